//! `<actuator>`: motors, servos, dampers and general affine actuators on joints, tendons and sites.

use signorini_multibody::{
    Actuator, ActuatorId, ActuatorKind, JointKind, Kinematics, LengthRow, MassMatrix, Model, Transmission,
    actuator_length_into, forward_kinematics_into, mass_matrix_into,
};

use super::Importer;
use super::sensors::{site, tendon};
use crate::error::FormatError;
use crate::parts::JointRecord;
use crate::xml::{Attributes, Element};

/// Elements whose defaults apply to every actuator.
const KINDS: [&str; 5] = ["general", "motor", "position", "velocity", "damper"];

/// MuJoCo's affine actuator: with length `l` and its rate `l̇`,
/// force = `(gain[0] + gain[1] l + gain[2] l̇) · control + bias[0] + bias[1] l + bias[2] l̇`.
#[derive(Clone, Copy, PartialEq)]
struct Affine {
    gain: [f64; 3],
    bias: [f64; 3],
}

/// What an actuator acts on, and the joint if it is a hinge or slide.
struct Target {
    transmission: Transmission,
    gear: f64,
    joint: Option<JointRecord>,
}

/// Reads all actuators; gives back for each one of the file whether it is in the model.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<Vec<bool>, FormatError> {
    let mut kept = Vec::new();
    for element in root.children_named("actuator").flat_map(|a| a.children()) {
        let missing = read_actuator(importer, element)?;
        if let Some(what) = &missing {
            let effect = "it is left out, and its control with it";
            importer.report.motion(element.at(), element.name(), what, effect);
            importer.left_out_actuators.extend(element.attributes().text("name"));
        }
        kept.push(missing.is_none());
    }
    Ok(kept)
}

/// Adds an actuator, or says why it is not supported.
fn read_actuator<'t>(importer: &mut Importer<'t>, element: Element<'t>) -> Result<Option<String>, FormatError> {
    if !KINDS.contains(&element.name()) {
        return Ok(Some("this sort of actuator is not supported".into()));
    }
    let a = importer.defaults.of(element, None, &KINDS)?;
    let target = match target(importer, &a)? {
        Ok(target) => target,
        Err(what) => return Ok(Some(what)),
    };
    let Some(kind) = law(importer, &a)? else {
        return Ok(Some("gain, bias or activation is not that of a memoryless affine actuator".into()));
    };
    let actuator = Actuator {
        name: String::new(),
        transmission: target.transmission,
        gear: target.gear,
        kind,
        control_range: control_range(importer, &a, target.joint)?,
        force_range: importer.range(&a, "forcerange", "forcelimited")?,
    };
    let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
    let id = importer.parts.add_actuator(element, name, actuator)?;
    let ratio = damping_ratio(&a)?;
    if ratio > 0.0 && element.is("position") {
        importer.damping_ratios.push((id, ratio));
    }
    Ok(None)
}

/// What the actuator acts on; a reason if that is not supported.
fn target(importer: &Importer, a: &Attributes) -> Result<Result<Target, String>, FormatError> {
    let (gear, _) = a.overlay::<6>("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    if let Some(attribute) = ["joint", "jointinparent"].into_iter().find(|name| a.has(name)) {
        let joint = driven_joint(importer, a, attribute)?;
        if joint.kind.nv() == 1 {
            let transmission = Transmission::Joint(joint.id);
            return Ok(Ok(Target { transmission, gear: gear[0], joint: Some(joint) }));
        }
        if attribute == "jointinparent" && joint.kind == JointKind::Ball {
            return Ok(Err("acts on a ball joint in the axes of the parent, which is not supported".into()));
        }
        let transmission = Transmission::JointAxes { joint: joint.id, axes: gear };
        return Ok(Ok(Target { transmission, gear: 1.0, joint: None }));
    }
    if a.has("tendon") {
        let target = |id| Target { transmission: Transmission::Tendon(id), gear: gear[0], joint: None };
        return Ok(tendon(importer, a)?.map(target));
    }
    if a.has("site") {
        let reference = if a.has("refsite") { Some(site(importer, a, "refsite")?) } else { None };
        let transmission = Transmission::Site { site: site(importer, a, "site")?, reference, wrench: gear };
        return Ok(Ok(Target { transmission, gear: 1.0, joint: None }));
    }
    let others = ["body", "slidersite", "cranksite"];
    match others.iter().any(|other| a.has(other)) {
        true => Ok(Err("acts on something other than a joint, tendon or site, which is not supported".into())),
        false => Err(a.element().incomplete("attribute 'joint': the joint it drives")),
    }
}

fn driven_joint(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<JointRecord, FormatError> {
    let name = a.required(attribute, "the joint it drives")?;
    importer.parts.joint(name).ok_or_else(|| a.unknown(attribute, "joint", importer.parts.joint_names()))
}

fn control_range(
    importer: &Importer,
    a: &Attributes,
    joint: Option<JointRecord>,
) -> Result<Option<[f64; 2]>, FormatError> {
    let inherit = a.non_negative("inheritrange")?.filter(|x| *x > 0.0 && a.element().is("position"));
    match inherit {
        None => importer.range(a, "ctrlrange", "ctrllimited"),
        Some(factor) => {
            let missing = || a.invalid("inheritrange", "an actuator on a joint with limits");
            let [low, high] = joint.and_then(|joint| joint.limits).ok_or_else(missing)?;
            let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * factor);
            Ok(Some([middle - half, middle + half]))
        }
    }
}

/// The law of an actuator; none if it has an activation or depends on more than length and rate. Servos inherit gains
/// from defaults of their own sort and from those of `<general>`, which itself inherits from all.
fn law(importer: &mut Importer, a: &Attributes) -> Result<Option<ActuatorKind>, FormatError> {
    let sort = a.element().name();
    if sort == "motor" {
        return Ok(Some(ActuatorKind::Motor));
    }
    let relevant = |layer: &Element| sort == "general" || layer.is(sort) || layer.is("general");
    let inherited = Attributes::new(a.element(), a.layers().skip(1).filter(relevant).collect());
    if sort == "general" && inherited.text("dyntype").is_some_and(|t| t != "none") {
        return Ok(None);
    }
    if sort == "position" && inherited.number_or("timeconst", 0.0)? != 0.0 {
        let effect = "the servo follows its control at once";
        importer.report.motion(a.at("timeconst"), "position", "'timeconst' is not supported", effect);
    }
    let Some(Affine { gain, bias }) = affine(&inherited)? else { return Ok(None) };
    Ok(Some(match sort {
        "position" => ActuatorKind::Position { kp: gain[0], kv: -bias[2] },
        "velocity" => ActuatorKind::Velocity { kv: gain[0] },
        _ => kind_of(Affine { gain, bias }),
    }))
}

/// Gain and bias as the layers write them over each other; none if they depend on more than length and rate.
fn affine(a: &Attributes) -> Result<Option<Affine>, FormatError> {
    let mut law = Affine { gain: [1.0, 0.0, 0.0], bias: [0.0; 3] };
    // Numbers that a gain of type 'fixed' and a bias of type 'none' do not use are kept for a nearer layer that does.
    let (mut gain_affine, mut bias_affine) = (false, false);
    for layer in a.layers().rev() {
        let own = layer.attributes();
        match layer.name() {
            "position" => {
                let kp = own.non_negative("kp")?.unwrap_or(law.gain[0]);
                let kv = own.non_negative("kv")?.unwrap_or(-law.bias[2]);
                law = Affine { gain: [kp, 0.0, 0.0], bias: [0.0, -kp, -kv] };
                (gain_affine, bias_affine) = (false, true);
            }
            "velocity" => {
                let kv = own.non_negative("kv")?.unwrap_or(law.gain[0]);
                law = Affine { gain: [kv, 0.0, 0.0], bias: [0.0, 0.0, -kv] };
                (gain_affine, bias_affine) = (false, true);
            }
            "damper" => {
                let kv = own.non_negative("kv")?.unwrap_or(-law.gain[2]);
                law = Affine { gain: [0.0, 0.0, -kv], bias: [0.0; 3] };
                (gain_affine, bias_affine) = (true, false);
            }
            "motor" => {
                law = Affine { gain: [1.0, 0.0, 0.0], bias: [0.0; 3] };
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
                for (numbers, name) in [(&mut law.gain, "gainprm"), (&mut law.bias, "biasprm")] {
                    let given = own.numbers(name)?.unwrap_or_default();
                    numbers.iter_mut().zip(given).for_each(|(b, x)| *b = x);
                }
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
fn kind_of(Affine { gain, bias }: Affine) -> ActuatorKind {
    let (kp, kv) = (-bias[1], -bias[2]);
    let plain = gain[1] == 0.0 && gain[2] == 0.0 && bias[0] == 0.0 && kv >= 0.0;
    match gain[0] {
        1.0 if plain && kp == 0.0 && kv == 0.0 => ActuatorKind::Motor,
        g if plain && kp == g && g > 0.0 => ActuatorKind::Position { kp, kv },
        g if plain && kp == 0.0 && kv == g && g > 0.0 => ActuatorKind::Velocity { kv },
        _ => ActuatorKind::Affine { gain, bias },
    }
}

fn damping_ratio(a: &Attributes) -> Result<f64, FormatError> {
    let ratio = a.non_negative("dampratio")?.unwrap_or(0.0);
    if ratio > 0.0 && a.element().raw("kv").is_some() {
        return Err(a.invalid("dampratio", "either 'kv' or 'dampratio'"));
    }
    Ok(ratio)
}

/// Gives position servos the damping of a ratio of the critical one, `kv = 2 ratio √(kp m)`, with the inertia `m` at the
/// reference configuration that the servo feels along its length: `1/m = ∇lᵀ M⁻¹ ∇l`.
pub(super) fn damp_by_ratio(model: &mut Model, ratios: &[(ActuatorId, f64)]) {
    if ratios.is_empty() {
        return;
    }
    let (q, v) = (model.reference_configuration(), vec![0.0; model.nv]);
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &q, &v, &mut kinematics);
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, &kinematics, &mut mass);
    // A mass matrix that is singular at the reference configuration gives no damping; the step will say what is wrong.
    let Ok(factor) = mass.matrix.factor() else { return };
    let (mut row, mut acceleration) = (LengthRow::new(model), vec![0.0; model.nv]);
    for &(id, ratio) in ratios {
        actuator_length_into(model, &kinematics, &q, &model.actuators[id.index()], &mut row);
        acceleration.fill(0.0);
        row.dofs.iter().zip(&row.gradient).for_each(|(&k, &g)| acceleration[k] = g);
        factor.solve_in_place(&mut acceleration);
        let felt = 1.0 / row.rate(&acceleration);
        if !felt.is_finite() {
            continue; // It moves nothing.
        }
        if let ActuatorKind::Position { kp, kv } = &mut model.actuators[id.index()].kind {
            *kv = 2.0 * ratio * (*kp * felt).sqrt();
        }
    }
}
