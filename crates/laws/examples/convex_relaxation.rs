//! A block pulled along a plane by the contact laws and by Anitescu's convex relaxation of them: how far the relaxation lifts it,
//! and what its answer leaves of the laws. Then what both cost from a cold start, over random problems of several families.
//!
//!     cargo run --release -p signorini-contact --example convex_relaxation

use std::time::Instant;

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon};
use signorini_laws::{ConvexRelaxation, RelaxedSolution};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random};

const TIMESTEP: f64 = 0.01;
const FRICTION: f64 = 0.5;
/// Pull, m/s².
const PULL: f64 = 20.0;

/// Height and velocity (along the plane, upwards) of a block of 2 kg.
#[derive(Clone, Copy, Default)]
struct Block {
    height: f64,
    velocity: [f64; 2],
}

impl Block {
    fn problem(self) -> ContactProblem {
        let mass = BlockDiagonal::from_dense(2, &[2.0, 0.0, 0.0, 2.0]).expect("symmetric");
        let free = vec![self.velocity[0] + PULL * TIMESTEP, self.velocity[1] - 9.81 * TIMESTEP];
        let mut problem = ContactProblem::new(mass, free, TIMESTEP).expect("valid data");
        let polygon = FrictionPolygon::regular(2, 0.0).expect("an even number");
        problem.push_contact([(0, [0.0, 1.0, 0.0]), (1, [1.0, 0.0, 0.0])], self.height, FRICTION, &polygon);
        problem
    }

    fn moved(self, velocity: &[f64]) -> Self {
        Self { height: self.height + TIMESTEP * velocity[1], velocity: [velocity[0], velocity[1]] }
    }
}

fn main() {
    let (mut solver, mut relaxation) = (ContactSolver::default(), ConvexRelaxation::default());
    let (mut exact, mut relaxed) = (Block::default(), Block::default());
    println!("{:>6} {:>21} {:>33}", "", "contact laws", "convex relaxation");
    println!(
        "{:>6} {:>10} {:>10} {:>10} {:>10} {:>10} {:>12} {:>12}",
        "t, s", "v, m/s", "gap, mm", "v, m/s", "gap, mm", "mu v dt", "own residual", "of the laws"
    );
    for step in 1..=20 {
        exact = exact.moved(&solver.solve(&exact.problem(), None).velocity);
        let problem = relaxed.problem();
        let solution = relaxation.solve(&problem, 1e-10);
        relaxed = relaxed.moved(&solution.velocity);
        println!(
            "{:6.2} {:10.4} {:10.4} {:10.4} {:10.4} {:10.4} {:12.1e} {:12.1e}",
            f64::from(step) * TIMESTEP,
            exact.velocity[0],
            1e3 * exact.height,
            relaxed.velocity[0],
            1e3 * relaxed.height,
            1e3 * FRICTION * relaxed.velocity[0] * TIMESTEP,
            solution.certificate.worst(),
            solution.contact_laws(&problem).worst()
        );
    }
    println!("\n{:12} {:>10} {:>14} {:>14}", "family", "laws us", "relaxation us", "factorisations");
    for family in [Family::Box, Family::Stack, Family::Pyramid, Family::Cluster, Family::Articulated] {
        costs(family);
    }
}

/// Median microseconds over twenty problems of a family that slide, measured by turns.
fn costs(family: Family) {
    let (mut solver, mut relaxation) = (ContactSolver::default(), ConvexRelaxation::default());
    let (mut exact, mut relaxed) = (ContactSolution::default(), RelaxedSolution::default());
    let (mut times, mut factorizations): ([Vec<f64>; 2], u32) = Default::default();
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let shared = Parameters { gap: Gap::Zero, motion: Motion::Slide, ..Parameters::default() };
        let problem = family.small(&mut random, &Parameters { directions: 8, ..shared });
        for _ in 0..11 {
            let begin = Instant::now();
            solver.solve_into(&problem, None, &mut exact);
            times[0].push(1e6 * begin.elapsed().as_secs_f64());
            let begin = Instant::now();
            relaxation.solve_into(&problem, 1e-10, &mut relaxed);
            times[1].push(1e6 * begin.elapsed().as_secs_f64());
        }
        factorizations += relaxed.report.factorizations;
    }
    let [laws, relaxed] = times.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    println!("{:12} {laws:10.1} {relaxed:14.1} {:14}", format!("{family:?}"), factorizations / 20);
}
