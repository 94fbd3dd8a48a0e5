//! Loops over many numbers with the processor's widest vectors, chosen while the program runs.
//!
//! They are the same arithmetic as without vectors: products and sums are not contracted, and what is reduced are maxima and
//! minima, so that the results have the same bits on every processor.

use pulp::{Arch, Simd, WithSimd};

use super::kernels::add_product;

/// Numbers that are reduced, or added, side by side.
pub(super) const LANES: usize = 8;

/// Compiles a function for several widths of vectors. Everything it calls has to be inlined.
macro_rules! widest {
    ($(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),*) -> $output:ty $body:block) => {
        $(#[$doc])*
        pub(crate) fn $name<'a>($($argument: $type),*) -> $output {
            struct Work<'a> {
                $($argument: $type),*
            }
            impl<'a> pulp::WithSimd for Work<'a> {
                type Output = $output;

                #[inline(always)]
                fn with_simd<S: pulp::Simd>(self, _: S) -> $output {
                    // References know more as arguments than as fields.
                    #[inline(always)]
                    fn run<'a>($($argument: $type),*) -> $output $body
                    run($(self.$argument),*)
                }
            }
            pulp::Arch::new().dispatch(Work { $($argument),* })
        }
    };
}
pub(super) use widest;

/// The larger of two numbers, in one instruction; the first where one is no number.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The largest `value` of a pair of entries, at least 0; `y` has at least the length of `x`.
#[inline(always)]
fn largest_of(x: &[f64], y: &[f64], value: impl Fn(f64, f64) -> f64) -> f64 {
    let (n, y) = (x.len(), &y[..x.len()]);
    let mut lanes = [0.0; LANES];
    let whole = n - n % LANES;
    let mut first = 0;
    while first < whole {
        let (x, y) = (&x[first..first + LANES], &y[first..first + LANES]);
        for k in 0..LANES {
            lanes[k] = larger(lanes[k], value(x[k], y[k]));
        }
        first += LANES;
    }
    let mut all = 0.0;
    for i in whole..n {
        all = larger(all, value(x[i], y[i]));
    }
    for k in 0..LANES {
        all = larger(all, lanes[k]);
    }
    all
}

/// `y += factor · x`.
pub(crate) fn add_scaled_wide(y: &mut [f64], factor: f64, x: &[f64]) {
    Arch::new().dispatch(AddScaled { y, factor, x });
}

struct AddScaled<'a> {
    y: &'a mut [f64],
    factor: f64,
    x: &'a [f64],
}

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        add_scaled_with(simd, self.y, self.factor, self.x);
    }
}

#[inline(always)]
fn add_scaled_with<S: Simd>(simd: S, y: &mut [f64], factor: f64, x: &[f64]) {
    let ((y_whole, y_rest), (x_whole, x_rest)) = (S::as_mut_simd_f64s(y), S::as_simd_f64s(x));
    let factors = simd.splat_f64s(factor);
    for k in 0..y_whole.len().min(x_whole.len()) {
        y_whole[k] = simd.add_f64s(y_whole[k], simd.mul_f64s(factors, x_whole[k]));
    }
    for k in 0..y_rest.len().min(x_rest.len()) {
        y_rest[k] += factor * x_rest[k];
    }
}

/// Applies updates in product form: for each transformed column and its position `p`, `v_p ← v_p / column_p` and the other
/// entries `v_i −= column_i v_p`. `columns`: one after another, of the length of `v`
pub(crate) fn apply_updates(v: &mut [f64], columns: &[f64], positions: &[usize]) {
    Arch::new().dispatch(ApplyUpdates { v, columns, positions });
}

struct ApplyUpdates<'a> {
    v: &'a mut [f64],
    columns: &'a [f64],
    positions: &'a [usize],
}

impl WithSimd for ApplyUpdates<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (n, v) = (self.v.len(), self.v);
        let mut columns = self.columns;
        for &p in self.positions {
            let (column, rest) = columns.split_at(n);
            if v[p] != 0.0 {
                let x = v[p] / column[p];
                add_scaled_with(simd, v, -x, column);
                v[p] = x;
            }
            columns = rest;
        }
    }
}

widest! {
    /// `high + low += column · x` in doubled precision.
    fn add_product_doubled(high: &'a mut [f64], low: &'a mut [f64], column: &'a [f64], x: f64) -> () {
        let (low, column) = (&mut low[..high.len()], &column[..high.len()]);
        for i in 0..column.len() {
            add_product(&mut high[i], &mut low[i], column[i], x);
        }
    }
}

/// What decides which basic variable leaves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// The largest size of an entry of the column.
    pub(crate) largest: f64,
    /// Entries up to this count as zero.
    pub(crate) floor: f64,
    /// The smallest ratio when each value may lie off by the tie's width.
    pub(crate) ratio: f64,
}

/// Harris' bound on the ratios `max(x_i, 0) / a_i` of entries above a floor, and into `near` every `i` whose ratio is at most
/// that, with others beside it.
///
/// - `tie`: width of a tie relative to the largest `x`; `pivot`: the floor relative to the largest `a`
pub(crate) fn ratio_bound(x: &[f64], a: &[f64], tie: f64, pivot: f64, near: &mut Vec<usize>) -> Bound {
    Arch::new().dispatch(RatioBound { x, a, tie, pivot, near })
}

struct RatioBound<'a> {
    x: &'a [f64],
    a: &'a [f64],
    tie: f64,
    pivot: f64,
    near: &'a mut Vec<usize>,
}

impl WithSimd for RatioBound<'_> {
    type Output = Bound;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Bound {
        let Self { x, a, tie, pivot, near } = self;
        // What a vector lacks at the end is zero, which is never above the floor.
        let ((x_whole, x_rest), (a_whole, a_rest)) = (S::as_simd_f64s(x), S::as_simd_f64s(a));
        let (x_rest, a_rest) = (simd.partial_load_f64s(x_rest), simd.partial_load_f64s(a_rest));
        let x_whole = &x_whole[..a_whole.len()];
        let zero = simd.splat_f64s(0.0);
        let (mut largest, mut size) =
            (simd.abs_f64s(a_rest), simd.max_f64s(simd.abs_f64s(x_rest), simd.splat_f64s(1.0)));
        for k in 0..a_whole.len() {
            largest = simd.max_f64s(simd.abs_f64s(a_whole[k]), largest);
            size = simd.max_f64s(simd.abs_f64s(x_whole[k]), size);
        }
        let largest = simd.reduce_max_f64s(largest);
        let smallest = pivot * larger(largest, 1e-3);
        let floor = simd.splat_f64s(smallest);
        let slack = simd.splat_f64s(tie * simd.reduce_max_f64s(size));
        let infinite = simd.splat_f64s(f64::INFINITY);
        let ratio_of = |x, a| {
            let ratio = simd.div_f64s(simd.add_f64s(simd.max_f64s(x, zero), slack), a);
            simd.select_f64s(simd.greater_than_f64s(a, floor), ratio, infinite)
        };
        let mut ratio = ratio_of(x_rest, a_rest);
        for k in 0..a_whole.len() {
            ratio = simd.min_f64s(ratio_of(x_whole[k], a_whole[k]), ratio);
        }
        let ratio = simd.reduce_min_f64s(ratio);
        // Products instead of quotients, with room for their rounding.
        let wide = simd.splat_f64s(ratio * (1.0 + 8.0 * f64::EPSILON));
        let is_near = |x, a| {
            let below = simd.less_than_or_equal_f64s(simd.max_f64s(x, zero), simd.mul_f64s(wide, a));
            simd.first_true_m64s(simd.and_m64s(simd.greater_than_f64s(a, floor), below)) < S::F64_LANES
        };
        near.clear();
        for k in 0..a_whole.len() {
            if is_near(x_whole[k], a_whole[k]) {
                near.extend(k * S::F64_LANES..(k + 1) * S::F64_LANES);
            }
        }
        if is_near(x_rest, a_rest) {
            near.extend(a_whole.len() * S::F64_LANES..a.len());
        }
        Bound { largest, floor: smallest, ratio }
    }
}

widest! {
    /// The largest `|x_i y_i|`, at least 0.
    fn largest_product(x: &'a [f64], y: &'a [f64]) -> f64 {
        largest_of(x, y, |x, y| (x * y).abs())
    }
}

widest! {
    /// Largest sizes of the entries of `R A C` in each row and column, for a square row-major `A` and diagonal `R` and `C`.
    fn largest_entries(A: &'a [f64], rows: &'a [f64], cols: &'a [f64], in_row: &'a mut [f64], in_col: &'a mut [f64]) -> () {
        let n = cols.len();
        in_col.fill(0.0);
        let in_col = &mut in_col[..n];
        for i in 0..n {
            let (scale, row) = (rows[i], &A[i * n..][..n]);
            in_row[i] = largest_of(row, cols, |a, col| (scale * a * col).abs());
            for j in 0..n {
                in_col[j] = larger(in_col[j], (scale * row[j] * cols[j]).abs());
            }
        }
    }
}

widest! {
    /// `(R A C)ᵀ` for a square row-major `A` and diagonal `R` and `C`.
    fn scale_transposed(A: &'a [f64], rows: &'a [f64], cols: &'a [f64], out: &'a mut [f64]) -> () {
        let n = cols.len();
        let whole = n - n % 4;
        for i in (0..whole).step_by(4) {
            let A: [&[f64]; 4] = std::array::from_fn(|k| &A[(i + k) * n..][..n]);
            let scale: [f64; 4] = std::array::from_fn(|k| rows[i + k]);
            for j in 0..n {
                let entries: [f64; 4] = std::array::from_fn(|k| scale[k] * A[k][j] * cols[j]);
                out[j * n + i..][..4].copy_from_slice(&entries);
            }
        }
        for i in whole..n {
            for j in 0..n {
                out[j * n + i] = rows[i] * A[i * n + j] * cols[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of either sign and of several sizes, zero among them.
    fn numbers(n: usize, seed: usize) -> Vec<f64> {
        let fraction = |k: usize| ((k as f64).sin() * 43758.5453).fract();
        let number = |i: usize| fraction(97 * seed + i) * 10f64.powi(i as i32 % 5 - 2);
        (0..n).map(|i| if (i + seed).is_multiple_of(7) { 0.0 } else { number(i + 1) }).collect()
    }

    fn bits(x: &[f64]) -> Vec<u64> {
        x.iter().map(|x| (x + 0.0).to_bits()).collect()
    }

    #[test]
    fn updates_have_the_bits_of_plain_loops() {
        for n in [1, 3, 4, 8, 13, 60, 70] {
            let (columns, positions) = (numbers(3 * n, 5), [0, n / 2, n - 1]);
            let columns: Vec<f64> = columns.iter().map(|x| x + 0.01).collect();
            let (mut v, mut plain) = (numbers(n, 1), numbers(n, 1));
            apply_updates(&mut v, &columns, &positions);
            for (column, p) in columns.chunks(n).zip(positions) {
                let x = plain[p] / column[p];
                for i in 0..n {
                    plain[i] -= x * column[i];
                }
                plain[p] = x;
            }
            assert_eq!(bits(&v), bits(&plain), "n {n}");
        }
    }

    #[test]
    fn the_bound_on_ratios_is_that_of_a_plain_loop() {
        for n in [1, 2, 5, 8, 15, 60, 71] {
            for seed in 0..20 {
                let (x, a, tie, pivot) = (numbers(n, seed), numbers(n, seed + 3), 1e-3, 1e-3);
                let mut near = Vec::new();
                let bound = ratio_bound(&x, &a, tie, pivot, &mut near);
                let largest = a.iter().fold(0.0f64, |max, a| max.max(a.abs()));
                let size = x.iter().fold(1.0f64, |max, x| max.max(x.abs()));
                let floor = pivot * largest.max(1e-3);
                let above: Vec<usize> = (0..n).filter(|&i| a[i] > floor).collect();
                let ratio = above.iter().map(|&i| (x[i].max(0.0) + tie * size) / a[i]).fold(f64::INFINITY, f64::min);
                assert_eq!((bound.largest, bound.floor, bound.ratio), (largest, floor, ratio));
                let wanted = above.into_iter().filter(|&i| x[i].max(0.0) / a[i] <= ratio);
                assert!(wanted.clone().all(|i| near.contains(&i)), "{near:?}");
                assert!(near.is_sorted() && near.iter().all(|&i| i < n));
            }
        }
    }

    #[test]
    fn scaled_entries_are_those_of_plain_loops() {
        for n in [1, 4, 7, 18] {
            let (A, rows, cols) = (numbers(n * n, 2), numbers(n, 3), numbers(n, 4));
            let entry = |i: usize, j: usize| rows[i] * A[i * n + j] * cols[j];
            let mut transposed = vec![0.0; n * n];
            scale_transposed(&A, &rows, &cols, &mut transposed);
            let plain: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n)).collect();
            assert_eq!(bits(&transposed), bits(&plain));
            let (mut in_row, mut in_col) = (vec![0.0; n], vec![0.0; n]);
            largest_entries(&A, &rows, &cols, &mut in_row, &mut in_col);
            let largest = |entries: &mut dyn Iterator<Item = f64>| entries.fold(0.0f64, |max, x| max.max(x.abs()));
            for k in 0..n {
                assert_eq!(in_row[k], largest(&mut (0..n).map(|j| entry(k, j))));
                assert_eq!(in_col[k], largest(&mut (0..n).map(|i| entry(i, k))));
            }
        }
    }
}
