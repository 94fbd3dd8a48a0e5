//! `W = J M⁻¹ Jᵀ` between those parts of an island of which it is asked for.

use std::ops::Range;

use signorini_multibody::{BlockCholesky, FEW_ROWS};

use crate::islands::Island;

/// `W` of the parts that are known, in the order in which they became known; memory is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Delassus {
    parts: Vec<Part>,
    /// Which parts of the island these are.
    is_known: Vec<bool>,
    /// `L⁻ᵀ Jᵀ` of each part, `[nv, rows]`; written on its ways.
    half: Vec<f64>,
    /// `[rows, rows]` in a square of `stride` rows.
    data: Vec<f64>,
    stride: usize,
    nv: usize,
}

/// A known part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its number in the island: that of a unit, or after these that of a bilateral row.
    pub part: usize,
    /// The first of its components that has a row here, how many have, and where they begin.
    pub first: usize,
    size: usize,
    begin: usize,
    /// The degrees of freedom on the ways from it to the roots, as bits.
    way: u32,
}

impl Part {
    /// Its rows.
    pub fn rows(&self) -> Range<usize> {
        self.begin..self.begin + self.size
    }
}

impl Delassus {
    /// Makes room for an island of which nothing is known.
    pub fn forget(&mut self, island: &Island) {
        let (units, bilateral) = (island.units.len(), island.bilateral.len());
        (self.nv, self.stride) = (island.nv(), 3 * units + bilateral);
        self.parts.clear();
        self.is_known.clear();
        self.is_known.resize(units + bilateral, false);
        self.half.resize(self.stride * self.nv, 0.0);
        self.data.resize(self.stride * self.stride, 0.0);
    }

    /// The known parts.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Number of known rows.
    pub fn len(&self) -> usize {
        self.parts.last().map_or(0, |part| part.rows().end)
    }

    /// Row `r` of `W`, over the known rows.
    pub fn row(&self, r: usize) -> &[f64] {
        &self.data[r * self.stride..][..self.len()]
    }

    /// Makes a part known, by the rows of those components that have one: one component, or all three.
    pub fn learn(&mut self, factor: &BlockCholesky, island: &Island, part: usize, components: Range<usize>) {
        if std::mem::replace(&mut self.is_known[part], true) {
            return;
        }
        let begin = self.len();
        self.parts.push(Part { part, first: components.start, size: components.len(), begin, way: 0 });
        if components.len() == 1 { self.add::<1>(factor, island) } else { self.add::<3>(factor, island) }
    }

    /// `L⁻ᵀ Jᵀ` and `W` of the last part, which has `N` rows.
    fn add<const N: usize>(&mut self, factor: &BlockCholesky, island: &Island) {
        let Self { parts, half, data, stride, nv, .. } = self;
        let Some((own, before)) = parts.split_last_mut() else { return };
        let (half_before, rest) = half.split_at_mut(own.begin * *nv);
        let half = &mut rest.as_chunks_mut::<N>().0[..*nv];
        own.way = half_solve(factor, island, own, half);
        for other in before {
            let (rows, shared) = (other.rows(), own.way & other.way);
            let other_half = &half_before[rows.start * *nv..rows.end * *nv];
            if other.size == 1 {
                let block = multiply_shared::<N, 1>(half, other_half.as_chunks().0, shared);
                write(data, *stride, own.begin, rows.start, block);
            } else {
                let block = multiply_shared::<N, 3>(half, other_half.as_chunks().0, shared);
                write(data, *stride, own.begin, rows.start, block);
            }
        }
        write(data, *stride, own.begin, own.begin, multiply_shared::<N, N>(half, half, own.way));
    }

    /// `y += L⁻ᵀ Jᵀ p` for impulses of the known rows.
    pub fn add_half(&self, p: &[f64], y: &mut [f64]) {
        for part in &self.parts {
            let (rows, p) = (part.rows(), &p[part.rows()]);
            let half = &self.half[rows.start * self.nv..rows.end * self.nv];
            if let [p] = p {
                for_each_bit(part.way, |k| y[k] += half[k] * p);
            } else {
                let half = half.as_chunks::<3>().0;
                for_each_bit(part.way, |k| y[k] += half[k][0] * p[0] + half[k][1] * p[1] + half[k][2] * p[2]);
            }
        }
    }
}

/// Writes a block of `W`, and its transpose.
fn write<const A: usize, const B: usize>(data: &mut [f64], stride: usize, a: usize, b: usize, block: [[f64; B]; A]) {
    for (r, row) in block.iter().enumerate() {
        data[(a + r) * stride + b..][..B].copy_from_slice(row);
        (0..B).for_each(|s| data[(b + s) * stride + a + r] = row[s]);
    }
}

/// `L⁻ᵀ Jᵀ` of a part over the degrees of freedom of the island; returns those on its ways to the roots as bits.
fn half_solve<const N: usize>(factor: &BlockCholesky, island: &Island, part: &Part, half: &mut [[f64; N]]) -> u32 {
    let mut entries = [[0.0; N]; FEW_ROWS];
    let columns = if let Some(k) = part.part.checked_sub(island.units.len()) {
        let (columns, own) = island.bilateral_jacobian.group(k);
        entries.iter_mut().zip(own).for_each(|(entry, own)| entry[0] = own[0]);
        columns
    } else {
        let (columns, own) = island.jacobian.group(part.part);
        let components = part.first..part.first + N;
        entries.iter_mut().zip(own).for_each(|(entry, own)| entry.copy_from_slice(&own[components.clone()]));
        columns
    };
    let (mut first, mut way) = (0, 0);
    while first < columns.len() {
        let k = island.block_of(columns[first] as usize);
        let (start, end) = (island.starts[k], island.starts[k + 1]);
        let (mut rows, mut last) = ([0; FEW_ROWS], first);
        while last < columns.len() && (columns[last] as usize) < end {
            rows[last - first] = columns[last] as usize - start;
            last += 1;
        }
        let own = &mut half[start..end];
        let rows = &rows[..last - first];
        way |= factor.half_solve_on_ways(island.blocks[k] as usize, rows, &entries[first..last], own) << start;
        first = last;
    }
    way
}

/// `Aᵀ B` over the rows whose bits are set.
fn multiply_shared<const A: usize, const B: usize>(a: &[[f64; A]], b: &[[f64; B]], rows: u32) -> [[f64; B]; A] {
    let (mut product, mut left) = ([[0.0; B]; A], rows);
    while left != 0 {
        let first = left.trailing_zeros();
        let run = first as usize..(first + (left >> first).trailing_ones()) as usize;
        for (a, b) in a[run.clone()].iter().zip(&b[run]) {
            for r in 0..A {
                (0..B).for_each(|s| product[r][s] += a[r] * b[s]);
            }
        }
        // A carry out of the run clears it.
        left &= left.wrapping_add(1 << first);
    }
    product
}

fn for_each_bit(mut bits: u32, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}
