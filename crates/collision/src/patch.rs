//! The flat part of a shape that faces a direction: a face, an edge, a line of support or a point.

use glamx::glam::DVec3;

use crate::convex::{Convex, Placed, Triangle, radial};
use crate::hull::Hull;

/// Corners in convex order with ids that name the same place of the shape from step to step: 1 point, 2 ends of a line,
/// or a polygon.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    pub points: Vec<DVec3>,
    pub ids: Vec<u32>,
    /// Whether discs have [`FINE_RIM`] points instead of [`RIM`].
    pub is_fine: bool,
}

/// Points that stand for the rim of a disc.
const RIM: usize = 8;
/// The same where outlines are whole: the polygon misses 5e-4 of the radius.
const FINE_RIM: usize = 96;
/// A disc tilted by less than this sine counts as flat: its lowest point is then nowhere in particular.
const FLAT_DISC: f64 = 1e-6;
/// A face steeper than this cosine to the direction does not face it; an edge or a vertex is taken instead.
const STEEP: f64 = 0.1;

impl Patch {
    pub fn clear(&mut self) {
        self.points.clear();
        self.ids.clear();
    }

    fn push(&mut self, point: DVec3, id: u32) {
        self.points.push(point);
        self.ids.push(id);
    }

    /// Points of the rim of a disc.
    fn rim(&self) -> usize {
        if self.is_fine { FINE_RIM } else { RIM }
    }

    /// Fills the patch of `placed` that faces the unit vector `n` (both in the common frame).
    pub fn fill(&mut self, placed: &Placed, n: DVec3) {
        self.clear();
        let d = placed.local(n);
        match placed.shape {
            Convex::Sphere { radius } => self.push(d * *radius, 0),
            Convex::Capsule { radius, half_length } => {
                self.push(DVec3::Z * *half_length + d * *radius, 0);
                self.push(DVec3::Z * -half_length + d * *radius, 1);
            }
            Convex::Box { half } => return self.box_face(placed, *half, d),
            Convex::Cylinder { radius, half_length } => self.cylinder(*radius, *half_length, d),
            Convex::Cone { radius, half_length } => self.cone(*radius, *half_length, d),
            Convex::Ellipsoid { .. } => self.push(placed.shape.core_support(d), 0),
            Convex::Hull(hull) => self.hull(hull, d),
            Convex::Triangle(triangle) => self.triangle(triangle, d),
        }
        for point in &mut self.points {
            *point = placed.point(*point);
        }
    }

    /// Fills the corners of a polyhedron that reach farthest along the unit vector `n`, those within `tolerance` (m) of it, in convex order; none of a curved shape.
    /// Where a corner or an edge touches, the face that looks along `n` most may be another one.
    pub fn fill_farthest(&mut self, placed: &Placed, n: DVec3, tolerance: f64) {
        self.clear();
        let d = placed.local(n);
        match placed.shape {
            Convex::Box { half } => {
                for id in 0..8_u32 {
                    self.push(box_corner(*half, [id & 1 != 0, id & 2 != 0, id & 4 != 0]), id);
                }
            }
            Convex::Hull(hull) => (0..).zip(&hull.vertices).for_each(|(id, vertex)| self.push(*vertex, id)),
            Convex::Triangle(t) => t.vertices.iter().zip(t.ids).for_each(|(vertex, id)| self.push(*vertex, id)),
            _ => return,
        }
        self.keep_farthest(d, tolerance);
        self.order_about(d);
        for point in &mut self.points {
            *point = placed.point(*point);
        }
    }

    /// Leaves out the points that do not reach as far along `d` as the farthest, less a tolerance.
    fn keep_farthest(&mut self, d: DVec3, tolerance: f64) {
        let farthest = self.points.iter().map(|p| d.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
        let mut kept = 0;
        for k in 0..self.points.len() {
            if d.dot(self.points[k]) >= farthest - tolerance {
                (self.points[kept], self.ids[kept]) = (self.points[k], self.ids[k]);
                kept += 1;
            }
        }
        self.points.truncate(kept);
        self.ids.truncate(kept);
    }

    /// Brings the corners of a polygon across `d` into convex order.
    fn order_about(&mut self, d: DVec3) {
        let middle = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
        let (u, v) = d.any_orthonormal_pair();
        let angle = |p: DVec3| (p - middle).dot(v).atan2((p - middle).dot(u));
        for end in 1..self.points.len() {
            for k in (1..=end).rev() {
                if angle(self.points[k - 1]) <= angle(self.points[k]) {
                    break;
                }
                self.points.swap(k - 1, k);
                self.ids.swap(k - 1, k);
            }
        }
    }

    /// The face of a box, in the common frame.
    fn box_face(&mut self, placed: &Placed, half: DVec3, d: DVec3) {
        let a = d.abs();
        let axis = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let up = d[axis] >= 0.0;
        let arm = |i: usize| placed.rotation.col(i) * half[i];
        let center = if up { placed.position + arm(axis) } else { placed.position - arm(axis) };
        let (along_u, along_v) = (arm(u), arm(v));
        let id = |su: bool, sv: bool| u32::from(up) << axis | u32::from(su) << u | u32::from(sv) << v;
        self.push(center + along_u + along_v, id(true, true));
        self.push(center - along_u + along_v, id(false, true));
        self.push(center - along_u - along_v, id(false, false));
        self.push(center + along_u - along_v, id(true, false));
    }

    fn cylinder(&mut self, radius: f64, half_length: f64, d: DVec3) {
        let tilt = d.x.hypot(d.y);
        if d.z.abs() >= tilt {
            let first_id = if d.z > 0.0 { 0 } else { self.rim() as u32 };
            self.disc(radius, half_length.copysign(d.z), d, first_id);
        } else {
            let side = radial(d) * radius;
            let first_id = 2 * self.rim() as u32;
            self.push(side + DVec3::Z * half_length, first_id);
            self.push(side - DVec3::Z * half_length, first_id + 1);
        }
    }

    fn cone(&mut self, radius: f64, half_length: f64, d: DVec3) {
        let slant = radius.hypot(2.0 * half_length);
        let (out, along) = (2.0 * half_length / slant, radius / slant);
        let side = out * d.x.hypot(d.y) + along * d.z;
        if -d.z >= side {
            self.disc(radius, -half_length, d, 0);
        } else {
            let first_id = 2 * self.rim() as u32;
            self.push(DVec3::Z * half_length, first_id);
            self.push(radial(d) * radius - DVec3::Z * half_length, first_id + 1);
        }
    }

    /// Evenly spread rim points at fixed places of the shape; when the disc is tilted the nearest gives way to the point
    /// of the rim that is really farthest along `d`.
    fn disc(&mut self, radius: f64, z: f64, d: DVec3, first_id: u32) {
        let rim = self.rim();
        for k in 0..rim {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / rim as f64).sin_cos();
            self.push(DVec3::new(radius * cos, radius * sin, z), first_id + k as u32);
        }
        if d.x.hypot(d.y) > FLAT_DISC {
            let turn = d.y.atan2(d.x) / std::f64::consts::TAU * rim as f64;
            let nearest = (turn.round() as i64).rem_euclid(rim as i64) as usize;
            self.points[nearest] = radial(d) * radius + DVec3::Z * z;
        }
    }

    fn hull(&mut self, hull: &Hull, d: DVec3) {
        let face = hull.face_towards(d);
        if d.dot(face.normal) < STEEP {
            let i = hull.support_index(d);
            return self.push(hull.vertices[i], i as u32);
        }
        for &i in &face.loop_ {
            self.push(hull.vertices[i as usize], i);
        }
    }

    fn triangle(&mut self, t: &Triangle, d: DVec3) {
        let lowest = (0..3).min_by(|&i, &j| d.dot(t.vertices[i]).total_cmp(&d.dot(t.vertices[j]))).unwrap_or(0);
        let steep = d.dot(t.normal).abs() < STEEP;
        for i in (0..3).filter(|&i| !steep || i != lowest) {
            self.push(t.vertices[i], t.ids[i]);
        }
    }
}

/// The corner of a box on the positive side of the axes that are `true`.
pub(crate) fn box_corner(half: DVec3, signs: [bool; 3]) -> DVec3 {
    let s = |i: usize| if signs[i] { half[i] } else { -half[i] };
    DVec3::new(s(0), s(1), s(2))
}

/// Number of that corner: bit i says on which side of axis i it lies.
pub(crate) fn box_corner_id(signs: [bool; 3]) -> u32 {
    u32::from(signs[0]) | u32::from(signs[1]) << 1 | u32::from(signs[2]) << 2
}
