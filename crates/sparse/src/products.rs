//! Products of panels, with each other and with parts of a vector.
//!
//! They are compiled for several widths of vectors, as the [kernels](super::kernels) are, and give the same bits with all.

use pulp::Simd;

use super::kernels::{FREE, LIMB};
use super::panels::{Panel, PanelMut, SUMS, load, load_some, store, store_some};

/// Columns from which a product is taken in vectors.
const FEW_COLUMNS: usize = 4;

/// `C −= Aᵀ B` for `A` of `[inner, rows]`, `B` of `[inner, columns]`, `C` of `[rows, columns]`.
#[inline(always)]
pub(super) fn subtract_product<S: Simd>(
    simd: S,
    mut c: PanelMut,
    a: Panel,
    b: Panel,
    (inner, rows, columns): (usize, usize, usize),
) {
    match (inner, rows) {
        // As many sums as the registers hold.
        (FREE, FREE) if S::F64_LANES >= 8 => subtract_fixed::<S, FREE, FREE, FREE>(simd, &mut c, a, b, columns),
        (FREE, FREE) if S::F64_LANES > 1 => subtract_fixed::<S, FREE, FREE, 3>(simd, &mut c, a, b, columns),
        (LIMB, LIMB) if S::F64_LANES > 1 => subtract_fixed::<S, LIMB, LIMB, 3>(simd, &mut c, a, b, columns),
        (LIMB, FREE) if S::F64_LANES > 1 => subtract_fixed::<S, LIMB, FREE, 3>(simd, &mut c, a, b, columns),
        _ => {
            for r in 0..rows {
                let row = &mut c.data[r * c.stride..][..columns];
                for k in 0..inner {
                    let factor = a.data[k * a.stride + r];
                    row.iter_mut().zip(b.row(k, columns)).for_each(|(c, b)| *c -= factor * b);
                }
            }
        }
    }
}

/// The product for blocks of fixed size, `T` rows at once.
#[inline(always)]
fn subtract_fixed<S: Simd, const I: usize, const R: usize, const T: usize>(
    simd: S,
    c: &mut PanelMut,
    a: Panel,
    b: Panel,
    columns: usize,
) {
    if columns < FEW_COLUMNS {
        return subtract_few_columns::<I, R>(c, a, b, columns);
    }
    let pair = 2 * S::F64_LANES;
    let (mut first, mut left) = (0, columns);
    while left > pair + S::F64_LANES {
        subtract_tiles::<S, 2, I, R, T>(simd, c, a, b, (first, pair));
        (first, left) = (first + pair, left - pair);
    }
    if left > pair {
        subtract_tiles::<S, 3, I, R, T>(simd, c, a, b, (first, left));
    } else if left > S::F64_LANES {
        subtract_tiles::<S, 2, I, R, T>(simd, c, a, b, (first, left));
    } else if left > 0 {
        subtract_tiles::<S, 1, I, R, T>(simd, c, a, b, (first, left));
    }
}

/// The product for so few columns that they fill no vector.
#[inline(always)]
fn subtract_few_columns<const I: usize, const R: usize>(c: &mut PanelMut, a: Panel, b: Panel, columns: usize) {
    for j in 0..columns {
        let mut sums = [0.0; R];
        for r in 0..R {
            sums[r] = c.data[r * c.stride + j];
        }
        for k in 0..I {
            let (factors, entry) = (a.part::<R>(k, 0), b.data[k * b.stride + j]);
            for r in 0..R {
                sums[r] -= factors[r] * entry;
            }
        }
        for r in 0..R {
            c.data[r * c.stride + j] = sums[r];
        }
    }
}

/// All rows of as many columns from `first` on as `V` vectors hold, or not quite as many.
#[inline(always)]
fn subtract_tiles<S: Simd, const V: usize, const I: usize, const R: usize, const T: usize>(
    simd: S,
    c: &mut PanelMut,
    a: Panel,
    b: Panel,
    columns: (usize, usize),
) {
    // Not a loop over a range with steps: that is a call, to what is compiled without vectors.
    subtract_tile::<S, V, I, T>(simd, c, a, b, 0, columns);
    if T < R {
        subtract_tile::<S, V, I, T>(simd, c, a, b, T, columns);
    }
}

/// `T` rows from `row` on and `count` columns from `first` on, summed in registers.
#[inline(always)]
fn subtract_tile<S: Simd, const V: usize, const I: usize, const T: usize>(
    simd: S,
    c: &mut PanelMut,
    a: Panel,
    b: Panel,
    row: usize,
    (first, count): (usize, usize),
) {
    let width = count.min(S::F64_LANES);
    let mut sums = [[simd.splat_f64s(0.0); V]; T];
    for r in 0..T {
        let own = &c.data[(row + r) * c.stride + first..][..count];
        for v in 0..V {
            sums[r][v] = load_some(simd, &own[place::<S, V>(v, count)..][..width]);
        }
    }
    for k in 0..I {
        let (factors, own) = (a.part::<T>(k, row), &b.data[k * b.stride + first..][..count]);
        let mut entries = [simd.splat_f64s(0.0); V];
        for v in 0..V {
            entries[v] = load_some(simd, &own[place::<S, V>(v, count)..][..width]);
        }
        for r in 0..T {
            let factor = simd.splat_f64s(factors[r]);
            for v in 0..V {
                sums[r][v] = simd.sub_f64s(sums[r][v], simd.mul_f64s(factor, entries[v]));
            }
        }
    }
    for r in 0..T {
        let own = &mut c.data[(row + r) * c.stride + first..][..count];
        for v in 0..V {
            store_some(simd, &mut own[place::<S, V>(v, count)..][..width], sums[r][v]);
        }
    }
}

/// Where vector `v` of the `V` that hold `count` columns begins: the last may overlap the one before it, and computes the same there.
#[inline(always)]
fn place<S: Simd, const V: usize>(v: usize, count: usize) -> usize {
    if v + 1 == V { count.max(S::F64_LANES) - S::F64_LANES } else { v * S::F64_LANES }
}

/// `y = Bᵀ x` for a panel `B` of `[x, y]`, whose rows are read as far as `y` is long, some way beyond their end.
#[inline(always)]
pub(super) fn multiply_transposed<S: Simd>(simd: S, y: &mut [[f64; SUMS]], panel: Panel, x: &[f64]) {
    if let Ok(x) = x.try_into() {
        return multiply_transposed_fixed::<S, FREE>(simd, y, panel, x);
    }
    if let Ok(x) = x.try_into() {
        return multiply_transposed_fixed::<S, LIMB>(simd, y, panel, x);
    }
    y.as_flattened_mut().fill(0.0);
    for (k, x) in x.iter().enumerate() {
        let row = panel.chunks(k, y.len());
        y.as_flattened_mut().iter_mut().zip(row.as_flattened()).for_each(|(y, b)| *y += b * x);
    }
}

#[inline(always)]
fn multiply_transposed_fixed<S: Simd, const N: usize>(simd: S, y: &mut [[f64; SUMS]], panel: Panel, x: &[f64; N]) {
    let mut rows: [&[[f64; SUMS]]; N] = [&[]; N];
    for k in 0..N {
        rows[k] = panel.chunks(k, y.len());
    }
    for j in 0..y.len() {
        let mut v = 0;
        while v < SUMS {
            let mut sum = simd.splat_f64s(0.0);
            for k in 0..N {
                let part = load(simd, &rows[k][j][v..v + S::F64_LANES]);
                sum = simd.add_f64s(sum, simd.mul_f64s(part, simd.splat_f64s(x[k])));
            }
            store(simd, &mut y[j][v..v + S::F64_LANES], sum);
            v += S::F64_LANES;
        }
    }
}

/// `y −= B x` for a panel `B` of `[y, x]`. Where `x` is longer than the rows it is zero.
#[inline(always)]
pub(super) fn subtract_multiply<S: Simd>(simd: S, y: &mut [f64], panel: Panel, x: &[[f64; SUMS]]) {
    if let Ok(y) = <&mut [f64; FREE]>::try_from(&mut *y) {
        return subtract_dots(simd, y, panel, x);
    }
    if let Ok(y) = <&mut [f64; LIMB]>::try_from(&mut *y) {
        return subtract_dots(simd, y, panel, x);
    }
    for (k, y) in y.iter_mut().enumerate() {
        let row = Panel { data: &panel.data[k * panel.stride..], stride: 0 };
        subtract_dots(simd, std::array::from_mut(y), row, x);
    }
}

/// The same for a fixed number of rows.
#[inline(always)]
fn subtract_dots<S: Simd, const N: usize>(simd: S, y: &mut [f64; N], panel: Panel, x: &[[f64; SUMS]]) {
    match S::F64_LANES {
        8 => subtract_dots_by::<S, 1, N>(simd, y, panel, x),
        4 => subtract_dots_by::<S, 2, N>(simd, y, panel, x),
        2 => subtract_dots_by::<S, 4, N>(simd, y, panel, x),
        _ => subtract_dots_by::<S, SUMS, N>(simd, y, panel, x),
    }
}

/// The same with the sums of a row in `V` vectors.
#[inline(always)]
fn subtract_dots_by<S: Simd, const V: usize, const N: usize>(
    simd: S,
    y: &mut [f64; N],
    panel: Panel,
    x: &[[f64; SUMS]],
) {
    let lanes = S::F64_LANES;
    let mut rows: [&[[f64; SUMS]]; N] = [&[]; N];
    for k in 0..N {
        rows[k] = panel.chunks(k, x.len());
    }
    let mut sums = [[simd.splat_f64s(0.0); V]; N];
    for j in 0..x.len() {
        for v in 0..V {
            let part = load(simd, &x[j][v * lanes..(v + 1) * lanes]);
            for k in 0..N {
                let row = load(simd, &rows[k][j][v * lanes..(v + 1) * lanes]);
                sums[k][v] = simd.add_f64s(sums[k][v], simd.mul_f64s(row, part));
            }
        }
    }
    for k in 0..N {
        let mut half = V / 2;
        while half > 0 {
            for v in 0..half {
                sums[k][v] = simd.add_f64s(sums[k][v], sums[k][v + half]);
            }
            half /= 2;
        }
        y[k] -= simd.reduce_sum_f64s(sums[k][0]);
    }
}
