//! Triangle meshes and height fields against convex shapes and half-spaces.

use glamx::glam::DVec3;

use crate::bvh::Aabb;
use crate::convex::{Convex, Placed, bounds_of, scale, separation_along};
use crate::feature::Feature;
use crate::halfspace::HalfSpace;
use crate::manifold::Touch;
use crate::mesh::PlacedSet;
use crate::narrow::Narrow;
use crate::reduce::keep_gaps;
use crate::separation::Separation;
use crate::triangles::{Triangles, lowest_allowed};

/// Buffers of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    candidates: Vec<u32>,
    found: Vec<Touch>,
    rest: Vec<Touch>,
    triangles: Triangles,
}

/// Contacts belong to one flat part of the surface if their normals differ by less than this (1 − cosine) and their
/// planes by less than a millionth of the size.
const SAME_NORMAL: f64 = 1e-9;

impl Surface {
    /// Appends the contacts of the convex shape B (whose bounding box has half-lengths `half`) with the surface A within
    /// `margin`: every triangle near B is a convex shape of its own; then points with one normal and plane are reduced
    /// together.
    pub fn convex(
        &mut self,
        a: &PlacedSet,
        b: &Placed,
        half: DVec3,
        margin: f64,
        narrow: &mut Narrow,
        out: &mut Vec<Touch>,
    ) {
        let relative = a.rotation.transpose() * b.rotation;
        let center = a.rotation.transpose() * (b.center - a.position);
        let half = relative.abs() * half + DVec3::splat(margin);
        self.candidates.clear();
        let near = Aabb { low: center - half, high: center + half };
        a.set.bvh.overlapping(&near, |i| {
            let (low, high) = bounds_of(&a.set.triangle(i).vertices);
            if near.overlaps(&Aabb { low, high }) {
                self.candidates.push(i);
            }
        });
        self.candidates.sort_unstable();
        self.found.clear();
        for &index in &self.candidates {
            let triangle = a.set.triangle(index);
            let [p, q, r] = triangle.vertices;
            let middle = (p + q + r) / 3.0;
            let size = (p - middle).length().max((q - middle).length()).max((r - middle).length());
            let shape = Convex::Triangle(triangle);
            let center = a.rotation * middle + a.position;
            let placed = Placed { shape: &shape, rotation: a.rotation, position: a.position, center, size };
            touch_triangle(a, index, &placed, b, margin, narrow, &mut self.found);
        }
        self.reduce(b.size, margin, narrow, out);
    }

    /// Appends the vertices of the surface B within `margin` of the half-space A.
    pub fn half_space(
        &mut self,
        a: &HalfSpace,
        b: &PlacedSet,
        size: f64,
        margin: f64,
        narrow: &mut Narrow,
        out: &mut Vec<Touch>,
    ) {
        for (i, p) in b.set.vertices.iter().enumerate() {
            a.touch_point(b.rotation * *p + b.position, Feature::VertexB(i as u32), margin, out);
        }
        narrow.reducer.limit(out, size);
    }

    /// Appends the contacts of the surface B with the surface A within `margin`, reduced as those of a convex shape are.
    ///
    /// - `size`: of the smaller one, m
    pub fn surfaces(
        &mut self,
        a: &PlacedSet,
        b: &PlacedSet,
        size: f64,
        margin: f64,
        narrow: &mut Narrow,
        out: &mut Vec<Touch>,
    ) {
        self.found.clear();
        self.triangles.touch(a, b, margin, narrow, &mut self.found);
        self.reduce(size, margin, narrow, out);
    }

    /// Reduces the contacts of each flat part of the surface to their outline.
    fn reduce(&mut self, size: f64, margin: f64, narrow: &mut Narrow, out: &mut Vec<Touch>) {
        while let Some(first) = self.found.first().copied() {
            let surface = |t: &Touch| first.normal.dot(t.position - t.normal * (0.5 * t.gap));
            let level = surface(&first);
            let from = out.len();
            self.rest.clear();
            for touch in &self.found {
                let same = touch.normal.dot(first.normal) > 1.0 - SAME_NORMAL;
                let group =
                    if same && (surface(touch) - level).abs() <= 1e-6 * size { &mut *out } else { &mut self.rest };
                group.push(*touch);
            }
            narrow.reducer.outline(out, from, margin, size);
            std::mem::swap(&mut self.found, &mut self.rest);
        }
    }
}

/// Contacts of B with one triangle; none of its own where the normal would lean over an edge to a neighbour that has
/// the contact.
fn touch_triangle(
    set: &PlacedSet,
    index: u32,
    a: &Placed,
    b: &Placed,
    margin: f64,
    narrow: &mut Narrow,
    out: &mut Vec<Touch>,
) {
    let from = out.len();
    let Some(found) = narrow.touch(a, b, margin, out) else { return };
    let leaning = a.local(found.normal);
    // What is outside of a closed surface is touched by the outside of its triangles: where a side of B and one of a solid are in one plane, the
    // triangle at the edge that they share would touch B from behind as well.
    let is_outside = set.set.closed && !set.set.is_front(index, leaning) && {
        let inside_b = set.rotation.transpose() * (b.inside() - set.position);
        !set.set.encloses(inside_b)
    };
    let (allowed, free) = set.set.allowed_normal(index, leaning, is_outside);
    if !free {
        out.truncate(from);
        let normal = a.rotation * allowed;
        let gap = separation_along(a, b, normal);
        if gap <= margin {
            let size = scale(a, b);
            narrow.patches(a, b, &Separation { normal, gap, midpoint: None }, size, out);
            // What touches a side of a body at its edge overlaps the plane of that side by as much as it is wide, and is another side's. Below a height
            // field all is solid.
            if !set.set.solid_below {
                let lowest = lowest_allowed(found.gap, a.size.min(b.size));
                keep_gaps(out, from, |gap| gap >= lowest);
            }
            narrow.reducer.outline(out, from, margin, size);
        }
    }
    for touch in &mut out[from..] {
        if touch.feature == Feature::Closest {
            touch.feature = Feature::OnTriangle(index);
        }
    }
}
