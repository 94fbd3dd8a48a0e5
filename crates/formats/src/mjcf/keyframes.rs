//! `<keyframe>`: named states.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{JointKind, Keyframe, Pose};

use super::actuators::Listed;
use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

/// `actuators`: those of the file, in its order.
pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    root: Element<'t>,
    actuators: &[Listed],
) -> Result<(), FormatError> {
    for key in root.children_named("keyframe").flat_map(|k| k.children_named("key")) {
        let a = key.attributes();
        let (reference, rest) = (importer.parts.reference.clone(), vec![0.0; importer.parts.nv]);
        let mut q = beginning(importer, &a, "qpos", "numbers in q (nq)", &reference)?;
        turn_none(importer, &mut q);
        let v = beginning(importer, &a, "qvel", "numbers in v (nv)", &rest)?;
        let control = list(&a, "ctrl", "actuators", &vec![0.0; actuators.len()])?;
        let control = control.into_iter().zip(actuators).filter(|(_, a)| a.kept).map(|(c, _)| c).collect();
        let count = actuators.iter().map(|actuator| actuator.activations).sum();
        let activations = list(&a, "act", "activations (na)", &vec![0.0; count])?;
        let owners = actuators.iter().flat_map(|actuator| std::iter::repeat_n(actuator.kept, actuator.activations));
        let activation = activations.into_iter().zip(owners).filter(|(_, kept)| *kept).map(|(x, _)| x).collect();
        let time = a.number_or("time", 0.0)?;
        let mocap = mocap_poses(&a, &importer.parts.mocap_placements)?;
        let name = a.text("name").filter(|n| !n.is_empty()).map(str::to_owned);
        importer.parts.add_keyframe(
            key,
            name,
            Keyframe::new(String::new(), q)
                .with_time(time)
                .with_v(v)
                .with_activation(activation)
                .with_control(control)
                .with_mocap(mocap),
        )?;
    }
    Ok(())
}

/// Takes quaternions of zeros for none: those of free and ball joints become the identity, as in MuJoCo.
fn turn_none(importer: &Importer, q: &mut [f64]) {
    let mut rest = q;
    for joint in &importer.parts.joints {
        let own = rest.split_off_mut(..joint.kind.nq()).unwrap_or_default();
        match (joint.kind, own) {
            (JointKind::Free, [_, _, _, quaternion @ ..]) | (JointKind::Ball, quaternion) => {
                if let [w @ 0.0, 0.0, 0.0, 0.0] = quaternion {
                    *w = 1.0;
                }
            }
            _ => {}
        }
    }
}

/// `mpos` and `mquat`: where the bodies stand that are moved from outside; nothing where neither is given.
fn mocap_poses(a: &Attributes, placements: &[Pose]) -> Result<Vec<Pose>, FormatError> {
    if !a.has("mpos") && !a.has("mquat") {
        return Ok(Vec::new());
    }
    let positions: Vec<f64> = placements.iter().flat_map(|pose| pose.position.to_array()).collect();
    let rotations: Vec<f64> = placements.iter().map(|pose| pose.rotation).flat_map(|r| [r.w, r.x, r.y, r.z]).collect();
    let positions = list(a, "mpos", "numbers for the mocap bodies", &positions)?;
    let rotations = list(a, "mquat", "numbers for the mocap bodies", &rotations)?;
    let poses = positions.chunks_exact(3).zip(rotations.chunks_exact(4)).map(|(p, r)| {
        let rotation = DQuat::from_xyzw(r[1], r[2], r[3], r[0]);
        let norm = rotation.length();
        // A quaternion of zeros is MuJoCo's word for none.
        let rotation = if norm > 0.0 { rotation / norm } else { DQuat::IDENTITY };
        Pose::new(DVec3::from_slice(p), rotation)
    });
    Ok(poses.collect())
}

/// A list that may end early, as in MuJoCo: the rest is the default's.
fn beginning(
    importer: &mut Importer,
    a: &Attributes,
    name: &'static str,
    what: &str,
    default: &[f64],
) -> Result<Vec<f64>, FormatError> {
    let Some(numbers) = a.numbers(name)?.filter(|numbers| numbers.len() < default.len()) else {
        return list(a, name, what, default);
    };
    let found = format!("'{name}' has {} of {} {what}", numbers.len(), default.len());
    importer.report.motion(a.at(name), "key", found, "the others are as in the reference configuration at rest");
    Ok(numbers.iter().chain(&default[numbers.len()..]).copied().collect())
}

fn list(a: &Attributes, name: &'static str, what: &str, default: &[f64]) -> Result<Vec<f64>, FormatError> {
    match a.numbers(name)? {
        None => Ok(default.to_owned()),
        Some(numbers) if numbers.len() == default.len() => Ok(numbers),
        Some(numbers) => {
            let expected = format!("{} {what} as the model has, found {}", default.len(), numbers.len());
            Err(a.invalid(name, expected))
        }
    }
}
