//! How a step went: the certificate and the solver's report.

mod saving;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use signorini::contact;
use signorini::contact::SolveStatus;

/// Residuals of the laws of one step or solve; each is 0 for an exact solution, without unit (formulation §8).
#[pyclass(frozen, module = "signorini")]
#[derive(Clone, Copy)]
pub struct Certificate(pub contact::Certificate);

#[pymethods]
impl Certificate {
    /// Momentum balance of the claimed velocity and impulses.
    #[getter]
    fn momentum(&self) -> f64 {
        self.0.momentum
    }

    /// Natural map of the LCP in one unit.
    #[getter]
    fn natural_map(&self) -> f64 {
        self.0.natural_map
    }

    /// Signorini's condition.
    #[getter]
    fn signorini(&self) -> f64 {
        self.0.signorini
    }

    /// Friction bound in the polygon's gauge.
    #[getter]
    fn friction(&self) -> f64 {
        self.0.friction
    }

    /// Maximum dissipation: distance from the linear program's minimum.
    #[getter]
    fn dissipation(&self) -> f64 {
        self.0.dissipation
    }

    /// Bilateral rows.
    #[getter]
    fn bilateral(&self) -> f64 {
        self.0.bilateral
    }

    /// The largest residual.
    #[getter]
    fn worst(&self) -> f64 {
        self.0.worst()
    }

    /// Whether every law holds within `tolerance`.
    #[pyo3(signature = (tolerance=1e-9))]
    fn holds(&self, tolerance: f64) -> bool {
        self.0.holds(tolerance)
    }

    fn _repr_html_(&self) -> String {
        let c = &self.0;
        let laws = [
            ("momentum", c.momentum),
            ("natural map", c.natural_map),
            ("Signorini", c.signorini),
            ("friction", c.friction),
            ("dissipation", c.dissipation),
            ("bilateral", c.bilateral),
        ];
        let row = |(law, residual)| format!("<tr><td>{law}</td><td>{residual:.1e}</td></tr>");
        let rows: String = laws.into_iter().map(row).collect();
        format!("<b>signorini.Certificate</b>, worst residual {:.1e}<table>{rows}</table>", c.worst())
    }

    fn __repr__(&self) -> String {
        let c = &self.0;
        format!(
            "Certificate(momentum={:.1e}, natural_map={:.1e}, signorini={:.1e}, friction={:.1e}, dissipation={:.1e}, \
             bilateral={:.1e})",
            c.momentum, c.natural_map, c.signorini, c.friction, c.dissipation, c.bilateral
        )
    }
}

/// What a stage of the structured solver did.
#[pyclass(frozen, get_all, module = "signorini")]
#[derive(Clone)]
pub struct StageCount {
    /// How often it was asked: once for each island that came to it.
    asked: u64,
    /// How often it ended an island: by a solution, or by the proof that there is none.
    ended: u64,
    /// Its part of the time of all stages; None where times were not measured.
    time_share: Option<f64>,
}

#[pymethods]
impl StageCount {
    fn __repr__(&self) -> String {
        let share = self.time_share.map_or(String::new(), |share| format!(", time_share={share:.3}"));
        format!("StageCount(asked={}, ended={}{share})", self.asked, self.ended)
    }
}

/// What the stages did that were asked, by name, in the order of the cascade.
pub fn stages_dict<'py>(py: Python<'py>, counts: &contact::StageCounts) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (stage, count) in counts.iter().filter(|(_, count)| count.asked > 0) {
        let (asked, ended, time_share) = (count.asked, count.ended, counts.time_share(stage));
        dict.set_item(stage.name(), StageCount { asked, ended, time_share }.into_pyobject(py)?)?;
    }
    Ok(dict)
}

/// What a stage of the structured solver did on an island.
#[pyclass(frozen, get_all, module = "signorini")]
#[derive(Clone)]
pub struct StageRun {
    /// The island, by the order of the first tree in each.
    island: u32,
    /// The stage's name.
    stage: &'static str,
    /// Why it ended.
    outcome: &'static str,
    /// What the laws lacked after each proximal iteration, relative to the island's velocity scale.
    residuals: Vec<f64>,
}

impl From<&contact::StageRun> for StageRun {
    fn from(run: &contact::StageRun) -> Self {
        Self {
            island: run.island,
            stage: run.stage.name(),
            outcome: run.outcome.name(),
            residuals: run.residuals.clone(),
        }
    }
}

#[pymethods]
impl StageRun {
    fn __repr__(&self) -> String {
        let Self { island, stage, outcome, residuals } = self;
        format!("<signorini.StageRun {stage} of island {island}: {outcome}, {} residuals>", residuals.len())
    }
}

/// What the last step did.
#[pyclass(frozen, module = "signorini")]
#[derive(Clone)]
pub struct StepReport {
    /// "solved", "inaccurate", "unresolved", "infeasible", "iteration_limit".
    #[pyo3(get)]
    status: String,
    /// Contacts that contradict each other, where the status says so; indices into the problem.
    #[pyo3(get)]
    blamed: Vec<usize>,
    /// Residuals of the step.
    #[pyo3(get)]
    certificate: Certificate,
    /// Contacts in the problem, joint limits included.
    #[pyo3(get)]
    contacts: usize,
    /// Mode changes, proximal iterations and pivots together.
    #[pyo3(get)]
    iterations: u32,
    /// Islands: sets of trees that contacts tie together.
    #[pyo3(get)]
    islands: usize,
    /// Islands that were given to Lemke's method.
    #[pyo3(get)]
    lemke_islands: u32,
    /// Contact sweeps.
    #[pyo3(get)]
    sweeps: u32,
    /// Where the budget was used up: the row that lacks most, ("contact", "group" or "bilateral", its index in the problem).
    #[pyo3(get)]
    worst_row: Option<(String, usize)>,
    /// Where the budget was used up: root mean square of what the rows lack, relative to the velocity scale.
    #[pyo3(get)]
    residual_rms: Option<f64>,
    /// Whether the worst residual exceeds the tolerance.
    #[pyo3(get)]
    missed_tolerance: bool,
    /// Part θ of the overlaps and violations asked for that the step removes: 1 where it is all of them.
    #[pyo3(get)]
    theta: f64,
    /// What was kept where `theta` is less than 1: ("contact" or "bilateral", index of the row in the problem, m or rad).
    #[pyo3(get)]
    kept: Vec<(String, usize, f64)>,
    /// Work of the impulses along the corrections, J.
    #[pyo3(get)]
    correction_energy: f64,
    /// Contact points that no degree of freedom moves along their normal; they are not in the problem.
    #[pyo3(get)]
    left_out: usize,
    /// Whether negative gaps were taken as zero.
    #[pyo3(get)]
    clipped_gaps: bool,
    /// How often contacts were found anew because a body moved farther than expected.
    #[pyo3(get)]
    enlargements: u32,
    stages: contact::StageCounts,
}

impl StepReport {
    pub fn new(report: &signorini::StepReport) -> Self {
        Self {
            status: status_of(&report.status),
            blamed: contacts_of(&report.status).to_vec(),
            certificate: Certificate(report.certificate),
            contacts: report.contacts,
            iterations: report.solver.iterations(),
            islands: report.solver.islands,
            lemke_islands: report.solver.lemke_islands,
            sweeps: report.solver.sweeps,
            worst_row: report.spread.map(|spread| lacking_row(spread.worst_row)),
            residual_rms: report.spread.map(|spread| spread.rms),
            missed_tolerance: report.missed_tolerance,
            theta: report.theta,
            kept: report.kept.iter().map(kept_row).collect(),
            correction_energy: report.correction_energy,
            left_out: report.left_out,
            clipped_gaps: report.clipped_gaps,
            enlargements: report.enlargements,
            stages: report.solver.stages,
        }
    }
}

fn lacking_row(row: contact::LackingRow) -> (String, usize) {
    let (kind, index) = match row {
        contact::LackingRow::Contact(i) => ("contact", i),
        contact::LackingRow::FrictionGroup(j) => ("group", j),
        contact::LackingRow::Bilateral(k) => ("bilateral", k),
    };
    (kind.to_owned(), index)
}

fn kept_row(kept: &signorini::Kept) -> (String, usize, f64) {
    let (kind, index) = match kept.row {
        signorini::KeptRow::Contact(i) => ("contact", i),
        signorini::KeptRow::Bilateral(k) => ("bilateral", k),
    };
    (kind.to_owned(), index, kept.size)
}

#[pymethods]
impl StepReport {
    /// What the structured solver's stages did, those that were asked, by name in the order of the cascade.
    #[getter]
    fn stages<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        stages_dict(py, &self.stages)
    }

    fn __repr__(&self) -> String {
        format!(
            "<signorini.StepReport {}: {} contacts, {} iterations, worst residual {:.1e}>",
            self.status,
            self.contacts,
            self.iterations,
            self.certificate.0.worst()
        )
    }
}

/// How a state was brought to rest.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct SettleReport {
    /// Steps towards rest; 0 where the state rested.
    steps: u32,
    /// Factorisations in them; 0 where the state rested.
    factorizations: u64,
    /// The ordinary step that ended where it began.
    at_rest: StepReport,
    /// Largest entry of the velocity before and after it, m/s or rad/s: zero, or rounding where springs or servos hold a load.
    speed: f64,
}

impl SettleReport {
    pub fn new(report: &signorini::SettleReport) -> Self {
        let signorini::SettleReport { steps, factorizations, ref at_rest, speed, .. } = *report;
        Self { steps, factorizations, at_rest: StepReport::new(at_rest), speed }
    }
}

#[pymethods]
impl SettleReport {
    fn __repr__(&self) -> String {
        let StepReport { contacts, certificate, .. } = &self.at_rest;
        let worst = certificate.0.worst();
        format!(
            "<signorini.SettleReport {} steps: at rest on {contacts} contacts, worst residual {worst:.1e}>",
            self.steps
        )
    }
}

/// The contacts that a status blames.
pub fn contacts_of(status: &SolveStatus) -> &[usize] {
    match status {
        SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts } => contacts,
        _ => &[],
    }
}

/// The name of a contact problem's status in Python's spelling; a ray is none of a verdict.
pub fn status_of(status: &SolveStatus) -> String {
    if matches!(status, SolveStatus::Ray { .. }) { "unresolved".into() } else { name_of(status) }
}

/// The name of an enum's variant in Python's spelling: `IterationLimit` is "iteration_limit".
pub fn name_of(variant: &impl std::fmt::Debug) -> String {
    let debug = format!("{variant:?}");
    let mut name = String::new();
    for c in debug.chars().take_while(|c| c.is_alphanumeric()) {
        if c.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(c.to_lowercase());
    }
    name
}
