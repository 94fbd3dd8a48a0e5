//! Motors on joints: where a `<transmission>` names a joint, and where its `<limit>` has an `effort`.

use std::collections::{HashMap, HashSet};

use signorini_multibody::{Actuator, ActuatorKind, Transmission};

use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::Element;

/// Adds motors with their joints' names: for the joints that transmissions name, in that order, then for all other joints with an
/// `effort` in the order of the file, but for those that mimic another. The effort bounds the motor's force. What ROS commands is
/// the force at the joint: the reduction of the gear is inside it.
pub(super) fn read<'t>(importer: &mut Importer, root: Element<'t>) -> Result<(), FormatError> {
    let named = root.children_named("joint").filter_map(|j| Some((j.attributes().text("name")?, j)));
    let joints: HashMap<&str, Element<'t>> = named.collect();
    let mut driven: HashSet<&str> = HashSet::new();
    for end in root.children_named("transmission").flat_map(|t| t.children_named("joint")) {
        let name = end.attributes().required("name", "the joint it drives")?;
        let Some(&joint) = joints.get(name) else {
            let what = "drives a joint that is not defined";
            importer.report.motion(end.at(), "transmission", what, "it is left out; is the name misspelt?");
            continue;
        };
        if driven.insert(name) {
            add_motor(importer, end, name, effort(joint)?)?;
        }
    }
    for joint in root.children_named("joint").filter(|joint| joint.child("mimic").is_none()) {
        let Some(name) = joint.attributes().text("name") else { continue };
        if let Some(limit) = joint.child("limit").filter(|limit| has_no_bound(*limit)) {
            let effect = "its motor, if a transmission names one, has no bound (as in Gazebo)";
            importer.report.other(limit.at(), "limit", "has a negative effort", effect);
        }
        if let (Some(bound), false) = (effort(joint)?, driven.contains(name)) {
            add_motor(importer, joint, name, Some(bound))?;
        }
    }
    Ok(())
}

/// A motor for a joint that the model has and that has one degree of freedom; fixed joints have none.
fn add_motor<'t>(
    importer: &mut Importer,
    element: Element<'t>,
    name: &str,
    bound: Option<f64>,
) -> Result<(), FormatError> {
    let Some(joint) = importer.parts.joint(name).filter(|joint| joint.kind.nv() == 1) else { return Ok(()) };
    let actuator = Actuator::new(String::new(), Transmission::Joint(joint.id), ActuatorKind::Motor)
        .with_force_range(bound.filter(|bound| bound.is_finite()).map(|bound| [-bound, bound]));
    importer.parts.add_actuator(element, Some(name.to_owned()), actuator).map(drop)
}

/// The bound of a joint's force, if it has one that is neither 0 nor negative; it may be infinite.
fn effort(joint: Element) -> Result<Option<f64>, FormatError> {
    let Some(limit) = joint.child("limit") else { return Ok(None) };
    Ok(limit.attributes().number_or_infinity("effort")?.filter(|bound| *bound > 0.0))
}

fn has_no_bound(limit: Element) -> bool {
    limit.attributes().number_or_infinity("effort").is_ok_and(|effort| effort.is_some_and(|bound| bound < 0.0))
}
