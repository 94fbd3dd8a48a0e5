//! Mass matrix by the composite-rigid-body algorithm.

use glamx::glam::{DMat3, DVec3};

use crate::kinematics::Kinematics;
use crate::mass::BlockDiagonal;
use crate::math::{outer, scalar};
use crate::model::{BodyId, Inertia, JointKind, Model};

/// Inertia of a rigid body about some origin, world axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidInertia {
    /// kg.
    pub mass: f64,
    /// Mass times the centre of mass from the origin, kg·m.
    pub first_moment: DVec3,
    /// Rotational inertia about the origin, kg·m².
    pub rotational: DMat3,
}

impl RigidInertia {
    pub const ZERO: Self = Self { mass: 0.0, first_moment: DVec3::ZERO, rotational: DMat3::ZERO };

    /// A body's inertia about its origin, in its own axes.
    pub fn in_body_axes(inertia: &Inertia) -> Self {
        let first_moment = inertia.center_of_mass * inertia.mass;
        Self { mass: inertia.mass, first_moment, rotational: inertia_about_origin(inertia) }
    }

    /// The inertia of a body that is turned by `rotation`.
    pub fn turned(&self, rotation: DMat3) -> Self {
        let rotational = rotation * self.rotational * rotation.transpose();
        Self { mass: self.mass, first_moment: rotation * self.first_moment, rotational }
    }

    /// Adds an inertia whose origin is at `r` from this one's.
    pub fn add_at(&mut self, other: &Self, r: DVec3) {
        let (m, h) = (other.mass, other.first_moment);
        let cross = outer(h, r);
        let shift = scalar(2.0 * h.dot(r) + m * r.length_squared()) - cross - cross.transpose() - outer(r, r) * m;
        self.mass += m;
        self.first_moment += h + r * m;
        self.rotational += other.rotational + shift;
    }

    /// Moment about the origin and force that accelerate the body by `(angular, linear)`.
    pub fn times(&self, angular: DVec3, linear: DVec3) -> (DVec3, DVec3) {
        let moment = self.rotational * angular + self.first_moment.cross(linear);
        (moment, linear * self.mass + angular.cross(self.first_moment))
    }
}

/// Rotational inertia about the body's origin in the body's axes (parallel-axis theorem), kg·m².
fn inertia_about_origin(inertia: &Inertia) -> DMat3 {
    let c = inertia.center_of_mass;
    inertia.rotational + (scalar(c.length_squared()) - outer(c, c)) * inertia.mass
}

/// The mass matrix and the storage to compute it.
#[derive(Clone, Debug)]
pub struct MassMatrix {
    /// `M(q)`, kg, kg·m, kg·m².
    pub matrix: BlockDiagonal,
    composite: Vec<RigidInertia>,
    has_children: Vec<bool>,
    /// Of every body, in its own axes.
    inertia: Vec<RigidInertia>,
    path: Vec<PathStep>,
}

/// A body on the way to the root.
#[derive(Clone, Copy, Debug)]
struct PathStep {
    parent: usize,
    /// Its own degrees of freedom.
    first_dof: usize,
    end_dof: usize,
    /// Whether they are those of a free joint.
    free: bool,
}

impl PathStep {
    fn of(model: &Model, i: usize) -> Self {
        let dofs = model.dofs_of(BodyId(i as u32));
        let free = matches!(model.joints_of(BodyId(i as u32)), [joint] if joint.kind == JointKind::Free);
        Self { parent: model.bodies[i].parent.index(), first_dof: dofs.start, end_dof: dofs.end, free }
    }
}

impl MassMatrix {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let mut has_children = vec![false; model.bodies.len()];
        for body in &model.bodies[1..] {
            has_children[body.parent.index()] = true;
        }
        Self {
            matrix: BlockDiagonal::new(model),
            composite: vec![RigidInertia::ZERO; model.bodies.len()],
            has_children,
            inertia: model.bodies.iter().map(|body| RigidInertia::in_body_axes(&body.inertia)).collect(),
            path: (0..model.bodies.len()).map(|i| PathStep::of(model, i)).collect(),
        }
    }
}

/// Mass matrix by the composite-rigid-body algorithm: `M(q)` of `M v̇ + h = τ`, armature included.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the same `q`
/// - `mass`: out
///
/// # Cost
/// O(dofs · depth), no allocation. A free body without children costs a few dozen flops.
///
/// # Source
/// Featherstone (2008), ch. 6.2.
pub fn mass_matrix_into(model: &Model, kinematics: &Kinematics, mass: &mut MassMatrix) {
    assert_eq!(mass.path.len(), model.bodies.len(), "the storage belongs to another model");
    // Every entry that can differ from zero is written below.
    let MassMatrix { matrix, composite, has_children, inertia, path } = mass;
    for i in (1..model.bodies.len()).filter(|&i| !path[i].free || has_children[i]) {
        composite[i] = inertia[i].turned(kinematics.rotation[i]);
    }
    for i in (1..model.bodies.len()).rev() {
        let (rotation, k) = (kinematics.rotation[i], path[i].first_dof);
        if path[i].free && !has_children[i] {
            let arm = rotation * inertia[i].first_moment;
            free_columns(k, inertia[i].mass, arm, inertia[i].rotational, kinematics, matrix);
            continue;
        }
        let whole = composite[i];
        if path[i].free {
            let rotational = rotation.transpose() * whole.rotational * rotation;
            free_columns(k, whole.mass, whole.first_moment, rotational, kinematics, matrix);
            continue;
        }
        for k in path[i].first_dof..path[i].end_dof {
            column(path, kinematics, i, k, &whole, matrix);
        }
        let parent = path[i].parent;
        if parent != 0 {
            composite[parent].add_at(&whole, kinematics.offset[i]);
        }
    }
    for joint in model.joints.iter().filter(|joint| joint.armature != 0.0) {
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            matrix.add_to_diagonal(k, joint.armature);
        }
    }
}

/// Row `k` of a dof of body `i` up to and including its diagonal, and the column: the momentum that its unit rate gives to
/// all it carries, seen along every axis on the way to the root.
fn column(
    path: &[PathStep],
    kinematics: &Kinematics,
    i: usize,
    k: usize,
    inertia: &RigidInertia,
    out: &mut BlockDiagonal,
) {
    let (mut moment, force) = inertia.times(kinematics.dof_angular[k], kinematics.dof_linear[k]);
    let (block, data) = out.block_mut(out.block_of(k));
    let row = k - block.start;
    let (mut body, mut end) = (i, k + 1);
    loop {
        let step = path[body];
        let mut put = |column: usize, value: f64| {
            let column = column - block.start;
            data[row * block.size + column] = value;
            data[column * block.size + row] = value;
        };
        if step.free {
            // Its axes are the world's and the body's.
            let values = [force, kinematics.rotation[body].mul_transpose_vec3(moment)];
            let values = values.iter().flat_map(|x| x.to_array());
            (step.first_dof..).zip(values).for_each(|(column, value)| put(column, value));
            return;
        }
        let axes = kinematics.dof_angular[step.first_dof..end].iter().zip(&kinematics.dof_linear[step.first_dof..end]);
        for (column, (angular, linear)) in (step.first_dof..).zip(axes) {
            put(column, angular.dot(moment) + linear.dot(force));
        }
        if step.parent == 0 {
            return;
        }
        moment += kinematics.offset[body].cross(force);
        body = step.parent;
        end = path[body].end_dof;
    }
}

/// The 6 × 6 block of a free joint, velocities in world axes, angular velocities in the body's:
/// `[m 1, −[R m c]× R; …, I_o]`, in which only the coupling depends on the configuration.
/// - `first_moment`: world axes; `rotational`: about the origin, body axes
fn free_columns(
    k: usize,
    m: f64,
    first_moment: DVec3,
    rotational: DMat3,
    kinematics: &Kinematics,
    out: &mut BlockDiagonal,
) {
    let rotational = rotational.to_cols_array_2d();
    for a in 0..3 {
        out.set(k + a, k + a, m);
        let coupling = kinematics.dof_angular[k + 3 + a].cross(first_moment).to_array();
        for b in 0..3 {
            out.set(k + 3 + a, k + b, coupling[b]);
        }
        for b in 0..=a {
            out.set(k + 3 + a, k + 3 + b, rotational[a][b]);
        }
    }
}
