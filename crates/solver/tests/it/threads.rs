//! Islands on one thread and on several.

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, WarmStart};
use signorini_multibody::BlockDiagonal;
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::{Family, Gap, Parameters, Random};

/// Problems side by side: one problem whose islands are theirs.
fn beside_each_other(problems: &[ContactProblem]) -> ContactProblem {
    let nv: usize = problems.iter().map(ContactProblem::nv).sum();
    let (mut mass, mut free_velocity, mut start) = (vec![0.0; nv * nv], Vec::new(), 0);
    for problem in problems {
        for (k, row) in problem.mass.to_dense().chunks_exact(problem.nv()).enumerate() {
            mass[(start + k) * nv + start..][..row.len()].copy_from_slice(row);
        }
        free_velocity.extend_from_slice(&problem.free_velocity);
        start += problem.nv();
    }
    let mass = BlockDiagonal::from_dense(nv, &mass).unwrap();
    let mut all = ContactProblem::new(mass, free_velocity, problems[0].timestep).unwrap();
    let mut start = 0;
    for problem in problems {
        for i in 0..problem.contact_count() {
            let (columns, entries) = problem.jacobian.group(i);
            let columns = columns.iter().map(|c| c + start).zip(entries.iter().copied());
            let directions = problem.directions_of(i).to_vec();
            let polygon = FrictionPolygon::from_directions(directions).unwrap();
            // Gaps count divided by the time step.
            let gap = problem.gap[i] * all.timestep / problem.timestep;
            all.push_contact(columns, gap, problem.friction[i], &polygon);
        }
        start += problem.nv() as u32;
    }
    all
}

/// Islands of all families and sizes, several hundred contacts in all.
fn many_islands(seed: u64) -> ContactProblem {
    let mut random = Random::new(seed);
    let problems: Vec<_> = (0..40)
        .map(|k| {
            let parameters = Parameters { gap: Gap::Positive, ..Parameters::random(&mut random) };
            Family::ALL[k % Family::ALL.len()].small(&mut random, &parameters)
        })
        .collect();
    beside_each_other(&problems)
}

fn solver(threads: usize) -> ContactSolver {
    ContactSolver::new(SolverSettings::default().with_threads(threads)).unwrap()
}

/// Everything in a solution, bit by bit.
fn bits(solution: &ContactSolution) -> (Vec<u64>, String) {
    let numbers = [&solution.velocity, &solution.lambda_n, &solution.alpha, &solution.beta, &solution.bilateral];
    let numbers = numbers.into_iter().flatten().chain(solution.impulse.iter().flatten());
    let words = format!("{:?} {:?} {:?}", solution.status, solution.report, solution.modes);
    (numbers.map(|x| x.to_bits()).collect(), words)
}

/// Cold, from the solution, and from that of a problem that is a little different.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for seed in 0..6 {
        let problem = many_islands(seed);
        let mut moved = problem.clone();
        moved.free_velocity.iter_mut().for_each(|v| *v *= 1.03);
        let solve = |threads| {
            let mut solver = solver(threads);
            let cold = solver.solve(&problem, None);
            let again = solver.solve(&problem, Some(&WarmStart::from_solution(&cold)));
            let warm = solver.solve(&moved, Some(&WarmStart::from_solution(&cold)));
            [cold, again, warm]
        };
        let [alone, several] = [solve(1), solve(2)];
        assert!(alone[0].report.islands >= 30 && problem.contact_count() > 150, "enough for several threads");
        assert!(alone.iter().all(|s| s.certificate.holds(1e-9)), "seed {seed}: {:?}", alone[0].certificate);
        for (one, two) in alone.iter().zip(&several) {
            assert_eq!(bits(one), bits(two), "seed {seed}, 2 threads");
        }
        for threads in [3, 16, 0] {
            let other = solve(threads);
            (0..3).for_each(|k| assert_eq!(bits(&alone[k]), bits(&other[k]), "seed {seed}, {threads} threads"));
        }
    }
}

/// What a solver has solved before leaves no trace in what it solves next.
#[test]
fn a_used_solver_gives_the_bits_of_a_new_one() {
    let mut used = solver(2);
    for seed in 10..14 {
        let problem = many_islands(seed);
        assert_eq!(bits(&used.solve(&problem, None)), bits(&solver(1).solve(&problem, None)), "seed {seed}");
    }
}
