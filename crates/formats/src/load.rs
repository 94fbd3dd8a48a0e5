//! The entry points.

use derive_setters::Setters;
use std::path::{Path, PathBuf};

use signorini_multibody::Model;

use crate::error::FormatError;
use crate::mesh::read_file;
use crate::report::{ImportReport, Warning};
use crate::{mjcf, sdf, urdf, xml};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;

/// How to read what a file leaves open.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct LoadOptions {
    /// Folders in which the packages of `package://…` are looked for (URDF, SDF). The folders above the model are searched
    /// after them. Default: none.
    pub package_dirs: Vec<PathBuf>,
    /// Whether the root link of a URDF gets a free joint; otherwise it is fixed to the world. Default: false.
    pub floating_base: bool,
    /// Whether links that a fixed joint connects become one body (URDF). The merged link's frame stays as a site of its
    /// name. Default: false.
    pub merge_fixed_joints: bool,
    /// Whether the links of a URDF meet each other, but for those that a joint connects. Default: true.
    pub self_collision: bool,
    /// An SRDF file whose `<disable_collisions>` say which links of a URDF do not meet. Default: none.
    #[setters(into)]
    pub srdf: Option<PathBuf>,
    /// Coefficient of friction of the shapes of a URDF, which has no word for it; finite, ≥ 0. Default: 1.
    pub friction: f64,
    /// Whether the world gets a floor (URDF, SDF): the plane z = 0, the first geom, called "floor". Its own friction is 0, so that
    /// the friction of what stands on it counts. Default: false.
    pub floor: bool,
    /// What becomes of a geom whose mesh file is not there. Default: the file is refused.
    pub missing_meshes: MissingMeshes,
}

/// What becomes of a geom whose mesh file is not there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingMeshes {
    /// The model is refused.
    #[default]
    Stop,
    /// The geom is left out, which the report tells: nothing touches it, and a body whose inertia comes from its geoms loses its share.
    Skip,
}

impl LoadOptions {
    fn check(&self) -> Result<(), FormatError> {
        if self.friction >= 0.0 && self.friction.is_finite() {
            return Ok(());
        }
        Err(FormatError::InvalidFriction { found: self.friction })
    }

    /// Adds to the report of an MJCF file called `file` what is asked for and not done there. [`load`] does so by itself.
    pub fn report_unused(&self, file: &str, mut imported: Imported) -> Imported {
        if self.floor {
            imported.report.warnings.push(Warning {
                file: file.to_owned(),
                line: 1,
                element: "mujoco".into(),
                what: "a floor was asked for".into(),
                effect: "MJCF has its own; none is added".into(),
                count: 1,
                changes_motion: true,
            });
        }
        imported
    }
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            package_dirs: Vec::new(),
            floating_base: false,
            merge_fixed_joints: false,
            self_collision: true,
            srdf: None,
            friction: 1.0,
            floor: false,
            missing_meshes: MissingMeshes::Stop,
        }
    }
}

/// A model and what the file had that the model has not.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Imported {
    /// The model.
    pub model: Model,
    /// What was left out or altered.
    pub report: ImportReport,
}

/// Reads a model file; its root element says whether it is MJCF, URDF or SDF.
///
/// # Errors
/// [`FormatError`] with the place in the file; [`FormatError::Unreadable`] if there is no such file or it is not text;
/// [`FormatError::InvalidFriction`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    let path = path.as_ref();
    let unreadable = |reason| FormatError::Unreadable { path: path.to_owned(), reason };
    let bytes = read_file(path, MAX_BYTES).map_err(unreadable)?;
    let text = String::from_utf8(bytes).map_err(|_| unreadable("not UTF-8 text".into()))?;
    let base = path.parent().unwrap_or(Path::new(""));
    let tree = xml::parse(&text, &path.to_string_lossy())?;
    match tree.root().name() {
        "mujoco" => Ok(options.report_unused(&path.to_string_lossy(), mjcf::import(tree, base, Some(path), options)?)),
        "robot" => urdf::import(tree, base, options),
        "sdf" | "gazebo" => sdf::import(tree, base, options),
        found => Err(FormatError::UnknownFormat { at: tree.root().at(), found: found.to_owned() }),
    }
}

/// Reads MJCF from text; files that it names are looked for in `base`.
///
/// ```
/// let text = r#"<mujoco>
///   <worldbody>
///     <body name="ball" pos="0 0 1"><freejoint/><geom size="0.1" mass="2" solref="0.01 1"/></body>
///   </worldbody>
/// </mujoco>"#;
/// let imported = signorini_formats::load_mjcf_str(text, ".")?;
/// assert_eq!((imported.model.nq, imported.model.bodies[1].inertia.mass), (7, 2.0));
/// assert_eq!(imported.report.warnings[0].line, 3); // contacts are rigid, 'solref' has no meaning
/// # Ok::<(), signorini_formats::FormatError>(())
/// ```
///
/// # Errors
/// As [`load`].
pub fn load_mjcf_str(text: &str, base: impl AsRef<Path>) -> Result<Imported, FormatError> {
    load_mjcf_str_with(text, base, &LoadOptions::default())
}

/// [`load_mjcf_str`] with options; of these MJCF leaves open what becomes of missing meshes.
///
/// # Errors
/// As [`load`].
pub fn load_mjcf_str_with(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    let tree = parse_as("mujoco", text, "(MJCF text)")?;
    mjcf::import(tree, base.as_ref(), None, options)
}

/// Reads URDF from text; files that it names by relative paths are looked for in `base`.
///
/// # Errors
/// As [`load`].
pub fn load_urdf_str(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    let tree = parse_as("robot", text, "(URDF text)")?;
    urdf::import(tree, base.as_ref(), options)
}

/// Reads SDF from text; files that it names by relative paths are looked for in `base`.
///
/// # Errors
/// As [`load`].
pub fn load_sdf_str(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    let tree = parse_as("sdf", text, "(SDF text)")?;
    sdf::import(tree, base.as_ref(), options)
}

fn parse_as(root: &str, text: &str, label: &str) -> Result<xml::Tree, FormatError> {
    let tree = xml::parse(text, label)?;
    if tree.root().is(root) {
        return Ok(tree);
    }
    Err(FormatError::UnknownFormat { at: tree.root().at(), found: tree.root().name().to_owned() })
}
