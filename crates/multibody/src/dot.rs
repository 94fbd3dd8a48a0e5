//! The inner product that all dense rows share, so that equal rows have equal bits.

/// The scalar product, in four sums so that an addition does not wait for the one before it. They are added in pairs that are
/// neighbours in memory. Near the leaves of a tree rows are short.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    match (a, b) {
        ([], []) => return 0.0,
        ([a], [p]) => return a * p,
        ([a, b], [p, q]) => return a * p + b * q,
        _ => {}
    }
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let (mut even, mut odd) = ([0.0; 2], [0.0; 2]);
    for (a, b) in a.iter().zip(b) {
        for l in 0..2 {
            even[l] += a[l] * b[l];
            odd[l] += a[l + 2] * b[l + 2];
        }
    }
    let sums: [f64; 2] = std::array::from_fn(|l| even[l] + odd[l]);
    let rest = rest_a.iter().zip(rest_b).fold(0.0, |sum, (a, b)| sum + a * b);
    sums[0] + sums[1] + rest
}
