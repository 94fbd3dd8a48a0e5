//! Derivatives of a step's momentum balance by numbers of the model.

use glamx::glam::{DMat3, DVec3};

use super::balance::BalanceDerivatives;
use super::drive::drive_by_timestep;
use super::inverse_dynamics::InverseDynamicsDerivatives;
use crate::composite::{RigidInertia, momentum};
use crate::free_motion::{AffineForce, FreeMotion, is_before, joint_spring, tendon_spring};
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::{outer, scalar};
use crate::model::{ActuatorId, BodyId, Inertia, Joint, JointId, JointKind, Model, Transmission};
use crate::spatial::SpatialVector;
use crate::state::{Input, State};

/// A change of a body's inertia: of its ten numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaChange {
    /// Of the mass, kg; centre and rotational inertia about it stay.
    pub mass: f64,
    /// Of the centre of mass in the body's axes, m.
    pub center_of_mass: DVec3,
    /// Of the rotational inertia about the centre of mass in the body's axes, kg·m².
    pub rotational: DMat3,
}

impl InertiaChange {
    /// No change.
    pub const ZERO: Self = Self { mass: 0.0, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };

    /// The change of mass, first moment and inertia about the origin of the body.
    fn about_origin(&self, inertia: &Inertia) -> RigidInertia {
        let (m, c, dc) = (inertia.mass, inertia.center_of_mass, self.center_of_mass);
        let square = |c: DVec3| scalar(c.length_squared()) - outer(c, c);
        let turned = scalar(2.0 * c.dot(dc)) - outer(c, dc) - outer(dc, c);
        RigidInertia {
            mass: self.mass,
            first_moment: c * self.mass + dc * m,
            rotational: self.rotational + square(c) * self.mass + turned * m,
        }
    }
}

/// What `E` is differentiated at: the arguments of [`balance_derivatives_into`](super::balance_derivatives_into), which has been called
/// with them.
#[derive(Clone, Copy)]
pub struct BalanceAt<'a> {
    /// The model.
    pub model: &'a Model,
    /// Of the state.
    pub kinematics: &'a Kinematics,
    /// The state at the beginning of the step.
    pub state: &'a State,
    /// Of the step.
    pub input: &'a Input,
    /// Δt, s.
    pub dt: f64,
    /// Of the step.
    pub free: &'a FreeMotion,
    /// `v⁺`, `[nv]`.
    pub velocity: &'a [f64],
    /// Impulses from outside, as for the balance.
    pub impulses: &'a [SpatialVector],
    /// What was computed.
    pub balance: &'a BalanceDerivatives,
}

/// Where the balance is differentiated, at fixed velocities: at `v⁺` or at the end of the motion without contact.
#[derive(Clone, Copy)]
struct Place<'a> {
    at: BalanceAt<'a>,
    /// Of its velocity.
    own: &'a BalanceDerivatives,
}

impl BalanceAt<'_> {
    /// Adds `∂E` by a number of the model, times a change of it, to `out`, `[nv]`.
    ///
    /// # Source
    /// With the Coriolis forces of [`free_motion_into`](crate::free_motion_into): what the change does to the motion without contact is in them.
    pub fn add(&self, change: &BalanceChange, out: &mut [f64]) {
        Place { at: *self, own: self.balance }.add(change, out);
        let Some((coriolis, at_end)) = self.balance.free_end() else { return };
        let at = BalanceAt { velocity: &self.free.free_velocity, impulses: &coriolis.nothing, ..*self };
        let mut end = vec![0.0; self.model.nv];
        Place { at, own: at_end }.add(change, &mut end);
        self.free.coriolis.subtract_carried(&mut end, out);
    }
}

/// A change of a number that the balance depends on.
#[derive(Clone, Debug)]
pub enum BalanceChange {
    /// Of a body's inertia.
    Inertia(BodyId, InertiaChange),
    /// Of gravity, m/s².
    Gravity(DVec3),
    /// Of the numbers of a joint.
    Joint(JointId, JointChange),
    /// Of the activation of an actuator.
    Activation(ActuatorId, f64),
    /// Of the time step, s; the impulses stay.
    Timestep(f64),
}

impl Place<'_> {
    fn add(&self, change: &BalanceChange, out: &mut [f64]) {
        match change {
            BalanceChange::Inertia(body, change) => self.add_by_inertia(*body, change, out),
            BalanceChange::Gravity(change) => self.add_by_gravity(*change, out),
            BalanceChange::Joint(joint, change) => {
                if let Some(joint) = self.at.model.joints.get(joint.index()) {
                    self.add_by_joint(joint, change, out);
                }
            }
            BalanceChange::Activation(actuator, change) => self.add_by_activation(actuator.index(), *change, out),
            BalanceChange::Timestep(change) => self.add_by_timestep(*change, out),
        }
    }

    /// # Source
    /// The wrench of a body is linear in its mass, first moment and inertia about the origin (Atkeson, An, Hollerbach 1986); the
    /// equation of the variational integrator is differentiated implicitly.
    fn add_by_inertia(&self, body: BodyId, change: &InertiaChange, out: &mut [f64]) {
        let (model, dynamics) = (self.at.model, &self.own.dynamics);
        let own = &model.bodies[body.index()];
        let Some(l) = dynamics.motion.links.of_body[body.index()] else { return };
        let local = change.about_origin(&own.inertia);
        let placed = local.turned(self.at.kinematics.rotation[body.index()]);
        let arm = self.at.kinematics.pose[body.index()].position - dynamics.motion.reference[l];
        let mut inertia = RigidInertia::ZERO;
        inertia.add_at(&placed, arm);
        let share = own.gravity_compensation;
        let held = RigidInertia {
            mass: share * placed.mass,
            first_moment: placed.first_moment * share,
            rotational: DMat3::ZERO,
        };
        let mut floating = RigidInertia::ZERO;
        floating.add_at(&held, arm);
        let gravity = self.gravity();
        let wrench = |dynamics: &InverseDynamicsDerivatives| {
            let v = dynamics.motion.after[l];
            momentum(&inertia, dynamics.links[l].after) + v.carry_wrench(momentum(&inertia, v))
                - momentum(&floating, gravity)
        };
        // All links of a tree have one reference.
        let power = |k: usize, wrench: SpatialVector| self.at.dt * dynamics.motion.axis[k].dot(wrench);
        let own = wrench(dynamics);
        model.dofs_moving(body).for_each(|k| out[k] += power(k, own));
        if let Some((coriolis, _)) = self.at.balance.free_end() {
            let [ahead, behind] = coriolis.halves.each_ref().map(wrench);
            let turning = model.dofs_moving(body).filter(|&k| self.at.free.coriolis.turns(k));
            turning.for_each(|k| out[k] += power(k, ahead - behind));
        }
        self.add_to_integrator(body, &local, out);
    }

    fn gravity(&self) -> SpatialVector {
        SpatialVector { angular: DVec3::ZERO, linear: -self.at.model.gravity }
    }

    /// What a change of inertia does to the variational integrator of a body that turns freely with `body` welded to it.
    fn add_to_integrator(&self, body: BodyId, change: &RigidInertia, out: &mut [f64]) {
        let root = self.at.model.body_weld[body.index()];
        for rotation in &self.at.free.free_rotations {
            let (translation, first) = rotation.dofs();
            if self.at.model.dof_body(first) != root {
                continue;
            }
            let (pose, root_pose) = (self.at.kinematics.pose[body.index()], self.at.kinematics.pose[root.index()]);
            let turn = (root_pose.rotation.conjugate() * pose.rotation).normalize();
            let from_root = root_pose.rotation.conjugate() * (pose.position - root_pose.position);
            let mut whole = RigidInertia::ZERO;
            let anchor = rotation.anchor(self.at.model);
            whole.add_at(&change.turned(DMat3::from_quat(turn)), from_root - anchor);
            let Some(slope) = rotation.correction_by_inertia(&self.at.state.v, self.at.dt, &whole) else { continue };
            self.subtract_correction((translation, first, root), slope, out);
        }
    }

    fn subtract_correction(
        &self,
        (translation, rotation, root): (Option<usize>, usize, BodyId),
        [linear, angular]: [DVec3; 2],
        out: &mut [f64],
    ) {
        let linear = self.at.kinematics.rotation[root.index()] * linear;
        for a in 0..3 {
            out[rotation + a] -= angular[a];
            if let Some(first) = translation {
                out[first + a] -= linear[a];
            }
        }
    }

    fn add_by_gravity(&self, change: DVec3, out: &mut [f64]) {
        let dynamics = &self.own.dynamics;
        let fall = SpatialVector { angular: DVec3::ZERO, linear: -change };
        for (l, link) in dynamics.motion.links.all.iter().enumerate() {
            let whole = &dynamics.links[l];
            let wrench = momentum(&whole.inertia, fall) - momentum(&whole.floating, fall);
            for k in link.dofs.clone() {
                out[k] += self.at.dt * dynamics.motion.axis[k].dot(wrench);
            }
        }
    }

    fn add_by_joint(&self, joint: &Joint, change: &JointChange, out: &mut [f64]) {
        let dt = self.at.dt;
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            let end = self.at.velocity[k];
            out[k] += dt * change.damping * end + change.armature * (end - self.at.state.v[k]);
            let stretch = match joint.kind {
                JointKind::Hinge { .. } | JointKind::Slide { .. } => {
                    self.at.state.q[joint.q_index] - joint.spring_reference
                }
                JointKind::Ball | JointKind::Free => 0.0,
            };
            out[k] += dt * change.stiffness * (stretch + 0.5 * dt * (end - self.at.state.v[k]));
            if joint.kind.nv() == 1 {
                out[k] -= dt * joint.stiffness * change.spring_reference;
            }
        }
        if change.armature == 0.0 || joint.kind != JointKind::Ball {
            return;
        }
        let slope = RigidInertia { rotational: scalar(change.armature), ..RigidInertia::ZERO };
        for rotation in self.at.free.free_rotations.iter().filter(|r| r.dofs() == (None, joint.v_index)) {
            if let Some(slope) = rotation.correction_by_inertia(&self.at.state.v, dt, &slope) {
                self.subtract_correction((None, joint.v_index, joint.body), slope, out);
            }
        }
    }

    fn add_by_activation(&self, a: usize, change: f64, out: &mut [f64]) {
        let nu = self.at.model.actuators.len();
        let slope = self.own.activation_share[a] * change;
        (0..self.at.model.nv).for_each(|k| out[k] += slope * self.own.by_drive[k * nu + a]);
    }

    fn add_by_timestep(&self, change: f64, out: &mut [f64]) {
        let (model, dt, dynamics) = (self.at.model, self.at.dt, &self.own.dynamics);
        // Inverse dynamics has M (v⁺ − v) + Δt (…) less the impulses: what has no Δt is taken off.
        let mut rest: Vec<f64> = dynamics.force.iter().map(|force| dt * force).collect();
        let change_of: Vec<f64> = self.at.velocity.iter().zip(&self.at.state.v).map(|(end, v)| end - v).collect();
        for (rest, mass) in rest.iter_mut().zip(dynamics.mass.chunks_exact(model.nv.max(1))) {
            *rest -= mass.iter().zip(&change_of).map(|(m, v)| m * v).sum::<f64>();
        }
        for (i, impulse) in self.at.impulses.iter().enumerate().filter(|(_, w)| **w != SpatialVector::ZERO) {
            let origin = self.at.kinematics.pose[i].position;
            for k in model.dofs_moving(BodyId(i as u32)) {
                rest[k] += dynamics.motion.displacement(k, origin).dot(*impulse);
            }
        }
        for (k, rest) in rest.iter().enumerate() {
            out[k] += change * (rest / dt - self.at.input.generalized_force.get(k).unwrap_or(&0.0));
        }
        if let Some((coriolis, _)) = self.at.balance.free_end() {
            out.iter_mut().zip(&coriolis.impulse).for_each(|(out, impulse)| *out += change * impulse / dt);
        }
        for rotation in &self.at.free.free_rotations {
            let (translation, first) = rotation.dofs();
            if let Some(slope) = rotation.correction_by_timestep(&self.at.state.v, dt) {
                let root = model.dof_body(first);
                self.subtract_correction((translation, first, root), slope.map(|x| x * change), out);
            }
        }
        for joint in model.joints.iter().filter(|joint| joint.damping != 0.0 || joint.stiffness != 0.0) {
            let force = joint_spring(joint, self.at.state);
            for k in joint.v_index..joint.v_index + joint.kind.nv() {
                out[k] += change * self.by_timestep_of(force, self.at.state.v[k], self.at.velocity[k]);
            }
        }
        for (tendon, row) in model.tendons.iter().zip(&self.at.free.tendon_rows) {
            self.add_length(tendon_spring(tendon, row.length), row, change, out);
        }
        let nu = model.actuators.len();
        for (a, actuator) in model.actuators.iter().enumerate() {
            if !matches!(actuator.transmission, Transmission::Site { .. }) {
                self.add_length(self.at.free.laws[a], &self.at.free.actuator_rows[a], change, out);
            }
            let slope = drive_by_timestep(actuator, (self.at.state, self.at.input), a, dt) * change;
            (0..model.nv).for_each(|k| out[k] += slope * self.own.by_drive[k * nu + a]);
        }
    }

    /// `∂/∂Δt` of `−Δt f(v⁺)`.
    fn by_timestep_of(&self, force: AffineForce, begin: f64, end: f64) -> f64 {
        self.at.dt * force.stiffness * end + force.rise(self.at.dt) * (end - begin) - force.at(begin, end, self.at.dt)
    }

    fn add_length(&self, force: AffineForce, row: &LengthRow, change: f64, out: &mut [f64]) {
        let own = self.by_timestep_of(force, row.rate(&self.at.state.v), row.rate(self.at.velocity)) * change;
        let weight = (force.slope(self.at.dt) + self.at.dt * force.stiffness + force.rise(self.at.dt)) * change;
        let gain = |k: usize| self.at.velocity[k] - self.at.state.v[k];
        for (i, (&k, &g)) in row.dofs.iter().zip(&row.gradient).enumerate() {
            out[k] += own * g;
            for (&l, &other) in row.dofs[..i].iter().zip(&row.gradient) {
                if !is_before(self.at.model, l, k) {
                    let coupling = g * other;
                    out[k] += weight * (coupling.abs() * gain(k) - coupling * gain(l));
                    out[l] += weight * (coupling.abs() * gain(l) - coupling * gain(k));
                }
            }
        }
    }
}

/// A change of a joint's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointChange {
    /// Of the damping, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// Of the stiffness, N/m or N·m/rad.
    pub stiffness: f64,
    /// Of the rotor inertia, kg or kg·m².
    pub armature: f64,
    /// Of the spring's rest value, m or rad.
    pub spring_reference: f64,
}
