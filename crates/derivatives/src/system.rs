//! The linear system of a mode, solved.

use signorini_multibody::BlockCholesky;

use crate::matrix::{Rows, add_scaled, dot, largest};
use crate::reduced::Reduced;
use crate::rows::ModeRows;
use crate::validity::InequalitySource;

/// Impulses that cancel leave no more velocity than this part of what each of them gives.
const CANCELS: f64 = 1e-7;

/// `[M̂ −N; C 0]` brought to its independent rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModeSystem {
    pub rows: ModeRows,
    factor: Option<BlockCholesky>,
    /// `M̂⁻¹ N`, one row per column of `N`.
    responses: Rows,
    schur: Rows,
    reduced: Reduced,
}

/// The velocity that a system gives per unit of momentum, `[nv, nv]`, and per unit of what its rows change by, a row of `[nv]` each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gain {
    pub by_momentum: Rows,
    pub by_rows: Rows,
    work: Rows,
    unit: Vec<f64>,
    scratch: Vec<f64>,
}

impl ModeSystem {
    /// Brings the rows at hand to the independent ones.
    ///
    /// - `factor`: of `M̂`
    ///
    /// # Errors
    /// Why the velocity has no derivative.
    pub fn reduce(&mut self, nv: usize, factor: &BlockCholesky) -> Result<(), String> {
        self.factor = Some(factor.clone());
        let Self { rows, responses, schur, reduced, .. } = self;
        responses.clear(nv);
        for i in 0..rows.len() {
            let response = responses.push();
            response.copy_from_slice(rows.impulse.row(i));
            factor.solve_in_place(response);
            let size = dot(rows.impulse.row(i), response);
            if size > 0.0 {
                let scale = 1.0 / size.sqrt();
                response.iter_mut().for_each(|x| *x *= scale);
                rows.scale(i, scale);
            }
        }
        schur.clear(rows.len());
        for i in 0..rows.len() {
            let entries = schur.push();
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry = dot(rows.held.row(i), responses.row(j));
            }
        }
        reduced.factor(schur).map_err(|pivot| {
            format!("the contacts hold a motion all but twice: a pivot is {:.1e} of the largest", pivot.0)
        })?;
        for k in reduced.rank..rows.len() {
            let impulses = reduced.null_vector(k);
            let (mut motion, mut size) = (vec![0.0; nv], 0.0);
            for (i, x) in impulses.iter().enumerate() {
                add_scaled(&mut motion, *x, responses.row(i));
                size += x.abs() * largest(responses.row(i));
            }
            if largest(&motion) > CANCELS * size {
                return Err("the velocity is not unique: contacts that slide leave it open".into());
            }
        }
        self.check_unfelt(nv)
    }

    /// Whether momenta that may come or go where faces lie on each other leave the velocity as it is.
    fn check_unfelt(&self, nv: usize) -> Result<(), String> {
        let (mut velocity, mut free) = (vec![0.0; nv], vec![0.0; nv]);
        let (slopes, mut scratch) = (vec![0.0; self.rows.len()], Vec::new());
        for k in 0..self.rows.unfelt.len() {
            velocity.copy_from_slice(self.rows.unfelt.row(k));
            free.copy_from_slice(self.rows.unfelt.row(k));
            self.accelerate(&mut free);
            self.solve(&mut velocity, &slopes, &mut scratch);
            if largest(&velocity) > CANCELS * largest(&free) {
                return Err("faces lie on each other, and the parts that touch are about to change".into());
            }
        }
        Ok(())
    }

    /// The system without the rows of some contacts.
    ///
    /// # Errors
    /// As of [`reduce`](Self::reduce).
    pub fn without(&self, nv: usize, contacts: &[usize]) -> Result<Self, String> {
        let mut out = Self::default();
        let Some(factor) = &self.factor else { return Ok(out) };
        out.rows.held.clear(nv);
        out.rows.impulse.clear(nv);
        for (i, source) in self.rows.source.iter().enumerate() {
            if !matches!(source, InequalitySource::Contact(i) if contacts.contains(i)) {
                out.rows.source.push(*source);
                out.rows.held.push().copy_from_slice(self.rows.held.row(i));
                out.rows.impulse.push().copy_from_slice(self.rows.impulse.row(i));
            }
        }
        out.reduce(nv, factor)?;
        Ok(out)
    }

    /// Rows that depend on the others.
    pub fn dropped(&self) -> &[usize] {
        &self.reduced.rows[self.reduced.rank..]
    }

    /// `M̂⁻¹ x`, in place.
    pub fn accelerate(&self, x: &mut [f64]) {
        if let Some(factor) = &self.factor {
            factor.solve_in_place(x);
        }
    }

    /// `v⁺` of the system: `momentum` in, velocity out; `slopes`: what the rows change by.
    pub fn solve(&self, momentum: &mut [f64], slopes: &[f64], scratch: &mut Vec<f64>) {
        self.accelerate(momentum);
        let mut impulses: Vec<f64> =
            slopes.iter().enumerate().map(|(i, slope)| -slope - dot(self.rows.held.row(i), momentum)).collect();
        self.reduced.solve_in_place(&mut impulses, scratch);
        for (i, x) in impulses.iter().enumerate() {
            add_scaled(momentum, *x, self.responses.row(i));
        }
    }

    /// The transposed system with the gradient by `v⁺`, which becomes that by the momentum; returns minus that by the rows.
    pub fn solve_transposed(&self, adjoint: &mut [f64]) -> Vec<f64> {
        // [M̂ −N; C 0]ᵀ (a, b) = (adjoint, 0): S ᵀ b = Nᵀ M̂⁻¹ adjoint, a = M̂⁻¹ (adjoint − Cᵀ b).
        let mut multipliers: Vec<f64> = (0..self.rows.len()).map(|i| dot(self.responses.row(i), adjoint)).collect();
        self.reduced.solve_transposed_in_place(&mut multipliers, &mut Vec::new());
        for (i, b) in multipliers.iter().enumerate() {
            add_scaled(adjoint, -b, self.rows.held.row(i));
        }
        self.accelerate(adjoint);
        multipliers
    }

    /// Velocity by momentum and by rows, so that many columns are a product of matrices.
    pub fn gain_into(&self, nv: usize, out: &mut Gain) {
        let Gain { by_momentum, by_rows, work, unit, scratch } = out;
        let m = self.rows.len();
        by_rows.clear(nv);
        work.clear(nv);
        for i in 0..m {
            unit.clear();
            unit.resize(m, 0.0);
            unit[i] = -1.0;
            self.reduced.solve_in_place(unit, scratch);
            let row = by_rows.push();
            unit.iter().enumerate().for_each(|(k, x)| add_scaled(row, *x, self.responses.row(k)));
            let moved = work.push();
            moved.copy_from_slice(self.rows.held.row(i));
            self.accelerate(moved);
        }
        by_momentum.clear(nv);
        for r in 0..nv {
            let row = by_momentum.push();
            row[r] = 1.0;
            self.accelerate(row);
            // The rows answer −c with what they give for c.
            (0..m).for_each(|i| add_scaled(row, by_rows.row(i)[r], work.row(i)));
        }
    }
}
