//! The walk of a contact problem: islands, hold, cascade, verdict; and a second look where the certificate does not hold.

use std::time::Instant;

use signorini_contact::certificate::Certificate;
use signorini_contact::projection::Cones;
use signorini_contact::scales::VelocityScale;
use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, ProblemError, SolveStatus, StageKind, WarmStart,
};
use signorini_lcp::Lemke;

use crate::continuation::continue_to;
use crate::islands::Islands;
use crate::pool::{IslandPool, Request, is_denial};
use crate::residual::RESIDUALS;
use crate::settings::SolverSettings;
use crate::stages::hold::GivenStart;
use crate::stages::solve_whole;
use crate::task::{Look, Patience, SIZES, accepted_closely};
use crate::verdict::{Verdict, immovable_rows, take_free_velocity};

/// What is tuned in second looks.
struct Tuning {
    /// How many there are at most, as long as each leaves less of what the laws lack, or rounding.
    second_looks: u32,
}

/// Chosen by: `random_steps --seeds 0..6000` and the stored cases of `crates/solver/tests/data/random_steps`, 23 November 2026.
const TUNING: Tuning = Tuning { second_looks: 12 };

/// The structured contact solver with its memory.
#[derive(Debug, Default)]
pub struct ContactSolver {
    settings: SolverSettings,
    patience: Patience,
    cones: Cones,
    islands: Islands,
    given: GivenStart,
    pool: IslandPool,
    verdict: Verdict,
    /// What every island lacks; infinite where it is not solved.
    residuals: Vec<f64>,
    /// Contacts of islands that contradict themselves.
    contradiction: Vec<usize>,
    /// What islands failed with.
    failure: Option<SolveStatus>,
    /// The solution before a second look.
    earlier: ContactSolution,
    lemke: Lemke,
    /// Whether the last walk ended where rounding is all that is left.
    is_out_of_digits: bool,
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

    /// Sets how many sweeps the next solves may make ([`SolverSettings::budget`]), where they are counted.
    pub fn set_budget(&mut self, sweeps: u32) {
        self.settings.budget = self.settings.budget.map(|_| sweeps.max(1));
    }

    /// The settings.
    pub fn settings(&self) -> &SolverSettings {
        &self.settings
    }

    /// From now on problems are parts of larger ones, of which the other islands are known to stand: residuals are relative to the scales of both.
    ///
    /// - `delassus`, `velocity`: scales of the other part ([`ContactProblem::delassus_scale`], 1/kg, and [`ContactProblem::velocity_scale`], m/s); zero where there
    ///   is none
    pub fn set_beside(&mut self, delassus: f64, velocity: VelocityScale) {
        self.islands.set_beside(delassus, velocity);
    }

    /// The island of a unit of the last problem: a contact, or a friction group counted after the contacts; `None` if nothing moves it.
    pub fn island_of_unit(&self, unit: usize) -> Option<usize> {
        self.islands.of_unit(unit)
    }

    /// The island of a block of the last problem's mass matrix; `None` if no row moves it.
    pub fn island_of_block(&self, block: usize) -> Option<usize> {
        self.islands.of_block(block)
    }

    /// Solves a problem; see [`solve_into`](Self::solve_into).
    pub fn solve(&mut self, problem: &ContactProblem, warm: Option<&WarmStart>) -> ContactSolution {
        let mut solution = ContactSolution::default();
        self.solve_into(problem, warm, &mut solution);
        solution
    }

    /// Solves a problem into `solution`, whose memory is reused. The result has the same bits on any number of threads.
    ///
    /// `warm`: the start, if it has one entry per contact. The status is decided by the [certificate](signorini_contact::certify) of
    /// the result, and by how far its velocity is from that of its impulses along any row, never by the solver's own numbers.
    /// No allocation after warm-up where the stages before Lemke's method reach the tolerance on one thread.
    pub fn solve_into(&mut self, problem: &ContactProblem, warm: Option<&WarmStart>, solution: &mut ContactSolution) {
        self.solve_patiently_into(problem, warm, Patience::Full, solution);
    }

    /// [`solve_into`](Self::solve_into) with less patience, for problems that may have no solution. Its denials are no proofs then.
    pub fn solve_patiently_into(
        &mut self,
        problem: &ContactProblem,
        warm: Option<&WarmStart>,
        patience: Patience,
        solution: &mut ContactSolution,
    ) {
        self.solve_looking(problem, warm, patience, solution);
        let is_proved = matches!(solution.status, SolveStatus::Infeasible { .. });
        let may_go_on = patience == Patience::Full && self.settings.budget.is_none();
        if may_go_on && solution.status != SolveStatus::Solved && !is_proved && !self.is_out_of_digits {
            let is_near = self.verdict.violation(solution) <= RESIDUALS.far;
            continue_to(problem, is_near, solution, |problem, start, patience, solution| {
                self.solve_looking(problem, start, patience, solution);
            });
        }
    }

    /// Whether the last solve missed the tolerance by no more than what the last digits of its impulses make in a velocity, after all stages of
    /// the cascade: continuation and smaller corrections would end there, too, at many times the work.
    pub fn is_out_of_digits(&self) -> bool {
        self.is_out_of_digits
    }

    /// Whether laws that lack this part of the velocity scale mostly have a solution near by: what has none is mostly above 1e-3, what was cut short below
    /// 1e-5 (solves of mixers and necklaces, 28 November 2026).
    pub fn is_near(residual: f64) -> bool {
        residual <= RESIDUALS.far
    }

    /// Whether the last solve left the island of a unit (a contact, or a friction group counted after the contacts) with laws that do
    /// not hold; of every unit, if none of the islands tells why the certificate does not.
    pub fn unit_lacks(&self, unit: usize) -> bool {
        self.lacks(self.islands.of_unit(unit))
    }

    /// The same of a bilateral row.
    pub fn bilateral_lacks(&self, row: usize) -> bool {
        self.lacks(self.islands.of_bilateral(row))
    }

    fn lacks(&self, island: Option<usize>) -> bool {
        self.lacking()(island.and_then(|island| self.residuals.get(island)).copied().unwrap_or(0.0))
    }

    /// Which residuals are those of islands whose laws do not hold; all, if none of the islands tells why the certificate does not.
    fn lacking(&self) -> impl Fn(f64) -> bool + use<> {
        let accept = self.settings.accept();
        let lacks = move |residual: f64| residual > accept || residual.is_nan();
        let any = self.residuals.iter().any(|residual| lacks(*residual));
        move |residual| !any || lacks(residual)
    }

    /// The walk of a problem, without [continuation](crate::continuation).
    fn solve_looking(
        &mut self,
        problem: &ContactProblem,
        warm: Option<&WarmStart>,
        patience: Patience,
        solution: &mut ContactSolution,
    ) {
        self.patience = patience;
        self.is_out_of_digits = false;
        if !has_rows(problem) {
            return take_free_velocity(problem, solution);
        }
        self.cones.prepare(problem);
        if problem.friction_groups.bound.iter().any(|bound| matches!(bound, FrictionBound::Shifted { .. })) {
            return self.solve_whole(problem, solution);
        }
        self.begin(problem, solution);
        let is_given = warm.is_some_and(|warm| self.given.read(problem, &self.cones, &self.islands, warm));
        let any_held = is_given && self.hold(problem, solution);
        let mut is_certified = self.look(problem, is_given, any_held, solution);
        let is_left = |solution: &ContactSolution| solution.report.unfinished_islands > 0;
        if any_held && !is_certified && !is_left(solution) {
            // What was solved would come out the same.
            self.given.let_go(&mut self.residuals);
            solution.report.sleeping_islands = 0;
            is_certified = self.look(problem, is_given, false, solution);
        }
        if !is_certified && is_left(solution) {
            let denial = std::mem::take(&mut self.contradiction);
            solution.status = if denial.is_empty() { SolveStatus::Inaccurate } else { infeasible(denial) };
            return;
        }
        if !is_certified && !self.is_denied() {
            is_certified = self.look_further(problem, is_given, solution);
        }
        if !(is_certified && self.verdict.is_resolved(problem, solution)) {
            self.is_out_of_digits = self.verdict.is_out_of_digits(solution);
            self.conclude(problem, solution);
        }
    }

    /// Finds the islands and the scales of a problem.
    fn begin(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        self.islands.find(problem);
        self.verdict.begin(&self.islands, self.settings.tolerance);
        solution.begin(problem);
        solution.report.islands = self.islands.all().len();
        self.residuals.clear();
        self.residuals.resize(self.islands.all().len(), f64::INFINITY);
        self.contradiction.clear();
        self.failure = None;
    }

    /// Takes the islands that the start solves already; whether there are any.
    fn hold(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        let Self { given, cones, islands, settings, residuals, .. } = self;
        let begin = settings.time_stages.then(Instant::now);
        let held = given.hold(problem, cones, islands, settings, solution, residuals);
        let count = &mut solution.report.stages[StageKind::Hold];
        (count.asked, count.ended) = (residuals.len() as u64, u64::from(held));
        count.nanoseconds = begin.map_or(0, |begin| begin.elapsed().as_nanos() as u64);
        if settings.sleeping {
            solution.report.sleeping_islands = given.resting();
        }
        held > 0
    }

    /// Takes the islands that are not solved yet through the cascade; whether the certificate holds then.
    fn look(
        &mut self,
        problem: &ContactProblem,
        is_given: bool,
        any_held: bool,
        solution: &mut ContactSolution,
    ) -> bool {
        if self.residuals.contains(&f64::INFINITY) {
            self.islands.assemble(problem, |island| self.residuals[island] == f64::INFINITY);
            self.run_cascade(
                problem,
                self.patience.first_look(),
                is_given,
                |_, residual| residual == f64::INFINITY,
                solution,
            );
            if solution.report.unfinished_islands > 0 {
                return self.verdict.complete_unfinished(problem, &self.cones, solution);
            }
        } else if any_held {
            let known = (&*self.residuals, &*self.given.rates);
            return self.verdict.complete_given(problem, &self.cones, known, solution);
        }
        self.verdict.complete(problem, &self.cones, &self.residuals, solution)
    }

    fn run_cascade(
        &mut self,
        problem: &ContactProblem,
        look: Look,
        is_given: bool,
        chosen: impl Fn(usize, f64) -> bool,
        solution: &mut ContactSolution,
    ) {
        let Self { pool, cones, islands, settings, given, residuals, .. } = self;
        let given = is_given.then_some(&*given);
        let request = Request { problem, cones, islands: islands.all(), settings, look, given };
        pool.run(request, chosen, residuals, solution);
        self.contradiction.extend(self.pool.contradictions());
        self.failure = self.pool.failure().or(self.failure.take());
    }

    /// Looks again at what was found, and without a start.
    fn look_further(&mut self, problem: &ContactProblem, is_given: bool, solution: &mut ContactSolution) -> bool {
        let second_looks = if self.patience == Patience::Full { TUNING.second_looks } else { 0 };
        self.look_again(problem, second_looks, solution) || is_given && self.look_without_start(problem, solution)
    }

    /// Goes on from what was found, where the certificate asks for more than the islands did, or some lack something: those have to
    /// come down farther now. Keeps what certifies better; whether the certificate holds.
    fn look_again(&mut self, problem: &ContactProblem, second_looks: u32, solution: &mut ContactSolution) -> bool {
        for look in 0..second_looks {
            // Where impulses are large, their last digits decide: those of every look differ.
            let found = WarmStart::scaled(solution, 1.0 + f64::from(look) * RESIDUALS.cancelled);
            self.given.read(problem, &self.cones, &self.islands, &found);
            let closely: Vec<f64> =
                self.islands.all().iter().map(|island| accepted_closely(island.units.len(), &self.settings)).collect();
            let lacks = |island: usize, residual: f64| residual > closely[island];
            let any_lacks = self.residuals.iter().enumerate().any(|(island, residual)| lacks(island, *residual));
            solution.report.restarts += self.residuals.len() as u32;
            let is_counted = self.settings.budget.is_some();
            let size = |island: usize| self.islands.all()[island].units.len();
            let is_short: Vec<bool> =
                (0..closely.len()).map(|island| !is_counted || size(island) < SIZES.large).collect();
            let chosen = |island: usize, residual: f64| is_short[island] && (!any_lacks || lacks(island, residual));
            let (before, after) = self.improve(problem, solution, |solver, solution| {
                solver.run_cascade(problem, Look::Second, true, chosen, solution);
            });
            if self.verdict.is_certified(solution) {
                return true;
            }
            // Where rounding is all that lacks other last digits may do; in a large island, whose factorisations are dear, while they help.
            let is_worth = after < before || self.islands.all().iter().all(|island| island.units.len() < SIZES.large);
            let goes_on =
                after <= RESIDUALS.less * before || is_worth && self.verdict.is_rounded(solution, RESIDUALS.rounded);
            if self.is_denied() || !goes_on {
                break;
            }
        }
        false
    }

    /// Looks at the islands that lack something, at all where none tells what the certificate lacks, without what they began with: impulses that balance each other, as those of a jam that is over, can be
    /// larger than any that this problem asks for, and their last digits more than its tolerance. Keeps what certifies better; whether the certificate
    /// holds.
    fn look_without_start(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        if self.patience == Patience::Short || !self.verdict.is_out_of_digits(solution) {
            return false;
        }
        let lacks = self.lacking();
        self.improve(problem, solution, |solver, solution| {
            solver.run_cascade(problem, Look::Only, false, |_, residual| lacks(residual), solution);
        });
        self.verdict.is_certified(solution)
    }

    /// Lets the islands be solved once more, and keeps what certifies better; how far from the laws that was before, and is with what was found.
    fn improve(
        &mut self,
        problem: &ContactProblem,
        solution: &mut ContactSolution,
        solve: impl FnOnce(&mut Self, &mut ContactSolution),
    ) -> (f64, f64) {
        let before = self.verdict.violation(solution);
        self.earlier.copy_warm_part(solution);
        self.earlier.velocity.clone_from(&solution.velocity);
        self.failure = None;
        solve(self, solution);
        self.verdict.complete(problem, &self.cones, &self.residuals, solution);
        let after = self.verdict.violation(solution);
        if after >= before || after.is_nan() {
            solution.copy_warm_part(&self.earlier);
            solution.velocity.clone_from(&self.earlier.velocity);
            self.verdict.complete(problem, &self.cones, &self.residuals, solution);
        }
        (before, after)
    }

    /// Whether an island was proved to have no solution.
    fn is_denied(&self) -> bool {
        !self.contradiction.is_empty() || self.failure.as_ref().is_some_and(is_denial)
    }

    /// The status of what did not certify, or was not resolved.
    fn conclude(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        self.verdict.drop_what_is_worse(problem, &self.cones, solution);
        let contacts = std::mem::take(&mut self.contradiction);
        solution.status = if !contacts.is_empty() {
            infeasible(contacts)
        } else if self.verdict.is_certified(solution) && self.verdict.is_resolved(problem, solution) {
            SolveStatus::Solved
        } else {
            self.failure.take().or_else(|| immovable_rows(problem)).unwrap_or(SolveStatus::Inaccurate)
        };
        if self.settings.budget.is_some() && solution.status == SolveStatus::Inaccurate {
            solution.spread = self.verdict.spread(problem, solution);
        }
    }

    /// Lemke's method for a whole problem: where a bound has a constant part and grows with a normal impulse, its kink lies
    /// between the pieces that the other stages know.
    fn solve_whole(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        if let Some(whole) = solve_whole(&mut self.lemke, problem, &self.settings) {
            *solution = whole;
            (solution.report.islands, solution.report.lemke_islands) = (1, 1);
            let count = &mut solution.report.stages[StageKind::Lemke];
            (count.asked, count.ended) = (1, u64::from(solution.status == SolveStatus::Solved));
        } else {
            self.begin(problem, solution);
            self.verdict.complete(problem, &self.cones, &[], solution);
            solution.status = SolveStatus::Inaccurate;
        }
    }

    /// The certificate of a claimed solution of the problem that was solved last, as by [`certify`](signorini_contact::certify()), with
    /// the scales that the solve computed.
    pub fn recertify(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Certificate {
        self.verdict.recertify(problem, solution, has_rows(problem))
    }
}

fn infeasible(mut contacts: Vec<usize>) -> SolveStatus {
    contacts.sort_unstable();
    SolveStatus::Infeasible { contacts }
}

fn has_rows(problem: &ContactProblem) -> bool {
    problem.contact_count() > 0 || !problem.bilateral_violation.is_empty() || !problem.friction_groups.is_empty()
}
