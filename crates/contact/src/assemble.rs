//! The complementarity problems of a contact problem: mixed (formulation §3) and standard (§4).

#![allow(non_snake_case)]

use signorini_complementarity::{Lcp, Matrix, MixedLcp, Scaling};

use crate::{ContactProblem, ProblemError};

/// Where the unknowns of a complementarity problem lie. Row order: velocity (mixed form only), bilateral, normal,
/// tangential (contacts, then friction groups), bounds (contacts, then friction groups) (formulation §5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Entries of `v⁺`; 0 in the standard form.
    pub velocity: usize,
    /// First entry of `λ_B`.
    pub bilateral: usize,
    /// First entry of `λ_N`.
    pub normal: usize,
    /// First entry of `α`.
    pub tangential: usize,
    /// First entry of the friction groups' `α`.
    pub group_tangential: usize,
    /// First entry of `β`.
    pub bounds: usize,
    /// First entry of the friction groups' `β`.
    pub group_bounds: usize,
    /// Number of unknowns.
    pub size: usize,
}

impl Layout {
    fn new(problem: &ContactProblem, velocity: usize) -> Self {
        let normal = velocity + problem.bilateral_violation.len();
        let tangential = normal + problem.contact_count();
        let group_tangential = tangential + problem.direction_count();
        let bounds = group_tangential + problem.friction_groups.direction_count();
        let group_bounds = bounds + problem.contact_count();
        let size = group_bounds + problem.friction_groups.len();
        Self { velocity, bilateral: velocity, normal, tangential, group_tangential, bounds, group_bounds, size }
    }
}

/// Consecutive rows of impulses, each made of the same two adjacent rows of the Jacobians, their bases.
struct CombinedRows {
    /// The first of the rows.
    row: usize,
    /// The first of the bases.
    base: usize,
    /// Of the first and of the second base in each row.
    weights: [Vec<f64>; 2],
}

impl CombinedRows {
    fn of_directions(row: usize, base: usize, directions: &[[f64; 2]]) -> Self {
        Self { row, base, weights: [0, 1].map(|k| directions.iter().map(|d| d[k]).collect()) }
    }
}

/// Of a row that is its first base.
const ALONE: [[f64; 2]; 1] = [[1.0, 0.0]];

/// Columns and entries of a row of the Jacobians.
type Base<'a> = (&'a [u32], Vec<f64>);

fn dot((columns, entries): &Base, x: &[f64]) -> f64 {
    columns.iter().zip(entries).map(|(&c, e)| e * x[c as usize]).sum()
}

impl ContactProblem {
    /// Layout of [`mixed_lcp`](Self::mixed_lcp).
    pub fn mixed_layout(&self) -> Layout {
        Layout::new(self, self.nv())
    }

    /// Layout of [`condensed_lcp`](Self::condensed_lcp) and, without bilateral rows, of [`standard_lcp`](Self::standard_lcp).
    pub fn standard_layout(&self) -> Layout {
        Layout::new(self, 0)
    }

    /// The mixed LCP in `(v⁺, λ_B, λ_N, α, α_F, β, β_F)` (F: friction groups): `v⁺` and `λ_B` are free (formulation §3, with the bilateral rows of §5).
    ///
    /// # Errors
    /// [`ProblemError::Lcp`] if a number is not finite.
    pub fn mixed_lcp(&self) -> Result<MixedLcp, ProblemError> {
        let at = self.mixed_layout();
        let mut A = Matrix::zeros(at.size, at.size);
        let mut b = vec![0.0; at.size];
        for (index, block) in self.mass.blocks().iter().enumerate() {
            for (k, &m) in self.mass.block_data(index).iter().enumerate() {
                A[(block.start + k / block.size, block.start + k % block.size)] = m;
            }
        }
        self.mass.multiply_into(&self.free_velocity, &mut b[..at.velocity]);
        b[..at.velocity].iter_mut().for_each(|x| *x = -*x);
        self.for_each_row(&at, |row, columns, direction| {
            for (&column, entry) in columns.iter().zip(direction) {
                A[(row, column as usize)] = *entry;
                A[(column as usize, row)] = -*entry;
            }
        });
        self.fill_constants(&at, &mut b);
        self.fill_friction(&at, &mut A);
        let free = (0..at.size).map(|i| i < at.normal).collect();
        Ok(MixedLcp::with_scaling(A, b, free, self.scaling(&at)?)?)
    }

    /// The LCP in `(λ_B, λ_N, α, α_F, β, β_F)` after elimination of `v⁺`; `λ_B` is free.
    ///
    /// # Errors
    /// [`ProblemError::Lcp`] if a number is not finite.
    pub fn condensed_lcp(&self) -> Result<MixedLcp, ProblemError> {
        let at = self.standard_layout();
        let (A, b) = self.condensed_arrays(&at);
        let free = (0..at.size).map(|i| i < at.normal).collect();
        Ok(MixedLcp::with_scaling(A, b, free, self.scaling(&at)?)?)
    }

    /// The standard LCP in `z = (λ_N, α, α_F, β, β_F)` (formulation §4; F: friction groups).
    ///
    /// # Errors
    /// [`ProblemError::Length`] if there are bilateral rows (take [`condensed_lcp`](Self::condensed_lcp) then);
    /// [`ProblemError::Lcp`] if a number is not finite.
    pub fn standard_lcp(&self) -> Result<Lcp, ProblemError> {
        let found = self.bilateral_violation.len();
        if found > 0 {
            return Err(ProblemError::Length { array: "bilateral rows of a standard LCP", expected: 0, found });
        }
        let at = self.standard_layout();
        let (A, b) = self.condensed_arrays(&at);
        Ok(Lcp::with_scaling(A, b, self.scaling(&at)?)?)
    }

    /// `J v` with the constants of `b`, of the rows of all impulses in the order of [`standard_layout`](Self::standard_layout): their
    /// `w` at the velocity that the impulses give, but for `β`.
    pub fn rates(&self, velocity: &[f64]) -> Vec<f64> {
        let at = self.standard_layout();
        let mut rates = vec![0.0; at.size];
        self.for_each_row(&at, |row, columns, entries| {
            rates[row] = columns.iter().zip(entries).map(|(&c, e)| e * velocity[c as usize]).sum();
        });
        self.fill_constants(&at, &mut rates);
        rates.truncate(at.bounds);
        rates
    }

    /// `A` and `b` with `v⁺` eliminated: `A = R M⁻¹ Rᵀ` over the rows R of all impulses, plus the friction blocks. The rows of a contact
    /// or friction group are combinations of few, of which the products are made.
    fn condensed_arrays(&self, at: &Layout) -> (Matrix, Vec<f64>) {
        let (bases, rows) = self.rows_by_base(at);
        let count = bases.len();
        // The second base of the last rows may be one that is not there.
        let mut products = vec![0.0; (count + 1) * (count + 1)];
        let mut rates = vec![0.0; count + 1];
        let mut column = vec![0.0; self.nv()];
        for (j, source) in bases.iter().enumerate() {
            column.fill(0.0);
            source.0.iter().zip(&source.1).for_each(|(&c, e)| column[c as usize] = *e);
            self.mass_factor.solve_in_place(&mut column);
            for (i, target) in bases.iter().enumerate().skip(j) {
                let product = dot(target, &column);
                products[i * (count + 1) + j] = product;
                products[j * (count + 1) + i] = product;
            }
            rates[j] = dot(source, &self.free_velocity);
        }
        let mut A = Matrix::zeros(at.size, at.size);
        let mut b = vec![0.0; at.size];
        let mut combined = vec![0.0; count + 1];
        for targets in &rows {
            let (start, next) = (targets.base * (count + 1), (targets.base + 1) * (count + 1));
            for (k, (&first, &second)) in targets.weights[0].iter().zip(&targets.weights[1]).enumerate() {
                let row = targets.row + k;
                let pairs = products[start..next].iter().zip(&products[next..next + count + 1]);
                combined.iter_mut().zip(pairs).for_each(|(x, (a, b))| *x = first * a + second * b);
                let entries = &mut A.data_mut()[row * at.size..][..at.size];
                for sources in &rows {
                    let (first, second) = (combined[sources.base], combined[sources.base + 1]);
                    let [a, b] = &sources.weights;
                    let entries = entries[sources.row..].iter_mut().zip(a.iter().zip(b));
                    entries.for_each(|(entry, (a, b))| *entry = a * first + b * second);
                }
                b[row] = first * rates[targets.base] + second * rates[targets.base + 1];
            }
        }
        self.fill_constants(at, &mut b);
        self.fill_friction(at, &mut A);
        (A, b)
    }

    /// The rows of all impulses, in their order: which combinations they are of which rows of the Jacobians.
    fn rows_by_base(&self, at: &Layout) -> (Vec<Base<'_>>, Vec<CombinedRows>) {
        let (mut bases, mut rows) = (Vec::new(), Vec::new());
        for k in 0..self.bilateral_violation.len() {
            let (columns, group) = self.bilateral_jacobian.group(k);
            rows.push(CombinedRows::of_directions(at.bilateral + k, bases.len(), &ALONE));
            bases.push((columns, group.iter().map(|e| e[0]).collect()));
        }
        for i in 0..self.contact_count() {
            let (columns, group) = self.jacobian.group(i);
            rows.push(CombinedRows::of_directions(at.normal + i, bases.len(), &ALONE));
            bases.push((columns, group.iter().map(|e| e[0]).collect()));
        }
        for i in 0..self.contact_count() {
            let (columns, group) = self.jacobian.group(i);
            let directions = self.directions_of(i);
            if !directions.is_empty() {
                let row = at.tangential + self.direction_offsets[i];
                rows.push(CombinedRows::of_directions(row, bases.len(), directions));
                bases.extend((1..3).map(|r| (columns, group.iter().map(|e| e[r]).collect())));
            }
        }
        for j in 0..self.friction_groups.len() {
            let (columns, group) = self.friction_groups.jacobian.group(j);
            let row = at.group_tangential + self.friction_groups.direction_range(j).start;
            rows.push(CombinedRows::of_directions(row, bases.len(), self.friction_groups.directions_of(j)));
            bases.extend((0..2).map(|r| (columns, group.iter().map(|e| e[r]).collect())));
        }
        (bases, rows)
    }

    /// Calls `visit(row, columns, entries)` for the Jacobian row of every impulse: bilateral, normal, tangential.
    fn for_each_row(&self, at: &Layout, mut visit: impl FnMut(usize, &[u32], &[f64])) {
        let mut entries = Vec::new();
        for k in 0..self.bilateral_violation.len() {
            let (columns, group) = self.bilateral_jacobian.group(k);
            entries.clear();
            entries.extend(group.iter().map(|e| e[0]));
            visit(at.bilateral + k, columns, &entries);
        }
        for i in 0..self.contact_count() {
            let (columns, group) = self.jacobian.group(i);
            entries.clear();
            entries.extend(group.iter().map(|e| e[0]));
            visit(at.normal + i, columns, &entries);
            for (k, d) in self.directions_of(i).iter().enumerate() {
                entries.clear();
                entries.extend(group.iter().map(|e| d[0] * e[1] + d[1] * e[2]));
                visit(at.tangential + self.direction_offsets[i] + k, columns, &entries);
            }
        }
        for j in 0..self.friction_groups.len() {
            let (columns, group) = self.friction_groups.jacobian.group(j);
            for (k, d) in self.friction_groups.direction_range(j).zip(self.friction_groups.directions_of(j)) {
                entries.clear();
                entries.extend(group.iter().map(|e| d[0] * e[0] + d[1] * e[1]));
                visit(at.group_tangential + k, columns, &entries);
            }
        }
    }

    /// Adds `φ/Δt`, `Θ/Δt`, `−Dᵀu` and the constant bounds.
    fn fill_constants(&self, at: &Layout, b: &mut [f64]) {
        for (k, theta) in self.bilateral_violation.iter().enumerate() {
            b[at.bilateral + k] += theta / self.timestep;
        }
        for (i, phi) in self.gap.iter().enumerate() {
            b[at.normal + i] += phi / self.timestep;
        }
        let groups = &self.friction_groups;
        for (j, (u, bound)) in groups.target.iter().zip(&groups.bound).enumerate() {
            for (k, d) in groups.direction_range(j).zip(groups.directions_of(j)) {
                b[at.group_tangential + k] -= d[0] * u[0] + d[1] * u[1];
            }
            b[at.group_bounds + j] = bound.constant();
        }
    }

    /// The blocks `E`, `M_μ`, `−Eᵀ`, of contacts and of friction groups.
    fn fill_friction(&self, at: &Layout, A: &mut Matrix) {
        for i in 0..self.contact_count() {
            A[(at.bounds + i, at.normal + i)] = self.friction[i];
            for k in self.direction_offsets[i]..self.direction_offsets[i + 1] {
                A[(at.tangential + k, at.bounds + i)] = 1.0;
                A[(at.bounds + i, at.tangential + k)] = -1.0;
            }
        }
        for (j, bound) in self.friction_groups.bound.iter().enumerate() {
            if let Some((contact, coefficient)) = bound.normal() {
                A[(at.group_bounds + j, at.normal + contact)] = coefficient;
            }
            for k in self.friction_groups.direction_range(j) {
                A[(at.group_tangential + k, at.group_bounds + j)] = 1.0;
                A[(at.group_bounds + j, at.group_tangential + k)] = -1.0;
            }
        }
    }

    /// One unit for all rows (formulation §8): impulses times `g`, the residuals of the bounds times `g`, and momentum rows
    /// divided by `max|M|`.
    fn scaling(&self, at: &Layout) -> Result<Scaling, ProblemError> {
        let g = self.delassus_scale();
        let g = if g > 0.0 { g } else { 1.0 };
        let mass = self.mass.data().iter().fold(0.0, |a: f64, m| a.max(m.abs()));
        let kind = |i: usize, velocity: f64, impulse: f64, bound: f64| {
            if i < at.velocity {
                velocity
            } else if i < at.bounds {
                impulse
            } else {
                bound
            }
        };
        let z = (0..at.size).map(|i| kind(i, 1.0, g, 1.0)).collect();
        let w = (0..at.size).map(|i| kind(i, 1.0 / mass, 1.0, g)).collect();
        Ok(Scaling::new(z, w)?)
    }
}
