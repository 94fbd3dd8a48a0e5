//! `<transmission>`: motors on joints.

use signorini_multibody::{Actuator, ActuatorKind, Transmission};

use super::Importer;
use crate::error::FormatError;
use crate::xml::Element;

/// Adds a motor for every joint that a transmission names, with the joint's name and, if its `<limit>` has an `effort`,
/// that bound of the force. What ROS commands is the force at the joint: the reduction of the gear is inside it.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    let mut driven: Vec<&str> = Vec::new();
    for transmission in root.children_named("transmission") {
        for end in transmission.children_named("joint") {
            let a = end.attributes();
            let name = a.required("name", "the joint it drives")?;
            let Some(joint) = importer.parts.joint(name) else {
                // A fixed joint is no joint of the model, a misspelt one none of the file.
                if !root.children_named("joint").any(|j| j.attributes().text("name") == Some(name)) {
                    let what = "drives a joint that is not defined";
                    importer.report.motion(end.at(), "transmission", what, "it is left out; is the name misspelt?");
                }
                continue;
            };
            if joint.kind.nv() != 1 || driven.contains(&name) {
                continue;
            }
            driven.push(name);
            let actuator = Actuator {
                name: String::new(),
                transmission: Transmission::Joint(joint.id),
                gear: 1.0,
                kind: ActuatorKind::Motor,
                control_range: None,
                force_range: effort(root, name)?.map(|bound| [-bound, bound]),
            };
            importer.parts.add_actuator(end, Some(name.to_owned()), actuator)?;
        }
    }
    Ok(())
}

/// The bound of a joint's force, if it has one that is not 0.
fn effort(root: Element, joint: &str) -> Result<Option<f64>, FormatError> {
    let joint = root.children_named("joint").find(|j| j.attributes().text("name") == Some(joint));
    let Some(limit) = joint.and_then(|j| j.child("limit")) else { return Ok(None) };
    Ok(limit.attributes().non_negative("effort")?.filter(|bound| *bound > 0.0))
}
