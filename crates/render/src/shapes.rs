//! Where a ray meets one shape first, in the shape's frame. A ray from inside meets the surface where it leaves.

use signorini_multibody::glam::{DVec2, DVec3};

use crate::ray::{Hit, Ray};

/// The nearest of crossings in front of the ray's origin.
fn first(crossings: impl IntoIterator<Item = (f64, DVec3)>) -> Option<Hit> {
    let ahead = crossings.into_iter().filter(|(distance, _)| *distance >= 0.0);
    ahead.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(distance, normal)| Hit::smooth(distance, normal))
}

/// Both roots of `a t² + 2 b t + c` for a > 0, without cancellation.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || a <= 0.0 {
        return None;
    }
    let q = -b - discriminant.sqrt().copysign(b);
    Some(if q == 0.0 { [0.0, 0.0] } else { [q / a, c / q] })
}

/// The plane z = 0, from either side.
pub(crate) fn plane(ray: &Ray) -> Option<Hit> {
    let distance = -ray.origin.z / ray.direction.z;
    (distance >= 0.0 && distance.is_finite()).then(|| Hit::smooth(distance, DVec3::Z))
}

fn ball(ray: &Ray, center: DVec3, radius: f64) -> impl Iterator<Item = (f64, DVec3)> {
    let o = ray.origin - center;
    // From the point of the ray nearest to the centre, where nothing is lost far away.
    let middle = -o.dot(ray.direction);
    let foot = o + middle * ray.direction;
    let half = (radius * radius - foot.length_squared()).max(-1.0);
    let direction = ray.direction;
    let distances = if half >= 0.0 { Some([middle - half.sqrt(), middle + half.sqrt()]) } else { None };
    distances.into_iter().flatten().map(move |t| (t, (o + t * direction) / radius))
}

pub(crate) fn sphere(ray: &Ray, radius: f64) -> Option<Hit> {
    first(ball(ray, DVec3::ZERO, radius))
}

pub(crate) fn ellipsoid(ray: &Ray, axes: DVec3) -> Option<Hit> {
    let (o, d) = (ray.origin / axes, ray.direction / axes);
    let a = d.length_squared();
    let middle = -o.dot(d) / a;
    let half = (1.0 - (o + middle * d).length_squared()) / a;
    if half < 0.0 {
        return None;
    }
    first([-half.sqrt(), half.sqrt()].map(|h| {
        let t = middle + h;
        (t, (ray.at(t) / (axes * axes)).normalize_or(DVec3::Z))
    }))
}

pub(crate) fn cuboid(ray: &Ray, half: DVec3) -> Option<Hit> {
    let (mut enter, mut leave) = ((f64::NEG_INFINITY, DVec3::X), (f64::INFINITY, DVec3::X));
    for k in 0..3 {
        let (o, d) = (ray.origin[k], ray.direction[k]);
        if d == 0.0 {
            if o.abs() > half[k] {
                return None;
            }
            continue;
        }
        let ahead = DVec3::AXES[k] * d.signum();
        let (near, far) = ((-half[k].copysign(d) - o) / d, (half[k].copysign(d) - o) / d);
        if near > enter.0 {
            enter = (near, -ahead);
        }
        if far < leave.0 {
            leave = (far, ahead);
        }
    }
    if enter.0 > leave.0 { None } else { first([enter, leave]) }
}

/// The side of a cylinder about z between −h and h.
fn tube(ray: &Ray, radius: f64, h: f64) -> impl Iterator<Item = (f64, DVec3)> {
    let (o, d) = (DVec2::new(ray.origin.x, ray.origin.y), DVec2::new(ray.direction.x, ray.direction.y));
    let a = d.length_squared();
    let middle = -o.dot(d) / a;
    let half = (radius * radius - (o + middle * d).length_squared()) / a;
    let ray = *ray;
    let distances = if half >= 0.0 && middle.is_finite() { Some([-half.sqrt(), half.sqrt()]) } else { None };
    distances.into_iter().flatten().filter_map(move |part| {
        let p = ray.at(middle + part);
        (p.z.abs() <= h).then(|| (middle + part, DVec3::new(p.x, p.y, 0.0) / radius))
    })
}

/// The disc of a radius at height z.
fn disc(ray: &Ray, radius: f64, z: f64) -> Option<(f64, DVec3)> {
    let t = (z - ray.origin.z) / ray.direction.z;
    let p = ray.at(t);
    (p.x.hypot(p.y) <= radius).then_some((t, DVec3::Z * z.signum()))
}

pub(crate) fn cylinder(ray: &Ray, radius: f64, h: f64) -> Option<Hit> {
    first(tube(ray, radius, h).chain(disc(ray, radius, h)).chain(disc(ray, radius, -h)))
}

pub(crate) fn capsule(ray: &Ray, radius: f64, h: f64) -> Option<Hit> {
    let ends = [h, -h]
        .into_iter()
        .flat_map(|z| ball(ray, DVec3::Z * z, radius).filter(move |(_, normal)| normal.z * z >= 0.0));
    first(tube(ray, radius, h).chain(ends))
}

/// Apex at +h, base at −h.
pub(crate) fn cone(ray: &Ray, radius: f64, h: f64) -> Option<Hit> {
    // x² + y² = s² (h − z)² with s the slope of the side.
    let s = radius / (2.0 * h);
    let (o, d) = (ray.origin, ray.direction);
    let down = h - o.z;
    let a = d.x * d.x + d.y * d.y - s * s * d.z * d.z;
    let b = o.x * d.x + o.y * d.y + s * s * down * d.z;
    let c = o.x * o.x + o.y * o.y - s * s * down * down;
    let sides = if a.abs() < 1e-14 { Some([-0.5 * c / b; 2]) } else { roots(a.abs(), b * a.signum(), c * a.signum()) };
    let on_side = sides.into_iter().flatten().filter_map(|t| {
        let p = ray.at(t);
        let normal = DVec3::new(p.x, p.y, s * s * (h - p.z)).normalize_or(DVec3::Z);
        (p.z.abs() <= h).then_some((t, normal))
    });
    first(on_side.chain(disc(ray, radius, -h)))
}
