//! A warm solve with the circular cone allocates nothing once the buffers have grown to the problem.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use signorini_contact::{ConeSolution, ConeStatus, ConeWarmStart};
use signorini_laws::CircularConeSolver;
use signorini_testkit::{Motion, Parameters, Random, families};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting the calls of each thread.
struct Counting;

fn count() {
    ALLOCATIONS.with(|allocations| allocations.set(allocations.get() + 1));
}

#[allow(unsafe_code)]
// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
    for (allocations, steps) in &mut rounds {
        let before = ALLOCATIONS.with(Cell::get);
        for (problem, start) in problems.iter().zip(&starts) {
            solver.solve_into(problem, Some(start), &mut solution);
            assert_eq!((&solution.status, solution.report.polygon_solves), (&ConeStatus::Solved, 0));
            *steps += solution.report.newton_iterations;
        }
        *allocations = ALLOCATIONS.with(Cell::get) - before;
    }
    assert!(rounds[0].0 > 0, "the counter counts");
    assert_eq!(rounds[1].0, 0);
    assert!(rounds[1].1 > 0, "Newton's method had nothing to do");
}
