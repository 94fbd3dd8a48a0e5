//! The direction along which two convex shapes are farthest apart (or overlap least).
//!
//! For a unit normal n from A to B the separation is `s(n) = min n·b − max n·a`; every `s(n)` is a lower bound of the
//! signed distance. The gap of a contact is always `s(n)` of the normal that is returned, so a normal that is not the best
//! one cannot hide an overlap.

use glamx::glam::DVec3;

use crate::convex::{Convex, Placed, scale, separation_along};
use crate::distance::signed_distance;
use crate::epa::Epa;
use crate::gjk::{self, Outcome};

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

/// Buffers of the general search.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    epa: Epa,
    axes: Vec<DVec3>,
}

impl Search {
    /// The best of the characteristic axes of two convex shapes, or `None` if they are more than `margin` apart.
    pub fn axis(&mut self, a: &Placed, b: &Placed, margin: f64) -> Option<Separation> {
        self.collect_axes(a, b);
        let mut best = (f64::NEG_INFINITY, DVec3::Z);
        for &axis in &self.axes {
            for n in [axis, -axis] {
                let gap = separation_along(a, b, n);
                if gap > best.0 + 1e-12 * scale(a, b) {
                    best = (gap, n);
                }
            }
        }
        (best.0 <= margin).then_some(Separation { normal: best.1, gap: best.0, midpoint: None })
    }

    /// Any two convex shapes: characteristic axes first, then GJK between the cores (Gilbert, Johnson, Keerthi 1988) when
    /// they are apart, else an expanding polytope (van den Bergen 2001). `None` if farther apart than `margin`.
    pub fn general(&mut self, a: &Placed, b: &Placed, margin: f64) -> Option<Separation> {
        let size = scale(a, b);
        let radii = a.shape.radius() + b.shape.radius();
        let axis = self.axis(a, b, margin)?;
        match gjk::closest(a, b, margin + radii) {
            Outcome::Beyond => None,
            Outcome::Apart(pair) if pair.distance > TOUCHING * size => {
                let between = 0.5 * (pair.point_a + pair.point_b);
                let midpoint = between + pair.normal * (0.5 * (a.shape.radius() - b.shape.radius()));
                let gap = separation_along(a, b, pair.normal);
                let found = Separation { normal: pair.normal, gap, midpoint: Some(midpoint) };
                let stalled = pair.open > STALLED * size;
                let polished = if stalled { self.epa.search(a, b, &self.axes, 2.0 * pair.distance) } else { None };
                let found = polished.filter(|p| p.gap > gap).unwrap_or(found);
                Some(prefer_axis(axis, found, 1e-12 * size))
            }
            _ => {
                let found = self.epa.search(a, b, &self.axes, 0.0);
                Some(found.map_or(axis, |f| prefer_axis(axis, f, 1e-10 * size)))
            }
        }
        .filter(|s| s.gap <= margin)
    }

    /// Directions in which the two shapes are likely to be farthest apart: face normals, axes, common perpendiculars.
    fn collect_axes(&mut self, a: &Placed, b: &Placed) {
        self.axes.clear();
        for placed in [a, b] {
            let r = placed.rotation;
            match placed.shape {
                Convex::Box { .. } => self.axes.extend([r.x_axis, r.y_axis, r.z_axis]),
                Convex::Cylinder { .. } | Convex::Cone { .. } => self.axes.push(r.z_axis),
                Convex::Triangle(t) => self.axes.push(r * t.normal),
                Convex::Hull(hull) => {
                    let to_b = placed.local(b.center - a.center);
                    self.axes.push(r * hull.face_towards(to_b).normal);
                    self.axes.push(r * hull.face_towards(-to_b).normal);
                }
                _ => {}
            }
        }
        let to_b = b.center - a.center;
        for placed in [a, b] {
            let axis = placed.rotation.z_axis;
            self.axes.extend(perpendicular(to_b, axis));
            if let Convex::Cone { radius, half_length } = placed.shape {
                self.axes.extend(cone_normals(placed, *radius, *half_length, to_b, a, b));
            }
        }
        let cross = a.rotation.z_axis.cross(b.rotation.z_axis);
        if cross.length_squared() > 1e-12 {
            self.axes.extend(cross.try_normalize());
        }
        self.axes.extend(to_b.try_normalize());
    }
}

/// A search's result, but with a closed-form axis that separates as well: the axis is exact where the search determines
/// its direction only to rounding.
fn prefer_axis(axis: Separation, found: Separation, tolerance: f64) -> Separation {
    if axis.gap >= found.gap - tolerance { Separation { midpoint: found.midpoint, ..axis } } else { found }
}

/// Uncertainty of the distance, as a share of the size, at which GJK is taken to have stalled.
const STALLED: f64 = 1e-11;
/// Core distance, as a share of the size, below which closest points no longer give a direction.
const TOUCHING: f64 = 1e-7;

/// Unit vector of the part of `d` across the unit vector `axis`, if there is one.
fn perpendicular(d: DVec3, axis: DVec3) -> Option<DVec3> {
    let across = d - axis * d.dot(axis);
    if across.length() > 1e-6 * d.length() { across.try_normalize() } else { None }
}

/// Outward normals of a cone's side: towards the other shape, and where a face normal of the other leans on it.
fn cone_normals(
    cone: &Placed,
    radius: f64,
    half_length: f64,
    to_b: DVec3,
    a: &Placed,
    b: &Placed,
) -> impl Iterator<Item = DVec3> {
    let slant = radius.hypot(2.0 * half_length);
    let axis = cone.rotation.z_axis;
    let towards = [to_b, -to_b, a.rotation.z_axis, b.rotation.z_axis, -a.rotation.z_axis, -b.rotation.z_axis];
    // On its axis all directions from it are alike.
    let aside = perpendicular(to_b, axis).is_none().then(|| axis.any_orthonormal_vector());
    towards.into_iter().chain(aside).filter_map(move |d| {
        let out = perpendicular(d, axis)?;
        Some(out * (2.0 * half_length / slant) + axis * (radius / slant))
    })
}
