//! Solving the step's problem with the corrections that the laws permit.

use signorini_contact::SolveStatus;
use signorini_multibody::Model;
use signorini_solver::{ContactSolver, Patience};

use crate::SimulationError;
use crate::report::{KeptRow, StepReport};
use crate::settings::{InfeasiblePolicy, Settings};
use crate::solver::Verdict;
use crate::workspace::Workspace;

/// Problems that are solved to find a larger θ, one more in the first of several steps.
const PROBES: u32 = 2;
/// From here on all of the corrections are tried again, and above none so small a part of what is excluded.
const NEARLY: f64 = 0.9;
const LOWEST: f64 = 0.25;
/// Fewer contacts than this are in no island whose factorisations are dear.
const SMALL: usize = 64;

/// Between a θ for which a solution was found and one for which none was.
struct Bracket {
    solved: f64,
    unsolved: f64,
}

impl Bracket {
    /// θ is a ratio: its digits matter, and not its size.
    fn middle(&self) -> f64 {
        if self.solved > 0.0 { (self.solved * self.unsolved).sqrt() } else { LOWEST * self.unsolved }
    }
}

impl Workspace {
    /// Solves the problem at hand and writes how it went to the report.
    pub(crate) fn solve(
        &mut self,
        model: &Model,
        settings: &Settings,
        v: &[f64],
        report: &mut StepReport,
    ) -> Result<(), SimulationError> {
        report.clipped_gaps = false;
        self.corrections.ask_again(&mut self.builder.problem);
        let mut verdict = self.solve_permitted(settings, report)?;
        // What misses the tolerance moves the bodies, too.
        if self.corrections.any() && !self.is_denied() {
            verdict = self.bound_energy(model, settings, v, verdict, report)?;
        }
        if self.is_denied() && settings.infeasible == InfeasiblePolicy::GoOn && !self.is_driven() {
            // There is a solution that was not found: the step goes on with the best point.
            self.solution.status = SolveStatus::Inaccurate;
        }
        report.status.clone_from(&self.solution.status);
        report.law = verdict.law;
        report.certificate = verdict.certificate;
        report.spread = self.solution.spread;
        report.cone_certificate = verdict.cone;
        report.least_norm = verdict.least_norm;
        report.contacts = self.builder.problem.contact_count();
        report.missed_tolerance = !verdict.holds;
        self.tell_corrections(report);
        Ok(())
    }

    fn solve_permitted(&mut self, settings: &Settings, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        if settings.infeasible == InfeasiblePolicy::GoOn && self.corrections.any() {
            self.corrections.leave_immovable(&mut self.builder.problem);
            // A step after one that was limited is mostly limited in the same way.
            if self.withheld.repeats()
                && let Some(verdict) = self.repeat_permitted(report)?
            {
                return Ok(verdict);
            }
            return self.search_permitted(report);
        }
        let verdict = self.attempt(Patience::Full, report)?;
        if self.is_denied() && settings.infeasible == InfeasiblePolicy::ClipGaps && self.builder.clip_gaps() {
            report.clipped_gaps = true;
            return self.attempt(Patience::Full, report);
        }
        Ok(verdict)
    }

    /// All that is asked for where a solution of that is found soon, otherwise the largest part of it for which one is.
    fn search_permitted(&mut self, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let expected = self.withheld.theta();
        if let Some(verdict) = self.find_still_stuck(expected, report)? {
            return Ok(verdict);
        }
        let is_small = self.builder.problem.contact_count() < SMALL;
        let is_short = (expected < 1.0 || is_small) && !self.withheld.is_by_energy() && !self.solver.is_counted();
        let patience = if is_short { Patience::Short } else { Patience::Brief };
        let mut verdict = self.attempt(patience, report)?;
        let may_go_on = patience == Patience::Brief && !self.solver.is_counted() && !self.solver.is_out_of_digits();
        if !verdict.holds && may_go_on && ContactSolver::is_near(verdict.certificate.worst()) {
            // Impulses that are nearly those of a solution are another start.
            self.keep_best();
            verdict = self.attempt(patience, report)?;
        }
        // Sweeps that leave something open say nothing about what the laws permit; a proof that there is no solution does.
        let is_open = self.solver.is_counted() && self.solution.status == SolveStatus::Inaccurate;
        if verdict.holds || is_open {
            return Ok(verdict);
        }
        if self.solver.is_out_of_digits() {
            return self.correct_all_or_nothing(report);
        }
        let verdict = self.search_part(expected, patience, report)?;
        if verdict.holds { self.release_others(verdict, report) } else { Ok(verdict) }
    }

    /// All that is asked for, though impulses have no digits for it; where that is not solved, without it. Such impulses are those of masses that differ
    /// as much, which smaller corrections have, too, or of corrections that nearly contradict each other.
    fn correct_all_or_nothing(&mut self, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let whole = self.attempt(Patience::Full, report)?;
        if whole.holds || !self.limit_what_lacks() {
            return Ok(whole);
        }
        self.best.clone_from(&self.solution);
        let verdict = self.attempt_part(0.0, Patience::Short, report)?;
        if verdict.holds {
            self.search_above(verdict, 1.0, Patience::Short, report)
        } else {
            self.take_best(1.0, whole, report)
        }
    }

    /// What the last step was permitted, without a search for more, where a contradiction proves that there is none.
    fn find_still_stuck(&mut self, expected: f64, report: &mut StepReport) -> Result<Option<Verdict>, SimulationError> {
        if expected == 1.0 || self.withheld.is_by_energy() {
            return Ok(None);
        }
        let Self { withheld, builder, corrections, .. } = self;
        if corrections.limit(|i| withheld.has_contact(&builder.keys[i]), |k| withheld.has_row(k)) {
            if self.largest_part() <= expected {
                self.corrections.theta = expected;
                self.contradictions.release_all_but_needed(&self.builder.problem, &mut self.corrections);
                let verdict = self.attempt_part(expected, Patience::Short, report)?;
                if verdict.holds {
                    self.withheld.take_proof();
                    return Ok(Some(verdict));
                }
                self.corrections.set(1.0, &mut self.builder.problem);
            }
            self.corrections.limit_nothing();
        }
        Ok(None)
    }

    /// The largest part of the limited corrections for which no contradiction is found.
    fn largest_part(&mut self) -> f64 {
        if self.is_driven() {
            self.contradictions.clear();
            return 1.0;
        }
        let Self { contradictions, builder, corrections, .. } = self;
        contradictions.largest_part(&builder.problem, corrections)
    }

    /// The largest part of what is asked for in the islands whose laws do not hold, after all of it was tried.
    fn search_part(
        &mut self,
        expected: f64,
        patience: Patience,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        let mut largest = 1.0;
        if self.limit_what_lacks() {
            largest = self.largest_part();
            for theta in [expected, 0.0] {
                if theta < self.corrections.theta && theta <= largest {
                    let verdict = self.attempt_part(theta, Patience::Short, report)?;
                    if verdict.holds {
                        return self.search_above(verdict, largest, Patience::Short, report);
                    }
                }
            }
        }
        if patience == Patience::Short && largest == 1.0 {
            let verdict = self.attempt_part(1.0, Patience::Brief, report)?;
            if verdict.holds {
                return Ok(verdict);
            }
            self.corrections.limit_nothing();
            self.limit_what_lacks();
        }
        // Everything was tried already where the same step, with fewer contacts, has missed its tolerance.
        let patience = if report.missed_tolerance { Patience::Brief } else { Patience::Full };
        let verdict = self.attempt_part(0.0, patience, report)?;
        if verdict.holds {
            return self.search_above(verdict, largest, Patience::Brief, report);
        }
        if report.missed_tolerance || largest < 1.0 {
            return Ok(verdict);
        }
        // No solution is found where there must be one: perhaps one is found where there may be none, or what comes closer to one.
        self.best.clone_from(&self.solution);
        let whole = self.attempt_part(1.0, Patience::Full, report)?;
        let comes_closer = !self.is_denied() && whole.certificate.worst() < verdict.certificate.worst();
        if whole.holds || comes_closer { Ok(whole) } else { self.take_best(0.0, verdict, report) }
    }

    /// What the last step was permitted, of the same rows, where that has a solution and they are still violated.
    fn repeat_permitted(&mut self, report: &mut StepReport) -> Result<Option<Verdict>, SimulationError> {
        let Self { withheld, builder, corrections, .. } = self;
        if withheld.is_by_energy() {
            corrections.limit_all(&builder.impacts);
        }
        if corrections.limit(|i| withheld.has_contact(&builder.keys[i]), |k| withheld.has_row(k)) {
            let patience = if self.withheld.is_by_energy() { Patience::Full } else { Patience::Short };
            let verdict = self.attempt_part(self.withheld.theta(), patience, report)?;
            if verdict.holds {
                return Ok(Some(verdict));
            }
            // What came in beside them since may ask for too much.
            if !self.withheld.is_by_energy() && self.limit_what_lacks() {
                let verdict = self.attempt_part(self.withheld.theta(), Patience::Brief, report)?;
                if verdict.holds {
                    return Ok(Some(verdict));
                }
            }
        }
        self.corrections.set(1.0, &mut self.builder.problem);
        self.corrections.limit_nothing();
        self.withheld.search_again();
        Ok(None)
    }

    /// Asks in full for those limited rows that no contradiction needs: at a dead centre a mechanism may be unable to make one of its corrections at all,
    /// and no other one.
    fn release_others(&mut self, verdict: Verdict, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let theta = self.corrections.theta;
        if theta == 1.0 || self.is_driven() {
            return Ok(verdict);
        }
        let Self { contradictions, builder, corrections, .. } = self;
        if !contradictions.release_all_but_needed(&builder.problem, corrections) {
            return Ok(verdict);
        }
        self.keep_best();
        let others = self.attempt_part(theta, Patience::Short, report)?;
        if others.holds {
            return Ok(others);
        }
        self.contradictions.limit_again(&mut self.corrections);
        self.take_best(theta, verdict, report)
    }

    /// Takes note of what the step was not permitted.
    pub(crate) fn remember_withheld(&mut self) {
        let Self { withheld, builder, corrections, .. } = self;
        let theta = corrections.part();
        let contacts = corrections.kept().filter_map(|kept| match kept.row {
            KeptRow::Contact(i) => Some(builder.keys[i]),
            KeptRow::Bilateral(_) => None,
        });
        let rows = corrections.kept().filter_map(|kept| match kept.row {
            KeptRow::Bilateral(k) => Some(k),
            KeptRow::Contact(_) => None,
        });
        withheld.remember(theta, corrections.limits_all(), contacts, rows);
    }

    /// Limits the corrections of the islands whose laws do not hold; whether they have any.
    fn limit_what_lacks(&mut self) -> bool {
        let Self { solver, corrections, .. } = self;
        corrections.limit(|i| solver.contact_lacks(i), |k| solver.bilateral_lacks(k))
    }

    /// The largest θ for which a solution is found, from the solution at hand.
    ///
    /// - `largest`: what there can be a solution for
    fn search_above(
        &mut self,
        verdict: Verdict,
        largest: f64,
        patience: Patience,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        let mut bracket = Bracket { solved: self.corrections.theta, unsolved: largest };
        if bracket.solved >= bracket.unsolved {
            return Ok(verdict);
        }
        let mut best = verdict;
        // From the solution for less, the one for all may be near. After a step that was limited it is unlikely.
        let is_first = self.withheld.theta() == 1.0 && largest == 1.0;
        let mut tries_all = is_first;
        self.keep_best();
        for _ in 0..PROBES + u32::from(is_first) {
            let theta = if std::mem::take(&mut tries_all) { 1.0 } else { bracket.middle() };
            let verdict = self.attempt_part(theta, patience, report)?;
            if !verdict.holds {
                bracket.unsolved = theta;
                continue;
            }
            if theta == 1.0 {
                return Ok(verdict);
            }
            (bracket.solved, best) = (theta, verdict);
            tries_all = !is_first && theta > NEARLY;
            self.keep_best();
        }
        if self.corrections.theta == bracket.solved { Ok(best) } else { self.take_best(bracket.solved, best, report) }
    }

    /// Whether the solution at hand is none: the problem was denied one.
    fn is_denied(&self) -> bool {
        matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. })
    }

    /// Whether velocities are prescribed, which may be impossible.
    pub(crate) fn is_driven(&self) -> bool {
        self.builder.problem.bilateral_violation.len() > self.builder.bilateral_source.len()
    }

    /// Writes what was corrected, and what was kept, to the report.
    fn tell_corrections(&self, report: &mut StepReport) {
        report.theta = self.corrections.part();
        report.correction_energy = self.correction_energy();
        report.left_out = self.builder.left_out.len();
        report.kept.clear();
        report.kept.extend(self.corrections.kept());
    }
}
