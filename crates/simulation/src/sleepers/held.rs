//! Trees that begin asleep.
//!
//! A model may let trees stand where it has them, whatever pulls at them, until something touches them or acts on them alone
//! ([`Body::begins_asleep`](signorini_multibody::Body::begins_asleep)). That is asked of the state and input of every step anew, so that a run which is stored and taken
//! up again goes on as it would have: such a tree is held in steps that begin in the reference configuration without velocity. Trees that constraints,
//! tendons or actuators tie together are held together.

use signorini_multibody::{BlockDiagonal, Equality, EqualityKind, Input, Model, State};

use super::trees::{Mover, Trees, visit_movers};
use crate::rest::same_bits;

/// The trees of a model that begin asleep.
#[derive(Clone, Debug, Default)]
pub(super) struct Held {
    /// Sets of trees that are held together.
    sets: Vec<Vec<usize>>,
    /// The configuration in which they are.
    reference: Vec<f64>,
    /// The trees that actuators move.
    is_driven: Vec<bool>,
    /// With what their free motion was found: Δt, controls and activations.
    dt: f64,
    control: Vec<f64>,
    activation: Vec<f64>,
}

impl Held {
    /// - `mass`: a matrix with the blocks of the model's mass matrix
    pub fn new(model: &Model, mass: &BlockDiagonal, trees: &Trees) -> Self {
        let asleep = |tree: usize| begins_asleep(model, trees.dofs(tree).start);
        let mut is_awake: Vec<bool> = (0..trees.len()).map(|tree| !asleep(tree)).collect();
        if !is_awake.contains(&false) {
            return Self::default();
        }
        let mut set_of: Vec<usize> = (0..trees.len()).collect();
        let mut is_driven = vec![false; trees.len()];
        visit_movers(model, |mover, dofs| {
            if matches!(mover, Mover::Actuator) {
                dofs.iter().for_each(|&dof| is_driven[mass.block_of(dof)] = true);
            }
            let tied: Vec<usize> = dofs.iter().map(|&dof| set_of[mass.block_of(dof)]).collect();
            let Some(&first) = tied.iter().min() else { return };
            is_awake[first] |= is_moved(model, mover) || tied.iter().any(|&set| is_awake[set]);
            if tied.iter().any(|set| *set != first) {
                set_of.iter_mut().filter(|set| tied.contains(set)).for_each(|set| *set = first);
            }
        });
        let mut sets = vec![Vec::new(); trees.len()];
        (0..trees.len()).for_each(|tree| sets[set_of[tree]].push(tree));
        sets.retain(|set: &Vec<usize>| set.first().is_some_and(|&first| !is_awake[first]));
        Self { sets, reference: model.reference_configuration(), is_driven, ..Self::default() }
    }

    pub fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// The sets of which all trees may be held and are undisturbed, with their places.
    pub fn ready<'a>(
        &'a self,
        trees: &'a Trees,
        state: &'a State,
        input: &'a Input,
        may_be: impl Fn(usize) -> bool + 'a,
    ) -> impl Iterator<Item = (u64, &'a [usize])> {
        let is_ready = move |&tree: &usize| may_be(tree) && self.is_undisturbed(tree, trees, state, input);
        (0..).zip(self.sets.iter().map(Vec::as_slice)).filter(move |(_, set)| set.iter().all(&is_ready))
    }

    /// Takes note of what free motion was found with.
    pub fn note_free_motion(&mut self, state: &State, input: &Input, dt: f64) {
        self.dt = dt;
        self.control.clone_from(&input.control);
        self.activation.clone_from(&state.activation);
    }

    /// Whether the free motion of a tree is the one that was found last.
    pub fn is_current(&self, tree: usize, state: &State, input: &Input, dt: f64) -> bool {
        let same = || same_bits(&self.control, &input.control) && same_bits(&self.activation, &state.activation);
        self.dt == dt && (!self.is_driven[tree] || same())
    }

    /// Whether a tree is in the reference configuration, without velocity and generalized force of its own.
    pub fn is_undisturbed(&self, tree: usize, trees: &Trees, state: &State, input: &Input) -> bool {
        trees.is_undisturbed(tree, state, input, (&self.reference, &[]))
    }
}

/// Whether the tree whose first degree of freedom this is begins asleep.
fn begins_asleep(model: &Model, dof: usize) -> bool {
    let joint = &model.joints[model.dof_joint[dof].index()];
    model.bodies[joint.body.index()].begins_asleep
}

/// Whether a body that is moved from outside has a part in it.
fn is_moved(model: &Model, mover: Mover) -> bool {
    let Mover::Equality(Equality { kind, .. }) = mover else { return false };
    let (EqualityKind::Connect { body_a, body_b, .. } | EqualityKind::Weld { body_a, body_b, .. }) = *kind else {
        return false;
    };
    [body_a, body_b].into_iter().any(|body| model.hangs_on_mocap(body))
}
