//! Derivatives of what acts along lengths: springs of tendons, actuators.

use glamx::glam::DVec3;

use super::balance::{BalanceDerivatives, Unsupported};
use super::curvature::LengthCurvature;
use super::drive::{MarginSource, distance_to, drive_slopes};
use crate::free_motion::{AffineForce, FreeMotion, Saturation};
use crate::free_motion::{actuator_law, can_saturate, is_before, tendon_spring};
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::{read_quaternion, right_jacobian, rotation_log};
use crate::model::{Actuator, ActuatorKind, Model, Muscle, Tendon, Transmission};
use crate::state::{Input, State};

/// A step whose balance is differentiated.
#[derive(Clone, Copy)]
pub(super) struct BalanceStep<'a> {
    pub model: &'a Model,
    pub kinematics: &'a Kinematics,
    pub state: &'a State,
    pub input: &'a Input,
    /// `v⁺`, `[nv]`.
    pub velocity: &'a [f64],
    /// Δt, s.
    pub dt: f64,
    pub free: &'a FreeMotion,
}

/// How a force along a length changes with the length, with its rate where that is explicit, and with what it takes as its control: its
/// value, and its fall with the velocity at the end of the step.
#[derive(Clone, Copy, Debug, Default)]
struct LawSlopes {
    value: [f64; 3],
    fall: [f64; 3],
}

/// A force along a length, with all that it changes by.
struct Pull<'a> {
    force: AffineForce,
    slopes: LawSlopes,
    row: &'a LengthRow,
    /// Slope of the length by the degrees of freedom of the row.
    by_place: &'a [f64],
    /// How the row of a tendon, by index, turns with the configuration; nothing where it stays.
    curvature: Option<(usize, &'a LengthCurvature)>,
    actuator: Option<usize>,
}

impl BalanceStep<'_> {
    /// Adds the springs and dampers of tendons.
    pub fn add_tendons(&self, turns: &mut LengthCurvature, out: &mut BalanceDerivatives) -> Result<(), Unsupported> {
        for (t, (tendon, row)) in self.model.tendons.iter().zip(&self.free.tendon_rows).enumerate() {
            let force = tendon_spring(tendon, row.length);
            let [lower, upper] = tendon.rest;
            if tendon.stiffness > 0.0 {
                let size = lower.abs().max(upper.abs()).max(row.length.abs()).max(f64::MIN_POSITIVE);
                let distance = (row.length - lower).abs().min((row.length - upper).abs());
                let is_switch = lower < upper;
                out.margins.push((MarginSource::Slack(t), if is_switch { distance / size } else { f64::INFINITY }));
            }
            if tendon.stiffness == 0.0 && tendon.damping == 0.0 {
                continue;
            }
            let curvature = self.curvature(t, (tendon, 1.0), row, turns, out)?;
            let slopes = LawSlopes { value: [-force.elasticity, 0.0, 0.0], fall: [0.0; 3] };
            let by_place = &row.gradient;
            self.add(Pull { force, slopes, row, by_place, curvature, actuator: None }, out);
        }
        Ok(())
    }

    /// Adds the actuators, and how they change with their controls.
    pub fn add_actuators(&self, turns: &mut LengthCurvature, out: &mut BalanceDerivatives) -> Result<(), Unsupported> {
        let nu = self.model.actuators.len();
        for (a, actuator) in self.model.actuators.iter().enumerate() {
            self.add_actuator((a, actuator), turns, out)?;
            let [by_input, by_activation] =
                drive_slopes(actuator, (self.state, self.input), a, self.dt, &mut out.margins);
            out.activation_share[a] = by_activation;
            for &k in &self.free.actuator_rows[a].dofs {
                out.by_control[k * nu + a] = by_input * out.by_drive[k * nu + a];
            }
        }
        Ok(())
    }

    fn add_actuator(
        &self,
        (a, actuator): (usize, &Actuator),
        turns: &mut LengthCurvature,
        out: &mut BalanceDerivatives,
    ) -> Result<(), Unsupported> {
        let (row, force) = (&self.free.actuator_rows[a], self.free.laws[a]);
        let drive = actuator.drive(self.state, self.input, a, self.dt);
        let slopes = self.law_of((a, actuator), drive, row, out);
        if let Transmission::Site { .. } = actuator.transmission {
            // The force itself is among the wrenches.
            for (&k, g) in row.dofs.iter().zip(&row.gradient) {
                out.by_drive[k * self.model.actuators.len() + a] -= self.dt * slopes.value[2] * g;
            }
            return Ok(());
        }
        let turning: [f64; 3];
        let mut by_place = &row.gradient[..];
        let mut curvature = None;
        match &actuator.transmission {
            Transmission::JointAxes { joint, axes } => {
                let joint = &self.model.joints[joint.index()];
                turning = match joint.kind.nv() {
                    3 => {
                        let turn = rotation_log(read_quaternion(&self.state.q[joint.q_index..]));
                        let back = right_jacobian(turn).inverse().transpose();
                        (back * DVec3::from_slice(axes) * actuator.gear).to_array()
                    }
                    _ => [0.0; 3],
                };
                by_place = &turning;
            }
            Transmission::Tendon(tendon) => {
                let t = tendon.index();
                curvature = self.curvature(t, (&self.model.tendons[t], actuator.gear), row, turns, out)?;
            }
            _ => {}
        }
        self.add(Pull { force, slopes, row, by_place, curvature, actuator: Some(a) }, out);
        Ok(())
    }

    /// How the row of a tendon turns; `scale`: of the row.
    fn curvature<'a>(
        &self,
        t: usize,
        (tendon, scale): (&Tendon, f64),
        row: &LengthRow,
        turns: &'a mut LengthCurvature,
        out: &mut BalanceDerivatives,
    ) -> Result<Option<(usize, &'a LengthCurvature)>, Unsupported> {
        if tendon.path.is_empty() {
            return Ok(None);
        }
        turns.set(self.model, self.kinematics, &out.dynamics.motion, tendon, row);
        if turns.by_configuration.iter().any(|x| !x.is_finite()) {
            let part = format!("tendon '{}'", tendon.name);
            return Err(Unsupported { part, reason: "its way past a geom is not smooth here" });
        }
        turns.scale(scale);
        out.margins.push((MarginSource::Path(t), turns.clearance));
        Ok(Some((t, turns)))
    }

    /// The slopes of an actuator's law, as it acts in the step.
    fn law_of(
        &self,
        (a, actuator): (usize, &Actuator),
        drive: f64,
        row: &LengthRow,
        out: &mut BalanceDerivatives,
    ) -> LawSlopes {
        let (length, rate) = (row.length, row.rate(&self.state.v));
        if let (ActuatorKind::Motor, Some(range)) = (actuator.kind, actuator.force_range) {
            out.margins.push((MarginSource::Force(a), distance_to(drive, range)));
        }
        if can_saturate(actuator)
            && let Some([lower, upper]) = actuator.force_range
        {
            let unbounded = actuator_law(actuator, drive, length, rate);
            let end = row.rate(&self.free.free_velocity);
            let force = unbounded.at(end, end, self.dt);
            let distance = (force - lower).abs().min((force - upper).abs());
            out.margins.push((MarginSource::Force(a), distance / (upper - lower).max(f64::MIN_POSITIVE)));
            if self.free.saturation[a] != Saturation::Within {
                return LawSlopes::default();
            }
        }
        if let ActuatorKind::Muscle(muscle) = &actuator.kind {
            let (slopes, margin) = muscle_slopes(muscle, drive, length, rate, self.dt);
            out.margins.push((MarginSource::Curve(a), margin));
            return slopes;
        }
        law_slopes(actuator, drive, length, rate, self.dt)
    }

    /// Adds a force along a length.
    fn add(&self, pull: Pull, out: &mut BalanceDerivatives) {
        let Pull { force, slopes, row, by_place, curvature, actuator } = &pull;
        let (nv, nu, dt) = (self.model.nv, self.model.actuators.len(), self.dt);
        let (begin, end) = (row.rate(&self.state.v), row.rate(self.velocity));
        let [by_length, by_rate, by_drive] = [0, 1, 2].map(|k| slopes.value[k] - slopes.fall[k] * end);
        let whole = force.at(begin, end, dt);
        for (&k, &g) in row.dofs.iter().zip(&row.gradient) {
            out.impulse[k] -= dt * whole * g;
            for (&l, slope) in row.dofs.iter().zip(*by_place) {
                BalanceDerivatives::add(&mut out.by_configuration, nv, k, l, -dt * by_length * g * slope);
            }
            for (&l, &other) in row.dofs.iter().zip(&row.gradient) {
                BalanceDerivatives::add(&mut out.by_velocity, nv, k, l, -dt * (by_rate + force.rise(dt)) * g * other);
            }
            if let Some(a) = actuator {
                out.by_drive[k * nu + a] -= dt * by_drive * g;
            }
        }
        if let Some((_, turns)) = curvature {
            let n = row.dofs.len();
            for (j, &l) in row.dofs.iter().enumerate() {
                let [turned_begin, turned_end] = [&self.state.v[..], self.velocity].map(|v| turns.turned(row, j, v));
                let change = (by_rate + force.rise(dt)) * turned_begin - force.slope(dt) * turned_end;
                for (i, (&k, &g)) in row.dofs.iter().zip(&row.gradient).enumerate() {
                    let own = change * g + whole * turns.by_configuration[i * n + j];
                    BalanceDerivatives::add(&mut out.by_configuration, nv, k, l, -dt * own);
                }
            }
        }
        self.add_across(&pull, out);
    }

    /// Adds what the implicit matrix has for couplings across branches: the part that stands for them acts on the change of velocity, and
    /// what is left out on both sides of the diagonal does not.
    fn add_across(&self, pull: &Pull, out: &mut BalanceDerivatives) {
        let (row, dt) = (pull.row, self.dt);
        let weight = dt * pull.force.slope(dt);
        let is_still = weight == 0.0 && pull.slopes.fall == [0.0; 3];
        let whole: f64 = row.gradient.iter().map(|g| g * g).sum();
        let mut least = f64::INFINITY;
        for (i, &k) in row.dofs.iter().enumerate().filter(|_| !is_still) {
            for (j, &l) in row.dofs[..i].iter().enumerate() {
                if !is_before(self.model, l, k) {
                    least = least.min((row.gradient[i] * row.gradient[j]).abs() / whole);
                    self.add_pair(pull, [(i, k), (j, l)], out);
                    self.add_pair(pull, [(j, l), (i, k)], out);
                }
            }
        }
        // Where a coupling changes its sign, its absolute value has a corner.
        if let Some((t, _)) = pull.curvature.filter(|_| least.is_finite()) {
            out.margins.push((MarginSource::Path(t), least));
        }
    }

    /// The equation of the first of two degrees of freedom, `weight (|c| Δv_k − c Δv_l)` with their coupling `c`.
    fn add_pair(&self, pull: &Pull, [(i, k), (j, l)]: [(usize, usize); 2], out: &mut BalanceDerivatives) {
        let Pull { force, slopes, row, by_place, curvature, actuator } = pull;
        let (nv, nu, dt) = (self.model.nv, self.model.actuators.len(), self.dt);
        let weight = dt * force.slope(dt);
        let coupling = row.gradient[i] * row.gradient[j];
        let [own, other] = [k, l].map(|d| self.velocity[d] - self.state.v[d]);
        let part = coupling.abs() * own - coupling * other;
        out.impulse[k] += weight * part;
        BalanceDerivatives::add(&mut out.by_velocity, nv, k, k, -weight * coupling.abs());
        BalanceDerivatives::add(&mut out.by_velocity, nv, k, l, weight * coupling);
        if let Some(a) = actuator {
            out.by_drive[k * nu + a] += dt * slopes.fall[2] * part;
        }
        let n = row.dofs.len();
        for (m, &d) in row.dofs.iter().enumerate() {
            let grown = slopes.fall[1] * row.gradient[m];
            BalanceDerivatives::add(&mut out.by_velocity, nv, k, d, dt * grown * part);
            let mut by_place = dt * slopes.fall[0] * by_place[m] * part;
            if let Some((_, turns)) = curvature {
                by_place += dt * slopes.fall[1] * turns.turned(row, m, &self.state.v) * part;
                let slope = |at: usize| turns.by_configuration[at * n + m];
                let change = slope(i) * row.gradient[j] + row.gradient[i] * slope(j);
                by_place += weight * change * (coupling.signum() * own - other);
            }
            BalanceDerivatives::add(&mut out.by_configuration, nv, k, d, by_place);
        }
    }
}

fn law_slopes(actuator: &Actuator, drive: f64, length: f64, rate: f64, dt: f64) -> LawSlopes {
    let constant = |value: [f64; 3]| LawSlopes { value, fall: [0.0; 3] };
    match actuator.kind {
        ActuatorKind::Motor => {
            let within = actuator.force_range.is_none_or(|[lower, upper]| lower < drive && drive < upper);
            constant([0.0, 0.0, f64::from(within)])
        }
        ActuatorKind::Position { kp, .. } => constant([-kp, 0.0, kp]),
        ActuatorKind::Velocity { kv } => constant([0.0, 0.0, kv]),
        ActuatorKind::Affine { gain, bias } => {
            let [_, by_length, by_rate] = [0, 1, 2].map(|k| gain[k] * drive + bias[k]);
            let explicit = if by_rate > 0.0 { gain[2] * rate } else { 0.0 };
            let stiffer = if by_length < 0.0 { -gain[1] } else { 0.0 };
            let slower = if by_rate < 0.0 { -gain[2] } else { 0.0 };
            let by_control = gain[0] + gain[1] * length + explicit;
            LawSlopes { value: [by_length, by_rate.max(0.0), by_control], fall: [0.0, 0.0, slower + dt * stiffer] }
        }
        // Its own function has it.
        ActuatorKind::Muscle(_) | ActuatorKind::Speed => LawSlopes::default(),
    }
}

/// The slopes of a muscle's law, whose stiffness and damping are its own slopes where it pulls back, and its distance from where they are not
/// smooth.
fn muscle_slopes(muscle: &Muscle, activation: f64, length: f64, rate: f64, dt: f64) -> (LawSlopes, f64) {
    let [_, by_length, by_rate, by_activation] = muscle.force_with_slopes(activation, length, rate);
    let [stiffer, slower] = muscle.curvature(activation, length, rate);
    let mut slopes = LawSlopes { value: [by_length, by_rate, by_activation], fall: [0.0; 3] };
    if by_rate < 0.0 {
        // The value is that without velocity: the force and its damping times the rate.
        slopes.value[1] -= by_rate;
        for k in 0..3 {
            slopes.value[k] -= slower[k] * rate;
            slopes.fall[k] -= slower[k];
        }
    }
    if by_length < 0.0 {
        (0..3).for_each(|k| slopes.fall[k] -= dt * stiffer[k]);
    }
    let mut margin = muscle.border(length, rate);
    for (slope, bend) in [(by_length, stiffer), (by_rate, slower)] {
        // Where it stays as it is when the state changes, it turns nowhere.
        if bend[0] != 0.0 || bend[1] != 0.0 {
            margin = margin.min(slope.abs() / muscle.force.max(f64::MIN_POSITIVE));
        }
    }
    (slopes, margin)
}
