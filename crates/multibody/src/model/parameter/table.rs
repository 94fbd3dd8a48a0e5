//! Which numbers can change, where they stand, and what a change of them costs.

use super::numbers::{Numbers, Written, read_affine, read_servo, write_affine, write_servo};
use crate::model::Model;

/// What has to be made anew after a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Effect {
    /// Inertias and laws that a simulation keeps in its own order: some microseconds, with the bodies.
    Values,
    /// Besides, the search for contacts: which pairs can meet is asked again, quadratic in the geoms that can touch; meshes keep their
    /// hulls.
    Search,
}

/// Reads row `i`.
type Read = fn(&Model, usize, &mut [f64]);
/// Writes row `i`.
type Write = fn(&mut Model, usize, &[f64]) -> Written;

struct Entry {
    name: &'static str,
    list: List,
    shape: &'static [usize],
    effect: Effect,
    read: Read,
    write: Write,
}

/// The parts that have a parameter.
#[derive(Clone, Copy)]
enum List {
    Model,
    Bodies,
    Joints,
    Geoms,
    Pairs,
    Sites,
    Tendons,
    Actuators,
}

macro_rules! list_of {
    (bodies) => {
        List::Bodies
    };
    (joints) => {
        List::Joints
    };
    (geoms) => {
        List::Geoms
    };
    (pairs) => {
        List::Pairs
    };
    (sites) => {
        List::Sites
    };
    (tendons) => {
        List::Tendons
    };
    (actuators) => {
        List::Actuators
    };
}

macro_rules! parameters {
    ($($(#[$doc:meta])* $variant:ident = $name:literal: $list:ident [$($field:ident).+] $shape:tt $effect:ident;)*
     => $($(#[$special_doc:meta])* $special:ident = $entry:expr;)*) => {
        /// Numbers of a model that can change without building it anew, by their names in Python and in recordings (MuJoCo's where it has
        /// the same). One row for each part, in the order of the model.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Parameter {
            $($(#[$doc])* $variant,)*
            $($(#[$special_doc])* $special,)*
        }

        impl Parameter {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)* $(Self::$special,)*];

            fn entry(self) -> Entry {
                match self {
                    $(Self::$variant => Entry {
                        name: $name,
                        list: list_of!($list),
                        shape: &$shape,
                        effect: Effect::$effect,
                        read: |model, i, out| model.$list[i]$(.$field)+.read(out),
                        write: |model, i, values| model.$list[i]$(.$field)+.write(values),
                    },)*
                    $(Self::$special => $entry,)*
                }
            }
        }
    };
}

parameters! {
    /// Masses, kg. The rotational inertia stays: a body of another density changes both.
    BodyMass = "body_mass": bodies [inertia.mass] [] Values;
    /// Centres of mass in the body frame, m.
    BodyCenter = "body_ipos": bodies [inertia.center_of_mass] [3] Values;
    /// Rotational inertias about the centres of mass in the axes of the body, kg·m².
    BodyInertia = "body_inertia": bodies [inertia.rotational] [3, 3] Values;
    /// Shares of the weight that are taken away.
    BodyGravityCompensation = "body_gravcomp": bodies [gravity_compensation] [] Values;
    /// Positions of bodies in their parents at the reference configuration, m.
    BodyPosition = "body_pos": bodies [placement.position] [3] Search;
    /// Orientations of bodies in their parents at the reference configuration, (w, x, y, z).
    BodyRotation = "body_quat": bodies [placement.rotation] [4] Search;
    /// Viscous damping of joints, N·s/m or N·m·s/rad.
    JointDamping = "jnt_damping": joints [damping] [] Values;
    /// Spring stiffness of joints, N/m or N·m/rad.
    JointStiffness = "jnt_stiffness": joints [stiffness] [] Values;
    /// Rest values of the springs of joints, rad or m.
    JointSpringReference = "jnt_springref": joints [spring_reference] [] Values;
    /// Rotor inertias of joints, kg or kg·m².
    JointArmature = "jnt_armature": joints [armature] [] Values;
    /// Dry friction of joints, N or N·m.
    JointFrictionLoss = "jnt_frictionloss": joints [friction_loss] [] Values;
    /// Limits of joints, rad or m; (−∞, ∞) where there are none.
    JointRange = "jnt_range": joints [limits] [2] Values;
    /// Points on the axes of joints in the body frame, m.
    JointAnchor = "jnt_pos": joints [anchor] [3] Search;
    /// Coefficients of restitution of geoms.
    GeomRestitution = "geom_restitution": geoms [restitution] [] Values;
    /// Distances from the surfaces of geoms at which contacts act, m.
    GeomMargin = "geom_margin": geoms [margin] [] Search;
    /// Velocities of the surfaces of geoms in their axes, m/s.
    GeomSurfaceVelocity = "geom_surface_velocity": geoms [surface_velocity] [3] Values;
    /// Sizes of geoms, m: half-extents of boxes and ellipsoids, radius of spheres, radius and half the length of capsules, cylinders and
    /// cones; zeros behind them and for other shapes, which keep theirs.
    GeomSize = "geom_size": geoms [geometry] [3] Search;
    /// Positions of geoms in their bodies, m.
    GeomPosition = "geom_pos": geoms [placement.position] [3] Search;
    /// Orientations of geoms in their bodies, (w, x, y, z).
    GeomRotation = "geom_quat": geoms [placement.rotation] [4] Search;
    /// Positions of sites in their bodies, m.
    SitePosition = "site_pos": sites [placement.position] [3] Values;
    /// Orientations of sites in their bodies, (w, x, y, z).
    SiteRotation = "site_quat": sites [placement.rotation] [4] Values;
    /// Stiffness of the springs of tendons, N/m.
    TendonStiffness = "tendon_stiffness": tendons [stiffness] [] Values;
    /// Viscous damping of tendons, N·s/m.
    TendonDamping = "tendon_damping": tendons [damping] [] Values;
    /// Lengths between which the springs of tendons are slack, m.
    TendonRest = "tendon_lengthspring": tendons [rest] [2] Values;
    /// Limits of the lengths of tendons, m; (−∞, ∞) where there are none.
    TendonRange = "tendon_range": tendons [limits] [2] Values;
    /// Factors from the forces of actuators to those on what they drive.
    ActuatorGear = "actuator_gear": actuators [gear] [] Values;
    /// Ranges of the forces of actuators, N or N·m; (−∞, ∞) where there are none.
    ActuatorForceRange = "actuator_forcerange": actuators [force_range] [2] Values;
    /// Ranges of the controls of actuators; (−∞, ∞) where there are none.
    ActuatorControlRange = "actuator_ctrlrange": actuators [control_range] [2] Values;
    =>
    /// Gravity in world, m/s²: one row.
    Gravity = Entry {
        name: "gravity",
        list: List::Model,
        shape: &[3],
        effect: Effect::Values,
        read: |model, _, out| model.gravity.read(out),
        write: |model, _, values| model.gravity.write(values),
    };
    /// Friction of geoms: sliding, spinning (m), rolling (m); the last two act where the model has such friction.
    GeomFriction = Entry {
        name: "geom_friction",
        list: List::Geoms,
        shape: &[3],
        effect: Effect::Values,
        read: |model, i, out| {
            let geom = &model.geoms[i];
            out.copy_from_slice(&[geom.friction, geom.spinning_friction, geom.rolling_friction]);
        },
        write: |model, i, values| {
            let geom = &mut model.geoms[i];
            (geom.friction, geom.spinning_friction, geom.rolling_friction) = (values[0], values[1], values[2]);
            Ok(())
        },
    };
    /// Friction of pairs of geoms that have their own, as of geoms.
    PairFriction = Entry {
        name: "pair_friction",
        list: List::Pairs,
        shape: &[3],
        effect: Effect::Values,
        read: |model, i, out| {
            let pair = &model.pairs[i];
            out.copy_from_slice(&[pair.friction, pair.spinning_friction, pair.rolling_friction]);
        },
        write: |model, i, values| {
            let pair = &mut model.pairs[i];
            (pair.friction, pair.spinning_friction, pair.rolling_friction) = (values[0], values[1], values[2]);
            Ok(())
        },
    };
    /// Stiffness of position servos, N/m or N·m/rad; zero for others.
    ActuatorStiffness = of_law("actuator_kp", &[], |model, i, out| read_servo(&model.actuators[i].kind, 0, out),
        |model, i, values| write_servo(&mut model.actuators[i].kind, 0, values));
    /// Damping of position and velocity servos, N·s/m or N·m·s/rad; zero for others.
    ActuatorDamping = of_law("actuator_kv", &[], |model, i, out| read_servo(&model.actuators[i].kind, 1, out),
        |model, i, values| write_servo(&mut model.actuators[i].kind, 1, values));
    /// Gains of affine actuators; zeros for others.
    ActuatorGain = of_law("actuator_gain", &[3], |model, i, out| read_affine(&model.actuators[i].kind, 0, out),
        |model, i, values| write_affine(&mut model.actuators[i].kind, 0, values));
    /// Biases of affine actuators; zeros for others.
    ActuatorBias = of_law("actuator_bias", &[3], |model, i, out| read_affine(&model.actuators[i].kind, 1, out),
        |model, i, values| write_affine(&mut model.actuators[i].kind, 1, values));
}

/// A number of an actuator's law.
fn of_law(name: &'static str, shape: &'static [usize], read: Read, write: Write) -> Entry {
    Entry { name, list: List::Actuators, shape, effect: Effect::Values, read, write }
}

impl Parameter {
    /// The largest [`width`](Self::width).
    pub(super) const WIDEST: usize = 9;

    /// Its name in Python and in recordings.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The parameter of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|parameter| parameter.name() == name)
    }

    /// Shape of a row; empty for one number.
    pub fn shape(self) -> &'static [usize] {
        self.entry().shape
    }

    /// Numbers in a row.
    pub fn width(self) -> usize {
        self.shape().iter().product()
    }

    /// What a change makes necessary.
    pub fn effect(self) -> Effect {
        self.entry().effect
    }

    /// Whether it belongs to the model as a whole and has one row.
    pub fn is_global(self) -> bool {
        matches!(self.entry().list, List::Model)
    }

    /// Number of rows: of parts that have it.
    pub fn count(self, model: &Model) -> usize {
        match self.entry().list {
            List::Model => 1,
            List::Bodies => model.bodies.len(),
            List::Joints => model.joints.len(),
            List::Geoms => model.geoms.len(),
            List::Pairs => model.pairs.len(),
            List::Sites => model.sites.len(),
            List::Tendons => model.tendons.len(),
            List::Actuators => model.actuators.len(),
        }
    }

    /// Names of the parts, in the order of its rows; empty where these have none.
    pub fn part_names(self, model: &Model) -> Vec<&str> {
        match self.entry().list {
            List::Model | List::Pairs => Vec::new(),
            List::Bodies => model.bodies.iter().map(|part| part.name.as_str()).collect(),
            List::Joints => model.joints.iter().map(|part| part.name.as_str()).collect(),
            List::Geoms => model.geoms.iter().map(|part| part.name.as_str()).collect(),
            List::Sites => model.sites.iter().map(|part| part.name.as_str()).collect(),
            List::Tendons => model.tendons.iter().map(|part| part.name.as_str()).collect(),
            List::Actuators => model.actuators.iter().map(|part| part.name.as_str()).collect(),
        }
    }

    /// The sort of parts that have it, as messages call it.
    pub fn sort(self) -> &'static str {
        match self.entry().list {
            List::Model => "model",
            List::Bodies => "body",
            List::Joints => "joint",
            List::Geoms => "geom",
            List::Pairs => "contact pair",
            List::Sites => "site",
            List::Tendons => "tendon",
            List::Actuators => "actuator",
        }
    }

    /// A part in messages.
    pub(super) fn part_name(self, model: &Model, i: usize) -> String {
        match self.part_names(model).get(i) {
            Some(name) => format!("{} '{name}'", self.sort()),
            None => format!("{} {i}", self.sort()),
        }
    }

    pub(super) fn read(self, model: &Model, i: usize, out: &mut [f64]) {
        (self.entry().read)(model, i, out);
    }

    pub(super) fn write(self, model: &mut Model, i: usize, values: &[f64]) -> Written {
        if i == 0 && matches!(self.entry().list, List::Bodies) {
            return Err("the world stands still and has no mass");
        }
        (self.entry().write)(model, i, values)
    }
}
