//! A table on four legs: what the contact laws say about the load of each leg, and the choice of least norm. Then what both cost
//! beside the solve, over random problems of several families.
//!
//!     cargo run --release -p signorini-contact --example indeterminate_forces

use std::time::Instant;

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus, WarmStart};
use signorini_laws::{LeastNorm, LeastNormReport, force_distributions};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Parameters, Random, RigidBody, Scene};

fn main() {
    let problem = table();
    let mut solution = ContactSolver::default().solve(&problem, None);
    let set = force_distributions(&problem, &solution).expect("a solved problem");
    LeastNorm::default().apply(&problem, &mut solution, 1e-9);
    println!("20 kg on four legs, {} dimensions of impulses with the same velocity", set.dimension);
    println!("{:>4} {:>22} {:>16}", "leg", "normal impulse, N s", "of least norm");
    for (i, range) in set.normal.iter().enumerate() {
        println!("{i:4} {:10.4} … {:9.4} {:16.4}", range.min, range.max, solution.lambda_n[i]);
    }
    println!(
        "\n{:12} {:>4} {:>10} {:>10} {:>13} {:>14} {:>13} {:>10}",
        "family", "nc", "cold us", "warm us", "least norm us", "factorisations", "all ranges us", "programs"
    );
    for family in [Family::Box, Family::Stack, Family::Pyramid, Family::Cluster, Family::Articulated] {
        costs(family);
    }
}

/// Off-centre, so that the legs are not loaded alike.
fn table() -> ContactProblem {
    let mut scene = Scene::default();
    let body = RigidBody::cuboid(DVec3::new(1.0, 1.0, 0.5), 20.0, DVec3::new(0.1, 0.05, 0.25), DMat3::IDENTITY);
    let body = scene.body(body);
    for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
        scene.contact(None, Some(body), DVec3::new(x, y, 0.0), DVec3::Z, 0.0);
    }
    scene.problem(|_| (0.5, FrictionPolygon::regular(8, 0.0).expect("even")))
}

/// Median microseconds over twenty problems of a family, measured by turns.
fn costs(family: Family) {
    let (mut solver, mut least_norm) = (ContactSolver::default(), LeastNorm::default());
    let mut times: [Vec<f64>; 4] = Default::default();
    let (mut contacts, mut programs, mut factorizations) = (0, 0, 0);
    let mut report = LeastNormReport::default();
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let parameters = Parameters { friction: 0.5, directions: 8, gap: Gap::Zero, ..Parameters::default() };
        let problem = family.small(&mut random, &parameters);
        let mut solution = ContactSolution::default();
        let cold = median(|| solver.solve_into(&problem, None, &mut solution));
        if solution.status != SolveStatus::Solved {
            continue;
        }
        let mut start = WarmStart::default();
        (0..problem.contact_count()).for_each(|i| start.push(&solution, Some(i)));
        let warm = median(|| solver.solve_into(&problem, Some(&start), &mut solution));
        let chosen = median(|| {
            report = least_norm.apply(&problem, &mut solution, 1e-9);
        });
        factorizations += report.factorizations as usize;
        let begin = Instant::now();
        let set = force_distributions(&problem, &solution).expect("a solved problem");
        let ranges = begin.elapsed().as_secs_f64();
        programs += set.linear_programs;
        contacts += problem.contact_count();
        times.iter_mut().zip([cold, warm, chosen, ranges]).for_each(|(all, time)| all.push(1e6 * time));
    }
    let count = times[0].len().max(1);
    let [cold, warm, chosen, ranges] = times.map(|mut all| middle(&mut all));
    println!(
        "{:12} {:4} {cold:10.1} {warm:10.1} {chosen:13.1} {:14} {ranges:13.1} {:10}",
        format!("{family:?}"),
        contacts / count,
        factorizations / count,
        programs / count
    );
}

/// Median seconds of eleven runs.
fn median(mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..11)
        .map(|_| {
            let begin = Instant::now();
            run();
            begin.elapsed().as_secs_f64()
        })
        .collect();
    middle(&mut times)
}

fn middle(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
