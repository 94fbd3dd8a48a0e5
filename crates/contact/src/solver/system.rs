//! The proximal system `H = M + Σ J_cᵀ (ρ_c B_c) J_c` of one island, factorised, with rank-one updates.

use super::coupling::{Run, add_outer, find_runs};
use super::gathering::Gathering;
use super::island::{Island, block_of};
use super::mode::{Cones, Facet, Mode};
use super::sparse::{BlockLu, Symbolic, Vectorised, run_widest};
use crate::ContactProblem;

/// Updates kept before the matrix is factorised afresh.
const MAX_UPDATES: usize = 40;

/// `H` for the current modes: a block LU factorisation and, since then, one rank-one update per change of mode
/// (Sherman–Morrison in product form). Its blocks are bodies, or branches of trees; contacts and trees couple them.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximalSystem {
    n: usize,
    /// First degree of freedom of each block, and the total.
    starts: Vec<usize>,
    /// Pairs of blocks of one tree that its mass matrix couples, the one nearer to the root first.
    branches: Vec<(u32, u32)>,
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

#[derive(Clone, Copy, Debug)]
struct Update {
    contact: usize,
    /// `ρ f / (1 + ρ fᵀ J_c H⁻¹ J_cᵀ a)`.
    row: [f64; 3],
}

impl ProximalSystem {
    /// Finds which blocks the rows couple, and an elimination order.
    pub fn analyse(&mut self, problem: &ContactProblem, island: &Island) {
        self.n = island.nv();
        self.gathering.find_blocks(&problem.mass, island, &mut self.starts, &mut self.branches);
        self.runs.clear();
        self.edges.clear();
        self.edges.extend_from_slice(&self.branches);
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
            self.add_mass(problem.mass.block_data(block as usize), island.starts[k], island.starts[k + 1]);
        }
        for k in 0..self.branches.len() {
            let (a, b) = (self.branches[k].0 as usize, self.branches[k].1 as usize);
            let tree = island.block_of(self.starts[a]);
            self.add_branch(problem.mass.block_data(island.blocks[tree] as usize), island.starts[tree], a, b);
        }
        let contacts = island.units.len();
        for (k, &rho) in bilateral_weight.iter().enumerate() {
            let entries = island.bilateral_jacobian.group(k);
            let runs = &self.runs[self.run_offsets[contacts + k]..self.run_offsets[contacts + k + 1]];
            add_outer(&mut self.base, &self.symbolic, &self.starts, runs, entries, [[rho]]);
        }
    }

    /// Copies what a block of the mass matrix over the degrees of freedom `start..end` has in the diagonal blocks.
    fn add_mass(&mut self, mass: &[f64], start: usize, end: usize) {
        let size = end - start;
        let mut block = block_of(&self.starts, start);
        while self.starts[block] < end {
            let (begin, width) = (self.starts[block], self.starts[block + 1] - self.starts[block]);
            let position = self.symbolic.position[block] as usize;
            let (place, stride) = (self.symbolic.upper_panel(position), self.symbolic.width(position));
            let own = start.max(begin)..end.min(begin + width);
            for i in own.clone() {
                let row = &mass[(i - start) * size + own.start - start..][..own.len()];
                self.base.upper[place + (i - begin) * stride + own.start - begin..][..own.len()].copy_from_slice(row);
            }
            block += 1;
        }
    }

    /// Copies what the mass matrix of a tree whose degrees of freedom begin at `start` has where the blocks `a` and `b` meet.
    fn add_branch(&mut self, mass: &[f64], start: usize, a: usize, b: usize) {
        let size = mass.len().isqrt();
        let swapped = self.symbolic.position[a] > self.symbolic.position[b];
        let (a, b) = if swapped { (b, a) } else { (a, b) };
        let place = self.symbolic.place(a, b);
        let columns = self.starts[b] - start..self.starts[b + 1] - start;
        for i in 0..self.starts[a + 1] - self.starts[a] {
            let row = &mass[(self.starts[a] - start + i) * size..][columns.clone()];
            self.base.lower[place.lower + i * place.lower_stride..][..row.len()].copy_from_slice(row);
            self.base.upper[place.upper + i * place.upper_stride..][..row.len()].copy_from_slice(row);
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
        run_widest(Assembly { system: self, island, slope });
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

/// Adds `Σ J_cᵀ S_c J_c` to the matrix that is to be factorised.
struct Assembly<'a, F> {
    system: &'a mut ProximalSystem,
    island: &'a Island,
    slope: F,
}

impl<F: Fn(usize) -> Option<[[f64; 3]; 3]>> Vectorised for Assembly<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: pulp::Simd>(self, _simd: S) {
        let (system, island) = (self.system, self.island);
        for c in 0..island.units.len() {
            if let Some(mut slope) = (self.slope)(c) {
                if c >= island.contact_count {
                    slope[0] = [0.0; 3];
                }
                let runs = &system.runs[system.run_offsets[c]..system.run_offsets[c + 1]];
                add_outer(&mut system.lu, &system.symbolic, &system.starts, runs, island.jacobian.group(c), slope);
            }
        }
    }
}
