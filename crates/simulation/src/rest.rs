//! Steps that end where they began: while nothing changes, the next one is the same.

use signorini_multibody::{Input, State};

use crate::report::StepReport;

/// The last step, if it ended where it began. The problem and the solution of it are those in the workspace.
#[derive(Clone, Debug, Default)]
pub(crate) struct FixedPoint {
    holds: bool,
    q: Vec<f64>,
    v: Vec<f64>,
    activation: Vec<f64>,
    input: Input,
    dt: f64,
    report: StepReport,
}

impl FixedPoint {
    /// Forgets the last step.
    pub fn clear(&mut self) {
        self.holds = false;
    }

    /// How the step from here goes, if it is the last one again: same configuration, velocity, activations, input and Δt, bit for bit.
    pub fn report(&self, state: &State, input: &Input, dt: f64) -> Option<&StepReport> {
        let same = self.holds
            && self.dt == dt
            && same_bits(&self.v, &state.v)
            && same_bits(&self.q, &state.q)
            && same_bits(&self.activation, &state.activation)
            && same_bits(&self.input.control, &input.control)
            && self.input.mocap == input.mocap
            && self.input.wrench == input.wrench
            && same_bits(&self.input.generalized_force, &input.generalized_force);
        same.then_some(&self.report)
    }

    /// Takes note of a step from `state` to `next`.
    pub fn observe(&mut self, state: &State, input: &Input, next: &State, dt: f64, report: &StepReport) {
        let plain = report.advanced()
            && !report.missed_tolerance
            && !report.clipped_gaps
            && report.theta == 1.0
            && report.impacts == 0;
        let remembered = same_bits(&state.activation, &next.activation);
        self.holds = plain && remembered && same_bits(&state.v, &next.v) && same_bits(&state.q, &next.q);
        if !self.holds {
            return;
        }
        self.q.clone_from(&state.q);
        self.v.clone_from(&state.v);
        self.activation.clone_from(&state.activation);
        self.input.control.clone_from(&input.control);
        self.input.mocap.clone_from(&input.mocap);
        self.input.wrench.clone_from(&input.wrench);
        self.input.generalized_force.clone_from(&input.generalized_force);
        self.dt = dt;
        self.report.clone_from(report);
        let islands = report.solver.islands;
        self.report.solver = Default::default();
        (self.report.solver.islands, self.report.solver.sleeping_islands) = (islands, islands);
        (self.report.enlargements, self.report.unresolved_rotations) = (0, report.unresolved_rotations);
    }
}

pub(crate) fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}
