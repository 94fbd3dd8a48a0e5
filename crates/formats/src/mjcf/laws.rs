//! The force law of an actuator and how its activation follows the control.

use std::f64::consts::FRAC_PI_4;

use signorini_multibody::{ActivationKind, ActuatorKind};

use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

/// MuJoCo's affine actuator: with length `l` and its rate `l̇`,
/// force = `(gain[0] + gain[1] l + gain[2] l̇) · drive + bias[0] + bias[1] l + bias[2] l̇`.
#[derive(Clone, Copy, PartialEq)]
struct Affine {
    gain: [f64; 3],
    bias: [f64; 3],
    dynamics: Dynamics,
    time_constant: f64,
}

/// MuJoCo's `dyntype`.
#[derive(Clone, Copy, PartialEq)]
enum Dynamics {
    None,
    Integrator,
    Filter,
    ExactFilter,
}

/// The law of an actuator and its activation; none if it depends on more than length, rate and one activation. Servos inherit
/// gains from defaults of their own sort and from those of `<general>`, which itself inherits from all.
pub(super) fn law(
    importer: &mut Importer,
    a: &Attributes,
) -> Result<Option<(ActuatorKind, Option<ActivationKind>)>, FormatError> {
    let sort = a.element().name();
    if sort == "motor" {
        return Ok(Some((ActuatorKind::Motor, None)));
    }
    let Some(law) = affine(&relevant(a))? else { return Ok(None) };
    let activation = activation(importer, a, law)?;
    let Affine { gain, bias, .. } = law;
    let kind = match sort {
        "position" | "intvelocity" => ActuatorKind::Position { kp: gain[0], kv: -bias[2] },
        "velocity" => ActuatorKind::Velocity { kv: gain[0] },
        _ => kind_of(law),
    };
    Ok(Some((kind, activation)))
}

/// How many activations an actuator has in the file, supported or not.
pub(super) fn activation_count(a: &Attributes) -> Result<usize, FormatError> {
    let sort = a.element().name();
    if sort == "muscle" {
        return Ok(1);
    }
    let own_count = a.integer("actdim")?.filter(|_| sort == "general").and_then(|n| usize::try_from(n).ok());
    Ok(match affine(&relevant(a))? {
        _ if ["motor", "adhesion", "plugin"].contains(&sort) => 0,
        Some(Affine { dynamics: Dynamics::None, .. }) => 0,
        None if relevant(a).text("dyntype").is_none_or(|dyntype| dyntype == "none") => 0,
        _ => own_count.unwrap_or(1),
    })
}

/// The layers from which an actuator inherits its law.
fn relevant<'t>(a: &Attributes<'t>) -> Attributes<'t> {
    let sort = a.element().name();
    let relevant = |layer: &Element| sort == "general" || layer.is(sort) || layer.is("general");
    Attributes::new(a.element(), a.layers().skip(1).filter(relevant).collect())
}

fn activation(importer: &mut Importer, a: &Attributes, law: Affine) -> Result<Option<ActivationKind>, FormatError> {
    let time_constant = law.time_constant;
    if matches!(law.dynamics, Dynamics::Filter | Dynamics::ExactFilter) && time_constant <= 0.0 {
        let name = if a.element().is("general") { "dynprm" } else { "timeconst" };
        return Err(a.invalid(name, "a positive time constant"));
    }
    Ok(match law.dynamics {
        Dynamics::None => None,
        Dynamics::Integrator => Some(ActivationKind::Integrator),
        Dynamics::ExactFilter => Some(ActivationKind::ExactFilter { time_constant }),
        Dynamics::Filter => {
            let dt = importer.timestep;
            if dt > 2.0 * time_constant {
                let what = format!("a filter of {time_constant} s is too fast for the time step of {dt} s");
                let effect = "the activation diverges; use dyntype 'filterexact' or a smaller step";
                importer.report.motion(a.element().at(), a.element().name(), what, effect);
            }
            Some(ActivationKind::Filter { time_constant })
        }
    })
}

/// Gain, bias and activation as the layers write them over each other; none if they depend on more than length, rate and one
/// activation.
fn affine(a: &Attributes) -> Result<Option<Affine>, FormatError> {
    let mut law = Affine { gain: [1.0, 0.0, 0.0], bias: [0.0; 3], dynamics: Dynamics::None, time_constant: 1.0 };
    // Numbers that a gain of type 'fixed' and a bias of type 'none' do not use are kept for a nearer layer that does.
    let (mut gain_affine, mut bias_affine) = (false, false);
    for layer in a.layers().rev() {
        let own = layer.attributes();
        match layer.name() {
            "position" | "intvelocity" => {
                let kp = own.non_negative("kp")?.unwrap_or(law.gain[0]);
                let kv = own.non_negative("kv")?.unwrap_or(-law.bias[2]);
                let time = own.non_negative("timeconst")?.unwrap_or(0.0);
                (law.gain, law.bias) = ([kp, 0.0, 0.0], [0.0, -kp, -kv]);
                law.dynamics = match layer.name() {
                    "intvelocity" => Dynamics::Integrator,
                    _ if time > 0.0 => Dynamics::ExactFilter,
                    _ => Dynamics::None,
                };
                law.time_constant = if time > 0.0 { time } else { law.time_constant };
                (gain_affine, bias_affine) = (false, true);
            }
            "velocity" => {
                let kv = own.non_negative("kv")?.unwrap_or(law.gain[0]);
                law = Affine { gain: [kv, 0.0, 0.0], bias: [0.0, 0.0, -kv], dynamics: Dynamics::None, ..law };
                (gain_affine, bias_affine) = (false, true);
            }
            "damper" => {
                let kv = own.non_negative("kv")?.unwrap_or(-law.gain[2]);
                law = Affine { gain: [0.0, 0.0, -kv], bias: [0.0; 3], dynamics: Dynamics::None, ..law };
                (gain_affine, bias_affine) = (true, false);
            }
            "cylinder" => {
                let area = own.non_negative("diameter")?.map(|d| FRAC_PI_4 * d * d);
                let area = area.or(own.non_negative("area")?).unwrap_or(law.gain[0]);
                let bias = own.vector::<3>("bias")?.unwrap_or(law.bias);
                let time_constant = own.non_negative("timeconst")?.unwrap_or(law.time_constant);
                law = Affine { gain: [area, 0.0, 0.0], bias, dynamics: Dynamics::Filter, time_constant };
                (gain_affine, bias_affine) = (false, true);
            }
            "adhesion" => {
                let gain = own.non_negative("gain")?.unwrap_or(law.gain[0]);
                law = Affine { gain: [gain, 0.0, 0.0], bias: [0.0; 3], dynamics: Dynamics::None, ..law };
                (gain_affine, bias_affine) = (false, false);
            }
            "motor" => {
                law = Affine { gain: [1.0, 0.0, 0.0], bias: [0.0; 3], dynamics: Dynamics::None, ..law };
                (gain_affine, bias_affine) = (false, false);
            }
            _ => {
                match own.text("gaintype") {
                    None => {}
                    Some("fixed") => gain_affine = false,
                    Some("affine") => gain_affine = true,
                    Some(_) => return Ok(None),
                }
                match own.text("biastype") {
                    None => {}
                    Some("none") => bias_affine = false,
                    Some("affine") => bias_affine = true,
                    Some(_) => return Ok(None),
                }
                match own.text("dyntype") {
                    None => {}
                    Some("none") => law.dynamics = Dynamics::None,
                    Some("integrator") => law.dynamics = Dynamics::Integrator,
                    Some("filter") => law.dynamics = Dynamics::Filter,
                    Some("filterexact") => law.dynamics = Dynamics::ExactFilter,
                    Some(_) => return Ok(None),
                }
                for (numbers, name) in [(&mut law.gain, "gainprm"), (&mut law.bias, "biasprm")] {
                    let given = own.numbers(name)?.unwrap_or_default();
                    numbers.iter_mut().zip(given).for_each(|(b, x)| *b = x);
                }
                let given = own.numbers("dynprm")?.unwrap_or_default();
                law.time_constant = given.first().copied().unwrap_or(law.time_constant);
            }
        }
    }
    if !gain_affine {
        law.gain = [law.gain[0], 0.0, 0.0];
    }
    if !bias_affine {
        law.bias = [0.0; 3];
    }
    Ok(Some(law))
}

/// The motor or servo whose force is the same, or the affine actuator itself.
fn kind_of(Affine { gain, bias, .. }: Affine) -> ActuatorKind {
    let (kp, kv) = (-bias[1], -bias[2]);
    let plain = gain[1] == 0.0 && gain[2] == 0.0 && bias[0] == 0.0 && kv >= 0.0;
    match gain[0] {
        1.0 if plain && kp == 0.0 && kv == 0.0 => ActuatorKind::Motor,
        g if plain && kp == g && g > 0.0 => ActuatorKind::Position { kp, kv },
        g if plain && kp == 0.0 && kv == g && g > 0.0 => ActuatorKind::Velocity { kv },
        _ => ActuatorKind::Affine { gain, bias },
    }
}
