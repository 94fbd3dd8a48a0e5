//! Kinematic trees that stand beside others that move.

use crate::mass::BlockDiagonal;
use crate::model::{BodyId, Model};

/// Trees of a model that stand where they stood when kinematics and free motion were computed last, with the same forces: their part of both is what
/// it was, and is left alone by what is told of them. So are bodies that cannot move: they are where [`Kinematics::new`](crate::Kinematics::new) puts them.
#[derive(Clone, Debug, Default)]
pub struct StandingTrees {
    bodies: Vec<bool>,
    dofs: Vec<bool>,
    blocks: Vec<bool>,
    /// A degree of freedom that moves each body.
    moved_by: Vec<Option<usize>>,
}

impl StandingTrees {
    /// No tree stands.
    ///
    /// - `mass`: a matrix with the blocks of the model's mass matrix, each of which is a tree
    pub fn none(model: &Model, mass: &BlockDiagonal) -> Self {
        Self {
            bodies: (0..model.bodies.len() as u32).map(|i| model.is_fixed(BodyId(i))).collect(),
            dofs: vec![false; model.nv],
            blocks: vec![false; mass.blocks().len()],
            moved_by: (0..model.bodies.len() as u32).map(|i| model.dofs_moving(BodyId(i)).next()).collect(),
        }
    }

    /// Takes the trees for standing of which that is said.
    ///
    /// - `mass`: as when this was made; `stands`: told the index of a tree's block
    pub fn set(&mut self, mass: &BlockDiagonal, stands: impl Fn(usize) -> bool) {
        for (b, block) in mass.blocks().iter().enumerate() {
            self.blocks[b] = stands(b);
            self.dofs[block.range()].fill(self.blocks[b]);
        }
        for (body, moved_by) in self.bodies.iter_mut().zip(&self.moved_by) {
            *body = moved_by.map_or(*body, |dof| self.dofs[dof]);
        }
    }
}

/// What a computation leaves alone.
pub(crate) trait Known: Copy {
    /// Whether there may be anything.
    const IS_SOME: bool;

    fn has_body(self, body: usize) -> bool;
    fn has_dof(self, dof: usize) -> bool;
    fn has_block(self, block: usize) -> bool;
}

/// Nothing.
#[derive(Clone, Copy)]
pub(crate) struct Nothing;

impl Known for Nothing {
    const IS_SOME: bool = false;

    fn has_body(self, _: usize) -> bool {
        false
    }

    fn has_dof(self, _: usize) -> bool {
        false
    }

    fn has_block(self, _: usize) -> bool {
        false
    }
}

impl Known for &StandingTrees {
    const IS_SOME: bool = true;

    fn has_body(self, body: usize) -> bool {
        self.bodies[body]
    }

    fn has_dof(self, dof: usize) -> bool {
        self.dofs[dof]
    }

    fn has_block(self, block: usize) -> bool {
        self.blocks[block]
    }
}
