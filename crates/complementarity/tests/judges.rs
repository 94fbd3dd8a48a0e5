//! What judges solutions and proofs, written down a second time.
#![allow(non_snake_case)] // matrices keep the letters of the formulas

use signorini_complementarity::{ExcludedCase, Exclusion, Lcp, LcpError, Matrix, MixedLcp, PairCase, Scaling, dot};

/// Numbers between −1 and 1, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, n: usize) -> usize {
        (0.5 * (self.next() + 1.0) * n as f64) as usize
    }

    fn list(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// A problem with free rows, zeros and units of its own.
fn problem(numbers: &mut Numbers, n: usize) -> (MixedLcp, [Vec<f64>; 2]) {
    let A = Matrix::from_fn(n, n, |_, _| if numbers.below(3) == 0 { 0.0 } else { numbers.next() });
    let weights = [0, 1].map(|_| (0..n).map(|_| 2.5 + 2.0 * numbers.next()).collect::<Vec<f64>>());
    let (b, free) = (numbers.list(n), (0..n).map(|_| numbers.below(3) == 0).collect());
    let scaling = Scaling::new(weights[0].clone(), weights[1].clone()).expect("positive weights");
    (MixedLcp::with_scaling(A, b, free, scaling).expect("numbers"), weights)
}

/// `A z + b`, entry by entry.
fn w_of(problem: &MixedLcp, z: &[f64]) -> Vec<f64> {
    let row = |i: usize| (0..z.len()).map(|j| problem.A()[(i, j)] * z[j]).sum::<f64>() + problem.b()[i];
    (0..z.len()).map(row).collect()
}

#[test]
fn the_residual_is_the_largest_of_the_natural_map_in_one_unit() {
    let mut numbers = Numbers(1);
    for _ in 0..500 {
        let n = 1 + numbers.below(12);
        let (problem, [of_z, of_w]) = problem(&mut numbers, n);
        let z = numbers.list(n);
        let w = w_of(&problem, &z);
        let natural = |i: usize| {
            let (z, w) = (of_z[i] * z[i], of_w[i] * w[i]);
            if problem.free()[i] || w < z { w.abs() } else { z.abs() }
        };
        let row = (0..n).max_by(|&i, &j| natural(i).total_cmp(&natural(j))).expect("a row");
        let largest = problem.b().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let found = problem.residual(&z);
        assert!((found.value - natural(row) / largest).abs() <= 1e-13 * found.value.max(1.0), "{found:?}");
        assert_eq!(found.row, Some(row));
        assert!(found.within(found.value) && !found.within(found.value * (1.0 - 1e-12)));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut other = z.clone();
            other[numbers.below(n)] = bad;
            assert_eq!(problem.residual(&other).value, f64::INFINITY);
        }
    }
}

#[test]
fn without_data_zero_is_the_solution_and_nothing_else() {
    let lcp = Lcp::new(Matrix::from_fn(2, 2, |i, j| if i == j { 3.0 } else { 0.0 }), vec![0.0; 2]).expect("numbers");
    assert_eq!((lcp.residual(&[0.0; 2]).value, lcp.residual(&[0.0; 2]).row), (0.0, None));
    assert_eq!((lcp.residual(&[0.0, 1e-300]).value, lcp.residual(&[0.0, 1e-300]).row), (f64::INFINITY, Some(1)));
    let numbers = Lcp::new(Matrix::zeros(1, 1), vec![1.0]).expect("numbers");
    for (z, w) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0)] {
        assert_eq!(numbers.residual_at(&[z], &[w]).value, f64::INFINITY, "{z} {w}");
    }
}

#[test]
fn the_default_scaling_is_the_largest_of_the_diagonal_or_of_all() {
    let of = |data: [f64; 4]| Scaling::from_diagonal(&Matrix::new(2, 2, data.to_vec()).expect("2 by 2"));
    let little = [([0.25, 0.5, 0.0, -0.125], 0.25), ([0.0, 0.5, -0.25, 0.0], 0.5), ([0.0; 4], 1.0)];
    for (data, g) in [([2.0, 9.0, 1.0, -5.0], 5.0), ([0.0, 3.0, -7.0, 0.0], 7.0)].into_iter().chain(little) {
        assert_eq!((of(data).z(), of(data).w()), (&[g; 2][..], &[1.0; 2][..]), "{data:?}");
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Scaling::new(vec![1.0, bad], vec![1.0; 2]).is_err() && Scaling::new(vec![1.0], vec![bad]).is_err());
    }
    assert!(Scaling::new(vec![1.0], vec![1.0; 2]).is_err());
}

/// Farkas' lemma with rounding: the residual says up to which size there is no `z`, and there is none.
#[test]
fn an_excluded_case_has_no_point_below_the_size_that_it_excludes() {
    let mut numbers = Numbers(2);
    let (mut proofs, mut none) = (0, 0);
    for _ in 0..2000 {
        let n = 1 + numbers.below(5);
        let (problem, [_, unit]) = problem(&mut numbers, n);
        let pair = |i: usize| match numbers.below(3) {
            _ if problem.free()[i] => PairCase::Open,
            0 => PairCase::NoZ,
            1 => PairCase::NoW,
            _ => PairCase::Open,
        };
        let pairs: Vec<PairCase> = (0..n).map(pair).collect();
        let equation = |i: usize| problem.free()[i] || pairs[i] == PairCase::NoW;
        let multiplier = |i: usize| {
            let y = [0.0, 1.0, numbers.next()][numbers.below(3)];
            if equation(i) { y } else { f64::abs(y) }
        };
        let multipliers: Vec<f64> = (0..n).map(multiplier).collect();
        let case = ExcludedCase { pairs: pairs.clone(), multipliers: multipliers.clone() };
        let found = case.residual(&problem);
        let shortfall = -(0..n).map(|i| multipliers[i] * problem.b()[i]).sum::<f64>();
        if shortfall <= 0.0 {
            assert_eq!(found, f64::INFINITY);
            none += 1;
            continue;
        }
        let left = |j: usize| {
            let column: Vec<f64> = (0..n).map(|i| multipliers[i] * problem.A()[(i, j)]).collect();
            let (sum, size) = (column.iter().sum::<f64>(), column.iter().map(|x| x.abs()).sum::<f64>());
            let allowed = if problem.free()[j] { sum.abs() } else { sum.max(0.0) };
            let takes_part = |i: &usize| problem.A()[(*i, j)] != 0.0;
            let weight: f64 = (0..n).filter(takes_part).map(|i| multipliers[i].abs() / unit[i]).sum();
            if size == 0.0 || pairs[j] == PairCase::NoZ { 0.0 } else { allowed / size * weight }
        };
        let largest = (0..n).map(|i| (problem.b()[i] * unit[i]).abs()).fold(0.0, f64::max);
        let excluded = shortfall / (0..n).map(left).sum::<f64>();
        let wanted = largest / excluded;
        assert!((found - wanted).abs() <= 1e-12 * wanted, "{found} {wanted}");
        for _ in 0..20 {
            // Terms in the unit of w that all are below the size.
            let most = |j: usize| {
                let terms = (0..n).filter(|&i| multipliers[i] != 0.0).map(|i| (unit[i] * problem.A()[(i, j)]).abs());
                0.999 * excluded.min(1e6) / terms.fold(1e-9, f64::max)
            };
            let z: Vec<f64> = (0..n)
                .map(|j| match pairs[j] {
                    _ if problem.free()[j] => most(j) * numbers.next().signum(),
                    PairCase::NoZ => 0.0,
                    _ => most(j) * numbers.below(2) as f64,
                })
                .collect();
            let w = w_of(&problem, &z);
            let holds = |i: usize| if equation(i) { w[i].abs() < 1e-12 } else { w[i] >= 0.0 };
            assert!(!(0..n).all(holds), "{z:?} is of the case: {w:?}");
        }
        proofs += 1;
    }
    assert!(proofs > 500 && none > 500, "{proofs} {none}");
}

/// The worst of all cases; none where a case is missing, decides a free row, or has multipliers of a wrong sign, size or value.
#[test]
fn an_exclusion_is_as_good_as_its_worst_case() {
    // w = (z₂ − 1, 1): see the two cases of the second pair. The third row is free: w₃ = z₃.
    let A = Matrix::from_fn(3, 3, |i, j| f64::from(u8::from((i, j) == (0, 1) || (i, j) == (2, 2))));
    let problem = MixedLcp::new(A, vec![-1.0, 1.0, 0.0], vec![false, false, true]).expect("numbers");
    let case = |second: PairCase, y: [f64; 3]| ExcludedCase {
        pairs: vec![PairCase::Open, second, PairCase::Open],
        multipliers: y.to_vec(),
    };
    let [no_z, no_w] = [case(PairCase::NoZ, [1.0, 0.0, 0.0]), case(PairCase::NoW, [0.0, -1.0, 0.0])];
    let of = |cases: &[&ExcludedCase]| Exclusion { cases: cases.iter().map(|case| (*case).clone()).collect() };
    let whole = of(&[&no_z, &no_w]);
    assert_eq!((whole.residual(&problem), whole.rows(), whole.is_infeasible()), (0.0, vec![0, 1], false));
    let worse = case(PairCase::NoW, [0.0, -1.0, 1e-3]);
    let own = worse.residual(&problem);
    assert!(own > 0.0 && own < 1.0 && of(&[&no_z, &worse]).residual(&problem) == own);
    assert_eq!(of(&[&no_z, &worse]).rows(), [0, 1, 2]);
    let mut decides_free = no_w.clone();
    decides_free.pairs[2] = PairCase::NoW;
    let mut short = no_w.clone();
    short.multipliers.pop();
    let mut few = no_w.clone();
    few.pairs.pop();
    let (sign, no_number) = (case(PairCase::NoW, [-1e-9, -1.0, 0.0]), case(PairCase::NoW, [f64::NAN, -1.0, 0.0]));
    for wrong in [&decides_free, &short, &few, &sign, &no_number, &case(PairCase::NoZ, [0.0, -1.0, 0.0])] {
        assert_eq!(of(&[&no_z, wrong]).residual(&problem), f64::INFINITY, "{wrong:?}");
    }
    assert_eq!([of(&[]).residual(&problem), of(&[&no_z]).residual(&problem)], [f64::INFINITY; 2]);
    // w = z − 1 has the solution z = 1, which no multiplier of that size excludes: nothing cancels.
    let solvable = MixedLcp::new(Matrix::from_fn(1, 1, |_, _| 1.0), vec![-1.0], vec![false]).expect("numbers");
    let all = ExcludedCase { pairs: vec![PairCase::Open], multipliers: vec![1.0] };
    assert_eq!(of(&[&all]).residual(&solvable), 1.0);
    let open = case(PairCase::Open, [1.0, 0.0, 0.0]);
    assert!(of(&[&open]).is_infeasible() && !of(&[]).is_infeasible() && !of(&[&no_z]).is_infeasible());
}

#[test]
fn products_are_those_of_plain_sums() {
    let mut numbers = Numbers(3);
    for n in 0..40 {
        let (a, b) = (numbers.list(n), numbers.list(n));
        assert!((dot(&a, &b) - (0..n).map(|k| a[k] * b[k]).sum::<f64>()).abs() < 1e-14);
        let A = Matrix::new(3, n, numbers.list(3 * n)).expect("3 by n");
        let mut product = [f64::NAN; 3];
        A.multiply_into(&b, &mut product);
        for (i, found) in product.iter().enumerate() {
            assert!((found - (0..n).map(|j| A.data()[i * n + j] * b[j]).sum::<f64>()).abs() < 1e-14);
            assert!((0..n).all(|j| A.transposed()[(j, i)] == A[(i, j)] && A.row(i)[j] == A[(i, j)]));
        }
    }
}

#[test]
fn entries_that_are_no_numbers_are_named() {
    let mut A = Matrix::from_fn(4, 4, |i, j| (i + j) as f64);
    A[(2, 1)] = f64::INFINITY;
    match Lcp::new(A, vec![0.0; 4]) {
        Err(LcpError::MatrixNotFinite { row: 2, col: 1, value: f64::INFINITY }) => {}
        other => panic!("{other:?}"),
    }
    match Lcp::new(Matrix::zeros(2, 2), vec![0.0, f64::NEG_INFINITY]) {
        Err(LcpError::VectorNotFinite { what: "b", index: 1, .. }) => {}
        other => panic!("{other:?}"),
    }
    assert!(matches!(Lcp::new(Matrix::zeros(2, 3), vec![0.0; 2]), Err(LcpError::NotSquare { rows: 2, cols: 3 })));
    for length in [1, 3] {
        assert!(matches!(Lcp::new(Matrix::zeros(2, 2), vec![0.0; length]), Err(LcpError::Length { expected: 2, .. })));
        let scaling = Scaling::new(vec![1.0; length], vec![1.0; length]).expect("positive");
        assert!(Lcp::with_scaling(Matrix::zeros(2, 2), vec![0.0; 2], scaling.clone()).is_err());
        assert!(MixedLcp::with_scaling(Matrix::zeros(2, 2), vec![0.0; 2], vec![false; 2], scaling).is_err());
        assert!(MixedLcp::new(Matrix::zeros(2, 2), vec![0.0; 2], vec![false; length]).is_err());
    }
}
