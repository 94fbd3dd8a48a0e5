//! Mass matrix by the composite-rigid-body algorithm.

use std::ops::Range;

use glamx::glam::{DMat3, DVec3};

use crate::kinematics::Kinematics;
use crate::layout::Block;
use crate::mass::BlockDiagonal;
use crate::math::{outer, scalar};
use crate::model::{BodyId, Inertia, Model};
use crate::moving::{MovingBodies, MovingBody};
use crate::spatial::SpatialVector;
use crate::standing::{Known, Nothing};

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
        if self.rotational == DMat3::ZERO {
            return Self { first_moment: rotation * self.first_moment, ..*self };
        }
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

    /// Adds an inertia about the same origin.
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.first_moment += other.first_moment;
        self.rotational += other.rotational;
    }

    /// Moment about the origin and force that accelerate the body by `(angular, linear)`.
    pub fn times(&self, angular: DVec3, linear: DVec3) -> (DVec3, DVec3) {
        let moment = self.rotational * angular + self.first_moment.cross(linear);
        (moment, linear * self.mass + angular.cross(self.first_moment))
    }
}

/// Momentum of a rigid body about the point that its inertia refers to.
#[inline]
pub(crate) fn momentum(inertia: &RigidInertia, motion: SpatialVector) -> SpatialVector {
    let (angular, linear) = inertia.times(motion.angular, motion.linear);
    SpatialVector { angular, linear }
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
    /// Of every body that can move and is not free and alone, with what is welded to it, about its origin, world axes.
    pub(crate) placed: Vec<RigidInertia>,
    moving: Vec<MovingPart>,
    /// Of every degree of freedom.
    momenta: Vec<Momentum>,
    carried: Carried,
}

/// A body that can move.
#[derive(Clone, Debug)]
struct MovingPart {
    body: usize,
    /// With all that is welded to it, in its own axes.
    inertia: RigidInertia,
    /// Whether it is free, without rotor inertia, and no body with joints hangs on it.
    is_alone: bool,
}

impl MovingPart {
    fn all(model: &Model) -> Vec<Self> {
        let moving = MovingBodies::of(model).0;
        let mut carries = vec![false; model.bodies.len()];
        moving.iter().for_each(|one| carries[one.carrier] = true);
        let has_rotor = |i: usize| model.joints_of(BodyId(i as u32)).iter().any(|joint| joint.armature != 0.0);
        let part = |one: &MovingBody| Self {
            body: one.body,
            inertia: RigidInertia::in_body_axes(&one.inertia),
            is_alone: model.path[one.body].free && !carries[one.body] && !has_rotor(one.body),
        };
        moving.iter().map(part).collect()
    }
}

/// For every body the degrees of freedom of its own joints and of all that hangs on it, as runs of neighbours: one run, if
/// bodies were added tree by tree.
#[derive(Clone, Debug)]
struct Carried {
    runs: Vec<Range<usize>>,
    /// Where each body's runs begin, and the total.
    offsets: Vec<usize>,
}

impl Carried {
    fn of(model: &Model) -> Self {
        let mut of_body: Vec<Vec<Range<usize>>> = vec![Vec::new(); model.bodies.len()];
        for (i, step) in model.path.iter().enumerate().rev() {
            let own = step.first_dof..step.end_dof;
            of_body[i].extend((!own.is_empty()).then_some(own));
            of_body[i].sort_by_key(|run| run.start);
            of_body[i].dedup_by(|next, run| {
                let neighbours = run.end == next.start;
                run.end = if neighbours { next.end } else { run.end };
                neighbours
            });
            // What the world carries is asked by nobody.
            if step.parent != 0 {
                let runs = of_body[i].clone();
                of_body[step.parent].extend(runs);
            }
        }
        of_body[0].clear();
        let mut offsets = vec![0];
        offsets.extend(of_body.iter().scan(0, |sum, runs| {
            *sum += runs.len();
            Some(*sum)
        }));
        Self { runs: of_body.concat(), offsets }
    }

    fn runs_of(&self, i: usize) -> &[Range<usize>] {
        &self.runs[self.offsets[i]..self.offsets[i + 1]]
    }
}

/// The momentum that a unit rate of a degree of freedom gives to all it carries: moment about the origin of the body that is
/// at hand, then force, world axes; or an axis of a joint: angular, then linear.
#[derive(Clone, Copy, Debug)]
struct Momentum([f64; 6]);

impl Momentum {
    const ZERO: Self = Self([0.0; 6]);

    fn new(moment: DVec3, force: DVec3) -> Self {
        Self([moment.x, moment.y, moment.z, force.x, force.y, force.z])
    }

    /// The same referred to an origin at `−r` from the present one.
    fn shift(&mut self, r: DVec3) {
        let [mx, my, mz, fx, fy, fz] = self.0;
        self.0 = [mx + (r.y * fz - r.z * fy), my + (r.z * fx - r.x * fz), mz + (r.x * fy - r.y * fx), fx, fy, fz];
    }

    /// The scalar product with an axis, two products at a time.
    fn dot(&self, axis: &Self) -> f64 {
        let (a, b) = (&self.0, &axis.0);
        let sums: [f64; 2] = std::array::from_fn(|l| a[l] * b[l] + a[2 + l] * b[2 + l] + a[4 + l] * b[4 + l]);
        sums[0] + sums[1]
    }
}

impl MassMatrix {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            matrix: BlockDiagonal::new(model),
            composite: vec![RigidInertia::ZERO; model.bodies.len()],
            placed: vec![RigidInertia::ZERO; model.bodies.len()],
            moving: MovingPart::all(model),
            momenta: vec![Momentum::ZERO; model.nv],
            carried: Carried::of(model),
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
/// Featherstone (2008), ch. 6.2. All columns that a body carries go to its parent together, about whose origin they are then,
/// so that no number depends on where the world's origin is.
pub fn mass_matrix_into(model: &Model, kinematics: &Kinematics, mass: &mut MassMatrix) {
    mass_matrix_of(model, kinematics, Nothing, mass);
}

/// [`mass_matrix_into`] of what is not known.
pub(crate) fn mass_matrix_of(model: &Model, kinematics: &Kinematics, known: impl Known, mass: &mut MassMatrix) {
    assert_eq!(mass.composite.len(), model.bodies.len(), "the storage belongs to another model");
    // Every entry that can differ from zero is written below.
    let MassMatrix { matrix, composite, placed, moving, momenta, carried } = mass;
    for part in moving.iter().filter(|part| !part.is_alone && !known.has_body(part.body)) {
        placed[part.body] = part.inertia.turned(kinematics.rotation[part.body]);
        composite[part.body] = placed[part.body];
    }
    for MovingPart { body: i, inertia, is_alone } in moving.iter().rev().filter(|part| !known.has_body(part.body)) {
        let i = *i;
        let (rotation, step) = (kinematics.rotation[i], &model.path[i]);
        if *is_alone {
            let arm = rotation * inertia.first_moment;
            free_block(step.first_dof, inertia.mass, arm, inertia.rotational, kinematics, matrix);
            continue;
        }
        let (whole, runs) = (&composite[i], carried.runs_of(i));
        if step.free {
            let rotational = rotation.transpose() * whole.rotational * rotation;
            free_block(step.first_dof, whole.mass, whole.first_moment, rotational, kinematics, matrix);
            for k in runs.iter().flat_map(|run| run.start.max(step.end_dof)..run.end) {
                put_free_column(rotation, &momenta[k], step.first_dof, k, matrix);
            }
            continue;
        }
        for k in step.first_dof..step.end_dof {
            let (moment, force) = whole.times(kinematics.dof_angular[k], kinematics.dof_linear[k]);
            momenta[k] = Momentum::new(moment, force);
        }
        for k in step.first_dof..step.end_dof {
            let axis = Momentum::new(kinematics.dof_angular[k], kinematics.dof_linear[k]);
            for run in runs.iter().filter(|run| run.end > k) {
                put_row(&axis, momenta, k, run.start.max(k)..run.end, matrix.block_mut(matrix.block_of(k)));
            }
        }
        if step.above != 0 {
            let offset = kinematics.offset[i];
            let whole = *whole;
            composite[step.parent].add_at(&whole, offset);
            runs.iter().for_each(|run| momenta[run.clone()].iter_mut().for_each(|momentum| momentum.shift(offset)));
        }
    }
    for joint in model.joints.iter().filter(|joint| joint.armature != 0.0 && !known.has_dof(joint.v_index)) {
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            matrix.add_to_diagonal(k, joint.armature);
        }
    }
}

/// Row `k` of a block, that of an axis, at the columns of a run, and the column.
fn put_row(axis: &Momentum, momenta: &[Momentum], k: usize, run: Range<usize>, block: (Block, &mut [f64])) {
    match axis.0 {
        // Most joints turn about the origin of their body.
        [x, y, z, 0.0, 0.0, 0.0] => {
            put_entries(|momentum| momentum.0[0] * x + momentum.0[2] * z + momentum.0[1] * y, momenta, k, run, block);
        }
        _ => put_entries(|momentum| momentum.dot(axis), momenta, k, run, block),
    }
}

#[inline]
fn put_entries(
    product: impl Fn(&Momentum) -> f64,
    momenta: &[Momentum],
    k: usize,
    run: Range<usize>,
    (block, data): (Block, &mut [f64]),
) {
    let (n, row) = (block.size, k - block.start);
    let mut mirrored = (run.start - block.start) * n + row;
    let own = row * n + run.start - block.start;
    for (momentum, entry) in momenta[run].iter().zip(own..) {
        let value = product(momentum);
        data[entry] = value;
        data[mirrored] = value;
        mirrored += n;
    }
}

/// Column `k` at the rows of a free joint, and the row: the axes of the joint are the world's and the body's.
fn put_free_column(rotation: DMat3, momentum: &Momentum, first: usize, k: usize, out: &mut BlockDiagonal) {
    let [mx, my, mz, fx, fy, fz] = momentum.0;
    let moment = rotation.mul_transpose_vec3(DVec3::new(mx, my, mz));
    let column = [fx, fy, fz, moment.x, moment.y, moment.z];
    let (block, data) = out.block_mut(out.block_of(k));
    let (n, first, k) = (block.size, first - block.start, k - block.start);
    data[k * n + first..][..6].copy_from_slice(&column);
    for (row, x) in data[first * n..].chunks_mut(n).zip(column) {
        row[k] = x;
    }
}

/// The 6 × 6 block of a free joint, velocities in world axes, angular velocities in the body's:
/// `[m 1, −[R m c]× R; …, I_o]`, in which only the coupling depends on the configuration.
/// - `first_moment`: world axes; `rotational`: about the origin, body axes
fn free_block(
    k: usize,
    m: f64,
    first_moment: DVec3,
    rotational: DMat3,
    kinematics: &Kinematics,
    out: &mut BlockDiagonal,
) {
    let (block, data) = out.block_mut(out.block_of(k));
    let (n, k) = (block.size, k - block.start);
    let axes = &kinematics.dof_angular[block.start + k + 3..block.start + k + 6];
    // Row a of −[R m c]× R transposed: how the linear momentum changes with the rate about axis a of the body.
    let coupling: [[f64; 3]; 3] = std::array::from_fn(|a| axes[a].cross(first_moment).to_array());
    for (a, row) in data[k * n..].chunks_mut(n).take(6).enumerate() {
        let row = &mut row[k..k + 6];
        if a < 3 {
            row[..3].fill(0.0);
            row[a] = m;
            (0..3).for_each(|b| row[3 + b] = coupling[b][a]);
        } else {
            row[..3].copy_from_slice(&coupling[a - 3]);
            // The upper triangle of both halves: a product may be symmetric to rounding only.
            (0..3).for_each(|b| row[3 + b] = rotational.col(b.max(a - 3))[b.min(a - 3)]);
        }
    }
}
