//! Derivatives of the momentum balance of a step, at its own velocity.

use glamx::glam::{DQuat, DVec3};

use super::drive::{MarginSource, distance_to, drive_slopes};
use super::inverse_dynamics::{InverseDynamicsDerivatives, inverse_dynamics_derivatives_into};
use crate::free_motion::{AffineForce, FreeMotion, Saturation};
use crate::free_motion::{actuator_law, can_saturate, is_before, joint_spring, tendon_spring};
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::{read_quaternion, right_jacobian, rotation_log};
use crate::model::{ActivationKind, Actuator, ActuatorKind, BodyId, Model, Tendon, Transmission};
use crate::spatial::SpatialVector;
use crate::state::{Input, State};

/// A part of a model without derivatives.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{part} has no derivative: {reason}")]
pub struct Unsupported {
    /// Which part.
    pub part: String,
    /// Why.
    pub reason: &'static str,
}

/// `E(v⁺; q, v, u) = M̂ (v⁺ − v) − Δt (…)`, the impulse that contacts and constraints have to give for a step to end with `v⁺`, and its
/// derivatives at fixed `v⁺`. That by `v⁺` is `M̂`, that by the applied force `−Δt`.
#[derive(Clone, Debug)]
pub struct BalanceDerivatives {
    /// `E`, `[nv]`, N·s, N·m·s, less the impulses from outside.
    pub impulse: Vec<f64>,
    /// `∂E/∂q` in tangent coordinates, where the impulses from outside turn with their bodies, `[nv, nv]` row by row.
    pub by_configuration: Vec<f64>,
    /// `∂E/∂v`, `[nv, nv]` row by row.
    pub by_velocity: Vec<f64>,
    /// `∂E/∂u`, `[nv, nu]` row by row.
    pub by_control: Vec<f64>,
    /// `∂E` by what the force laws of actuators take as their control, `[nv, nu]` row by row.
    pub(super) by_drive: Vec<f64>,
    /// How that changes with the activation of each actuator, `[nu]`; 0 for one without.
    pub(super) activation_share: Vec<f64>,
    /// How far each inequality is from turning, relative to its range: what is 0 has two one-sided derivatives.
    pub margins: Vec<(MarginSource, f64)>,
    /// Inverse dynamics of the step's mean acceleration.
    pub dynamics: InverseDynamicsDerivatives,
    acceleration: Vec<f64>,
    wrenches: Vec<SpatialVector>,
}

impl BalanceDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (nv, nu) = (model.nv, model.actuators.len());
        Self {
            impulse: vec![0.0; nv],
            by_configuration: vec![0.0; nv * nv],
            by_velocity: vec![0.0; nv * nv],
            by_control: vec![0.0; nv * nu],
            by_drive: vec![0.0; nv * nu],
            activation_share: vec![0.0; nu],
            margins: Vec::new(),
            dynamics: InverseDynamicsDerivatives::new(model),
            acceleration: vec![0.0; nv],
            wrenches: vec![SpatialVector::ZERO; model.bodies.len()],
        }
    }

    fn add(matrix: &mut [f64], nv: usize, row: usize, column: usize, value: f64) {
        matrix[row * nv + column] += value;
    }
}

/// Derivatives of the momentum balance of a step (formulation §1 with the implicit terms of [`free_motion_into`](crate::free_motion_into)).
///
/// - `kinematics`, `free`: of the state, as the step has them
/// - `velocity`: `v⁺`, `[nv]`
/// - `impulses`: for every body the moment about its origin and the force that it gets from outside over the step, world axes, N·m·s
///   and N·s
///
/// # Errors
/// [`Unsupported`] for actuators at sites that measure a length, for bodies that turn too fast for Δt.
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
    out.margins.clear();
    out.by_drive.fill(0.0);
    out.by_control.fill(0.0);
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
    check_lengths(model)?;
    for (t, (tendon, row)) in model.tendons.iter().zip(&free.tendon_rows).enumerate() {
        let force = tendon_spring(tendon, row.length);
        let [lower, upper] = tendon.rest;
        if tendon.stiffness > 0.0 {
            let size = lower.abs().max(upper.abs()).max(row.length.abs()).max(f64::MIN_POSITIVE);
            let distance = (row.length - lower).abs().min((row.length - upper).abs());
            let is_switch = lower < upper;
            out.margins.push((MarginSource::Slack(t), if is_switch { distance / size } else { f64::INFINITY }));
        }
        let law = LawSlopes { by_length: -force.elasticity, by_rate: force.rise(dt), ..LawSlopes::default() };
        add_length(model, (force, law), (row, &row.gradient), (state, velocity, dt), None, out);
    }
    let nu = model.actuators.len();
    for (a, actuator) in model.actuators.iter().enumerate() {
        add_actuator(model, (a, actuator), (state, input), dt, free, velocity, out);
        let [by_input, by_activation] = drive_slopes(actuator, (state, input), a, dt, &mut out.margins);
        out.activation_share[a] = by_activation;
        for &k in &free.actuator_rows[a].dofs {
            out.by_control[k * nu + a] = by_input * out.by_drive[k * nu + a];
        }
    }
    Ok(())
}

/// Whether rows of lengths stay as they are when the configuration changes, and laws of forces are linear.
fn check_lengths(model: &Model) -> Result<(), Unsupported> {
    let pulls = |tendon: &Tendon| tendon.stiffness != 0.0 || tendon.damping != 0.0;
    let turns = |tendon: &Tendon| !tendon.path.is_empty();
    if let Some(tendon) = model.tendons.iter().find(|tendon| pulls(tendon) && turns(tendon)) {
        let part = format!("tendon '{}'", tendon.name);
        return Err(Unsupported { part, reason: "the row of a spatial tendon turns with its path" });
    }
    for actuator in &model.actuators {
        let remembers = actuator.activation.map(|activation| activation.kind);
        let reason = match (actuator.kind, &actuator.transmission) {
            _ if matches!(remembers, Some(ActivationKind::Muscle { .. })) => "the activation of a muscle is curved",
            (ActuatorKind::Muscle(_), _) => "the law of a muscle is curved",
            (_, Transmission::Tendon(tendon)) if turns(&model.tendons[tendon.index()]) => {
                "the row of a spatial tendon turns with its path"
            }
            (_, Transmission::Body { .. }) => "what sticks pulls where it touches",
            _ => continue,
        };
        return Err(Unsupported { part: format!("actuator '{}'", actuator.name), reason });
    }
    Ok(())
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
            let part = format!("body '{}'", model.bodies[owner.index()].name);
            return Err(Unsupported { part, reason: "it turns too fast for the time step" });
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

/// How an affine force changes with its own length, with its rate where that is explicit, and with its control: of its value, and of
/// its fall with the velocity at the end.
#[derive(Clone, Copy, Debug, Default)]
struct LawSlopes {
    by_length: f64,
    by_rate: f64,
    by_control: f64,
    fall_by_control: f64,
}

fn add_actuator(
    model: &Model,
    (a, actuator): (usize, &Actuator),
    (state, input): (&State, &Input),
    dt: f64,
    free: &FreeMotion,
    velocity: &[f64],
    out: &mut BalanceDerivatives,
) {
    let (row, law) = (&free.actuator_rows[a], free.laws[a]);
    let drive = actuator.drive(state, input, a, dt);
    let mut slopes = law_slopes(actuator, drive, row.length, row.rate(&state.v), dt);
    if can_saturate(actuator)
        && let Some([lower, upper]) = actuator.force_range
    {
        let unbounded = actuator_law(actuator, drive, row.length, row.rate(&state.v));
        let rate = row.rate(&free.free_velocity);
        let force = unbounded.at(rate, rate, dt);
        let distance = (force - lower).abs().min((force - upper).abs());
        out.margins.push((MarginSource::Force(a), distance / (upper - lower).max(f64::MIN_POSITIVE)));
        if free.saturation[a] != Saturation::Within {
            slopes = LawSlopes::default();
        }
    }
    if let (ActuatorKind::Motor, Some(range)) = (actuator.kind, actuator.force_range) {
        out.margins.push((MarginSource::Force(a), distance_to(drive, range)));
    }
    if let Transmission::Site { .. } = actuator.transmission {
        // The force itself is among the wrenches.
        for (&k, g) in row.dofs.iter().zip(&row.gradient) {
            out.by_drive[k * model.actuators.len() + a] -= dt * slopes.by_control * g;
        }
        return;
    }
    let turning: [f64; 3];
    let length_slope = match &actuator.transmission {
        Transmission::JointAxes { joint, axes } => {
            let joint = &model.joints[joint.index()];
            turning = match joint.kind.nv() {
                3 => {
                    let turn = rotation_log(read_quaternion(&state.q[joint.q_index..]));
                    (right_jacobian(turn).inverse().transpose() * DVec3::from_slice(axes) * actuator.gear).to_array()
                }
                _ => [0.0; 3],
            };
            &turning[..]
        }
        _ => &row.gradient[..],
    };
    add_length(model, (law, slopes), (row, length_slope), (state, velocity, dt), Some(a), out);
}

/// Adds a force along a length whose row does not change with the configuration.
///
/// - `length_slope`: of the length by the degrees of freedom of the row
fn add_length(
    model: &Model,
    (force, slopes): (AffineForce, LawSlopes),
    (row, length_slope): (&LengthRow, &[f64]),
    (state, velocity, dt): (&State, &[f64], f64),
    actuator: Option<usize>,
    out: &mut BalanceDerivatives,
) {
    let (nv, nu) = (model.nv, model.actuators.len());
    let (begin, end) = (row.rate(&state.v), row.rate(velocity));
    let weight = dt * force.slope(dt);
    let lumped = |k: usize, coupling: f64, out: &mut BalanceDerivatives| {
        // The part of the implicit matrix that stands for couplings across branches acts on the change of velocity.
        out.impulse[k] += weight * coupling * (velocity[k] - state.v[k]);
        BalanceDerivatives::add(&mut out.by_velocity, nv, k, k, -weight * coupling);
        if let Some(a) = actuator {
            out.by_drive[k * nu + a] += dt * slopes.fall_by_control * coupling * (velocity[k] - state.v[k]);
        }
    };
    for (i, (&k, &g)) in row.dofs.iter().zip(&row.gradient).enumerate() {
        for (&l, &other) in row.dofs[..i].iter().zip(&row.gradient) {
            if !is_before(model, l, k) {
                let coupling = g * other;
                lumped(k, coupling.abs(), out);
                lumped(l, coupling.abs(), out);
                // What is left out of the matrix on both sides of the diagonal.
                for (r, c) in [(k, l), (l, k)] {
                    out.impulse[r] -= weight * coupling * (velocity[c] - state.v[c]);
                    BalanceDerivatives::add(&mut out.by_velocity, nv, r, c, weight * coupling);
                    if let Some(a) = actuator {
                        out.by_drive[r * nu + a] -= dt * slopes.fall_by_control * coupling * (velocity[c] - state.v[c]);
                    }
                }
            }
        }
    }
    for (&k, &g) in row.dofs.iter().zip(&row.gradient) {
        out.impulse[k] -= dt * force.at(begin, end, dt) * g;
        for (&l, slope) in row.dofs.iter().zip(length_slope) {
            BalanceDerivatives::add(&mut out.by_configuration, nv, k, l, -dt * slopes.by_length * g * slope);
        }
        for (&l, &other) in row.dofs.iter().zip(&row.gradient) {
            BalanceDerivatives::add(&mut out.by_velocity, nv, k, l, -dt * slopes.by_rate * g * other);
        }
        if let Some(a) = actuator {
            out.by_drive[k * nu + a] -= dt * (slopes.by_control - slopes.fall_by_control * end) * g;
        }
    }
}

fn law_slopes(actuator: &Actuator, drive: f64, length: f64, rate: f64, dt: f64) -> LawSlopes {
    let zero = LawSlopes::default();
    match actuator.kind {
        ActuatorKind::Motor => {
            let within = actuator.force_range.is_none_or(|[lower, upper]| lower < drive && drive < upper);
            LawSlopes { by_control: f64::from(within), ..zero }
        }
        ActuatorKind::Position { kp, .. } => LawSlopes { by_length: -kp, by_control: kp, ..zero },
        ActuatorKind::Velocity { kv } => LawSlopes { by_control: kv, ..zero },
        ActuatorKind::Affine { gain, bias } => {
            let [_, by_length, by_rate] = [0, 1, 2].map(|k| gain[k] * drive + bias[k]);
            let explicit = if by_rate > 0.0 { gain[2] * rate } else { 0.0 };
            let stiffer = if by_length < 0.0 { -gain[1] } else { 0.0 };
            let slower = if by_rate < 0.0 { -gain[2] } else { 0.0 };
            LawSlopes {
                by_length,
                by_rate: by_rate.max(0.0),
                by_control: gain[0] + gain[1] * length + explicit,
                fall_by_control: slower + dt * stiffer,
            }
        }
        // Refused before.
        ActuatorKind::Muscle(_) => zero,
        ActuatorKind::Speed => zero,
    }
}
