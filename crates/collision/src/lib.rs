//! Contact points between the geoms of a model.
//!
//! Second room of the step: poses come in, [`ContactPoint`](signorini_multibody::ContactPoint)s go out. [`Collider`] is
//! made once per model; [`Collider::find`] gives every point at which two geoms could touch within the step, as far as
//! the bodies can travel ([`Reach`]), so that nothing tunnels. The answer is a pure function of the poses: no manifold
//! is carried from call to call.
//!
//! What is exact and what is not, by pair:
//!
//! | pair | normal and gap | points |
//! |---|---|---|
//! | plane – box, convex mesh | exact | every vertex of a face that looks at the plane (at most 8 by outline) |
//! | plane – sphere, capsule, ellipsoid, cone, cylinder | exact | support points; a disc lying flat: 8 rim points |
//! | sphere – anything convex | exact (ellipsoid: root finding to rounding) | 1 |
//! | capsule – capsule | exact | 1; along each other: the ends of the common part |
//! | box – box | exact: 15 axes; corner against corner: closest points | overlap of the faces |
//! | triangle – the above | exact | overlap of the triangle with the facing patch |
//! | other convex pairs | the best of closed-form axes, GJK (apart) and an expanding polytope (overlapping); polyhedra end exactly, curved sides to 1e-12 of the size in the gap, about 1e-6 rad in the normal | overlap of the facing patches, discs as octagons through the deepest point of the rim, or the closest points |
//!
//! The gap is always the separation of the two shapes along the returned normal, computed from their support functions:
//! it can be smaller than the true distance when a search ends early, never larger.

mod bvh;
mod capsule;
mod collider;
mod convex;
mod distance;
mod epa;
mod error;
mod feature;
mod gjk;
mod halfspace;
mod hull;
mod manifold;
mod mesh;
mod narrow;
mod patch;
mod reduce;
mod separation;
mod shape;
mod surface;

pub use collider::{Collider, Reach};
pub use error::CollisionError;
