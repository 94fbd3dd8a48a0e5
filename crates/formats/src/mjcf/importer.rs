//! What the readers of the sections share.

use std::collections::{HashMap, HashSet};

use signorini_multibody::{ActuatorId, BodyId, Camera, GeomId, JointId, SpinResistance, TendonId};

use super::assets::Assets;
use super::compiler::{Compiler, Compilers};
use super::defaults::Defaults;
use super::muscles::UnscaledMuscle;
use super::restitution::Restitution;
use super::textures::Textures;
use crate::error::{FormatError, Location};
use crate::options::MissingMeshes;
use crate::parts::Parts;
use crate::report::Reporter;
use crate::xml::{Attributes, Element};

/// Elements read under `<worldbody>`, copies counted, beyond which a file is refused.
const MAX_ELEMENTS: usize = 4_000_000;

/// A camera with the name of the body at which it looks, which may come later in the file.
pub(super) struct AimedCamera<'t> {
    pub camera: Camera,
    pub body: BodyId,
    pub target: Option<(&'t str, Attributes<'t>)>,
    /// Whether it looks at the centre of mass.
    pub com: bool,
}

/// What the readers of the sections share.
pub(super) struct Importer<'t> {
    pub compilers: Compilers,
    pub defaults: Defaults<'t>,
    pub assets: Assets<'t>,
    pub textures: Textures<'t>,
    pub parts: Parts,
    pub report: Reporter,
    /// Geoms with the frame of a mesh's file.
    pub mesh_geoms: HashSet<GeomId>,
    /// Cameras whose bodies are not all known yet.
    pub cameras: Vec<AimedCamera<'t>>,
    /// Names of the model's cameras, in order.
    pub camera_names: Vec<String>,
    /// Largest `gap` of the geoms of bodies that have one, m: as far as adhesion acts.
    pub layers: HashMap<BodyId, f64>,
    pub elements: usize,
    pub contacts_disabled: bool,
    pub equalities_disabled: bool,
    pub friction_loss_disabled: bool,
    pub limits_disabled: bool,
    pub actuation_disabled: bool,
    pub dampers_disabled: bool,
    pub springs_disabled: bool,
    pub restitution: Restitution<'t>,
    /// Names of geoms that explicit pairs name.
    pub paired: HashSet<&'t str>,
    /// Names of geoms that sensors name.
    pub measured: HashSet<&'t str>,
    /// Names of tendons and actuators of the file that the model does not have.
    pub left_out_tendons: HashSet<&'t str>,
    pub left_out_actuators: HashSet<&'t str>,
    /// Friction that depends on the direction, by geom.
    pub grains: HashMap<&'t str, ([f64; 2], Attributes<'t>)>,
    /// Actuators that shall hold their speed exactly and that were not met yet.
    pub speed_servos: HashMap<&'t str, Attributes<'t>>,
    /// Spatial tendons whose springs rest where those of the joints do.
    pub resting_tendons: Vec<TendonId>,
    /// Ranges of tendons that have one, in force or not.
    pub tendon_ranges: HashMap<TendonId, [f64; 2]>,
    /// Muscles of which the model has to be known.
    pub muscles: Vec<UnscaledMuscle>,
    /// Time step of the file, s.
    pub timestep: f64,
    pub missing_meshes: MissingMeshes,
    /// Joints whose actuators together have a bound, with the place where it stands.
    pub actuator_force_ranges: Vec<(JointId, [f64; 2], Location)>,
    /// Where joints say that their gravity compensation is a force of actuators.
    pub actuator_compensated: Vec<Location>,
    /// Whether parts of the file are left out that others may refer to.
    pub parts_are_left_out: bool,
    /// Position servos whose damping is to come from a damping ratio.
    pub damping_ratios: Vec<(ActuatorId, f64)>,
}

impl Importer<'_> {
    /// The settings with which an element is read.
    pub fn compiler(&self, element: Element) -> &Compiler {
        self.compilers.of(element)
    }

    /// A range that counts if its switch says so, or if it is given and `autolimits` holds.
    pub fn range(
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
            (Some([low, high]), None) if low == 0.0 && high == 0.0 => Ok(None),
            (Some([low, high]), None) if low >= high => {
                let what = format!("'{range}' has not the lower number first");
                let effect = format!("it counts for nothing: exchange the numbers, or say {switch}=\"false\"");
                a.element().note(a.at(range), what, effect, true);
                Ok(None)
            }
            (Some(_), None) if !self.compiler(a.element()).autolimits => {
                Err(a.invalid(range, format!("'{switch}' to be given as well, because autolimits is false")))
            }
            (Some(_), _) => self.ordered(a, range),
        }
    }

    /// A range that counts if it is given.
    pub fn ordered(&self, a: &Attributes, range: &'static str) -> Result<Option<[f64; 2]>, FormatError> {
        match a.vector::<2>(range)? {
            Some([low, high]) if low >= high => Err(a.invalid(range, "the lower number first")),
            values => Ok(values),
        }
    }

    /// What an element was read as; nothing, and a warning, where it refers to a part that is not there because it is left out.
    pub fn unless_left_out<T>(
        &mut self,
        element: Element,
        read: Result<T, FormatError>,
    ) -> Result<Option<T>, FormatError> {
        match read {
            Err(FormatError::UnknownName { sort, name, .. }) if self.parts_are_left_out => {
                let what = format!("refers to the {sort} '{name}', which is left out");
                self.report.motion(element.at(), element.name(), what, "it is left out, too");
                Ok(None)
            }
            read => read.map(Some),
        }
    }

    /// `condim`: whether contacts have friction, and which turning they resist.
    pub fn condim(&self, a: &Attributes) -> Result<Option<(bool, SpinResistance)>, FormatError> {
        Ok(match a.integer("condim")? {
            None => None,
            Some(1) => Some((false, SpinResistance::None)),
            Some(3) => Some((true, SpinResistance::None)),
            Some(4) => Some((true, SpinResistance::Spinning)),
            Some(6) => Some((true, SpinResistance::Rolling)),
            Some(_) => return Err(a.invalid("condim", "1, 3, 4 or 6")),
        })
    }

    pub fn count_element(&mut self, element: Element) -> Result<(), FormatError> {
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            return Err(element.invalid(format!("more than {MAX_ELEMENTS} elements after replication")));
        }
        Ok(())
    }
}
