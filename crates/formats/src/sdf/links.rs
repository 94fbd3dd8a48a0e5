//! `<link>`: bodies, with the joints that move them.

use std::collections::HashMap;

use signorini_multibody::{BodyId, Joint, JointKind, Pose};

use super::apart;
use super::frames::Frames;
use super::importer::Importer;
use super::tree::{KinematicTree, Placed};
use super::visuals::{self, Link};
use super::{constraints, inertial, joints, shapes, values};
use crate::error::FormatError;
use crate::xml::Element;

/// Adds the links of all models of a world, and what connects them.
pub(super) fn read<'t>(importer: &mut Importer, world: Element<'t>) -> Result<(), FormatError> {
    let frames = Frames::read(world)?;
    let tree = KinematicTree::read(&frames)?;
    let mut bodies: HashMap<usize, BodyId> = HashMap::new();
    let top = |placed: &Placed| frames.entities[placed.link].top;
    for of_model in tree.order.chunk_by(|a, b| top(a) == top(b)) {
        let links = of_model.iter().map(|placed| add(importer, &frames, &tree, placed, &mut bodies));
        let links: Vec<Link> = links.collect::<Result<_, FormatError>>()?;
        visuals::read(importer, &frames, links)?;
    }
    constraints::close_loops(importer, &frames, &tree, &bodies)?;
    constraints::follow(importer, &frames, &tree)?;
    apart::keep_apart(importer, &frames, &tree, &bodies)
}

/// Adds a link as a body, with the joint that moves it.
fn add<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    tree: &KinematicTree<'t>,
    placed: &Placed,
    bodies: &mut HashMap<usize, BodyId>,
) -> Result<Link, FormatError> {
    let link = &frames.entities[placed.link];
    let here = frames.pose(placed.link);
    let here = Pose::new(here.position, here.rotation.normalize());
    if frames.is_world(placed.link) {
        let touching = shapes::read(importer, frames, placed.link, BodyId::WORLD, &here)?.touching;
        return Ok(Link { entity: placed.link, body: BodyId::WORLD, offset: here, touching, fixed: true });
    }
    let parent = placed.towards_root.map_or(BodyId::WORLD, |link| bodies[&link]);
    let from = placed.towards_root.map_or(Pose::IDENTITY, |link| frames.pose(link));
    let placement = from.inverse() * here;
    let placement = Pose::new(placement.position, placement.rotation.normalize());
    let name = frames.label(placed.link).to_owned();
    let body = importer.parts.add_body(link.element, Some(name.clone()), parent, placement)?;
    bodies.insert(placed.link, body);
    match placed.edge.map(|e| &tree.edges[e]) {
        Some(edge) => joints::add(importer, frames, edge, placed, body, &here)?,
        None if link.fixed => {}
        None => {
            let joint = importer.parts.unused_name(&format!("{name}_free"));
            importer.parts.add_joint(link.element, Some(joint), body, &here, Joint::new("", JointKind::Free))?;
        }
    }
    if values::flag(link.element, "gravity")? == Some(false) {
        importer.parts.set_gravity_compensation(body, 1.0)?;
    }
    let shapes = shapes::read(importer, frames, placed.link, body, &Pose::IDENTITY)?;
    let inertia = inertial::read(importer, link.element, &shapes.solids)?;
    importer.parts.set_inertia(body, inertia)?;
    let touching = shapes.touching;
    Ok(Link { entity: placed.link, body, offset: Pose::IDENTITY, touching, fixed: link.fixed })
}
