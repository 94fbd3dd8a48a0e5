//! The linear system of a mode, solved.

use signorini_multibody::BlockCholesky;

use crate::matrix::{Rows, Work, add_scaled, dot, largest, wide};
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
    /// `M̂⁻¹ N`, one row per degree of freedom.
    responses: Rows,
    schur: Rows,
    reduced: Reduced,
    held: Sparse,
    null: Rows,
    cancelled: Rows,
    size: Vec<f64>,
}

/// Where the rows of `C` have entries: most contacts move few of many degrees of freedom.
#[derive(Clone, Debug, Default)]
struct Sparse {
    entries: Vec<(f64, usize)>,
    ends: Vec<usize>,
}

impl Sparse {
    fn set(&mut self, rows: &Rows) {
        self.entries.clear();
        self.ends.clear();
        for row in rows.data.chunks_exact(rows.width.max(1)) {
            self.entries.extend(row.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(k, x)| (*x, k)));
            self.ends.push(self.entries.len());
        }
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (f64, usize)> {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        self.entries[start..self.ends[i]].iter().copied()
    }
}

impl ModeSystem {
    /// Brings the rows at hand to the independent ones.
    ///
    /// - `factor`: of `M̂`
    ///
    /// # Errors
    /// Why the velocity has no derivative.
    pub fn reduce(&mut self, nv: usize, factor: &BlockCholesky) -> Result<(), String> {
        match &mut self.factor {
            Some(own) => own.clone_from(factor),
            None => self.factor = Some(factor.clone()),
        }
        self.respond(nv, factor);
        let Self { rows, responses, schur, reduced, held, .. } = self;
        held.set(&rows.held);
        schur.reset(rows.len(), rows.len());
        wide(Couplings { held, responses, schur });
        reduced.factor(schur).map_err(|pivot| {
            format!("the contacts hold a motion all but twice: a pivot is {:.1e} of the largest", pivot.0)
        })?;
        self.check_cancelled(nv)?;
        self.check_unfelt(nv)
    }

    /// Solves for what the impulses give, and brings each equation to the scale of its impulse.
    fn respond(&mut self, nv: usize, factor: &BlockCholesky) {
        let Self { rows, responses, size, .. } = self;
        let m = rows.len();
        responses.shape(nv, m);
        for (i, impulse) in rows.impulse.data.chunks_exact(nv.max(1)).enumerate() {
            impulse.iter().enumerate().for_each(|(k, x)| responses.data[k * m + i] = *x);
        }
        wide(Responses { factor, responses });
        size.clear();
        size.resize(m, 0.0);
        for (i, size) in size.iter_mut().enumerate() {
            let impulse = rows.impulse.row(i).iter().enumerate();
            let energy: f64 = impulse.map(|(k, x)| x * responses.data[k * m + i]).sum();
            *size = if energy > 0.0 { 1.0 / energy.sqrt() } else { 1.0 };
            rows.scale(i, *size);
        }
        for row in responses.data.chunks_exact_mut(m.max(1)) {
            row.iter_mut().zip(&*size).for_each(|(x, scale)| *x *= scale);
        }
    }

    /// Whether impulses that cancel along all rows move nothing.
    fn check_cancelled(&mut self, nv: usize) -> Result<(), String> {
        let Self { rows, responses, reduced, null, cancelled, size, .. } = self;
        let (m, rank) = (rows.len(), reduced.rank);
        if rank == m {
            return Ok(());
        }
        size.fill(0.0);
        for row in responses.data.chunks_exact(m) {
            size.iter_mut().zip(row).for_each(|(size, x)| *size = size.max(x.abs()));
        }
        wide(Cancelled { reduced, responses, null, out: cancelled });
        for d in 0..m - rank {
            let of_null = (0..rank).map(|i| null.row(i)[d].abs() * size[reduced.columns[i]]);
            let whole = of_null.sum::<f64>() + size[reduced.columns[rank + d]];
            let left = (0..nv).map(|k| cancelled.row(k)[d].abs()).fold(0.0, f64::max);
            if left > CANCELS * whole {
                return Err("the velocity is not unique: contacts that slide leave it open".into());
            }
        }
        Ok(())
    }

    /// Whether momenta that may come or go where faces lie on each other leave the velocity as it is.
    fn check_unfelt(&self, nv: usize) -> Result<(), String> {
        if self.rows.unfelt.len() == 0 {
            return Ok(());
        }
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

    /// The same, and all rows, which may be changed.
    pub fn dropped_of(&mut self) -> (&[usize], &mut ModeRows) {
        (&self.reduced.rows[self.reduced.rank..], &mut self.rows)
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
        for (x, response) in momentum.iter_mut().zip(self.responses.data.chunks_exact(impulses.len().max(1))) {
            *x += dot(response, &impulses);
        }
    }

    /// The same for many columns at once.
    ///
    /// - `columns`: momenta in, velocities out, `[nv, any]`
    /// - `slopes`: what the rows change by, `[rows, any]`
    pub fn solve_columns(&self, columns: &mut Rows, slopes: &Rows, impulses: &mut Rows) {
        let Some(factor) = &self.factor else { return };
        wide(Columns { factor, system: self, columns, slopes, impulses });
    }

    /// How the velocities `columns` move along row `i`, `C v`, which is added to `out`.
    pub fn add_held(&self, i: usize, columns: &Rows, out: &mut [f64]) {
        for (s, k) in self.held.row(i) {
            add_scaled(out, s, columns.row(k));
        }
    }

    /// The transposed system with the gradient by `v⁺`, which becomes that by the momentum; returns minus that by the rows.
    pub fn solve_transposed(&self, adjoint: &mut [f64]) -> Vec<f64> {
        // [M̂ −N; C 0]ᵀ (a, b) = (adjoint, 0): S ᵀ b = Nᵀ M̂⁻¹ adjoint, a = M̂⁻¹ (adjoint − Cᵀ b).
        let mut multipliers = vec![0.0; self.rows.len()];
        for (x, response) in adjoint.iter().zip(self.responses.data.chunks_exact(self.rows.len().max(1))) {
            add_scaled(&mut multipliers, *x, response);
        }
        self.reduced.solve_transposed_in_place(&mut multipliers, &mut Vec::new());
        for (i, b) in multipliers.iter().enumerate() {
            add_scaled(adjoint, -b, self.rows.held.row(i));
        }
        self.accelerate(adjoint);
        multipliers
    }
}

/// `C M̂⁻¹ N`.
struct Couplings<'a> {
    held: &'a Sparse,
    responses: &'a Rows,
    schur: &'a mut Rows,
}

impl Work for Couplings<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for i in 0..self.schur.len() {
            self.schur.add_rows(i, self.held.row(i), self.responses);
        }
    }
}

/// `M̂⁻¹ N`, of `N`.
struct Responses<'a> {
    factor: &'a BlockCholesky,
    responses: &'a mut Rows,
}

impl Work for Responses<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.factor.solve_rows_in_place(&mut self.responses.data, self.responses.width);
    }
}

/// What is left of the motions of impulses that cancel along all rows.
struct Cancelled<'a> {
    reduced: &'a Reduced,
    responses: &'a Rows,
    null: &'a mut Rows,
    out: &'a mut Rows,
}

impl Work for Cancelled<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { reduced, responses, null, out } = self;
        let rank = reduced.rank;
        reduced.null_vectors_into(null);
        out.reset(responses.len(), reduced.columns.len() - rank);
        for k in 0..responses.len() {
            let response = responses.row(k);
            out.add_rows(k, (0..rank).map(|i| (response[reduced.columns[i]], i)), null);
            let own = out.row_mut(k).iter_mut().zip(&reduced.columns[rank..]);
            own.for_each(|(x, &j)| *x += response[j]);
        }
    }
}

/// Momenta to velocities, of many columns at once.
struct Columns<'a> {
    factor: &'a BlockCholesky,
    system: &'a ModeSystem,
    columns: &'a mut Rows,
    slopes: &'a Rows,
    impulses: &'a mut Rows,
}

impl Work for Columns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { factor, system, columns, slopes, impulses } = self;
        let Reduced { rows, columns: pivots, rank, .. } = &system.reduced;
        factor.solve_rows_in_place(&mut columns.data, columns.width);
        impulses.reset(*rank, columns.width);
        for (i, &row) in rows[..*rank].iter().enumerate() {
            impulses.add_rows(i, system.held.row(row), columns);
            impulses.row_mut(i).iter_mut().zip(slopes.row(row)).for_each(|(x, slope)| *x = -*x - slope);
        }
        system.reduced.solve_rows_in_place(impulses);
        for (k, response) in system.responses.data.chunks_exact(system.rows.len().max(1)).enumerate() {
            columns.add_rows(k, (0..*rank).map(|i| (response[pivots[i]], i)), impulses);
        }
    }
}
