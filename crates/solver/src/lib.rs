//! The structured contact solver: exact, warm-started, with Lemke's method behind it.
//!
//! The cascade, island by island (one that starts warm and has few rows, as robots have, is first given to
//! [Newton's method in the space of impulses](impulse_newton)):
//! 1. proximal iterations from the warm start, a few Newton steps on the modes in each, then the [path](path); a small cold
//!    island begins with modes that [sweeps](sweeps) found, a large one that is far from its modes has an
//!    [interior start](interior_start), by the [central path](interior_path) where it needs that; a [proof](contradiction) that the gaps contradict each other ends the solve;
//! 2. the same from a cold start with other random shifts, a few times; in a large island from where an attempt ended if that is
//!    close to a solution, then from the ends of central paths that begin with opened contacts and at the associated law, and then
//!    twice patiently, from [block sweeps](block_sweeps) where nothing close was found, by paths that begin at the centre, and with an
//!    ε that stays near the one at which they turn back;
//! 3. lexicographic Lemke on the standard LCP ([`signorini_lcp::Lemke`]), which ends in a solution, or in a ray where the
//!    contacts wedge; what it leaves with a residual the proximal iterations go on from.
//!
//! A small island whose gaps are violated goes from its first attempt to the third stage.
//!
//! What was tried and why the solver moved on is in the [`SolveReport`].

mod attempts;
mod bilateral_basis;
mod block_sweeps;
mod breakpoint;
mod contradiction;
mod coupling;
mod fallback;
mod find_modes;
mod gathering;
mod given;
mod impulse_newton;
mod interior_control;
mod interior_path;
mod interior_series;
mod interior_start;
mod interior_step;
mod interior_unit;
mod island;
mod island_pool;
mod island_solver;
mod islands;
mod known_rows;
mod lcp_route;
mod lists;
mod motion;
mod path;
mod proximal;
mod settings;
mod sleep;
mod structure;
mod sweeps;
mod system;
mod verdict;
mod warm_start;
mod weight;

pub use bilateral_basis::BilateralBasis;
pub use island::Island;
pub use islands::Islands;
pub use lcp_route::solve_as_lcp;
pub use settings::SolverSettings;
pub use system::ProximalSystem;

use signorini_lcp::Lemke;

use attempts::{Start, closely_accepted};
use given::GivenStart;
use island_pool::IslandPool;
use signorini_contact::certificate::{Certificate, Scales, Scratch, certify_afresh, certify_with};
use signorini_contact::projection::Cones;
use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, ProblemError, SolveStatus, WarmStart};

/// What is left in islands that nothing more is to be done about.
const SETTLED: f64 = -1.0;
/// How often the iterations go on from what Lemke's method found, beyond the first time where at most so many tolerances are left,
/// and by how much the impulses differ between one time and the next.
const ROUNDINGS: u32 = 12;
const ROUNDED: f64 = 10.0;
const OTHER_DIGITS: f64 = 1e-9;

/// The structured contact solver with its memory.
#[derive(Debug, Default)]
pub struct ContactSolver {
    settings: SolverSettings,
    cones: Cones,
    islands: Islands,
    given: GivenStart,
    pool: IslandPool,
    /// The solution before a retry.
    earlier: ContactSolution,
    /// What the first two stages left in each island.
    residuals: Vec<f64>,
    /// Contacts of islands that contradict themselves.
    contradiction: Vec<usize>,
    scales: Scales,
    scratch: Scratch,
    lemke: Lemke,
}

impl ContactSolver {
    /// A solver with these settings.
    ///
    /// # Errors
    /// [`ProblemError::Number`] for a setting out of its range.
    pub fn new(settings: SolverSettings) -> Result<Self, ProblemError> {
        settings.validate()?;
        Ok(Self { settings, ..Self::default() })
    }

    /// The settings.
    pub fn settings(&self) -> &SolverSettings {
        &self.settings
    }

    /// Solves a problem into `solution`, whose memory is reused. The result has the same bits on any number of threads.
    ///
    /// `warm`: the start, if it has one entry per contact. The status is decided by the [certificate](crate::certify) of
    /// the result, and by how far its velocity is from that of its impulses along any row, never by the solver's own numbers.
    /// No allocation after warm-up where the first two stages reach the tolerance on one thread.
    pub fn solve_into(&mut self, problem: &ContactProblem, warm: Option<&WarmStart>, solution: &mut ContactSolution) {
        if !has_rows(problem) {
            return take_free_velocity(problem, solution);
        }
        self.cones.prepare(problem);
        if problem.friction_groups.bound.iter().any(|bound| matches!(bound, FrictionBound::Shifted { .. })) {
            self.solve_whole(problem, solution);
            return;
        }
        self.islands.find(problem);
        self.scales = Scales::new(problem, self.islands.delassus_scale(), self.islands.velocity_scale());
        solution.begin(problem);
        solution.report.islands = self.islands.all().len();
        self.residuals.clear();
        self.residuals.resize(self.islands.all().len(), f64::INFINITY);
        self.contradiction.clear();
        let is_given = warm.is_some_and(|warm| self.given.read(problem, &self.cones, &self.islands, warm));
        let any_held = is_given && !self.settings.sleeping && self.hold_islands(problem, solution);
        let mut certified = self.solve_from_start(problem, is_given, any_held, solution);
        if certified && self.is_resolved(problem, solution) {
            return;
        }
        if any_held && !certified {
            // What was solved would come out the same.
            self.given.let_go(&mut self.residuals);
            certified = self.solve_from_start(problem, is_given, false, solution);
        }
        if !certified && !self.contradiction.is_empty() {
            self.drop_what_is_worse(problem, solution);
            self.contradiction.sort_unstable();
            solution.status = SolveStatus::Infeasible { contacts: self.contradiction.clone() };
            return;
        }
        if !certified {
            self.retry_cold(problem, is_given, solution);
        }
        let failure = if certified || self.is_certified(solution) { None } else { self.fall_back(problem, solution) };
        self.drop_what_is_worse(problem, solution);
        solution.status = if self.is_certified(solution) && self.is_resolved(problem, solution) {
            SolveStatus::Solved
        } else {
            failure.or_else(|| immovable_rows(problem)).unwrap_or(SolveStatus::Inaccurate)
        };
    }

    /// Takes the islands that the start solves already; whether there are any.
    fn hold_islands(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        let Self { given, cones, islands, settings, residuals, .. } = self;
        given.hold(problem, cones, islands, settings, solution, residuals)
    }

    /// Assembles the islands whose residual is not known yet, and solves them; whether the certificate holds then.
    fn solve_from_start(
        &mut self,
        problem: &ContactProblem,
        is_given: bool,
        any_held: bool,
        solution: &mut ContactSolution,
    ) -> bool {
        if self.residuals.contains(&f64::INFINITY) {
            self.islands.assemble(problem, |island| self.residuals[island] == f64::INFINITY);
            let given = std::mem::take(&mut self.given);
            let start = if is_given { Start::Warm(&given) } else { Start::Zero };
            self.solve_islands(problem, start, solution, |residual| residual == f64::INFINITY);
            self.given = given;
        } else if any_held {
            return self.complete_given(problem, solution);
        }
        self.complete(problem, solution)
    }

    /// No impulses at all have the residual 1: what was found may be worse and of no use to anyone.
    fn drop_what_is_worse(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        if solution.certificate.natural_map > 1.0 || solution.certificate.natural_map.is_nan() {
            solution.drop_impulses(problem);
            self.certify_completed(problem, solution);
        }
    }

    /// The first two stages of the cascade for the islands whose residual is `chosen`.
    fn solve_islands(
        &mut self,
        problem: &ContactProblem,
        start: Start,
        solution: &mut ContactSolution,
        chosen: impl Fn(f64) -> bool,
    ) {
        let Self { pool, cones, islands, settings, residuals, .. } = self;
        pool.run((problem, cones, islands.all()), settings, start, solution, residuals, chosen);
        self.contradiction.extend(pool.contradictions().map(|i| i as usize));
    }

    /// Lemke's method for a whole problem: where a bound has a constant part and grows with a normal impulse, its kink lies
    /// between the pieces that the first two stages know.
    fn solve_whole(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        if let Some(whole) = fallback::solve_whole(&mut self.lemke, problem, &self.settings) {
            *solution = whole;
            (solution.report.islands, solution.report.lemke_islands) = (1, 1);
        } else {
            solution.prepare(problem);
            self.complete(problem, solution);
            solution.status = SolveStatus::Inaccurate;
        }
    }

    /// Gives the islands that were accepted a cold start, where the certificate asks for more than they do (it multiplies
    /// errors of the velocity by large impulses); after a warm start first the one of a solve without it.
    fn retry_cold(&mut self, problem: &ContactProblem, is_given: bool, solution: &mut ContactSolution) {
        let accept = self.settings.accept;
        for start in [Start::Zero, Start::Cold].into_iter().skip(usize::from(!is_given)) {
            let accepted = self.residuals.iter().filter(|&&residual| residual <= accept).count();
            if accepted > 0 && !self.is_certified(solution) {
                solution.report.restarts += accepted as u32;
                self.retry(problem, start, solution, |residual| residual <= accept);
            }
        }
    }

    /// Solves the islands whose residual is `chosen` once more and keeps what certifies better.
    fn retry(
        &mut self,
        problem: &ContactProblem,
        start: Start,
        solution: &mut ContactSolution,
        chosen: impl Fn(f64) -> bool,
    ) {
        self.earlier.copy_warm_part(solution);
        self.earlier.velocity.clone_from(&solution.velocity);
        let earlier = self.violation(solution);
        self.solve_islands(problem, start, solution, chosen);
        self.complete(problem, solution);
        if self.violation(solution) >= earlier {
            solution.copy_warm_part(&self.earlier);
            solution.velocity.clone_from(&self.earlier.velocity);
            self.complete(problem, solution);
        }
    }

    /// The last stage of the cascade, for the islands that the first two left with a residual. Where it neither solves a small
    /// island nor denies it, the first two go on from what it found: Lemke's method works with sums that round, the proximal
    /// iterations with differences from their centre.
    fn fall_back(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> Option<SolveStatus> {
        let (mut denial, mut failure) = (None, None);
        for (island, residual) in self.islands.all().iter().zip(&mut self.residuals) {
            let left =
                std::mem::replace(residual, if island.units.len() < proximal::LARGE { *residual } else { SETTLED });
            if left <= closely_accepted(island, &self.settings) {
                continue;
            }
            let outcome = fallback::solve_with_lemke(&mut self.lemke, problem, island, &self.settings, left, solution);
            let denied = matches!(outcome, Some(SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. }));
            let kind = if denied { &mut denial } else { &mut failure };
            *kind = kind.take().or(outcome);
        }
        self.certify_completed(problem, solution);
        if denial.is_some() {
            return denial;
        }
        self.take_better_velocity(problem, solution);
        for roundings in 0..ROUNDINGS {
            let most = ROUNDED * self.settings.tolerance;
            let rounded = self.violation(solution) <= most && self.scales.rounding(solution) <= most;
            let near = roundings == 0 || rounded;
            if !near || self.is_certified(solution) || self.residuals.iter().all(|&residual| residual <= SETTLED) {
                break;
            }
            // The same solution by way of other numbers: where impulses are large, their last digits decide.
            let found = WarmStart::scaled(solution, 1.0 + f64::from(roundings) * OTHER_DIGITS);
            let mut given = std::mem::take(&mut self.given);
            given.read(problem, &self.cones, &self.islands, &found);
            self.retry(problem, Start::Found(&given), solution, |residual| residual > SETTLED);
            self.given = given;
        }
        failure
    }

    /// The certificate of a claimed solution of the problem that was solved last, as by [`certify`](crate::certify()), with the
    /// scales that the solve computed.
    pub fn recertify(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Certificate {
        if !has_rows(problem) {
            return certify_afresh(problem, solution, &mut self.scratch);
        }
        certify_with(problem, solution, &self.scales, &mut self.scratch)
    }

    /// Solves a problem; see [`solve_into`](Self::solve_into).
    pub fn solve(&mut self, problem: &ContactProblem, warm: Option<&WarmStart>) -> ContactSolution {
        let mut solution = ContactSolution::default();
        self.solve_into(problem, warm, &mut solution);
        solution
    }
}

fn has_rows(problem: &ContactProblem) -> bool {
    problem.contact_count() > 0 || !problem.bilateral_violation.is_empty() || !problem.friction_groups.is_empty()
}

/// The solution where nothing touches: with `v⁺ = v^f` and no other unknown every residual is zero, if the data are numbers.
fn take_free_velocity(problem: &ContactProblem, solution: &mut ContactSolution) {
    solution.prepare(problem);
    solution.certificate = Certificate::default();
    if solution.velocity.iter().any(|v| !v.is_finite()) {
        solution.certificate = Certificate::everything_violated();
        solution.status = SolveStatus::Inaccurate;
    }
}

/// Rows that belong to no island because no degree of freedom moves them, and that are violated: no impulse can help.
fn immovable_rows(problem: &ContactProblem) -> Option<SolveStatus> {
    let violated = |i: &usize| problem.jacobian.group(*i).0.is_empty() && problem.gap[*i] < 0.0;
    let contacts: Vec<usize> = (0..problem.contact_count()).filter(violated).collect();
    let contradicted =
        |k: usize| problem.bilateral_jacobian.group(k).0.is_empty() && problem.bilateral_violation[k] != 0.0;
    let any = !contacts.is_empty() || (0..problem.bilateral_violation.len()).any(contradicted);
    any.then_some(SolveStatus::Infeasible { contacts })
}
