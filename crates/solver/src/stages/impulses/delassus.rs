//! `W = J M⁻¹ Jᵀ` between those parts of an island of which it is asked for.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use signorini_lcp::linalg::{SHORT, dot, whole_lanes};
use signorini_multibody::{BlockCholesky, LANES};

use crate::islands::Island;

/// `W` of the parts that are known, in the order in which they became known; memory is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Delassus {
    parts: Vec<Part>,
    /// Which parts of the island these are.
    is_known: Vec<bool>,
    /// `L⁻ᵀ Jᵀ`, a column for each known row, `[nv, stride]`.
    half: Vec<f64>,
    /// `[rows, rows]` in rows of `stride` numbers.
    data: Vec<f64>,
    stride: usize,
    /// For how many rows `W` is there.
    solved: usize,
    /// The columns that are solved for at a time, `[nv, whole lanes]`.
    columns: Vec<f64>,
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
}

impl Part {
    /// Its rows.
    pub fn rows(&self) -> Range<usize> {
        self.begin..self.begin + self.size
    }

    /// Its components that have a row.
    pub fn components(&self) -> Range<usize> {
        self.first..self.first + self.size
    }
}

impl Delassus {
    /// Makes room for an island of which nothing is known.
    pub fn forget(&mut self, island: &Island) {
        let (units, bilateral) = (island.units.len(), island.bilateral.len());
        (self.stride, self.solved) = (whole_lanes(3 * units + bilateral), 0);
        self.parts.clear();
        self.is_known.clear();
        self.is_known.resize(units + bilateral, false);
        let room = island.nv() * self.stride;
        self.half.resize(room, 0.0);
        self.columns.reserve(room.saturating_sub(self.columns.len()));
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

    /// Takes in a part, by the rows of those components that have one: one, two or all three. [`find`](Self::find) makes it known.
    pub fn learn(&mut self, part: usize, components: Range<usize>) {
        if !std::mem::replace(&mut self.is_known[part], true) {
            let begin = self.len();
            self.parts.push(Part { part, first: components.start, size: components.len(), begin });
        }
    }

    /// `L⁻ᵀ Jᵀ` and `W` of the parts that were taken in since it was called last.
    pub fn find(&mut self, factor: &BlockCholesky, island: &Island) {
        if self.solved == self.len() {
            return;
        }
        let width = self.take_columns(island);
        let work = Find { delassus: self, factor, island, width };
        // Short rows are done before wide vectors have begun.
        if island.nv() <= SHORT {
            work.run()
        } else {
            Arch::new().dispatch(work)
        }
        self.solved = self.len();
    }

    /// Writes the columns of the rows that are not solved yet, and returns into how many whole lanes they fit.
    fn take_columns(&mut self, island: &Island) -> usize {
        let width = whole_lanes(self.len() - self.solved);
        self.columns.clear();
        self.columns.resize(island.nv() * width, 0.0);
        let new = self.parts.iter().rev().take_while(|part| part.begin >= self.solved);
        for part in new {
            let place = part.begin - self.solved;
            if let Some(k) = part.part.checked_sub(island.units.len()) {
                let (columns, entries) = island.bilateral_jacobian.group(k);
                for (&column, [entry]) in columns.iter().zip(entries) {
                    self.columns[column as usize * width + place] = *entry;
                }
            } else {
                let (columns, entries) = island.jacobian.group(part.part);
                for (&column, entry) in columns.iter().zip(entries) {
                    let own = &mut self.columns[column as usize * width + place..][..part.size];
                    own.iter_mut().zip(&entry[part.first..]).for_each(|(x, entry)| *x = *entry);
                }
            }
        }
        width
    }

    /// `u = W p` for impulses of the known rows.
    pub fn multiply(&self, p: &[f64], u: &mut Vec<f64>) {
        u.clear();
        u.resize(self.len(), 0.0);
        if self.len() <= SHORT { self.add_rows(p, u) } else { Arch::new().dispatch(Multiply { delassus: self, p, u }) }
    }

    #[inline(always)]
    fn add_rows(&self, p: &[f64], u: &mut [f64]) {
        let rows = self.data.chunks_exact(self.stride.max(1));
        for (p, row) in p.iter().zip(rows).filter(|(p, _)| **p != 0.0) {
            u.iter_mut().zip(row).for_each(|(u, w)| *u += p * w);
        }
    }

    /// `y += L⁻ᵀ Jᵀ p` for impulses of the known rows.
    pub fn add_half(&self, p: &[f64], y: &mut [f64]) {
        let rows = self.half.chunks_exact(self.stride.max(1));
        y.iter_mut().zip(rows).for_each(|(y, half)| *y += dot(&half[..p.len()], p));
    }
}

struct Multiply<'a> {
    delassus: &'a Delassus,
    p: &'a [f64],
    u: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.delassus.add_rows(self.p, self.u);
    }
}

struct Find<'a> {
    delassus: &'a mut Delassus,
    factor: &'a BlockCholesky,
    island: &'a Island,
    width: usize,
}

impl Find<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { delassus, factor, island, width } = self;
        for (k, &block) in island.blocks.iter().enumerate() {
            let own = island.starts[k] * width..island.starts[k + 1] * width;
            factor.half_solve_rows(block as usize, &mut delassus.columns[own], width, width);
        }
        let (known, len) = (delassus.solved, delassus.len());
        let Delassus { half, data, columns, stride, .. } = delassus;
        for (half, columns) in half.chunks_exact_mut(*stride).zip(columns.chunks_exact(width)) {
            half[known..len].copy_from_slice(&columns[..len - known]);
        }
        for r in known..len {
            let (before, own) = data.split_at_mut(r * *stride);
            let end = whole_lanes(r + 1);
            let mut first = 0;
            while first < end {
                let own = &mut own[first..];
                first += match (end - first) / LANES {
                    1 => products::<1>(half, *stride, r, first, own),
                    2 | 3 => products::<2>(half, *stride, r, first, own),
                    _ => products::<4>(half, *stride, r, first, own),
                };
            }
            before.chunks_exact_mut(*stride).zip(&*own).for_each(|(row, own)| row[r] = *own);
        }
    }
}

impl WithSimd for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.run();
    }
}

/// `COUNT` lanes of row `r` of `W`, from column `first` on; how many numbers these are.
#[inline(always)]
fn products<const COUNT: usize>(half: &[f64], stride: usize, r: usize, first: usize, own: &mut [f64]) -> usize {
    let mut sums = [[0.0; LANES]; COUNT];
    for row in half.chunks_exact(stride) {
        let factor = row[r];
        // Most degrees of freedom are not on the way from this row to its root.
        if factor != 0.0 {
            for (sums, row) in sums.iter_mut().zip(row[first..][..COUNT * LANES].as_chunks::<LANES>().0) {
                for lane in 0..LANES {
                    sums[lane] += factor * row[lane];
                }
            }
        }
    }
    own[..COUNT * LANES].copy_from_slice(sums.as_flattened());
    COUNT * LANES
}
