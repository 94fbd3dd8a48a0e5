//! Residuals and outcomes do not depend on the units of the data.

use signorini_lcp::{Lcp, Lemke, Matrix, Method, Scaling};

use crate::support::{Random, touching_contacts};

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
