//! MJCF, MuJoCo's model format.
//!
//! The way through a file: includes are put in, `<compiler>` says how to read, `<default>` gives attributes to those
//! who lack them, then bodies with joints, geoms and sites, contact pairs, equality constraints, tendons, actuators,
//! sensors, keyframes. What is in the file and not in
//! the model is found by comparing the file with a table of what is read (`coverage`).

mod actuators;
mod assets;
mod bodies;
mod compiler;
mod contacts;
mod coverage;
mod custom;
mod defaults;
mod equality;
mod geoms;
mod include;
mod joints;
mod keyframes;
mod laws;
mod options;
mod sensors;
mod sites;
mod tendons;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use signorini_multibody::{ActuatorId, JointId, SpinResistance};

use assets::Assets;
use compiler::Compiler;
use defaults::Defaults;

use crate::error::{FormatError, Location};
use crate::parts::Parts;
use crate::report::Reporter;
use crate::xml::{Attributes, Element, Tree};
use crate::{Imported, LoadOptions, MissingMeshes};

/// Elements read under `<worldbody>`, copies counted, beyond which a file is refused.
const MAX_ELEMENTS: usize = 4_000_000;

/// Contact properties of a geom, for pairs.
#[derive(Clone, Copy)]
struct ContactProperties {
    friction: f64,
    frictional: bool,
    spin_resistance: SpinResistance,
    spinning_friction: f64,
    rolling_friction: f64,
}

/// What the readers of the sections share.
struct Importer<'t> {
    compiler: Compiler,
    defaults: Defaults<'t>,
    assets: Assets<'t>,
    parts: Parts,
    report: Reporter,
    /// By geom.
    contact_properties: Vec<ContactProperties>,
    elements: usize,
    contacts_disabled: bool,
    equalities_disabled: bool,
    friction_loss_disabled: bool,
    restitution: custom::Restitution<'t>,
    /// Names of geoms that explicit pairs name.
    paired: HashSet<&'t str>,
    /// Names of tendons and actuators of the file that the model does not have.
    left_out_tendons: HashSet<&'t str>,
    left_out_actuators: HashSet<&'t str>,
    /// Friction that depends on the direction, by geom.
    grains: HashMap<&'t str, ([f64; 2], Attributes<'t>)>,
    /// Actuators that shall hold their speed exactly and that were not met yet.
    speed_servos: HashMap<&'t str, Attributes<'t>>,
    /// Time step of the file, s.
    timestep: f64,
    missing_meshes: MissingMeshes,
    /// Joints whose actuators together have a bound, with the place where it stands.
    actuator_force_ranges: Vec<(JointId, [f64; 2], Location)>,
    /// Position servos whose damping is to come from a damping ratio.
    damping_ratios: Vec<(ActuatorId, f64)>,
}

/// Turns a parsed document into a model; `main` is the file it came from, if any.
pub(crate) fn import(
    mut tree: Tree,
    base: &Path,
    main: Option<&Path>,
    options: &LoadOptions,
) -> Result<Imported, FormatError> {
    include::expand(&mut tree, base, main)?;
    let root = tree.root();
    let names = tree.elements().filter_map(|e| e.raw("name")).map(|a| a.value.trim().to_owned());
    let reserved: HashSet<String> = names.collect();
    let defaults = Defaults::read(root)?;
    let mut importer = Importer {
        compiler: Compiler::read(root)?,
        assets: Assets::read(root, base, &defaults)?,
        defaults,
        parts: Parts::new(root.attributes().text("model").unwrap_or("MuJoCo Model"), root, reserved),
        report: Reporter::default(),
        contact_properties: Vec::new(),
        elements: 0,
        contacts_disabled: false,
        equalities_disabled: false,
        friction_loss_disabled: false,
        restitution: custom::Restitution::read(root)?,
        paired: contacts::paired_geoms(root),
        left_out_tendons: HashSet::new(),
        left_out_actuators: HashSet::new(),
        damping_ratios: Vec::new(),
        grains: custom::grains(root)?,
        speed_servos: custom::speed_servos(root)?,
        timestep: 0.002,
        missing_meshes: options.missing_meshes,
        actuator_force_ranges: Vec::new(),
    };
    options::read(&mut importer, root)?;
    bodies::read(&mut importer, root)?;
    contacts::read(&mut importer, root)?;
    custom::check(&importer)?;
    equality::read(&mut importer, root)?;
    tendons::read(&mut importer, root)?;
    let listed = actuators::read(&mut importer, root)?;
    sensors::read(&mut importer, root)?;
    keyframes::read(&mut importer, root, &listed)?;
    coverage::audit(root, &mut importer.report);
    importer.report.notes(tree.take_notes());
    let mut model = importer.parts.build()?;
    actuators::bound_by_joints(&mut model, &importer.actuator_force_ranges, &mut importer.report);
    actuators::damp_by_ratio(&mut model, &importer.damping_ratios);
    Ok(Imported { model, report: importer.report.finish() })
}

impl Importer<'_> {
    /// A range that counts if its switch says so, or if it is given and `autolimits` holds.
    fn range(
        &self,
        a: &Attributes,
        range: &'static str,
        switch: &'static str,
    ) -> Result<Option<[f64; 2]>, FormatError> {
        let words = [("true", Some(true)), ("false", Some(false)), ("auto", None)];
        let limited = a.choice(switch, &words)?.flatten();
        let values = a.vector::<2>(range)?.filter(|_| limited != Some(false));
        match (values, limited) {
            (None, Some(true)) => Err(a.invalid(switch, format!("'{range}' to be given as well"))),
            (None, _) => Ok(None),
            (Some([low, high]), _) if low == 0.0 && high == 0.0 && limited.is_none() => Ok(None),
            (Some(_), None) if !self.compiler.autolimits => {
                Err(a.invalid(range, format!("'{switch}' to be given as well, because autolimits is false")))
            }
            (Some([low, high]), _) if low >= high => Err(a.invalid(range, "the lower number first")),
            (Some(values), _) => Ok(Some(values)),
        }
    }

    /// `condim`: whether contacts have friction, and which turning they resist.
    fn condim(&self, a: &Attributes) -> Result<Option<(bool, SpinResistance)>, FormatError> {
        Ok(match a.integer("condim")? {
            None => None,
            Some(1) => Some((false, SpinResistance::None)),
            Some(3) => Some((true, SpinResistance::None)),
            Some(4) => Some((true, SpinResistance::Spinning)),
            Some(6) => Some((true, SpinResistance::Rolling)),
            Some(_) => return Err(a.invalid("condim", "1, 3, 4 or 6")),
        })
    }

    fn count_element(&mut self, element: Element) -> Result<(), FormatError> {
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            return Err(element.invalid(format!("more than {MAX_ELEMENTS} elements after replication")));
        }
        Ok(())
    }
}
