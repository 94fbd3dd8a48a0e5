//! `<mimic joint multiplier offset>`: a joint that follows another one.

use std::collections::HashSet;

use super::importer::Importer;
use super::tree::KinematicTree;
use crate::error::FormatError;
use crate::mimic::follow;

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
        let numbers = || Ok([a.number_or("offset", 0.0)?, a.number_or("multiplier", 1.0)?]);
        let Importer { parts, report, .. } = importer;
        follow(parts, report, element, [name, leader], numbers)?;
    }
    Ok(())
}
