//! Where the solve of an island begins.

use super::given::GivenStart;
use super::island::Island;
use super::island_solver::IslandSolver;

/// Gives the solver of an island its part of a start.
pub(super) fn load(solver: &mut IslandSolver, island: &Island, given: &GivenStart) {
    solver.modes.extend(island.units.iter().map(|&i| given.modes[i as usize]));
    for (impulse, &i) in solver.impulse.iter_mut().zip(&island.units) {
        *impulse = given.impulse[i as usize];
    }
    for (impulse, &i) in solver.bilateral_impulse.iter_mut().zip(&island.bilateral) {
        *impulse = given.bilateral[i as usize];
    }
    island.gather(&given.velocity, &mut solver.velocity);
    solver.knows_velocity = true;
}
