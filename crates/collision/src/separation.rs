//! The direction along which two convex shapes are farthest apart (or overlap least), in closed form where there is one.
//!
//! For a unit normal n from A to B the separation is `s(n) = min n·b − max n·a`; every `s(n)` is a lower bound of the
//! signed distance. The gap of a contact is always `s(n)` of the normal that is returned, so a normal that is not the best
//! one cannot hide an overlap.

use glamx::glam::DVec3;

use crate::convex::{Placed, scale, separation_along};
use crate::distance::signed_distance;

/// A separating (or least overlapping) direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Separation {
    /// Unit, from A to B.
    pub normal: DVec3,
    /// Gap along the normal, m.
    pub gap: f64,
    /// A point midway between the surfaces where the gap is attained, if it is known.
    pub midpoint: Option<DVec3>,
}

impl Separation {
    pub fn swapped(self) -> Self {
        Self { normal: -self.normal, ..self }
    }
}

/// An axis made of two edges must beat the best face normal by this share of the gap and this share of the size.
const EDGE_BIAS: (f64, f64) = (1e-3, 1e-8);
/// The second box's faces must beat the first one's by this share of the size.
const FACE_BIAS: f64 = 1e-10;

/// The best of the 15 axes of two boxes, face normals preferred (Gottschalk, Lin, Manocha 1996), or `None` if they are
/// farther apart than `margin`.
pub(crate) fn boxes(a: &Placed, b: &Placed, half_a: DVec3, half_b: DVec3, margin: f64) -> Option<Separation> {
    let to_b = b.position - a.position;
    let (ra, rb) = (a.rotation, b.rotation);
    let relative = ra.transpose() * rb;
    let size = scale(a, b);
    let center = ra.transpose() * to_b;
    let abs = [relative.x_axis.abs(), relative.y_axis.abs(), relative.z_axis.abs()];
    let reach_b = abs[0] * half_b.x + abs[1] * half_b.y + abs[2] * half_b.z;
    let (mut face_a, mut face_b) = ((f64::NEG_INFINITY, DVec3::Z), (f64::NEG_INFINITY, DVec3::Z));
    for i in 0..3 {
        let gap = center[i].abs() - half_a[i] - reach_b[i];
        if gap > face_a.0 + FACE_BIAS * size {
            face_a = (gap, ra.col(i) * sign(center[i]));
        }
    }
    for j in 0..3 {
        let along = rb.col(j).dot(to_b);
        let gap = along.abs() - half_b[j] - half_a.dot(abs[j]);
        if gap > face_b.0 + FACE_BIAS * size {
            face_b = (gap, rb.col(j) * sign(along));
        }
    }
    let best = if face_b.0 > face_a.0 + FACE_BIAS * size { face_b } else { face_a };
    if best.0 > margin {
        return None;
    }
    let mut edge = (best.0 + EDGE_BIAS.0 * best.0.abs() + EDGE_BIAS.1 * size, None);
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            // All in the axes of A, where axis i of A is a unit vector: |a_i × b_j|² = 1 − (a_i·b_j)², without cancellation.
            let b_j = relative.col(j);
            let length2 = b_j[i1] * b_j[i1] + b_j[i2] * b_j[i2];
            if length2 < 1e-8 {
                continue;
            }
            let along = center[i2] * b_j[i1] - center[i1] * b_j[i2];
            let reach_a = half_a[i1] * abs[j][i2] + half_a[i2] * abs[j][i1];
            let reach_b = half_b[j1] * abs[j2][i] + half_b[j2] * abs[j1][i];
            // The gap is this over the length, which is at most 1.
            let scaled = along.abs() - reach_a - reach_b;
            if scaled <= edge.0.min(0.0) || scaled <= edge.0 * length2.sqrt() {
                continue;
            }
            let axis = ra.col(i).cross(rb.col(j)).normalize();
            let (in_a, in_b) = (ra.transpose() * axis, rb.transpose() * axis);
            let along = axis.dot(to_b);
            let gap = along.abs() - half_a.dot(in_a.abs()) - half_b.dot(in_b.abs());
            if gap > edge.0 {
                edge = (gap, Some(axis * sign(along)));
            }
        }
    }
    let (gap, normal) = match edge.1 {
        Some(axis) => (edge.0, axis),
        None => between_faces(a, b, face_a, face_b).unwrap_or(best),
    };
    (gap <= margin).then_some(Separation { normal, gap, midpoint: None })
}

/// Where a corner (an edge) of one box touches a corner of the other, every direction between the two face normals
/// separates them equally well: the middle one, so that neither box is preferred. `None` if this is not such a case.
fn between_faces(a: &Placed, b: &Placed, face_a: (f64, DVec3), face_b: (f64, DVec3)) -> Option<(f64, DVec3)> {
    let size = scale(a, b);
    let touching = face_a.0.abs().max(face_b.0.abs()) <= CORNER * size;
    let distinct = face_a.1.dot(face_b.1) < 1.0 - 1e-6;
    if !touching || !distinct {
        return None;
    }
    let normal = (face_a.1 + face_b.1).try_normalize()?;
    Some((separation_along(a, b, normal), normal))
}

/// Two boxes touch corner to corner if both boxes' best faces touch to within this share of the size.
const CORNER: f64 = 1e-6;

fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// A sphere B against any shape A: exact distance of its centre, or `None` beyond `margin`.
pub(crate) fn sphere(a: &Placed, b: &Placed, radius: f64, margin: f64) -> Option<Separation> {
    let center = b.position;
    let (distance, normal) = signed_distance(a, center);
    let gap = distance - radius;
    if gap.is_nan() || gap > margin {
        return None;
    }
    let midpoint = center - normal * (radius + 0.5 * gap);
    Some(Separation { normal, gap, midpoint: Some(midpoint) })
}
