//! Derivatives of the velocity, many columns at once.

use signorini_multibody::derivatives::BalanceDerivatives;

use crate::matrix::Rows;
use crate::system::ModeSystem;

/// Derivatives of `v⁺`, a column for each number that they are by, and the storage to compute them.
#[derive(Clone, Debug, Default)]
pub(crate) struct VelocityColumns {
    /// `[nv, width]`.
    pub velocity: Rows,
    /// What the rows of the mode change by, `[rows, width]`.
    pub slopes: Rows,
    impulses: Rows,
    /// Whether they are those of the step at hand by `(q, v, u)`.
    pub is_current: bool,
}

impl VelocityColumns {
    /// Makes sure that they are `∂v⁺/∂(q, v, u)`.
    pub fn keep_motion(&mut self, balance: &BalanceDerivatives, system: &ModeSystem) {
        if self.is_current {
            return;
        }
        let (nv, rows) = (balance.impulse.len(), &system.rows);
        let nu = balance.by_control.len().checked_div(nv).unwrap_or(0);
        let width = 2 * nv + nu;
        self.velocity.shape(nv, width);
        for (k, row) in self.velocity.data.chunks_exact_mut(width.max(1)).enumerate() {
            let (place, rest) = row.split_at_mut(nv);
            let (rate, control) = rest.split_at_mut(nv);
            negate(place, &balance.by_configuration[k * nv..(k + 1) * nv]);
            negate(rate, &balance.by_velocity[k * nv..(k + 1) * nv]);
            negate(control, &balance.by_control[k * nu..(k + 1) * nu]);
        }
        self.slopes.shape(rows.len(), width);
        for (i, row) in self.slopes.data.chunks_exact_mut(width.max(1)).enumerate() {
            row[..nv].copy_from_slice(rows.by_configuration.row(i));
            row[nv..2 * nv].copy_from_slice(rows.by_velocity.row(i));
            if nu > 0 {
                row[2 * nv..].copy_from_slice(rows.by_control.row(i));
            }
        }
        system.solve_columns(&mut self.velocity, &self.slopes, &mut self.impulses);
        self.is_current = true;
    }

    /// `∂v⁺/∂τ`.
    pub fn solve_forces(&mut self, balance: &BalanceDerivatives, system: &ModeSystem) {
        let nv = balance.impulse.len();
        self.velocity.shape(nv, nv);
        negate(&mut self.velocity.data, &balance.by_force);
        self.slopes.reset(system.rows.len(), nv);
        system.solve_columns(&mut self.velocity, &self.slopes, &mut self.impulses);
    }

    /// `∂v⁺` by the directions of parameters, `count` of them.
    pub fn solve_parameters(&mut self, nv: usize, count: usize, system: &ModeSystem) {
        let rows = &system.rows;
        self.velocity.reset(nv, count);
        for j in 0..count {
            for (k, slope) in rows.balance_by_parameter.row(j).iter().enumerate() {
                self.velocity.data[k * count + j] = -slope;
            }
        }
        self.slopes.reset(rows.len(), count);
        self.slopes.data.copy_from_slice(&rows.by_parameter.data);
        system.solve_columns(&mut self.velocity, &self.slopes, &mut self.impulses);
    }
}

fn negate(out: &mut [f64], x: &[f64]) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out = -x);
}
