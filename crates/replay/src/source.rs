//! The model's file in a recording, and the model from there.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_formats::{
    FormatError, Imported, LoadOptions, MissingMeshes, load_mjcf_str_with, load_sdf_str, load_urdf_str, read_text,
};
use signorini_multibody::Model;
use signorini_recording::{Header, ModelSource};
use signorini_simulation::recorded_model;

use crate::ReplayError;

/// The file of a model, by its text.
///
/// - `file`: for people
/// - `base_dir`: folder in which files that the text names are looked for; made absolute unless empty
pub fn model_source(file: &str, text: &str, base_dir: &Path, options: &LoadOptions) -> ModelSource {
    let name = |path: &Path| path.to_string_lossy().into_owned();
    // Where the present folder is not known, the path is kept as it is.
    let absolute = |path: &Path| name(&std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()));
    ModelSource {
        file: file.to_owned(),
        text: text.to_owned(),
        base_dir: if base_dir.as_os_str().is_empty() { String::new() } else { absolute(base_dir) },
        package_dirs: options.package_dirs.iter().map(|path| absolute(path)).collect(),
        floating_base: options.floating_base,
        merge_fixed_joints: options.merge_fixed_joints,
        self_collision: options.self_collision,
        srdf: options.srdf.as_deref().map(absolute),
        friction: options.friction,
        floor: options.floor,
        skip_missing_meshes: options.missing_meshes == MissingMeshes::Skip,
        decompose: options.decompose,
        visuals: options.visuals,
    }
}

/// The file of a model, read.
///
/// # Errors
/// [`FormatError::Unreadable`].
pub fn read_model_source(path: &Path, options: &LoadOptions) -> Result<ModelSource, FormatError> {
    let text = read_text(path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(model_source(&path.display().to_string(), &text, folder, options))
}

/// The model of a recording, from the text in its header and the files that this names, with the parameters that its run had.
///
/// Whether it is the same model is for its [hash](Header::model_hash) to tell.
///
/// # Errors
/// [`ReplayError::NoSource`], [`ReplayError::Model`], [`ReplayError::Simulation`] where changed parameters do not fit.
pub fn rebuild(header: &Header) -> Result<Model, ReplayError> {
    let source = header.source.as_ref();
    let source = source.ok_or_else(|| ReplayError::NoSource { model: header.model_name.clone() })?;
    let options = LoadOptions::default()
        .with_package_dirs(source.package_dirs.iter().map(PathBuf::from).collect())
        .with_floating_base(source.floating_base)
        .with_merge_fixed_joints(source.merge_fixed_joints)
        .with_self_collision(source.self_collision)
        .with_srdf(source.srdf.as_ref().map(PathBuf::from))
        .with_friction(source.friction)
        .with_floor(source.floor)
        .with_missing_meshes(if source.skip_missing_meshes { MissingMeshes::Skip } else { MissingMeshes::Stop })
        .with_decompose(source.decompose)
        .with_visuals(source.visuals);
    let imported = load_text(&source.text, Path::new(&source.base_dir), &options);
    let model = imported.map(|imported| imported.model).map_err(|error| ReplayError::Model(Box::new(error)))?;
    Ok(Arc::unwrap_or_clone(recorded_model(model, header)?))
}

/// Text in the format that its root element says.
fn load_text(text: &str, base: &Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    match load_mjcf_str_with(text, base, options) {
        Err(FormatError::UnknownFormat { found, .. }) if found == "robot" => load_urdf_str(text, base, options),
        Err(FormatError::UnknownFormat { found, .. }) if found == "sdf" => load_sdf_str(text, base, options),
        other => other,
    }
}
