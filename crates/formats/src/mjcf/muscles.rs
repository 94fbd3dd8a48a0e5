//! Muscles: `<muscle>`, and `<general>` with the types of one.

use signorini_multibody::{
    ActivationKind, ActuatorId, ActuatorKind, Kinematics, LengthRow, MassMatrix, Model, Muscle, actuator_length_into,
    forward_kinematics_into, mass_matrix_into,
};

use super::law_numbers::{Dynamics, Form, LawNumbers};
use crate::error::{FormatError, Location};
use crate::report::Reporter;
use crate::xml::Attributes;

/// Places along a joint's range at which the search for the extreme lengths of an actuator looks.
const PLACES: usize = 33;

/// Where it ends, relative to a joint's range: a length near its extreme is known to the square of it.
const FINEST: f64 = 1e-7;

/// How often it goes over all joints.
const ROUNDS: usize = 4;

/// Which numbers of a bias its force depends on beside its size.
const PASSIVE: [usize; 5] = [0, 1, 2, 3, 5];

/// What a file says of a muscle.
pub(super) struct MuscleLaw {
    pub muscle: Muscle,
    pub activation: ActivationKind,
    /// The force times the acceleration that it causes, where the file does not give the force, N·m/s².
    scale: Option<f64>,
    has_length_range: bool,
}

/// A muscle of which the model has to be known: the acceleration that its force causes, or how long it can be.
pub(super) struct UnscaledMuscle {
    id: ActuatorId,
    at: Location,
    scale: Option<f64>,
    has_length_range: bool,
}

impl MuscleLaw {
    /// What is left to be found out of it as the actuator `id`.
    pub fn unscaled(&self, id: ActuatorId, at: Location) -> Option<UnscaledMuscle> {
        let Self { scale, has_length_range, .. } = *self;
        (scale.is_some() || !has_length_range).then_some(UnscaledMuscle { id, at, scale, has_length_range })
    }
}

/// The law of a muscle; nothing for other actuators, and for one whose passive force has curves of its own.
pub(super) fn muscle_law(a: &Attributes, numbers: &LawNumbers) -> Result<Option<MuscleLaw>, FormatError> {
    let LawNumbers { gain, bias, .. } = numbers;
    let passive = match numbers.bias_form {
        Form::Constant => 0.0,
        Form::Muscle if PASSIVE.iter().all(|&k| gain[k] == bias[k]) => bias[7],
        _ => return Ok(None),
    };
    if numbers.gain_form != Form::Muscle || numbers.dynamics != Dynamics::Muscle {
        return Ok(None);
    }
    let [low, high, force, scale, shortest, longest, fastest, _, lengthening] = *gain;
    let given = a.vector::<2>("lengthrange")?.filter(|[low, high]| low < high);
    let muscle = Muscle::new(force.max(0.0), given.unwrap_or([0.0, 1.0]))
        .with_range([low, high])
        .with_shortest(shortest)
        .with_longest(longest)
        .with_fastest(fastest)
        .with_passive(passive)
        .with_lengthening(lengthening);
    let [rise, fall, smoothing] = numbers.dynamics_numbers;
    let activation = ActivationKind::Muscle { times: [rise, fall], smoothing };
    let scale = (force < 0.0).then_some(scale);
    Ok(Some(MuscleLaw { muscle, activation, scale, has_length_range: given.is_some() }))
}

/// Forces that are given by the acceleration they cause at the reference configuration, `scale/|M⁻¹ ∇l|`, and length ranges.
pub(super) fn finish(model: &mut Model, muscles: &[UnscaledMuscle], report: &mut Reporter) {
    for unscaled in muscles {
        let a = unscaled.id.index();
        let force = unscaled.scale.and_then(|scale| Some(scale / acceleration(model, a)?));
        let range = (!unscaled.has_length_range).then(|| extreme_lengths(model, a));
        let ActuatorKind::Muscle(muscle) = &mut model.actuators[a].kind else { continue };
        muscle.force = force.filter(|force| force.is_finite()).unwrap_or(muscle.force);
        if let Some(range) = range {
            muscle.length_range = range;
            let effect = format!("its length is searched for between the limits of its joints: {range:?}");
            report.motion(
                unscaled.at.clone(),
                "muscle",
                "no 'lengthrange', which MuJoCo finds by a simulation",
                effect,
            );
        }
    }
}

/// `|M⁻¹ ∇l|` at the reference configuration; nothing where it moves nothing.
fn acceleration(model: &Model, actuator: usize) -> Option<f64> {
    let q = model.reference_configuration();
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &q, &vec![0.0; model.nv], &mut kinematics);
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, &kinematics, &mut mass);
    let factor = mass.matrix.factor().ok()?;
    let mut row = LengthRow::new(model);
    actuator_length_into(model, &kinematics, &q, &model.actuators[actuator], &mut row);
    let mut acceleration = vec![0.0; model.nv];
    row.dofs.iter().zip(&row.gradient).for_each(|(&k, &g)| acceleration[k] = g);
    factor.solve_in_place(&mut acceleration);
    Some(acceleration.iter().map(|x| x * x).sum::<f64>().sqrt()).filter(|x| *x > 0.0)
}

/// The smallest and the largest length of an actuator between the limits of the hinges and slides that move it, joint by joint; a joint
/// without limits stays, and what does not change its length gives it a range of 1.
fn extreme_lengths(model: &Model, actuator: usize) -> [f64; 2] {
    let (mut kinematics, mut row) = (Kinematics::new(model), LengthRow::new(model));
    let (actuator, v) = (&model.actuators[actuator], vec![0.0; model.nv]);
    let mut length = |q: &[f64]| {
        forward_kinematics_into(model, q, &v, &mut kinematics);
        actuator_length_into(model, &kinematics, q, actuator, &mut row);
        row.length
    };
    let limited = model.joints.iter().filter(|joint| joint.kind.nv() == 1).filter_map(|j| Some((j.q_index, j.limits?)));
    let limited: Vec<(usize, [f64; 2])> = limited.collect();
    let mut extreme = |sign: f64| {
        let mut q = model.reference_configuration();
        let mut best = sign * length(&q);
        for _ in 0..ROUNDS {
            for &(k, [low, high]) in &limited {
                let mut at = q[k];
                let mut try_at = |place: f64, at: &mut f64| {
                    q[k] = place.clamp(low, high);
                    let found = sign * length(&q);
                    let better = found > best;
                    (best, *at) = if better { (found, q[k]) } else { (best, *at) };
                    q[k] = *at;
                    better
                };
                let mut width = (high - low) / (PLACES - 1) as f64;
                (0..PLACES).for_each(|place| _ = try_at(low + width * place as f64, &mut at));
                while width > FINEST * (high - low) {
                    let moved = try_at(at - width, &mut at) || try_at(at + width, &mut at);
                    width *= if moved { 1.0 } else { 0.5 };
                }
            }
        }
        sign * best
    };
    let [low, high] = [extreme(-1.0), extreme(1.0)];
    if low < high { [low, high] } else { [low - 0.5, low + 0.5] }
}
