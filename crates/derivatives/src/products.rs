//! Matrices of a derivative, and products with them.

use signorini_lcp::Matrix;

use crate::columns::VelocityColumns;
use crate::matrix::{add_scaled, dot};
use crate::step::StepDerivatives;

impl StepDerivatives {
    /// `A = ∂(q⁺, v⁺)/∂(q, v)`, `[2 nv, 2 nv]`; none where the derivative is refused. Where it is one-sided it is that of the modes which
    /// the solution has.
    pub fn state_matrix(&self) -> Option<Matrix> {
        let mut out = Matrix::zeros(2 * self.nv, 2 * self.nv);
        self.has_matrices.then(|| {
            self.with_motion_columns(|columns| self.take_columns(columns, 0, true, &mut out));
            out
        })
    }

    /// `∂(q⁺, v⁺)/∂u`, `[2 nv, nu]`, as [`state_matrix`](Self::state_matrix).
    pub fn control_matrix(&self) -> Option<Matrix> {
        let mut out = Matrix::zeros(2 * self.nv, self.nu);
        self.has_matrices.then(|| {
            self.with_motion_columns(|columns| self.take_columns(columns, 2 * self.nv, false, &mut out));
            out
        })
    }

    /// `∂(q⁺, v⁺)/∂τ` by the applied generalized force, `[2 nv, nv]`, as [`state_matrix`](Self::state_matrix).
    pub fn force_matrix(&self) -> Option<Matrix> {
        let mut out = Matrix::zeros(2 * self.nv, self.nv);
        self.has_matrices.then(|| {
            let mut columns = VelocityColumns::default();
            columns.solve_forces(&self.balance, &self.system);
            self.take_columns(&columns, 0, false, &mut out);
            out
        })
    }

    /// The [state](Self::state_matrix) and the [control matrix](Self::control_matrix) into memory that is kept, `[2 nv, 2 nv]` and
    /// `[2 nv, nu]`; `false` where the derivative is refused.
    ///
    /// # Panics
    /// If a matrix has another shape.
    pub fn matrices_into(&mut self, state: &mut Matrix, control: &mut Matrix) -> bool {
        if !self.has_matrices {
            return false;
        }
        self.columns.keep_motion(&self.balance, &self.system);
        self.take_columns(&self.columns, 0, true, state);
        self.take_columns(&self.columns, 2 * self.nv, false, control);
        true
    }

    /// `∂(q⁺, v⁺)` by the parameters that [`with_parameters`](Self::with_parameters) was given, `[2 nv, directions]`.
    ///
    /// # Errors
    /// Why there is none, for the step or for one of the parameters.
    pub fn parameter_matrix(&self) -> Result<Matrix, String> {
        if let crate::Validity::Refused { reason } = self.validity() {
            return Err(reason.clone());
        }
        let missing = self.system.rows.without_slope.iter().enumerate();
        if let Some((j, reason)) = missing.into_iter().find_map(|(j, reason)| Some((j, reason.as_ref()?))) {
            return Err(format!("parameter {j}: {reason}"));
        }
        let mut out = Matrix::zeros(2 * self.nv, self.directions.len());
        let mut columns = VelocityColumns::default();
        columns.solve_parameters(self.nv, self.directions.len(), &self.system);
        self.take_columns(&columns, 0, false, &mut out);
        self.add_time(out.data_mut());
        Ok(out)
    }

    fn with_motion_columns(&self, work: impl FnOnce(&VelocityColumns)) {
        if self.columns.is_current {
            return work(&self.columns);
        }
        let mut columns = VelocityColumns::default();
        columns.keep_motion(&self.balance, &self.system);
        work(&columns);
    }

    /// `∂(q⁺, v⁺)` from columns of `∂v⁺`, from the first given on; `by_configuration`: whether they begin with those by `q`.
    fn take_columns(&self, columns: &VelocityColumns, first: usize, by_configuration: bool, out: &mut Matrix) {
        let (width, velocity) = (out.cols(), &columns.velocity);
        assert_eq!(out.rows(), 2 * self.nv, "the matrix has another shape");
        let (top, bottom) = out.data_mut().split_at_mut(self.nv * width);
        for (row, from) in bottom.chunks_exact_mut(width.max(1)).zip(velocity.data.chunks_exact(velocity.width.max(1)))
        {
            row.copy_from_slice(&from[first..first + width]);
        }
        self.integration.forward_rows(bottom, width, by_configuration, top);
    }

    /// A longer step goes on along the velocity.
    fn add_time(&self, top: &mut [f64]) {
        let width = self.directions.len();
        for (j, direction) in self.directions.iter().enumerate() {
            let share = crate::parameter::share(direction, |p| p == crate::ScalarParameter::Timestep);
            self.velocity.iter().enumerate().for_each(|(r, v)| top[r * width + j] += share * v);
        }
    }

    /// The product with a change `(δq, δv, δu, δτ)`, `[3 nv + nu]`: `(δq⁺, δv⁺)`, `[2 nv]`, without forming matrices. Nothing where the derivative
    /// is refused.
    ///
    /// # Panics
    /// If the length is another one.
    pub fn product(&self, change: &[f64]) -> Option<Vec<f64>> {
        let (nv, nu) = (self.nv, self.nu);
        assert_eq!(change.len(), 3 * nv + nu, "a change has 3 nv + nu numbers");
        if !self.has_matrices {
            return None;
        }
        let (mut velocity, slopes) = self.momentum_and_slopes(change);
        self.system.solve(&mut velocity, &slopes, &mut Vec::new());
        let mut place = vec![0.0; nv];
        self.integration.forward(&change[..nv], &velocity, &mut place);
        place.extend(velocity);
        Some(place)
    }

    /// What a change `(δq, δv, δu, δτ)` does to the balance and to the rows.
    pub(crate) fn momentum_and_slopes(&self, change: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (nv, nu, rows) = (self.nv, self.nu, &self.system.rows);
        let (dq, rest) = change.split_at(nv);
        let (dv, rest) = rest.split_at(nv);
        let (du, force) = rest.split_at(nu);
        let mut momentum = vec![0.0; nv];
        for (r, x) in momentum.iter_mut().enumerate() {
            *x -= dot(&self.balance.by_configuration[r * nv..(r + 1) * nv], dq);
            *x -= dot(&self.balance.by_velocity[r * nv..(r + 1) * nv], dv);
            *x -= dot(&self.balance.by_control[r * nu..(r + 1) * nu], du);
            *x -= dot(&self.balance.by_force[r * nv..(r + 1) * nv], force);
        }
        let slope = |i: usize| {
            let by_control = if nu > 0 { dot(rows.by_control.row(i), du) } else { 0.0 };
            dot(rows.by_configuration.row(i), dq) + dot(rows.by_velocity.row(i), dv) + by_control
        };
        (momentum, (0..rows.len()).map(slope).collect())
    }

    /// The product of the transposed derivative with the gradient of a function by `(q⁺, v⁺)`, `[2 nv]`: its gradient by `(q, v, u, τ)`
    /// and by the directions of parameters, `[3 nv + nu + directions]`, without forming matrices. Nothing where the derivative is refused.
    ///
    /// # Panics
    /// If the length is another one.
    pub fn transposed_product(&self, gradient: &[f64]) -> Option<Vec<f64>> {
        let (nv, nu, np) = (self.nv, self.nu, self.directions.len());
        assert_eq!(gradient.len(), 2 * nv, "a gradient has 2 nv numbers");
        if !self.has_matrices {
            return None;
        }
        let mut out = vec![0.0; 3 * nv + nu + np];
        let mut adjoint = gradient[nv..].to_vec();
        self.integration.backward(&gradient[..nv], &mut out[..nv], &mut adjoint);
        let multipliers = self.system.solve_transposed(&mut adjoint);
        let (dq, rest) = out.split_at_mut(nv);
        let (dv, rest) = rest.split_at_mut(nv);
        let (du, rest) = rest.split_at_mut(nu);
        let (force, parameters) = rest.split_at_mut(nv);
        for (r, a) in adjoint.iter().enumerate() {
            add_scaled(dq, -a, &self.balance.by_configuration[r * nv..(r + 1) * nv]);
            add_scaled(dv, -a, &self.balance.by_velocity[r * nv..(r + 1) * nv]);
            add_scaled(du, -a, &self.balance.by_control[r * nu..(r + 1) * nu]);
            add_scaled(force, -a, &self.balance.by_force[r * nv..(r + 1) * nv]);
        }
        let rows = &self.system.rows;
        for (i, b) in multipliers.iter().enumerate() {
            add_scaled(dq, -b, rows.by_configuration.row(i));
            add_scaled(dv, -b, rows.by_velocity.row(i));
            if nu > 0 {
                add_scaled(du, -b, rows.by_control.row(i));
            }
            if np > 0 {
                add_scaled(parameters, -b, rows.by_parameter.row(i));
            }
        }
        for (j, x) in parameters.iter_mut().enumerate() {
            *x -= dot(rows.balance_by_parameter.row(j), &adjoint);
            let share = crate::parameter::share(&self.directions[j], |p| p == crate::ScalarParameter::Timestep);
            *x += share * dot(&self.velocity, &gradient[..nv]);
        }
        Some(out)
    }
}
