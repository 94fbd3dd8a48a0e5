//! URDF, the model format of ROS.
//!
//! Links become bodies, joints the joints of their child's body; a fixed joint leaves the child welded to its parent and
//! keeps its name. Order: as in the document, depth first. The root link is welded to the world, or floats if asked; a
//! root link called "world" is the world itself.

mod bodies;
mod collisions;
mod coverage;
mod importer;
mod materials;
mod mimic;
mod shapes;
mod transmissions;
mod tree;
mod visuals;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use signorini_multibody::{BodyId, Inertia, Joint, JointKind, Pose};

use crate::armature::{arm_dependent_joints, arm_massless_joints};
use crate::coverage::explain;
use crate::decompose::Decomposer;
use crate::error::FormatError;
use crate::mesh_store::MeshStore;
use crate::options::{Imported, LoadOptions};
use crate::parts::Parts;
use crate::report::Reporter;
use crate::visuals::{TOUCHED, Visuals};
use crate::xml::{Element, Tree};
use importer::{Importer, Placed};
use tree::KinematicTree;

pub(crate) use bodies::limits;
pub(crate) use materials::{Material, Materials};

/// Turns a parsed document into a model.
pub(crate) fn import(tree: Tree, base: &Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    read(&tree, base, options).map_err(|error| explain(error, |report| coverage::audit(tree.root(), report)))
}

fn read(tree: &Tree, base: &Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    let root = tree.root();
    let kinematics = KinematicTree::read(root)?;
    let names = tree.elements().filter_map(|e| e.raw("name")).map(|a| a.value.trim().to_owned());
    let reserved: HashSet<String> = names.collect();
    let name = root.attributes().text("name").unwrap_or("robot");
    let mut importer = Importer {
        parts: Parts::new(name, root, reserved),
        report: Reporter::default(),
        materials: materials::Materials::read(root),
        meshes: MeshStore::new(base, options),
        visuals: Visuals::new(base, options),
        touching: Vec::new(),
        merged: HashMap::new(),
    };
    importer.parts.decomposer = Decomposer::asked_for(options, base);
    if options.floor {
        importer.parts.add_floor(root, 1)?;
    }
    let placed = place_links(&mut importer, &kinematics, options)?;
    let seen = visuals::read(&mut importer, &kinematics, &placed)?;
    collisions::exclude(&mut importer, root, &kinematics, &placed, options)?;
    transmissions::read(&mut importer, root)?;
    mimic::read(&mut importer, &kinematics)?;
    coverage::audit(root, &mut importer.report);
    arm_massless_joints(&mut importer.parts, &mut importer.report);
    importer.report.notes(tree.take_notes());
    let hidden = importer.touching.iter().filter(|(link, _)| seen.contains(link)).map(|(_, geom)| geom.index());
    let hidden: Vec<usize> = hidden.collect();
    let mut model = importer.parts.build()?;
    arm_dependent_joints(&mut model, &importer.parts, &mut importer.report);
    hidden.into_iter().for_each(|geom| model.geoms[geom].look.group = TOUCHED);
    model.geoms.iter_mut().skip(usize::from(options.floor)).for_each(|geom| geom.friction = options.friction);
    Ok(Imported { model, report: importer.report.finish() })
}

/// Adds all links in the order of the tree, each with its joint, inertia and shapes.
fn place_links(
    importer: &mut Importer,
    kinematics: &KinematicTree,
    options: &LoadOptions,
) -> Result<HashMap<usize, Placed>, FormatError> {
    let mut placed: HashMap<usize, Placed> = HashMap::new();
    let mut inertias: BTreeMap<BodyId, Vec<Inertia>> = BTreeMap::new();
    let floats = options.floating_base && has_mass(importer, kinematics)?;
    for &link in &kinematics.order {
        let tree::Link { name, element, joint, .. } = kinematics.links[link];
        let mut here = match joint {
            None => place_root(importer, (name, element), floats)?,
            Some(joint) => {
                let joint = &kinematics.joints[joint];
                let Some(parent) = placed.get(&joint.parent) else {
                    return Err(element.invalid("its parent link is not placed"));
                };
                let child =
                    bodies::add_child(importer, (name, element), joint.element, parent, options.merge_fixed_joints)?;
                let weld = if child.moves { Some(link) } else { parent.weld };
                Placed { weld, body: child.body, offset: child.offset, pose: child.pose }
            }
        };
        if here.body == BodyId::WORLD {
            warn_about_weight_of_the_world(importer, element);
        } else {
            let inertia = bodies::inertia(importer, element)?.placed(&here.offset);
            inertias.entry(here.body).or_default().push(inertia);
        }
        shapes::read(importer, (link, name, element), here.body, &here.offset)?;
        if joint.is_none() && floats && here.body != BodyId::WORLD {
            here.weld = Some(link);
        }
        placed.insert(link, here);
    }
    for (body, parts) in &inertias {
        let whole = if let [only] = parts[..] { only } else { Inertia::sum(parts) };
        importer.parts.set_inertia(*body, whole)?;
    }
    Ok(placed)
}

/// Whether any link has mass; where none has, it is reported that a base that shall float stays where it is.
fn has_mass(importer: &mut Importer, kinematics: &KinematicTree) -> Result<bool, FormatError> {
    for link in &kinematics.links {
        let mass = link.element.child("inertial").and_then(|i| i.child("mass"));
        if mass.map_or(Ok(None), |m| m.attributes().number("value"))?.is_some_and(|mass| mass > 0.0) {
            return Ok(true);
        }
    }
    if let Some(&root) = kinematics.order.first() {
        let element = kinematics.links[root].element;
        let what = "is to float, and no link of the robot has mass";
        let effect = "it is fixed to the world (as in Bullet): give the links an <inertial>, or ask for a fixed base";
        importer.report.motion(element.at(), "link", what, effect);
    }
    Ok(false)
}

/// The root link: the world if it is called so, else a body that is welded to the world or floats.
fn place_root<'t>(
    importer: &mut Importer,
    (name, element): (&'t str, Element<'t>),
    floats: bool,
) -> Result<Placed, FormatError> {
    let world = Placed { body: BodyId::WORLD, offset: Pose::IDENTITY, pose: Pose::IDENTITY, weld: None };
    if name == tree::WORLD {
        if floats {
            let (what, effect) = ("root link 'world' cannot float", "the model stays fixed as the file says");
            importer.report.motion(element.at(), "link", what, effect);
        }
        return Ok(world);
    }
    let body = importer.parts.add_body(element, Some(name.to_owned()), BodyId::WORLD, Pose::IDENTITY)?;
    if floats {
        let joint = importer.parts.unused_name("floating_base");
        importer.parts.add_joint(element, Some(joint), body, &Pose::IDENTITY, Joint::new("", JointKind::Free))?;
    }
    Ok(Placed { body, ..world })
}

fn warn_about_weight_of_the_world(importer: &mut Importer, element: Element) {
    if let Some(inertial) = element.child("inertial") {
        importer.report.other(inertial.at(), "inertial", "of the link 'world'", "the world has no mass");
    }
}
