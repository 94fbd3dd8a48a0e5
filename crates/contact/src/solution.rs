//! The solution of a contact problem.

use crate::ContactProblem;
use crate::certificate::Certificate;
use crate::solver::{Mode, SolveReport, SolveStatus};

/// What a contact does in a solution. Directions are numbered as in the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactMode {
    /// No impulse.
    #[default]
    Open,
    /// Closed without friction.
    Frictionless,
    /// Closed, impulse inside the friction cone.
    Sticking,
    /// Slides; the friction impulse is at direction `k`.
    Sliding {
        /// The direction.
        k: u32,
    },
    /// Slides; the friction impulse is on the edge between two directions.
    SlidingBetween {
        /// One direction.
        j: u32,
        /// The next one.
        k: u32,
    },
}

/// Velocity and impulses of one step, with their certificate.
#[derive(Clone, Debug, Default)]
pub struct ContactSolution {
    /// Next velocity `v⁺`, `[nv]`, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Normal impulses `λ_N`, `[nc]`, N·s.
    pub lambda_n: Vec<f64>,
    /// Impulses along the directions `α`, `[m]`, N·s; `λ_T = D α`.
    pub alpha: Vec<f64>,
    /// Multipliers of the friction bounds `β`, `[nc]`, m/s.
    pub beta: Vec<f64>,
    /// Impulses of the bilateral rows `λ_B`, `[nb]`, N·s or N·m·s.
    pub bilateral: Vec<f64>,
    /// Impulses (normal, tangent 1, tangent 2) of each contact: `(λ_N, D α)`, `[nc]`, N·s.
    pub impulse: Vec<[f64; 3]>,
    /// What each contact does, `[nc]`.
    pub modes: Vec<ContactMode>,
    /// How the solve ended.
    pub status: SolveStatus,
    /// Residuals of the laws, computed from the data.
    pub certificate: Certificate,
    /// What was done.
    pub report: SolveReport,
    pub(crate) solver_modes: Vec<Mode>,
}

impl ContactSolution {
    /// Zero impulses of the right sizes, and a fresh report.
    pub(crate) fn prepare(&mut self, problem: &ContactProblem) {
        self.drop_impulses(problem);
        self.report = SolveReport::default();
        self.status = SolveStatus::Solved;
    }

    /// Zero impulses of the right sizes, and the velocity without them.
    pub(crate) fn drop_impulses(&mut self, problem: &ContactProblem) {
        let nc = problem.contact_count();
        let zero = |x: &mut Vec<f64>, n| {
            x.clear();
            x.resize(n, 0.0);
        };
        self.velocity.clone_from(&problem.free_velocity);
        zero(&mut self.lambda_n, nc);
        zero(&mut self.alpha, problem.direction_count());
        zero(&mut self.beta, nc);
        zero(&mut self.bilateral, problem.bilateral_violation.len());
        self.impulse.clear();
        self.impulse.resize(nc, [0.0; 3]);
        self.modes.clear();
        self.modes.resize(nc, ContactMode::Open);
        self.solver_modes.clear();
        self.solver_modes.resize(nc, Mode::Open);
    }

    /// Copies what a [`WarmStart`](crate::WarmStart) is made from: impulses and modes.
    pub fn copy_warm_part(&mut self, other: &Self) {
        self.impulse.clone_from(&other.impulse);
        self.solver_modes.clone_from(&other.solver_modes);
        self.bilateral.clone_from(&other.bilateral);
    }

    /// Appends the [warm part](Self::copy_warm_part) as plain numbers, so that a state can be stored with it: the numbers
    /// of contacts and of bilateral rows, then for each contact its impulse (3) and mode (1), then the bilateral impulses.
    pub fn write_warm_part(&self, numbers: &mut Vec<f64>) {
        numbers.extend([self.impulse.len() as f64, self.bilateral.len() as f64]);
        for (impulse, mode) in self.impulse.iter().zip(&self.solver_modes) {
            numbers.extend(impulse);
            numbers.push(f64::from(mode.code()));
        }
        numbers.extend(&self.bilateral);
    }

    /// Reads what [`write_warm_part`](Self::write_warm_part) wrote; `None`, and no change, if it is not that.
    pub fn read_warm_part(&mut self, numbers: &[f64]) -> Option<()> {
        let (&[contacts, bilateral], rest) = numbers.split_first_chunk()?;
        let (contacts, bilateral) = (whole(contacts)?, whole(bilateral)?);
        if rest.len() != contacts.checked_mul(4)?.checked_add(bilateral)? || rest.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let (entries, multipliers) = rest.split_at(4 * contacts);
        let modes = entries.chunks_exact(4).map(|e| Mode::from_code(whole(e[3])?.try_into().ok()?));
        self.solver_modes = modes.collect::<Option<_>>()?;
        self.impulse = entries.chunks_exact(4).map(|e| [e[0], e[1], e[2]]).collect();
        self.bilateral = multipliers.to_vec();
        Some(())
    }

    /// `z = (λ_N, α, β)` of the standard LCP (formulation §4).
    pub fn z(&self) -> Vec<f64> {
        self.lambda_n.iter().chain(&self.alpha).chain(&self.beta).copied().collect()
    }
}

/// A number as an index, if it is a whole one.
fn whole(x: f64) -> Option<usize> {
    (x >= 0.0 && x.fract() == 0.0 && x < 1e9).then_some(x as usize)
}
