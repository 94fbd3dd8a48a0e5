//! Symmetric positive definite matrices of a few rows, dense, row by row.

/// `A = L Lᵀ`: the lower half of `a` (`[n, n]`) becomes `L`. Nothing where a pivot is no larger than `floor` times its diagonal entry.
pub(crate) fn factorise(a: &mut [f64], n: usize, floor: f64) -> Option<()> {
    for j in 0..n {
        let diagonal = a[j * n + j];
        let pivot = diagonal - (0..j).map(|k| a[j * n + k] * a[j * n + k]).sum::<f64>();
        if pivot.is_nan() || pivot <= floor * diagonal {
            return None;
        }
        a[j * n + j] = pivot.sqrt();
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            a[i * n + j] = (a[i * n + j] - sum) / a[j * n + j];
        }
    }
    Some(())
}

/// Solves `L Lᵀ x = b`; `x` holds `b` before and the solution after.
pub(crate) fn solve(l: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i * n + i];
    }
}
