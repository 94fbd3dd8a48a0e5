//! The contact problem of one time step as plain data.

use signorini_multibody::{BlockCholesky, BlockDiagonal};

use crate::ProblemError;
use crate::friction_group::{FrictionBound, FrictionGroups};
use crate::jacobian::SparseRows;
use crate::polygon::{FrictionPolygon, check_directions};
use crate::unsupported::UnsupportedFriction;

/// A direction of another length than 1 by more than this makes friction anisotropic.
const UNIT_TOLERANCE: f64 = 1e-9;

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

    /// Adds a contact: its Jacobian columns, in any order, with entries (normal, tangent 1, tangent 2), gap φ (m), friction μ, directions.
    ///
    /// Nothing is checked here; [`check`](Self::check) names what does not fit.
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

    /// Whether the circular friction cone has a law for every friction of the problem: none depends on the direction.
    ///
    /// # Errors
    /// [`UnsupportedFriction`] with the first reason.
    pub fn check_circular(&self) -> Result<(), UnsupportedFriction> {
        if let Some(contact) = (0..self.contact_count()).find(|&i| self.is_anisotropic(i)) {
            return Err(UnsupportedFriction::Anisotropic { contact });
        }
        let groups = &self.friction_groups;
        match (0..groups.len()).find(|&j| !all_of_length_one(groups.directions_of(j))) {
            Some(group) => Err(UnsupportedFriction::AnisotropicGroup { group }),
            None => Ok(()),
        }
    }

    /// Whether friction acts at contacts alone.
    pub fn check_without_groups(&self) -> Result<(), UnsupportedFriction> {
        match self.friction_groups.len() {
            0 => Ok(()),
            count => Err(UnsupportedFriction::Groups { count }),
        }
    }

    /// Whether a direction of contact `i` has another length than 1.
    pub fn is_anisotropic(&self, i: usize) -> bool {
        !all_of_length_one(self.directions_of(i))
    }

    /// Contact velocity `c_i = J_i v` as (normal, tangent 1, tangent 2), m/s.
    pub fn contact_velocity(&self, i: usize, v: &[f64]) -> [f64; 3] {
        self.jacobian.multiply(i, v)
    }
}

fn all_of_length_one(directions: &[[f64; 2]]) -> bool {
    directions.iter().all(|d| (d[0].hypot(d[1]) - 1.0).abs() <= UNIT_TOLERANCE)
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
