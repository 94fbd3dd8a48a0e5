//! Half-solved rows, body by body: with `M = Lᵀ L` velocities are `v = v^f + L⁻¹ s`, `s = Σ Z_cᵀ λ_c` and `Z_c = J_c L⁻¹`.

use signorini_multibody::BlockCholesky;

use crate::islands::Island;

/// Degrees of freedom of a free body, whose products have a fixed length.
const FREE: usize = 6;

/// The bodies of an island: consecutive blocks of the mass matrix that every row moves together or not at all. A free body with a diagonal
/// mass matrix has six blocks; a tree is one.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    /// First block of each, and the number of blocks.
    pub blocks: Vec<u32>,
    /// First degree of freedom of each, and the total.
    pub starts: Vec<u32>,
    /// The body of each degree of freedom.
    of_dof: Vec<u32>,
    /// Whether a body begins at a block.
    begins: Vec<bool>,
}

impl Bodies {
    /// Finds the bodies of an island.
    pub fn find(&mut self, island: &Island) {
        let count = island.blocks.len();
        self.begins.clear();
        self.begins.resize(count + 1, false);
        (self.begins[0], self.begins[count]) = (true, true);
        self.of_dof.clear();
        for k in 0..count {
            self.of_dof.resize(island.starts[k + 1], k as u32);
        }
        for c in 0..island.units.len() {
            self.cut(island.jacobian.group(c).0);
        }
        for k in 0..island.bilateral.len() {
            self.cut(island.bilateral_jacobian.group(k).0);
        }
        self.blocks.clear();
        self.starts.clear();
        for k in (0..=count).filter(|&k| self.begins[k]) {
            self.blocks.push(k as u32);
            self.starts.push(island.starts[k] as u32);
        }
        for (body, ends) in self.starts.windows(2).enumerate() {
            self.of_dof[ends[0] as usize..ends[1] as usize].fill(body as u32);
        }
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The body of a degree of freedom.
    pub fn of(&self, column: u32) -> usize {
        self.of_dof[column as usize] as usize
    }

    /// Lets bodies begin and end where the blocks do that a row moves.
    fn cut(&mut self, columns: &[u32]) {
        let mut last = None;
        for block in columns.iter().map(|&column| self.of_dof[column as usize] as usize) {
            match last {
                Some(before) if block == before => continue,
                Some(before) if block == before + 1 => {}
                Some(before) => (self.begins[before + 1], self.begins[block]) = (true, true),
                None => self.begins[block] = true,
            }
            last = Some(block);
        }
        last.into_iter().for_each(|block| self.begins[block + 1] = true);
    }
}

/// `Z` of groups of `R` rows.
#[derive(Clone, Debug)]
pub(super) struct HalfRows<const R: usize> {
    /// First of its runs of each group, and the total.
    groups: Vec<u32>,
    runs: Vec<Run>,
    entries: Vec<[f64; R]>,
}

/// The entries of a group for one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub body: u32,
    start: u32,
    count: u32,
    first: u32,
}

impl<const R: usize> Default for HalfRows<R> {
    fn default() -> Self {
        Self { groups: vec![0], runs: Vec::new(), entries: Vec::new() }
    }
}

impl<const R: usize> HalfRows<R> {
    /// Forgets all groups.
    pub fn clear(&mut self) {
        self.groups.truncate(1);
        self.runs.clear();
        self.entries.clear();
    }

    /// Adds a group from its Jacobian over the degrees of freedom of the island; `Z Zᵀ` of it comes back.
    pub fn push(
        &mut self,
        factor: &BlockCholesky,
        island: &Island,
        bodies: &Bodies,
        columns: &[u32],
        jacobian: impl Fn(usize) -> [f64; R],
    ) -> [[f64; R]; R] {
        let (mut k, group) = (0, self.entries.len());
        while k < columns.len() {
            let body = bodies.of(columns[k]);
            let [start, end] = [bodies.starts[body], bodies.starts[body + 1]];
            let first = self.entries.len();
            self.entries.resize(first + (end - start) as usize, [0.0; R]);
            let own = &mut self.entries[first..];
            while k < columns.len() && columns[k] < end {
                own[(columns[k] - start) as usize] = jacobian(k);
                k += 1;
            }
            for block in bodies.blocks[body] as usize..bodies.blocks[body + 1] as usize {
                let [from, to] = [island.starts[block], island.starts[block + 1]].map(|dof| dof - start as usize);
                factor.half_solve_block(island.blocks[block] as usize, &mut own[from..to]);
            }
            self.runs.push(Run { body: body as u32, start, count: end - start, first: first as u32 });
        }
        self.groups.push(self.runs.len() as u32);
        let mut square = [[0.0; R]; R];
        for entry in &self.entries[group..] {
            for r in 0..R {
                (0..R).for_each(|s| square[r][s] += entry[r] * entry[s]);
            }
        }
        square
    }

    /// The runs of a group.
    #[inline]
    pub fn runs(&self, group: usize) -> &[Run] {
        &self.runs[self.groups[group] as usize..self.groups[group + 1] as usize]
    }

    /// `Z s`.
    #[inline]
    pub fn multiply(&self, group: usize, s: &[f64]) -> [f64; R] {
        let mut u = [0.0; R];
        for run in self.runs(group) {
            let (entries, s) = (&self.entries[run.first as usize..], &s[run.start as usize..]);
            if run.count as usize == FREE
                && let (Some(entries), Some(s)) = (entries.first_chunk::<FREE>(), s.first_chunk::<FREE>())
            {
                for k in 0..FREE {
                    (0..R).for_each(|r| u[r] += entries[k][r] * s[k]);
                }
            } else {
                for (entry, s) in entries[..run.count as usize].iter().zip(s) {
                    (0..R).for_each(|r| u[r] += entry[r] * s);
                }
            }
        }
        u
    }

    /// `s += Zᵀ p`.
    #[inline]
    pub fn add_transposed(&self, group: usize, p: [f64; R], s: &mut [f64]) {
        for run in self.runs(group) {
            let (entries, s) = (&self.entries[run.first as usize..], &mut s[run.start as usize..]);
            if run.count as usize == FREE
                && let (Some(entries), Some(s)) = (entries.first_chunk::<FREE>(), s.first_chunk_mut::<FREE>())
            {
                (0..FREE).for_each(|k| s[k] += dot(entries[k], p));
            } else {
                entries[..run.count as usize].iter().zip(s).for_each(|(entry, s)| *s += dot(*entry, p));
            }
        }
    }
}

#[inline]
fn dot<const R: usize>(a: [f64; R], b: [f64; R]) -> f64 {
    let mut sum = 0.0;
    (0..R).for_each(|r| sum += a[r] * b[r]);
    sum
}
