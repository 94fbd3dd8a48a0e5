//! Solving the step's problem with the corrections that the laws permit.

use signorini_contact::SolveStatus;
use signorini_multibody::{Model, kinetic_energy};
use signorini_solver::Patience;

use crate::SimulationError;
use crate::corrections::energy;
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
/// Problems that are solved to bring the energy of corrections below its bound, and the part of the bound that is aimed at.
const REDUCTIONS: u32 = 4;
const AIM: f64 = 0.9;
/// Corrections may put in the energy that all bodies have at so many times the speed of corrections, and this part of the
/// kinetic energy.
const SPEEDS: f64 = 2.0;
const PART_OF_ENERGY: f64 = 0.01;

/// Between a θ for which a solution was found and one for which none was.
struct Bracket {
    solved: f64,
    unsolved: f64,
}

impl Bracket {
    fn above(solved: f64) -> Self {
        Self { solved, unsolved: 1.0 }
    }

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
        if verdict.holds && self.corrections.any() {
            verdict = self.bound_energy(model, settings, v, verdict, report)?;
        }
        let denied = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if denied && settings.infeasible == InfeasiblePolicy::GoOn && !self.is_driven() {
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
            return self.search_permitted(report);
        }
        let verdict = self.attempt(Patience::Full, report)?;
        let unsolvable = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if unsolvable && settings.infeasible == InfeasiblePolicy::ClipGaps && self.builder.clip_gaps() {
            report.clipped_gaps = true;
            return self.attempt(Patience::Full, report);
        }
        Ok(verdict)
    }

    /// All that is asked for where a solution of that is found soon, otherwise the largest part of it for which one is. A step after one that
    /// was limited is mostly limited in the same way: solutions near the last one are looked for first.
    fn search_permitted(&mut self, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        if self.withheld.repeats()
            && let Some(verdict) = self.repeat_permitted(report)?
        {
            return Ok(verdict);
        }
        let expected = self.withheld.theta();
        let is_small = self.builder.problem.contact_count() < SMALL;
        let is_short = (expected < 1.0 || is_small) && !self.solver.is_counted();
        let patience = if is_short { Patience::Short } else { Patience::Brief };
        let verdict = self.attempt(patience, report)?;
        // Sweeps that leave something open say nothing about what the laws permit; a proof that there is no solution does.
        let is_open = self.solver.is_counted() && self.solution.status == SolveStatus::Inaccurate;
        if verdict.holds || is_open {
            return Ok(verdict);
        }
        if self.solver.is_out_of_digits() {
            // No other part of the corrections has a solution with more digits.
            return self.attempt(Patience::Full, report);
        }
        if self.limit_what_lacks() {
            for theta in [expected, 0.0] {
                if theta < self.corrections.theta {
                    let verdict = self.attempt_part(theta, Patience::Short, report)?;
                    if verdict.holds {
                        return self.search_above(verdict, Patience::Short, report);
                    }
                }
            }
        }
        if patience == Patience::Short {
            let verdict = self.attempt_part(1.0, Patience::Brief, report)?;
            if verdict.holds {
                return Ok(verdict);
            }
            self.corrections.limit_nothing();
            self.limit_what_lacks();
        }
        let verdict = self.attempt_part(0.0, Patience::Full, report)?;
        if verdict.holds {
            return self.search_above(verdict, Patience::Brief, report);
        }
        // No solution is found where there must be one: perhaps one is found where there may be none.
        let verdict = self.attempt_part(1.0, Patience::Full, report)?;
        if verdict.holds { Ok(verdict) } else { self.attempt_part(0.0, Patience::Full, report) }
    }

    /// What the last step was permitted, of the same rows, where that has a solution and they are still violated.
    fn repeat_permitted(&mut self, report: &mut StepReport) -> Result<Option<Verdict>, SimulationError> {
        let Self { withheld, builder, corrections, .. } = self;
        if corrections.limit(|i| withheld.has_contact(&builder.keys[i]), |k| withheld.has_row(k)) {
            let verdict = self.attempt_part(self.withheld.theta(), Patience::Short, report)?;
            if verdict.holds {
                return Ok(Some(verdict));
            }
        }
        self.corrections.set(1.0, &mut self.builder.problem);
        self.corrections.limit_nothing();
        self.withheld.search_again();
        Ok(None)
    }

    /// Takes note of what the step was not permitted.
    pub(crate) fn remember_withheld(&mut self) {
        let Self { withheld, builder, corrections, .. } = self;
        let theta = if corrections.kept().next().is_some() { corrections.theta } else { 1.0 };
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
    fn search_above(
        &mut self,
        verdict: Verdict,
        patience: Patience,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        let (mut best, mut bracket) = (verdict, Bracket::above(self.corrections.theta));
        // From the solution for less, the one for all may be near. After a step that was limited it is unlikely.
        let is_first = self.withheld.theta() == 1.0;
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

    /// Reduces θ where corrections put in more energy than they may.
    fn bound_energy(
        &mut self,
        model: &Model,
        settings: &Settings,
        v: &[f64],
        mut verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        if self.correction_energy() <= 0.0 || !settings.correction_speed.is_finite() {
            return Ok(verdict);
        }
        let speed = SPEEDS * settings.correction_speed;
        let mut bound = 0.5 * self.moving_mass * speed * speed;
        let mut put_in = self.energy_left(model, bound);
        if put_in > bound {
            bound += PART_OF_ENERGY * kinetic_energy(model, &self.kinematics, v);
        }
        for reduction in 0..=REDUCTIONS {
            if put_in <= bound {
                break;
            }
            self.warm.keep(&self.builder.keys, &self.builder.group_keys, &self.solution);
            let theta = self.corrections.theta * (AIM * bound / put_in).sqrt().min(AIM);
            let theta = if reduction == REDUCTIONS { 0.0 } else { theta };
            self.corrections.limit(|_| true, |_| true);
            verdict = self.attempt_part(theta, Patience::Full, report)?;
            put_in = self.energy_left(model, bound);
        }
        Ok(verdict)
    }

    /// The work of the corrections, J; where that is above the bound, what can be left of it in the motion: what the step's implicit forces
    /// take at the velocity of its end, `v⁺ᵀ (M̂ − M) v⁺`, is not, as with dampers that hold a mechanism back, and it is no more than the
    /// kinetic energy after the step, as where friction takes the rest.
    fn energy_left(&mut self, model: &Model, bound: f64) -> f64 {
        let work = self.correction_energy();
        if work <= bound {
            return work;
        }
        let Self { builder, solution, kinematics, reach, best, .. } = self;
        let v = &solution.velocity;
        let momentum = &mut best.velocity;
        momentum.resize(v.len(), 0.0);
        builder.problem.mass.multiply_into(v, momentum);
        let with_implicit: f64 = v.iter().zip(momentum).map(|(v, p)| v * *p).sum();
        let rigid = 2.0 * reach.end.kinetic_energy(model, kinematics, v);
        (work - (with_implicit - rigid).max(0.0)).min(0.5 * rigid)
    }

    /// Whether velocities are prescribed, which may be impossible.
    pub(crate) fn is_driven(&self) -> bool {
        self.builder.problem.bilateral_violation.len() > self.builder.bilateral_source.len()
    }

    fn correction_energy(&self) -> f64 {
        let constraints = self.builder.bilateral_source.len();
        energy(&self.builder.problem, &self.solution, &self.builder.impacts, constraints)
    }

    fn attempt_part(
        &mut self,
        theta: f64,
        patience: Patience,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        self.corrections.set(theta, &mut self.builder.problem);
        self.attempt(patience, report)
    }

    fn attempt(&mut self, patience: Patience, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let start = self.warm.start_for(&self.builder.keys, &self.builder.group_keys);
        let verdict = self.solver.solve_into(&mut self.builder.problem, Some(start), patience, &mut self.solution);
        report.solver.accumulate(&self.solution.report);
        report.solves += 1;
        verdict
    }

    /// Keeps the solution at hand, from which the next ones start.
    fn keep_best(&mut self) {
        self.warm.keep(&self.builder.keys, &self.builder.group_keys, &self.solution);
        self.best.clone_from(&self.solution);
    }

    /// Gives the problem the part θ that has a solution, and that solution.
    fn take_best(&mut self, theta: f64, verdict: Verdict, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        if !self.solver.keeps_directions() {
            return self.attempt_part(theta, Patience::Full, report);
        }
        self.corrections.set(theta, &mut self.builder.problem);
        std::mem::swap(&mut self.solution, &mut self.best);
        Ok(verdict)
    }

    /// Writes what was corrected, and what was kept, to the report.
    fn tell_corrections(&self, report: &mut StepReport) {
        report.theta = self.corrections.theta;
        report.correction_energy = self.correction_energy();
        report.left_out = self.builder.left_out.len();
        report.kept.clear();
        report.kept.extend(self.corrections.kept());
    }
}
