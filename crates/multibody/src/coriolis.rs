//! Coriolis, centrifugal and gyroscopic forces of trees, linearly implicit.
//!
//! The bias force is `h(q, v) = h(q, 0) + C(q, v) v` with `C(q, v) = ½ ∂h/∂v`, which is linear in `v` and the same the other way round,
//! `C(q, v) w = C(q, w) v`. Taken at both ends of a step,
//!
//! ```text
//! M (v⁺ − v) = Δt (τ − h(q, 0) − C(q, v) v⁺),
//! ```
//!
//! it is linear in `v⁺`, and the same equation read backwards, from `−v⁺` to `−v`. With `v` and `v⁺` as the mean velocities of the steps
//! to `q` and from it, the motion is reversible and of second order: its energy stays within O(Δt) of what it was, and does not drift, where
//! `C(q, v) v` drifts by O(Δt) a second and throws what turns by a radian in a few steps. Bodies that turn freely have a variational
//! integrator of their own ([`free_rotation`](crate::free_rotation)).
//!
//! The matrix `M + Δt C` has entries where the mass matrix has them, but is not symmetric: it is factorised as that is, from the last
//! degree of freedom to the first, without any fill.
//!
//! # Source
//! W. Kahan, *Unconventional numerical methods for trajectory calculations* (1993); E. Celledoni, R. I. McLachlan, B. Owren, G. R. W. Quispel,
//! *Geometric properties of Kahan's method*, J. Phys. A 46 (2013). `∂h/∂v` is that of
//! [`inverse_dynamics_derivatives_into`](crate::derivatives::inverse_dynamics_derivatives_into).

use std::ops::Range;
use std::sync::Arc;

use glamx::glam::{DMat3, DVec3};

use crate::cholesky::BlockCholesky;
use crate::composite::{RigidInertia, momentum};
use crate::dot::dot;
use crate::kinematics::Kinematics;
use crate::layout::{Block, Layout};
use crate::mass::BlockDiagonal;
use crate::math::scalar;
use crate::model::{JointKind, Model};
use crate::motion::MotionDerivatives;
use crate::moving::MovingBodies;
use crate::spatial::SpatialVector;
use crate::standing::Known;

/// A pivot of `M̂ + Δt C` below this part of that of `M̂` is of a tree that turns too fast for Δt: the symmetric part is `M̂ + ½ Δt Ṁ`, of which a half is
/// left where `M`, carried on as it changes, would be gone at the end of the step.
const LEAST_PIVOT: f64 = 0.5;

/// The matrices `Δt C` of trees that turn, and the factors of `M̂ + Δt C`.
#[derive(Clone, Debug)]
pub(crate) struct CoriolisSystem {
    layout: Arc<Layout>,
    trees: Vec<Tree>,
    motion: MotionDerivatives,
    /// Which links have these forces from elsewhere (trees whose degrees of freedom interleave share a block).
    apart: Vec<bool>,
    /// Bodies that can move and the last link that moves each, those of each tree together.
    bodies: Vec<(usize, usize)>,
    /// Of every link with all that hangs on it.
    whole: Vec<(RigidInertia, ByVelocity)>,
    /// How the velocity of what each degree of freedom carries changes with its rate.
    by_rate: Vec<SpatialVector>,
    /// `Δt C`, and the factors.
    matrix: Triangles,
    factor: Triangles,
    inverse_pivot: Vec<f64>,
}

/// Entries `(i, k)` and `(k, i)` of square blocks, for `i` on the way from `k` to the root, both in row `i` and column `k`.
#[derive(Clone, Debug)]
struct Triangles {
    above: Vec<f64>,
    below: Vec<f64>,
}

/// A tree whose mass matrix depends on its configuration.
#[derive(Clone, Debug)]
struct Tree {
    block: usize,
    links: Range<usize>,
    bodies: Range<usize>,
    /// Its degrees of freedom that turn something, or move it where something before them turns.
    turning: Vec<usize>,
    /// Where its entries begin.
    offset: usize,
    pace: Pace,
}

impl Tree {
    fn is_resolved(&self) -> bool {
        self.pace != Pace::Unresolved
    }
}

/// How fast a tree turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pace {
    /// Its forces are those of the beginning of the step to rounding.
    Slow,
    Resolved,
    /// Too fast for Δt.
    Unresolved,
}

impl CoriolisSystem {
    /// Storage for a model.
    ///
    /// - `mass`: a matrix with the blocks of its mass matrix
    /// - `apart`: whether a degree of freedom has these forces from elsewhere, with its whole tree
    pub fn new(model: &Model, mass: &BlockDiagonal, apart: impl Fn(usize) -> bool) -> Self {
        let motion = MotionDerivatives::new(model);
        let (layout, links) = (mass.layout().clone(), &motion.links);
        let moving = MovingBodies::of(model).0;
        let mut parts: Vec<_> = moving.iter().filter_map(|one| Some((one.body, links.of_body[one.body]?))).collect();
        parts.sort_by_key(|part| part.1);
        let turns =
            |k: usize| !apart(k) && !matches!(model.joints[model.dof_joint[k].index()].kind, JointKind::Slide { .. });
        let (mut trees, mut entries) = (Vec::new(), 0);
        for (b, block) in layout.blocks.iter().enumerate().filter(|(_, block)| block.size > 1) {
            let counts = |k| std::iter::successors(Some(k), |&k| model.dof_parent[k]).any(turns);
            let turning: Vec<usize> = block.range().filter(|&k| counts(k)).collect();
            if turning.is_empty() {
                continue;
            }
            let own = links.of_dof[block.start]..links.of_dof[block.range().end - 1] + 1;
            let [first, end] = [own.start, own.end].map(|link| parts.partition_point(|part| part.1 < link));
            trees.push(Tree { block: b, links: own, bodies: first..end, turning, offset: entries, pace: Pace::Slow });
            entries += block.size * block.size;
        }
        let empty = Triangles { above: vec![0.0; entries], below: vec![0.0; entries] };
        Self {
            apart: links.all.iter().map(|link| apart(link.dofs.start)).collect(),
            layout,
            trees,
            bodies: parts,
            whole: vec![(RigidInertia::ZERO, ByVelocity::ZERO); links.all.len()],
            by_rate: vec![SpatialVector::ZERO; model.nv],
            matrix: empty.clone(),
            factor: empty,
            inverse_pivot: vec![0.0; model.nv],
            motion,
        }
    }

    /// `Δt C` of all trees that turn.
    ///
    /// - `placed`: inertias of bodies that can move about their origins, world axes
    /// - `v`: `[nv]`; `dt`: Δt, s
    pub fn set(
        &mut self,
        model: &Model,
        (kinematics, placed): (&Kinematics, &[RigidInertia]),
        v: &[f64],
        dt: f64,
        known: impl Known,
    ) {
        for t in 0..self.trees.len() {
            let tree = &mut self.trees[t];
            let fastest = tree.turning.iter().fold(0.0_f64, |most, &k| most.max(v[k].abs()));
            let slow = known.has_block(tree.block) || fastest * dt < f64::EPSILON;
            tree.pace = if slow { Pace::Slow } else { Pace::Resolved };
            if !slow {
                self.write(t, model, (kinematics, placed), v, dt);
            }
        }
    }

    /// Whether [`advance`](Self::advance) writes the velocity of a block of the mass matrix.
    pub fn has_block(&self, block: usize) -> bool {
        let tree = self.trees.binary_search_by_key(&block, |tree| tree.block);
        tree.is_ok_and(|t| self.trees[t].pace != Pace::Slow)
    }

    /// Number of trees that turn too fast for Δt.
    pub fn unresolved(&self) -> usize {
        self.trees.iter().filter(|tree| tree.pace == Pace::Unresolved).count()
    }

    /// Factorises `M̂ + Δt C`, and writes the velocity at the end of the step of trees that turn: `v + (M̂ + Δt C)⁻¹ r`. Those that turn too fast for
    /// it do not feel these forces at all.
    ///
    /// - `mass`, `mass_factor`: `M̂` and its factor; `impulse`: `r`, `[nv]`, with these forces at the beginning of the step
    pub fn advance(
        &mut self,
        (mass, mass_factor): (&BlockDiagonal, &BlockCholesky),
        impulse: &[f64],
        v: &[f64],
        end: &mut [f64],
    ) {
        for t in 0..self.trees.len() {
            if self.trees[t].pace == Pace::Slow {
                continue;
            }
            let rows = self.block(t).range();
            let pace = if self.factorize(t, mass, mass_factor) { Pace::Resolved } else { Pace::Unresolved };
            self.trees[t].pace = pace;
            end[rows.clone()].copy_from_slice(&impulse[rows.clone()]);
            if pace == Pace::Resolved {
                self.solve_tree(t, &mut end[rows.clone()]);
            } else {
                self.add_product(t, &v[rows.clone()], &mut end[rows.clone()]);
                mass_factor.solve_block_in_place(self.trees[t].block, &mut end[rows.clone()]);
            }
            end[rows.clone()].iter_mut().zip(&v[rows]).for_each(|(end, v)| *end += v);
        }
    }

    /// Whether a tree turns and is resolved.
    pub fn is_turning(&self) -> bool {
        self.trees.iter().any(|tree| tree.pace == Pace::Resolved)
    }

    /// Whether there are trees that could turn, resolved: the slope of these forces by the velocity is none of zero at rest.
    pub fn could_turn(&self) -> bool {
        self.trees.iter().any(Tree::is_resolved)
    }

    /// The degrees of freedom of the trees that turn or could, resolved.
    pub fn turning(&self) -> impl Iterator<Item = usize> + '_ {
        let links = self.trees.iter().filter(|tree| tree.is_resolved()).flat_map(|tree| tree.links.clone());
        links.filter(|&l| !self.apart[l]).flat_map(|l| self.motion.links.all[l].dofs.clone())
    }

    /// Whether a degree of freedom is [one of these](Self::turning).
    pub fn turns(&self, dof: usize) -> bool {
        let link = self.motion.links.of_dof[dof];
        let own = self.trees.iter().find(|tree| tree.links.contains(&link));
        !self.apart[link] && own.is_some_and(Tree::is_resolved)
    }

    /// The degree of freedom of a tree that turns too fast for Δt.
    pub fn first_unresolved(&self) -> Option<usize> {
        let tree = self.trees.iter().find(|tree| tree.pace == Pace::Unresolved)?;
        tree.turning.first().copied()
    }

    /// `x ← x − K y` with `K = Δt C (M̂ + Δt C)⁻¹`, at the trees that turn and are resolved (at others it is zero); `y` is used up.
    pub fn subtract_carried(&self, y: &mut [f64], x: &mut [f64]) {
        for t in (0..self.trees.len()).filter(|&t| self.trees[t].pace == Pace::Resolved) {
            let rows = self.block(t).range();
            self.solve_tree(t, &mut y[rows.clone()]);
            y[rows.clone()].iter_mut().for_each(|y| *y = -*y);
            self.add_product(t, &y[rows.clone()], &mut x[rows]);
        }
    }

    fn block(&self, t: usize) -> Block {
        self.layout.blocks[self.trees[t].block]
    }

    /// `Δt C` of a tree.
    fn write(
        &mut self,
        t: usize,
        model: &Model,
        (kinematics, placed): (&Kinematics, &[RigidInertia]),
        v: &[f64],
        dt: f64,
    ) {
        let Self { layout, trees, motion, apart, bodies, whole, by_rate, matrix, .. } = self;
        let tree = &trees[t];
        let block = layout.blocks[tree.block];
        motion.set_of(model, kinematics, v, tree.links.clone());
        whole[tree.links.clone()].fill((RigidInertia::ZERO, ByVelocity::ZERO));
        for &(body, link) in &bodies[tree.bodies.clone()] {
            whole[link].0.add_at(&placed[body], kinematics.pose[body].position - motion.reference[link]);
        }
        for l in tree.links.clone() {
            let (before, after) = (motion.before[l], motion.after[l]);
            whole[l].1 = ByVelocity::of(&whole[l].0, after, momentum(&whole[l].0, after).linear);
            for k in motion.links.all[l].dofs.clone() {
                by_rate[k] = (before + after).carry_motion(motion.axis[k]);
            }
        }
        let half = 0.5 * dt;
        for l in tree.links.clone().rev().filter(|&l| !apart[l]) {
            let link = &motion.links.all[l];
            let (inertia, by_velocity) = whole[l];
            // A tree's own translation changes no force.
            if link.parent.is_none() && kinematics.dof_angular[link.dofs.start] == DVec3::ZERO {
                continue;
            }
            for k in link.dofs.clone() {
                let axis = motion.axis[k].scaled(half);
                let of_rate = (momentum(&inertia, by_rate[k]) + by_velocity.times(motion.axis[k].angular)).scaled(half);
                let (taken, turn) = (momentum(&inertia, axis), by_velocity.times_transposed(axis));
                let mut next = Some(k);
                while let Some(i) = next {
                    let entry = tree.offset + (i - block.start) * block.size + k - block.start;
                    matrix.above[entry] = motion.axis[i].dot(of_rate);
                    matrix.below[entry] = taken.dot(by_rate[i]) + turn.dot(motion.axis[i].angular);
                    next = layout.previous(i);
                }
            }
            if let Some(parent) = link.parent {
                whole[parent].0.add(&inertia);
                whole[parent].1.add(&by_velocity);
            }
        }
    }

    /// `M̂ + Δt C = A B` with `A` unit upper and `B` lower triangular, `B` stored by columns; whether its pivots are those of a tree that does not
    /// turn too fast.
    fn factorize(&mut self, t: usize, mass: &BlockDiagonal, mass_factor: &BlockCholesky) -> bool {
        let block = self.block(t);
        let Self { layout, trees, matrix, factor: Triangles { above, below }, inverse_pivot, .. } = self;
        let (n, start, offset) = (block.size, block.start, trees[t].offset);
        let own = offset..offset + n * n;
        let (c_above, c_below) = (&matrix.above[own.clone()], &matrix.below[own.clone()]);
        let (above, below, m) = (&mut above[own.clone()], &mut below[own], mass.data_of(&block));
        for k in (0..n).rev() {
            let carried = k + 1..layout.end(start + k) - start;
            let (a_before, a) = above.split_at_mut(k * n);
            let (b_before, b) = below.split_at_mut(k * n);
            let (a, b) = (&a[carried.clone()], &b[carried.clone()]);
            let pivot = m[k * (n + 1)] + c_above[k * (n + 1)] - dot(a, b);
            let part = pivot * mass_factor.inverse_pivot(start + k);
            if part.is_nan() || part < LEAST_PIVOT {
                return false;
            }
            let inverse = pivot.recip();
            inverse_pivot[start + k] = inverse;
            let mut next = layout.previous(start + k);
            while let Some(i) = next {
                let entry = (i - start) * n + k;
                let row = &mut a_before[(i - start) * n..][..n];
                row[k] = (m[entry] + c_above[entry] - dot(&row[carried.clone()], b)) * inverse;
                let column = &mut b_before[(i - start) * n..][..n];
                column[k] = m[entry] + c_below[entry] - dot(a, &column[carried.clone()]);
                next = layout.previous(i);
            }
        }
        true
    }

    /// `x ← (M̂ + Δt C)⁻¹ x` of a tree that is resolved.
    fn solve_tree(&self, t: usize, x: &mut [f64]) {
        let (block, offset) = (self.block(t), self.trees[t].offset);
        let (n, start) = (block.size, block.start);
        let row = |k: usize| offset + k * n + k + 1..offset + k * n + self.layout.end(start + k) - start;
        for k in (0..n).rev() {
            let (head, tail) = x.split_at_mut(k + 1);
            let entries = &self.factor.above[row(k)];
            head[k] -= dot(entries, &tail[..entries.len()]);
        }
        for k in 0..n {
            let (head, tail) = x.split_at_mut(k + 1);
            head[k] *= self.inverse_pivot[start + k];
            let own = head[k];
            tail.iter_mut().zip(&self.factor.below[row(k)]).for_each(|(x, entry)| *x -= entry * own);
        }
    }

    /// `y ← y + Δt C x` of a tree.
    fn add_product(&self, t: usize, x: &[f64], y: &mut [f64]) {
        let (block, offset) = (self.block(t), self.trees[t].offset);
        let (n, start) = (block.size, block.start);
        for k in 0..n {
            let row = offset + k * n;
            y[k] += self.matrix.above[row + k] * x[k];
            for j in k + 1..self.layout.end(start + k) - start {
                y[k] += self.matrix.above[row + j] * x[j];
                y[j] += self.matrix.below[row + j] * x[k];
            }
        }
    }
}

/// How the wrench on bodies changes with a velocity `u = (a, b)` common to all, `I (u × v) + u ×* I v + v ×* I u`: by its rotation alone,
/// as force `2 a × p` with the momentum `p`, and as moment `(2 ω× Θ − tr Θ ω× + 2 (h·w − w hᵀ)) a` with the velocity `(ω, w)`, the first
/// moment `h` and the inertia `Θ`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByVelocity {
    pub moment: DMat3,
    pub momentum: DVec3,
}

impl ByVelocity {
    pub const ZERO: Self = Self { moment: DMat3::ZERO, momentum: DVec3::ZERO };

    #[inline]
    pub fn of(inertia: &RigidInertia, v: SpatialVector, momentum: DVec3) -> Self {
        let (theta, h) = (&inertia.rotational, inertia.first_moment);
        let trace = theta.x_axis.x + theta.y_axis.y + theta.z_axis.z;
        let column = |e: usize| {
            let (axis, own) = (DVec3::AXES[e], theta.col(e));
            v.angular.cross(own * 2.0 - axis * trace) - v.linear * (2.0 * h[e])
        };
        let moment = DMat3::from_cols(column(0), column(1), column(2)) + scalar(2.0 * h.dot(v.linear));
        Self { moment, momentum }
    }

    /// Adds that of other bodies.
    pub fn add(&mut self, other: &Self) {
        self.moment += other.moment;
        self.momentum += other.momentum;
    }

    #[inline]
    pub fn times(&self, a: DVec3) -> SpatialVector {
        SpatialVector { angular: self.moment * a, linear: a.cross(self.momentum) * 2.0 }
    }

    #[inline]
    pub fn times_transposed(&self, wrench_of: SpatialVector) -> DVec3 {
        self.moment.mul_transpose_vec3(wrench_of.angular) + self.momentum.cross(wrench_of.linear) * 2.0
    }
}
