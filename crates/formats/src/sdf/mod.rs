//! SDF, the model format of Gazebo and Drake (SDFormat 1.4 to 1.12).
//!
//! Links become bodies; joints, frames and models inside models are resolved to poses first (`frames`), then joints and
//! links become a tree (`tree`). A joint that leads from a body towards the root is turned round and keeps the meaning
//! of its coordinate; one that closes a loop is left out. A model that hangs on nothing floats unless it is static.

mod coverage;
mod frames;
mod importer;
mod include;
mod joints;
mod scripts;
mod shapes;
mod tree;
mod urdf_model;
mod values;
mod visuals;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use signorini_multibody::glam::DMat3;
use signorini_multibody::{BodyId, Inertia, Joint, JointKind, Pose};

use crate::decompose::Decomposer;
use crate::error::FormatError;
use crate::inertia::nearest_physical;
use crate::mesh_store::MeshStore;
use crate::options::{Imported, LoadOptions};
use crate::parts::Parts;
use crate::report::Reporter;
use crate::visuals::{TOUCHED, Visuals};
use crate::xml::{Element, Tree};
use frames::Frames;
use importer::Importer;
use tree::KinematicTree;
use visuals::Link;

/// More pairs of links that are kept apart than this are refused.
const MAX_PAIRS: usize = 1_000_000;

/// Turns a parsed document into a model.
pub(crate) fn import(mut tree: Tree, base: &Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    let versions = include::expand(&mut tree, base, &options.package_dirs)?;
    let root = tree.root();
    let world = root.child("world");
    let container = world.unwrap_or(root);
    let models: Vec<Element> = container.children_named("model").collect();
    if models.is_empty() {
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
        pairs: 0,
        versions,
    };
    importer.parts.decomposer = Decomposer::asked_for(options, base);
    if options.floor {
        importer.parts.add_floor(root)?;
    }
    if let Some(world) = world {
        read_world(&mut importer, world)?;
    }
    for model in &models {
        // Where there are several models, the names of their parts begin with theirs.
        let own = model.attributes().required("name", "other elements refer to it by its name")?;
        let prefix = if models.len() > 1 { format!("{own}::") } else { String::new() };
        read_model(&mut importer, *model, &prefix)?;
    }
    coverage::audit(root, &mut importer.report);
    importer.parts.arm_massless_joints(&mut importer.report);
    importer.report.notes(tree.take_notes());
    let mut model = importer.parts.build()?;
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

fn read_model<'t>(importer: &mut Importer, model: Element<'t>, prefix: &str) -> Result<(), FormatError> {
    let frames = Frames::read(model)?;
    let tree = KinematicTree::read(&frames)?;
    let placed_model = values::pose(model)?;
    let fixed = values::flag(model, "static")?.unwrap_or(false);
    let mut bodies: HashMap<usize, BodyId> = HashMap::new();
    let mut links: Vec<Link> = Vec::new();
    for placed in &tree.order {
        let entity = &frames.entities[placed.link];
        if frames.is_world(placed.link) {
            let offset = placed_model * frames.pose(placed.link);
            let touching = shapes::read(importer, &frames, placed.link, BodyId::WORLD, &offset)?;
            links.push(Link { entity: placed.link, body: BodyId::WORLD, offset, touching, fixed: true });
            continue;
        }
        let here = placed_model * frames.pose(placed.link);
        let here = Pose::new(here.position, here.rotation.normalize());
        let mut parent = placed.towards_root.map_or(BodyId::WORLD, |link| bodies[&link]);
        let from = placed.towards_root.map_or(Pose::IDENTITY, |link| placed_model * frames.pose(link));
        let edge = placed.edge.map(|e| &tree.edges[e]);
        let free = edge.is_none() && !fixed;
        if free {
            parent = BodyId::WORLD;
        }
        let placement = from.inverse() * here;
        let placement = Pose::new(placement.position, placement.rotation.normalize());
        let name = format!("{prefix}{}", entity.name);
        let body = importer.parts.add_body(entity.element, Some(name.clone()), parent, placement)?;
        bodies.insert(placed.link, body);
        match edge {
            Some(edge) if !fixed => joints::add(importer, &frames, edge, placed, body, &here, prefix)?,
            None if free => {
                let joint = importer.parts.unused_name(&format!("{name}_free"));
                importer.parts.add_joint(entity.element, Some(joint), body, &here, Joint::new("", JointKind::Free))?;
            }
            _ => {}
        }
        let inertia = inertia(importer, entity.element)?;
        importer.parts.set_inertia(body, inertia)?;
        let touching = shapes::read(importer, &frames, placed.link, body, &Pose::IDENTITY)?;
        links.push(Link { entity: placed.link, body, offset: Pose::IDENTITY, touching, fixed });
    }
    visuals::read(importer, &frames, links, prefix)?;
    for edge in tree.edges.iter().filter(|edge| !edge.in_tree && !fixed) {
        let (what, effect) = match tree::couples(edge.element) {
            true => ("of type 'gearbox' is not supported", "the joints that it couples move by themselves"),
            false => ("closes a loop, which is not supported", "it is left out: the loop is open"),
        };
        importer.report.motion(edge.element.at(), "joint", what, effect);
    }
    keep_apart(importer, model, &tree, &bodies)
}

/// Keeps the links of a model from touching: all of them, unless it says that they do; else those that a joint connects.
fn keep_apart(
    importer: &mut Importer,
    model: Element,
    tree: &KinematicTree,
    bodies: &HashMap<usize, BodyId>,
) -> Result<(), FormatError> {
    let meets = values::flag(model, "self_collide")?.unwrap_or(false);
    let list: Vec<BodyId> = tree.order.iter().filter_map(|placed| bodies.get(&placed.link).copied()).collect();
    let joined = tree.edges.iter().filter_map(|e| Some((*bodies.get(&e.parent?)?, *bodies.get(&e.child?)?)));
    let pairs: Vec<(BodyId, BodyId)> = match meets {
        true => joined.collect(),
        false if list.len() > 1000 => return Err(model.invalid("more than 1000 links without <self_collide>")),
        false => list.iter().enumerate().flat_map(|(i, &a)| list[..i].iter().map(move |&b| (a, b))).collect(),
    };
    importer.pairs += pairs.len();
    if importer.pairs > MAX_PAIRS {
        return Err(model.invalid(format!("more than {MAX_PAIRS} pairs of links that do not touch")));
    }
    pairs.into_iter().for_each(|(a, b)| {
        importer.parts.builder.exclude(a, b);
    });
    Ok(())
}

/// `<inertial>` of a link in the link's frame; 1 kg and 1 kg·m² about every axis where nothing is said, as SDF defines.
fn inertia(importer: &mut Importer, link: Element) -> Result<Inertia, FormatError> {
    let inertial = link.child("inertial");
    let mass = inertial.map_or(Ok(None), |i| values::non_negative(i, "mass"))?.unwrap_or(1.0);
    let matrix = inertial.and_then(|i| i.child("inertia"));
    let entry = |name, default| {
        Ok::<f64, FormatError>(match matrix {
            Some(matrix) => values::number(matrix, name)?.unwrap_or(default),
            None => default,
        })
    };
    let (xx, yy, zz) = (entry("ixx", 1.0)?, entry("iyy", 1.0)?, entry("izz", 1.0)?);
    let (xy, xz, yz) = (entry("ixy", 0.0)?, entry("ixz", 0.0)?, entry("iyz", 0.0)?);
    let mut rotational = DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    if let (Some(possible), Some(matrix)) = (nearest_physical(rotational), matrix) {
        let what = "is not that of a rigid body (a principal moment is negative or exceeds the sum of the others)";
        importer.report.motion(matrix.at(), "inertia", what, "it is replaced by the nearest possible one");
        rotational = possible;
    }
    let placement = inertial.map_or(Ok(Pose::IDENTITY), values::pose)?;
    let center_of_mass = signorini_multibody::glam::DVec3::ZERO;
    Ok(Inertia { mass, center_of_mass, rotational }.placed(&placement))
}
