//! Numbers of a model that a step depends on.

use signorini_multibody::derivatives::{BalanceAt, BalanceChange, InertiaChange, JointChange};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{ActuatorId, BodyId, GeomId, Geometry, Joint, JointId, Model};

/// A number of a model, or of a state beside `q` and `v`, by which a step is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ScalarParameter {
    /// Δt, s.
    Timestep,
    /// Gravity along an axis of the world (0, 1, 2), m/s².
    Gravity(usize),
    /// Mass of a body, kg; its centre of mass and its rotational inertia about that stay.
    Mass(BodyId),
    /// Centre of mass along an axis of the body, m; the rotational inertia about it stays.
    CenterOfMass(BodyId, usize),
    /// Rotational inertia about the centre of mass in the axes of the body, kg·m²: an entry and the one across the diagonal.
    Inertia(BodyId, [usize; 2]),
    /// Damping of a joint, N·s/m or N·m·s/rad.
    Damping(JointId),
    /// Stiffness of a joint, N/m or N·m/rad.
    Stiffness(JointId),
    /// Rest value of a joint's spring, m or rad.
    SpringReference(JointId),
    /// Rotor inertia of a joint, kg or kg·m².
    Armature(JointId),
    /// Dry friction of a joint, N or N·m.
    FrictionLoss(JointId),
    /// Coefficient of sliding friction of a geom.
    Friction(GeomId),
    /// Coefficient of friction of a geom against spinning, m.
    SpinningFriction(GeomId),
    /// Coefficient of friction of a geom against rolling, m.
    RollingFriction(GeomId),
    /// Coefficient of sliding friction of an entry of [`Model::pairs`].
    PairFriction(usize),
    /// Coefficient of restitution of a geom.
    Restitution(GeomId),
    /// Distance from a geom's surface at which contacts act, m.
    Margin(GeomId),
    /// Place of a geom in its body, along an axis of the body, m.
    GeomPosition(GeomId, usize),
    /// A size of a geom's shape, m: radius; half-extents (3); radius and half-length of capsules.
    GeomSize(GeomId, usize),
    /// Activation of an actuator at the beginning of the step.
    Activation(ActuatorId),
}

impl ScalarParameter {
    /// Every number that a model has, activations among them: all by which its steps can be differentiated, whether they feel them or not.
    pub fn all(model: &Model) -> Vec<Self> {
        let mut all = vec![Self::Timestep];
        all.extend((0..3).map(Self::Gravity));
        for body in (1..model.bodies.len()).map(|i| BodyId(i as u32)) {
            all.push(Self::Mass(body));
            all.extend((0..3).map(|axis| Self::CenterOfMass(body, axis)));
            let entries = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
            all.extend(entries.map(|entry| Self::Inertia(body, entry)));
        }
        for (k, joint) in model.joints.iter().enumerate() {
            all.extend(Self::all_of_joint(JointId(k as u32), joint));
        }
        for geom in (0..model.geoms.len()).map(|k| GeomId(k as u32)) {
            all.extend([Self::Friction(geom), Self::SpinningFriction(geom), Self::RollingFriction(geom)]);
            all.extend([Self::Restitution(geom), Self::Margin(geom)]);
            all.extend((0..3).map(|axis| Self::GeomPosition(geom, axis)));
            all.extend((0..3).map(|size| Self::GeomSize(geom, size)));
        }
        all.extend((0..model.pairs.len()).map(Self::PairFriction));
        all.retain(|parameter| parameter.value(model).is_some());
        let activated = model.actuators.iter().enumerate().filter(|(_, actuator)| actuator.activation.is_some());
        all.extend(activated.map(|(a, _)| Self::Activation(ActuatorId(a as u32))));
        all
    }

    /// Springs and dry friction are numbers of the joints that have them.
    fn all_of_joint(id: JointId, joint: &Joint) -> impl Iterator<Item = Self> {
        let (has_spring, has_friction) = (joint.stiffness > 0.0, joint.friction_loss > 0.0);
        let turns = joint.kind.nv() == 1;
        let along = [Self::Damping(id), Self::Armature(id)].into_iter().filter(move |_| turns);
        let spring = [Self::Stiffness(id), Self::SpringReference(id)].into_iter().filter(move |_| has_spring);
        along.chain(spring).chain(has_friction.then_some(Self::FrictionLoss(id)))
    }

    /// Its value; none where the model has no such number (and for an activation, which is in the state).
    pub fn value(self, model: &Model) -> Option<f64> {
        let joint = |id: JointId| model.joints.get(id.index());
        let geom = |id: GeomId| model.geoms.get(id.index());
        let inertia = |id: BodyId| model.bodies.get(id.index()).map(|body| &body.inertia);
        match self {
            Self::Timestep => Some(model.timestep),
            Self::Gravity(axis) => model.gravity.to_array().get(axis).copied(),
            Self::Mass(body) => inertia(body).map(|inertia| inertia.mass),
            Self::CenterOfMass(body, axis) => inertia(body)?.center_of_mass.to_array().get(axis).copied(),
            Self::Inertia(body, [r, c]) => inertia(body)?.rotational.to_cols_array_2d().get(c)?.get(r).copied(),
            Self::Damping(id) => joint(id).map(|joint| joint.damping),
            Self::Stiffness(id) => joint(id).map(|joint| joint.stiffness),
            Self::SpringReference(id) => joint(id).map(|joint| joint.spring_reference),
            Self::Armature(id) => joint(id).map(|joint| joint.armature),
            Self::FrictionLoss(id) => joint(id).map(|joint| joint.friction_loss),
            Self::Friction(id) => geom(id).map(|geom| geom.friction),
            Self::SpinningFriction(id) => geom(id).map(|geom| geom.spinning_friction),
            Self::RollingFriction(id) => geom(id).map(|geom| geom.rolling_friction),
            Self::PairFriction(k) => model.pairs.get(k).map(|pair| pair.friction),
            Self::Restitution(id) => geom(id).map(|geom| geom.restitution),
            Self::Margin(id) => geom(id).map(|geom| geom.margin),
            Self::GeomPosition(id, axis) => geom(id)?.placement.position.to_array().get(axis).copied(),
            Self::GeomSize(id, k) => size_of(&mut geom(id)?.geometry.clone(), k).map(|size| *size),
            Self::Activation(_) => None,
        }
    }

    /// The least and the largest value that a model may give it, whatever its other numbers are.
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::Timestep | Self::GeomSize(..) => [f64::MIN_POSITIVE, f64::INFINITY],
            Self::Restitution(_) => [0.0, 1.0],
            Self::Mass(_)
            | Self::Damping(_)
            | Self::Stiffness(_)
            | Self::Armature(_)
            | Self::FrictionLoss(_)
            | Self::Friction(_)
            | Self::SpinningFriction(_)
            | Self::RollingFriction(_)
            | Self::PairFriction(_)
            | Self::Margin(_) => [0.0, f64::INFINITY],
            Self::Inertia(_, [r, c]) if r == c => [0.0, f64::INFINITY],
            Self::Gravity(_)
            | Self::CenterOfMass(..)
            | Self::Inertia(..)
            | Self::SpringReference(_)
            | Self::GeomPosition(..)
            | Self::Activation(_) => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Gives it another value, which [`Model::check_numbers`] may find out of its range. What is made from a model, such as a workspace, has
    /// to be made again. `false` where the model has no such number.
    pub fn set(self, model: &mut Model, value: f64) -> bool {
        let place = match self {
            Self::Timestep => Some(&mut model.timestep),
            Self::Gravity(axis) => axis_of(&mut model.gravity, axis),
            Self::Mass(body) => model.bodies.get_mut(body.index()).map(|body| &mut body.inertia.mass),
            Self::CenterOfMass(body, axis) => {
                model.bodies.get_mut(body.index()).and_then(|body| axis_of(&mut body.inertia.center_of_mass, axis))
            }
            Self::Inertia(body, [r, c]) => {
                let Some(body) = model.bodies.get_mut(body.index()).filter(|_| r < 3 && c < 3) else { return false };
                let mut entries = body.inertia.rotational.to_cols_array_2d();
                (entries[c][r], entries[r][c]) = (value, value);
                body.inertia.rotational = DMat3::from_cols_array_2d(&entries);
                return true;
            }
            Self::Damping(id) => model.joints.get_mut(id.index()).map(|joint| &mut joint.damping),
            Self::Stiffness(id) => model.joints.get_mut(id.index()).map(|joint| &mut joint.stiffness),
            Self::SpringReference(id) => model.joints.get_mut(id.index()).map(|joint| &mut joint.spring_reference),
            Self::Armature(id) => model.joints.get_mut(id.index()).map(|joint| &mut joint.armature),
            Self::FrictionLoss(id) => model.joints.get_mut(id.index()).map(|joint| &mut joint.friction_loss),
            Self::Friction(id) => model.geoms.get_mut(id.index()).map(|geom| &mut geom.friction),
            Self::SpinningFriction(id) => model.geoms.get_mut(id.index()).map(|geom| &mut geom.spinning_friction),
            Self::RollingFriction(id) => model.geoms.get_mut(id.index()).map(|geom| &mut geom.rolling_friction),
            Self::PairFriction(k) => model.pairs.get_mut(k).map(|pair| &mut pair.friction),
            Self::Restitution(id) => model.geoms.get_mut(id.index()).map(|geom| &mut geom.restitution),
            Self::Margin(id) => model.geoms.get_mut(id.index()).map(|geom| &mut geom.margin),
            Self::GeomPosition(id, axis) => {
                model.geoms.get_mut(id.index()).and_then(|geom| axis_of(&mut geom.placement.position, axis))
            }
            Self::GeomSize(id, k) => model.geoms.get_mut(id.index()).and_then(|geom| size_of(&mut geom.geometry, k)),
            Self::Activation(_) => None,
        };
        place.map(|place| *place = value).is_some()
    }
}

fn axis_of(v: &mut DVec3, axis: usize) -> Option<&mut f64> {
    match axis {
        0 => Some(&mut v.x),
        1 => Some(&mut v.y),
        2 => Some(&mut v.z),
        _ => None,
    }
}

fn size_of(geometry: &mut Geometry, k: usize) -> Option<&mut f64> {
    match (geometry, k) {
        (Geometry::Sphere { radius }, 0) => Some(radius),
        (Geometry::Box { half_extents }, k) => axis_of(half_extents, k),
        (Geometry::Ellipsoid { semi_axes }, k) => axis_of(semi_axes, k),
        (
            Geometry::Capsule { radius, half_length }
            | Geometry::Cylinder { radius, half_length }
            | Geometry::Cone { radius, half_length },
            k,
        ) => match k {
            0 => Some(radius),
            1 => Some(half_length),
            _ => None,
        },
        _ => None,
    }
}

/// Numbers of a model that change together: each with its share. A box has its size, mass and inertia in common; two geoms that have
/// the same friction, and of which a contact takes the larger, have a derivative together alone.
pub type Direction = Vec<(ScalarParameter, f64)>;

/// The sum of the shares of what `of` picks from a direction.
pub(crate) fn share(direction: &[(ScalarParameter, f64)], of: impl Fn(ScalarParameter) -> bool) -> f64 {
    direction.iter().filter(|(parameter, _)| of(*parameter)).map(|(_, weight)| weight).sum()
}

/// `∂E` along a direction, in all that is no contact, `[nv]`.
pub(crate) fn add_smooth(at: &BalanceAt, direction: &[(ScalarParameter, f64)], out: &mut [f64]) {
    direction
        .iter()
        .filter_map(|&(parameter, weight)| change_of(parameter, weight))
        .for_each(|change| at.add(&change, out));
}

/// What a change of a parameter is to the balance; nothing if that does not depend on it.
fn change_of(parameter: ScalarParameter, weight: f64) -> Option<BalanceChange> {
    let unit = |axis: usize| DVec3::AXES[axis.min(2)] * weight;
    let inertia = |body: BodyId, change: InertiaChange| Some(BalanceChange::Inertia(body, change));
    let joint = |id: JointId, change: JointChange| Some(BalanceChange::Joint(id, change));
    match parameter {
        ScalarParameter::Timestep => Some(BalanceChange::Timestep(weight)),
        ScalarParameter::Gravity(axis) => Some(BalanceChange::Gravity(unit(axis))),
        ScalarParameter::Mass(body) => inertia(body, InertiaChange { mass: weight, ..InertiaChange::ZERO }),
        ScalarParameter::CenterOfMass(body, axis) => {
            inertia(body, InertiaChange { center_of_mass: unit(axis), ..InertiaChange::ZERO })
        }
        ScalarParameter::Inertia(body, [r, c]) => {
            let mut entries = [[0.0; 3]; 3];
            (entries[r][c], entries[c][r]) = (weight, weight);
            let rotational = DMat3::from_cols_array_2d(&entries);
            inertia(body, InertiaChange { rotational, ..InertiaChange::ZERO })
        }
        ScalarParameter::Damping(id) => joint(id, JointChange { damping: weight, ..Default::default() }),
        ScalarParameter::Stiffness(id) => joint(id, JointChange { stiffness: weight, ..Default::default() }),
        ScalarParameter::Armature(id) => joint(id, JointChange { armature: weight, ..Default::default() }),
        ScalarParameter::SpringReference(id) => {
            joint(id, JointChange { spring_reference: weight, ..Default::default() })
        }
        ScalarParameter::Activation(id) => Some(BalanceChange::Activation(id, weight)),
        _ => None,
    }
}
