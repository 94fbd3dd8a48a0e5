//! Rows of the mechanism itself: equality constraints, dry friction in joints, servos of speed (formulation §5).

use signorini_contact::FrictionBound;
use signorini_multibody::{ActuatorKind, Input, Kinematics, Model, State, actuator_length_into, equality_block_into};

use super::builder::ProblemBuilder;
use super::pace::rounded;
use super::rows::push_rows;
use crate::source::{BilateralSource, FrictionSource};

impl ProblemBuilder {
    /// Bilateral rows of all equality constraints, but for those that follow from others.
    pub(super) fn push_equalities(&mut self, model: &Model, kinematics: &Kinematics, state: &State) {
        (self.constraint_error, self.corrects_constraints) = (0.0, true);
        let dt = self.problem.timestep;
        self.bilateral_source.clear();
        for (e, equality) in model.equalities.iter().enumerate() {
            for b in 0..equality.kind.block_count() {
                equality_block_into(model, kinematics, &state.q, &equality.kind, b, &mut self.block);
                if self.all_stand(&self.block.rows.dofs) {
                    continue;
                }
                self.constraint_error = self.constraint_error.max(self.block.size());
                let part = self.pace.block_part(model, kinematics, state, (&equality.kind, b), &self.block, dt);
                self.corrects_constraints &= part == self.pace.stabilization;
                let Self { problem, block, assembly_tolerance, bilateral_source, .. } = self;
                push_rows(block, *assembly_tolerance, |axis, columns, violation| {
                    problem.push_bilateral(columns, part * rounded(violation, 1.0));
                    bilateral_source.push(BilateralSource { equality: e, block: b, axis });
                });
            }
        }
        self.dependent.leave_out(&mut self.problem, &mut self.bilateral_source);
    }

    /// Friction groups of joints with dry friction, one for each degree of freedom.
    pub(super) fn push_joint_friction(&mut self, model: &Model) {
        for (j, joint) in model.joints.iter().enumerate().filter(|(_, joint)| joint.friction_loss > 0.0) {
            let bound = FrictionBound::Impulse(joint.friction_loss * self.problem.timestep);
            for dof in (joint.v_index..joint.v_index + joint.kind.nv()).filter(|&dof| !self.stands[dof]) {
                self.problem.push_friction_row([(dof as u32, 1.0)], 0.0, bound);
                self.friction_source.push(FrictionSource::Joint { joint: j, dof });
            }
        }
    }

    /// Friction groups of servos of speed, in the rate of the actuator's length. The middle of the force range is part of the free motion; the group adds up to half
    /// of the range in either direction.
    pub(super) fn push_servos(&mut self, model: &Model, kinematics: &Kinematics, state: &State, input: &Input) {
        for (a, actuator) in model.actuators.iter().enumerate() {
            if let (ActuatorKind::Speed, Some([lower, upper])) = (actuator.kind, actuator.force_range) {
                actuator_length_into(model, kinematics, &state.q, actuator, &mut self.length);
                if self.all_stand(&self.length.dofs) {
                    continue;
                }
                let speed = actuator.drive(state, input, a, self.problem.timestep);
                let bound = FrictionBound::Impulse((upper - lower) / 2.0 * self.problem.timestep);
                let row = self.length.dofs.iter().zip(&self.length.gradient).map(|(&k, &g)| (k as u32, g));
                self.problem.push_friction_row(row, speed, bound);
                self.friction_source.push(FrictionSource::Servo { actuator: a });
            }
        }
    }
}
