//! Joints that close loops, and axes that follow others.

use std::collections::HashMap;

use signorini_multibody::{BodyId, EqualityKind, Pose};

use super::frames::Frames;
use super::importer::Importer;
use super::joints::direction;
use super::tree::{self, Edge, KinematicTree};
use super::values;
use crate::error::FormatError;
use crate::mimic;
use crate::xml::Element;

/// Half the distance of the two points that hold an axis, m. Any distance holds an axis that is where it should be; one that is turned away from there is
/// turned back at the speed of corrections of points so far out. Chosen by reasoning: half the width of a link.
const ARM: f64 = 0.1;

/// Adds the constraints of the joints that are in no tree, except those within one rigid body.
pub(super) fn close_loops<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    tree: &KinematicTree<'t>,
    bodies: &HashMap<usize, BodyId>,
) -> Result<(), FormatError> {
    let mut welded = tree.welded(frames);
    for edge in tree.edges.iter().filter(|edge| !edge.in_tree && !welded.are_joined(edge.parent, edge.child)) {
        if tree::couples(edge.element) {
            let effect = "the joints that it couples move by themselves";
            importer.report.motion(edge.element.at(), "joint", "of type 'gearbox' is not supported", effect);
        } else {
            close(importer, frames, edge, bodies)?;
        }
    }
    Ok(())
}

/// Adds the constraints that a joint between two links of the tree is: a weld, a common point, or two of its axis.
fn close<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    edge: &Edge<'t>,
    bodies: &HashMap<usize, BodyId>,
) -> Result<(), FormatError> {
    let element = edge.element;
    let sort = element.attributes().text("type").unwrap_or_default();
    let body = |link: Option<usize>| link.map_or(BodyId::WORLD, |link| bodies[&link]);
    let (body_a, body_b) = (body(edge.parent), body(edge.child));
    let here = frames.pose(edge.entity);
    let [in_a, in_b] =
        [edge.parent, edge.child].map(|link| link.map_or(Pose::IDENTITY, |link| frames.pose(link)).inverse());
    let common_point = |point| {
        let [point_a, point_b] = [in_a, in_b].map(|to_body| to_body.transform_point(point));
        EqualityKind::Connect { body_a, point_a, body_b, point_b }
    };
    let constraints = match sort {
        "fixed" => {
            let [frame_a, frame_b] = [in_a, in_b].map(|to_body| to_body * here);
            vec![EqualityKind::Weld { body_a, frame_a, body_b, frame_b }]
        }
        "revolute" | "continuous" => {
            let arm = direction(importer, frames, edge, element.child("axis"))?.normalize() * ARM;
            [here.position - arm, here.position + arm].map(common_point).to_vec()
        }
        "ball" | "universal" | "revolute2" => vec![common_point(here.position)],
        _ => {
            let what = format!("of type '{sort}' closes a loop, which is not supported");
            importer.report.motion(element.at(), "joint", what, "it is left out: the loop is open");
            return Ok(());
        }
    };
    if matches!(sort, "universal" | "revolute2") {
        let what = format!("of type '{sort}' closes a loop");
        importer.report.motion(element.at(), "joint", what, "its links can turn in all directions there");
    }
    report_unheld(importer, element, sort);
    let name = frames.label(edge.entity).to_owned();
    let second = importer.parts.unused_name(&format!("{name}_axis"));
    for (kind, name) in constraints.into_iter().zip([name, second]) {
        importer.parts.add_equality(element, Some(name), kind)?;
    }
    Ok(())
}

/// Reports what a joint says of its motion that a constraint has not.
fn report_unheld(importer: &mut Importer, joint: Element, sort: &str) {
    if sort == "fixed" {
        return;
    }
    for axis in ["axis", "axis2"].iter().filter_map(|name| joint.child(name)) {
        for part in ["limit", "dynamics"].iter().filter_map(|name| axis.child(name)) {
            let what = "belongs to a joint that closes a loop";
            let effect = "it is left out: the joint turns freely; give the loop to a joint without it";
            importer.report.motion(part.at(), part.name(), what, effect);
        }
    }
}

/// Adds the constraint `q = multiplier · (q′ − reference) + offset` for every axis that mimics another (SDFormat 1.11).
pub(super) fn follow<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    tree: &KinematicTree<'t>,
) -> Result<(), FormatError> {
    for edge in &tree.edges {
        for axis in ["axis", "axis2"] {
            let Some(mimic) = edge.element.child(axis).and_then(|axis| axis.child("mimic")) else { continue };
            let scope = frames.entities[edge.entity].scope.as_str();
            let leader = mimic.attributes().required("joint", "the joint that leads")?;
            let Some(leader) = frames.joint(scope, leader) else {
                let what = format!("follows the joint '{leader}', which is not defined");
                importer.report.motion(mimic.at(), "mimic", what, "it moves freely; is the name misspelt?");
                continue;
            };
            let of_leader = mimic.attributes().text("axis").unwrap_or("axis");
            let number = |name, default| Ok::<_, FormatError>(values::number(mimic, name)?.unwrap_or(default));
            let numbers = || {
                let (multiplier, offset) = (number("multiplier", 1.0)?, number("offset", 0.0)?);
                Ok([offset - multiplier * number("reference", 0.0)?, multiplier])
            };
            let names = [(edge.entity, axis), (leader, of_leader)].map(|(joint, axis)| {
                let second = if axis == "axis2" { "_2" } else { "" };
                format!("{}{second}", frames.label(joint))
            });
            let Importer { parts, report, .. } = importer;
            mimic::follow(parts, report, mimic, [&names[0], &names[1]], numbers)?;
        }
    }
    Ok(())
}
