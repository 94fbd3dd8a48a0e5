//! A warm solve with the circular cone allocates nothing once the buffers have grown to the problem.

use signorini_contact::{ConeSolution, ConeStatus, ConeWarmStart};
use signorini_laws::CircularConeSolver;
use signorini_testkit::{CountingAllocator, Motion, Parameters, Random, allocations, families};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn warm_solves_allocate_nothing() {
    let parameters = Parameters { friction: 0.3, motion: Motion::Slide, ..Parameters::default() };
    let problems: Vec<_> =
        (0..8).map(|seed| families::stack(&mut Random::new(seed), &parameters, 2 + seed as usize % 3)).collect();
    let (mut solver, mut solution) = (CircularConeSolver::default(), ConeSolution::default());
    let starts: Vec<ConeWarmStart> = problems
        .iter()
        .map(|problem| {
            let mut start = ConeWarmStart::default();
            // A little off the solution, so that Newton's method has work to do.
            solver.solve(problem, None).impulse.iter().for_each(|p| start.push(p.map(|x| 1.001 * x)));
            start
        })
        .collect();
    let mut rounds = [(0, 0); 2];
    for (counted, steps) in &mut rounds {
        *counted = allocations(|| {
            for (problem, start) in problems.iter().zip(&starts) {
                solver.solve_into(problem, Some(start), &mut solution);
                assert_eq!((&solution.status, solution.report.polygon_solves), (&ConeStatus::Solved, 0));
                *steps += solution.report.newton_iterations;
            }
        });
    }
    assert!(rounds[0].0 > 0, "the counter counts");
    assert_eq!(rounds[1].0, 0);
    assert!(rounds[1].1 > 0, "Newton's method had nothing to do");
}
