//! The scales of a problem's data: its Delassus diagonal and its velocities.

use signorini_multibody::FEW_ROWS;

use crate::ContactProblem;
#[doc(hidden)]
pub use crate::lists::raise;

/// Rows of the block of a free body.
pub const FREE_ROWS: usize = 6;

/// Part of its terms below which a sum is no scale: what is left of a velocity is told to its last five digits by 1e-9 of this part.
const CANCELLATION: f64 = 1e-6;

impl ContactProblem {
    /// `g`: the largest diagonal entry of `J M⁻¹ Jᵀ` over the rows of contacts and friction groups, 1/kg; 0 without any.
    pub fn delassus_scale(&self) -> f64 {
        let mut column = vec![0.0; self.nv()];
        self.delassus_scale_with(&mut column)
    }

    /// [`delassus_scale`](Self::delassus_scale) without memory of its own; `scratch` as in
    /// [`delassus_diagonal`](Self::delassus_diagonal).
    pub fn delassus_scale_with(&self, scratch: &mut [f64]) -> f64 {
        let mut scale = 0.0_f64;
        for i in 0..self.contact_count() {
            let (columns, entries) = self.jacobian.group(i);
            scale = scale.max(largest(self.delassus_entries(columns, entries, scratch)));
        }
        for j in 0..self.friction_groups.len() {
            let (columns, entries) = self.friction_groups.jacobian.group(j);
            scale = scale.max(largest(self.delassus_entries(columns, entries, scratch)));
        }
        scale
    }

    /// The diagonal of contact `i`'s block of `J M⁻¹ Jᵀ`. `scratch`: `[nv]`, all zero before and after.
    ///
    /// # Cost
    /// Half a solve with each block of the mass matrix that the contact touches, on the ways to the root; three in blocks of more
    /// than [`FEW_ROWS`] rows.
    pub fn delassus_diagonal(&self, i: usize, scratch: &mut [f64]) -> [f64; 3] {
        let (columns, entries) = self.jacobian.group(i);
        self.delassus_entries(columns, entries, scratch)
    }

    /// `∇Θ_k M⁻¹ ∇Θ_kᵀ` of bilateral row `k`. `scratch` as in [`delassus_diagonal`](Self::delassus_diagonal).
    pub fn bilateral_delassus(&self, k: usize, scratch: &mut [f64]) -> f64 {
        let (columns, entries) = self.bilateral_jacobian.group(k);
        self.delassus_entries(columns, entries, scratch)[0]
    }

    /// The diagonal of friction group `j`'s block of `J M⁻¹ Jᵀ`. `scratch` as in
    /// [`delassus_diagonal`](Self::delassus_diagonal).
    pub fn group_delassus(&self, j: usize, scratch: &mut [f64]) -> [f64; 2] {
        let (columns, entries) = self.friction_groups.jacobian.group(j);
        self.delassus_entries(columns, entries, scratch)
    }

    fn delassus_entries<const R: usize>(&self, columns: &[u32], entries: &[[f64; R]], scratch: &mut [f64]) -> [f64; R] {
        if let Some(diagonal) = self.mass_factor.inverse_squares_if_diagonal(columns, entries) {
            return diagonal;
        }
        if let (&[first, .., last], FREE_ROWS) = (columns, columns.len())
            && last as usize - first as usize == FREE_ROWS - 1
        {
            // Mostly all of a free body and nothing else.
            let index = self.mass.block_of(first as usize);
            let block = self.mass.blocks()[index];
            if block.start == first as usize && block.size == FREE_ROWS {
                return self.mass_factor.inverse_squares_of_block(index, entries);
            }
        }
        self.delassus_in_blocks(columns, entries, scratch, |_| true)
    }

    /// The diagonal of `Y M⁻¹ Yᵀ` for `R` rows in the same columns, of which those in blocks of the mass matrix that are `seen` count.
    /// `scratch` as in [`delassus_diagonal`](Self::delassus_diagonal).
    #[doc(hidden)]
    pub fn delassus_in_blocks<const R: usize>(
        &self,
        columns: &[u32],
        entries: &[[f64; R]],
        scratch: &mut [f64],
        seen: impl Fn(usize) -> bool,
    ) -> [f64; R] {
        let mut diagonal = [0.0; R];
        let mut first = 0;
        while first < columns.len() {
            let index = self.mass.block_of(columns[first] as usize);
            let range = self.mass.blocks()[index].range();
            let mut last = first + 1;
            while last < columns.len() && (columns[last] as usize) < range.end {
                last += 1;
            }
            let (own, own_entries) = (&columns[first..last], &entries[first..last]);
            first = last;
            if !seen(index) {
                continue;
            }
            let squares = if range.len() <= FREE_ROWS && range.len() == own.len() {
                self.mass_factor.inverse_squares_of_block(index, own_entries)
            } else if range.len() <= FEW_ROWS {
                // What holds the columns is zeroed each time.
                if own.len() <= FEW_ROWS / 4 {
                    self.squares_on_paths::<R, { FEW_ROWS / 4 }>(index, range.start, own, own_entries)
                } else {
                    self.squares_on_paths::<R, FEW_ROWS>(index, range.start, own, own_entries)
                }
            } else {
                self.squares_one_by_one(index, range, own, own_entries, scratch)
            };
            diagonal.iter_mut().zip(squares).for_each(|(sum, s)| *sum += s);
        }
        diagonal
    }

    /// The part of one block of the mass matrix, on the ways to the root; of at most `MOST` columns.
    fn squares_on_paths<const R: usize, const MOST: usize>(
        &self,
        block: usize,
        start: usize,
        columns: &[u32],
        entries: &[[f64; R]],
    ) -> [f64; R] {
        let mut rows = [0; MOST];
        let rows = &mut rows[..columns.len()];
        rows.iter_mut().zip(columns).for_each(|(row, &column)| *row = column as usize - start);
        // The limit of a joint has a normal alone.
        if entries.iter().all(|entry| entry[1..].iter().all(|x| *x == 0.0)) {
            let mut normal = [[0.0]; MOST];
            let normal = &mut normal[..columns.len()];
            normal.iter_mut().zip(entries).for_each(|(x, entry)| x[0] = entry[0]);
            let [square] = self.mass_factor.inverse_squares(block, rows, normal);
            return std::array::from_fn(|r| if r == 0 { square } else { 0.0 });
        }
        self.mass_factor.inverse_squares(block, rows, entries)
    }

    /// The same, column by column, in `scratch`.
    fn squares_one_by_one<const R: usize>(
        &self,
        block: usize,
        range: std::ops::Range<usize>,
        columns: &[u32],
        entries: &[[f64; R]],
        scratch: &mut [f64],
    ) -> [f64; R] {
        let (Some(&first), Some(&last)) = (columns.first(), columns.last()) else { return [0.0; R] };
        let (first, rows) = (first as usize - range.start, range.start..last as usize + 1);
        std::array::from_fn(|r| {
            // Limits and the friction of joints have one row alone.
            if entries.iter().all(|entry| entry[r] == 0.0) {
                return 0.0;
            }
            for (&column, entry) in columns.iter().zip(entries) {
                scratch[column as usize] = entry[r];
            }
            let x = &mut scratch[rows.clone()];
            let square = self.mass_factor.inverse_square(block, first, x);
            x.fill(0.0);
            square
        })
    }

    /// `s_v = max|b|`, the data's velocity scale (formulation §8), m/s. Constant bounds of friction groups, which are impulses,
    /// are not in it: a bound that is never reached does not loosen the residuals.
    ///
    /// At least 1e-6 of the terms that add up to `J v^f`: where bodies move together these cancel, and a smaller scale would
    /// compare rounding with rounding. In the terms of bilateral rows a coordinate counts at least as much as its tree's fastest one does in the
    /// metric of the mass matrix: where a tree falls as a whole, the velocities of its joints are rounding, too.
    pub fn velocity_scale(&self) -> f64 {
        let mut scale = VelocityScale::default();
        for i in 0..self.contact_count() {
            scale.add_contact(self, i);
        }
        for k in 0..self.bilateral_violation.len() {
            scale.add_bilateral(self, k);
        }
        for j in 0..self.friction_groups.len() {
            scale.add_group(self, j);
        }
        scale.value()
    }
}

/// The largest entry of `b` and the largest sum of terms in it, of the rows so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityScale {
    /// The largest entry, m/s.
    pub largest: f64,
    /// The largest sum of absolute terms, m/s.
    pub terms: f64,
}

impl VelocityScale {
    /// `s_v` of the rows so far.
    pub fn value(&self) -> f64 {
        self.largest.max(CANCELLATION * self.terms)
    }

    /// Takes in a velocity that its terms, the largest sum of which is given, add up to.
    pub fn add(&mut self, velocity: f64, terms: f64) {
        raise(&mut self.largest, velocity.abs());
        raise(&mut self.terms, terms);
    }

    /// Takes in contact `i`; returns `J_i v^f + (φ/Δt, 0, 0)` and its terms.
    pub fn add_contact(&mut self, problem: &ContactProblem, i: usize) -> ([f64; 3], f64) {
        let (mut u, terms) = problem.jacobian.multiply_with_terms(i, &problem.free_velocity);
        u[0] += problem.gap[i] / problem.timestep;
        self.add(u[0], terms);
        for d in problem.directions_of(i) {
            raise(&mut self.largest, (d[0] * u[1] + d[1] * u[2]).abs());
        }
        (u, terms)
    }

    /// Takes in bilateral row `k`; returns `∇Θ_k v^f + Θ_k/Δt` and its terms.
    pub fn add_bilateral(&mut self, problem: &ContactProblem, k: usize) -> (f64, f64) {
        let [rate] = problem.bilateral_jacobian.multiply(k, &problem.free_velocity);
        let terms = bilateral_terms(problem, k);
        let u = rate + problem.bilateral_violation[k] / problem.timestep;
        self.add(u, terms);
        (u, terms)
    }

    /// Takes in friction group `j`; returns `J_j v^f − u_F` and its terms.
    pub fn add_group(&mut self, problem: &ContactProblem, j: usize) -> ([f64; 2], f64) {
        let groups = &problem.friction_groups;
        let ([a, b], terms) = groups.jacobian.multiply_with_terms(j, &problem.free_velocity);
        raise(&mut self.terms, terms);
        let slip = [a - groups.target[j][0], b - groups.target[j][1]];
        for d in groups.directions_of(j) {
            raise(&mut self.largest, (d[0] * slip[0] + d[1] * slip[1]).abs());
        }
        (slip, terms)
    }
}

/// `Σ_b Σ_{j∈b} |J_kj| max_{i∈b} √(M_ii/M_jj) |v^f_i|` of bilateral row `k` over the trees `b`, m/s.
fn bilateral_terms(problem: &ContactProblem, k: usize) -> f64 {
    let (mass, velocity) = (&problem.mass, &problem.free_velocity);
    let (columns, entries) = problem.bilateral_jacobian.group(k);
    let of_tree = |(block, part): (usize, std::ops::Range<usize>)| {
        // One root for a column and none for the others: there are many rows to a tree.
        let mut most = 0.0;
        mass.blocks()[block].range().for_each(|i| raise(&mut most, mass.get(i, i) * velocity[i] * velocity[i]));
        let own = columns[part.clone()].iter().zip(&entries[part]);
        own.map(|(&j, [entry])| entry.abs() * (most / mass.get(j as usize, j as usize)).sqrt()).sum::<f64>()
    };
    mass.blocks_touched(columns).map(of_tree).sum()
}

/// The largest entry of the diagonal of a Delassus block, at least 0.
pub fn largest<const R: usize>(diagonal: [f64; R]) -> f64 {
    let mut largest = 0.0;
    diagonal.iter().for_each(|x| raise(&mut largest, *x));
    largest
}
