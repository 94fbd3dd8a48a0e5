//! The solution of a contact problem.

use crate::ContactProblem;
use crate::outcome::{SolveReport, SolveStatus};
use crate::projection::Mode;
use crate::residuals::{Certificate, ResidualSpread};
use crate::stages::StageRun;

/// What a contact or friction group does in a solution. Directions are numbered as in the problem.
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
#[non_exhaustive]
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
    /// Impulses of the friction groups along their directions, N·s or N·m·s.
    pub group_alpha: Vec<f64>,
    /// Multipliers of the friction groups' bounds, m/s or rad/s.
    pub group_beta: Vec<f64>,
    /// Impulses (normal, tangent 1, tangent 2) of each contact: `(λ_N, D α)`, `[nc]`, N·s.
    pub impulse: Vec<[f64; 3]>,
    /// What each contact does, `[nc]`.
    pub modes: Vec<ContactMode>,
    /// Impulses `D α` of each friction group, N·s or N·m·s.
    pub group_impulse: Vec<[f64; 2]>,
    /// What each friction group does; open where its bound is 0.
    pub group_modes: Vec<ContactMode>,
    /// How the solve ended.
    pub status: SolveStatus,
    /// Residuals of the laws, computed from the data.
    pub certificate: Certificate,
    /// Where the residual of a solution is that was not [`Solved`](SolveStatus::Solved) because the solver's budget was used up.
    pub spread: Option<ResidualSpread>,
    /// What was done.
    pub report: SolveReport,
    /// What every stage did on every island, in order; empty unless `SolverSettings::record_history` asks for it.
    pub history: Vec<StageRun>,
    /// Pieces of the contacts, then of the friction groups.
    pub solver_modes: Vec<Mode>,
}

impl ContactSolution {
    /// Zero impulses of the right sizes, and a fresh report.
    pub fn prepare(&mut self, problem: &ContactProblem) {
        self.drop_impulses(problem);
        self.spread = None;
        self.report = SolveReport::default();
        self.history.clear();
        self.status = SolveStatus::Solved;
    }

    /// The same as [`prepare`](Self::prepare) where α, β and modes are recovered from the impulses later: of these only the sizes.
    pub fn begin(&mut self, problem: &ContactProblem) {
        let (nc, groups) = (problem.contact_count(), &problem.friction_groups);
        let of_contacts = [self.modes.len(), self.lambda_n.len(), self.beta.len()] == [nc; 3];
        let of_groups = [self.group_modes.len(), self.group_beta.len()] == [groups.len(); 2];
        let of_directions =
            [self.alpha.len(), self.group_alpha.len()] == [problem.direction_count(), groups.direction_count()];
        if !(of_contacts && of_groups && of_directions) {
            return self.prepare(problem);
        }
        self.velocity.clone_from(&problem.free_velocity);
        fill(&mut self.impulse, nc, [0.0; 3]);
        fill(&mut self.bilateral, problem.bilateral_violation.len(), 0.0);
        fill(&mut self.group_impulse, groups.len(), [0.0; 2]);
        fill(&mut self.solver_modes, nc + groups.len(), Mode::Open);
        self.spread = None;
        self.report = SolveReport::default();
        self.history.clear();
        self.status = SolveStatus::Solved;
    }

    /// Zero impulses of the right sizes, and the velocity without them.
    pub fn drop_impulses(&mut self, problem: &ContactProblem) {
        let (nc, groups) = (problem.contact_count(), &problem.friction_groups);
        self.velocity.clone_from(&problem.free_velocity);
        fill(&mut self.lambda_n, nc, 0.0);
        fill(&mut self.alpha, problem.direction_count(), 0.0);
        fill(&mut self.beta, nc, 0.0);
        fill(&mut self.bilateral, problem.bilateral_violation.len(), 0.0);
        fill(&mut self.group_alpha, groups.direction_count(), 0.0);
        fill(&mut self.group_beta, groups.len(), 0.0);
        fill(&mut self.group_impulse, groups.len(), [0.0; 2]);
        fill(&mut self.group_modes, groups.len(), ContactMode::Open);
        fill(&mut self.impulse, nc, [0.0; 3]);
        fill(&mut self.modes, nc, ContactMode::Open);
        fill(&mut self.solver_modes, nc + groups.len(), Mode::Open);
    }

    /// Takes the impulse and the piece of unit `i`: a contact, or a friction group counted after the contacts.
    pub fn take_unit(&mut self, i: usize, impulse: [f64; 3], mode: Mode) {
        match i.checked_sub(self.impulse.len()) {
            None => self.impulse[i] = impulse,
            Some(j) => self.group_impulse[j] = [impulse[1], impulse[2]],
        }
        self.solver_modes[i] = mode;
    }

    /// Copies what a [`WarmStart`](crate::WarmStart) is made from: impulses and modes.
    pub fn copy_warm_part(&mut self, other: &Self) {
        self.impulse.clone_from(&other.impulse);
        self.solver_modes.clone_from(&other.solver_modes);
        self.bilateral.clone_from(&other.bilateral);
        self.group_impulse.clone_from(&other.group_impulse);
    }

    /// Multiplies the impulses of the [warm part](Self::copy_warm_part), as another Δt asks for.
    pub fn scale_warm_part(&mut self, factor: f64) {
        self.impulse.iter_mut().flatten().for_each(|p| *p *= factor);
        self.group_impulse.iter_mut().flatten().for_each(|p| *p *= factor);
        self.bilateral.iter_mut().for_each(|p| *p *= factor);
    }

    /// Empties the [warm part](Self::copy_warm_part) and keeps the memory.
    pub fn clear_warm_part(&mut self) {
        self.impulse.clear();
        self.solver_modes.clear();
        self.bilateral.clear();
        self.group_impulse.clear();
    }

    /// Appends the [warm part](Self::copy_warm_part) as plain numbers, so that a state can be stored with it: the numbers
    /// of contacts, of friction groups and of bilateral rows, then for each contact its impulse (3) and mode (1), for each
    /// group its impulse (2) and mode (1), then the bilateral impulses.
    pub fn write_warm_part(&self, numbers: &mut Vec<f64>) {
        let (contacts, groups) = (self.impulse.len(), self.group_impulse.len());
        numbers.extend([contacts as f64, groups as f64, self.bilateral.len() as f64]);
        for (impulse, mode) in self.impulse.iter().zip(&self.solver_modes) {
            numbers.extend(impulse);
            numbers.push(f64::from(mode.code()));
        }
        for (impulse, mode) in self.group_impulse.iter().zip(&self.solver_modes[contacts..]) {
            numbers.extend(impulse);
            numbers.push(f64::from(mode.code()));
        }
        numbers.extend(&self.bilateral);
    }

    /// Reads what [`write_warm_part`](Self::write_warm_part) wrote; `None`, and no change, if it is not that.
    pub fn read_warm_part(&mut self, numbers: &[f64]) -> Option<()> {
        let (&[contacts, groups, bilateral], rest) = numbers.split_first_chunk()?;
        let (contacts, groups, bilateral) = (whole(contacts)?, whole(groups)?, whole(bilateral)?);
        let expected = contacts.checked_mul(4)?.checked_add(groups.checked_mul(3)?)?.checked_add(bilateral)?;
        if rest.len() != expected || rest.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let (entries, rest) = rest.split_at(4 * contacts);
        let (group_entries, multipliers) = rest.split_at(3 * groups);
        let mode = |x: f64| Mode::from_code(whole(x)?.try_into().ok()?);
        let modes =
            entries.chunks_exact(4).map(|e| mode(e[3])).chain(group_entries.chunks_exact(3).map(|e| mode(e[2])));
        self.solver_modes = modes.collect::<Option<_>>()?;
        self.impulse = entries.chunks_exact(4).map(|e| [e[0], e[1], e[2]]).collect();
        self.group_impulse = group_entries.chunks_exact(3).map(|e| [e[0], e[1]]).collect();
        self.bilateral = multipliers.to_vec();
        Some(())
    }

    /// `z = (λ_N, α, α_F, β, β_F)` of the standard LCP (formulation §4; F: friction groups).
    pub fn z(&self) -> Vec<f64> {
        let impulses = self.lambda_n.iter().chain(&self.alpha).chain(&self.group_alpha);
        impulses.chain(&self.beta).chain(&self.group_beta).copied().collect()
    }
}

/// Makes all entries the same, and as many as asked for. A list of the right length, as from step to step, stays in place.
fn fill<T: Copy>(x: &mut Vec<T>, count: usize, value: T) {
    if x.len() == count {
        return x.iter_mut().for_each(|x| *x = value);
    }
    x.clear();
    x.resize(count, value);
}

/// A number as an index, if it is a whole one.
fn whole(x: f64) -> Option<usize> {
    (x >= 0.0 && x.fract() == 0.0 && x < 1e9).then_some(x as usize)
}
