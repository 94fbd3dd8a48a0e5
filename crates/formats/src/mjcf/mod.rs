//! MJCF, MuJoCo's model format.
//!
//! The way through a file: includes and attached models are put in, `<compiler>` says how to read, `<default>` gives attributes to those
//! who lack them, then bodies with joints, geoms and sites, contact pairs, tendons, equality constraints, actuators,
//! sensors, keyframes. What is in the file and not in
//! the model is found by comparing the file with a table of what is read (`coverage`).

mod actuators;
mod assets;
mod attach;
mod bodies;
mod compiler;
mod contacts;
mod coverage;
mod custom;
mod defaults;
mod equality;
mod geoms;
mod importer;
mod include;
mod joints;
mod keyframes;
mod law_numbers;
mod laws;
mod looks;
mod muscles;
mod options;
mod order;
mod references;
mod replicate;
mod restitution;
mod scope;
mod sensors;
mod sites;
mod tendons;
mod textures;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use assets::Assets;
use compiler::Compilers;
use defaults::Defaults;
use importer::Importer;
use restitution::Restitution;
use textures::Textures;

use crate::armature::arm_dependent_joints;
use crate::coverage::explain;
use crate::decompose::Decomposer;
use crate::error::FormatError;
use crate::options::{Imported, LoadOptions};
use crate::parts::Parts;
use crate::report::Reporter;
use crate::xml::Tree;

/// Turns a parsed document into a model; `main` is the file it came from, if any.
pub(crate) fn import(
    mut tree: Tree,
    base: &Path,
    main: Option<&Path>,
    options: &LoadOptions,
) -> Result<Imported, FormatError> {
    include::expand(&mut tree, base, main)?;
    let (folders, mut arrivals) = attach::expand(&mut tree, base)?;
    replicate::expand_references(&mut tree, &mut arrivals)?;
    arrivals.sort(&mut tree);
    read(&tree, (base, &folders), options)
        .map_err(|error| explain(error, |report| coverage::audit(tree.root(), report)))
}

/// Elements that would make parts with names.
const MAKERS: [&str; 3] = ["flexcomp", "composite", "deformable"];

fn read(tree: &Tree, (base, folders): (&Path, &[PathBuf]), options: &LoadOptions) -> Result<Imported, FormatError> {
    let root = tree.root();
    let names = tree.elements().filter_map(|e| e.raw("name")).map(|a| a.value.trim().to_owned());
    let reserved: HashSet<String> = names.collect();
    let defaults = Defaults::read(root)?;
    let mut importer = Importer {
        compilers: Compilers::read(root, folders)?,
        assets: Assets::read(root, &defaults)?,
        textures: Textures::read(root, &defaults, options.visuals)?,
        defaults,
        parts: Parts::new(root.attributes().text("model").unwrap_or("MuJoCo Model"), root, reserved),
        report: Reporter::default(),
        mesh_geoms: HashSet::new(),
        cameras: Vec::new(),
        camera_names: Vec::new(),
        layers: HashMap::new(),
        elements: 0,
        contacts_disabled: false,
        equalities_disabled: false,
        friction_loss_disabled: false,
        limits_disabled: false,
        actuation_disabled: false,
        dampers_disabled: false,
        springs_disabled: false,
        restitution: Restitution::read(root)?,
        paired: contacts::paired_geoms(root),
        measured: contacts::measured_geoms(root),
        left_out_tendons: HashSet::new(),
        left_out_actuators: HashSet::new(),
        damping_ratios: Vec::new(),
        resting_tendons: Vec::new(),
        tendon_ranges: HashMap::new(),
        muscles: Vec::new(),
        grains: custom::grains(root)?,
        speed_servos: custom::speed_servos(root)?,
        timestep: 0.002,
        missing_meshes: options.missing_meshes,
        actuator_force_ranges: Vec::new(),
        actuator_compensated: Vec::new(),
        parts_are_left_out: tree.elements().any(|e| MAKERS.contains(&e.name())),
    };
    importer.parts.decomposer = Decomposer::asked_for(options, base);
    options::read(&mut importer, root)?;
    bodies::read(&mut importer, root)?;
    looks::finish_cameras(&mut importer)?;
    contacts::read(&mut importer, root)?;
    custom::check(&importer)?;
    tendons::read(&mut importer, root)?;
    equality::read(&mut importer, root)?;
    let listed = actuators::read(&mut importer, root)?;
    sensors::read(&mut importer, root)?;
    keyframes::read(&mut importer, root, &listed)?;
    coverage::audit(root, &mut importer.report);
    importer.report.notes(tree.take_notes());
    let mut model = importer.parts.build()?;
    arm_dependent_joints(&mut model, &importer.parts, &mut importer.report);
    actuators::bound_by_joints(&mut model, &importer.actuator_force_ranges, &mut importer.report);
    joints::report_compensation(&model, &importer.actuator_compensated, &mut importer.report);
    tendons::rest_with_joints(&mut model, &importer.resting_tendons);
    muscles::finish(&mut model, &importer.muscles, &mut importer.report);
    actuators::damp_by_ratio(&mut model, &importer.damping_ratios);
    Ok(Imported { model, report: importer.report.finish() })
}
