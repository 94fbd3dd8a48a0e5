//! Splitting a problem into islands: sets of kinematic trees that contacts and bilateral rows tie together.

use signorini_multibody::{BlockCholesky, BlockDiagonal};

use crate::ContactProblem;
use crate::jacobian::SparseRows;

/// One island with its rows over local degrees of freedom.
#[derive(Clone, Debug, Default)]
pub(crate) struct Island {
    /// Blocks of the mass matrix in it, ascending.
    pub blocks: Vec<u32>,
    /// First local degree of freedom of each block, and the total.
    pub starts: Vec<usize>,
    /// First global degree of freedom of each block.
    pub global_starts: Vec<usize>,
    /// Contacts in it, ascending.
    pub contacts: Vec<u32>,
    /// Their Jacobian over local degrees of freedom.
    pub jacobian: SparseRows<3>,
    /// Bilateral rows in it, ascending.
    pub bilateral: Vec<u32>,
    /// Their Jacobian over local degrees of freedom.
    pub bilateral_jacobian: SparseRows<1>,
}

impl Island {
    /// Number of local degrees of freedom.
    pub fn nv(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Copies the island's part of a global vector.
    pub fn gather(&self, global: &[f64], local: &mut Vec<f64>) {
        local.clear();
        for (k, &start) in self.global_starts.iter().enumerate() {
            local.extend_from_slice(&global[start..start + self.starts[k + 1] - self.starts[k]]);
        }
    }

    /// Writes a local vector to its places in a global one.
    pub fn scatter(&self, local: &[f64], global: &mut [f64]) {
        for (k, &start) in self.global_starts.iter().enumerate() {
            let own = &local[self.starts[k]..self.starts[k + 1]];
            global[start..start + own.len()].copy_from_slice(own);
        }
    }

    /// Overwrites a local vector with `M⁻¹` times it.
    pub fn solve_mass(&self, factor: &BlockCholesky, x: &mut [f64]) {
        for (k, &block) in self.blocks.iter().enumerate() {
            factor.solve_block_in_place(block as usize, &mut x[self.starts[k]..self.starts[k + 1]]);
        }
    }

    /// `y += M x` for local vectors.
    pub fn multiply_mass(&self, mass: &BlockDiagonal, x: &[f64], y: &mut [f64]) {
        for (k, &block) in self.blocks.iter().enumerate() {
            let own = self.starts[k]..self.starts[k + 1];
            for (y, row) in y[own.clone()].iter_mut().zip(mass.block_data(block as usize).chunks_exact(own.len())) {
                *y += row.iter().zip(&x[own.clone()]).map(|(m, x)| m * x).sum::<f64>();
            }
        }
    }

    /// Adds the island's part of the mass matrix to a dense local matrix.
    pub fn add_mass(&self, mass: &BlockDiagonal, dense: &mut [f64]) {
        let n = self.nv();
        for (k, &block) in self.blocks.iter().enumerate() {
            let size = mass.blocks()[block as usize].size;
            for (i, row) in mass.block_data(block as usize).chunks_exact(size).enumerate() {
                let start = (self.starts[k] + i) * n + self.starts[k];
                dense[start..start + size].iter_mut().zip(row).for_each(|(h, m)| *h += m);
            }
        }
    }

    fn clear(&mut self) {
        self.blocks.clear();
        self.starts.clear();
        self.global_starts.clear();
        self.contacts.clear();
        self.jacobian.clear();
        self.bilateral.clear();
        self.bilateral_jacobian.clear();
    }
}

/// The islands of a problem; memory is reused from problem to problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct Islands {
    islands: Vec<Island>,
    count: usize,
    block_of_dof: Vec<u32>,
    root: Vec<u32>,
    island_of_root: Vec<u32>,
    local_start: Vec<usize>,
}

const NONE: u32 = u32::MAX;

impl Islands {
    /// The islands that have at least one row, in the order of their first block.
    pub fn all(&self) -> &[Island] {
        &self.islands[..self.count]
    }

    /// Finds the islands of a problem.
    pub fn find(&mut self, problem: &ContactProblem) {
        self.join_blocks(problem);
        self.number_islands(problem);
        for i in 0..problem.contact_count() {
            let (columns, entries) = problem.jacobian.group(i);
            let Some(island) = self.island_of(columns) else { continue };
            let local = columns.iter().map(|&c| local_index(problem, &self.block_of_dof, &self.local_start, c));
            let island = &mut self.islands[island];
            island.jacobian.push(local.zip(entries.iter().copied()));
            island.contacts.push(i as u32);
        }
        for i in 0..problem.bilateral_violation.len() {
            let (columns, entries) = problem.bilateral_jacobian.group(i);
            let Some(island) = self.island_of(columns) else { continue };
            let local = columns.iter().map(|&c| local_index(problem, &self.block_of_dof, &self.local_start, c));
            let island = &mut self.islands[island];
            island.bilateral_jacobian.push(local.zip(entries.iter().copied()));
            island.bilateral.push(i as u32);
        }
    }

    /// Union–find over the blocks of the mass matrix.
    fn join_blocks(&mut self, problem: &ContactProblem) {
        let blocks = problem.mass.blocks();
        self.block_of_dof.clear();
        for (k, block) in blocks.iter().enumerate() {
            self.block_of_dof.extend(std::iter::repeat_n(k as u32, block.size));
        }
        self.root.clear();
        self.root.extend(0..blocks.len() as u32);
        for i in 0..problem.contact_count() {
            self.join(problem.jacobian.group(i).0);
        }
        for i in 0..problem.bilateral_violation.len() {
            self.join(problem.bilateral_jacobian.group(i).0);
        }
    }

    fn join(&mut self, columns: &[u32]) {
        let Some((&first, rest)) = columns.split_first() else { return };
        let mut a = find_root(&mut self.root, self.block_of_dof[first as usize]);
        for &column in rest {
            let b = find_root(&mut self.root, self.block_of_dof[column as usize]);
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            self.root[high as usize] = low;
            a = low;
        }
    }

    /// Gives every touched root an island and every block its local place.
    fn number_islands(&mut self, problem: &ContactProblem) {
        let blocks = problem.mass.blocks();
        self.island_of_root.clear();
        self.island_of_root.resize(blocks.len(), NONE);
        let groups = (0..problem.contact_count()).map(|i| problem.jacobian.group(i).0);
        let bilateral = (0..problem.bilateral_violation.len()).map(|i| problem.bilateral_jacobian.group(i).0);
        for columns in groups.chain(bilateral) {
            if let Some(&c) = columns.first() {
                let root = find_root(&mut self.root, self.block_of_dof[c as usize]);
                self.island_of_root[root as usize] = 0;
            }
        }
        self.count = 0;
        self.local_start.clear();
        self.local_start.resize(blocks.len(), 0);
        for (k, block) in blocks.iter().enumerate() {
            let root = find_root(&mut self.root, k as u32) as usize;
            if self.island_of_root[root] == NONE {
                continue;
            }
            if root == k {
                self.island_of_root[root] = self.count as u32;
                if self.islands.len() == self.count {
                    self.islands.push(Island::default());
                }
                self.islands[self.count].clear();
                self.islands[self.count].starts.push(0);
                self.count += 1;
            }
            let island = &mut self.islands[self.island_of_root[root] as usize];
            self.local_start[k] = island.nv();
            island.blocks.push(k as u32);
            island.global_starts.push(block.start);
            island.starts.push(self.local_start[k] + block.size);
        }
    }

    fn island_of(&mut self, columns: &[u32]) -> Option<usize> {
        let block = self.block_of_dof[*columns.first()? as usize];
        let root = find_root(&mut self.root, block);
        Some(self.island_of_root[root as usize] as usize)
    }
}

/// Place of a global degree of freedom in its island.
fn local_index(problem: &ContactProblem, block_of_dof: &[u32], local_start: &[usize], column: u32) -> u32 {
    let block = block_of_dof[column as usize] as usize;
    (local_start[block] + column as usize - problem.mass.blocks()[block].start) as u32
}

fn find_root(root: &mut [u32], mut k: u32) -> u32 {
    while root[k as usize] != k {
        root[k as usize] = root[root[k as usize] as usize];
        k = root[k as usize];
    }
    k
}
