//! A hash of a model's whole content.

use glamx::glam::{DMat3, DVec3};

use super::builder::MAGNETIC;
use super::{
    Activation, ActivationKind, Actuator, ActuatorKind, Body, ContactFilter, Equality, EqualityKind, Geom, GeomPair,
    Geometry, HeightField, Inertia, Joint, JointKind, Keyframe, Mesh, Model, Muscle, PathPart, Sensor, SensorKind,
    Site, SpinResistance, Tendon, Transmission,
};
use crate::math::Pose;

impl Model {
    /// A hash of everything the model is but for its cameras, lights and looks: equal for equal models on every machine, so that a recording or a stored problem
    /// can name the model it belongs to. 64-bit FNV-1a over the fields in order, numbers by their bits.
    pub fn content_hash(&self) -> u64 {
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
        // What is derived from the other fields is left out.
        let Self {
            name,
            gravity,
            magnetic,
            timestep,
            sleeping,
            bodies,
            joints,
            geoms,
            pairs,
            contact_filter,
            equalities,
            sites,
            tendons,
            actuators,
            sensors,
            keyframes,
            mocap_bodies: _,
            cameras: _,
            lights: _,
            nq: _,
            nv: _,
            na: _,
            sensor_size: _,
            dof_parent: _,
            dof_joint: _,
            body_last_dof: _,
            body_weld: _,
            path: _,
        } = self;
        name.feed(&mut hash);
        gravity.feed(&mut hash);
        timestep.feed(&mut hash);
        bodies.feed(&mut hash);
        joints.feed(&mut hash);
        geoms.feed(&mut hash);
        pairs.feed(&mut hash);
        contact_filter.feed(&mut hash);
        equalities.feed(&mut hash);
        sites.feed(&mut hash);
        tendons.feed(&mut hash);
        actuators.feed(&mut hash);
        sensors.feed(&mut hash);
        keyframes.feed(&mut hash);
        if *magnetic != MAGNETIC {
            magnetic.feed(&mut hash);
        }
        if *sleeping {
            hash.bytes(b"sleeping");
        }
        hash.0
    }
}

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo).
struct Fnv(u64);

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

trait Feed {
    fn feed(&self, hash: &mut Fnv);
}

fn is_default<T: Default + PartialEq>(x: &T) -> bool {
    *x == T::default()
}

macro_rules! feed_number {
    ($($t:ty),*) => {
        $(impl Feed for $t {
            fn feed(&self, hash: &mut Fnv) {
                hash.bytes(&self.to_le_bytes());
            }
        })*
    };
}
feed_number!(u8, u32, u64, i32, f32, f64);

/// Feeds every field; a new field is a compile error here. Those of `where set` count only where they are not the default, so that
/// models without them keep the hash that they had before there were such fields. Those of `but` are for pictures alone, or follow from others.
macro_rules! feed_fields {
    ($t:ident { $($field:ident),* $(,)? } $(where set { $($late:ident),* })? $(but { $($left_out:ident),* })?) => {
        impl Feed for $t {
            fn feed(&self, hash: &mut Fnv) {
                let Self { $($field,)* $($($late,)*)? $($($left_out: _,)*)? } = self;
                $($field.feed(hash);)*
                $($(if !is_default($late) {
                    $late.feed(hash);
                })*)?
            }
        }
    };
}
feed_fields!(Pose { position, rotation });
feed_fields!(Inertia { mass, center_of_mass, rotational });
feed_fields!(Body { name, parent, placement, inertia, gravity_compensation, first_joint, joint_count } where set { mocap, begins_asleep });
feed_fields!(Joint {
    name,
    body,
    kind,
    anchor,
    reference,
    limits,
    damping,
    stiffness,
    spring_reference,
    armature,
    friction_loss,
    q_index,
    v_index,
});
feed_fields!(Geom {
    name,
    body,
    placement,
    geometry,
    friction,
    frictional,
    spin_resistance,
    spinning_friction,
    rolling_friction,
    grain,
    restitution,
    margin,
    surface_velocity,
    contact_type,
    contact_affinity,
    rgba,
} where set { priority } but { look });
feed_fields!(GeomPair {
    geom_a,
    geom_b,
    friction,
    spin_resistance,
    spinning_friction,
    rolling_friction,
    restitution,
    margin
});
feed_fields!(Equality { name, kind });
feed_fields!(Site { name, body, placement, zone });
feed_fields!(Tendon { name, terms, stiffness, damping, rest, limits } where set { path } but { reference_length });
feed_fields!(Muscle { force, length_range, range, shortest, longest, fastest, passive, lengthening });
feed_fields!(Sensor { name, kind, cutoff, address });
feed_fields!(Actuator { name, transmission, gear, kind, activation, control_range, force_range } but { turns });
feed_fields!(Activation { kind, range, early, index });
feed_fields!(Keyframe { name, time, q, v, activation, control } where set { mocap });
feed_fields!(Mesh { vertices, triangles });
feed_fields!(HeightField { size, half_extents, heights });

macro_rules! feed_id {
    ($($t:ident),*) => {
        $(impl Feed for super::$t {
            fn feed(&self, hash: &mut Fnv) {
                self.0.feed(hash);
            }
        })*
    };
}
feed_id!(BodyId, JointId, GeomId, SiteId, TendonId, ActuatorId);

impl Feed for usize {
    fn feed(&self, hash: &mut Fnv) {
        (*self as u64).feed(hash);
    }
}

impl Feed for bool {
    fn feed(&self, hash: &mut Fnv) {
        u8::from(*self).feed(hash);
    }
}

impl Feed for String {
    fn feed(&self, hash: &mut Fnv) {
        self.len().feed(hash);
        hash.bytes(self.as_bytes());
    }
}

impl Feed for DVec3 {
    fn feed(&self, hash: &mut Fnv) {
        self.to_array().feed(hash);
    }
}

impl Feed for DMat3 {
    fn feed(&self, hash: &mut Fnv) {
        self.to_cols_array().feed(hash);
    }
}

impl Feed for glamx::glam::DQuat {
    fn feed(&self, hash: &mut Fnv) {
        self.to_array().feed(hash);
    }
}

impl<T: Feed, const N: usize> Feed for [T; N] {
    fn feed(&self, hash: &mut Fnv) {
        self.iter().for_each(|x| x.feed(hash));
    }
}

impl<T: Feed> Feed for Vec<T> {
    fn feed(&self, hash: &mut Fnv) {
        self.len().feed(hash);
        self.iter().for_each(|x| x.feed(hash));
    }
}

impl<T: Feed> Feed for Option<T> {
    fn feed(&self, hash: &mut Fnv) {
        u8::from(self.is_some()).feed(hash);
        self.iter().for_each(|x| x.feed(hash));
    }
}

impl Feed for EqualityKind {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Connect { body_a, point_a, body_b, point_b } => {
                0u8.feed(hash);
                ((*body_a, *point_a), (*body_b, *point_b)).feed(hash);
            }
            Self::Weld { body_a, frame_a, body_b, frame_b } => {
                1u8.feed(hash);
                ((*body_a, *frame_a), (*body_b, *frame_b)).feed(hash);
            }
            Self::Joint { joint, driver, polynomial } => {
                2u8.feed(hash);
                joint.feed(hash);
                driver.feed(hash);
                polynomial.feed(hash);
            }
            Self::Tendon { tendon, driver, polynomial } => {
                3u8.feed(hash);
                tendon.feed(hash);
                driver.feed(hash);
                polynomial.feed(hash);
            }
        }
    }
}

impl Feed for SpinResistance {
    fn feed(&self, hash: &mut Fnv) {
        (*self as u8).feed(hash);
    }
}

impl Feed for JointKind {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Free => 0u8.feed(hash),
            Self::Ball => 1u8.feed(hash),
            Self::Hinge { axis } => {
                2u8.feed(hash);
                axis.feed(hash);
            }
            Self::Slide { axis } => {
                3u8.feed(hash);
                axis.feed(hash);
            }
        }
    }
}

impl Feed for ActuatorKind {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Motor => 0u8.feed(hash),
            Self::Position { kp, kv } => {
                1u8.feed(hash);
                [*kp, *kv].feed(hash);
            }
            Self::Velocity { kv } => {
                2u8.feed(hash);
                kv.feed(hash);
            }
            Self::Speed => 3u8.feed(hash),
            Self::Affine { gain, bias } => {
                4u8.feed(hash);
                gain.feed(hash);
                bias.feed(hash);
            }
            Self::Muscle(muscle) => {
                5u8.feed(hash);
                muscle.feed(hash);
            }
        }
    }
}

impl Feed for ActivationKind {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Integrator => 0u8.feed(hash),
            Self::Filter { time_constant } => {
                1u8.feed(hash);
                time_constant.feed(hash);
            }
            Self::ExactFilter { time_constant } => {
                2u8.feed(hash);
                time_constant.feed(hash);
            }
            Self::Muscle { times, smoothing } => {
                3u8.feed(hash);
                times.feed(hash);
                smoothing.feed(hash);
            }
        }
    }
}

impl Feed for PathPart {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Site(site) => {
                0u8.feed(hash);
                site.feed(hash);
            }
            Self::Wrap { geom, side } => {
                1u8.feed(hash);
                geom.feed(hash);
                side.feed(hash);
            }
            Self::Pulley { divisor } => {
                2u8.feed(hash);
                divisor.feed(hash);
            }
        }
    }
}

impl Feed for Transmission {
    fn feed(&self, hash: &mut Fnv) {
        match self {
            Self::Joint(joint) => {
                0u8.feed(hash);
                joint.feed(hash);
            }
            Self::JointAxes { joint, axes } => {
                1u8.feed(hash);
                joint.feed(hash);
                axes.feed(hash);
            }
            Self::Tendon(tendon) => {
                2u8.feed(hash);
                tendon.feed(hash);
            }
            Self::Site { site, reference, wrench } => {
                3u8.feed(hash);
                site.feed(hash);
                reference.feed(hash);
                wrench.feed(hash);
            }
            Self::Body { body, layer } => {
                4u8.feed(hash);
                body.feed(hash);
                layer.feed(hash);
            }
        }
    }
}

/// The derived text names the kind and everything it refers to.
impl Feed for SensorKind {
    fn feed(&self, hash: &mut Fnv) {
        let text = format!("{self:?}");
        text.feed(hash);
    }
}

impl Feed for Geometry {
    fn feed(&self, hash: &mut Fnv) {
        // The kind's name tells the shapes apart; then come its sizes.
        hash.bytes(self.kind_name().as_bytes());
        match self {
            Self::Plane => {}
            Self::Sphere { radius } => radius.feed(hash),
            Self::Box { half_extents } => half_extents.feed(hash),
            Self::Capsule { radius, half_length }
            | Self::Cylinder { radius, half_length }
            | Self::Cone { radius, half_length } => [*radius, *half_length].feed(hash),
            Self::Ellipsoid { semi_axes } => semi_axes.feed(hash),
            Self::ConvexMesh(mesh) | Self::TriangleMesh(mesh) => mesh.feed(hash),
            Self::HeightField(field) => field.feed(hash),
        }
    }
}

impl Feed for ContactFilter {
    fn feed(&self, hash: &mut Fnv) {
        // Only the excluded pairs are not in the model's other fields.
        self.excluded_bodies().copied().collect::<Vec<_>>().feed(hash);
    }
}

impl<A: Feed, B: Feed> Feed for (A, B) {
    fn feed(&self, hash: &mut Fnv) {
        self.0.feed(hash);
        self.1.feed(hash);
    }
}
