//! What a group of Jacobian rows adds to the blocks of the proximal system that it couples.

use crate::islands::block_of;
use signorini_sparse::{BlockLu, FREE, LIMB, Symbolic};

/// The columns of a group of Jacobian rows that belong to one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub block: usize,
    first: usize,
    last: usize,
}

/// Cuts ascending columns where they pass from one block to the next.
pub(super) fn find_runs(columns: &[u32], starts: &[usize], runs: &mut Vec<Run>) {
    let mut first = 0;
    while first < columns.len() {
        let block = block_of(starts, columns[first] as usize);
        let end = starts[block + 1];
        let inside = |&c: &u32| (c as usize) < end;
        let rest = &columns[first..];
        let last = if rest.last().is_some_and(inside) { columns.len() } else { first + rest.partition_point(inside) };
        runs.push(Run { block, first, last });
        first = last;
    }
}

/// `A += Jᵀ S J` for a group of Jacobian rows over its runs.
#[inline(always)]
pub(super) fn add_outer<const R: usize>(
    matrix: &mut BlockLu,
    symbolic: &Symbolic,
    starts: &[usize],
    runs: &[Run],
    (columns, entries): (&[u32], &[[f64; R]]),
    slope: [[f64; R]; R],
) {
    let transposed = std::array::from_fn(|r| std::array::from_fn(|k| slope[k][r]));
    let part = |run: &Run| Part {
        start: starts[run.block],
        size: starts[run.block + 1] - starts[run.block],
        columns: &columns[run.first..run.last],
        entries: &entries[run.first..run.last],
    };
    for (k, run) in runs.iter().enumerate() {
        let own = part(run);
        let position = symbolic.position[run.block] as usize;
        own.add_product(&slope, &own, &mut matrix.upper[symbolic.upper_panel(position)..], symbolic.width(position));
        for other in &runs[..k] {
            let swapped = symbolic.position[run.block] < symbolic.position[other.block];
            let (a, b) = if swapped { (run, other) } else { (other, run) };
            let place = symbolic.place(a.block, b.block);
            let (a, b) = (part(a), part(b));
            a.add_product(&transposed, &b, &mut matrix.lower[place.lower..], place.lower_stride);
            a.add_product(&slope, &b, &mut matrix.upper[place.upper..], place.upper_stride);
        }
    }
}

/// The entries of a group of Jacobian rows in one block.
struct Part<'a, const R: usize> {
    /// First degree of freedom of the block, and its size.
    start: usize,
    size: usize,
    columns: &'a [u32],
    entries: &'a [[f64; R]],
}

impl<const R: usize> Part<'_, R> {
    /// `C += A S Bᵀ` for the transposed rows `A` and `B` of two blocks and `C` with `stride` between its rows.
    #[inline(always)]
    fn add_product(&self, slope: &[[f64; R]; R], other: &Self, c: &mut [f64], stride: usize) {
        if let Some(a) = self.rows::<FREE>() {
            if let Some(b) = other.rows::<FREE>() {
                return add_fixed(&weigh(&a, slope), &b, c, stride);
            }
            if let Some(b) = other.rows::<LIMB>() {
                return add_fixed(&weigh(&a, slope), &b, c, stride);
            }
        } else if let Some(a) = self.rows::<LIMB>() {
            if let Some(b) = other.rows::<FREE>() {
                return add_fixed(&weigh(&a, slope), &b, c, stride);
            }
            if let Some(b) = other.rows::<LIMB>() {
                return add_fixed(&weigh(&a, slope), &b, c, stride);
            }
        }
        let first = other.columns.first().map_or(0, |&j| j as usize - other.start);
        let consecutive =
            other.columns.last().is_some_and(|&j| j as usize - other.start + 1 == first + other.columns.len());
        for (i, row) in self.columns.iter().zip(self.entries) {
            let weighted: [f64; R] = std::array::from_fn(|k| (0..R).map(|r| row[r] * slope[r][k]).sum());
            let product = |entry: &[f64; R]| (0..R).map(|k| weighted[k] * entry[k]).sum::<f64>();
            let c = &mut c[(*i as usize - self.start) * stride..][..other.size];
            if consecutive {
                c[first..].iter_mut().zip(other.entries).for_each(|(c, entry)| *c += product(entry));
            } else {
                let columns = other.columns.iter().zip(other.entries);
                columns.for_each(|(&j, entry)| c[j as usize - other.start] += product(entry));
            }
        }
    }

    /// The rows, if they have all columns of a block of `N`.
    #[inline(always)]
    fn rows<const N: usize>(&self) -> Option<[[f64; N]; R]> {
        let entries: &[[f64; R]; N] = self.entries.try_into().ok().filter(|_| self.size == N)?;
        Some(std::array::from_fn(|r| std::array::from_fn(|k| entries[k][r])))
    }
}

/// `Sᵀ` times the rows.
#[inline(always)]
fn weigh<const N: usize, const R: usize>(rows: &[[f64; N]; R], slope: &[[f64; R]; R]) -> [[f64; N]; R] {
    let mut weighted = [[0.0; N]; R];
    for k in 0..R {
        for r in 0..R {
            for i in 0..N {
                weighted[k][i] += slope[r][k] * rows[r][i];
            }
        }
    }
    weighted
}

/// `C += Wᵀ B` for all columns of two blocks.
#[inline(always)]
fn add_fixed<const A: usize, const B: usize, const R: usize>(
    weighted: &[[f64; A]; R],
    rows: &[[f64; B]; R],
    c: &mut [f64],
    stride: usize,
) {
    for i in 0..A {
        let Some(c) = c[i * stride..].first_chunk_mut::<B>() else { return };
        for r in 0..R {
            for j in 0..B {
                c[j] += weighted[r][i] * rows[r][j];
            }
        }
    }
}
