//! The proximal system `H = M + Σ J_cᵀ (ρ_c B_c) J_c` of one island, factorised, with rank-one updates.

use signorini_lcp::linalg::Lu;

use super::island::Island;
use super::mode::{Cones, Facet, Mode};
use crate::ContactProblem;

/// Updates kept before the matrix is factorised afresh.
const MAX_UPDATES: usize = 40;

/// `H` for the current modes: an LU factorisation and, since then, one rank-one update per change of mode
/// (Sherman–Morrison in product form).
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximalSystem {
    n: usize,
    /// `M` and the bilateral rows, dense; the same for all modes.
    base: Vec<f64>,
    lu: Lu,
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
    /// Assembles the part that no mode changes. `bilateral_weight`: ρ of every bilateral row.
    pub fn prepare(&mut self, problem: &ContactProblem, island: &Island, bilateral_weight: &[f64]) {
        let n = island.nv();
        self.n = n;
        self.base.clear();
        self.base.resize(n * n, 0.0);
        island.add_mass(&problem.mass, &mut self.base);
        for (k, &rho) in bilateral_weight.iter().enumerate() {
            let (columns, entries) = island.bilateral_jacobian.group(k);
            for (&i, a) in columns.iter().zip(entries) {
                for (&j, b) in columns.iter().zip(entries) {
                    self.base[i as usize * n + j as usize] += rho * a[0] * b[0];
                }
            }
        }
    }

    /// Factorises for the given modes; `false` if the matrix is singular.
    pub fn factor(&mut self, island: &Island, cones: &Cones, modes: &[Mode], weight: &[f64]) -> bool {
        self.updates.clear();
        self.columns.clear();
        let n = self.n;
        let h = self.lu.start(n);
        h.copy_from_slice(&self.base);
        for (c, &mode) in modes.iter().enumerate() {
            if mode == Mode::Open {
                continue;
            }
            let slope = cones.slope(island.contacts[c] as usize, mode);
            let (columns, entries) = island.jacobian.group(c);
            for (&i, a) in columns.iter().zip(entries) {
                // row = ρ (J_cᵀ B) restricted to degree of freedom i
                let row: [f64; 3] =
                    std::array::from_fn(|k| weight[c] * (a[0] * slope[0][k] + a[1] * slope[1][k] + a[2] * slope[2][k]));
                let h_row = &mut h[i as usize * n..(i as usize + 1) * n];
                for (&j, b) in columns.iter().zip(entries) {
                    h_row[j as usize] += row[0] * b[0] + row[1] * b[1] + row[2] * b[2];
                }
            }
        }
        self.lu.factorize() > 0.0
    }

    /// Whether so many updates have gathered that a fresh factorisation is due.
    pub fn is_worn(&self) -> bool {
        self.updates.len() >= MAX_UPDATES
    }

    /// Overwrites `x` with `H⁻¹ x`.
    pub fn solve(&self, island: &Island, x: &mut [f64]) {
        self.lu.solve(x);
        for (update, column) in self.updates.iter().zip(self.columns.chunks_exact(self.n)) {
            let u = island.jacobian.multiply(update.contact, x);
            let factor = update.row[0] * u[0] + update.row[1] * u[1] + update.row[2] * u[2];
            if factor != 0.0 {
                x.iter_mut().zip(column).for_each(|(x, w)| *x -= factor * w);
            }
        }
    }

    /// Lets contact `c` cross a facet: `H ← H + ρ J_cᵀ a fᵀ J_c`. Returns the column `w = H_old⁻¹ J_cᵀ a` and the ratio of
    /// the determinants `1 + ρ fᵀ J_c w`, or nothing if the new matrix is singular.
    pub fn cross(&mut self, island: &Island, c: usize, facet: &Facet, weight: f64) -> Option<(&[f64], f64)> {
        let start = self.columns.len();
        self.columns.resize(start + self.n, 0.0);
        let (known, column) = self.columns.split_at_mut(start);
        island.jacobian.add_transposed(c, facet.jump, column);
        self.lu.solve(column);
        for (update, w) in self.updates.iter().zip(known.chunks_exact(self.n)) {
            let u = island.jacobian.multiply(update.contact, column);
            let factor = update.row[0] * u[0] + update.row[1] * u[1] + update.row[2] * u[2];
            column.iter_mut().zip(w).for_each(|(x, w)| *x -= factor * w);
        }
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
