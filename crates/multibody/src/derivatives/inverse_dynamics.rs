//! Derivatives of inverse dynamics in recursive form.

use glamx::glam::DVec3;

use crate::composite::{RigidInertia, momentum};
use crate::coriolis::ByVelocity;
use crate::kinematics::Kinematics;
use crate::model::Model;
use crate::motion::MotionDerivatives;
use crate::spatial::SpatialVector;

/// `τ`, `∂τ/∂q`, `∂τ/∂v` and `∂τ/∂v̇` of inverse dynamics with wrenches from outside, and the storage to compute them.
#[derive(Clone, Debug)]
pub struct InverseDynamicsDerivatives {
    /// `τ`, `[nv]`, N, N·m.
    pub force: Vec<f64>,
    /// `∂τ/∂q` in tangent coordinates at fixed `v`, `v̇`, `[nv, nv]` row by row.
    pub by_configuration: Vec<f64>,
    /// `∂τ/∂v`, `[nv, nv]` row by row.
    pub by_velocity: Vec<f64>,
    /// `M`, which is `∂τ/∂v̇`, `[nv, nv]` row by row.
    pub mass: Vec<f64>,
    /// Of the velocity given.
    pub motion: MotionDerivatives,
    pub(super) links: Vec<LinkDynamics>,
    /// Of every body, in its own axes.
    inertia: Vec<RigidInertia>,
    drag: Vec<Drag>,
    /// Of the degrees of freedom of the link at hand.
    taken: [Taken; 3],
    /// Whether gravity is compensated anywhere.
    floats: bool,
}

/// What a degree of freedom changes when its link moves rigidly.
#[derive(Clone, Copy, Debug)]
struct Drag {
    /// Rotation of velocities by its displacement.
    turn: DVec3,
    /// Of accelerations by its displacement and by its rate.
    by_place: SpatialVector,
    by_rate: SpatialVector,
    /// Of gravity by its displacement.
    fall: SpatialVector,
}

/// What a degree of freedom takes of the wrench on all that it carries: by accelerations, by the rotation of a velocity common to all, by
/// gravity where it does not pull.
#[derive(Clone, Copy, Debug)]
struct Taken {
    acceleration: SpatialVector,
    turn: DVec3,
    fall: SpatialVector,
}

/// A link with all that hangs on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkDynamics {
    /// Acceleration after it, less gravity.
    pub after: SpatialVector,
    pub inertia: RigidInertia,
    /// Mass that gravity does not pull, and its first moment, as an inertia without rotational part.
    pub floating: RigidInertia,
    /// The wrench that it takes.
    wrench: SpatialVector,
    /// How the wrench changes with a velocity common to all.
    by_velocity: ByVelocity,
}

const ZERO: SpatialVector = SpatialVector::ZERO;

const NOTHING: LinkDynamics = LinkDynamics {
    after: SpatialVector::ZERO,
    inertia: RigidInertia::ZERO,
    floating: RigidInertia::ZERO,
    wrench: SpatialVector::ZERO,
    by_velocity: ByVelocity::ZERO,
};

impl InverseDynamicsDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let motion = MotionDerivatives::new(model);
        let nv = model.nv;
        Self {
            force: vec![0.0; nv],
            by_configuration: vec![0.0; nv * nv],
            by_velocity: vec![0.0; nv * nv],
            links: vec![NOTHING; motion.links.all.len()],
            inertia: model.bodies.iter().map(|body| RigidInertia::in_body_axes(&body.inertia)).collect(),
            mass: vec![0.0; nv * nv],
            drag: vec![Drag { turn: DVec3::ZERO, by_place: ZERO, by_rate: ZERO, fall: ZERO }; nv],
            taken: [Taken { acceleration: ZERO, turn: DVec3::ZERO, fall: ZERO }; 3],
            floats: model.bodies.iter().any(|body| body.gravity_compensation != 0.0),
            motion,
        }
    }
}

/// `τ = M v̇ + h − Σ Jᵀ W` with its derivatives, where the wrenches `W` are fixed to their bodies and turn with them, and `h` is without the
/// weight that gravity compensation takes away.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the configuration
/// - `v`, `acceleration`: `[nv]`
/// - `external`: for every body moment about its origin and force from outside, world axes, N·m and N; empty for none
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(dofs · depth), no allocation.
///
/// # Source
/// J. Carpentier, N. Mansard, *Analytical Derivatives of Rigid Body Dynamics Algorithms*, Robotics: Science and Systems (2018): all about one
/// point per tree. A degree of freedom displaces what it carries rigidly, which turns the wrench with it, and takes away the velocity
/// and acceleration that its parent has there.
pub fn inverse_dynamics_derivatives_into(
    model: &Model,
    kinematics: &Kinematics,
    v: &[f64],
    acceleration: &[f64],
    external: &[SpatialVector],
    out: &mut InverseDynamicsDerivatives,
) {
    assert!(v.len() == model.nv && acceleration.len() == model.nv, "lengths must be nv");
    out.motion.set(model, kinematics, v);
    let gravity = SpatialVector { angular: Default::default(), linear: -model.gravity };
    accelerate(v, acceleration, gravity, out);
    gather_bodies(model, kinematics, gravity, external, out);
    for l in (0..out.links.len()).rev() {
        write_link(l, model.nv, out);
        if let Some(parent) = out.motion.links.all[l].parent {
            let (head, tail) = out.links.split_at_mut(l);
            add_link(&mut head[parent], &tail[0]);
        }
    }
    for joint in model.joints.iter().filter(|joint| joint.armature != 0.0) {
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            out.force[k] += joint.armature * acceleration[k];
            out.mass[k * (model.nv + 1)] += joint.armature;
        }
    }
}

/// Accelerations of the links, and what each degree of freedom takes away where it displaces or turns.
fn accelerate(v: &[f64], acceleration: &[f64], gravity: SpatialVector, out: &mut InverseDynamicsDerivatives) {
    let InverseDynamicsDerivatives { motion, links, drag, .. } = out;
    for (l, link) in motion.links.all.iter().enumerate() {
        let before = link.parent.map_or(gravity, |parent| links[parent].after);
        let (u, w) = (motion.before[l], motion.after[l]);
        let (mut own, mut rate) = (before, SpatialVector::ZERO);
        for k in link.dofs.clone() {
            let axis = motion.axis[k];
            own += axis.scaled(acceleration[k]);
            rate += axis.scaled(v[k]);
            let by_place = u.carry_motion(axis);
            drag[k] = Drag {
                turn: by_place.angular,
                by_place: before.carry_motion(axis) + u.carry_motion(by_place),
                by_rate: (u + w).carry_motion(axis),
                fall: gravity.carry_motion(axis),
            };
        }
        links[l] = LinkDynamics { after: own + u.carry_motion(rate), ..NOTHING };
    }
}

/// Inertias, wrenches and their change with velocity of each link's own bodies.
fn gather_bodies(
    model: &Model,
    kinematics: &Kinematics,
    gravity: SpatialVector,
    external: &[SpatialVector],
    out: &mut InverseDynamicsDerivatives,
) {
    for (i, body) in model.bodies.iter().enumerate() {
        let Some(l) = out.motion.links.of_body[i] else { continue };
        let from_reference = kinematics.pose[i].position - out.motion.reference[l];
        let placed = out.inertia[i].turned(kinematics.rotation[i]);
        let link = &mut out.links[l];
        link.inertia.add_at(&placed, from_reference);
        if body.gravity_compensation != 0.0 {
            let share = body.gravity_compensation;
            let held = RigidInertia {
                mass: share * placed.mass,
                first_moment: placed.first_moment * share,
                rotational: RigidInertia::ZERO.rotational,
            };
            link.floating.add_at(&held, from_reference);
        }
        if let Some(wrench) = external.get(i) {
            let moment = wrench.angular + from_reference.cross(wrench.linear);
            link.wrench -= SpatialVector { angular: moment, linear: wrench.linear };
        }
    }
    for (l, link) in out.links.iter_mut().enumerate() {
        let v = out.motion.after[l];
        let carried = momentum(&link.inertia, v);
        link.wrench +=
            momentum(&link.inertia, link.after) + v.carry_wrench(carried) - momentum(&link.floating, gravity);
        link.by_velocity = ByVelocity::of(&link.inertia, v, carried.linear);
    }
}

/// Rows and columns of a link whose subtree is complete: its columns in the rows up to the root, and its rows in the columns up to the
/// root.
fn write_link(l: usize, nv: usize, out: &mut InverseDynamicsDerivatives) {
    let InverseDynamicsDerivatives {
        force,
        by_configuration,
        by_velocity,
        mass,
        motion,
        links,
        drag,
        taken,
        floats,
        ..
    } = out;
    let (link, whole) = (&motion.links.all[l], &links[l]);
    for (k, taken) in link.dofs.clone().zip(&mut *taken) {
        let axis = motion.axis[k];
        force[k] = axis.dot(whole.wrench);
        taken.acceleration = momentum(&whole.inertia, axis);
        taken.turn = whole.by_velocity.times_transposed(axis);
        taken.fall = if *floats { momentum(&whole.floating, axis) } else { ZERO };
    }
    for k in link.dofs.clone() {
        let (axis, drag) = (motion.axis[k], &drag[k]);
        let mut of_place = momentum(&whole.inertia, drag.by_place) + whole.by_velocity.times(drag.turn);
        if *floats {
            of_place -= momentum(&whole.floating, drag.fall);
        }
        let of_rate = momentum(&whole.inertia, drag.by_rate) + whole.by_velocity.times(axis.angular);
        for (row, taken) in link.dofs.clone().zip(&*taken) {
            by_configuration[row * nv + k] = motion.axis[row].dot(of_place);
            by_velocity[row * nv + k] = motion.axis[row].dot(of_rate);
            mass[row * nv + k] = taken.acceleration.dot(axis);
        }
        let turned = of_place + axis.carry_wrench(whole.wrench);
        let mut at = link.parent;
        while let Some(parent) = at {
            for row in motion.links.all[parent].dofs.clone() {
                by_configuration[row * nv + k] = motion.axis[row].dot(turned);
                by_velocity[row * nv + k] = motion.axis[row].dot(of_rate);
            }
            at = motion.links.all[parent].parent;
        }
    }
    let mut at = link.parent;
    while let Some(parent) = at {
        for k in motion.links.all[parent].dofs.clone() {
            let (axis, drag) = (motion.axis[k], &drag[k]);
            for (row, taken) in link.dofs.clone().zip(&*taken) {
                let mut of_place = taken.acceleration.dot(drag.by_place) + taken.turn.dot(drag.turn);
                if *floats {
                    of_place -= taken.fall.dot(drag.fall);
                }
                by_configuration[row * nv + k] = of_place;
                by_velocity[row * nv + k] = taken.acceleration.dot(drag.by_rate) + taken.turn.dot(axis.angular);
                let inertia = taken.acceleration.dot(axis);
                (mass[row * nv + k], mass[k * nv + row]) = (inertia, inertia);
            }
        }
        at = motion.links.all[parent].parent;
    }
}

fn add_link(parent: &mut LinkDynamics, child: &LinkDynamics) {
    parent.inertia.add(&child.inertia);
    parent.floating.add(&child.floating);
    parent.wrench += child.wrench;
    parent.by_velocity.add(&child.by_velocity);
}
