//! The point of a cone nearest to the target, by the conditions that make it the nearest.

use signorini_lcp::Alternative;

use crate::support::{Random, inner};

/// Columns whose rows have a largest entry of 1, so that the length of what is left is that in one unit, too.
fn columns_of_size_one(random: &mut Random, size: usize, count: usize) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = (0..count).map(|_| random.vector(size)).collect();
    for r in 0..size {
        let largest = columns.iter().fold(0.0f64, |most, column| most.max(column[r].abs()));
        columns.iter_mut().for_each(|column| column[r] /= largest);
    }
    columns
}

/// What is left has no positive product with any column, and none with the combination: the conditions of Karush, Kuhn and Tucker.
#[test]
fn what_is_left_has_no_column_to_follow() {
    let (mut alternative, mut met, mut missed) = (Alternative::default(), 0, 0);
    for seed in 0..400 {
        let mut random = Random(43_000 + seed);
        let (size, count) = (2 + random.below(6), 1 + random.below(9));
        let columns = columns_of_size_one(&mut random, size, count);
        alternative.begin(size);
        columns.iter().for_each(|column| alternative.push().copy_from_slice(column));
        alternative.find();
        let y = alternative.coefficients();
        let mut left = vec![0.0; size];
        left[size - 1] = -1.0;
        for (column, y) in columns.iter().zip(y) {
            assert!(*y >= 0.0, "seed {seed}: {y}");
            left.iter_mut().zip(column).for_each(|(l, x)| *l -= y * x);
        }
        let rounding = 1e-12 * (1.0 + y.iter().sum::<f64>());
        assert!(left.iter().zip(alternative.rest()).all(|(a, b)| (a - b).abs() < rounding), "seed {seed}: {left:?}");
        assert!(columns.iter().all(|column| inner(column, &left) < rounding), "seed {seed}: {left:?}");
        let combination: f64 = columns.iter().zip(y).map(|(column, y)| y * inner(column, &left)).sum();
        assert!(combination.abs() < rounding * rounding.max(1.0) + 1e-10, "seed {seed}: {combination:e}");
        let length = inner(&left, &left).sqrt();
        assert!((alternative.missed() - length).abs() < rounding, "seed {seed}: {length}");
        if length < 1e-9 { met += 1 } else { missed += 1 }
    }
    assert!(met > 50 && missed > 100, "{met} met, {missed} missed");
}
