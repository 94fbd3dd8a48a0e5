//! What `Recording.check` found.

use pyo3::prelude::*;
use signorini_replay as replay;

use crate::report::{Certificate, name_of};

/// What certifying the steps of a recording again found.
#[pyclass(frozen, module = "signorini")]
pub struct RecordingCheck {
    pub found: replay::RecordingCheck,
    pub tolerance: f64,
}

#[pymethods]
impl RecordingCheck {
    /// Whether there are steps and every law holds in all of them.
    #[getter]
    fn ok(&self) -> bool {
        self.found.holds()
    }

    /// Steps certified.
    #[getter]
    fn steps(&self) -> usize {
        self.found.certified
    }

    /// "polygon" or "circular_cone": the law of friction of the certificates.
    #[getter]
    fn law(&self) -> String {
        name_of(&self.found.law)
    }

    /// Largest residual of each law.
    #[getter]
    fn worst(&self) -> Certificate {
        Certificate(self.found.worst)
    }

    /// The step with the largest residual.
    #[getter]
    fn worst_step(&self) -> u64 {
        self.found.worst_step
    }

    /// Number of steps that do not hold.
    #[getter]
    fn violated(&self) -> usize {
        self.found.violated
    }

    /// The first of them: step, time in s, and what is wrong.
    #[getter]
    fn violations(&self) -> Vec<(u64, f64, String)> {
        let words = |violation: &replay::Violation| {
            let residual = violation.residual.map(|r| format!("residual {r:.1e}"));
            let fault = violation.fault.as_ref().map(ToString::to_string);
            let what = [residual, fault].into_iter().flatten().collect::<Vec<_>>().join("; ");
            (violation.step, violation.time, what)
        };
        self.found.violations.iter().map(words).collect()
    }

    /// Steps that do not begin where the one before ended: the state was set from outside.
    #[getter]
    fn restarts(&self) -> Vec<u64> {
        self.found.restarts.clone()
    }

    fn __bool__(&self) -> bool {
        self.found.holds()
    }

    fn __repr__(&self) -> String {
        let verdict = if self.found.holds() { "every law holds" } else { "VIOLATED" };
        format!(
            "<signorini.RecordingCheck {verdict}: {} steps, {} violated, worst residual {:.1e} (tolerance {:e})>",
            self.found.certified,
            self.found.violated,
            self.found.worst.worst(),
            self.tolerance
        )
    }
}
