//! Proximal iterations from the iterate.

use super::shared::{Outcome, Shared};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::task::{Look, Task};

pub(super) fn applies(_: &Task, _: &Iterate) -> bool {
    true
}

/// Iterates with the usual weight; at the second look at a large island with a large one that falls: what it lacks are a few modes. A part,
/// which no other stage takes up, has both.
pub(super) fn run(shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let weight = if task.look == Look::Second && task.is_large() {
        ProximalWeight::falling(task.settings)
    } else {
        ProximalWeight::new(task.settings, task.is_large())
    };
    let outcome = shared.iterate(task, iterate, weight);
    if task.look == Look::Part && iterate.residual > task.accept() {
        return shared.iterate(task, iterate, ProximalWeight::falling(task.settings));
    }
    outcome
}
