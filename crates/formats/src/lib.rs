//! Reads MJCF, URDF and SDF models.
//!
//! [`load`] looks at a file, [`load_mjcf_str`], [`load_urdf_str`] and [`load_sdf_str`] at text. Each gives an [`Imported`]: the
//! [`Model`](signorini_multibody::Model), and an [`ImportReport`] that lists with file and line everything in the file
//! that the model does not have and what that changes. Files that make no sense are refused with a [`FormatError`] that
//! says where and what to do. No input makes the readers panic.
//!
//! ```
//! use signorini_formats::{LoadOptions, load_urdf_str};
//!
//! let text = r#"<robot name="ball">
//!   <link name="ball">
//!     <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
//!     <collision><geometry><sphere radius="0.1"/></geometry></collision>
//!   </link>
//! </robot>"#;
//! let imported = load_urdf_str(text, ".", &LoadOptions::default().with_floating_base(true).with_floor(true))?;
//! assert_eq!((imported.model.nv, imported.model.bodies[1].inertia.mass), (6, 2.0));
//! assert_eq!(imported.report.motion_warnings().count(), 0, "{}", imported.report);
//! # Ok::<(), signorini_formats::FormatError>(())
//! ```

mod armature;
mod coverage;
mod decompose;
mod error;
mod inertia;
mod load;
mod mesh;
mod mesh_store;
mod mimic;
mod mjcf;
mod options;
mod packages;
mod parts;
mod report;
mod sdf;
mod shapes;
mod urdf;
mod visuals;
mod write;
mod xml;

pub use error::{FormatError, Location};
pub use load::{load, load_mjcf_str, load_mjcf_str_with, load_sdf_str, load_urdf_str, read_text};
pub use mesh::{MeshFormat, read_mesh, read_mesh_file, solid_inertia};
pub use options::{Imported, LoadOptions, MissingMeshes};
pub use report::{ImportReport, Warning};
pub use write::{Written, write_mjcf, write_urdf};
