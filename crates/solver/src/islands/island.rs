//! An island: kinematic trees that contacts and bilateral rows tie together, with its rows over local degrees of freedom.

use signorini_multibody::{BlockCholesky, BlockDiagonal};

use signorini_contact::SparseRows;
use signorini_contact::scales::VelocityScale;

/// One island with its rows over local degrees of freedom.
#[derive(Clone, Debug, Default)]
pub struct Island {
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
    /// `u` of each unit at the free velocity.
    pub free_slack: Vec<[f64; 3]>,
    /// Largest diagonal entry of each unit's Delassus block.
    pub scale: Vec<f64>,
    /// That of the whole problem, in which residuals are measured as in the certificate.
    pub residual_scale: f64,
    /// Of the parts of `free_slack` that its laws see, and of the bilateral rows.
    pub velocity_scale: VelocityScale,
    /// Bilateral rows in it, ascending.
    pub bilateral: Vec<u32>,
    /// Their Jacobian over local degrees of freedom.
    pub bilateral_jacobian: SparseRows<1>,
    /// `Θ/Δt` of each.
    pub bilateral_offset: Vec<f64>,
    /// `∇Θ v^f + Θ/Δt` of each.
    pub bilateral_free_slack: Vec<f64>,
    /// `∇Θ M⁻¹ ∇Θᵀ` of each.
    pub bilateral_scale: Vec<f64>,
}

impl Island {
    /// Number of local degrees of freedom.
    pub fn nv(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// The block that holds a local degree of freedom.
    pub fn block_of(&self, dof: usize) -> usize {
        block_of(&self.starts, dof)
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

    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.starts.clear();
        self.global_starts.clear();
        self.velocity_scale = VelocityScale::default();
        self.clear_rows();
    }

    /// Leaves its blocks and its velocity scale.
    pub(super) fn clear_rows(&mut self) {
        self.units.clear();
        self.contact_count = 0;
        self.bounded_by.clear();
        self.jacobian.clear();
        self.offset.clear();
        self.free_slack.clear();
        self.scale.clear();
        self.bilateral.clear();
        self.bilateral_jacobian.clear();
        self.bilateral_offset.clear();
        self.bilateral_free_slack.clear();
        self.bilateral_scale.clear();
    }
}

/// The block that holds a degree of freedom, from the first degrees of freedom of the blocks and the total.
pub(crate) fn block_of(starts: &[usize], dof: usize) -> usize {
    starts.partition_point(|&s| s <= dof) - 1
}
