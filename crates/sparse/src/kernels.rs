//! Dense operations on diagonal blocks, and on panels of their height.
//!
//! All are compiled for several widths of vectors, by being inlined into what [`pulp::Arch`] dispatches to. Every entry of a
//! result is summed in one order that depends neither on that width nor on which columns are done together, and products are
//! rounded before they are added: all processors give the same bits.

use super::panels::PanelMut;

/// Degrees of freedom of a free body: the block size that almost all problems with many blocks have.
pub const FREE: usize = 6;
/// Those of a leg of four, or of an arm.
pub const LIMB: usize = 3;

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
pub fn copy_few(target: &mut [f64], source: &[f64]) {
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

/// A scalar product in four sums, so that an addition does not wait for the one before it.
#[inline(always)]
fn dot(a: &[f64], x: &[f64]) -> f64 {
    let ((a, a_rest), (x, x_rest)) = (a.as_chunks::<4>(), x.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, x) in a.iter().zip(x) {
        for l in 0..4 {
            sums[l] += a[l] * x[l];
        }
    }
    let rest: f64 = a_rest.iter().zip(x_rest).map(|(a, x)| a * x).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
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
