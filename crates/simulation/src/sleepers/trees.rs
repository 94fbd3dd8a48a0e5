//! The kinematic trees of a model, one for each block of its mass matrix, and which of them may sleep.

use std::ops::Range;

use signorini_multibody::{
    BlockDiagonal, BodyId, ContactPoint, Equality, EqualityBlock, Input, Kinematics, LengthRow, Model, SpatialVector,
    State, Transmission, actuator_length_into, equality_block_into, forward_kinematics_into, tendon_length_into,
};

use crate::rest::same_bits;

/// The trees of a model.
#[derive(Clone, Debug)]
pub(crate) struct Trees {
    all: Vec<Tree>,
    /// The tree that moves each body.
    of_body: Vec<Option<u32>>,
}

/// A tree: its degrees of freedom and coordinates.
#[derive(Clone, Debug)]
struct Tree {
    v: Range<usize>,
    q: Range<usize>,
    may_sleep: bool,
}

impl Trees {
    /// - `mass`: a matrix with the blocks of the model's mass matrix
    pub fn new(model: &Model, mass: &BlockDiagonal) -> Self {
        let blocks = mass.blocks().iter();
        // What a mocap body or an adhesive one does to others is not followed.
        let sticks = |transmission: &Transmission| matches!(transmission, Transmission::Body { .. });
        let may_sleep = model.mocap_bodies.is_empty() && !model.actuators.iter().any(|a| sticks(&a.transmission));
        let mut all: Vec<Tree> = blocks.map(|block| Tree { v: block.range(), q: 0..0, may_sleep }).collect();
        for joint in &model.joints {
            let q = &mut all[mass.block_of(joint.v_index)].q;
            let own = joint.q_index..joint.q_index + joint.kind.nq();
            *q = if q.start == q.end { own } else { q.start.min(own.start)..q.end.max(own.end) };
        }
        // Other things than their own state can set these trees in motion.
        visit_movers(model, |_, dofs| dofs.iter().for_each(|&dof| all[mass.block_of(dof)].may_sleep = false));
        let tree = |i: u32| model.dofs_moving(BodyId(i)).next().map(|dof| mass.block_of(dof) as u32);
        Self { all, of_body: (0..model.bodies.len() as u32).map(tree).collect() }
    }

    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// The tree that moves a body.
    pub fn of(&self, body: BodyId) -> Option<usize> {
        self.of_body.get(body.index()).copied().flatten().map(|tree| tree as usize)
    }

    /// The trees of both bodies of a contact point.
    pub fn of_point(&self, point: &ContactPoint) -> impl Iterator<Item = usize> {
        [self.of(point.body_a), self.of(point.body_b)].into_iter().flatten()
    }

    /// Its degrees of freedom.
    pub fn dofs(&self, tree: usize) -> Range<usize> {
        self.all[tree].v.clone()
    }

    /// Whether a tree may sleep, and a step left it as it was, without velocity.
    pub fn stood(&self, tree: usize, state: &State, next: &State) -> bool {
        let Tree { v, q, may_sleep } = &self.all[tree];
        let is_zero = |of: &State| of.v[v.clone()].iter().all(|v| *v == 0.0);
        *may_sleep && is_zero(state) && is_zero(next) && same_bits(&state.q[q.clone()], &next.q[q.clone()])
    }

    /// Its coordinates.
    pub fn coordinates(&self, tree: usize) -> Range<usize> {
        self.all[tree].q.clone()
    }

    /// Whether a tree stands where another state has it, with the same force on it; `known`: that configuration and the forces, none where they are 0.
    pub fn is_undisturbed(&self, tree: usize, state: &State, input: &Input, known: (&[f64], &[f64])) -> bool {
        let Tree { v, q, .. } = &self.all[tree];
        let force = |all: &[f64], k: usize| all.get(k).copied().unwrap_or(0.0);
        state.v[v.clone()].iter().all(|v| *v == 0.0)
            && same_bits(&state.q[q.clone()], &known.0[q.clone()])
            && v.clone().all(|k| force(&input.generalized_force, k) == force(known.1, k))
    }

    /// The trees on which wrenches act.
    pub fn pushed<'a>(&'a self, input: &'a Input) -> impl Iterator<Item = usize> + 'a {
        let acts = |wrench: &SpatialVector| *wrench != SpatialVector::ZERO;
        let bodies = input.wrench.iter().enumerate().filter(move |(_, wrench)| acts(wrench));
        bodies.filter_map(|(body, _)| self.of_body[body].map(|tree| tree as usize))
    }
}

/// What moves trees beside their own state.
#[derive(Clone, Copy)]
pub(super) enum Mover<'a> {
    Actuator,
    Tendon,
    Equality(&'a Equality),
}

/// Visits actuators, tendons and the blocks of equality constraints, with the degrees of freedom that each of them moves.
pub(super) fn visit_movers<'a>(model: &'a Model, mut visit: impl FnMut(Mover<'a>, &[usize])) {
    let mut kinematics = Kinematics::new(model);
    let state = State::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let (mut length, mut block) = (LengthRow::new(model), EqualityBlock::new(model));
    for actuator in &model.actuators {
        actuator_length_into(model, &kinematics, &state.q, actuator, &mut length);
        visit(Mover::Actuator, &length.dofs);
    }
    for tendon in &model.tendons {
        tendon_length_into(model, &kinematics, &state.q, tendon, &mut length);
        visit(Mover::Tendon, &length.dofs);
    }
    for equality in &model.equalities {
        for b in 0..equality.kind.block_count() {
            equality_block_into(model, &kinematics, &state.q, &equality.kind, b, &mut block);
            visit(Mover::Equality(equality), &block.rows.dofs);
        }
    }
}
