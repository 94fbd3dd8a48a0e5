//! The parts a model is made of.

use std::cmp::Ordering;

use derive_setters::Setters;
use glamx::glam::DVec3;

use super::{BodyId, GeomId, Geometry, Inertia, Look};
use crate::math::Pose;

/// A rigid body. Its frame B sits at `placement` in its parent's frame, then its joints move it, in order.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Parent; the world's parent is itself. Always has a smaller index than its children.
    pub parent: BodyId,
    /// `X_PB` at the reference configuration. For a body with a free joint this is its reference pose in world.
    pub placement: Pose,
    /// Mass, centre of mass, rotational inertia.
    pub inertia: Inertia,
    /// Share of its weight that a force at its centre of mass takes away: 1 makes it float.
    pub gravity_compensation: f64,
    /// First joint in [`Model::joints`](super::Model::joints); a body's joints are consecutive.
    pub first_joint: usize,
    /// Number of joints; 0 welds the body to its parent.
    pub joint_count: usize,
    /// Its place among the bodies whose pose is given from outside ([`Input::mocap`](crate::Input::mocap)), if it is one: a child of the
    /// world without joints, for the dynamics at rest in every step.
    pub mocap: Option<usize>,
    /// Whether, where simulations leave alone what rests, the tree that begins here stands in the reference configuration, whatever pulls at it, until something
    /// touches it or acts on it alone (MJCF `sleep="init"`); without meaning elsewhere than at the first body of a tree that moves.
    pub begins_asleep: bool,
}

/// How a joint lets its body move relative to the parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Six degrees of freedom: `q = [p_WB, quat_WB]`, `v = [v_WB in world axes, ω_WB in body axes]`. Only on children of
    /// the world, and the only joint of its body.
    Free,
    /// Three rotations about the anchor: `q = quat` (relative to the frame before the joint), `v = ω` in the axes of the
    /// frame after the joint.
    Ball,
    /// Rotation about an axis: `q`, `v` in rad, rad/s.
    Hinge {
        /// Unit axis in the body frame.
        axis: DVec3,
    },
    /// Translation along an axis: `q`, `v` in m, m/s.
    Slide {
        /// Unit axis in the body frame.
        axis: DVec3,
    },
}

impl JointKind {
    /// MJCF's name: "free", "ball", "hinge" or "slide".
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Ball => "ball",
            Self::Hinge { .. } => "hinge",
            Self::Slide { .. } => "slide",
        }
    }

    /// Number of entries in `q`.
    pub fn nq(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            Self::Hinge { .. } | Self::Slide { .. } => 1,
        }
    }

    /// Number of entries in `v`.
    pub fn nv(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Hinge { .. } | Self::Slide { .. } => 1,
        }
    }
}

/// A joint of a body, with what acts in it.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Joint {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// The body it moves.
    #[setters(skip)]
    pub body: BodyId,
    /// Its kind and axis.
    pub kind: JointKind,
    /// A point on the axis (hinge) or the centre (ball), in the body frame, m.
    #[setters(into)]
    pub anchor: DVec3,
    /// Value of a hinge's or slide's `q` at which the body is at its `placement` (rad, m).
    pub reference: f64,
    /// Lower and upper limit of a hinge's or slide's `q` (rad, m). A ball joint's lower limit is 0 and its upper one the largest
    /// angle of its rotation, in (0, π), as MJCF has it.
    #[setters(into)]
    pub limits: Option<[f64; 2]>,
    /// Viscous damping of every degree of freedom, N·s/m or N·m·s/rad, ≥ 0.
    pub damping: f64,
    /// Spring stiffness towards `spring_reference`, N/m or N·m/rad, ≥ 0 (hinge and slide).
    pub stiffness: f64,
    /// Rest value of the spring (rad, m).
    pub spring_reference: f64,
    /// Rotor inertia added to every degree of freedom's diagonal of the mass matrix, kg or kg·m², ≥ 0.
    pub armature: f64,
    /// Dry friction bound `τ_f` of every degree of freedom, N or N·m, ≥ 0 (formulation §5).
    pub friction_loss: f64,
    /// Where its entries in `q` begin; set by the builder.
    #[setters(skip)]
    pub q_index: usize,
    /// Where its entries in `v` begin; set by the builder.
    #[setters(skip)]
    pub v_index: usize,
}

impl Joint {
    /// Lets a body move freely.
    pub fn free(name: impl Into<String>) -> Self {
        Self::new(name, JointKind::Free)
    }

    /// Lets a body turn about its origin.
    pub fn ball(name: impl Into<String>) -> Self {
        Self::new(name, JointKind::Ball)
    }

    /// Lets a body turn about an axis (in its frame) through its origin.
    pub fn hinge(name: impl Into<String>, axis: impl Into<DVec3>) -> Self {
        Self::new(name, JointKind::Hinge { axis: axis.into() })
    }

    /// Lets a body move along an axis (in its frame).
    pub fn slide(name: impl Into<String>, axis: impl Into<DVec3>) -> Self {
        Self::new(name, JointKind::Slide { axis: axis.into() })
    }

    /// A joint with no limits and nothing acting in it.
    pub fn new(name: impl Into<String>, kind: JointKind) -> Self {
        Self {
            name: name.into(),
            body: BodyId::WORLD,
            kind,
            anchor: DVec3::ZERO,
            reference: 0.0,
            limits: None,
            damping: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            armature: 0.0,
            friction_loss: 0.0,
            q_index: 0,
            v_index: 0,
        }
    }
}

/// Which turning of one surface against the other a contact resists, besides sliding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum SpinResistance {
    /// None: a single point resists no turning.
    #[default]
    None,
    /// Spinning about the normal (MJCF `condim` 4).
    Spinning,
    /// Spinning and rolling (MJCF `condim` 6).
    Rolling,
}

/// A shape fixed to a body.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Geom {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// The body it is fixed to.
    #[setters(skip)]
    pub body: BodyId,
    /// `X_BG`, the geom's frame in the body's.
    #[setters(into)]
    pub placement: Pose,
    /// Its shape.
    pub geometry: Geometry,
    /// Coefficient of sliding friction, ≥ 0; a pair takes the larger of the two unless it has an entry of its own.
    pub friction: f64,
    /// Whether contacts with it have friction (MJCF `condim` ≥ 3 of either geom).
    pub frictional: bool,
    /// Which turning of one surface against the other its contacts resist (MJCF `condim` 4 and 6).
    pub spin_resistance: SpinResistance,
    /// Coefficient of friction against spinning about the normal, m, ≥ 0.
    pub spinning_friction: f64,
    /// Coefficient of friction against rolling, m, ≥ 0.
    pub rolling_friction: f64,
    /// Factors of the sliding friction along the geom's x axis and across it in the surface, > 0: a skate has a small first one.
    /// Where both geoms of a pair have some, those of the first count.
    #[setters(into)]
    pub grain: Option<[f64; 2]>,
    /// Coefficient of restitution e in [0, 1]; a pair takes the larger of the two.
    pub restitution: f64,
    /// Distance from the surface at which contacts act, m, ≥ 0; those of the two geoms of a pair add up (MJCF `margin`).
    pub margin: f64,
    /// Velocity of the surface relative to the body, in the geom's axes, m/s: a conveyor belt. Only its part along the
    /// tangents of a contact acts.
    #[setters(into)]
    pub surface_velocity: DVec3,
    /// Of two geoms that touch, the one with the higher priority says alone which friction their contacts have.
    pub priority: i32,
    /// Which collision groups it belongs to (bit mask); two geoms meet if one's type shares a bit with the other's affinity.
    pub contact_type: u32,
    /// Which collision groups it meets (bit mask).
    pub contact_affinity: u32,
    /// Colour for pictures: red, green, blue, opacity in [0, 1].
    pub rgba: [f32; 4],
    /// What else its surface looks like.
    pub look: Look,
}

impl Geom {
    /// A geom at its body's origin with friction 1 that meets everything.
    pub fn new(name: impl Into<String>, geometry: Geometry) -> Self {
        Self {
            name: name.into(),
            body: BodyId::WORLD,
            placement: Pose::IDENTITY,
            geometry,
            friction: 1.0,
            frictional: true,
            spin_resistance: SpinResistance::None,
            spinning_friction: 0.005,
            rolling_friction: 0.0001,
            grain: None,
            restitution: 0.0,
            margin: 0.0,
            surface_velocity: DVec3::ZERO,
            priority: 0,
            contact_type: 1,
            contact_affinity: 1,
            rgba: [0.5, 0.5, 0.5, 1.0],
            look: Look::default(),
        }
    }
}

impl Geom {
    /// Coefficient of sliding friction of contacts with another geom: that of the one with the higher priority; where they have the same,
    /// the larger of the two, or 0 where neither is frictional (MuJoCo's rule).
    pub fn friction_with(&self, other: &Self) -> f64 {
        let (friction, frictional) = match self.priority.cmp(&other.priority) {
            Ordering::Greater => (self.friction, self.frictional),
            Ordering::Less => (other.friction, other.frictional),
            Ordering::Equal => (self.friction.max(other.friction), self.frictional || other.frictional),
        };
        if frictional { friction } else { 0.0 }
    }

    /// Which turning contacts with another geom resist, and the coefficients of friction against spinning and rolling, m: those of the
    /// one with the higher priority; where they have the same, the larger of each.
    pub fn spin_friction_with(&self, other: &Self) -> (SpinResistance, f64, f64) {
        let own = |geom: &Self| (geom.spin_resistance, geom.spinning_friction, geom.rolling_friction);
        match self.priority.cmp(&other.priority) {
            Ordering::Greater => own(self),
            Ordering::Less => own(other),
            Ordering::Equal => (
                self.spin_resistance.max(other.spin_resistance),
                self.spinning_friction.max(other.spinning_friction),
                self.rolling_friction.max(other.rolling_friction),
            ),
        }
    }
}

/// Two geoms that meet whatever their masks say, with a friction of their own.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct GeomPair {
    /// One geom.
    pub geom_a: GeomId,
    /// The other.
    pub geom_b: GeomId,
    /// Coefficient of friction of the pair; 0 is frictionless.
    pub friction: f64,
    /// Which turning the pair resists.
    pub spin_resistance: SpinResistance,
    /// Coefficient of friction against spinning, m, ≥ 0.
    pub spinning_friction: f64,
    /// Coefficient of friction against rolling, m, ≥ 0.
    pub rolling_friction: f64,
    /// Coefficient of restitution in [0, 1]; that of the geoms where it is not given.
    #[setters(into)]
    pub restitution: Option<f64>,
    /// Distance of the surfaces at which contacts act, m, ≥ 0; the sum of the geoms' where it is not given.
    #[setters(into)]
    pub margin: Option<f64>,
}

impl GeomPair {
    /// A pair with a coefficient of sliding friction that resists no turning.
    pub fn new(geom_a: GeomId, geom_b: GeomId, friction: f64) -> Self {
        Self {
            geom_a,
            geom_b,
            friction,
            spin_resistance: SpinResistance::None,
            spinning_friction: 0.0,
            rolling_friction: 0.0,
            restitution: None,
            margin: None,
        }
    }
}

/// A named state.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Keyframe {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Configuration, `[nq]`.
    pub q: Vec<f64>,
    /// Velocity, `[nv]`.
    pub v: Vec<f64>,
    /// Activations, `[na]`.
    pub activation: Vec<f64>,
    /// Control, `[actuators]`.
    pub control: Vec<f64>,
    /// Poses `X_WB` of the bodies that are moved from outside, `[mocap_bodies]`; empty: where the model places them.
    pub mocap: Vec<Pose>,
}

impl Keyframe {
    /// A configuration `q` at rest at time 0, without activations and control.
    pub fn new(name: impl Into<String>, q: Vec<f64>) -> Self {
        Self {
            name: name.into(),
            time: 0.0,
            q,
            v: Vec::new(),
            activation: Vec::new(),
            control: Vec::new(),
            mocap: Vec::new(),
        }
    }
}
