//! Reads MJCF, URDF and SDF models.
//!
//! [`load`] looks at a file, [`load_mjcf_str`], [`load_urdf_str`] and [`load_sdf_str`] at text. Each gives an [`Imported`]: the
//! [`Model`](signorini_multibody::Model), and an [`ImportReport`] that lists with file and line everything in the file
//! that the model does not have and what that changes. Files that make no sense are refused with a [`FormatError`] that
//! says where and what to do. No input makes the readers panic.

mod coverage;
mod error;
mod inertia;
mod load;
mod mesh;
mod mjcf;
mod packages;
mod parts;
mod report;
mod sdf;
mod shapes;
mod urdf;
mod xml;

pub use error::{FormatError, Location};
pub use load::{Imported, LoadOptions, load, load_mjcf_str, load_sdf_str, load_urdf_str};
pub use mesh::{MeshFormat, read_mesh};
pub use report::{ImportReport, Warning};
