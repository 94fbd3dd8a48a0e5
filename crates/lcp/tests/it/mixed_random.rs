//! Mixed problems whose free block is singular, in units of all sizes: statuses against the search through all cases, and what a
//! status claims against the data.

use signorini_lcp::{
    Enumeration, Existence, Farkas, Lemke, Matrix, MixedLcp, Ray, Scaling, Status, exclude, solve_mixed,
};

use crate::support::{Random, inner};

/// A problem of which the free block has so much rank and its complementary part is monotone by turns, in the units that `exponent` draws.
fn random_problem(random: &mut Random, seed: u64) -> MixedLcp {
    let (free, pairs) = (1 + random.below(3), 2 + random.below(3));
    let (n, rank) = (free + pairs, random.below(free + 1));
    let is_skew = seed.is_multiple_of(2);
    let mut A = random.matrix(n, n);
    for i in 0..n {
        for j in 0..n {
            match (i < free, j < free) {
                (true, true) => A[(i, j)] = 0.0,
                (false, true) if is_skew => A[(i, j)] = -A[(j, i)],
                (false, false) if is_skew => A[(i, j)] = if i == j { A[(i, j)].abs() } else { 0.0 },
                _ => {}
            }
        }
    }
    for k in 0..rank {
        A[(k, k)] = 0.5 + random.signed().abs();
    }
    let b = random.vector(n);
    // Rows and variables in places of their own, so that free ones stand among the others.
    let mut order: Vec<usize> = (0..n).collect();
    (1..n).rev().for_each(|k| order.swap(k, random.below(k + 1)));
    let mut unit = || 2.0_f64.powi(random.below(21) as i32 - 10);
    let (rows, columns): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (unit(), unit())).unzip();
    let A = Matrix::from_fn(n, n, |i, j| rows[i] * A[(order[i], order[j])] * columns[j]);
    let b = (0..n).map(|i| rows[i] * b[order[i]]).collect();
    let scaling = Scaling::new(columns.iter().map(|c| 1.0 / c).collect(), rows.iter().map(|r| 1.0 / r).collect());
    MixedLcp::with_scaling(A, b, order.iter().map(|k| *k < free).collect(), scaling.unwrap()).unwrap()
}

/// `y` is none of a sign on free rows, `Aᵀy = 0` in free columns.
fn assert_proof(problem: &MixedLcp, farkas: &Farkas, name: &str) {
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    let n = problem.len();
    let sum: f64 = (0..n).map(|i| (farkas.y[i] / t[i]).abs()).sum();
    for j in 0..n {
        let column: f64 = (0..n).map(|i| problem.A()[(i, j)] * farkas.y[i]).sum::<f64>() / s[j];
        let is_allowed = if problem.free()[j] { column.abs() <= 1e-9 * sum } else { column <= 1e-9 * sum };
        assert!(is_allowed, "{name}: column {j} of the proof, {column:e} of {sum:e}");
        assert!(problem.free()[j] || farkas.y[j] >= -1e-9 * t[j] * sum, "{name}: multiplier {j}");
    }
    assert!(inner(problem.b(), &farkas.y) < 0.0, "{name}: right-hand side of the proof");
}

/// Without a covering variable a ray is a solution of the homogeneous problem.
fn assert_ray(problem: &MixedLcp, ray: &Ray, name: &str) {
    for i in 0..problem.len() {
        let row = problem.A().row(i);
        let terms: f64 = row.iter().zip(&ray.z).map(|(a, z)| (a * z).abs()).sum();
        let rest = ray.w[i] - inner(row, &ray.z);
        assert!(ray.z0 > 0.0 || rest.abs() <= 1e-9 * terms.max(ray.w[i]), "{name}: row {i} is off by {rest:e}");
        if problem.free()[i] {
            assert_eq!(ray.w[i], 0.0, "{name}: free row {i}");
        } else {
            assert!(ray.z[i] >= 0.0 && ray.w[i] >= 0.0 && ray.z[i].min(ray.w[i]) == 0.0, "{name}: pair {i}");
        }
    }
    let support: Vec<usize> = (0..problem.len()).filter(|&i| ray.z[i] != 0.0).collect();
    assert_eq!(support, ray.support, "{name}");
}

#[test]
fn statuses_of_mixed_problems_are_those_of_all_cases() {
    let (mut solved, mut none, mut proved, mut rays, mut singular) = (0, 0, 0, 0, 0);
    for seed in 0..1000 {
        let problem = random_problem(&mut Random(42_000 + seed), seed);
        let truth = exclude(&problem, 10_000);
        assert_ne!(truth, Existence::Undecided, "seed {seed}");
        let has_solution = matches!(truth, Existence::Solved(_));
        for (method, complete) in
            [(&mut Enumeration::default() as &mut dyn signorini_lcp::Method, true), (&mut Lemke::default(), false)]
        {
            let solution = solve_mixed(&problem, method, None);
            let name = format!("seed {seed}, complete: {complete}");
            let z = &solution.z;
            for i in 0..problem.len() {
                let w = inner(problem.A().row(i), z) + problem.b()[i];
                assert!(
                    (w - solution.w[i]).abs()
                        <= 1e-12 * (w.abs() + problem.b()[i].abs() + 1.0 / problem.scaling().w()[i]),
                    "{name}"
                );
            }
            match &solution.status {
                Status::Solved => {
                    assert!(has_solution && problem.residual(z).within(1e-9), "{name}");
                    // Its basis leads to it at once.
                    let again = solve_mixed(&problem, &mut Lemke::default(), Some(&solution.basis));
                    assert!(again.status.is_solved() && again.iterations == 0, "{name}: {again:?}");
                    solved += 1;
                }
                Status::NoSolution => {
                    assert!(!has_solution, "{name}");
                    none += 1;
                }
                Status::Infeasible(farkas) => {
                    assert_proof(&problem, farkas, &name);
                    proved += 1;
                }
                Status::Ray(ray) => {
                    assert_ray(&problem, ray, &name);
                    rays += 1;
                }
                Status::Inconsistent { row } => {
                    assert!(!has_solution && problem.free()[*row], "{name}");
                    none += 1;
                }
                Status::Singular => singular += 1,
                // Lemke's method may come out at a basis that is nearly singular.
                Status::Inaccurate if !complete => singular += 1,
                other => panic!("{name}: {other:?}"),
            }
        }
    }
    println!("{solved} solved, {none} without solution, {proved} infeasible, {rays} rays, {singular} singular");
    assert!(
        solved > 500 && none > 50 && proved > 50 && rays > 20 && singular < 20,
        "{solved} {none} {proved} {rays} {singular}"
    );
}
