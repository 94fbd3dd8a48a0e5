//! Dense operations on blocks inside row-major panels.
//!
//! All are compiled for several widths of vectors, by being inlined into what [`run_widest`](super::run_widest) runs. Every entry of
//! a result is summed in one order that depends neither on that width nor on which columns are done together, and products are
//! rounded before they are added: all processors give the same bits.

use pulp::Simd;

/// Degrees of freedom of a free body: the block size that almost all problems with many blocks have.
pub(crate) const FREE: usize = 6;
/// Those of a leg of four, or of an arm.
pub(crate) const LIMB: usize = 3;

/// The columns of a panel from one on, and the distance between its rows.
#[derive(Clone, Copy)]
pub(super) struct Panel<'a> {
    pub data: &'a [f64],
    pub stride: usize,
}

impl<'a> Panel<'a> {
    /// The panel from a later column on.
    #[inline(always)]
    pub fn from(self, column: usize) -> Self {
        Self { data: &self.data[column.min(self.data.len())..], stride: self.stride }
    }

    /// `N` entries of a row.
    #[inline(always)]
    fn part<const N: usize>(&self, row: usize, first: usize) -> &'a [f64; N] {
        self.data[row * self.stride + first..].first_chunk().expect("the panel holds the block")
    }

    #[inline(always)]
    fn row(&self, row: usize, length: usize) -> &'a [f64] {
        &self.data[row * self.stride..][..length]
    }
}

/// The same for a panel that is written.
pub(super) struct PanelMut<'a> {
    pub data: &'a mut [f64],
    pub stride: usize,
}

impl PanelMut<'_> {
    #[inline(always)]
    fn part<const N: usize>(&mut self, row: usize, first: usize) -> &mut [f64; N] {
        self.data[row * self.stride + first..].first_chunk_mut().expect("the panel holds the block")
    }
}

/// `C −= Aᵀ B` for `A` of `[inner, rows]`, `B` of `[inner, columns]`, `C` of `[rows, columns]`.
#[inline(always)]
pub(super) fn subtract_product<S: Simd>(
    _simd: S,
    mut c: PanelMut,
    a: Panel,
    b: Panel,
    (inner, rows, columns): (usize, usize, usize),
) {
    match (inner, rows) {
        // As many sums as the registers hold.
        (FREE, FREE) if S::F64_LANES >= 8 => subtract_fixed::<FREE, FREE, FREE>(&mut c, a, b, columns),
        (FREE, FREE) => subtract_fixed::<FREE, FREE, 3>(&mut c, a, b, columns),
        (LIMB, LIMB) => subtract_fixed::<LIMB, LIMB, 3>(&mut c, a, b, columns),
        (LIMB, FREE) => subtract_fixed::<LIMB, FREE, 3>(&mut c, a, b, columns),
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
fn subtract_fixed<const I: usize, const R: usize, const T: usize>(
    c: &mut PanelMut,
    a: Panel,
    b: Panel,
    columns: usize,
) {
    let mut first = 0;
    while first + 12 <= columns {
        (0..R).step_by(T).for_each(|row| subtract_tile::<12, I, T>(c, a, b, row, first));
        first += 12;
    }
    if first + 6 <= columns {
        (0..R).step_by(T).for_each(|row| subtract_tile::<6, I, T>(c, a, b, row, first));
        first += 6;
    }
    if first + 3 <= columns {
        (0..R).step_by(T).for_each(|row| subtract_tile::<3, I, T>(c, a, b, row, first));
        first += 3;
    }
    for first in first..columns {
        (0..R).step_by(T).for_each(|row| subtract_tile::<1, I, T>(c, a, b, row, first));
    }
}

/// `T` rows from `row` on and `W` columns from `first` on, summed in registers.
#[inline(always)]
fn subtract_tile<const W: usize, const I: usize, const T: usize>(
    c: &mut PanelMut,
    a: Panel,
    b: Panel,
    row: usize,
    first: usize,
) {
    let mut sums = [[0.0; W]; T];
    for r in 0..T {
        sums[r] = *c.part(row + r, first);
    }
    for k in 0..I {
        let (factors, entries) = (a.part::<T>(k, row), b.part::<W>(k, first));
        for r in 0..T {
            for j in 0..W {
                sums[r][j] -= factors[r] * entries[j];
            }
        }
    }
    for r in 0..T {
        *c.part(row + r, first) = sums[r];
    }
}

/// `B ← D⁻¹ B` for a block that [`factor_block`] factorised and a panel of its height, after as many columns.
#[inline(always)]
pub(super) fn solve_panel(d: &[f64], swaps: &[u32], panel: &mut [f64], width: usize) {
    if let (Ok(d), Ok(swaps)) = (<&[f64; FREE * FREE]>::try_from(d), <&[u32; FREE]>::try_from(swaps)) {
        return solve_panel_fixed(d, swaps, panel, width);
    }
    if let (Ok(d), Ok(swaps)) = (<&[f64; LIMB * LIMB]>::try_from(d), <&[u32; LIMB]>::try_from(swaps)) {
        return solve_panel_fixed(d, swaps, panel, width);
    }
    let n = swaps.len();
    let subtract = |target: &mut [f64], factor: f64, source: &[f64]| {
        target[n..].iter_mut().zip(&source[n..]).for_each(|(t, s)| *t -= factor * s);
    };
    for (k, &s) in swaps.iter().enumerate() {
        if s as usize != k {
            let (head, tail) = panel.split_at_mut(s as usize * width);
            head[k * width..][..width].swap_with_slice(&mut tail[..width]);
        }
    }
    for i in 1..n {
        let (done, rest) = panel.split_at_mut(i * width);
        for (row, factor) in done.chunks_exact(width).zip(&d[i * n..]) {
            subtract(&mut rest[..width], *factor, row);
        }
    }
    for i in (0..n).rev() {
        let (rest, done) = panel.split_at_mut((i + 1) * width);
        let own = &mut rest[i * width..];
        for (row, factor) in done.chunks_exact(width).zip(&d[i * n + i + 1..]) {
            subtract(own, *factor, row);
        }
        own[n..].iter_mut().for_each(|x| *x *= d[i * n + i]);
    }
}

#[inline(always)]
fn solve_panel_fixed<const N: usize>(d: &[f64], swaps: &[u32; N], panel: &mut [f64], width: usize) {
    let mut order: [usize; N] = std::array::from_fn(|i| i);
    for k in 0..N {
        order.swap(k, swaps[k] as usize);
    }
    let mut panel = PanelMut { data: panel, stride: width };
    let mut first = N;
    while first + 8 <= width {
        solve_strip::<8, N>(d, &order, &mut panel, first);
        first += 8;
    }
    if first + 4 <= width {
        solve_strip::<4, N>(d, &order, &mut panel, first);
        first += 4;
    }
    if first + 2 <= width {
        solve_strip::<2, N>(d, &order, &mut panel, first);
        first += 2;
    }
    for first in first..width {
        solve_strip::<1, N>(d, &order, &mut panel, first);
    }
}

#[inline(always)]
fn solve_strip<const W: usize, const N: usize>(d: &[f64], order: &[usize; N], panel: &mut PanelMut, first: usize) {
    let mut x = [[0.0; W]; N];
    for i in 0..N {
        x[i] = *panel.part(order[i], first);
    }
    for i in 1..N {
        for k in 0..i {
            for j in 0..W {
                x[i][j] -= d[i * N + k] * x[k][j];
            }
        }
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            for j in 0..W {
                x[i][j] -= d[i * N + k] * x[k][j];
            }
        }
        for j in 0..W {
            x[i][j] *= d[i * N + i];
        }
    }
    for i in 0..N {
        *panel.part(i, first) = x[i];
    }
}

/// Copies a few numbers without calling for it.
#[inline(always)]
pub(crate) fn copy_few(target: &mut [f64], source: &[f64]) {
    if let (Ok(target), Ok(source)) = (<&mut [f64; FREE]>::try_from(&mut *target), <&[f64; FREE]>::try_from(source)) {
        *target = *source;
    } else if let (Ok(target), Ok(source)) =
        (<&mut [f64; LIMB]>::try_from(&mut *target), <&[f64; LIMB]>::try_from(source))
    {
        *target = *source;
    } else {
        target.copy_from_slice(source);
    }
}

/// `x −= y` for a few numbers.
#[inline(always)]
pub(super) fn subtract_few(x: &mut [f64], y: &[f64]) {
    if let (Ok(x), Ok(y)) = (<&mut [f64; FREE]>::try_from(&mut *x), <&[f64; FREE]>::try_from(y)) {
        (0..FREE).for_each(|k| x[k] -= y[k]);
    } else if let (Ok(x), Ok(y)) = (<&mut [f64; LIMB]>::try_from(&mut *x), <&[f64; LIMB]>::try_from(y)) {
        (0..LIMB).for_each(|k| x[k] -= y[k]);
    } else {
        x.iter_mut().zip(y).for_each(|(x, y)| *x -= y);
    }
}

/// `y = Bᵀ x` for a panel `B` of `[x, y]`.
#[inline(always)]
pub(super) fn multiply_transposed(y: &mut [f64], panel: &[f64], x: &[f64]) {
    if let Ok(x) = x.try_into() {
        return multiply_transposed_fixed::<FREE>(y, panel, x);
    }
    if let Ok(x) = x.try_into() {
        return multiply_transposed_fixed::<LIMB>(y, panel, x);
    }
    y.fill(0.0);
    for (x, row) in x.iter().zip(panel.chunks_exact(y.len().max(1))) {
        y.iter_mut().zip(row).for_each(|(y, b)| *y += b * x);
    }
}

#[inline(always)]
fn multiply_transposed_fixed<const N: usize>(y: &mut [f64], panel: &[f64], x: &[f64; N]) {
    let columns = y.len();
    let rows: [&[f64]; N] = std::array::from_fn(|k| &panel[k * columns..][..columns]);
    for j in 0..columns {
        let mut sum = rows[0][j] * x[0];
        for k in 1..N {
            sum += rows[k][j] * x[k];
        }
        y[j] = sum;
    }
}

/// `y −= B x` for a panel `B` of `[y, x]`.
#[inline(always)]
pub(super) fn subtract_multiply(y: &mut [f64], panel: Panel, x: &[f64]) {
    if x.is_empty() {
        return;
    }
    if let Ok(y) = <&mut [f64; FREE]>::try_from(&mut *y) {
        let products = dots::<FREE>(panel, x);
        return (0..FREE).for_each(|k| y[k] -= products[k]);
    }
    if let Ok(y) = <&mut [f64; LIMB]>::try_from(&mut *y) {
        let products = dots::<LIMB>(panel, x);
        return (0..LIMB).for_each(|k| y[k] -= products[k]);
    }
    for (k, y) in y.iter_mut().enumerate() {
        *y -= dot(panel.row(k, x.len()), x);
    }
}

/// Scalar products of `N` rows with `x`, each in four sums so that an addition does not wait for the one before it.
#[inline(always)]
fn dots<const N: usize>(rows: Panel, x: &[f64]) -> [f64; N] {
    let rows: [(&[[f64; 4]], &[f64]); N] = std::array::from_fn(|k| rows.row(k, x.len()).as_chunks());
    let (chunks, rest) = x.as_chunks::<4>();
    let mut sums = [[0.0; 4]; N];
    for (j, x) in chunks.iter().enumerate() {
        for k in 0..N {
            for l in 0..4 {
                sums[k][l] += rows[k].0[j][l] * x[l];
            }
        }
    }
    std::array::from_fn(|k| {
        let tail: f64 = rows[k].1.iter().zip(rest).map(|(a, x)| a * x).sum();
        (sums[k][0] + sums[k][1]) + (sums[k][2] + sums[k][3]) + tail
    })
}

#[inline(always)]
fn dot(a: &[f64], x: &[f64]) -> f64 {
    dots::<1>(Panel { data: a, stride: 0 }, x)[0]
}

/// Factorises a square block in place with partial pivoting; `swaps[k]` is the row exchanged with row `k`, and the diagonal gets
/// the reciprocals of the pivots. Returns the smallest pivot relative to the largest entry of the block; 0 means singular.
#[inline(always)]
pub(super) fn factor_block(a: &mut [f64], swaps: &mut [u32]) -> f64 {
    if let (Ok(rows), Ok(swaps)) =
        (<&mut [[f64; FREE]; FREE]>::try_from(a.as_chunks_mut().0), <&mut [u32; FREE]>::try_from(&mut *swaps))
    {
        return factor_fixed(rows, swaps);
    }
    if let (Ok(rows), Ok(swaps)) =
        (<&mut [[f64; LIMB]; LIMB]>::try_from(a.as_chunks_mut().0), <&mut [u32; LIMB]>::try_from(&mut *swaps))
    {
        return factor_fixed(rows, swaps);
    }
    let n = swaps.len();
    let scale = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut smallest = f64::INFINITY;
    for k in 0..n {
        let mut best = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[best * n + k].abs() {
                best = i;
            }
        }
        swaps[k] = best as u32;
        if best != k {
            let (head, tail) = a.split_at_mut(best * n);
            head[k * n..(k + 1) * n].swap_with_slice(&mut tail[..n]);
        }
        let (head, tail) = a.split_at_mut((k + 1) * n);
        let pivot_row = &mut head[k * n..];
        let pivot = pivot_row[k];
        let inverse = 1.0 / pivot;
        smallest = smallest.min(pivot.abs());
        if !inverse.is_finite() {
            return 0.0;
        }
        pivot_row[k] = inverse;
        for row in tail.chunks_exact_mut(n) {
            let factor = row[k] * inverse;
            row[k] = factor;
            if factor != 0.0 {
                row[k + 1..].iter_mut().zip(&pivot_row[k + 1..n]).for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
    if scale.is_finite() { smallest / scale } else { 0.0 }
}

#[inline(always)]
fn factor_fixed<const N: usize>(rows: &mut [[f64; N]; N], swaps: &mut [u32; N]) -> f64 {
    let scale = rows.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let mut smallest = f64::INFINITY;
    for k in 0..N {
        let mut best = k;
        for i in k + 1..N {
            if rows[i][k].abs() > rows[best][k].abs() {
                best = i;
            }
        }
        swaps[k] = best as u32;
        rows.swap(k, best);
        let mut pivot_row = rows[k];
        let pivot = pivot_row[k];
        let inverse = 1.0 / pivot;
        smallest = smallest.min(pivot.abs());
        if !inverse.is_finite() {
            return 0.0;
        }
        rows[k][k] = inverse;
        // Whole rows at once: nothing is taken from what is done.
        pivot_row[..=k].fill(0.0);
        for row in &mut rows[k + 1..] {
            let factor = row[k] * inverse;
            for j in 0..N {
                row[j] -= factor * pivot_row[j];
            }
            row[k] = factor;
        }
    }
    if scale.is_finite() { smallest / scale } else { 0.0 }
}

/// Solves with a block that [`factor_block`] factorised.
#[inline(always)]
pub(super) fn solve_block(a: &[f64], swaps: &[u32], x: &mut [f64]) {
    if let (Some(rows), Ok(swaps), Ok(x)) = (
        a.as_chunks::<FREE>().0.first_chunk::<FREE>(),
        <&[u32; FREE]>::try_from(swaps),
        <&mut [f64; FREE]>::try_from(&mut *x),
    ) {
        return solve_fixed(rows, swaps, x);
    }
    if let (Some(rows), Ok(swaps), Ok(x)) = (
        a.as_chunks::<LIMB>().0.first_chunk::<LIMB>(),
        <&[u32; LIMB]>::try_from(swaps),
        <&mut [f64; LIMB]>::try_from(&mut *x),
    ) {
        return solve_fixed(rows, swaps, x);
    }
    let n = swaps.len();
    for (k, &s) in swaps.iter().enumerate() {
        x.swap(k, s as usize);
    }
    for i in 1..n {
        let (done, rest) = x.split_at_mut(i);
        rest[0] -= dot(&a[i * n..i * n + i], done);
    }
    for i in (0..n).rev() {
        let (left, right) = x.split_at_mut(i + 1);
        left[i] = (left[i] - dot(&a[i * n + i + 1..(i + 1) * n], right)) * a[i * n + i];
    }
}

#[inline(always)]
fn solve_fixed<const N: usize>(rows: &[[f64; N]; N], swaps: &[u32; N], x: &mut [f64; N]) {
    for k in 0..N {
        x.swap(k, swaps[k] as usize);
    }
    let mut y = *x;
    for i in 1..N {
        for k in 0..i {
            y[i] -= rows[i][k] * y[k];
        }
    }
    for i in (0..N).rev() {
        for k in i + 1..N {
            y[i] -= rows[i][k] * y[k];
        }
        y[i] *= rows[i][i];
    }
    *x = y;
}
