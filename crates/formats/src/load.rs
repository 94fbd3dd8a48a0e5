//! The entry points.

use std::path::Path;

use crate::error::FormatError;
use crate::mesh::read_file;
use crate::options::{Imported, LoadOptions};
use crate::{mjcf, sdf, urdf, xml};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;

/// Reads a model file; its root element says whether it is MJCF, URDF or SDF.
///
/// # Errors
/// [`FormatError`] with the place in the file; [`FormatError::Unreadable`] if there is no such file or it is not text;
/// [`FormatError::InvalidFriction`].
pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    let path = path.as_ref();
    let base = path.parent().unwrap_or(Path::new(""));
    import(text_of(path)?.parse(&path.to_string_lossy())?, base, Some(path), options)
}

fn import(tree: xml::Tree, base: &Path, main: Option<&Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    let (root, at) = (tree.root().name().to_owned(), tree.root().at());
    let with_unused = |imported| options.report_unused(&root, &at.file, imported);
    match &*root {
        "mujoco" => mjcf::import(tree, base, main, options).map(with_unused),
        "robot" => urdf::import(tree, base, options),
        "sdf" | "gazebo" => sdf::import(tree, base, options).map(with_unused),
        _ => Err(FormatError::UnknownFormat { at, found: root }),
    }
}

/// The text of a model file, whatever it is written in.
///
/// # Errors
/// [`FormatError::Unreadable`].
pub fn read_text(path: impl AsRef<Path>) -> Result<String, FormatError> {
    text_of(path.as_ref()).map(|text| text.text)
}

fn text_of(path: &Path) -> Result<xml::Text, FormatError> {
    let unreadable = |reason| FormatError::Unreadable { path: path.to_owned(), reason };
    xml::Text::of(read_file(path, MAX_BYTES).map_err(unreadable)?).map_err(unreadable)
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

/// [`load_mjcf_str`] with options; what has no meaning in MJCF is reported.
///
/// # Errors
/// As [`load`].
pub fn load_mjcf_str_with(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    import(parse_as("mujoco", text, "(MJCF text)")?, base.as_ref(), None, options)
}

/// Reads URDF from text; files that it names by relative paths are looked for in `base`.
///
/// # Errors
/// As [`load`].
pub fn load_urdf_str(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    import(parse_as("robot", text, "(URDF text)")?, base.as_ref(), None, options)
}

/// Reads SDF from text; files that it names by relative paths are looked for in `base`.
///
/// # Errors
/// As [`load`].
pub fn load_sdf_str(text: &str, base: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, FormatError> {
    options.check()?;
    import(parse_as("sdf", text, "(SDF text)")?, base.as_ref(), None, options)
}

fn parse_as(root: &str, text: &str, label: &str) -> Result<xml::Tree, FormatError> {
    let tree = xml::parse(text, label)?;
    if tree.root().is(root) {
        return Ok(tree);
    }
    Err(FormatError::UnknownFormat { at: tree.root().at(), found: tree.root().name().to_owned() })
}
