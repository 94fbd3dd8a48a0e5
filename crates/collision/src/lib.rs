//! Contact points between the geoms of a model.
//!
//! Second room of the step: poses come in, [`ContactPoint`](signorini_multibody::ContactPoint)s go out. [`Collider`] is
//! made once per model; [`Collider::find`] gives every point at which two geoms could touch within the step, as far as
//! the bodies can travel ([`Reach`]), so that nothing tunnels. The answer is a pure function of the poses: no manifold
//! is carried from call to call.
//!
//! ```
//! use signorini_collision::{Collider, Reach};
//! use signorini_multibody::{Geometry, ModelBuilder, Pose};
//!
//! let mut world = ModelBuilder::new("ball above a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.12]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let model = world.build()?;
//!
//! // Gap 20 mm: a point where the ball can travel 50 mm within the step, none where it can travel 5.
//! let (mut collider, mut points) = (Collider::new(&model)?, Vec::new());
//! let poses = [Pose::IDENTITY, [0.0, 0.0, 0.12].into()];
//! for (linear, expected) in [(0.05, 1), (0.005, 0)] {
//!     let reach = [Reach { linear: 0.0, angular: 0.0 }, Reach { linear, angular: 0.0 }];
//!     collider.find(&model, &poses, &reach, &mut points);
//!     assert_eq!(points.len(), expected);
//!     assert!(points.iter().all(|point| (point.gap - 0.02).abs() < 1e-12));
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is exact
//!
//! | pair | normal and gap | points |
//! |---|---|---|
//! | plane – box, triangle mesh | exact | every vertex that looks at the plane within the margin (at most 8 by outline) |
//! | plane – convex mesh | exact | every vertex within the margin that the step's turn can make the lowest (at most 8 by outline) |
//! | plane – sphere, capsule, ellipsoid, cone, cylinder | exact | points of support; a disc lying flat: 8 points of its rim |
//! | sphere – anything convex | exact (ellipsoid: root finding to rounding; hull: GJK to rounding) | 1 |
//! | capsule – capsule | exact | 1; where they run along each other: the ends of the common part |
//! | box – box | exact: 15 axes; apart corner to corner: closest points. A face normal is preferred to an edge axis that is better by less than a thousandth; where two corners meet, the direction between both face normals is taken | overlap of the facing faces, up to 8 |
//! | other convex pairs, contact along a face normal, an axis or a common perpendicular | exact | overlap of the facing faces, lines and discs (octagons through the lowest point of the rim) |
//! | other convex pairs, apart | GJK, polished: polyhedra exact; curved shapes to 1e-8 of the size in the gap, 1e-5 in normal and position | the same, or the closest points |
//! | other convex pairs, overlapping | expanding polytope: polyhedra exact; curved shapes as above | the same |
//! | triangle mesh, height field – convex | as for a triangle | per triangle, then one outline per flat part |
//!
//! The gap is always the separation of the two shapes along the returned normal, computed from their support functions:
//! where a search ends early it is smaller than the true distance, never larger (but for the rounding given above).
//!
//! All of this is checked on random and degenerate pairs against an independent method
//! (`cargo run --release -p signorini-collision --example cross_check`). Where faces are parallel up to rounding their points are
//! determined to 2e-7 of the size; a disc that leans by less than 1e-6 counts as flat.
//!
//! A pair has one normal (capsules along each other and meshes may have several), so a point that would only be reached
//! by a large turn within the step can be missing; the next step finds it. Triangle meshes are thin and have two outsides;
//! a height field is solid below. Edges inside a flat or hollow part of a surface let no normal lean over them; between
//! separate geoms (a floor of boxes) this is not known, and a box sliding over their seam can catch on it.

mod apart;
mod bvh;
mod capsule;
mod clipping;
mod collider;
mod convex;
mod decompose;
mod distance;
mod ellipsoids;
mod epa;
mod error;
mod feature;
mod fixed;
mod gjk;
mod halfspace;
mod hull;
mod hull_build;
mod laws;
mod manifold;
mod mesh;
mod narrow;
mod neighbours;
mod outermost;
mod overlaps;
mod partners;
mod patch;
mod placing;
mod query;
mod reach;
mod reduce;
mod search;
mod separation;
mod shape;
mod still;
mod surface;
mod sweep;
#[cfg(test)]
mod testing;
mod triangles;

pub use collider::Collider;
pub use decompose::convex_parts;
pub use error::CollisionError;
pub use hull_build::convex_hull;
pub use overlaps::OwnOverlap;
pub use query::{Nearest, Queries, Ray, RayHit};
pub use reach::{PairReach, Reach, RelativeMotion};
