//! A half-space against everything else: in closed form.

use glamx::glam::DVec3;

use crate::convex::{Convex, Placed};
use crate::feature::Feature;
use crate::hull::{Hull, Visited};
use crate::manifold::Touch;
use crate::narrow::Narrow;
use crate::patch::{Patch, box_corner, box_corner_id};

/// A half-space `normal · p ≤ offset` in the common frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace {
    pub normal: DVec3,
    pub offset: f64,
}

/// A face leans down if its normal is below the plane's horizon by more than this sine.
const LEANING: f64 = 1e-9;

impl HalfSpace {
    /// Appends the points of the convex shape B that are within `margin` of the half-space A: corners of boxes that
    /// can be seen from the plane, vertices of polyhedra that can come to be the lowest, the facing patch of round shapes.
    pub fn touch(&self, b: &Placed, margin: f64, narrow: &mut Narrow, out: &mut Vec<Touch>) {
        let lowest = -b.extent(-self.normal) - self.offset;
        if lowest.is_nan() || lowest > margin {
            return;
        }
        let patch = &mut narrow.manifold.patch_b;
        match b.shape {
            Convex::Box { half } => {
                let down = b.local(-self.normal);
                patch.clear();
                for k in 0..8_u32 {
                    let signs = [k & 1 != 0, k & 2 != 0, k & 4 != 0];
                    let faces_down = |i: usize| if signs[i] { down[i] > LEANING } else { down[i] < -LEANING };
                    if (0..3).any(faces_down) {
                        patch.points.push(b.point(box_corner(*half, signs)));
                        patch.ids.push(box_corner_id(signs));
                    }
                }
            }
            Convex::Hull(hull) => {
                hull_vertices(self, (b, hull), narrow.reducer.turn, margin, &mut narrow.visited, patch);
            }
            _ => patch.fill(b, -self.normal),
        }
        for (point, id) in patch.points.iter().zip(&patch.ids) {
            self.touch_point(*point, Feature::VertexB(*id), margin, out);
        }
    }

    /// Appends the contact of one point of B with the half-space A if it is within `margin`.
    pub fn touch_point(&self, point: DVec3, feature: Feature, margin: f64, out: &mut Vec<Touch>) {
        let gap = self.normal.dot(point) - self.offset;
        if gap <= margin {
            let position = point - self.normal * (0.5 * gap);
            out.push(Touch { position, normal: self.normal, gap, feature });
        }
    }
}

/// Vertices of a polyhedron lower by this share of its size than a neighbour's are as low as it.
const LEVEL: f64 = 1e-6;

/// The vertices within `margin` that can be the lowest after a turn by `turn` (rad): no neighbour is lower by more than
/// the turn can make up for. While none of these penetrates, none of the others does.
fn hull_vertices(
    half_space: &HalfSpace,
    (placed, hull): (&Placed, &Hull),
    turn: f64,
    margin: f64,
    visited: &mut Visited,
    patch: &mut Patch,
) {
    patch.clear();
    let down = placed.local(-half_space.normal);
    let deepest = half_space.normal.dot(placed.position) - half_space.offset - margin;
    let can_touch = |i: u32| {
        let p = hull.vertices[i as usize];
        let depth = down.dot(p);
        depth >= deepest
            && hull.neighbours.of(i as usize).iter().all(|&j| {
                let q = hull.vertices[j as usize];
                let lower = down.dot(q) - depth - LEVEL * placed.size;
                // Most are not lower, whatever the turn can make up for.
                lower <= 0.0 || lower <= turn * (q - p).length()
            })
    };
    hull.visit_around(down, visited, can_touch, |i| {
        patch.ids.push(i);
        patch.points.push(placed.point(hull.vertices[i as usize]));
    });
}
