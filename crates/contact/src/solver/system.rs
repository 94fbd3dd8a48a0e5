//! The proximal system `H = M + Σ J_cᵀ (ρ_c B_c) J_c` of one island, factorised, with rank-one updates.

use super::gathering::Gathering;
use super::island::{Island, block_of};
use super::mode::{Cones, Facet, Mode};
use super::sparse::{BlockLu, FREE, FreeRows, Symbolic, add_free_product};
use crate::ContactProblem;

/// Updates kept before the matrix is factorised afresh.
const MAX_UPDATES: usize = 40;

/// `H` for the current modes: a block LU factorisation and, since then, one rank-one update per change of mode
/// (Sherman–Morrison in product form). Its blocks are the bodies or trees; contacts couple them.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximalSystem {
    n: usize,
    /// First degree of freedom of each block, and the total.
    starts: Vec<usize>,
    gathering: Gathering,
    runs: Vec<Run>,
    /// Where each contact's runs begin, then each bilateral row's, and the total.
    run_offsets: Vec<usize>,
    edges: Vec<(u32, u32)>,
    symbolic: Symbolic,
    /// `M` and the bilateral rows; the same for all modes.
    base: BlockLu,
    lu: BlockLu,
    updates: Vec<Update>,
    /// `H⁻¹ J_cᵀ a` of each update, `n` entries each.
    columns: Vec<f64>,
}

/// The columns of a group of Jacobian rows that belong to one block.
#[derive(Clone, Copy, Debug)]
struct Run {
    block: usize,
    first: usize,
    last: usize,
}

#[derive(Clone, Copy, Debug)]
struct Update {
    contact: usize,
    /// `ρ f / (1 + ρ fᵀ J_c H⁻¹ J_cᵀ a)`.
    row: [f64; 3],
}

impl ProximalSystem {
    /// Finds which blocks the rows couple, and an elimination order.
    pub fn analyse(&mut self, island: &Island) {
        self.n = island.nv();
        self.gathering.find_blocks(island, &mut self.starts);
        self.runs.clear();
        self.edges.clear();
        self.run_offsets.clear();
        self.run_offsets.push(0);
        let contacts = (0..island.units.len()).map(|c| island.jacobian.group(c).0);
        let bilateral = (0..island.bilateral.len()).map(|k| island.bilateral_jacobian.group(k).0);
        for columns in contacts.chain(bilateral) {
            let begin = self.runs.len();
            find_runs(columns, &self.starts, &mut self.runs);
            for (k, b) in self.runs[begin..].iter().enumerate() {
                self.edges.extend(self.runs[begin..begin + k].iter().map(|a| (a.block as u32, b.block as u32)));
            }
            self.run_offsets.push(self.runs.len());
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.symbolic.analyse(&self.starts, &self.edges);
    }

    /// Assembles the part that no mode changes. `bilateral_weight`: ρ of every bilateral row.
    pub fn prepare(&mut self, problem: &ContactProblem, island: &Island, bilateral_weight: &[f64]) {
        self.base.clear(&self.symbolic);
        for (k, &block) in island.blocks.iter().enumerate() {
            let (start, size) = (island.starts[k], island.starts[k + 1] - island.starts[k]);
            let own = block_of(&self.starts, start);
            let width = self.starts[own + 1] - self.starts[own];
            let corner =
                self.symbolic.diagonal[self.symbolic.position[own] as usize] + (start - self.starts[own]) * (width + 1);
            for (i, row) in problem.mass.block_data(block as usize).chunks_exact(size).enumerate() {
                self.base.diagonal[corner + i * width..][..size].copy_from_slice(row);
            }
        }
        let contacts = island.units.len();
        for (k, &rho) in bilateral_weight.iter().enumerate() {
            let entries = island.bilateral_jacobian.group(k);
            let runs = &self.runs[self.run_offsets[contacts + k]..self.run_offsets[contacts + k + 1]];
            add_outer(&mut self.base, &self.symbolic, &self.starts, runs, entries, [[rho]]);
        }
    }

    /// Factorises for the given modes; `false` if a block is singular.
    pub fn factor(&mut self, island: &Island, cones: &Cones, modes: &[Mode], weight: &[f64]) -> bool {
        self.factor_slopes(island, |c| {
            let slope = (modes[c] != Mode::Open).then(|| cones.slope(island.units[c] as usize, modes[c]))?;
            Some(slope.map(|row| row.map(|b| weight[c] * b)))
        })
    }

    /// Factorises `M + Σ J_cᵀ S_c J_c` for any slopes (none: zero); `false` if a block is singular.
    pub fn factor_slopes(&mut self, island: &Island, slope: impl Fn(usize) -> Option<[[f64; 3]; 3]>) -> bool {
        self.updates.clear();
        self.columns.clear();
        self.lu.copy_from(&self.base);
        for c in 0..island.units.len() {
            if let Some(mut slope) = slope(c) {
                if c >= island.contact_count {
                    slope[0] = [0.0; 3];
                }
                let runs = &self.runs[self.run_offsets[c]..self.run_offsets[c + 1]];
                add_outer(&mut self.lu, &self.symbolic, &self.starts, runs, island.jacobian.group(c), slope);
            }
        }
        self.lu.factor(&self.symbolic) > 0.0
    }

    /// Whether so many updates have gathered that a fresh factorisation is due.
    pub fn is_worn(&self) -> bool {
        self.updates.len() >= MAX_UPDATES
    }

    /// Overwrites `x` with `H⁻¹ x`.
    pub fn solve(&mut self, island: &Island, x: &mut [f64]) {
        self.lu.solve(&self.symbolic, x);
        apply(&self.updates, &self.columns, self.n, island, x);
    }

    /// Lets contact `c` cross a facet: `H ← H + ρ J_cᵀ a fᵀ J_c`. Returns the column `w = H_old⁻¹ J_cᵀ a` and the ratio of
    /// the determinants `1 + ρ fᵀ J_c w`, or nothing if the new matrix is singular.
    pub fn cross(&mut self, island: &Island, c: usize, facet: &Facet, weight: f64) -> Option<(&[f64], f64)> {
        let start = self.columns.len();
        self.columns.resize(start + self.n, 0.0);
        let (known, column) = self.columns.split_at_mut(start);
        island.add_impulse(c, facet.jump, column);
        self.lu.solve(&self.symbolic, column);
        apply(&self.updates, known, self.n, island, column);
        let u = island.jacobian.multiply(c, column);
        let f = facet.normal;
        let ratio = 1.0 + weight * (f[0] * u[0] + f[1] * u[1] + f[2] * u[2]);
        if !ratio.is_finite() || ratio.abs() < 1e-13 {
            self.columns.truncate(start);
            return None;
        }
        self.updates.push(Update { contact: c, row: f.map(|f| weight * f / ratio) });
        Some((&self.columns[start..], ratio))
    }
}

/// Applies the updates, oldest first, to `x`.
fn apply(updates: &[Update], columns: &[f64], n: usize, island: &Island, x: &mut [f64]) {
    for (update, column) in updates.iter().zip(columns.chunks_exact(n.max(1))) {
        let u = island.jacobian.multiply(update.contact, x);
        let factor = update.row[0] * u[0] + update.row[1] * u[1] + update.row[2] * u[2];
        if factor != 0.0 {
            x.iter_mut().zip(column).for_each(|(x, w)| *x -= factor * w);
        }
    }
}

/// Cuts ascending columns where they pass from one block to the next.
fn find_runs(columns: &[u32], starts: &[usize], runs: &mut Vec<Run>) {
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
fn add_outer<const R: usize>(
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
        let place = symbolic.diagonal[symbolic.position[run.block] as usize];
        let free = own.free_rows();
        let diagonal = &mut matrix.diagonal[place..place + own.size * own.size];
        match (&free, free_block(diagonal)) {
            (Some(rows), Some(c)) => add_free_product(c, &weigh(rows, &slope), rows),
            _ => add_block(diagonal, &own, &slope, &own),
        }
        for other in &runs[..k] {
            let swapped = symbolic.position[run.block] > symbolic.position[other.block];
            let (a, b) = if swapped { (other, run) } else { (run, other) };
            let place = symbolic.block_in_panel(a.block, b.block);
            let (a, b) = (part(a), part(b));
            let range = place..place + a.size * b.size;
            let (lower, upper) = (&mut matrix.lower[range.clone()], &mut matrix.upper[range]);
            if let (Some(a), Some(b)) = (a.free_rows(), b.free_rows())
                && let (Some(lower), Some(upper)) = (free_block(lower), free_block(upper))
            {
                add_free_product(lower, &weigh(&b, &slope), &a);
                add_free_product(upper, &weigh(&b, &transposed), &a);
            } else {
                add_block(lower, &b, &slope, &a);
                add_block(upper, &b, &transposed, &a);
            }
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
    /// The rows, if they have all columns of a free body.
    #[inline]
    fn free_rows(&self) -> Option<FreeRows<R>> {
        let entries: &[[f64; R]; FREE] = self.entries.try_into().ok().filter(|_| self.size == FREE)?;
        Some(std::array::from_fn(|r| std::array::from_fn(|k| entries[k][r])))
    }
}

fn free_block(block: &mut [f64]) -> Option<&mut [[f64; FREE]; FREE]> {
    block.as_chunks_mut().0.try_into().ok()
}

/// `Sᵀ` times the rows.
#[inline]
fn weigh<const R: usize>(rows: &FreeRows<R>, slope: &[[f64; R]; R]) -> FreeRows<R> {
    let mut weighted = [[0.0; FREE]; R];
    for k in 0..R {
        for r in 0..R {
            for i in 0..FREE {
                weighted[k][i] += slope[r][k] * rows[r][i];
            }
        }
    }
    weighted
}

/// `C += A S Bᵀ` for `C` of the sizes of the two blocks.
fn add_block<const R: usize>(c: &mut [f64], a: &Part<R>, slope: &[[f64; R]; R], b: &Part<R>) {
    let first = b.columns.first().map_or(0, |&j| j as usize - b.start);
    let consecutive = b.columns.last().is_some_and(|&j| j as usize - b.start + 1 == first + b.columns.len());
    for (i, row) in a.columns.iter().zip(a.entries) {
        let weighted: [f64; R] = std::array::from_fn(|k| (0..R).map(|r| row[r] * slope[r][k]).sum());
        let product = |entry: &[f64; R]| (0..R).map(|k| weighted[k] * entry[k]).sum::<f64>();
        let c = &mut c[(*i as usize - a.start) * b.size..][..b.size];
        if consecutive {
            c[first..].iter_mut().zip(b.entries).for_each(|(c, entry)| *c += product(entry));
        } else {
            b.columns.iter().zip(b.entries).for_each(|(&j, entry)| c[j as usize - b.start] += product(entry));
        }
    }
}
