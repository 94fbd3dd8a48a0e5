//! Residuals and outcomes do not depend on the units of the data.

use signorini_lcp::{Lcp, Lemke, Matrix, Method, MethodKind, Scaling, Status, equilibrated};

use crate::support::{Random, gram, monotone, p_matrix, quadratic_program, touching_contacts};

/// The same problem with variable i measured in a unit `z[i]` times smaller and row i in one `w[i]` times smaller.
fn in_other_units(problem: &Lcp, z: &[f64], w: &[f64]) -> Lcp {
    let n = problem.len();
    let A = Matrix::from_fn(n, n, |i, j| w[i] * problem.A()[(i, j)] / z[j]);
    let b = (0..n).map(|i| w[i] * problem.b()[i]).collect();
    // The unit of the residual stays that of the first problem: b is measured there.
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    let scaling = Scaling::new((0..n).map(|i| s[i] / z[i]).collect(), (0..n).map(|i| t[i] / w[i]).collect());
    Lcp::with_scaling(A, b, scaling.unwrap()).unwrap()
}

#[test]
fn mass_and_time_units_do_not_matter() {
    for seed in 0..40 {
        let mut random = Random(5000 + seed);
        let problem = touching_contacts(&mut random, 3, 4, 5, 1);
        let n = problem.len();
        let impulses = n - 3;
        // Mass in other units: impulses × 2¹⁰, W and the friction bound accordingly; speeds as they are.
        let mass = 1024.0;
        let z: Vec<f64> = (0..n).map(|i| if i < impulses { mass } else { 1.0 }).collect();
        let w: Vec<f64> = (0..n).map(|i| if i < impulses { 1.0 } else { mass }).collect();
        let other = in_other_units(&problem, &z, &w);
        let (first, second) = (Lemke::default().solve(&problem, None), Lemke::default().solve(&other, None));
        assert!(first.status.is_solved() && second.status.is_solved(), "seed {seed}");
        assert_eq!(first.basis, second.basis, "seed {seed}");
        assert_eq!(first.residual.value, second.residual.value, "seed {seed}: powers of two are exact");
        let point = random.vector(n);
        let moved: Vec<f64> = (0..n).map(|i| z[i] * point[i]).collect();
        assert_eq!(problem.residual(&point).value, other.residual(&moved).value, "seed {seed}");
    }
}

#[test]
fn one_unit_for_all_rows_cancels_out() {
    for seed in 0..40 {
        let mut random = Random(6000 + seed);
        let n = 6;
        let (A, b) = (random.matrix(n, n), random.vector(n));
        let scaled = Matrix::from_fn(n, n, |i, j| 1e6 * A[(i, j)]);
        let first = Lcp::new(A, b.clone()).unwrap();
        let second = Lcp::new(scaled, b.iter().map(|b| 1e-3 * b).collect()).unwrap();
        // w' = 1e6 A z' + 1e-3 b with z' = 1e-9 z is 1e-3 w.
        let z = random.vector(n);
        let moved: Vec<f64> = z.iter().map(|z| 1e-9 * z).collect();
        let (left, right) = (first.residual(&z).value, second.residual(&moved).value);
        assert!((left - right).abs() <= 1e-12 * left, "seed {seed}: {left} and {right}");
    }
}

#[test]
fn a_point_that_is_not_finite_has_an_infinite_residual() {
    let problem = Lcp::new(Matrix::new(2, 2, vec![1.0, 0.0, 0.0, 1.0]).unwrap(), vec![-1.0, -1.0]).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let residual = problem.residual(&[1.0, bad]);
        assert!(residual.value.is_infinite() && !residual.within(1e300), "{bad}: {residual:?}");
    }
    assert!(problem.residual(&[f64::MAX, f64::MAX]).value > 1.0);
}

/// A status without its numbers.
fn name(status: &Status) -> String {
    format!("{status:?}").chars().take_while(|c| c.is_alphanumeric()).collect()
}

#[test]
fn no_method_depends_on_the_units_of_variables_and_rows() {
    for seed in 0..60 {
        let mut random = Random(60_000 + seed);
        let n = 3 + random.below(5);
        let problem = match seed % 4 {
            0 => Lcp::new(p_matrix(&mut random, n), random.vector(n)).unwrap(),
            1 => Lcp::new(gram(&random.matrix(n, n + 2)), random.vector(n)).unwrap(),
            2 => Lcp::new(monotone(&mut random, n, 2, false), random.vector(n)).unwrap(),
            _ => quadratic_program(&mut random, 3, 3, 3, true),
        };
        let n = problem.len();
        let mut powers = || (0..n).map(|_| 10f64.powi(random.below(13) as i32 - 6)).collect::<Vec<f64>>();
        let (z, w) = (powers(), powers());
        let other = in_other_units(&problem, &z, &w);
        for kind in MethodKind::all() {
            let mut method = kind.build().unwrap();
            let (first, second) = (method.solve(&problem, None), method.solve(&other, None));
            let label = format!("{kind} seed {seed}");
            assert_eq!(name(&first.status), name(&second.status), "{label}: {:?} {:?}", first.status, second.status);
            if first.status.is_solved() {
                let size = first.z.iter().fold(0.0f64, |max, z| max.max(z.abs()));
                for i in 0..n {
                    let back = second.z[i] / z[i];
                    assert!((first.z[i] - back).abs() <= 1e-7 * size, "{label}: z[{i}] {} and {back}", first.z[i]);
                }
            }
        }
    }
}

#[test]
fn the_solution_is_found_in_units_that_nobody_declared() {
    for seed in 0..40 {
        let mut random = Random(61_000 + seed);
        let n = 2 + random.below(6);
        let problem = Lcp::new(gram(&random.matrix(n, n + 2)), random.vector(n)).unwrap();
        let mut powers = || (0..n).map(|_| 10f64.powi(random.below(9) as i32 - 4)).collect::<Vec<f64>>();
        let (z, w) = (powers(), powers());
        let declared = in_other_units(&problem, &z, &w);
        let (A, b) = (declared.A().clone(), declared.b().to_vec());
        let scaling = equilibrated(&A, &b).unwrap();
        let undeclared = Lcp::with_scaling(A, b, scaling).unwrap();
        let reference = Lemke::default().solve(&problem, None);
        assert!(reference.status.is_solved(), "seed {seed}");
        for kind in MethodKind::all() {
            let solution = kind.build().unwrap().solve(&undeclared, None);
            assert!(solution.status.is_solved(), "{kind} seed {seed}: {:?}", solution.status);
            let size = reference.z.iter().fold(0.0f64, |max, z| max.max(z.abs()));
            for i in 0..n {
                let back = solution.z[i] / z[i];
                assert!(
                    (reference.z[i] - back).abs() <= 1e-6 * size,
                    "{kind} seed {seed}: z[{i}] {} and {back}",
                    reference.z[i]
                );
            }
        }
    }
}
