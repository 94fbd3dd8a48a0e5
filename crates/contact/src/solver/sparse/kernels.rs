//! Dense operations on small blocks, row-major.

/// Degrees of freedom of a free body: the block size that almost all problems with many blocks have.
pub(crate) const FREE: usize = 6;

/// `C −= A Bᵀ` for `A` of `[rows, inner]`, `B` of `[columns, inner]`, `C` of `[rows, columns]`.
pub(super) fn subtract_product(c: &mut [f64], a: &[f64], b: &[f64], inner: usize, columns: usize) {
    if inner == FREE && columns == FREE {
        return subtract_free(c, a, b);
    }
    for (row, a) in c.chunks_exact_mut(columns).zip(a.chunks_exact(inner)) {
        for (x, b) in row.iter_mut().zip(b.chunks_exact(inner)) {
            *x -= dot(a, b);
        }
    }
}

fn subtract_free(c: &mut [f64], a: &[f64], b: &[f64]) {
    let b: &[f64; FREE * FREE] = b.try_into().expect("a block of a free body");
    let mut transposed = [[0.0; FREE]; FREE];
    for k in 0..FREE {
        for j in 0..FREE {
            transposed[k][j] = b[j * FREE + k];
        }
    }
    for (row, a) in c.as_chunks_mut::<FREE>().0.iter_mut().zip(a.as_chunks::<FREE>().0) {
        for k in 0..FREE {
            for j in 0..FREE {
                row[j] -= a[k] * transposed[k][j];
            }
        }
    }
}

/// The rows `A` of a free body in a group of `R`, row by row.
pub(crate) type FreeRows<const R: usize> = [[f64; FREE]; R];

/// `C += Wᵀ B` for the rows of two free bodies, `C` of `[6, 6]`.
#[inline]
pub(crate) fn add_free_product<const R: usize>(
    c: &mut [[f64; FREE]; FREE],
    weighted: &FreeRows<R>,
    rows: &FreeRows<R>,
) {
    for i in 0..FREE {
        let mut sum = c[i];
        for r in 0..R {
            for j in 0..FREE {
                sum[j] += weighted[r][i] * rows[r][j];
            }
        }
        c[i] = sum;
    }
}

/// The scalar product, in four sums so that an addition does not wait for the one before it.
#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// `x −= A y` for `A` of `[x, y]`.
#[inline]
pub(super) fn subtract_multiply(x: &mut [f64], a: &[f64], y: &[f64]) {
    if let Ok(y) = <&[f64; FREE]>::try_from(y) {
        for (x, row) in x.iter_mut().zip(a.as_chunks::<FREE>().0) {
            let mut sum = 0.0;
            for k in 0..FREE {
                sum += row[k] * y[k];
            }
            *x -= sum;
        }
        return;
    }
    for (x, row) in x.iter_mut().zip(a.chunks_exact(y.len())) {
        *x -= dot(row, y);
    }
}

/// `y −= Aᵀ x` for `A` of `[x, y]`.
#[inline]
pub(super) fn subtract_multiply_transposed(y: &mut [f64], a: &[f64], x: &[f64]) {
    if let Ok(y) = <&mut [f64; FREE]>::try_from(&mut *y) {
        for (x, row) in x.iter().zip(a.as_chunks::<FREE>().0) {
            for k in 0..FREE {
                y[k] -= row[k] * x;
            }
        }
        return;
    }
    for (x, row) in x.iter().zip(a.chunks_exact(y.len())) {
        for (y, a) in y.iter_mut().zip(row) {
            *y -= a * x;
        }
    }
}

/// Factorises a square block in place with partial pivoting; `swaps[k]` is the row exchanged with row `k`, and the diagonal gets
/// the reciprocals of the pivots. Returns the smallest pivot relative to the largest entry of the block; 0 means singular.
pub(super) fn factor_block(a: &mut [f64], swaps: &mut [u32]) -> f64 {
    if let (Ok(a), Ok(swaps)) =
        (<&mut [f64; FREE * FREE]>::try_from(&mut *a), <&mut [u32; FREE]>::try_from(&mut *swaps))
    {
        return factor_free(a, swaps);
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

fn factor_free(a: &mut [f64; FREE * FREE], swaps: &mut [u32; FREE]) -> f64 {
    let scale = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let rows: &mut [[f64; FREE]; FREE] = a.as_chunks_mut().0.try_into().expect("six rows");
    let mut smallest = f64::INFINITY;
    for k in 0..FREE {
        let mut best = k;
        for i in k + 1..FREE {
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
            for j in 0..FREE {
                row[j] -= factor * pivot_row[j];
            }
            row[k] = factor;
        }
    }
    if scale.is_finite() { smallest / scale } else { 0.0 }
}

/// Solves with a block that [`factor_block`] factorised.
#[inline]
pub(super) fn solve_block(a: &[f64], swaps: &[u32], x: &mut [f64]) {
    if let (Ok(a), Ok(swaps), Ok(x)) =
        (<&[f64; FREE * FREE]>::try_from(a), <&[u32; FREE]>::try_from(swaps), <&mut [f64; FREE]>::try_from(&mut *x))
    {
        return solve_free(a, swaps, x);
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

fn solve_free(a: &[f64; FREE * FREE], swaps: &[u32; FREE], x: &mut [f64; FREE]) {
    let rows = a.as_chunks::<FREE>().0;
    for k in 0..FREE {
        x.swap(k, swaps[k] as usize);
    }
    let mut y = *x;
    for i in 1..FREE {
        for k in 0..i {
            y[i] -= rows[i][k] * y[k];
        }
    }
    for i in (0..FREE).rev() {
        for k in i + 1..FREE {
            y[i] -= rows[i][k] * y[k];
        }
        y[i] *= rows[i][i];
    }
    *x = y;
}
