//! A problem of one island, for the tests of parts that work on islands.

use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

use crate::interior::Ground;
use crate::islands::Islands;
use crate::iterate::Iterate;
use crate::proximal::ProximalMap;
use crate::settings::SolverSettings;
use crate::task::{Look, Task};

/// Calls `run` on the ground of an interior start without impulses.
pub(crate) fn on_ground_of<T>(problem: &ContactProblem, run: impl FnOnce(&mut Ground) -> T) -> T {
    let (mut cones, mut islands) = (Cones::default(), Islands::default());
    cones.prepare(problem);
    islands.find(problem);
    islands.assemble(problem, |_| true);
    let [island] = islands.all() else { panic!("{} islands", islands.all().len()) };
    let (settings, mut map, mut iterate) = (SolverSettings::default(), ProximalMap::default(), Iterate::default());
    let task = Task {
        problem,
        cones: &cones,
        island,
        settings: &settings,
        look: Look::First,
        is_warm: false,
        is_nearly_solved: false,
    };
    map.begin(&task);
    iterate.clear(problem, island);
    run(&mut Ground { map: &mut map, iterate: &mut iterate, task: &task })
}
