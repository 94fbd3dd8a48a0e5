//! The contact problem of one time step as plain data.

use signorini_multibody::{BlockCholesky, BlockDiagonal};

use crate::ProblemError;
use crate::friction_group::{FrictionBound, FrictionGroups};
use crate::jacobian::SparseRows;
use crate::polygon::{FrictionPolygon, check_directions};

/// Up to as many rows of a block of the mass matrix are solved with all columns of a contact together, on the stack: free bodies
/// and robots. A power of two, so that they are cleared quickly.
const FEW_ROWS: usize = 32;

/// Everything the formulation needs for one step: `M`, `v^f`, `Δt`, and for each contact `J_N`, `J_T`, `φ`, `μ`, `D`; for
/// each bilateral row its Jacobian and `Θ`, for each friction group its Jacobian, target, bound and `D` (formulation §§1–5).
///
/// Plain data: it can be saved, loaded, solved by any method and checked by a separate program. Sizes: `nv` degrees of
/// freedom, `nc` contacts, `nb` bilateral rows, `m` friction directions in all.
#[derive(Clone, Debug)]
pub struct ContactProblem {
    /// Mass matrix `M`, `[nv, nv]`, symmetric positive definite, one block per kinematic tree; kg, kg·m, kg·m².
    pub mass: BlockDiagonal,
    /// Cholesky factor of `mass`.
    pub mass_factor: BlockCholesky,
    /// Free velocity `v^f`, `[nv]`, m/s or rad/s.
    pub free_velocity: Vec<f64>,
    /// Time step Δt, s.
    pub timestep: f64,
    /// Contact Jacobian: group i holds row i of `J_N` and rows 2i, 2i+1 of `J_T`.
    pub jacobian: SparseRows<3>,
    /// Gaps φ, `[nc]`, m.
    pub gap: Vec<f64>,
    /// Coefficients of friction μ, `[nc]`.
    pub friction: Vec<f64>,
    /// Friction directions `D`, contact after contact, `[m]`.
    pub directions: Vec<[f64; 2]>,
    /// Where each contact's directions begin in `directions`, `[nc + 1]`.
    pub direction_offsets: Vec<usize>,
    /// Jacobian of the bilateral rows, `∇Θ`.
    pub bilateral_jacobian: SparseRows<1>,
    /// Violation Θ of each bilateral row at `q_t`, `[nb]`, m or rad.
    pub bilateral_violation: Vec<f64>,
    /// Friction apart from the tangents of contacts.
    pub friction_groups: FrictionGroups,
}

/// Part of its terms below which a sum is taken for rounding.
pub(crate) const CANCELLATION: f64 = 1e-7;

impl ContactProblem {
    /// A problem without contacts.
    ///
    /// # Errors
    /// [`ProblemError::Mass`] if `mass` is not positive definite, [`ProblemError::Length`] or
    /// [`ProblemError::Number`] if `free_velocity` or `timestep` do not fit.
    pub fn new(mass: BlockDiagonal, free_velocity: Vec<f64>, timestep: f64) -> Result<Self, ProblemError> {
        let mass_factor = mass.factor()?;
        let problem = Self {
            mass,
            mass_factor,
            free_velocity,
            timestep,
            jacobian: SparseRows::default(),
            gap: Vec::new(),
            friction: Vec::new(),
            directions: Vec::new(),
            direction_offsets: vec![0],
            bilateral_jacobian: SparseRows::default(),
            bilateral_violation: Vec::new(),
            friction_groups: FrictionGroups::default(),
        };
        problem.check()?;
        Ok(problem)
    }

    /// Degrees of freedom.
    pub fn nv(&self) -> usize {
        self.free_velocity.len()
    }

    /// Number of contacts.
    pub fn contact_count(&self) -> usize {
        self.gap.len()
    }

    /// Number of friction directions of all contacts, `m`.
    pub fn direction_count(&self) -> usize {
        self.directions.len()
    }

    /// The directions of contact `i`.
    pub fn directions_of(&self, i: usize) -> &[[f64; 2]] {
        &self.directions[self.direction_offsets[i]..self.direction_offsets[i + 1]]
    }

    /// Removes contacts, bilateral rows and friction groups and keeps the memory.
    pub fn clear_contacts(&mut self) {
        self.jacobian.clear();
        self.gap.clear();
        self.friction.clear();
        self.directions.clear();
        self.direction_offsets.clear();
        self.direction_offsets.push(0);
        self.bilateral_jacobian.clear();
        self.bilateral_violation.clear();
        self.friction_groups.clear();
    }

    /// Adds a contact: its Jacobian columns with entries (normal, tangent 1, tangent 2), gap φ (m), friction μ, directions.
    pub fn push_contact(
        &mut self,
        columns: impl IntoIterator<Item = (u32, [f64; 3])>,
        gap: f64,
        friction: f64,
        polygon: &FrictionPolygon,
    ) {
        self.jacobian.push(columns);
        self.gap.push(gap);
        self.friction.push(friction);
        self.directions.extend_from_slice(polygon.directions());
        self.direction_offsets.push(self.directions.len());
    }

    /// Adds a bilateral row `∇Θ v⁺ + Θ/Δt = 0`: its columns with entries, and Θ (m or rad).
    pub fn push_bilateral(&mut self, columns: impl IntoIterator<Item = (u32, [f64; 1])>, violation: f64) {
        self.bilateral_jacobian.push(columns);
        self.bilateral_violation.push(violation);
    }

    /// Adds a friction group (see [`FrictionGroups`]) in two generalized directions.
    ///
    /// - `columns`: Jacobian columns with the entries of both rows
    /// - `target`: the velocity that the group pulls towards, m/s or rad/s
    /// - `bound`: of the impulse; a contact that it names may be added later
    /// - `polygon`: the directions
    pub fn push_friction(
        &mut self,
        columns: impl IntoIterator<Item = (u32, [f64; 2])>,
        target: [f64; 2],
        bound: FrictionBound,
        polygon: &FrictionPolygon,
    ) {
        self.friction_groups.push(columns, target, bound, polygon);
    }

    /// Adds a friction group in one generalized direction, with the directions ±1; see
    /// [`push_friction`](Self::push_friction).
    pub fn push_friction_row(
        &mut self,
        columns: impl IntoIterator<Item = (u32, f64)>,
        target: f64,
        bound: FrictionBound,
    ) {
        let columns = columns.into_iter().map(|(column, entry)| (column, [entry, 0.0]));
        self.friction_groups.push_line(columns, target, bound);
    }

    /// Gives every frictional contact `count` equally spaced directions, its first direction kept.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] if `count` is odd or zero, or if the friction of a contact is anisotropic.
    pub fn with_directions(&self, count: usize) -> Result<Self, ProblemError> {
        let mut other = self.clone();
        other.directions.clear();
        other.direction_offsets = vec![0];
        for i in 0..self.contact_count() {
            if let Some(first) = self.directions_of(i).first() {
                if self.is_anisotropic(i) {
                    let reason = "only friction that is the same in all directions has another polygon".into();
                    return Err(ProblemError::Directions { contact: Some(i), reason });
                }
                let polygon = FrictionPolygon::regular(count, first[1].atan2(first[0]))?;
                other.directions.extend_from_slice(polygon.directions());
            }
            other.direction_offsets.push(other.directions.len());
        }
        Ok(other)
    }

    /// Checks sizes, ranges, finiteness and directions.
    ///
    /// # Errors
    /// The first [`ProblemError`] met; every variant names the array and index.
    pub fn check(&self) -> Result<(), ProblemError> {
        let (nv, nc) = (self.nv(), self.contact_count());
        length("mass", self.mass.dimension(), nv)?;
        length("mu", self.friction.len(), nc)?;
        length("J_N", self.jacobian.len(), nc)?;
        length("directions per contact", self.direction_offsets.len(), nc + 1)?;
        length("Theta", self.bilateral_violation.len(), self.bilateral_jacobian.len())?;
        number("dt", 0, self.timestep, "positive and finite", |x| x > 0.0)?;
        numbers("v_free", &self.free_velocity, "finite", |_| true)?;
        numbers("phi", &self.gap, "finite", |_| true)?;
        numbers("mu", &self.friction, "finite and not negative", |x| x >= 0.0)?;
        numbers("Theta", &self.bilateral_violation, "finite", |_| true)?;
        check_rows(&self.jacobian, nv)?;
        check_rows(&self.bilateral_jacobian, nv)?;
        check_rows(&self.friction_groups.jacobian, nv)?;
        for i in 0..nc {
            check_directions(self.directions_of(i))
                .map_err(|reason| ProblemError::Directions { contact: Some(i), reason })?;
        }
        self.check_groups()
    }

    fn check_groups(&self) -> Result<(), ProblemError> {
        let groups = &self.friction_groups;
        length("groups of J_F", groups.jacobian.len(), groups.len())?;
        length("u_F", groups.target.len(), groups.len())?;
        length("directions per friction group", groups.direction_offsets.len(), groups.len() + 1)?;
        for (j, target) in groups.target.iter().enumerate() {
            target.iter().try_for_each(|&u| number("u_F", j, u, "finite", |_| true))?;
            let constant = groups.bound[j].constant();
            number("bound of a friction group", j, constant, "finite and not negative", |r| r >= 0.0)?;
            if let Some((contact, coefficient)) = groups.bound[j].normal() {
                number("coefficient of a friction group", j, coefficient, "finite and not negative", |c| c >= 0.0)?;
                let nc = self.contact_count();
                number("contact of a friction group", j, contact as f64, "one of the contacts", |_| contact < nc)?;
            }
            check_directions(groups.directions_of(j))
                .map_err(|reason| ProblemError::GroupDirections { group: j, reason })?;
        }
        Ok(())
    }

    /// Contact velocity `c_i = J_i v` as (normal, tangent 1, tangent 2), m/s.
    pub fn contact_velocity(&self, i: usize, v: &[f64]) -> [f64; 3] {
        self.jacobian.multiply(i, v)
    }

    /// `g`: the largest diagonal entry of `J M⁻¹ Jᵀ` over the rows of contacts and friction groups, 1/kg; 0 without any.
    pub fn delassus_scale(&self) -> f64 {
        let mut column = vec![0.0; self.nv()];
        self.delassus_scale_with(&mut column)
    }

    /// [`delassus_scale`](Self::delassus_scale) without memory of its own; `scratch` as in
    /// [`delassus_diagonal`](Self::delassus_diagonal).
    pub(crate) fn delassus_scale_with(&self, scratch: &mut [f64]) -> f64 {
        let mut scale = 0.0_f64;
        for i in 0..self.contact_count() {
            let (columns, entries) = self.jacobian.group(i);
            scale = scale.max(self.largest_delassus_entry(columns, entries, scratch));
        }
        for j in 0..self.friction_groups.len() {
            let (columns, entries) = self.friction_groups.jacobian.group(j);
            scale = scale.max(self.largest_delassus_entry(columns, entries, scratch));
        }
        scale
    }

    /// The diagonal of contact `i`'s block of `J M⁻¹ Jᵀ`. `scratch`: `[nv]`, all zero before and after.
    ///
    /// # Cost
    /// Three half solves with each block of the mass matrix that the contact touches.
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
        let mut diagonal = [0.0; R];
        let mut first = 0;
        while first < columns.len() {
            let index = self.mass.block_of(columns[first] as usize);
            let range = self.mass.blocks()[index].range();
            let last = first + columns[first..].partition_point(|&c| range.contains(&(c as usize)));
            if range.len() == 1 {
                let mut unit = [1.0];
                self.mass_factor.half_solve_block_in_place(index, &mut unit);
                diagonal.iter_mut().zip(entries[first]).for_each(|(sum, e)| *sum += (e * unit[0]) * (e * unit[0]));
                first = last;
                continue;
            }
            for (r, sum) in diagonal.iter_mut().enumerate() {
                for k in first..last {
                    scratch[columns[k] as usize] = entries[k][r];
                }
                let x = &mut scratch[range.clone()];
                self.mass_factor.half_solve_block_in_place(index, x);
                *sum += x.iter().map(|x| x * x).sum::<f64>();
                x.fill(0.0);
            }
            first = last;
        }
        diagonal
    }

    /// The largest of [`delassus_entries`](Self::delassus_entries), by half a solve with all columns together where a block
    /// has few rows.
    fn largest_delassus_entry<const R: usize>(
        &self,
        columns: &[u32],
        entries: &[[f64; R]],
        scratch: &mut [f64],
    ) -> f64 {
        let mut diagonal = [0.0; R];
        let mut first = 0;
        while first < columns.len() {
            let index = self.mass.block_of(columns[first] as usize);
            let range = self.mass.blocks()[index].range();
            let last = first + columns[first..].partition_point(|&c| range.contains(&(c as usize)));
            let rows = columns[last - 1] as usize + 1 - range.start;
            if rows > FEW_ROWS {
                return self.delassus_entries(columns, entries, scratch).into_iter().fold(0.0, f64::max);
            }
            let mut together = [[0.0; R]; FEW_ROWS];
            for (column, entry) in columns[first..last].iter().zip(&entries[first..last]) {
                together[*column as usize - range.start] = *entry;
            }
            self.mass_factor.half_solve_block(index, &mut together[..rows]);
            for row in &together[..rows] {
                diagonal.iter_mut().zip(row).for_each(|(sum, y)| *sum += y * y);
            }
            first = last;
        }
        diagonal.into_iter().fold(0.0, f64::max)
    }

    /// `s_v = max|b|`, the data's velocity scale (formulation §8), m/s. Constant bounds of friction groups, which are impulses,
    /// are not in it: a bound that is never reached does not loosen the residuals.
    ///
    /// At least 1e-7 of the terms that add up to `J v^f`: where bodies move together these cancel, and a smaller scale would
    /// compare rounding with rounding.
    pub fn velocity_scale(&self) -> f64 {
        let (v, groups) = (&self.free_velocity, &self.friction_groups);
        let (mut scale, mut terms) = (0.0_f64, 0.0_f64);
        for i in 0..self.contact_count() {
            let [c_n, c_1, c_2] = self.contact_velocity(i, v);
            scale = scale.max((c_n + self.gap[i] / self.timestep).abs());
            for d in self.directions_of(i) {
                scale = scale.max((d[0] * c_1 + d[1] * c_2).abs());
            }
            terms = terms.max(self.jacobian.largest_terms(i, v));
        }
        for (k, theta) in self.bilateral_violation.iter().enumerate() {
            let [rate] = self.bilateral_jacobian.multiply(k, v);
            scale = scale.max((rate + theta / self.timestep).abs());
            terms = terms.max(self.bilateral_jacobian.largest_terms(k, v));
        }
        for j in 0..groups.len() {
            let [s_1, s_2] = groups.slip(j, v);
            for d in groups.directions_of(j) {
                scale = scale.max((d[0] * s_1 + d[1] * s_2).abs());
            }
            terms = terms.max(groups.jacobian.largest_terms(j, v));
        }
        scale.max(CANCELLATION * terms)
    }
}

fn check_rows<const R: usize>(rows: &SparseRows<R>, nv: usize) -> Result<(), ProblemError> {
    if let Some((row, column)) = rows.column_beyond(nv) {
        return Err(ProblemError::Column { row, column, nv });
    }
    if let Some((row, column)) = rows.column_out_of_order() {
        return Err(ProblemError::ColumnOrder { row, column });
    }
    match rows.not_finite() {
        Some((index, value)) => Err(ProblemError::Number { array: "J", index, value, expected: "finite" }),
        None => Ok(()),
    }
}

fn length(array: &'static str, found: usize, expected: usize) -> Result<(), ProblemError> {
    if found == expected { Ok(()) } else { Err(ProblemError::Length { array, expected, found }) }
}

fn number(
    array: &'static str,
    index: usize,
    value: f64,
    expected: &'static str,
    ok: impl Fn(f64) -> bool,
) -> Result<(), ProblemError> {
    if value.is_finite() && ok(value) { Ok(()) } else { Err(ProblemError::Number { array, index, value, expected }) }
}

fn numbers(
    array: &'static str,
    values: &[f64],
    expected: &'static str,
    ok: impl Fn(f64) -> bool + Copy,
) -> Result<(), ProblemError> {
    values.iter().enumerate().try_for_each(|(i, &x)| number(array, i, x, expected, ok))
}
