//! Products with sparse rows against dense ones, for every pattern of columns that is treated apart.

use signorini_contact::{ContactProblem, FrictionPolygon, ProblemError, SparseRows};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::Random;

const NV: usize = 30;

/// Columns of whole bodies, of parts of them, and of both.
fn patterns(random: &mut Random) -> Vec<Vec<u32>> {
    let mut all: Vec<Vec<u32>> = vec![
        Vec::new(),
        (0..6).collect(),
        (7..13).collect(),
        vec![0, 1, 2, 3, 4, 6],
        vec![1, 3, 5, 7, 9, 11],
        (6..18).collect(),
        (0..6).chain(12..18).collect(),
        (0..5).chain(12..19).collect(),
        (3..22).collect(),
    ];
    all.extend((0..40).map(|_| (0..NV as u32).filter(|_| random.below(2) > 0).collect::<Vec<u32>>()));
    all
}

fn assert_near(found: &[f64], wanted: &[f64], columns: &[u32]) {
    assert_eq!(found.len(), wanted.len());
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-13), "{columns:?}: {found:?}, dense {wanted:?}");
}

fn compare<const R: usize>(random: &mut Random) {
    for columns in patterns(random) {
        let mut rows = SparseRows::<R>::default();
        // Rows before and after, which have no part in the products.
        let other: Vec<(u32, [f64; R])> = (0..3).map(|c| (c, [7.0; R])).collect();
        let group: Vec<(u32, [f64; R])> =
            columns.iter().map(|&c| (c, std::array::from_fn(|_| random.normal()))).collect();
        [&other, &group, &other].into_iter().for_each(|group| rows.push(group.iter().copied()));
        let mut dense = [[0.0; NV]; R];
        group.iter().for_each(|(c, e)| (0..R).for_each(|r| dense[r][*c as usize] = e[r]));
        let x: Vec<[f64; 2]> = (0..NV).map(|_| [random.normal(), random.normal()]).collect();
        let [first, second] = [0, 1].map(|k| x.iter().map(|x| x[k]).collect::<Vec<f64>>());
        let times = |x: &[f64]| dense.map(|row| row.iter().zip(x).map(|(e, x)| e * x).sum::<f64>());
        assert_near(&rows.multiply(1, &first), &times(&first), &columns);
        let pairs = rows.multiply_pairs(1, &x);
        assert_near(&pairs.map(|pair| pair[0]), &times(&first), &columns);
        assert_near(&pairs.map(|pair| pair[1]), &times(&second), &columns);
        let (product, terms) = rows.multiply_with_terms(1, &first);
        let sizes = dense.map(|row| row.iter().zip(&first).map(|(e, x)| (e * x).abs()).sum::<f64>());
        assert_near(&product, &times(&first), &columns);
        assert_near(&[terms], &[sizes.into_iter().fold(0.0, f64::max)], &columns);
        let p: [f64; R] = std::array::from_fn(|_| random.normal());
        let (mut y, mut size) = (second.clone(), second.clone());
        rows.add_transposed(1, p, &mut y);
        rows.add_terms_transposed(1, p, &mut size);
        let column = |k: usize| (0..R).map(move |r| dense[r][k] * p[r]);
        let wanted: Vec<f64> = (0..NV).map(|k| second[k] + column(k).sum::<f64>()).collect();
        let sizes: Vec<f64> = (0..NV).map(|k| second[k] + column(k).map(f64::abs).sum::<f64>()).collect();
        assert_near(&y, &wanted, &columns);
        assert_near(&size, &sizes, &columns);
    }
}

#[test]
fn products_are_those_of_dense_rows() {
    let mut random = Random::new(4);
    compare::<1>(&mut random);
    compare::<2>(&mut random);
    compare::<3>(&mut random);
}

/// The contact with an entry that is no number is the one that is named.
#[test]
fn a_row_that_is_no_number_is_found() {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).expect("valid data");
    for i in 0..3 {
        let bad = if i == 1 { f64::NAN } else { 1.0 };
        let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 0.0, bad])];
        problem.push_contact(columns, 0.0, 0.5, &FrictionPolygon::regular(4, 0.0).expect("even"));
    }
    assert!(matches!(problem.jacobian.not_finite(), Some((1, x)) if x.is_nan()), "{:?}", problem.jacobian.not_finite());
    assert!(!matches!(problem.check(), Ok(()) | Err(ProblemError::Directions { .. })));
}
