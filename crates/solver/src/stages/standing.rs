//! A guess of the modes of a large island: all of it stands.
//!
//! Where a stack falls as one, the trial impulses at the free velocity say that all contacts but the lowest are open.

use signorini_contact::StageOutcome;
use signorini_contact::projection::Mode;

use super::shared::{Outcome, Shared};
use crate::iterate::Iterate;
use crate::task::Task;

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    iterate.modes.is_empty() && task.is_large()
}

/// Sets the modes to those in which everything sticks, unless the start solves the island.
pub(super) fn run(shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let map = &mut shared.map;
    map.set_weights(task.island, task.settings.proximal_weight);
    let residual = map.evaluate_centre(task, iterate);
    let standing = |i: usize| if task.cones.friction(i) > 0.0 { Mode::Stick } else { Mode::Closed };
    iterate.modes.extend(task.island.units.iter().map(|&i| standing(i as usize)));
    if residual <= task.settings.polish {
        map.guess_modes(task, &mut iterate.modes);
        iterate.residual = residual;
        return StageOutcome::Solved.into();
    }
    StageOutcome::Prepared.into()
}
