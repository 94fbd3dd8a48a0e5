//! Bringing a state to rest: on the way by steps that are easy to solve, at the end by Coulomb's laws.
//!
//! The steps of a pile that settles are the hardest there are, and what they are wanted for is often only where they end. Here the
//! way is one of convex problems ([`SettlingSolver`](signorini_laws::SettlingSolver)) with a large Δt, in which velocity is taken away after every step. Their state
//! of rest is one of Coulomb's law, too, and an ordinary step with its certificate says so.

mod pace;
mod report;
mod settler;

use std::ops::ControlFlow;

use signorini_multibody::Joint;

use crate::solver::StepSolver;
use crate::{ContactMethod, FrictionLaw, Simulation, SimulationError};
pub use report::{SettleProgress, SettleReport, SettleSettings};

use pace::{Calm, Pace};
use settler::Settler;

impl Simulation {
    /// Brings the state to rest: to a configuration, near the present one, from which the next step ends with velocity zero.
    ///
    /// The way there is no simulation. Friction is that of the step before, contacts give way a little, and velocity is taken
    /// away ([`SettleSettings`]): bodies fall, slide and tumble until they lie. The end is exact: all velocities are zero (where springs or
    /// servos hold a load, [rounding](SettleReport::speed)), an ordinary step from there ends where it began, and its
    /// [certificate](crate::StepReport::certificate) holds within the tolerance of the settings. The impulses of that step are the warm start
    /// of the next one. Time and input stay; the summary counts none of these steps. A state that rests stays where it is, to rounding;
    /// only large piles, hundreds of bodies, may settle by tenths of a millimetre where the impulses that hold them are not found again.
    /// Methods for LCPs leave velocities of rounding, which no step after another loses: with one of them these steps are the structured
    /// solver's, for the same laws.
    ///
    /// # Errors
    /// [`SimulationError::NotSettled`] if the steps are used up: something slides, rolls or falls for ever, or settles slowly. The
    /// state is then the one reached, with the velocity it has there. [`SimulationError::Setting`] for a setting out of its range,
    /// [`SimulationError::Incompatible`] with the circular cone;
    /// [`SimulationError::Problem`] for friction that is no contact's sliding (joints, servos, spinning, rolling), which
    /// these steps do not have; otherwise as for [`step`](Self::step).
    pub fn settle(&mut self, settings: &SettleSettings) -> Result<SettleReport, SimulationError> {
        self.settle_while(settings, |_| ControlFlow::Continue(()))
    }

    /// [`settle`](Self::settle), which for large piles takes minutes, with a function that is told after each step how far it is, and
    /// that may end it.
    ///
    /// # Errors
    /// As for [`settle`](Self::settle); [`SimulationError::NotSettled`] where the function ended it.
    pub fn settle_while(
        &mut self,
        settings: &SettleSettings,
        goes_on: impl FnMut(&SettleProgress) -> ControlFlow<()>,
    ) -> Result<SettleReport, SimulationError> {
        settings.validate()?;
        if self.settings.friction_law == FrictionLaw::Circular {
            let reason = "steps with the circular cone end with velocities of rounding, never at rest";
            return Err(SimulationError::Incompatible { settings: ["friction_law", "settle"], reason });
        }
        self.check_assembly()?;
        let ContactMethod::Lcp(_) = self.settings.method else { return self.settle_by_its_solver(settings, goes_on) };
        let exact = self.settings.clone().with_method(ContactMethod::default());
        let exact = StepSolver::new(&exact, exact.sleeps(&self.model))?;
        let own = std::mem::replace(&mut self.workspace.solver, exact);
        let settled = self.settle_by_its_solver(settings, goes_on);
        self.workspace.solver = own;
        settled
    }

    /// [`settle_while`](Self::settle_while), whose ordinary steps are those of the workspace's solver.
    fn settle_by_its_solver(
        &mut self,
        settings: &SettleSettings,
        mut goes_on: impl FnMut(&SettleProgress) -> ControlFlow<()>,
    ) -> Result<SettleReport, SimulationError> {
        let mut settler = Settler::new(self, settings)?;
        let mut report = SettleReport::default();
        if self.state.v.iter().all(|v| *v == 0.0)
            && settler.seems_to_rest(self, &mut goes_on)?
            && let Some((at_rest, speed)) = settler.certify(self)?
        {
            return Ok(SettleReport { at_rest, speed, ..report });
        }
        let (mut calm, mut pace) = (Calm::default(), Pace::default());
        while report.steps < settings.max_steps && !settler.is_ended {
            let [speed, slack] = settler.find_step(self)?;
            report.steps += 1;
            pace.note(speed, settler.most_factorizations(), report.steps);
            settler.advance(pace.momentum(settings.momentum));
            if calm.asks(speed.max(slack), report.steps)
                && let Some((at_rest, speed)) = settler.certify(self)?
            {
                return Ok(SettleReport { factorizations: settler.factorizations, at_rest, speed, ..report });
            }
            settler.tell(report.steps, &mut goes_on);
            settler.set_stride(pace.stride);
        }
        let time = self.state.time;
        self.begin_at(&settler.state.clone().with_time(time));
        Err(self.not_settled(report.steps))
    }

    fn not_settled(&self, steps: u32) -> SimulationError {
        let v = &self.state.v;
        let fastest = (0..v.len()).fold(0, |a, b| if v[b].abs() > v[a].abs() { b } else { a });
        let moves = |joint: &&Joint| joint.v_index <= fastest;
        let body = self.model.joints.iter().filter(moves).max_by_key(|joint| joint.v_index).map(|joint| joint.body);
        SimulationError::NotSettled {
            steps,
            kinetic_energy: self.energy().0,
            body: body.map_or_else(String::new, |body| self.model.bodies[body.index()].name.clone()),
            speed: v.get(fastest).map_or(0.0, |v| v.abs()),
        }
    }
}
