//! From arguments to a simulation that is ready to step.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use signorini::formats::{ImportReport, LoadOptions, MissingMeshes, load, load_mjcf_str_with};
use signorini::multibody::Model;
use signorini::recording::{ModelSource, is_recording};
use signorini::{Settings, SettleSettings, Simulation};
use signorini_replay::{model_source, read_model_source};

use crate::args::{MissingMeshArgument, ModelArguments, StartArguments};
use crate::error::CliError;
use crate::{output, scene, text};

/// A model with where it comes from.
#[derive(Debug)]
pub struct Loaded {
    /// The model.
    pub model: Arc<Model>,
    /// File, or `scenes/NAME.xml` for a bundled scene.
    pub source: String,
    /// What the import left out.
    pub report: ImportReport,
    /// The keyframe to start from where none is asked for.
    pub first_keyframe: Option<String>,
    /// The model's file, for recordings.
    pub file: ModelSource,
}

impl Loaded {
    /// Lines for the summary of a report: the source, and what was left out.
    pub fn notes(&self) -> Vec<(String, String)> {
        let left_out = self.report.warnings.iter().map(|w| ("left out".to_owned(), w.to_string()));
        std::iter::once(("model file".to_owned(), self.source.clone())).chain(left_out).collect()
    }
}

/// Reads the model file or bundled scene.
pub fn load_model(arguments: &ModelArguments) -> Result<Loaded, CliError> {
    let options = LoadOptions::default()
        .with_package_dirs(arguments.package_dir.clone())
        .with_floating_base(arguments.floating_base)
        .with_friction(arguments.friction)
        .with_floor(arguments.floor)
        .with_missing_meshes(match arguments.missing_meshes {
            MissingMeshArgument::Stop => MissingMeshes::Stop,
            MissingMeshArgument::Skip => MissingMeshes::Skip,
        })
        .with_decompose(arguments.decompose);
    if let Some(path) = &arguments.model {
        let imported = load(path, &options).map_err(|error| match is_recording(path) {
            Ok(true) => CliError::NoModel { path: path.clone() },
            _ => error.into(),
        })?;
        let source = path.display().to_string();
        let file = read_model_source(path, &options)?;
        return Ok(Loaded {
            model: Arc::new(imported.model),
            source,
            report: imported.report,
            first_keyframe: None,
            file,
        });
    }
    let scene = scene::named(arguments.scene.as_deref().unwrap_or(scene::DEFAULT))?;
    let mut imported = load_mjcf_str_with(scene.text, Path::new(""), &options)?;
    let source = format!("scenes/{}.xml", scene.name);
    imported.report.warnings.iter_mut().for_each(|warning| warning.file.clone_from(&source));
    let first_keyframe = imported.model.keyframes.first().map(|keyframe| keyframe.name.clone());
    let file = model_source(&source, scene.text, Path::new(""), &options);
    Ok(Loaded { model: Arc::new(imported.model), source, report: imported.report, first_keyframe, file })
}

/// A simulation in the state asked for.
pub fn start(loaded: &Loaded, start: &StartArguments, settings: Settings) -> Result<Simulation, CliError> {
    let mut simulation = Simulation::new(Arc::clone(&loaded.model), settings)?;
    if let Some(keyframe) = start.keyframe.as_ref().or(loaded.first_keyframe.as_ref()) {
        simulation.reset_to(keyframe)?;
    }
    if !start.assignments.is_empty() {
        let mut state = simulation.state().clone();
        start.assignments.iter().try_for_each(|assignment| assignment.apply(&loaded.model, &mut state))?;
        state.check(&loaded.model).map_err(CliError::State)?;
        simulation.set_state(&state)?;
    }
    let violation = simulation.constraint_violation();
    if violation > simulation.settings().assembly_tolerance {
        let left = simulation.assemble()?;
        eprintln!("note: the start violated equality constraints by up to {violation:.1e}; it was moved to {left:.1e}");
    }
    if start.settle {
        let spinner = output::spinner();
        let report = simulation.settle_while(&SettleSettings::default(), |progress| {
            spinner.set_message(text::settling(progress));
            spinner.tick();
            ControlFlow::Continue(())
        });
        spinner.finish_and_clear();
        let report = report?;
        eprintln!("note: {}", text::settled(&report));
    }
    Ok(simulation)
}
