//! Certificates and reports as Python keeps them in a pickle.

use pyo3::prelude::*;
use signorini::contact;

use super::{Certificate, StepReport};

/// The residuals of a certificate, in the order of its attributes.
type Residuals = [f64; 6];

#[pymethods]
impl Certificate {
    #[staticmethod]
    fn _of(residuals: Residuals) -> Self {
        Self(certificate_of(residuals))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Residuals,))> {
        Ok((slf.get_type().getattr("_of")?, (residuals_of(&slf.get().0),)))
    }
}

fn residuals_of(c: &contact::Certificate) -> Residuals {
    [c.momentum, c.natural_map, c.signorini, c.friction, c.dissipation, c.bilateral]
}

fn certificate_of(
    [momentum, natural_map, signorini, friction, dissipation, bilateral]: Residuals,
) -> contact::Certificate {
    let mut c = contact::Certificate::default();
    (c.momentum, c.natural_map, c.signorini) = (momentum, natural_map, signorini);
    (c.friction, c.dissipation, c.bilateral) = (friction, dissipation, bilateral);
    c
}

/// What a pickle has of a report: status, contacts to blame, residuals, whether they exceed the tolerance, the row that lacks most, and the mean.
type SavedVerdict = (String, Vec<usize>, Residuals, bool, Option<(String, usize)>, Option<f64>);

/// Its counts: contacts, iterations, islands, those of Lemke's method, sweeps, points left out, enlargements.
type SavedWork = (usize, u32, usize, u32, u32, usize, u32);

/// θ, what was kept, the work of corrections, and whether gaps were clipped.
type SavedCorrections = (f64, Vec<(String, usize, f64)>, f64, bool);

/// All of it, with the stages' counts and times.
type SavedReport = (SavedVerdict, SavedWork, SavedCorrections, Vec<[u64; 3]>);

#[pymethods]
impl StepReport {
    #[staticmethod]
    fn _of(verdict: SavedVerdict, work: SavedWork, corrections: SavedCorrections, stages: Vec<[u64; 3]>) -> Self {
        let (status, blamed, certificate, missed_tolerance, worst_row, residual_rms) = verdict;
        let (contacts, iterations, islands, lemke_islands, sweeps, left_out, enlargements) = work;
        let (theta, kept, correction_energy, clipped_gaps) = corrections;
        let mut counts = contact::StageCounts::default();
        for (stage, [asked, ended, nanoseconds]) in contact::StageKind::ALL.into_iter().zip(stages) {
            let count = &mut counts[stage];
            (count.asked, count.ended, count.nanoseconds) = (asked, ended, nanoseconds);
        }
        Self {
            status,
            blamed,
            certificate: Certificate(certificate_of(certificate)),
            contacts,
            iterations,
            islands,
            lemke_islands,
            sweeps,
            worst_row,
            residual_rms,
            missed_tolerance,
            theta,
            kept,
            correction_energy,
            left_out,
            clipped_gaps,
            enlargements,
            stages: counts,
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, SavedReport)> {
        let s = slf.get().clone();
        let certificate = residuals_of(&s.certificate.0);
        let verdict = (s.status, s.blamed, certificate, s.missed_tolerance, s.worst_row, s.residual_rms);
        let work = (s.contacts, s.iterations, s.islands, s.lemke_islands, s.sweeps, s.left_out, s.enlargements);
        let corrections = (s.theta, s.kept, s.correction_energy, s.clipped_gaps);
        let stages = s.stages.iter().map(|(_, count)| [count.asked, count.ended, count.nanoseconds]).collect();
        Ok((slf.get_type().getattr("_of")?, (verdict, work, corrections, stages)))
    }
}
