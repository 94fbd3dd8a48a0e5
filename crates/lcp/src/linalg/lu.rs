use super::dot;
use super::kernels::{add_scaled, subtract_four};
use super::vectors::widest;

/// Columns factorised together before the trailing matrix is updated.
const PANEL: usize = 32;

/// LU factorisation with partial pivoting of a square matrix, `P K = L U`, row-major, in place.
#[derive(Clone, Debug, Default)]
pub struct Lu {
    n: usize,
    data: Vec<f64>,
    /// `swaps[k]` is the row exchanged with row `k` in step `k`.
    swaps: Vec<usize>,
    /// For each row the columns between which its nonzeros lie: `first[i] ≤ j < last[i]`.
    first: Vec<usize>,
    last: Vec<usize>,
    /// Largest entry of each column before elimination.
    column_scale: Vec<f64>,
}

impl Lu {
    /// Allocates what matrices of up to `n`×`n` need.
    pub fn reserve(&mut self, n: usize) {
        self.data.reserve((n * n).saturating_sub(self.data.len()));
        self.column_scale.reserve(n.saturating_sub(self.column_scale.len()));
        for list in [&mut self.swaps, &mut self.first, &mut self.last] {
            list.reserve(n.saturating_sub(list.len()));
        }
    }

    /// Makes room for an `n`×`n` matrix and returns it, zeroed, to be filled.
    pub fn start(&mut self, n: usize) -> &mut [f64] {
        self.n = n;
        self.data.clear();
        self.data.resize(n * n, 0.0);
        &mut self.data
    }

    /// Factorises what [`Lu::start`] returned.
    ///
    /// Returns the smallest pivot relative to the largest entry of its column before elimination;
    /// 0 means exactly singular, and then no solve may follow.
    pub fn factorize(&mut self) -> f64 {
        factorize_widely(self)
    }

    #[inline(always)]
    fn factorize_inlined(&mut self) -> f64 {
        let n = self.n;
        self.swaps.clear();
        self.swaps.resize(n, 0);
        self.column_scale.clear();
        self.column_scale.resize(n, 0.0);
        for row in self.data.chunks_exact(n.max(1)) {
            for (scale, x) in self.column_scale.iter_mut().zip(row) {
                *scale = scale.max(x.abs());
            }
        }
        let mut smallest = 1.0f64;
        let mut start = 0;
        while start < n {
            let end = (start + PANEL).min(n);
            for k in start..end {
                let pivot = self.eliminate_column(k, end);
                if pivot == 0.0 {
                    return 0.0;
                }
                smallest = smallest.min(pivot / self.column_scale[k]);
            }
            self.update_trailing(start, end);
            start = end;
        }
        self.find_envelope();
        if smallest.is_finite() { smallest } else { 0.0 }
    }

    #[inline(always)]
    fn find_envelope(&mut self) {
        self.first.clear();
        self.last.clear();
        for row in self.data.chunks_exact(self.n.max(1)) {
            self.first.push(row.iter().position(|x| *x != 0.0).unwrap_or(0));
            self.last.push(row.iter().rposition(|x| *x != 0.0).map_or(0, |j| j + 1));
        }
    }

    /// One step of partial pivoting inside the panel that ends at column `end`; returns |pivot|.
    #[inline(always)]
    fn eliminate_column(&mut self, k: usize, end: usize) -> f64 {
        let n = self.n;
        let mut best = (k, 0.0f64);
        for i in k..n {
            let size = self.data[i * n + k].abs();
            if size > best.1 {
                best = (i, size);
            }
        }
        self.swaps[k] = best.0;
        if best.1 == 0.0 {
            return 0.0;
        }
        if best.0 != k {
            let (head, tail) = self.data.split_at_mut(best.0 * n);
            head[k * n..(k + 1) * n].swap_with_slice(&mut tail[..n]);
        }
        let (head, tail) = self.data.split_at_mut((k + 1) * n);
        let pivot_row = &head[k * n..];
        let pivot = pivot_row[k];
        for row in tail.chunks_exact_mut(n) {
            if row[k] != 0.0 {
                row[k] /= pivot;
                let factor = row[k];
                let (row, pivot_row) = (&mut row[k + 1..end], &pivot_row[k + 1..end]);
                row.iter_mut().zip(pivot_row).for_each(|(x, p)| *x -= factor * p);
            }
        }
        best.1
    }

    /// Applies the panel `start..end` to the columns right of it.
    #[inline(always)]
    fn update_trailing(&mut self, start: usize, end: usize) {
        let n = self.n;
        // The rows of the panel reach no further right than this, and change nothing beyond.
        let reach = |k: usize| self.data[k * n + end..(k + 1) * n].iter().rposition(|x| *x != 0.0).map_or(0, |j| j + 1);
        let width = (start..end).map(reach).max().unwrap_or(0);
        if width == 0 {
            return;
        }
        for i in start + 1..n {
            let (head, tail) = self.data.split_at_mut(i * n);
            let (left, right) = tail[..n].split_at_mut(end);
            let right = &mut right[..width];
            let upper = |k: usize| &head[k * n + end..k * n + end + width];
            let last = end.min(i);
            let mut k = start;
            while k + 4 <= last {
                let factors = [left[k], left[k + 1], left[k + 2], left[k + 3]];
                if factors != [0.0; 4] {
                    subtract_four(right, factors, [upper(k), upper(k + 1), upper(k + 2), upper(k + 3)]);
                }
                k += 4;
            }
            for k in k..last {
                if left[k] != 0.0 {
                    add_scaled(right, -left[k], upper(k));
                }
            }
        }
    }

    /// Solves `K x = rhs` in place.
    pub fn solve(&self, x: &mut [f64]) {
        solve_widely(self, x);
    }

    #[inline(always)]
    fn solve_inlined(&self, x: &mut [f64]) {
        let n = self.n;
        for k in 0..n {
            x.swap(k, self.swaps[k]);
        }
        let first = x.iter().position(|&v| v != 0.0).unwrap_or(n);
        for i in first + 1..n {
            let start = self.first[i].max(first);
            if start < i {
                x[i] -= dot(&self.data[i * n + start..i * n + i], &x[start..i]);
            }
        }
        for i in (0..n).rev() {
            let row = &self.data[i * n..(i + 1) * n];
            let end = self.last[i];
            x[i] = (x[i] - dot(&row[i + 1..end], &x[i + 1..end])) / row[i];
        }
    }
}

widest! {
    fn factorize_widely(lu: &'a mut Lu) -> f64 {
        lu.factorize_inlined()
    }
}

widest! {
    fn solve_widely(lu: &'a Lu, x: &'a mut [f64]) -> () {
        lu.solve_inlined(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_across_panel_borders() {
        for n in [1, 2, 31, 32, 33, 70] {
            let entry = |i: usize, j: usize| (((i * n + j + 1) as f64).sin() * 43758.5453).fract();
            let mut lu = Lu::default();
            for (k, x) in lu.start(n).iter_mut().enumerate() {
                *x = entry(k / n, k % n);
            }
            let wanted: Vec<f64> = (0..n).map(|i| i as f64 - 3.0).collect();
            let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * wanted[j]).sum()).collect();
            assert!(lu.factorize() > 0.0);
            lu.solve(&mut x);
            for i in 0..n {
                assert!((x[i] - wanted[i]).abs() < 1e-8, "n {n}: x[{i}] = {}", x[i]);
            }
        }
    }

    #[test]
    fn a_zero_column_is_reported() {
        let mut lu = Lu::default();
        lu.start(2).copy_from_slice(&[0.0, 1.0, 0.0, 2.0]);
        assert_eq!(lu.factorize(), 0.0);
    }
}
