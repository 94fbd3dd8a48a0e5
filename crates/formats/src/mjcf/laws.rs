//! The force law of an actuator and how its activation follows the control.

use signorini_multibody::{ActivationKind, ActuatorKind};

use super::importer::Importer;
use super::law_numbers::{Dynamics, Form, LawNumbers};
use crate::error::FormatError;
use crate::xml::Attributes;

/// A time constant that is none, the least that MuJoCo divides by (`mjMINVAL`), s: at its end every step has forgotten the activation at its
/// beginning.
const AT_ONCE: f64 = 1e-15;

/// The law of an actuator and its activation; none if it depends on more than length, rate and one activation.
pub(super) fn law(
    importer: &mut Importer,
    a: &Attributes,
    numbers: &LawNumbers,
) -> Option<(ActuatorKind, Option<ActivationKind>)> {
    let gain = affine(numbers.gain_form, &numbers.gain, [numbers.gain[0], 0.0, 0.0])?;
    let bias = affine(numbers.bias_form, &numbers.bias, [0.0; 3])?;
    let activation = match numbers.dynamics {
        Dynamics::None => None,
        Dynamics::Integrator => Some(ActivationKind::Integrator),
        Dynamics::Filter | Dynamics::ExactFilter => Some(filter(importer, a, numbers)),
        Dynamics::Muscle | Dynamics::Other => return None,
    };
    let kind = match a.element().name() {
        "position" | "intvelocity" => ActuatorKind::Position { kp: gain[0], kv: 0.0 - bias[2] },
        "velocity" => ActuatorKind::Velocity { kv: gain[0] },
        _ => kind_of(gain, bias),
    };
    Some((kind, activation))
}

/// How many activations an actuator has in the file, supported or not.
pub(super) fn activation_count(a: &Attributes, numbers: &LawNumbers) -> Result<usize, FormatError> {
    let own_count = a.integer("actdim")?.filter(|_| a.element().is("general")).and_then(|n| usize::try_from(n).ok());
    Ok(if numbers.dynamics == Dynamics::None { 0 } else { own_count.unwrap_or(1) })
}

/// The numbers of an affine form, or of one that is constant.
fn affine(form: Form, &[by_none, by_length, by_rate, ..]: &[f64; 9], constant: [f64; 3]) -> Option<[f64; 3]> {
    match form {
        Form::Constant => Some(constant),
        Form::Affine => Some([by_none, by_length, by_rate]),
        Form::Muscle | Form::Other => None,
    }
}

fn filter(importer: &mut Importer, a: &Attributes, numbers: &LawNumbers) -> ActivationKind {
    let (time_constant, dt) = (numbers.dynamics_numbers[0], importer.timestep);
    let name = if a.element().is("general") { "dynprm" } else { "timeconst" };
    if time_constant <= 0.0 {
        let effect = "the activation follows the control within a step: give it a positive number";
        importer.report.motion(a.at(name), a.element().name(), "a filter without a time constant", effect);
        return ActivationKind::ExactFilter { time_constant: AT_ONCE };
    }
    if numbers.dynamics == Dynamics::ExactFilter {
        return ActivationKind::ExactFilter { time_constant };
    }
    if dt > 2.0 * time_constant {
        let what = format!("a filter of {time_constant} s is too fast for the time step of {dt} s");
        let effect = "the activation diverges; use dyntype 'filterexact' or a smaller step";
        importer.report.motion(a.element().at(), a.element().name(), what, effect);
    }
    ActivationKind::Filter { time_constant }
}

/// The motor or servo whose force is the same, or the affine actuator itself.
fn kind_of(gain: [f64; 3], bias: [f64; 3]) -> ActuatorKind {
    let (kp, kv) = (-bias[1], -bias[2]);
    let plain = gain[1] == 0.0 && gain[2] == 0.0 && bias[0] == 0.0 && kv >= 0.0;
    match gain[0] {
        1.0 if plain && kp == 0.0 && kv == 0.0 => ActuatorKind::Motor,
        g if plain && kp == g && g > 0.0 => ActuatorKind::Position { kp, kv },
        g if plain && kp == 0.0 && kv == g && g > 0.0 => ActuatorKind::Velocity { kv },
        _ => ActuatorKind::Affine { gain, bias },
    }
}
