//! Questions about shapes that no step asks: how far two geoms are apart, and what a ray meets.

mod nearest;
mod placed;
mod ray;
mod ray_shapes;

pub use nearest::Nearest;
pub use placed::Queries;
pub use ray::{Ray, RayHit};
