//! `W = J M⁻¹ Jᵀ` between those parts of an island of which it is asked for.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use signorini_lcp::linalg::{SHORT, dot, whole_lanes};
use signorini_multibody::BlockCholesky;

use crate::islands::Island;

/// `W` of the parts that are known, in the order in which they became known; memory is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Delassus {
    parts: Vec<Part>,
    /// Which parts of the island these are.
    is_known: Vec<bool>,
    /// `L⁻ᵀ Jᵀ` of each known row, `[rows, nv]` with whole lanes for each; zero beside its ways.
    half: Vec<f64>,
    /// `[rows, rows]` in a square of `stride` rows.
    data: Vec<f64>,
    stride: usize,
    /// Numbers to a row of `half`.
    width: usize,
    scratch: Scratch,
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
    way: u64,
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
        (self.width, self.stride) = (whole_lanes(island.nv()), 3 * units + bilateral);
        self.parts.clear();
        self.is_known.clear();
        self.is_known.resize(units + bilateral, false);
        self.half.resize(self.stride * self.width, 0.0);
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

    /// Makes a part known, by the rows of those components that have one: one, two or all three.
    pub fn learn(&mut self, factor: &BlockCholesky, island: &Island, part: usize, components: Range<usize>) {
        if std::mem::replace(&mut self.is_known[part], true) {
            return;
        }
        let begin = self.len();
        self.parts.push(Part { part, first: components.start, size: components.len(), begin, way: 0 });
        match components.len() {
            1 => self.add::<1>(factor, island),
            2 => self.add::<2>(factor, island),
            _ => self.add::<3>(factor, island),
        }
    }

    /// `L⁻ᵀ Jᵀ` and `W` of the last part, which has `N` rows.
    fn add<const N: usize>(&mut self, factor: &BlockCholesky, island: &Island) {
        let Some(own) = self.parts.last_mut() else { return };
        let nv = island.nv();
        self.scratch.fit(nv);
        own.way = self.scratch.half_solve::<N>(factor, island, own);
        let half = self.scratch.half.as_chunks::<N>().0;
        let rows = &mut self.half[own.begin * self.width..][..N * self.width];
        rows.fill(0.0);
        for_each_bit(own.way, |k| (0..N).for_each(|r| rows[r * self.width + k] = half[k][r]));
        // Short rows are done before wide vectors have begun.
        if nv <= SHORT { self.find_products() } else { Arch::new().dispatch(Products(self)) }
    }

    /// `W` between the last part and all that are known.
    #[inline(always)]
    fn find_products(&mut self) {
        let Self { parts, half, data, stride, width, .. } = self;
        let Some(own) = parts.last() else { return };
        for other in &*parts {
            // Beside the ways that both have one of them is zero.
            let shared = own.way & other.way;
            let end = whole_lanes((u64::BITS - shared.leading_zeros()) as usize);
            for r in own.rows() {
                for s in other.rows() {
                    let product = dot(&half[r * *width..][..end], &half[s * *width..][..end]);
                    (data[r * *stride + s], data[s * *stride + r]) = (product, product);
                }
            }
        }
    }

    /// `y += L⁻ᵀ Jᵀ p` for impulses of the known rows.
    pub fn add_half(&self, p: &[f64], y: &mut [f64]) {
        for (p, half) in p.iter().zip(self.half.chunks_exact(self.width.max(1))).filter(|(p, _)| **p != 0.0) {
            y.iter_mut().zip(half).for_each(|(y, half)| *y += half * p);
        }
    }
}

struct Products<'a>(&'a mut Delassus);

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.find_products();
    }
}

/// What a half solve needs, for as many degrees of freedom as there are.
#[derive(Clone, Debug, Default)]
struct Scratch {
    entries: Vec<f64>,
    rows: Vec<usize>,
    half: Vec<f64>,
}

impl Scratch {
    fn fit(&mut self, nv: usize) {
        if self.rows.len() < nv {
            self.rows.resize(nv, 0);
            self.entries.resize(3 * nv, 0.0);
            self.half.resize(3 * nv, 0.0);
        }
    }

    /// `L⁻ᵀ Jᵀ` of a part over the degrees of freedom of the island, `[nv, N]` in `half`; returns those on its ways to the roots as bits.
    fn half_solve<const N: usize>(&mut self, factor: &BlockCholesky, island: &Island, part: &Part) -> u64 {
        let entries = self.entries.as_chunks_mut::<N>().0;
        let half = self.half.as_chunks_mut::<N>().0;
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
            let mut last = first;
            while last < columns.len() && (columns[last] as usize) < end {
                self.rows[last - first] = columns[last] as usize - start;
                last += 1;
            }
            let (rows, own) = (&self.rows[..last - first], &mut half[start..end]);
            way |= factor.half_solve_on_ways(island.blocks[k] as usize, rows, &entries[first..last], own) << start;
            first = last;
        }
        way
    }
}

fn for_each_bit(mut bits: u64, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}
