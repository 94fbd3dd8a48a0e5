//! Motors that hold a posture with bounded torque.

use signorini_multibody::Model;
use signorini_multibody::model::{Actuator, ActuatorKind};
use signorini_simulation::SimulationError;

/// The model whose actuators hold still with whatever force within their ranges that takes: "does this robot hold this posture?"
///
/// Every actuator becomes a servo of speed zero within its force range; of a motor without one the range of its control counts. Its torque is
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

fn force_range(actuator: &Actuator) -> Option<[f64; 2]> {
    let of_control = |gain: f64| {
        let [a, b] = actuator.control_range?.map(|u| gain * u);
        Some([a.min(b), a.max(b)])
    };
    actuator.force_range.or_else(|| match actuator.kind {
        ActuatorKind::Motor => of_control(1.0),
        ActuatorKind::Affine { gain: [gain, 0.0, 0.0], bias: [0.0, 0.0, 0.0] } => of_control(gain),
        _ => None,
    })
}
