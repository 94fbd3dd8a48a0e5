//! Triangle meshes and height fields against each other, triangle by triangle.
//!
//! Bodies that obey the laws of contact do not enter each other, so that two triangles at a contact are apart, or overlap by rounding. The
//! direction of their contact is the axis of separation (a face's normal, or the product of two edges; Gottschalk, Lin & Manocha 1996) along
//! which they are farthest apart among those that both surfaces allow: at an edge or a vertex a normal can lean as far as the neighbouring
//! faces do and no farther ([`TriangleSet::allows`]). So the edges inside a flat or hollow part of a surface have no contacts of their own.

use glamx::glam::{DMat3, DVec3};

use crate::bvh::Aabb;
use crate::convex::{Convex, Placed, Triangle, bounds_of, scale};
use crate::manifold::Touch;
use crate::mesh::{PlacedSet, TriangleSet};
use crate::narrow::Narrow;
use crate::separation::Separation;

/// Triangles that are apart cannot touch from the inside; by this share of their size they are apart for certain.
const APART: f64 = 1e-9;

/// An overlap along the allowed axis deeper than this many times the least one belongs to another side of the body.
const DEEPEST: f64 = 4.0;

/// The least gap along an allowed axis that belongs to the contact of shapes whose largest one is `most`, m.
///
/// - `size`: of the smaller one, m
pub(crate) fn lowest_allowed(most: f64, size: f64) -> f64 {
    let inside = if most > APART * size { 0.0 } else { DEEPEST * most };
    inside - APART * size
}

/// A triangle beside an edge and level with the face behind it, by this share of their size, slides over the edge: that face is the one
/// it will meet, and the side of the edge no obstacle. More than rounding and less than any step that is meant.
const FLUSH: f64 = 2e-6;

/// Buffers of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    near_b: Vec<u32>,
    near_a: Vec<u32>,
}

impl Triangles {
    /// Appends to `out` the contacts of the surfaces A and B within `margin` (m), normals from A to B, not yet reduced.
    pub fn touch(&mut self, a: &PlacedSet, b: &PlacedSet, margin: f64, narrow: &mut Narrow, out: &mut Vec<Touch>) {
        // Everything is looked for in the frame of A.
        let relative = a.rotation.transpose() * b.rotation;
        let offset = a.rotation.transpose() * (b.position - a.position);
        let (low, high) = a.set.bounds();
        let around_a = grown(&Aabb { low, high }, &relative.transpose(), -(relative.transpose() * offset), margin);
        self.near_b.clear();
        b.set.bvh.overlapping(&around_a, |j| {
            let (low, high) = bounds_of(&b.set.triangle(j).vertices);
            if around_a.overlaps(&Aabb { low, high }) {
                self.near_b.push(j);
            }
        });
        self.near_b.sort_unstable();
        for &j in &self.near_b {
            let of_b = b.set.triangle(j);
            let (low, high) = bounds_of(&of_b.vertices.map(|p| relative * p + offset));
            let margin_box = DVec3::splat(margin);
            let around = Aabb { low: low - margin_box, high: high + margin_box };
            self.near_a.clear();
            a.set.bvh.overlapping(&around, |i| {
                let (low, high) = bounds_of(&a.set.triangle(i).vertices);
                if around.overlaps(&Aabb { low, high }) {
                    self.near_a.push(i);
                }
            });
            self.near_a.sort_unstable();
            let of_b = Stood::new(b, j);
            for &i in &self.near_a {
                touch_pair((a, i), (b, &of_b), margin, narrow, out);
            }
        }
    }
}

/// The box around a box that is turned, moved and grown by a margin.
fn grown(of: &Aabb, rotation: &DMat3, offset: DVec3, margin: f64) -> Aabb {
    let (center, half) = (0.5 * (of.low + of.high), 0.5 * (of.high - of.low));
    let (center, half) = (*rotation * center + offset, rotation.abs() * half + DVec3::splat(margin));
    Aabb { low: center - half, high: center + half }
}

/// A triangle in the common frame.
struct Corners {
    points: [DVec3; 3],
    normal: DVec3,
}

impl Corners {
    fn new(set: &PlacedSet, triangle: &Triangle) -> Self {
        let points = triangle.vertices.map(|p| set.rotation * p + set.position);
        Self { points, normal: set.rotation * triangle.normal }
    }

    fn edges(&self) -> [DVec3; 3] {
        let [p, q, r] = self.points;
        [q - p, r - q, p - r]
    }

    /// Radius of a ball around the middle, and the middle.
    fn ball(&self) -> (f64, DVec3) {
        let middle = (self.points[0] + self.points[1] + self.points[2]) / 3.0;
        (self.points.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max), middle)
    }

    fn lowest(&self, n: DVec3) -> f64 {
        let [p, q, r] = self.points.map(|x| n.dot(x));
        p.min(q).min(r)
    }
}

/// A triangle of a surface where it stands.
struct Stood {
    index: u32,
    triangle: Triangle,
    corners: Corners,
    size: f64,
    center: DVec3,
}

impl Stood {
    fn new(set: &PlacedSet, index: u32) -> Self {
        let triangle = set.set.triangle(index);
        let corners = Corners::new(set, &triangle);
        let (size, center) = corners.ball();
        Self { index, triangle, corners, size, center }
    }
}

/// Appends the contacts of triangle `i` of A and one of B.
fn touch_pair(
    (a, i): (&PlacedSet, u32),
    (b, of_b): (&PlacedSet, &Stood),
    margin: f64,
    narrow: &mut Narrow,
    out: &mut Vec<Touch>,
) {
    let of_a = &Stood::new(a, i);
    if (of_b.center - of_a.center).length() > of_a.size + of_b.size + margin {
        return;
    }
    let allows =
        |n: DVec3| [a.set.allows(i, a.rotation.transpose() * n), b.set.allows(of_b.index, b.rotation.transpose() * -n)];
    let size = of_a.size.min(of_b.size);
    let Some(mut axes) = Axes::within(&of_a.corners, &of_b.corners, margin) else { return };
    let lowest = lowest_allowed(axes.most, size);
    let Some((gap, normal)) = axes.best(FLUSH * size, lowest, allows) else { return };
    let from = out.len();
    let [shape_a, shape_b] = [of_a, of_b].map(|of| Convex::Triangle(of.triangle));
    let place = |set: &PlacedSet, shape, of: &Stood| {
        let (rotation, position, center, size) = (set.rotation, set.position, of.center, of.size);
        Placed { shape, rotation, position, center, size }
    };
    let (placed_a, placed_b) = (place(a, &shape_a, of_a), place(b, &shape_b, of_b));
    let size = scale(&placed_a, &placed_b);
    narrow.patches(&placed_a, &placed_b, &Separation { normal, gap, midpoint: None }, size, out);
    narrow.reducer.outline(out, from, margin, size);
}

/// The axes of two triangles with their gaps: two faces, six sides, nine pairs of edges, in both directions.
struct Axes {
    all: [(f64, DVec3); 34],
    count: usize,
    /// The largest gap.
    most: f64,
}

impl Axes {
    /// All axes of separation; nothing where the triangles are farther apart than `margin` along one.
    fn within(a: &Corners, b: &Corners, margin: f64) -> Option<Self> {
        let mut axes = Self { all: [(0.0, DVec3::ZERO); 34], count: 0, most: f64::NEG_INFINITY };
        let (edges_a, edges_b) = (a.edges(), b.edges());
        let sides_a = edges_a.map(|e| e.cross(a.normal));
        let sides_b = edges_b.map(|e| e.cross(b.normal));
        let faces = [a.normal, b.normal];
        for axis in faces.into_iter().chain(sides_a).chain(sides_b) {
            axes.add(axis, a, b, margin)?;
        }
        for e in edges_a {
            for f in edges_b {
                let axis = e.cross(f);
                // Edges along each other have the axes of the faces.
                if axis.length_squared() > 1e-12 * e.length_squared() * f.length_squared() {
                    axes.add(axis, a, b, margin)?;
                }
            }
        }
        Some(axes)
    }

    fn add(&mut self, axis: DVec3, a: &Corners, b: &Corners, margin: f64) -> Option<()> {
        let Some(axis) = axis.try_normalize() else { return Some(()) };
        for n in [axis, -axis] {
            let gap = b.lowest(n) + a.lowest(-n);
            if gap > margin {
                return None;
            }
            self.all[self.count] = (gap, n);
            self.count += 1;
            self.most = self.most.max(gap);
        }
        Some(())
    }

    /// The axis that both surfaces allow, on a level within `flush` or else with the largest gap, which is at least `lowest`. None where the
    /// triangles are on a level along an axis that one surface alone allows: the contact belongs to another triangle at the other one's vertex.
    ///
    /// - `allows`: whether the surface of A, and that of B, does
    fn best(&mut self, flush: f64, lowest: f64, allows: impl Fn(DVec3) -> [bool; 2]) -> Option<(f64, DVec3)> {
        let is_flush = |gap: f64| gap.abs() <= flush;
        self.keep(|gap| gap >= lowest || is_flush(gap));
        let mut of_neighbour = false;
        while let Some((gap, n)) = self.take_farthest(flush) {
            if !is_flush(gap) && of_neighbour {
                return None;
            }
            match allows(n) {
                [true, true] => return Some((gap, n)),
                [false, false] => {}
                _ => of_neighbour |= is_flush(gap),
            }
        }
        None
    }

    /// Leaves out the axes with other gaps.
    fn keep(&mut self, wanted: impl Fn(f64) -> bool) {
        let mut kept = 0;
        for k in 0..self.count {
            self.all[kept] = self.all[k];
            kept += usize::from(wanted(self.all[k].0));
        }
        self.count = kept;
    }

    /// Takes out the axis with the largest gap, those within `flush` before all others; of equals the first, so that faces come before edges.
    fn take_farthest(&mut self, flush: f64) -> Option<(f64, DVec3)> {
        let rank = |gap: f64| if gap.abs() <= flush { 1 } else { 0 };
        let mut best: Option<usize> = None;
        for (k, &(gap, _)) in self.all[..self.count].iter().enumerate().filter(|(_, axis)| !axis.0.is_nan()) {
            let better = best.is_none_or(|other| {
                let other = self.all[other].0;
                rank(gap) > rank(other) || (rank(gap) == rank(other) && gap > other + ROUNDING * flush)
            });
            if better {
                best = Some(k);
            }
        }
        let taken = self.all[best?];
        self.all[best?].0 = f64::NAN;
        Some(taken)
    }
}

/// Axes whose gaps differ by less than this share of what is flush are equally good.
const ROUNDING: f64 = 1e-6;

impl TriangleSet {
    /// Whether the surface allows a contact on this triangle whose normal, in the mesh's frame, points out of it along `n`: the triangle's
    /// own normal, and what leans over its edges no farther than the neighbours' normals. A closed surface has contacts on its outside only.
    pub fn allows(&self, index: u32, n: DVec3) -> bool {
        self.allowed_normal(index, n, self.closed).1
    }
}
