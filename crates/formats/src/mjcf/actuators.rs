//! `<actuator>`: motors, servos, dampers, cylinders and general affine actuators on joints, tendons, sites and what bodies touch.

use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorId, ActuatorKind, JointId, JointKind, Kinematics, LengthRow,
    MassMatrix, Model, Transmission, actuator_length_into, forward_kinematics_into, mass_matrix_into,
};

use super::custom;
use super::importer::Importer;
use super::law_numbers::{Dynamics, LawNumbers};
use super::laws::{activation_count, law};
use super::muscles::muscle_law;
use super::sensors::{body, site, tendon};
use crate::error::{FormatError, Location};
use crate::parts::JointRecord;
use crate::report::Reporter;
use crate::xml::{Attributes, Element};

/// Elements whose defaults apply to every actuator.
const KINDS: [&str; 9] =
    ["general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion"];

/// What an actuator acts on, and the limits of that.
struct Target {
    transmission: Transmission,
    gear: f64,
    range: Option<[f64; 2]>,
}

/// What an actuator of the file means for the lists of a keyframe.
pub(super) struct Listed {
    /// Whether the model has it.
    pub kept: bool,
    /// How many activations it has in the file.
    pub activations: usize,
}

/// Reads all actuators, in the order of the file.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<Vec<Listed>, FormatError> {
    let mut listed = Vec::new();
    for element in root.children_named("actuator").flat_map(|a| a.children()) {
        let read = read_actuator(importer, element);
        let read = importer.unless_left_out(element, read)?;
        if let Some(Some(what)) = &read {
            let effect = "it is left out, and its control with it";
            importer.report.motion(element.at(), element.name(), what, effect);
        }
        let kept = matches!(read, Some(None));
        if !kept {
            importer.left_out_actuators.extend(element.attributes().text("name"));
        }
        let a = importer.defaults.of(element, None, &KINDS)?;
        let activations = activation_count(&a, &law_numbers(importer, element)?)?;
        listed.push(Listed { kept, activations });
    }
    custom::check_speed_servos(importer)?;
    Ok(listed)
}

fn law_numbers<'t>(importer: &Importer<'t>, element: Element<'t>) -> Result<LawNumbers<'t>, FormatError> {
    LawNumbers::read(element, &importer.defaults.classes_of(element, None, &KINDS)?)
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
    let mut numbers = law_numbers(importer, element)?;
    let ratio = numbers.take_damping_ratio();
    let muscle = muscle_law(&a, &numbers)?;
    let known = match &muscle {
        Some(muscle) => Some((ActuatorKind::Muscle(muscle.muscle), Some(muscle.activation))),
        None => law(importer, &a, &numbers),
    };
    let Some((kind, dynamics)) = known else {
        return Ok(Some("gain, bias or activation is not that of an affine actuator".into()));
    };
    let [control_range, activation_range] = ranges(importer, &a, &numbers, target.range)?;
    check_adhesion(&a, control_range)?;
    let remembers = |kind| Activation::new(kind).with_range(activation_range).with_early(numbers.early);
    let mut actuator = Actuator::new(String::new(), target.transmission, kind)
        .with_gear(target.gear)
        .with_activation(dynamics.map(remembers))
        .with_control_range(control_range)
        .with_force_range(importer.range(&a, "forcerange", "forcelimited")?);
    if importer.actuation_disabled {
        idle(&mut actuator);
    }
    let name = name_of(element);
    custom::hold_speed(importer, &mut actuator, name.as_deref())?;
    let id = importer.parts.add_actuator(element, name, actuator)?;
    importer.damping_ratios.extend(ratio.map(|ratio| (id, ratio)));
    importer.muscles.extend(muscle.and_then(|muscle| muscle.unscaled(id, element.at())));
    Ok(None)
}

/// What sticks only pulls: the range of its control is given and not negative, as MuJoCo wants it.
fn check_adhesion(a: &Attributes, control_range: Option<[f64; 2]>) -> Result<(), FormatError> {
    match control_range {
        _ if !a.element().is("adhesion") => Ok(()),
        Some([low, _]) if low >= 0.0 => Ok(()),
        Some(_) => Err(a.invalid("ctrlrange", "numbers that are not negative: it can only pull")),
        None => Err(a.element().incomplete("attribute 'ctrlrange': the range of its control")),
    }
}

fn name_of(element: Element) -> Option<String> {
    element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty())
}

/// What the actuator acts on; a reason if that is not supported.
fn target(importer: &Importer, a: &Attributes) -> Result<Result<Target, String>, FormatError> {
    let (gear, _) = a.overlay::<6>("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    if let Some(attribute) = ["joint", "jointinparent"].into_iter().find(|name| a.has(name)) {
        let joint = driven_joint(importer, a, attribute)?;
        if joint.kind.nv() == 1 {
            let transmission = Transmission::Joint(joint.id);
            return Ok(Ok(Target { transmission, gear: gear[0], range: joint.limits }));
        }
        let about = if joint.kind == JointKind::Ball { &gear[..3] } else { &gear[3..] };
        if attribute == "jointinparent" && about != [0.0; 3] {
            return Ok(Err("turns a ball or free joint in the axes of the parent, which is not supported".into()));
        }
        let transmission = Transmission::JointAxes { joint: joint.id, axes: gear };
        return Ok(Ok(Target { transmission, gear: 1.0, range: None }));
    }
    if a.has("tendon") {
        let target = |id| {
            let range = importer.tendon_ranges.get(&id).copied();
            Target { transmission: Transmission::Tendon(id), gear: gear[0], range }
        };
        return Ok(tendon(importer, a, "tendon")?.map(target));
    }
    if a.has("site") {
        let reference = if a.has("refsite") { Some(site(importer, a, "refsite")?) } else { None };
        let transmission = Transmission::Site { site: site(importer, a, "site")?, reference, wrench: gear };
        return Ok(Ok(Target { transmission, gear: 1.0, range: None }));
    }
    if a.has("body") {
        let body = body(importer, a, "body")?;
        let layer = importer.layers.get(&body).copied().unwrap_or(0.0);
        // In MuJoCo the gear does nothing here.
        return Ok(Ok(Target { transmission: Transmission::Body { body, layer }, gear: 1.0, range: None }));
    }
    let others = ["slidersite", "cranksite"];
    match others.iter().any(|other| a.has(other)) {
        true => Ok(Err("acts on something other than a joint, tendon, site or body, which is not supported".into())),
        false => Err(a.element().incomplete("attribute 'joint': the joint it drives")),
    }
}

fn driven_joint(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<JointRecord, FormatError> {
    let name = a.required(attribute, "the joint it drives")?;
    importer.parts.joint(name).ok_or_else(|| a.unknown(attribute, "joint", importer.parts.joint_names()))
}

/// The ranges of control and activation: own ones, and that of the set point from what it acts on where `inheritrange` asks for it.
fn ranges(
    importer: &Importer,
    a: &Attributes,
    numbers: &LawNumbers,
    target: Option<[f64; 2]>,
) -> Result<[Option<[f64; 2]>; 2], FormatError> {
    let control = match a.element().name() {
        // They have no switch: what they are given counts.
        "damper" | "adhesion" => importer.ordered(a, "ctrlrange")?,
        _ => importer.range(a, "ctrlrange", "ctrllimited")?,
    };
    let activation = match numbers.dynamics {
        Dynamics::None => None,
        _ => importer.range(a, "actrange", "actlimited")?,
    };
    if numbers.inherited_range == 0.0 || !numbers.is_servo() {
        return Ok([control, activation]);
    }
    let missing = || a.invalid("inheritrange", "an actuator on a joint or tendon with limits");
    let [low, high] = target.ok_or_else(missing)?;
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * numbers.inherited_range);
    let inherited = Some([middle - half, middle + half]);
    match numbers.dynamics {
        Dynamics::None | Dynamics::ExactFilter => Ok([inherited, activation]),
        Dynamics::Integrator => Ok([control, inherited]),
        _ => Err(a.invalid("inheritrange", "a servo without activation, with an exact filter or with an integrator")),
    }
}

/// Makes an actuator one that the flag `actuation` switches off: it has no force, and its activation stays.
fn idle(actuator: &mut Actuator) {
    actuator.force_range = Some([0.0; 2]);
    if actuator.activation.is_some() {
        actuator.activation = Some(Activation::new(ActivationKind::Integrator));
        actuator.control_range = Some([0.0; 2]);
    }
}

/// Takes over `actuatorfrcrange`, the bound of the force of all actuators on a joint: where a single one acts on it, that is a bound of
/// its own force, which sensors of it then show as well, where MuJoCo bounds the joint's share alone. Joints of the file are those of the model:
/// bodies are read one by one.
pub(super) fn bound_by_joints(model: &mut Model, ranges: &[(JointId, [f64; 2], Location)], report: &mut Reporter) {
    let Model { actuators, tendons, .. } = model;
    for (joint, [low, high], at) in ranges {
        let drives = |transmission: &Transmission| match transmission {
            Transmission::Joint(other) => other == joint,
            Transmission::JointAxes { .. } | Transmission::Body { .. } => false,
            Transmission::Tendon(tendon) => {
                // A path may be moved by any joint.
                let tendon = &tendons[tendon.index()];
                !tendon.path.is_empty() || tendon.terms.iter().any(|(other, _)| other == joint)
            }
            // A wrench at a site may act on any joint.
            Transmission::Site { .. } => true,
        };
        let mut driving = actuators.iter_mut().filter(|actuator| drives(&actuator.transmission));
        match (driving.next(), driving.next()) {
            (None, _) => {}
            (Some(only), None) if matches!(only.transmission, Transmission::Joint(_)) && only.gear != 0.0 => {
                let [a, b] = [low / only.gear, high / only.gear];
                let [own_low, own_high] = only.force_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
                // What is cut to two ranges is cut to their common part, or ends at the nearer end of the second.
                let cut = |x: f64| x.clamp(a.min(b), a.max(b));
                only.force_range = Some([cut(own_low), cut(own_high)]);
            }
            _ => {
                let what =
                    "'actuatorfrcrange' of a joint on which several actuators, a tendon or a site act is not supported";
                report.motion(at.clone(), "joint", what, "the total force of the actuators has no bound of its own");
            }
        }
    }
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
        let damping = |kp: f64| 2.0 * ratio * (kp.max(0.0) * felt).sqrt();
        match &mut model.actuators[id.index()].kind {
            ActuatorKind::Position { kp, kv } => *kv = damping(*kp),
            ActuatorKind::Affine { gain, bias } => bias[2] = -damping(gain[0]),
            _ => {}
        }
    }
}
