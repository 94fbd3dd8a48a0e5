//! Bilateral rows: closed forms, redundant rows, and rows together with contacts.

use signorini_contact::{ContactProblem, FrictionPolygon, SolveStatus, SparseRows};
use signorini_lcp::Lemke;
use signorini_multibody::BlockDiagonal;
use signorini_solver::{BilateralBasis, ContactSolver, solve_as_lcp};
use signorini_testkit::{Dense, Family, Gap, Parameters, Random, largest_difference};

use signorini_testkit::reference::{Matrices, keep, random_problem, worst_violation};

fn identity(n: usize, factor: f64) -> BlockDiagonal {
    BlockDiagonal::from_dense(n, &Dense::from_fn(n, n, |i, j| if i == j { factor } else { 0.0 }).data)
        .expect("symmetric")
}

/// Bob of mass 2 kg on a massless rod at 30° from the vertical, in the plane: the row of the length is the unit vector along
/// the rod, and the velocity that it leaves is the part of `v^f` across the rod.
#[test]
fn a_pendulum_keeps_the_velocity_across_its_rod() {
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    for violation in [0.0, 1e-3, -1e-3] {
        let free = [1.5, -0.0981];
        let mut problem = ContactProblem::new(identity(2, 2.0), free.to_vec(), 0.01).expect("valid data");
        problem.push_bilateral([(0, [sin]), (1, [-cos])], violation);
        let solution = ContactSolver::default().solve(&problem, None);
        assert_eq!(solution.status, SolveStatus::Solved);
        let across = cos * free[0] + sin * free[1];
        let along = -violation / 0.01;
        let wanted = [cos * across + sin * along, sin * across - cos * along];
        assert!(largest_difference(&solution.velocity, &wanted) < 1e-14, "{:?}", solution.velocity);
        let impulse = 2.0 * (along - (sin * free[0] - cos * free[1]));
        assert!((solution.bilateral[0] - impulse).abs() < 1e-12);
    }
}

/// `v⁺ = v^f − M⁻¹Bᵀ (B M⁻¹ Bᵀ)⁻¹ (B v^f + Θ/Δt)` where the rows are independent.
#[test]
fn bilateral_rows_alone_have_a_closed_form() {
    let mut solver = ContactSolver::default();
    let mut count = 0;
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let nb = 1 + random.below(3);
        let problem = random_problem(&mut random, 0, nb);
        if problem.nv() < nb {
            continue;
        }
        let matrices = Matrices::of(&problem);
        let (delassus, rate) = matrices.condensed();
        let impulses: Vec<f64> = delassus.inverse().apply(&rate).iter().map(|x| -x).collect();
        let wanted = matrices.velocity(&impulses);
        let solution = solver.solve(&problem, None);
        assert_eq!(solution.status, SolveStatus::Solved, "seed {seed}");
        let scale = wanted.iter().fold(1.0, |a: f64, v| a.max(v.abs()));
        let difference = largest_difference(&solution.velocity, &wanted) / scale;
        assert!(difference < 1e-9, "seed {seed}: {difference:e}");
        count += 1;
    }
    assert!(count > 80);
}

#[test]
fn redundant_rows_change_nothing() {
    let mut solver = ContactSolver::default();
    for seed in 0..60 {
        let mut random = Random::new(100 + seed);
        let nc = random.below(3);
        let mut problem = random_problem(&mut random, nc, 0);
        problem.friction.fill(0.0);
        let columns = |factor: f64, r: &mut Random| -> Vec<(u32, [f64; 1])> {
            (0..problem.free_velocity.len() as u32).map(|c| (c, [factor * r.normal()])).collect()
        };
        let row = columns(1.0, &mut random);
        let doubled: Vec<(u32, [f64; 1])> = row.iter().map(|(c, e)| (*c, [-2.0 * e[0]])).collect();
        problem.push_bilateral(row.clone(), 1e-3);
        let once = solver.solve(&problem, None);
        problem.push_bilateral(row, 1e-3);
        problem.push_bilateral(doubled, -2e-3);
        let thrice = solver.solve(&problem, None);
        if once.status != SolveStatus::Solved {
            continue;
        }
        assert_eq!(thrice.status, SolveStatus::Solved, "seed {seed}: {:e}", thrice.certificate.worst());
        assert!(worst_violation(&problem, &thrice) <= 1e-8, "seed {seed}");
        let scale = once.velocity.iter().fold(1.0, |a: f64, v| a.max(v.abs()));
        let difference = largest_difference(&once.velocity, &thrice.velocity) / scale;
        assert!(difference < 1e-8, "seed {seed}: {difference:e}");
    }
}

/// The same row with two different right-hand sides.
#[test]
fn rows_that_contradict_each_other_are_not_solved() {
    let mut problem = ContactProblem::new(identity(3, 1.0), vec![0.0; 3], 0.01).expect("valid data");
    problem.push_bilateral([(0, [1.0]), (2, [1.0])], 1e-3);
    problem.push_bilateral([(0, [1.0]), (2, [1.0])], -1e-3);
    let solution = ContactSolver::default().solve(&problem, None);
    assert_eq!(solution.status, SolveStatus::Infeasible { contacts: vec![] });
}

/// A block of 3 kg on a slide along x that is pressed on the ground: the slide holds y, friction brakes x.
#[test]
fn a_guided_block_brakes_along_its_guide() {
    let mut problem = ContactProblem::new(identity(3, 3.0), vec![2.0, 0.7, -0.5], 0.01).expect("valid data");
    let columns = [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.4, &FrictionPolygon::regular(8, 0.0).expect("even"));
    problem.push_bilateral([(1, [1.0])], 0.0);
    let solution = ContactSolver::default().solve(&problem, None);
    assert_eq!(solution.status, SolveStatus::Solved);
    assert!(largest_difference(&solution.velocity, &[2.0 - 0.4 * 0.5, 0.0, 0.0]) < 1e-13, "{:?}", solution.velocity);
    assert!((solution.lambda_n[0] - 1.5).abs() < 1e-12 && (solution.bilateral[0] + 2.1).abs() < 1e-12);
}

/// Contacts of the families with random bilateral rows between random coordinates.
#[test]
fn contacts_with_bilateral_rows_are_solved_as_lemke_solves_them() {
    let mut solver = ContactSolver::default();
    let (mut solved, mut misses) = ([0; 2], Vec::new());
    for seed in 0..120 {
        let mut random = Random::new(60_000 + seed);
        let gap = random.choice(&[Gap::Zero, Gap::Positive]);
        let parameters = Parameters { gap, mass_ratio: 1.0, ..Parameters::random(&mut random) };
        let family = random.choice(&[Family::Box, Family::Stack, Family::Cluster, Family::Articulated]);
        let mut problem = family.small(&mut random, &parameters);
        for _ in 0..1 + random.below(3) {
            let (a, b) = (random.below(problem.nv()) as u32, random.below(problem.nv()) as u32);
            let mut row = vec![(a.min(b), [random.normal()])];
            row.extend((a != b).then(|| (a.max(b), [random.normal()])));
            problem.push_bilateral(row, 0.0);
        }
        let structured = solver.solve(&problem, None);
        let lemke = solve_as_lcp(&problem, &mut Lemke::default(), 1e-9).expect("finite data");
        for (k, solution) in [&structured, &lemke].into_iter().enumerate() {
            if solution.status == SolveStatus::Solved {
                solved[k] += 1;
                assert!(worst_violation(&problem, solution) <= 1e-8, "seed {seed}, route {k}");
            }
        }
        if lemke.status == SolveStatus::Solved && structured.status != SolveStatus::Solved {
            misses.push((seed, family, structured.status, structured.certificate.worst()));
            keep(&problem, &format!("bilateral_{seed}"));
        }
    }
    println!("of 120: structured {}, Lemke {} solved", solved[0], solved[1]);
    assert!(misses.is_empty(), "Lemke solved, the structured solver did not: {misses:?}");
}

/// Random rows, some of them combinations of others: the rank is that of the independent ones, the smallest change in the
/// metric of M satisfies all consistent rows, and a contradiction names the rows of the combination.
#[test]
fn a_basis_tells_independent_redundant_and_contradicting_rows() {
    let mut basis = BilateralBasis::default();
    for seed in 0..60 {
        let mut random = Random::new(3300 + seed);
        let mut problem = random_problem(&mut random, 0, 0);
        let nv = problem.nv();
        let independent = 1 + random.below(nv.min(4));
        let rows: Vec<Vec<f64>> = (0..independent).map(|_| (0..nv).map(|_| random.normal()).collect()).collect();
        let wanted: Vec<f64> = (0..nv).map(|_| random.normal()).collect();
        let (first, last) = (0, independent - 1);
        let weights = [random.between(0.5, 2.0), if last > first { random.between(0.5, 2.0) } else { 0.0 }];
        let combined = (0..nv).map(|c| weights[0] * rows[first][c] + weights[1] * rows[last][c]).collect();
        for row in rows.iter().chain([&combined]) {
            problem.push_bilateral(row.iter().enumerate().map(|(c, x)| (c as u32, [*x])), 0.0);
        }
        let mut rate: Vec<f64> =
            (0..=independent).map(|k| -problem.bilateral_jacobian.multiply(k, &wanted)[0]).collect();
        basis.factor(&problem.bilateral_jacobian, &problem.mass_factor);
        assert_eq!(basis.rank(), independent, "seed {seed}");
        let mut change = vec![0.0; nv];
        basis.solve_into(&rate, &problem.mass_factor, &mut change);
        for (k, r) in rate.iter().enumerate() {
            let met = problem.bilateral_jacobian.multiply(k, &change)[0];
            assert!((met + r).abs() < 1e-8, "seed {seed}: row {k} gets {met}, wanted {}", -r);
        }
        // Smallest in the metric of M: no longer than the change that the rates were made from.
        let size = |v: &[f64]| {
            let mut momentum = vec![0.0; nv];
            problem.mass.multiply_into(v, &mut momentum);
            v.iter().zip(momentum).map(|(v, p)| v * p).sum::<f64>()
        };
        assert!(size(&change) <= size(&wanted) * (1.0 + 1e-9), "seed {seed}");
        assert!(basis.contradiction(&rate, 1e-6).is_empty(), "seed {seed}");
        rate[independent] += 0.1;
        let mut expected = vec![first, last, independent];
        expected.dedup();
        assert_eq!(basis.contradiction(&rate, 1e-6), expected, "seed {seed}");
    }
}

/// A row that is the sum of two others, a millionth as large and the first of all, which a file of few digits makes: what has digits stays.
#[test]
fn of_rows_that_follow_from_each_other_the_large_ones_stay() {
    let factor = identity(4, 1.0).factor().expect("positive definite");
    let mut basis = BilateralBasis::default();
    for seed in 0..50 {
        let mut random = Random::new(90_000 + seed);
        let large: [f64; 4] = std::array::from_fn(|_| random.normal());
        let small: [f64; 4] = large.map(|x| 1e-6 * x + 1e-15 * random.normal());
        let mut rows = SparseRows::<1>::default();
        let mut push = |row: &[f64], from: usize| rows.push(row.iter().zip(from..).map(|(x, k)| (k as u32, [*x])));
        push(&small, 0);
        push(&large[..2], 0);
        push(&large[2..], 2);
        basis.factor_preferring_large(&rows, &factor);
        let mut stay = basis.independent().to_vec();
        stay.sort_unstable();
        assert_eq!(stay, [1, 2], "seed {seed}");
    }
}

/// A body of 5 kg falls, and with it two limbs on slides across the fall that three rows hold to each other: what these ask for is rounding of the fall, in which they
/// contradict each other. What is more than that is a contradiction.
#[test]
fn rows_of_a_falling_loop_may_contradict_each_other_in_rounding() {
    let mass = Dense::from_fn(3, 3, |i, j| [[5.0, 0.2, 0.1], [0.2, 1.0, 0.0], [0.1, 0.0, 0.5]][i][j]);
    let mass = BlockDiagonal::from_dense(3, &mass.data).expect("symmetric");
    for (off, wanted) in [(1e-18, true), (1e-9, false)] {
        let mut problem = ContactProblem::new(mass.clone(), vec![-0.0981, 3e-17, -1e-17], 0.01).expect("valid data");
        for (factor, violation) in [(1.0, off), (0.7, -off), (0.3, off)] {
            problem.push_bilateral([(1, [factor]), (2, [-factor])], violation);
        }
        let solution = ContactSolver::default().solve(&problem, None);
        assert_eq!(solution.status == SolveStatus::Solved, wanted, "{off:e}: {:?}", solution.certificate);
        assert!((solution.velocity[0] + 0.0981).abs() < 1e-6, "{:?}", solution.velocity);
    }
}
