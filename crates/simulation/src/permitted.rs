//! Solving the step's problem with the corrections that the laws permit.

use signorini_contact::SolveStatus;

use crate::SimulationError;
use crate::corrections::energy;
use crate::report::StepReport;
use crate::settings::{InfeasiblePolicy, Settings};
use crate::solver::{Effort, Verdict};
use crate::workspace::Workspace;

/// Problems that are solved to find the largest θ.
const BISECTIONS: u32 = 4;
/// Problems that are solved to bring the energy of corrections below its bound, and the part of the bound that is aimed at.
const REDUCTIONS: u32 = 4;
const AIM: f64 = 0.9;
/// Corrections may put in the energy that all bodies have at so many times the speed of corrections, and this part of the
/// kinetic energy.
const SPEEDS: f64 = 2.0;
const PART_OF_ENERGY: f64 = 0.01;

impl Workspace {
    /// Solves the problem at hand and writes how it went to the report.
    pub(crate) fn solve(
        &mut self,
        settings: &Settings,
        v: &[f64],
        report: &mut StepReport,
    ) -> Result<(), SimulationError> {
        report.clipped_gaps = false;
        self.corrections.ask_again(&mut self.builder.problem);
        let mut verdict = self.solve_permitted(settings, report)?;
        if verdict.holds && self.corrections.any() {
            verdict = self.bound_energy(settings, v, verdict, report)?;
        }
        let denied = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if denied && settings.infeasible == InfeasiblePolicy::GoOn && !self.is_driven() {
            // There is a solution that was not found: the step goes on with the best point.
            self.solution.status = SolveStatus::Inaccurate;
        }
        report.status.clone_from(&self.solution.status);
        report.law = verdict.law;
        report.certificate = verdict.certificate;
        report.cone_certificate = verdict.cone;
        report.least_norm = verdict.least_norm;
        report.contacts = self.builder.problem.contact_count();
        report.missed_tolerance = !verdict.holds;
        self.tell_corrections(report);
        Ok(())
    }

    fn solve_permitted(&mut self, settings: &Settings, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let searches = settings.infeasible == InfeasiblePolicy::GoOn && self.corrections.any();
        let effort = if searches { Effort::First } else { Effort::All };
        let verdict = self.attempt(effort, report)?;
        if searches && !verdict.holds {
            return self.find_permitted(report);
        }
        let unsolvable = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if unsolvable && settings.infeasible == InfeasiblePolicy::ClipGaps && self.builder.clip_gaps() {
            report.clipped_gaps = true;
            return self.attempt(Effort::All, report);
        }
        Ok(verdict)
    }

    /// The largest θ for which a solution is found, from the side where there is one.
    fn find_permitted(&mut self, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let mut best = self.attempt_part(0.0, Effort::All, report)?;
        if !best.holds {
            // No solution is found where there must be one: perhaps one is found where there may be none.
            let verdict = self.attempt_part(1.0, Effort::All, report)?;
            return if verdict.holds { Ok(verdict) } else { self.attempt_part(0.0, Effort::All, report) };
        }
        let (mut solved, mut unsolved) = (0.0, 1.0);
        self.keep_best();
        for _ in 0..BISECTIONS {
            let theta = 0.5 * (solved + unsolved);
            let verdict = self.attempt_part(theta, Effort::First, report)?;
            if verdict.holds {
                (solved, best) = (theta, verdict);
                self.keep_best();
            } else {
                unsolved = theta;
            }
        }
        if self.corrections.theta == solved { Ok(best) } else { self.take_best(solved, best, report) }
    }

    /// Reduces θ where corrections put in more energy than they may.
    fn bound_energy(
        &mut self,
        settings: &Settings,
        v: &[f64],
        mut verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        let mut put_in = self.correction_energy();
        if put_in <= 0.0 || !settings.correction_speed.is_finite() {
            return Ok(verdict);
        }
        let speed = SPEEDS * settings.correction_speed;
        let mut bound = 0.5 * self.moving_mass * speed * speed;
        if put_in > bound {
            bound += PART_OF_ENERGY * self.kinetic_energy(v);
        }
        for reduction in 0..=REDUCTIONS {
            if put_in <= bound {
                break;
            }
            self.warm.keep(&self.builder.keys, &self.builder.group_keys, &self.solution);
            let theta = self.corrections.theta * (AIM * bound / put_in).sqrt().min(AIM);
            let theta = if reduction == REDUCTIONS { 0.0 } else { theta };
            verdict = self.attempt_part(theta, Effort::All, report)?;
            put_in = self.correction_energy();
        }
        Ok(verdict)
    }

    fn kinetic_energy(&mut self, v: &[f64]) -> f64 {
        let momentum = &mut self.best.velocity;
        momentum.resize(v.len(), 0.0);
        self.builder.problem.mass.multiply_into(v, momentum);
        0.5 * v.iter().zip(momentum).map(|(v, p)| v * *p).sum::<f64>()
    }

    /// Whether velocities are prescribed, which may be impossible.
    fn is_driven(&self) -> bool {
        self.builder.problem.bilateral_violation.len() > self.builder.bilateral_source.len()
    }

    fn correction_energy(&self) -> f64 {
        let constraints = self.builder.bilateral_source.len();
        energy(&self.builder.problem, &self.solution, &self.builder.impacts, constraints)
    }

    fn attempt_part(
        &mut self,
        theta: f64,
        effort: Effort,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        self.corrections.set(theta, &mut self.builder.problem);
        self.attempt(effort, report)
    }

    fn attempt(&mut self, effort: Effort, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let start = self.warm.start_for(&self.builder.keys, &self.builder.group_keys);
        let verdict = self.solver.solve_into(&mut self.builder.problem, Some(start), effort, &mut self.solution);
        report.solver.accumulate(&self.solution.report);
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
            return self.attempt_part(theta, Effort::All, report);
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
