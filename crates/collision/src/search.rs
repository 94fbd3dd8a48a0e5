//! The direction along which any two convex shapes are farthest apart (or overlap least).

use glamx::glam::DVec3;

use crate::convex::{Convex, Placed, scale, separation_along};
use crate::epa::{Epa, Farthest, farthest};
use crate::gjk::{self, Outcome};
use crate::reach::Within;
use crate::separation::Separation;

/// Buffers of the general search.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    epa: Epa,
    axes: Vec<DVec3>,
    /// Supports of the difference of the shapes along the axes and against them.
    known: Vec<Farthest>,
    /// What [`axis`](Self::axis) knows of the closest points of the cores.
    closest: Option<Outcome>,
    /// Where the direction that was found is an axis without a point that is known: another one along which the shapes are as far apart, with a point.
    tie: Option<Separation>,
    /// A direction along which the shapes of the last search are farther apart than asked for, where they are and it is known.
    pub apart: Option<DVec3>,
    /// How the shapes of the last search could move.
    pub within: Within,
    /// A normal along which they were farther apart than they could approach along it, and what is left of the gap (m), where the search ended with that.
    pub excluded: Option<(DVec3, f64)>,
}

/// Share of the size by which polyhedra that touch are shrunk to see which of their faces and edges face each other.
const SHRINK: f64 = 1e-3;

impl Search {
    /// Whether shapes with this gap along a unit normal cannot come together; the search ends there.
    pub fn excludes(&mut self, normal: DVec3, gap: f64) -> bool {
        self.excluded = self.within.excluded(normal, gap).map(|left| (normal, left));
        if self.excluded.is_some() {
            self.apart = Some(normal);
        }
        self.excluded.is_some()
    }

    /// What was found, unless it is more than `margin` apart or excluded.
    pub fn keep_within(&mut self, found: Separation, margin: f64) -> Option<Separation> {
        if found.gap > margin {
            self.apart = Some(found.normal);
            return None;
        }
        (!self.excludes(found.normal, found.gap)).then_some(found)
    }

    /// The best of the characteristic axes of two convex shapes, or `None` if they are more than `margin` apart.
    pub fn axis(&mut self, a: &Placed, b: &Placed, margin: f64) -> Option<Separation> {
        (self.closest, self.apart) = (None, None);
        self.axes.clear();
        let hull = |placed: &Placed| matches!(placed.shape, Convex::Hull(_));
        if hull(a) || hull(b) {
            self.collect_facing(a, b, margin)?;
        } else {
            self.collect_axes(a, b);
        }
        let mut best = (f64::NEG_INFINITY, DVec3::Z);
        let size = scale(a, b);
        self.known.clear();
        for &axis in &self.axes {
            for n in [axis, -axis] {
                let vertex = farthest(a, b, -n);
                let gap = n.dot(vertex.w);
                if gap > best.0 + 1e-12 * size {
                    best = (gap, n);
                }
                self.known.push(Farthest { along: -n, vertex });
            }
        }
        self.keep_within(Separation { normal: best.1, gap: best.0, midpoint: None }, margin)
    }

    /// The direction of any two convex shapes whose best characteristic axis was just found: GJK between the cores (Gilbert,
    /// Johnson, Keerthi 1988) when they are apart, else an expanding polytope (van den Bergen 2001). `None` if farther apart than
    /// `margin`.
    pub fn general(&mut self, a: &Placed, b: &Placed, axis: Separation, margin: f64) -> Option<Separation> {
        self.tie = None;
        let size = scale(a, b);
        let radii = a.shape.radius() + b.shape.radius();
        match self.closest.take().unwrap_or_else(|| gjk::closest(a, b, margin + radii)) {
            Outcome::Beyond(between) => {
                self.apart = between.try_normalize();
                None
            }
            Outcome::Apart(pair) if pair.distance > TOUCHING * size => {
                let between = 0.5 * (pair.point_a + pair.point_b);
                let midpoint = between + pair.normal * (0.5 * (a.shape.radius() - b.shape.radius()));
                let gap = separation_along(a, b, pair.normal);
                if gap > margin {
                    self.apart = Some(pair.normal);
                    return None;
                }
                let found = Separation { normal: pair.normal, gap, midpoint: Some(midpoint) };
                let stalled = pair.open > STALLED * size;
                let polished = if stalled { self.epa.search(a, b, &self.known, 2.0 * pair.distance) } else { None };
                let found = polished.filter(|p| p.gap > gap).unwrap_or(found);
                Some(self.prefer_axis(axis, found, 1e-12 * size))
            }
            _ => {
                let found = self.epa.search(a, b, &self.known, 0.0);
                Some(found.map_or(axis, |f| self.prefer_axis(axis, f, 1e-10 * size)))
            }
        }
        .filter(|s| {
            if s.gap > margin {
                self.apart = Some(s.normal);
            }
            s.gap <= margin
        })
    }

    /// A search's result, but with a closed-form axis that separates as well: the axis is exact where the search determines
    /// its direction only to rounding. Where the search ended in another direction, its point is not one of the axis.
    fn prefer_axis(&mut self, axis: Separation, found: Separation, tolerance: f64) -> Separation {
        if axis.gap < found.gap - tolerance {
            return found;
        }
        if axis.normal.dot(found.normal) > SAME_NORMAL {
            return Separation { midpoint: found.midpoint, ..axis };
        }
        self.tie = Some(found).filter(|found| found.gap >= axis.gap - tolerance);
        axis
    }

    /// The separation that was found with a point of its own: where it has none, the direction that separates as well and has one, or else the middle of the
    /// closest points, or between what reaches farthest along the normal.
    pub fn with_point(&self, found: Separation, a: &Placed, b: &Placed) -> Separation {
        if found.midpoint.is_some() {
            return found;
        }
        let middle = match gjk::closest(a, b, f64::INFINITY) {
            Outcome::Apart(pair) => {
                0.5 * (pair.point_a + pair.point_b + found.normal * (a.shape.radius() - b.shape.radius()))
            }
            _ => 0.5 * (a.support(found.normal) + b.support(-found.normal)),
        };
        self.tie.unwrap_or(Separation { midpoint: Some(middle), ..found })
    }

    /// Of shapes with many faces those directions that can matter: the faces nearest to the direction of the closest points.
    /// `None` if the shapes are more than `margin` apart. Where polyhedra touch or overlap a little, that direction is found between
    /// slightly smaller ones: these have the same faces and edges in the same directions.
    fn collect_facing(&mut self, a: &Placed, b: &Placed, margin: f64) -> Option<()> {
        let size = scale(a, b);
        let found = gjk::closest(a, b, margin + a.shape.radius() + b.shape.radius());
        let toward = match found {
            Outcome::Beyond(between) => {
                self.apart = between.try_normalize();
                return None;
            }
            Outcome::Apart(pair) if pair.distance > TOUCHING * size => {
                if self.excludes(pair.normal, separation_along(a, b, pair.normal)) {
                    return None;
                }
                Some(pair.normal)
            }
            // Between shapes that are smaller by the share about their centres the difference is so, and moves by so much towards that of the centres.
            Outcome::Overlapping(within) if within > 2.0 * SHRINK * (b.center - a.center).length() => None,
            _ => match gjk::closest_of_shrunk(a, b, SHRINK) {
                Outcome::Apart(pair) if pair.distance > TOUCHING * size => Some(pair.normal),
                _ => None,
            },
        };
        self.closest = Some(found);
        let toward = toward.or((b.center - a.center).try_normalize()).unwrap_or(DVec3::Z);
        for (placed, n) in [(a, toward), (b, -toward)] {
            if let Convex::Hull(hull) = placed.shape {
                self.axes.push(placed.rotation * hull.face_towards(placed.local(n)).normal);
            }
        }
        let flat = |placed: &Placed| matches!(placed.shape, Convex::Hull(_) | Convex::Box { .. } | Convex::Triangle(_));
        if flat(a) && flat(b) {
            self.collect_faces(a);
            self.collect_faces(b);
        } else {
            self.collect_axes(a, b);
        }
        self.axes.push(toward);
        Some(())
    }

    fn collect_faces(&mut self, placed: &Placed) {
        let r = placed.rotation;
        match placed.shape {
            Convex::Box { .. } => self.axes.extend([r.x_axis, r.y_axis, r.z_axis]),
            Convex::Cylinder { .. } | Convex::Cone { .. } => self.axes.push(r.z_axis),
            Convex::Triangle(t) => self.axes.push(r * t.normal),
            _ => {}
        }
    }

    /// Directions in which the two shapes are likely to be farthest apart: face normals, axes, common perpendiculars.
    fn collect_axes(&mut self, a: &Placed, b: &Placed) {
        self.collect_faces(a);
        self.collect_faces(b);
        let to_b = b.center - a.center;
        for placed in [a, b] {
            let axis = placed.rotation.z_axis;
            // Where the other shape is on the axis all directions across it are alike.
            self.axes.push(perpendicular(to_b, axis).unwrap_or(placed.rotation.x_axis));
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

/// Cosine above which two normals are one, to what a search determines of them.
const SAME_NORMAL: f64 = 1.0 - 1e-8;
/// Uncertainty of the distance, as a share of the size, at which GJK is taken to have stalled.
const STALLED: f64 = 1e-11;
/// Core distance, as a share of the size, below which closest points no longer give a direction.
pub(crate) const TOUCHING: f64 = 1e-7;

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
