//! SDF, the model format of Gazebo and Drake (SDFormat 1.4 to 1.12).
//!
//! Links become bodies; joints, frames and models inside models are resolved to poses first (`frames`), then joints and
//! links become a tree (`tree`). A joint that leads from a body towards the root is turned round and keeps the meaning
//! of its coordinate; one that closes a loop is a constraint, where it is fixed, a ball or a hinge (`constraints`). A model that hangs on nothing floats unless it is static. Joints
//! of the world are part of the tree as those of models are.

mod apart;
mod constraints;
mod coverage;
mod frames;
mod importer;
mod include;
mod inertial;
mod joints;
mod links;
mod scripts;
mod shapes;
mod tree;
mod urdf_model;
mod values;
mod visuals;

use std::collections::HashSet;
use std::path::Path;

use signorini_multibody::glam::DVec3;

use crate::armature::{arm_dependent_joints, arm_massless_joints};
use crate::decompose::Decomposer;
use crate::error::FormatError;
use crate::mesh_store::MeshStore;
use crate::options::{Imported, LoadOptions};
use crate::parts::Parts;
use crate::report::Reporter;
use crate::visuals::{TOUCHED, Visuals};
use crate::xml::{Element, Tree};
use importer::Importer;

/// Where no world says its own, m/s² (SDFormat, `<world><gravity>`).
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.8);

/// `<collide_bitmask>` of collisions that have none (SDFormat's default, 65535).
const COMMON_MASK: u32 = 0xffff;

/// Turns a parsed document into a model.
pub(crate) fn import(mut tree: Tree, base: &Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    let versions = include::expand(&mut tree, base, &options.package_dirs)?;
    let root = tree.root();
    let world = root.child("world");
    let container = world.unwrap_or(root);
    let models: Vec<Element> = container.children_named("model").collect();
    // Of an include that is not found there is a word already.
    if models.is_empty() && container.child("include").is_none() {
        let effect = "the world is empty";
        container.note(container.at(), "has no <model>", effect, true);
    }
    let names = tree.elements().filter_map(|e| e.raw("name")).map(|a| a.value.trim().to_owned());
    let reserved: HashSet<String> = names.collect();
    let name = world.or(models.first().copied()).unwrap_or(root).attributes().text("name").unwrap_or("model");
    let mut importer = Importer {
        parts: Parts::new(name, root, reserved),
        report: Reporter::default(),
        meshes: MeshStore::new(base, options),
        visuals: Visuals::new(base, options),
        hidden: Vec::new(),
        common_mask: if tree.elements().any(|e| e.is("collide_bitmask")) { COMMON_MASK } else { 1 },
        versions,
    };
    importer.parts.decomposer = Decomposer::asked_for(options, base);
    if options.floor {
        importer.parts.add_floor(root, importer.common_mask)?;
    }
    importer.parts.builder.gravity(GRAVITY);
    if let Some(world) = world {
        read_world(&mut importer, world)?;
    }
    links::read(&mut importer, container).map_err(|error| include::blame(root, error))?;
    coverage::audit(root, &mut importer.report);
    for other in root.children().filter(|e| e.is("world") || e.is("model")) {
        if world.is_some_and(|world| world.index() != other.index()) {
            let effect = "it is left out: the first world is read; put its models there, or into a file of their own";
            importer.report.motion(other.at(), other.name(), "stands beside a <world>", effect);
        }
    }
    arm_massless_joints(&mut importer.parts, &mut importer.report);
    importer.report.notes(tree.take_notes());
    let mut model = importer.parts.build()?;
    arm_dependent_joints(&mut model, &importer.parts, &mut importer.report);
    importer.hidden.iter().for_each(|geom| model.geoms[geom.index()].look.group = TOUCHED);
    Ok(Imported { model, report: importer.report.finish() })
}

fn read_world(importer: &mut Importer, world: Element) -> Result<(), FormatError> {
    if let Some(gravity) = values::vec3(world, "gravity")? {
        importer.parts.builder.gravity(gravity);
    }
    let Some(physics) = world.child("physics") else { return Ok(()) };
    match values::number(physics, "max_step_size")? {
        Some(step) if step <= 0.0 => return Err(physics.invalid("<max_step_size> must be positive, s")),
        Some(step) => drop(importer.parts.builder.timestep(step)),
        None => {}
    }
    Ok(())
}
