//! Worlds to simulate, made by rule and by seed.
//!
//! Every function gives a file as text: MJCF that needs no other file, whose first line says how it was made. The same arguments give the same
//! text on every machine.
//!
//! ```
//! use signorini_generate::{Heap, Shapes};
//!
//! let text = Heap::new(20).with_seed(7).with_shapes(Shapes::Mixed).mjcf()?;
//! assert_eq!(text.matches("<freejoint").count(), 20);
//! # Ok::<(), signorini_generate::GenerateError>(())
//! ```

mod buildings;
mod error;
mod heap;
mod objects;
mod random;
mod terrain;
mod text;

pub use buildings::{Arch, Pallet, Stack, Wall};
pub use error::{GenerateError, LENGTHS};
pub use heap::Heap;
pub use objects::Shapes;
pub use terrain::{Rough, Stairs, Terrain};
