//! What the commands find out, as plain data. Serialised as they are, these structs are the `--json` output.

mod comparison;
mod contradiction;
mod export;
mod file_name;
mod inspection;
mod recording;
mod run;
mod solving;
mod stability;
mod stages;

pub use comparison::{Comparison, Row};
pub use contradiction::{Contradiction, Involved, Place};
pub use export::Exported;
pub use file_name::FileName;
pub use inspection::{BodyLine, Inspection};
pub use recording::{RecordingResult, ending};
pub use run::{Budget, Miss, Range, RunResult, RunStatus, Unfinished};
pub use solving::{CheckResult, DenialProof, Distributions, Ending, LeastNormResult, SolveResult, solve_status};
pub use stability::{CriticalLine, SafetyResult, StabilityResult};
pub use stages::{StageHistory, StageLine};

use serde::Serialize;
use signorini::contact::{Certificate, RelaxationCertificate};
use signorini::formats::{ImportReport, Warning};

/// Residuals of the laws (formulation §8); those that a kind of problem does not have are left out.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Laws {
    /// Momentum balance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub momentum: Option<f64>,
    /// Natural map of the complementarity problem.
    pub natural_map: f64,
    /// Signorini's condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signorini: Option<f64>,
    /// Friction bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Maximum dissipation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dissipation: Option<f64>,
    /// Bilateral rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bilateral: Option<f64>,
    /// Impulses against the multipliers of a relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impulses: Option<f64>,
}

impl Laws {
    /// The laws of a contact problem, whatever the law of friction; `bilateral` says whether it has bilateral rows.
    pub fn of_contacts(certificate: &Certificate, bilateral: bool) -> Self {
        Self {
            momentum: Some(certificate.momentum),
            natural_map: certificate.natural_map,
            signorini: Some(certificate.signorini),
            friction: Some(certificate.friction),
            dissipation: Some(certificate.dissipation),
            bilateral: bilateral.then_some(certificate.bilateral),
            impulses: None,
        }
    }

    /// The laws of the convex relaxation.
    pub fn of_relaxation(certificate: &RelaxationCertificate, bilateral: bool) -> Self {
        Self {
            momentum: Some(certificate.momentum),
            natural_map: certificate.natural_map,
            impulses: Some(certificate.impulses),
            bilateral: bilateral.then_some(certificate.bilateral),
            ..Self::default()
        }
    }

    /// The laws of a frictional problem in impulse space, which has no velocity of its own to balance.
    pub fn of_friction(certificate: &Certificate) -> Self {
        Self { momentum: None, ..Self::of_contacts(certificate, false) }
    }

    /// A plain complementarity problem has the natural map alone.
    pub fn natural_map(natural_map: f64) -> Self {
        Self { natural_map, ..Self::default() }
    }

    /// Those of a list by name.
    pub fn named(list: &[(&str, f64)]) -> Self {
        let of = |law: &str| list.iter().find(|(name, _)| *name == law).map(|(_, residual)| *residual);
        Self {
            momentum: of("momentum"),
            natural_map: of("natural_map").unwrap_or(0.0),
            signorini: of("signorini"),
            friction: of("friction"),
            dissipation: of("dissipation"),
            bilateral: of("bilateral"),
            impulses: of("impulses"),
        }
    }

    /// The laws that there are, by name.
    pub fn list(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = [
            ("momentum", self.momentum),
            ("natural_map", Some(self.natural_map)),
            ("signorini", self.signorini),
            ("friction", self.friction),
            ("dissipation", self.dissipation),
            ("bilateral", self.bilateral),
            ("impulses", self.impulses),
        ];
        all.into_iter().filter_map(|(name, residual)| Some((name, residual?)))
    }

    /// The law that is violated most, and its residual; NaN counts as infinite.
    pub fn worst(&self) -> (&'static str, f64) {
        let finite = |(name, r): (_, f64)| (name, if r.is_nan() { f64::INFINITY } else { r });
        self.list().map(finite).fold(("natural_map", 0.0), |worst, law| if law.1 > worst.1 { law } else { worst })
    }
}

/// A line of the import report.
#[derive(Clone, Debug, Serialize)]
pub struct ImportWarning {
    /// File.
    pub file: String,
    /// Line of the first place, from 1.
    pub line: u32,
    /// Element.
    pub element: String,
    /// What is not taken over.
    pub what: String,
    /// What that changes.
    pub effect: String,
    /// Number of places.
    pub count: usize,
    /// Whether the motion can differ because of it.
    pub changes_motion: bool,
    /// The whole line for people.
    #[serde(skip)]
    pub text: String,
}

impl From<&Warning> for ImportWarning {
    fn from(warning: &Warning) -> Self {
        Self {
            file: warning.file.clone(),
            line: warning.line,
            element: warning.element.clone(),
            what: warning.what.clone(),
            effect: warning.effect.clone(),
            count: warning.count,
            changes_motion: warning.changes_motion,
            text: warning.to_string(),
        }
    }
}

/// The lines of an import report.
pub fn import_warnings(report: &ImportReport) -> Vec<ImportWarning> {
    report.warnings.iter().map(ImportWarning::from).collect()
}
