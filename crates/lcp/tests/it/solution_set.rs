//! All solutions of small problems: isolated ones, continua, none.

use signorini_lcp::{Enumeration, Lcp, Matrix, Method, Scaling, SolutionSet};

use crate::support::{Random, gram, inner, p_matrix, solves, touching_contacts};

fn set(rows: &[&[f64]], b: &[f64]) -> SolutionSet {
    let problem = Lcp::new(Matrix::new(b.len(), b.len(), rows.concat()).unwrap(), b.to_vec()).unwrap();
    let set = Enumeration::default().solution_set(&problem).unwrap();
    for point in &set.points {
        assert!(point.status.is_solved() && solves(&problem, &point.z, 1e-9), "{:?}", point.z);
    }
    set
}

fn bases(set: &SolutionSet) -> Vec<Vec<usize>> {
    set.continua.iter().map(signorini_lcp::Basis::active).collect()
}

#[test]
fn a_segment_and_its_ends() {
    // z₁ + z₂ = 1: the ends are alone in their bases, the segment belongs to both together.
    let segment = set(&[&[1.0, 1.0], &[1.0, 1.0]], &[-1.0, -1.0]);
    assert_eq!(bases(&segment), [[0, 1]]);
    assert!(segment.points.len() == 3 && !segment.is_finite());
}

#[test]
fn rays_and_half_planes_are_continua() {
    // w = (0, 3): z₁ is arbitrary, z₂ = 0.
    assert_eq!(bases(&set(&[&[0.0, 0.0], &[0.0, 0.0]], &[0.0, 3.0])), [[0]]);
    // w = 0 whatever z is: the quadrant.
    assert_eq!(bases(&set(&[&[0.0, 0.0], &[0.0, 0.0]], &[0.0, 0.0])), [vec![0], vec![1], vec![0, 1]]);
}

#[test]
fn a_singular_basis_may_have_one_solution_only() {
    // With both active z₁ = z₂ + 1 and w₃ = 1 − z₁ ≥ 0 with z₂ ≥ 0: the point (1, 0), alone though A_αα is singular.
    let point = set(&[&[1.0, -1.0, 0.0], &[1.0, -1.0, 0.0], &[-1.0, 0.0, 1.0]], &[-1.0, -1.0, 1.0]);
    assert!(point.points.iter().any(|solution| solution.z == [1.0, 0.0, 0.0]));
    assert!(bases(&point).iter().all(|basis| basis.contains(&2)), "{:?}", point.continua);
}

#[test]
fn a_solution_that_only_a_singular_basis_has_is_found() {
    // Both rows read z₁ − z₂ − 1 with their signs exchanged: w = 0 on the ray z₁ = z₂ + 1, and at its end
    // w₂ = 0 with z₂ = 0.
    let problem = [&[1.0, -1.0][..], &[-1.0, 1.0]];
    let ray = set(&problem, &[-1.0, 1.0]);
    assert_eq!(bases(&ray), [[0, 1]]);
    assert!(set(&problem, &[-1.0, 0.5]).points.is_empty(), "w₁ = −w₂ − 1/2");
    // A piece whose near-least-norm point is not admissible: z₁ − z₂ = 0, and w₃ = z₁ − 2 ≥ 0 pushes it out.
    let pushed = set(&[&[1.0, -1.0, 0.0], &[-1.0, 1.0, 0.0], &[1.0, 0.0, 0.0]], &[0.0, 0.0, -2.0]);
    assert!(!pushed.points.is_empty() && bases(&pushed).contains(&vec![0, 1]), "{:?}", pushed.points);
}

#[test]
fn p_matrices_have_one_solution_and_no_continuum() {
    for seed in 0..60 {
        let mut random = Random(50_000 + seed);
        let n = 1 + random.below(7);
        let problem = Lcp::new(p_matrix(&mut random, n), random.vector(n)).unwrap();
        let set = Enumeration::default().solution_set(&problem).unwrap();
        assert!(set.is_finite() && set.points.len() == 1, "seed {seed}: {} points", set.points.len());
    }
}

#[test]
fn the_solutions_of_a_semidefinite_problem_are_convex() {
    // More than one solution means a continuum (Cottle, Pang, Stone 2009, theorem 3.1.7), and all have the same A z.
    let mut continua = 0;
    for seed in 0..150 {
        let mut random = Random(51_000 + seed);
        let n = 2 + random.below(5);
        let rank = 1 + random.below(n);
        let mut G = random.matrix(n, rank);
        G.data_mut().iter_mut().for_each(|x| *x = (2.0 * *x).round());
        let A = gram(&G);
        // In every other problem A z = −b for some z ≥ 0.
        let z: Vec<f64> = (0..n).map(|_| random.sign().max(0.0)).collect();
        let b = (0..n).map(|i| if seed % 2 == 0 { random.sign() } else { -inner(A.row(i), &z) }).collect();
        let problem = Lcp::new(A, b).unwrap();
        let set = Enumeration::default().solution_set(&problem).unwrap();
        assert!(set.points.len() <= 1 || !set.is_finite(), "seed {seed}: {:?}", set.points);
        for pair in set.points.windows(2) {
            let distance = pair[0].w.iter().zip(&pair[1].w).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
            assert!(distance < 1e-8, "seed {seed}: {distance}");
            let middle: Vec<f64> = pair[0].z.iter().zip(&pair[1].z).map(|(a, b)| 0.5 * (a + b)).collect();
            assert!(solves(&problem, &middle, 1e-9), "seed {seed}");
        }
        continua += usize::from(!set.is_finite());
    }
    assert!((20..140).contains(&continua), "{continua} of 150");
}

#[test]
fn the_first_point_of_the_set_is_what_the_method_returns() {
    for seed in 0..20 {
        let problem = touching_contacts(&mut Random(52_000 + seed), 1, 4, 3, 0);
        let set = Enumeration::default().solution_set(&problem).unwrap();
        assert_eq!(set.points[0], Enumeration::default().solve(&problem, None), "seed {seed}");
    }
}

/// The determinant of a matrix of integers, by Bareiss' elimination without fractions.
fn determinant(mut a: Vec<Vec<i64>>) -> i64 {
    let (n, mut sign, mut last) = (a.len(), 1, 1);
    for k in 0..n {
        let Some(row) = (k..n).find(|&i| a[i][k] != 0) else { return 0 };
        if row != k {
            a.swap(row, k);
            sign = -sign;
        }
        for i in k + 1..n {
            for j in k + 1..n {
                a[i][j] = (a[i][j] * a[k][k] - a[i][k] * a[k][j]) / last;
            }
        }
        last = a[k][k];
    }
    sign * last
}

/// A solution with room around it in a basis is alone in it where the basis is regular, and one of a continuum where it is singular:
/// matrices of integers of either sign and any rank, in units of their own.
#[test]
fn a_basis_has_a_continuum_where_its_matrix_is_singular() {
    let (mut singular, mut regular) = (0, 0);
    for seed in 0..400 {
        let mut random = Random(53_000 + seed);
        let n = 2 + random.below(4);
        let rank = 1 + random.below(n);
        let factor = |random: &mut Random| -> Vec<Vec<i64>> {
            (0..n).map(|_| (0..rank).map(|_| random.below(5) as i64 - 2).collect()).collect()
        };
        let (left, right) = (factor(&mut random), factor(&mut random));
        let entry = |i: usize, j: usize| (0..rank).map(|k| left[i][k] * right[j][k]).sum::<i64>();
        let active: Vec<usize> = (0..n).filter(|_| random.below(3) > 0).collect();
        if active.is_empty() {
            continue;
        }
        let z: Vec<f64> = (0..n).map(|i| if active.contains(&i) { 1.0 + random.signed().abs() } else { 0.0 }).collect();
        let mut unit = || 2.0_f64.powi(random.below(9) as i32 - 4);
        let (rows, columns): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (unit(), unit())).unzip();
        let b: Vec<f64> = (0..n)
            .map(|i| {
                let w = if active.contains(&i) { 0.0 } else { 1.0 };
                rows[i] * (w - (0..n).map(|j| entry(i, j) as f64 * z[j]).sum::<f64>())
            })
            .collect();
        let A = Matrix::from_fn(n, n, |i, j| rows[i] * entry(i, j) as f64 * columns[j]);
        let scaling = Scaling::new(columns.iter().map(|c| 1.0 / c).collect(), rows.iter().map(|r| 1.0 / r).collect());
        let problem = Lcp::with_scaling(A, b, scaling.unwrap()).unwrap();
        let set = Enumeration::default().solution_set(&problem).unwrap();
        assert!(set.points.iter().all(|point| solves(&problem, &point.z, 1e-9)), "seed {seed}");
        let is_singular =
            determinant(active.iter().map(|&i| active.iter().map(|&j| entry(i, j)).collect()).collect()) == 0;
        assert_eq!(bases(&set).contains(&active), is_singular, "seed {seed}: {active:?} of {:?}", set.continua);
        let is_z = |found: &[f64]| (0..n).all(|j| (found[j] * columns[j] - z[j]).abs() < 1e-9);
        let is_found = set.points.iter().any(|point| is_z(&point.z));
        assert!(is_singular || is_found, "seed {seed}: {z:?} is alone in {active:?}");
        *(if is_singular { &mut singular } else { &mut regular }) += 1;
    }
    assert!(singular > 100 && regular > 50, "{singular} singular, {regular} regular");
}
