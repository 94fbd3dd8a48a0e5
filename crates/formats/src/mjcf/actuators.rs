//! `<actuator>`: motors and servos on hinges and slides.

use signorini_multibody::{Actuator, ActuatorKind};

use super::Importer;
use crate::error::FormatError;
use crate::parts::JointRecord;
use crate::xml::{Attributes, Element};

/// Elements whose defaults apply to every actuator.
const KINDS: [&str; 4] = ["general", "motor", "position", "velocity"];

/// MuJoCo's affine actuator: force = `gain · control + bias[0] + bias[1] · length + bias[2] · velocity`.
#[derive(Clone, Copy, PartialEq)]
struct Affine {
    gain: f64,
    bias: [f64; 3],
}

/// An actuator that can be taken over, and the factor its gear takes and its force range loses.
struct Law {
    kind: ActuatorKind,
    gain: f64,
}

/// Reads all actuators; gives back for each one of the file whether it is in the model.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<Vec<bool>, FormatError> {
    let mut kept = Vec::new();
    for element in root.children_named("actuator").flat_map(|a| a.children()) {
        kept.push(read_actuator(importer, element)?);
    }
    Ok(kept)
}

fn read_actuator<'t>(importer: &mut Importer<'t>, element: Element<'t>) -> Result<bool, FormatError> {
    let left_out = "it is left out, and its control with it";
    if !KINDS.contains(&element.name()) {
        importer.report.motion(element.at(), element.name(), "this sort of actuator is not supported", left_out);
        return Ok(false);
    }
    let a = importer.defaults.of(element, None, &KINDS)?;
    let Some(joint) = driven_joint(importer, &a)? else {
        let what = "acts on something other than a hinge or slide, which is not supported";
        importer.report.motion(element.at(), element.name(), what, left_out);
        return Ok(false);
    };
    let Some(law) = law(importer, &a)? else {
        let what = "gain, bias or activation is not that of a motor, position or velocity servo";
        importer.report.motion(element.at(), element.name(), what, left_out);
        return Ok(false);
    };
    let ([gear, ..], _) = a.overlay::<6>("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let force_range = importer.range(&a, "forcerange", "forcelimited")?.map(|r| r.map(|f| f / law.gain));
    let actuator = Actuator {
        name: String::new(),
        joint: joint.id,
        gear: gear * law.gain,
        kind: law.kind,
        control_range: control_range(importer, &a, &joint)?,
        force_range,
    };
    let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
    importer.parts.add_actuator(element, name, actuator)?;
    Ok(true)
}

/// The hinge or slide that the actuator drives; none if it drives something else.
fn driven_joint(importer: &Importer, a: &Attributes) -> Result<Option<JointRecord>, FormatError> {
    let attribute = if a.has("joint") { "joint" } else { "jointinparent" };
    if !a.has(attribute) {
        let others = ["tendon", "site", "body", "slidersite", "cranksite", "refsite"];
        return match others.iter().any(|other| a.has(other)) {
            true => Ok(None),
            false => Err(a.element().incomplete("attribute 'joint': the joint it drives")),
        };
    }
    let name = a.required(attribute, "the joint it drives")?;
    match importer.parts.joint(name) {
        Some(joint) => Ok(Some(joint).filter(|j| j.kind.nv() == 1)),
        None => Err(a.unknown(attribute, "joint", importer.parts.joint_names())),
    }
}

fn control_range(importer: &Importer, a: &Attributes, joint: &JointRecord) -> Result<Option<[f64; 2]>, FormatError> {
    let inherit = a.non_negative("inheritrange")?.filter(|x| *x > 0.0 && a.element().is("position"));
    match inherit {
        None => importer.range(a, "ctrlrange", "ctrllimited"),
        Some(factor) => {
            let missing = || a.invalid("inheritrange", "an actuator on a joint with limits");
            let [low, high] = joint.limits.ok_or_else(missing)?;
            let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * factor);
            Ok(Some([middle - half, middle + half]))
        }
    }
}

/// The law of an actuator. Servos inherit gains from defaults of their own sort and from those of `<general>`, which
/// itself inherits from all.
fn law(importer: &mut Importer, a: &Attributes) -> Result<Option<Law>, FormatError> {
    let sort = a.element().name();
    let relevant = |layer: &Element| sort == "general" || layer.is(sort) || layer.is("general");
    let inherited = Attributes::new(a.element(), a.layers().skip(1).filter(relevant).collect());
    if sort == "motor" {
        return Ok(Some(Law { kind: ActuatorKind::Motor, gain: 1.0 }));
    }
    if sort == "general" && a.text("dyntype").is_some_and(|t| t != "none") {
        return Ok(None);
    }
    let Some(Affine { gain, bias }) = affine(&inherited)? else { return Ok(None) };
    match sort {
        "position" => {
            warn_about_servo(importer, &inherited)?;
            Ok(Some(Law { kind: ActuatorKind::Position { kp: gain, kv: -bias[2] }, gain: 1.0 }))
        }
        "velocity" => Ok(Some(Law { kind: ActuatorKind::Velocity { kv: gain }, gain: 1.0 })),
        _ => Ok(law_of(Affine { gain, bias })),
    }
}

fn warn_about_servo(importer: &mut Importer, a: &Attributes) -> Result<(), FormatError> {
    if a.number_or("dampratio", 0.0)? != 0.0 {
        let effect = "the servo has the damping 'kv' (0 if not given)";
        importer.report.motion(a.at("dampratio"), "position", "'dampratio' is not supported", effect);
    }
    if a.number_or("timeconst", 0.0)? != 0.0 {
        let effect = "the servo follows its control at once";
        importer.report.motion(a.at("timeconst"), "position", "'timeconst' is not supported", effect);
    }
    Ok(())
}

/// Gain and bias as the layers write them over each other; none if they depend on more than length and velocity.
fn affine(a: &Attributes) -> Result<Option<Affine>, FormatError> {
    let mut law = Affine { gain: 1.0, bias: [0.0; 3] };
    let (mut gain_fixed, mut bias_used) = (true, false);
    for layer in a.layers().rev() {
        let own = layer.attributes();
        match layer.name() {
            "position" => {
                let kp = own.non_negative("kp")?.unwrap_or(law.gain);
                let kv = own.non_negative("kv")?.unwrap_or(-law.bias[2]);
                (law, gain_fixed, bias_used) = (Affine { gain: kp, bias: [0.0, -kp, -kv] }, true, true);
            }
            "velocity" => {
                let kv = own.non_negative("kv")?.unwrap_or(law.gain);
                (law, gain_fixed, bias_used) = (Affine { gain: kv, bias: [0.0, 0.0, -kv] }, true, true);
            }
            "motor" => (law, gain_fixed, bias_used) = (Affine { gain: 1.0, bias: [0.0; 3] }, true, false),
            _ => {
                gain_fixed = own.text("gaintype").map_or(gain_fixed, |t| t == "fixed");
                law.gain = own.numbers("gainprm")?.and_then(|g| g.first().copied()).unwrap_or(law.gain);
                match own.text("biastype") {
                    None => {}
                    Some("none") => bias_used = false,
                    Some("affine") => bias_used = true,
                    Some(_) => return Ok(None),
                }
                let given = own.numbers("biasprm")?.unwrap_or_default();
                law.bias.iter_mut().zip(given).for_each(|(b, x)| *b = x);
            }
        }
    }
    if !bias_used {
        law.bias = [0.0; 3];
    }
    Ok(gain_fixed.then_some(law))
}

/// The motor or servo whose force is the same, if there is one.
fn law_of(Affine { gain, bias: [constant, length, velocity] }: Affine) -> Option<Law> {
    let (kp, kv) = (-length, -velocity);
    if constant != 0.0 || gain <= 0.0 || kv < 0.0 {
        return None;
    }
    if kp == 0.0 && kv == 0.0 {
        return Some(Law { kind: ActuatorKind::Motor, gain });
    }
    if kp == gain {
        return Some(Law { kind: ActuatorKind::Position { kp, kv }, gain: 1.0 });
    }
    (kp == 0.0 && kv == gain).then_some(Law { kind: ActuatorKind::Velocity { kv }, gain: 1.0 })
}
