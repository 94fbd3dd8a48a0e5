//! Derivatives of the momentum balance of a step, at its own velocity.

use glamx::glam::{DQuat, DVec3};

use super::balance::{BalanceDerivatives, Unsupported};
use super::coriolis::CoriolisTerms;
use super::inverse_dynamics::inverse_dynamics_derivatives_into;
use super::lengths::BalanceStep;
use crate::free_motion::{FreeMotion, joint_spring};
use crate::kinematics::Kinematics;
use crate::model::{Actuator, BodyId, Model, Transmission};
use crate::spatial::SpatialVector;
use crate::state::{Input, State};

/// Derivatives of the momentum balance of a step (formulation §1 with the implicit terms of [`free_motion_into`](crate::free_motion_into)).
///
/// - `kinematics`, `free`: of the state, as the step has them
/// - `velocity`: `v⁺`, `[nv]`
/// - `impulses`: for every body the moment about its origin and the force that it gets from outside over the step, world axes, N·m·s
///   and N·s
///
/// # Errors
/// [`Unsupported`] for actuators at sites that measure a length, for adhesion, for bodies that turn too fast for Δt.
///
/// # Panics
/// If a length does not fit the model.
pub fn balance_derivatives_into(
    model: &Model,
    kinematics: &Kinematics,
    (state, input): (&State, &Input),
    dt: f64,
    free: &FreeMotion,
    (velocity, impulses): (&[f64], &[SpatialVector]),
    out: &mut BalanceDerivatives,
) -> Result<(), Unsupported> {
    if let Some(dof) = free.coriolis.first_unresolved() {
        return Err(too_fast(model, dof));
    }
    let step = BalanceStep { model, kinematics, state, input, velocity, dt, free };
    begin_balance(&step, impulses, out)?;
    out.turns = free.coriolis.could_turn();
    if !out.turns {
        return Ok(());
    }
    let mut coriolis = out.coriolis.take().unwrap_or_else(|| Box::new(CoriolisTerms::new(model)));
    let mut at_end = out.at_end.take().unwrap_or_else(|| Box::new(BalanceDerivatives::new(model)));
    coriolis.set(model, kinematics, &state.v, dt, free);
    let end = BalanceStep { velocity: &free.free_velocity, ..step };
    begin_balance(&end, &coriolis.nothing, &mut at_end)?;
    add_coriolis(model.nv, dt, free, &coriolis, &mut at_end);
    add_coriolis(model.nv, dt, free, &coriolis, out);
    subtract_carried(model.nv, free, &at_end, &mut coriolis.columns, out);
    (out.coriolis, out.at_end) = (Some(coriolis), Some(at_end));
    Ok(())
}

/// Adds `T` to a balance, with its derivatives at fixed `w`.
fn add_coriolis(nv: usize, dt: f64, free: &FreeMotion, terms: &CoriolisTerms, out: &mut BalanceDerivatives) {
    let [ahead, behind] = &terms.halves;
    for k in free.coriolis.turning() {
        out.impulse[k] += terms.impulse[k];
        for entry in k * nv..(k + 1) * nv {
            out.by_configuration[entry] += dt * (ahead.by_configuration[entry] - behind.by_configuration[entry]);
            // ∂h/∂v at both is C(v) ± C(δ), and ∂T/∂v at fixed w is Δt (C(δ) − C(v)).
            out.by_velocity[entry] -= dt * behind.by_velocity[entry];
        }
    }
}

/// Takes from the derivatives of a balance what `w` has of them: those at the end of the motion without contact, times `K`.
fn subtract_carried(
    nv: usize,
    free: &FreeMotion,
    at_end: &BalanceDerivatives,
    [end, own]: &mut [Vec<f64>; 2],
    out: &mut BalanceDerivatives,
) {
    for (matrix, of_end) in [
        (&mut out.by_configuration, &at_end.by_configuration),
        (&mut out.by_velocity, &at_end.by_velocity),
        (&mut out.by_control, &at_end.by_control),
        (&mut out.by_force, &at_end.by_force),
    ] {
        let width = matrix.len().checked_div(nv).unwrap_or(0);
        for column in 0..width {
            let entries = || (0..nv).map(|row| row * width + column);
            entries().zip(end.iter_mut()).for_each(|(entry, x)| *x = of_end[entry]);
            entries().zip(own.iter_mut()).for_each(|(entry, x)| *x = matrix[entry]);
            free.coriolis.subtract_carried(end, own);
            entries().zip(&*own).for_each(|(entry, x)| matrix[entry] = *x);
        }
    }
}

fn too_fast(model: &Model, dof: usize) -> Unsupported {
    let part = format!("body '{}'", model.bodies[model.dof_body(dof).index()].name);
    Unsupported { part, reason: "it turns too fast for the time step" }
}

/// The balance with Coriolis forces of the beginning of the step.
fn begin_balance(
    step: &BalanceStep,
    impulses: &[SpatialVector],
    out: &mut BalanceDerivatives,
) -> Result<(), Unsupported> {
    let BalanceStep { model, kinematics, state, input, velocity, dt, free } = *step;
    out.margins.clear();
    out.by_drive.fill(0.0);
    out.by_control.fill(0.0);
    out.by_force.fill(0.0);
    out.by_force.iter_mut().step_by(model.nv + 1).for_each(|entry| *entry = -dt);
    for (out, impulse) in out.wrenches.iter_mut().zip(impulses) {
        *out = impulse.scaled(1.0 / dt);
    }
    for (a, actuator) in model.actuators.iter().enumerate() {
        add_site_wrench(model, kinematics, (a, actuator), free, &mut out.wrenches)?;
    }
    add_applied_wrenches(model, kinematics, input, &mut out.wrenches);
    for (k, a) in out.acceleration.iter_mut().enumerate() {
        *a = (velocity[k] - state.v[k]) / dt;
    }
    let BalanceDerivatives { dynamics, acceleration, wrenches, .. } = out;
    inverse_dynamics_derivatives_into(model, kinematics, &state.v, acceleration, wrenches, dynamics);
    let scaled = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to = dt * from);
    scaled(&mut out.impulse, &out.dynamics.force);
    scaled(&mut out.by_configuration, &out.dynamics.by_configuration);
    // What M (v⁺ − v) adds to it by v.
    for ((to, slope), mass) in out.by_velocity.iter_mut().zip(&out.dynamics.by_velocity).zip(&out.dynamics.mass) {
        *to = dt * slope - mass;
    }
    for (k, impulse) in out.impulse.iter_mut().enumerate() {
        *impulse -= dt * input.generalized_force.get(k).unwrap_or(&0.0);
    }
    hold_applied_wrenches(model, kinematics, input, dt, out);
    add_free_rotations(model, kinematics, state, dt, free, out)?;
    add_joint_springs(model, state, dt, velocity, out);
    check_pulls(model)?;
    let mut lengths = std::mem::take(&mut out.lengths);
    let done = step.add_tendons(&mut lengths, out).and_then(|()| step.add_actuators(&mut lengths, out));
    out.lengths = lengths;
    done
}

/// Whether what pulls is known where the derivative is taken.
fn check_pulls(model: &Model) -> Result<(), Unsupported> {
    let sticks = |actuator: &&Actuator| matches!(actuator.transmission, Transmission::Body { .. });
    match model.actuators.iter().find(sticks) {
        None => Ok(()),
        Some(actuator) => {
            let part = format!("actuator '{}'", actuator.name);
            Err(Unsupported { part, reason: "what sticks pulls where it touches" })
        }
    }
}

/// The wrenches of the input, at the bodies' origins.
fn add_applied_wrenches(model: &Model, kinematics: &Kinematics, input: &Input, wrenches: &mut [SpatialVector]) {
    for (i, wrench) in input.wrench.iter().enumerate() {
        let arm = kinematics.rotation[i] * model.bodies[i].inertia.center_of_mass;
        let angular = wrench.angular + arm.cross(wrench.linear);
        wrenches[i] += SpatialVector { angular, linear: wrench.linear };
    }
}

/// Takes back that the wrenches of the input turn with their bodies: they keep their direction in world.
fn hold_applied_wrenches(model: &Model, kinematics: &Kinematics, input: &Input, dt: f64, out: &mut BalanceDerivatives) {
    for (i, wrench) in input.wrench.iter().enumerate().filter(|(_, wrench)| **wrench != SpatialVector::ZERO) {
        let (body, center) = (BodyId(i as u32), kinematics.center_of_mass[i]);
        for column in model.dofs_moving(body) {
            let turn = out.dynamics.motion.displacement(column, center).angular;
            let turned = SpatialVector { angular: turn.cross(wrench.angular), linear: turn.cross(wrench.linear) };
            for row in model.dofs_moving(body) {
                let power = out.dynamics.motion.displacement(row, center).dot(turned);
                BalanceDerivatives::add(&mut out.by_configuration, model.nv, row, column, dt * power);
            }
        }
    }
}

/// A motor at a site without reference is a wrench fixed to its body.
fn add_site_wrench(
    model: &Model,
    kinematics: &Kinematics,
    (a, actuator): (usize, &Actuator),
    free: &FreeMotion,
    wrenches: &mut [SpatialVector],
) -> Result<(), Unsupported> {
    let Transmission::Site { site, reference, wrench } = &actuator.transmission else { return Ok(()) };
    let law = free.laws[a];
    if reference.is_some() || law.stiffness != 0.0 || law.damping != 0.0 {
        let part = format!("actuator '{}'", actuator.name);
        return Err(Unsupported { part, reason: "it measures the motion of a site" });
    }
    let site = &model.sites[site.index()];
    let pose = &kinematics.pose[site.body.index()];
    let axes: DQuat = pose.rotation * site.placement.rotation;
    let size = law.value * actuator.gear;
    let force = axes * DVec3::from_slice(wrench) * size;
    let moment = axes * DVec3::from_slice(&wrench[3..]) * size;
    let arm = pose.rotation * site.placement.position;
    wrenches[site.body.index()] += SpatialVector { angular: moment + arm.cross(force), linear: force };
    Ok(())
}

fn add_free_rotations(
    model: &Model,
    kinematics: &Kinematics,
    state: &State,
    dt: f64,
    free: &FreeMotion,
    out: &mut BalanceDerivatives,
) -> Result<(), Unsupported> {
    let nv = model.nv;
    for body in &free.free_rotations {
        let (translation, rotation) = body.dofs();
        let owner = model.dof_body(rotation);
        let Some([linear, angular]) = body.correction_slope(&state.v, dt) else {
            return Err(too_fast(model, rotation));
        };
        let correction = body.correction(kinematics, &state.v, dt);
        let turn = kinematics.rotation[owner.index()];
        let own = turn.transpose() * correction.linear;
        for (b, axis) in DVec3::AXES.into_iter().enumerate() {
            let columns =
                [(rotation, angular.col(b), correction.angular), (0, turn * linear.col(b), correction.linear)];
            for a in 0..3 {
                out.by_velocity[(rotation + a) * nv + rotation + b] -= columns[0].1[a];
                if let Some(first) = translation {
                    out.by_velocity[(first + a) * nv + rotation + b] -= columns[1].1[a];
                    out.by_configuration[(first + a) * nv + rotation + b] -= (turn * axis.cross(own))[a];
                }
            }
        }
        for a in 0..3 {
            out.impulse[rotation + a] -= correction.angular[a];
            if let Some(first) = translation {
                out.impulse[first + a] -= correction.linear[a];
            }
        }
    }
    Ok(())
}

fn add_joint_springs(model: &Model, state: &State, dt: f64, velocity: &[f64], out: &mut BalanceDerivatives) {
    for joint in model.joints.iter().filter(|joint| joint.damping != 0.0 || joint.stiffness != 0.0) {
        let force = joint_spring(joint, state);
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            out.impulse[k] -= dt * force.at(state.v[k], velocity[k], dt);
            BalanceDerivatives::add(&mut out.by_velocity, model.nv, k, k, -dt * force.rise(dt));
            if joint.kind.nv() == 1 {
                BalanceDerivatives::add(&mut out.by_configuration, model.nv, k, k, dt * joint.stiffness);
            }
        }
    }
}
