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
    first_moment: DVec3,
    /// Rotational inertia about the origin, kg·m².
    rotational: DMat3,
}

impl RigidInertia {
    pub const ZERO: Self = Self { mass: 0.0, first_moment: DVec3::ZERO, rotational: DMat3::ZERO };

    /// A body's inertia about its origin, in its own axes turned by `rotation`.
    pub fn of_body(inertia: &Inertia, rotation: DMat3) -> Self {
        let first_moment = rotation * (inertia.center_of_mass * inertia.mass);
        let rotational = rotation * inertia_about_origin(inertia) * rotation.transpose();
        Self { mass: inertia.mass, first_moment, rotational }
    }

    /// Adds an inertia about the same origin.
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.rotational += other.rotational;
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
    mass.matrix.set_zero();
    mass.composite.fill(RigidInertia::ZERO);
    for i in (1..model.bodies.len()).rev() {
        let id = BodyId(i as u32);
        let body = &model.bodies[i];
        let rotation = kinematics.rotation[i];
        if let ([joint], false) = (model.joints_of(id), mass.has_children[i])
            && joint.kind == JointKind::Free
        {
            let arm = rotation * (body.inertia.center_of_mass * body.inertia.mass);
            let rotational = inertia_about_origin(&body.inertia);
            free_columns(joint.v_index, body.inertia.mass, arm, rotational, kinematics, &mut mass.matrix);
            continue;
        }
        mass.composite[i].add(&RigidInertia::of_body(&body.inertia, rotation));
        let composite = mass.composite[i];
        if let [joint] = model.joints_of(id)
            && joint.kind == JointKind::Free
        {
            let rotational = rotation.transpose() * composite.rotational * rotation;
            let (k, m) = (joint.v_index, composite.mass);
            free_columns(k, m, composite.first_moment, rotational, kinematics, &mut mass.matrix);
            continue;
        }
        for k in model.dofs_of(id) {
            column(model, kinematics, i, k, &composite, &mut mass.matrix);
        }
        let parent = body.parent.index();
        if parent != 0 {
            mass.composite[parent].add_at(&composite, kinematics.offset[i]);
        }
    }
    for joint in model.joints.iter().filter(|joint| joint.armature != 0.0) {
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            mass.matrix.add_to_diagonal(k, joint.armature);
        }
    }
}

/// Row `k` of a dof of body `i` up to and including its diagonal, and the column: the momentum that its unit rate gives to
/// all it carries, seen along every axis on the way to the root.
fn column(model: &Model, kinematics: &Kinematics, i: usize, k: usize, inertia: &RigidInertia, out: &mut BlockDiagonal) {
    let (mut moment, force) = inertia.times(kinematics.dof_angular[k], kinematics.dof_linear[k]);
    let (block, data) = out.block_mut(out.block_of(k));
    let row = k - block.start;
    let mut fill = |dofs: std::ops::Range<usize>, moment: DVec3| {
        for j in dofs {
            let value = kinematics.dof_angular[j].dot(moment) + kinematics.dof_linear[j].dot(force);
            let column = j - block.start;
            data[row * block.size + column] = value;
            data[column * block.size + row] = value;
        }
    };
    let own = model.dofs_of(BodyId(i as u32));
    fill(own.start..k + 1, moment);
    let mut b = i;
    while model.bodies[b].parent != BodyId::WORLD {
        moment += kinematics.offset[b].cross(force);
        b = model.bodies[b].parent.index();
        fill(model.dofs_of(BodyId(b as u32)), moment);
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
