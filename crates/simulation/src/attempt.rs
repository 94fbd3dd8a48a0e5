//! One problem of a step, and the best solution so far.

use signorini_contact::ContactSolution;
use signorini_solver::Patience;

use crate::SimulationError;
use crate::report::StepReport;
use crate::solver::Verdict;
use crate::workspace::Workspace;

impl Workspace {
    /// Solves the problem at hand with this part of the limited corrections.
    pub(crate) fn attempt_part(
        &mut self,
        theta: f64,
        patience: Patience,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        self.corrections.set(theta, &mut self.builder.problem);
        self.attempt(patience, report)
    }

    /// Solves the problem at hand.
    pub(crate) fn attempt(&mut self, patience: Patience, report: &mut StepReport) -> Result<Verdict, SimulationError> {
        let start = self.warm.start_for(&self.builder.keys, &self.builder.group_keys);
        let verdict = self.solver.solve_into(&mut self.builder.problem, Some(start), patience, &mut self.solution);
        report.solver.accumulate(&self.solution.report);
        report.solves += 1;
        verdict
    }

    /// The solution of the last step's problem that is found without a start, where one is: it is another one than the step's where its laws have
    /// several and the start of the step decided. The step's own solution stays what it is.
    pub fn solve_without_start(&mut self) -> Option<&ContactSolution> {
        let mut problem = self.rows().problem.clone();
        let Self { solver, best, .. } = self;
        let verdict = solver.solve_into(&mut problem, None, Patience::Full, best).ok()?;
        verdict.holds.then_some(&*best)
    }

    /// Keeps the solution at hand, from which the next ones start.
    pub(crate) fn keep_best(&mut self) {
        self.warm.keep(&self.builder.keys, &self.builder.group_keys, &self.solution);
        self.best.clone_from(&self.solution);
    }

    /// Gives the problem the part θ whose solution was kept, and that solution.
    pub(crate) fn take_best(
        &mut self,
        theta: f64,
        verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        if !self.solver.keeps_directions() {
            return self.attempt_part(theta, Patience::Full, report);
        }
        self.corrections.set(theta, &mut self.builder.problem);
        std::mem::swap(&mut self.solution, &mut self.best);
        Ok(verdict)
    }
}
