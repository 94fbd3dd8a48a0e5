//! Errors of the crates below as the package's exceptions (`python/signorini/errors.py`).

use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use signorini::SimulationError;
use signorini::contact::ProblemError as ContactProblemError;
use signorini::formats::FormatError;
use signorini::lcp::LcpError;
use signorini::multibody::FreeMotionError;
use signorini::recording::RecordingError as RecordingFault;
use signorini::spec::SpecError;
use signorini_replay::ReplayError;

pyo3::import_exception!(signorini.errors, BatchError);
pyo3::import_exception!(signorini.errors, ModelError);
pyo3::import_exception!(signorini.errors, ProblemError);
pyo3::import_exception!(signorini.errors, RecordingError);
pyo3::import_exception!(signorini.errors, SettingError);
pyo3::import_exception!(signorini.errors, SolveError);
pyo3::import_exception!(signorini.errors, StateError);

/// A model file that cannot be read.
pub fn format_error(error: FormatError) -> PyErr {
    use FormatError as E;
    let message = error.to_string();
    if let E::Unreadable { path, .. } = &error {
        return ModelError::new_err((message, path.display().to_string()));
    }
    let Some(at) = error.location() else { return ModelError::new_err(message) };
    ModelError::new_err((message, at.file.to_string(), at.line, at.column))
}

/// A simulation that cannot be set up or cannot go on.
pub fn simulation_error(error: SimulationError) -> PyErr {
    use SimulationError as E;
    let message = match &error {
        // The engine names its own function.
        E::WarmStart { found } => format!(
            "the last {found} numbers of the state are not a warm start: pass what get_state gave for this model, unchanged"
        ),
        error => error.to_string(),
    };
    match error {
        E::Memory { .. } => PyMemoryError::new_err(message),
        E::Setting { .. } | E::UnboundedMotor { .. } => SettingError::new_err(message),
        E::Collision(_) | E::Model(_) => ModelError::new_err(message),
        E::State(_) | E::FreeMotion(FreeMotionError::State(_)) | E::WarmStart { .. } => StateError::new_err(message),
        E::FreeMotion(_) => SolveError::new_err(message),
        E::Diverged { .. } => SolveError::new_err((message, "diverged")),
        E::NotSettled { .. } => SolveError::new_err((message, "not_settled")),
        _ => ProblemError::new_err(message),
    }
}

/// An edit that cannot be made, or a spec that is no mechanism.
pub fn spec_error(error: SpecError) -> PyErr {
    ModelError::new_err(error.to_string())
}

/// A malformed contact problem.
pub fn problem_error(error: ContactProblemError) -> PyErr {
    ProblemError::new_err(error.to_string())
}

/// A malformed complementarity problem, or a method that does not exist.
pub fn lcp_error(error: LcpError) -> PyErr {
    match error {
        LcpError::UnknownMethod { .. } | LcpError::Setting { .. } => SettingError::new_err(error.to_string()),
        _ => ProblemError::new_err(error.to_string()),
    }
}

/// A recording that cannot be written or read.
pub fn recording_error(error: RecordingFault) -> PyErr {
    RecordingError::new_err(error.to_string())
}

/// A recording that cannot be checked or exported.
pub fn replay_error(error: ReplayError) -> PyErr {
    match error {
        ReplayError::Recording(fault) => recording_error(fault),
        ReplayError::Model(fault) => format_error(*fault),
        other => RecordingError::new_err(other.to_string()),
    }
}
