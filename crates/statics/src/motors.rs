//! Motors that hold a posture with bounded torque.

use signorini_multibody::Model;
use signorini_multibody::model::{ActivationKind, Actuator, ActuatorKind};
use signorini_simulation::SimulationError;

/// The model whose actuators hold still with whatever force within their ranges that takes: "does this robot hold this posture?"
///
/// Every actuator becomes a servo of speed zero within its force range, a motor within what its control reaches of that. Its torque is
/// then a friction with a constant bound, so that verdicts, forces and safety factors speak of it as of any other
/// ([`SafetyQuestion::Motors`](crate::SafetyQuestion::Motors) is the torque margin). Controls and activations do not count.
///
/// # Errors
/// [`SimulationError::UnboundedMotor`] with the name of an actuator whose force has no bounds.
pub fn held_by_motors(model: &Model) -> Result<Model, SimulationError> {
    let mut held = model.clone();
    for actuator in &mut held.actuators {
        let Some(range) = force_range(actuator) else {
            return Err(SimulationError::UnboundedMotor { name: actuator.name.clone() });
        };
        (actuator.kind, actuator.force_range) = (ActuatorKind::Speed, Some(range));
        (actuator.control_range, actuator.activation) = (Some([0.0; 2]), None);
    }
    Ok(held)
}

/// The forces with which an actuator can hold still, where they have bounds.
fn force_range(actuator: &Actuator) -> Option<[f64; 2]> {
    let gain = match actuator.kind {
        ActuatorKind::Motor => Some(1.0),
        ActuatorKind::Affine { gain: [gain, 0.0, 0.0], bias: [0.0, 0.0, 0.0] } => Some(gain),
        _ => None,
    };
    let reached = gain.zip(drive_range(actuator)).map(|(gain, drive)| {
        let [a, b] = drive.map(|u| gain * u);
        [a.min(b), a.max(b)]
    });
    common(reached, actuator.force_range)
}

/// What can stand in for the control in the force law, in the long run.
fn drive_range(actuator: &Actuator) -> Option<[f64; 2]> {
    match &actuator.activation {
        None => actuator.control_range,
        Some(activation) if activation.kind == ActivationKind::Integrator => activation.range,
        Some(activation) => common(actuator.control_range, activation.range),
    }
}

/// The first range cut to the second, where there are both.
fn common(range: Option<[f64; 2]>, bound: Option<[f64; 2]>) -> Option<[f64; 2]> {
    match (range, bound) {
        (Some(range), Some([lower, upper])) => Some(range.map(|x| x.max(lower).min(upper))),
        (range, bound) => range.or(bound),
    }
}
