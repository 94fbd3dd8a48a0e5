//! A half-space against everything else: in closed form.

use glamx::glam::DVec3;

use crate::convex::{Convex, Placed};
use crate::feature::Feature;
use crate::hull::Hull;
use crate::manifold::Touch;
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
    /// Appends the points of the convex shape B that are within `margin` of the half-space A: vertices of polyhedra that
    /// can be seen from the plane, the facing patch of round shapes.
    pub fn touch(&self, b: &Placed, margin: f64, patch: &mut Patch, out: &mut Vec<Touch>) {
        let lowest = -b.extent(-self.normal) - self.offset;
        if lowest.is_nan() || lowest > margin {
            return;
        }
        let down = b.local(-self.normal);
        match b.shape {
            Convex::Box { half } => {
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
            Convex::Hull(hull) => hull_vertices(b, hull, down, patch),
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

/// The vertices of the faces that look down; only these can bear.
fn hull_vertices(placed: &Placed, hull: &Hull, down: DVec3, patch: &mut Patch) {
    patch.clear();
    for face in hull.faces.iter().filter(|f| f.normal.dot(down) > LEANING) {
        for &i in &face.loop_ {
            if !patch.ids.contains(&i) {
                patch.ids.push(i);
                patch.points.push(placed.point(hull.vertices[i as usize]));
            }
        }
    }
}
