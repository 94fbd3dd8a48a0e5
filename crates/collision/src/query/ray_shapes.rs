//! Where a ray crosses the surface of one shape, in the shape's frame.

use glamx::glam::{DVec2, DVec3};

use crate::convex::Convex;
use crate::hull::Hull;
use crate::mesh::TriangleSet;

/// A crossing of a ray and a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// From the ray's origin, m, ≥ 0.
    pub distance: f64,
    /// Unit outward normal.
    pub normal: DVec3,
}

/// Surfaces that meet reach beyond where they do by this part of the lengths at hand, so that no ray slips between them by rounding, of which it is
/// some thousand times.
const SEAM: f64 = 1e-12;

/// A place on two triangles is outside of each by less than this part of their sides, whatever the ray.
const BESIDE: f64 = 1e-6;

/// The half-space `z ≤ 0`, from its front.
pub(super) fn plane(o: DVec3, d: DVec3) -> Option<Crossing> {
    let distance = -o.z / d.z;
    (d.z < 0.0 && distance >= 0.0).then_some(Crossing { distance, normal: DVec3::Z })
}

/// A convex shape: the first crossing in front of the origin.
pub(super) fn convex(shape: &Convex, o: DVec3, d: DVec3) -> Option<Crossing> {
    match shape {
        Convex::Sphere { radius } => first(ball(o, d, DVec3::ZERO, *radius)),
        Convex::Box { half } => {
            slabs((0..3).flat_map(|k| [(DVec3::AXES[k], half[k]), (-DVec3::AXES[k], half[k])]), o, d)
        }
        Convex::Hull(hull) => polyhedron(hull, o, d),
        Convex::Capsule { radius, half_length } => capsule(*radius, *half_length, o, d),
        Convex::Cylinder { radius, half_length } => cylinder(*radius, *half_length, o, d),
        Convex::Cone { radius, half_length } => cone(*radius, *half_length, o, d),
        Convex::Ellipsoid { axes } => ellipsoid(*axes, o, d),
        Convex::Triangle(t) => triangle(t.vertices, o, d),
    }
}

/// The nearest triangle before `limit` (m); its normal looks at the ray's origin, that of a surface with a solid side away from it.
pub(super) fn triangles(set: &TriangleSet, o: DVec3, d: DVec3, limit: f64) -> Option<Crossing> {
    let mut best: Option<Crossing> = None;
    set.bvh.along(o, d, limit, |index| {
        let face = set.triangle(index);
        let known = best.map_or(limit, |best| best.distance);
        if let Some(found) = triangle(face.vertices, o, d)
            && found.distance < known
        {
            let away = set.solid_below && found.normal.dot(face.normal) < 0.0;
            best = Some(if away { Crossing { normal: -found.normal, ..found } } else { found });
        }
        best.map_or(limit, |best| best.distance)
    });
    best
}

/// The first crossing in front of the origin.
fn first(crossings: impl IntoIterator<Item = Crossing>) -> Option<Crossing> {
    let ahead = crossings.into_iter().filter(|crossing| crossing.distance >= 0.0);
    ahead.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Both roots of `a t² + 2 b t + c = 0`, without cancellation; none where they are not real, one where `a` is zero.
fn roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - a * c;
    // At the apex of a cone both are one, to rounding.
    if discriminant < -4.0 * f64::EPSILON * b * b || (a == 0.0 && b == 0.0) {
        return [None; 2];
    }
    let q = -(b + discriminant.max(0.0).sqrt().copysign(b));
    let large = (a != 0.0).then(|| q / a);
    let small = if q == 0.0 { large } else { Some(c / q) };
    [large, small]
}

fn ball(o: DVec3, d: DVec3, center: DVec3, radius: f64) -> impl Iterator<Item = Crossing> {
    let from = o - center;
    let middle = -d.dot(from);
    // Across the ray, so that a far origin costs no digits.
    let across = from + d * middle;
    let half2 = radius * radius - across.length_squared();
    let half = (half2 >= 0.0).then(|| half2.sqrt());
    half.into_iter()
        .flat_map(move |half| [middle - half, middle + half])
        .map(move |distance| Crossing { distance, normal: (from + d * distance).normalize_or_zero() })
}

/// Crossings with the intersection of half-spaces `normal · p ≤ offset`.
fn slabs(faces: impl Iterator<Item = (DVec3, f64)>, o: DVec3, d: DVec3) -> Option<Crossing> {
    let mut enter = Crossing { distance: f64::NEG_INFINITY, normal: DVec3::ZERO };
    let mut leave = Crossing { distance: f64::INFINITY, normal: DVec3::ZERO };
    for (normal, offset) in faces {
        let (speed, height) = (normal.dot(d), normal.dot(o) - offset);
        if speed == 0.0 {
            if height > 0.0 {
                return None;
            }
            continue;
        }
        let distance = -height / speed;
        if speed < 0.0 && distance > enter.distance {
            enter = Crossing { distance, normal };
        } else if speed > 0.0 && distance < leave.distance {
            leave = Crossing { distance, normal };
        }
    }
    if enter.distance > leave.distance {
        None
    } else {
        first([enter, leave].into_iter().filter(|c| c.distance.is_finite()))
    }
}

fn polyhedron(hull: &Hull, o: DVec3, d: DVec3) -> Option<Crossing> {
    slabs(hull.faces.iter().map(|face| (face.normal, face.offset)), o, d)
}

/// How far surfaces of a size reach beyond where they meet, for a ray from `o`, m.
fn seam(size: f64, o: DVec3) -> f64 {
    SEAM * (size + o.length())
}

/// Crossings with the mantle of the cylinder about Z whose height lies in `±half_length`.
fn mantle(radius: f64, half_length: f64, o: DVec3, d: DVec3) -> impl Iterator<Item = Crossing> {
    let half_length = half_length + seam(half_length, o);
    let (from, along) = (o.truncate(), d.truncate());
    let times = roots(along.length_squared(), from.dot(along), from.length_squared() - radius * radius);
    times.into_iter().flatten().filter_map(move |distance| {
        let p = o + d * distance;
        let normal = DVec2::new(p.x, p.y).normalize_or_zero().extend(0.0);
        (p.z.abs() <= half_length).then_some(Crossing { distance, normal })
    })
}

/// The crossing with a disc about Z at a height.
fn disc(radius: f64, z: f64, normal: DVec3, o: DVec3, d: DVec3) -> Option<Crossing> {
    let distance = (z - o.z) / d.z;
    let p = o + d * distance;
    (d.z != 0.0 && p.x.hypot(p.y) <= radius + seam(radius, o)).then_some(Crossing { distance, normal })
}

fn capsule(radius: f64, half_length: f64, o: DVec3, d: DVec3) -> Option<Crossing> {
    let seam = seam(radius + half_length, o);
    let caps = [1.0, -1.0].into_iter().flat_map(move |side| {
        let is_cap = move |c: &Crossing| side * (o.z + d.z * c.distance) >= half_length - seam;
        ball(o, d, DVec3::Z * (side * half_length), radius).filter(is_cap)
    });
    first(mantle(radius, half_length, o, d).chain(caps))
}

fn cylinder(radius: f64, half_length: f64, o: DVec3, d: DVec3) -> Option<Crossing> {
    let top = disc(radius, half_length, DVec3::Z, o, d);
    let bottom = disc(radius, -half_length, DVec3::NEG_Z, o, d);
    first(mantle(radius, half_length, o, d).chain(top).chain(bottom))
}

/// Apex at `+half_length`: `x² + y² = k² (half_length − z)²`.
fn cone(radius: f64, half_length: f64, o: DVec3, d: DVec3) -> Option<Crossing> {
    let k2 = (radius / (2.0 * half_length)).powi(2);
    let below = half_length - o.z;
    let a = d.x * d.x + d.y * d.y - k2 * d.z * d.z;
    let b = o.x * d.x + o.y * d.y + k2 * below * d.z;
    let c = o.x * o.x + o.y * o.y - k2 * below * below;
    let side = roots(a, b, c).into_iter().flatten().filter_map(|distance| {
        let p = o + d * distance;
        let normal = DVec3::new(p.x, p.y, k2 * (half_length - p.z)).try_normalize().unwrap_or(DVec3::Z);
        (p.z.abs() <= half_length + seam(half_length, o)).then_some(Crossing { distance, normal })
    });
    first(side.chain(disc(radius, -half_length, DVec3::NEG_Z, o, d)))
}

fn ellipsoid(axes: DVec3, o: DVec3, d: DVec3) -> Option<Crossing> {
    let (from, along) = (o / axes, d / axes);
    let times = roots(along.length_squared(), from.dot(along), from.length_squared() - 1.0);
    first(times.into_iter().flatten().map(|distance| {
        let p = o + d * distance;
        Crossing { distance, normal: (p / (axes * axes)).normalize_or_zero() }
    }))
}

/// One triangle, from both sides (Möller, Trumbore 1997).
fn triangle([a, b, c]: [DVec3; 3], o: DVec3, d: DVec3) -> Option<Crossing> {
    let (ab, ac, from) = (b - a, c - a, o - a);
    let across = d.cross(ac);
    let determinant = ab.dot(across);
    let u = from.dot(across) / determinant;
    let turned = from.cross(ab);
    let v = d.dot(turned) / determinant;
    let distance = ac.dot(turned) / determinant;
    // What is not there by far is most of what is asked for.
    let is_near = |slack: f64| u >= -slack && v >= -slack && u + v <= 1.0 + slack;
    let slack = || (SEAM * (1.0 + from.length() * (ab.length() + ac.length()) / determinant.abs())).min(BESIDE);
    let inside = is_near(BESIDE) && distance >= 0.0 && is_near(slack());
    let normal = ab.cross(ac).normalize_or_zero();
    // A ray in the triangle's plane has a determinant of zero, and no number is inside then.
    inside.then_some(Crossing { distance, normal: if normal.dot(d) > 0.0 { -normal } else { normal } })
}
