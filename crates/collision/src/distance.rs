//! Signed distance of a point from a convex shape, with the outward normal, in closed form where there is one.

use glamx::glam::{DVec2, DVec3};

use crate::convex::{Convex, Placed, radial};
use crate::gjk::{self, Outcome};
use crate::hull::Hull;

/// Signed distance (m, negative inside) of the point `p` from the shape and the unit normal from the shape to it.
/// At a centre of symmetry, where any of several normals is right, one of them is chosen by a fixed rule.
pub(crate) fn signed_distance(placed: &Placed, p: DVec3) -> (f64, DVec3) {
    let local = placed.local(p - placed.position);
    let (distance, normal) = match placed.shape {
        Convex::Sphere { radius } => from_core(local, DVec3::Z, *radius),
        Convex::Capsule { radius, half_length } => {
            let nearest = DVec3::Z * local.z.clamp(-half_length, *half_length);
            from_core(local - nearest, DVec3::X, *radius)
        }
        Convex::Box { half } => cuboid(*half, local),
        Convex::Cylinder { radius, half_length } => {
            let corners = [(0.0, -half_length), (*radius, -half_length), (*radius, *half_length), (0.0, *half_length)];
            revolved(&corners.map(|(x, y)| DVec2::new(x, y)), local)
        }
        Convex::Cone { radius, half_length } => {
            let corners = [(0.0, -half_length), (*radius, -half_length), (0.0, *half_length)];
            revolved(&corners.map(|(x, y)| DVec2::new(x, y)), local)
        }
        Convex::Ellipsoid { axes } => ellipsoid(*axes, local),
        Convex::Hull(hull) => polyhedron(placed, hull, local, p),
        Convex::Triangle(t) => {
            let [a, b, c] = t.vertices.map(|v| v - local);
            let weights = gjk::triangle_weights(a, b, c);
            let to_point = -(a * weights[0] + b * weights[1] + c * weights[2]);
            let side = if t.normal.dot(local - t.vertices[0]) < 0.0 { -t.normal } else { t.normal };
            from_core(to_point, side, 0.0)
        }
    };
    (distance, placed.rotation * normal)
}

/// Distance from a ball of `radius` about the origin; `fallback` is the normal at the centre.
fn from_core(p: DVec3, fallback: DVec3, radius: f64) -> (f64, DVec3) {
    let length = p.length();
    if length > 1e-12 * (radius + length) && length > f64::MIN_POSITIVE {
        (length - radius, p / length)
    } else {
        (length - radius, fallback)
    }
}

fn cuboid(half: DVec3, p: DVec3) -> (f64, DVec3) {
    let over = p.abs() - half;
    let outside = over.max(DVec3::ZERO);
    let length = outside.length();
    let signs = DVec3::ONE.copysign(p);
    if length > 1e-12 * half.max_element() {
        return (length, outside / length * signs);
    }
    let axis = if over.x >= over.y && over.x >= over.z {
        0
    } else if over.y >= over.z {
        1
    } else {
        2
    };
    (over[axis], DVec3::AXES[axis] * signs[axis])
}

/// A solid of revolution about Z whose half-section is the convex polygon `corners` (ρ, z), counter-clockwise from the
/// lower point on the axis to the upper one.
fn revolved(corners: &[DVec2], p: DVec3) -> (f64, DVec3) {
    let flat = DVec2::new(p.x.hypot(p.y), p.z);
    let size = corners[0].distance(corners[1]) + corners[1].distance(corners[2]);
    let mut inside = (f64::NEG_INFINITY, DVec2::Y);
    let mut nearest = (f64::INFINITY, DVec2::ZERO);
    for side in corners.windows(2) {
        let along = side[1] - side[0];
        let normal = -along.perp().normalize_or_zero();
        let height = normal.dot(flat - side[0]);
        if height > inside.0 {
            inside = (height, normal);
        }
        let place = ((flat - side[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let offset = flat - side[0].lerp(side[1], place);
        if offset.length() < nearest.0 {
            nearest = (offset.length(), offset);
        }
    }
    let (distance, n) = if inside.0 > 1e-12 * size { (nearest.0, nearest.1 / nearest.0) } else { inside };
    (distance, radial(p) * n.x + DVec3::Z * n.y)
}

/// The nearest point x of an ellipsoid satisfies `x_i = a_i² p_i / (u + a_i² − s²)` with the shortest semi-axis s; u by bisection on
/// the monotone branch (Eberly, Distance from a Point to an Ellipse, an Ellipsoid, 2013). Near the plane of symmetry across the
/// shortest axis u is small, which is why the bisection is for it and not for u − s².
fn ellipsoid(axes: DVec3, p: DVec3) -> (f64, DVec3) {
    let q = p.abs();
    let squares = axes * axes;
    let shortest = if axes.x <= axes.y && axes.x <= axes.z {
        0
    } else if axes.y <= axes.z {
        1
    } else {
        2
    };
    let longer = (axes - DVec3::splat(axes[shortest])) * (axes + DVec3::splat(axes[shortest]));
    let level = |u: f64| (axes * q / (longer + DVec3::splat(u))).length_squared() - 1.0;
    let mut low = axes[shortest] * q[shortest];
    let mut high = (axes * q).length();
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if level(middle) > 0.0 { low = middle } else { high = middle }
    }
    let u = 0.5 * (low + high);
    let mut x = squares * q / (longer + DVec3::splat(u));
    if !x.is_finite() || level(u) < -1e-9 {
        // On the plane of symmetry across the shortest axis the nearest point leaves that plane.
        let others = (0..3).filter(|&i| i != shortest);
        let mut rest = 1.0;
        for i in others {
            x[i] = if longer[i] > 0.0 { (squares[i] * q[i] / longer[i]).min(axes[i]) } else { 0.0 };
            rest -= (x[i] / axes[i]).powi(2);
        }
        x[shortest] = axes[shortest] * rest.max(0.0).sqrt();
    }
    let signs = DVec3::ONE.copysign(p);
    let normal = (x / squares * signs).try_normalize().unwrap_or(DVec3::Z);
    (normal.dot(p - x * signs), normal)
}

fn polyhedron(placed: &Placed, hull: &Hull, local: DVec3, p: DVec3) -> (f64, DVec3) {
    let point = Convex::Sphere { radius: 0.0 };
    let sphere = Placed { shape: &point, position: p, center: p, size: 0.0, ..*placed };
    match gjk::closest(placed, &sphere, f64::INFINITY) {
        Outcome::Apart(pair) if pair.distance > 1e-9 * placed.size => (pair.distance, placed.local(pair.normal)),
        _ => {
            let mut highest = (f64::NEG_INFINITY, DVec3::Z);
            for face in &hull.faces {
                let height = face.normal.dot(local) - face.offset;
                if height > highest.0 {
                    highest = (height, face.normal);
                }
            }
            highest
        }
    }
}
