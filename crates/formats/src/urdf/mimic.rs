//! `<mimic joint multiplier offset>`: a joint that follows another one.

use std::collections::HashSet;

use signorini_multibody::EqualityKind;

use super::importer::Importer;
use super::tree::KinematicTree;
use crate::error::FormatError;

/// Adds a constraint `q = multiplier · q′ + offset` for every joint that mimics another.
pub(super) fn read(importer: &mut Importer, kinematics: &KinematicTree) -> Result<(), FormatError> {
    let names = kinematics.joints.iter().filter_map(|j| j.element.attributes().text("name"));
    let names: HashSet<&str> = names.collect();
    for joint in &kinematics.joints {
        let Some(element) = joint.element.child("mimic") else { continue };
        let a = element.attributes();
        let leader = a.required("joint", "the joint that leads")?;
        let own = joint.element.attributes();
        let name = own.required("name", "messages and the model refer to the joint by it")?;
        if !names.contains(leader) {
            let what = format!("follows the joint '{leader}', which is not defined");
            importer.report.motion(element.at(), "mimic", what, "it moves freely; is the name misspelt?");
            continue;
        }
        let one_way = |record: Option<crate::parts::JointRecord>| record.filter(|r| r.kind.nv() == 1);
        let (Some(follower), Some(driver)) =
            (one_way(importer.parts.joint(name)), one_way(importer.parts.joint(leader)))
        else {
            let what = "is between joints one of which is neither a hinge nor a slide";
            importer.report.motion(element.at(), "mimic", what, "it has no effect");
            continue;
        };
        if follower.id == driver.id {
            return Err(a.invalid("joint", "another joint than its own"));
        }
        let (offset, multiplier) = (a.number_or("offset", 0.0)?, a.number_or("multiplier", 1.0)?);
        let polynomial = [offset, multiplier, 0.0, 0.0, 0.0];
        let kind = EqualityKind::Joint { joint: follower.id, driver: Some(driver.id), polynomial };
        let name = importer.parts.unused_name(&format!("{name}_mimics_{leader}"));
        importer.parts.add_equality(element, Some(name), kind)?;
    }
    Ok(())
}
