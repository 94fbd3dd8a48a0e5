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
    /// Units in it, ascending: contact `i` is unit `i`, friction group `j` of a problem with `nc` contacts unit `nc + j`.
    pub units: Vec<u32>,
    /// How many of its units are contacts.
    pub contact_count: usize,
    /// Rows of each unit over local degrees of freedom. A contact has its normal and tangents. A friction group has its two
    /// rows and, in the first row, what its bound grows with: the normal of the contact that bounds it, or nothing. The first
    /// component of a group's impulse is its bound, and pushes nothing.
    pub jacobian: SparseRows<3>,
    /// The unit of the contact that bounds each friction group, by place among the groups; itself where none does.
    pub bounded_by: Vec<u32>,
    /// `u − J v` of each unit: `(φ/Δt, 0, 0)` of a contact, minus the target of a group.
    pub offset: Vec<[f64; 3]>,
    /// Largest diagonal entry of each unit's Delassus block.
    pub scale: Vec<f64>,
    /// Bilateral rows in it, ascending.
    pub bilateral: Vec<u32>,
    /// Their Jacobian over local degrees of freedom.
    pub bilateral_jacobian: SparseRows<1>,
    /// `Θ/Δt` of each.
    pub bilateral_offset: Vec<f64>,
    /// `∇Θ M⁻¹ ∇Θᵀ` of each.
    pub bilateral_scale: Vec<f64>,
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

    /// The velocity `u` of unit `c` at a local velocity.
    pub fn slack(&self, c: usize, v: &[f64]) -> [f64; 3] {
        let (u, offset) = (self.jacobian.multiply(c, v), self.offset[c]);
        [u[0] + offset[0], u[1] + offset[1], u[2] + offset[2]]
    }

    /// Gives every friction group's first component the value of the contact that bounds it. They are the same number; weighted
    /// rows round differently.
    pub fn bind(&self, x: &mut [[f64; 3]]) {
        for (k, &by) in self.bounded_by.iter().enumerate() {
            x[self.contact_count + k][0] = x[by as usize][0];
        }
    }

    /// The part of unit `c`'s impulse (or of a change of it) that pushes.
    pub fn pushing(&self, c: usize, p: [f64; 3]) -> [f64; 3] {
        if c < self.contact_count { p } else { [0.0, p[1], p[2]] }
    }

    /// `y += J_cᵀ p` for the part of unit `c`'s impulse that pushes.
    pub fn add_impulse(&self, c: usize, p: [f64; 3], y: &mut [f64]) {
        self.jacobian.add_transposed(c, self.pushing(c, p), y);
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
        self.units.clear();
        self.contact_count = 0;
        self.bounded_by.clear();
        self.jacobian.clear();
        self.offset.clear();
        self.scale.clear();
        self.bilateral.clear();
        self.bilateral_jacobian.clear();
        self.bilateral_offset.clear();
        self.bilateral_scale.clear();
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
    scratch: Vec<f64>,
    columns: Vec<(u32, [f64; 3])>,
    /// Unit of each contact in its island.
    place: Vec<u32>,
    /// The largest Delassus entry of contacts and groups.
    delassus_scale: f64,
}

const NONE: u32 = u32::MAX;

impl Islands {
    /// The islands that have at least one row, in the order of their first block.
    pub fn all(&self) -> &[Island] {
        &self.islands[..self.count]
    }

    /// `g` of the problem ([`ContactProblem::delassus_scale`]).
    pub fn delassus_scale(&self) -> f64 {
        self.delassus_scale
    }

    /// Finds the islands of a problem.
    pub fn find(&mut self, problem: &ContactProblem) {
        self.join_blocks(problem);
        self.number_islands(problem);
        self.delassus_scale = 0.0;
        self.scratch.clear();
        self.scratch.resize(problem.nv(), 0.0);
        (0..problem.contact_count()).for_each(|i| self.add_contact(problem, i));
        (0..problem.friction_groups.len()).for_each(|j| self.add_group(problem, j));
        (0..problem.bilateral_violation.len()).for_each(|k| self.add_bilateral(problem, k));
    }

    fn add_contact(&mut self, problem: &ContactProblem, i: usize) {
        self.place.truncate(i);
        self.place.push(NONE);
        let (columns, entries) = problem.jacobian.group(i);
        let Some(island) = self.island_of(columns) else { return };
        let local = columns.iter().map(|&c| local_index(problem, &self.block_of_dof, &self.local_start, c));
        let g = largest(&problem.delassus_diagonal(i, &mut self.scratch));
        self.delassus_scale = self.delassus_scale.max(g);
        let island = &mut self.islands[island];
        self.place[i] = island.units.len() as u32;
        island.jacobian.push(local.zip(entries.iter().copied()));
        island.units.push(i as u32);
        island.contact_count += 1;
        island.offset.push([problem.gap[i] / problem.timestep, 0.0, 0.0]);
        island.scale.push(positive(g));
    }

    /// A group's first row is that of its contact, scaled so that the proximal weight of the group turns it into the contact's
    /// own trial impulse.
    fn add_group(&mut self, problem: &ContactProblem, j: usize) {
        let groups = &problem.friction_groups;
        let (columns, entries) = groups.jacobian.group(j);
        let Some(island) = self.island_of(columns) else { return };
        let g = largest(&problem.group_delassus(j, &mut self.scratch));
        self.delassus_scale = self.delassus_scale.max(g);
        let scale = positive(g);
        self.columns.clear();
        self.columns.extend(columns.iter().zip(entries).map(|(&c, e)| (c, [0.0, e[0], e[1]])));
        let target = groups.target[j];
        let mut offset = [0.0, -target[0], -target[1]];
        let contact = groups.bound[j].normal().map(|(contact, _)| contact).filter(|&i| self.place[i] != NONE);
        if let Some(i) = contact {
            let factor = scale / self.islands[island].scale[self.place[i] as usize];
            offset[0] = factor * problem.gap[i] / problem.timestep;
            let (columns, entries) = problem.jacobian.group(i);
            for (&c, e) in columns.iter().zip(entries) {
                match self.columns.binary_search_by_key(&c, |x| x.0) {
                    Ok(k) => self.columns[k].1[0] = factor * e[0],
                    Err(k) => self.columns.insert(k, (c, [factor * e[0], 0.0, 0.0])),
                }
            }
        }
        let Self { columns, islands, block_of_dof, local_start, place, .. } = self;
        let island = &mut islands[island];
        island.bounded_by.push(contact.map_or(island.units.len() as u32, |i| place[i]));
        island.jacobian.push(columns.iter().map(|&(c, e)| (local_index(problem, block_of_dof, local_start, c), e)));
        island.units.push((problem.contact_count() + j) as u32);
        island.offset.push(offset);
        island.scale.push(scale);
    }

    fn add_bilateral(&mut self, problem: &ContactProblem, k: usize) {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        let Some(island) = self.island_of(columns) else { return };
        let local = columns.iter().map(|&c| local_index(problem, &self.block_of_dof, &self.local_start, c));
        let scale = positive(problem.bilateral_delassus(k, &mut self.scratch));
        let island = &mut self.islands[island];
        island.bilateral_jacobian.push(local.zip(entries.iter().copied()));
        island.bilateral.push(k as u32);
        island.bilateral_offset.push(problem.bilateral_violation[k] / problem.timestep);
        island.bilateral_scale.push(scale);
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
        let groups = &problem.friction_groups;
        for j in 0..groups.len() {
            let columns = groups.jacobian.group(j).0;
            self.join(columns);
            if let Some((contact, _)) = groups.bound[j].normal() {
                let normal = problem.jacobian.group(contact).0;
                self.join_pair(columns.first(), normal.first());
            }
        }
        for i in 0..problem.bilateral_violation.len() {
            self.join(problem.bilateral_jacobian.group(i).0);
        }
    }

    fn join(&mut self, columns: &[u32]) {
        for pair in columns.windows(2) {
            self.join_pair(pair.first(), pair.last());
        }
    }

    fn join_pair(&mut self, first: Option<&u32>, second: Option<&u32>) {
        let (Some(&first), Some(&second)) = (first, second) else { return };
        let a = find_root(&mut self.root, self.block_of_dof[first as usize]);
        let b = find_root(&mut self.root, self.block_of_dof[second as usize]);
        self.root[a.max(b) as usize] = a.min(b);
    }

    /// Gives every touched root an island and every block its local place.
    fn number_islands(&mut self, problem: &ContactProblem) {
        let blocks = problem.mass.blocks();
        self.island_of_root.clear();
        self.island_of_root.resize(blocks.len(), NONE);
        let groups = &problem.friction_groups;
        let contacts = (0..problem.contact_count()).map(|i| problem.jacobian.group(i).0);
        let groups = (0..groups.len()).map(|j| groups.jacobian.group(j).0);
        let bilateral = (0..problem.bilateral_violation.len()).map(|i| problem.bilateral_jacobian.group(i).0);
        for columns in contacts.chain(groups).chain(bilateral) {
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

fn largest(diagonal: &[f64]) -> f64 {
    diagonal.iter().copied().fold(0.0, f64::max)
}

/// A scale; 1 where there is nothing to scale by.
fn positive(g: f64) -> f64 {
    if g > 0.0 { g } else { 1.0 }
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
