//! Mixed problems: free variables are eliminated by exchange pivots, and any [`Method`] solves what is left.
//!
//! Each free variable is exchanged with a free row's `w = 0`. Where the free block is singular, a free row `r` and
//! a free column `c` are joined through a complementary pair `j`: `w_r ↔ z_j`, then `w_j ↔ u_c`. The pair `j` then
//! enters the reduced problem with its roles exchanged. The point found is solved afresh from the original data.

use crate::equilibrate::Scaled;
use crate::polish::Polish;
use crate::{Basis, Farkas, Lcp, LcpError, Matrix, Method, MixedLcp, Ray, Report, Scaling, Solution, Status};

/// Pivots below this count as zero; the entries of the equilibrated problem have size 1.
const SMALLEST_PIVOT: f64 = 1e-10;
/// A constant below this in a vanishing row counts as zero; `b` of the equilibrated problem has size 1.
const CONSISTENT: f64 = 1e-9;

/// The equilibrated problem `w = T z + t` on its way to a form in which the free variables are basic.
struct Exchange {
    T: Matrix,
    t: Vec<f64>,
    /// The variable that each row defines: `w_i = i`, `z_j = n + j`.
    basic: Vec<usize>,
    /// The variable that each column multiplies.
    nonbasic: Vec<usize>,
}

/// The complementary part after the elimination.
struct Reduction {
    exchange: Exchange,
    /// Row and column of each remaining pair, in the order of the pairs, and whether its roles are exchanged.
    pairs: Vec<Pair>,
    /// Free variables that no equation fixes; they are 0.
    idle: Vec<usize>,
    /// Free rows that follow from the others.
    redundant: Vec<usize>,
}

struct Pair {
    index: usize,
    row: usize,
    col: usize,
    exchanged: bool,
}

/// Solves the problem by eliminating its free variables and giving the rest to `method`.
///
/// - `warm`: a complementary basis, `[n]`; its entries on free rows do not matter
///
/// The status is decided from [`MixedLcp::residual`]. A free variable that no equation fixes is 0. The free
/// block may be singular; [`Status::Inconsistent`] says that the free rows contradict each other, and
/// [`Status::Singular`] that they restrict the complementary variables in a way no free variable can take up.
///
/// # Cost
/// O(n²) per free variable, then the method's.
///
/// # Source
/// Cottle, Pang, Stone (2009), §1.5 and §2.3 (principal pivot transforms).
pub fn solve_mixed(problem: &MixedLcp, method: &mut dyn Method, warm: Option<&Basis>) -> Solution {
    let mut scaled = Scaled::default();
    scaled.load(problem.A(), problem.b(), problem.scaling());
    let reduction = match Reduction::of(problem, &scaled) {
        Ok(reduction) => reduction,
        Err(status) => return unsolved(problem, status, method.tolerance()),
    };
    let Ok(reduced) = reduction.problem(&scaled, problem.scaling()) else {
        return unsolved(problem, Status::Singular, method.tolerance());
    };
    let warm = warm.filter(|warm| warm.z_basic.len() == problem.len()).map(|warm| reduction.reduced_basis(warm));
    let inner = method.solve(&reduced, warm.as_ref());
    reduction.lift(problem, &scaled, inner, method.tolerance())
}

/// The zero point, with the status that ended the elimination unless it happens to be a solution.
fn unsolved(problem: &MixedLcp, status: Status, tolerance: f64) -> Solution {
    let z = vec![0.0; problem.len()];
    let residual = problem.residual(&z);
    Solution {
        w: problem.w(&z),
        z,
        status: if residual.within(tolerance) { Status::Solved } else { status },
        basis: Basis { z_basic: problem.free().to_vec() },
        iterations: 0,
        residual,
        report: Report::default(),
    }
}

impl Exchange {
    /// Solves row `row` for the variable of column `col` and inserts it everywhere else.
    fn pivot(&mut self, row: usize, col: usize) {
        let n = self.t.len();
        let pivot = self.T[(row, col)];
        let mut pivot_row: Vec<f64> = self.T.row(row).iter().map(|x| -x / pivot).collect();
        pivot_row[col] = 1.0 / pivot;
        let constant = -self.t[row] / pivot;
        for i in (0..n).filter(|&i| i != row) {
            let factor = self.T[(i, col)];
            if factor != 0.0 {
                self.T[(i, col)] = 0.0;
                for j in 0..n {
                    self.T[(i, j)] += factor * pivot_row[j];
                }
                self.t[i] += factor * constant;
            }
        }
        self.T.data_mut()[row * n..(row + 1) * n].copy_from_slice(&pivot_row);
        self.t[row] = constant;
        std::mem::swap(&mut self.basic[row], &mut self.nonbasic[col]);
    }

    /// The largest of `size` over the pairs of two index sets, where it exceeds the smallest pivot allowed.
    fn largest(rows: &[usize], cols: &[usize], size: impl Fn(usize, usize) -> f64) -> Option<(usize, usize)> {
        let mut best = (SMALLEST_PIVOT, None);
        for (r, &i) in rows.iter().enumerate() {
            for (c, &j) in cols.iter().enumerate() {
                if size(i, j) > best.0 {
                    best = (size(i, j), Some((r, c)));
                }
            }
        }
        best.1
    }
}

impl Reduction {
    fn of(problem: &MixedLcp, scaled: &Scaled) -> Result<Self, Status> {
        let n = problem.len();
        let mut exchange = Exchange {
            T: Matrix::from_fn(n, n, |i, j| scaled.column(j)[i]),
            t: scaled.b.clone(),
            basic: (0..n).collect(),
            nonbasic: (n..2 * n).collect(),
        };
        let mut rows: Vec<usize> = (0..n).filter(|&i| problem.free()[i]).collect();
        let mut cols = rows.clone();
        let mut pairs: Vec<Pair> = (0..n)
            .filter(|&i| !problem.free()[i])
            .map(|i| Pair { index: i, row: i, col: i, exchanged: false })
            .collect();
        loop {
            if let Some((r, c)) = Exchange::largest(&rows, &cols, |i, j| exchange.T[(i, j)].abs()) {
                exchange.pivot(rows.swap_remove(r), cols.swap_remove(c));
            } else if !join_through_pair(&mut exchange, &mut rows, &mut cols, &mut pairs) {
                break;
            }
        }
        let redundant = exchange.redundant_rows(&rows, &pairs)?;
        Ok(Self { exchange, pairs, idle: cols, redundant })
    }

    /// The reduced problem in the units of the original one, so that its residual is comparable.
    ///
    /// Fails only where the elimination overflowed.
    fn problem(&self, scaled: &Scaled, scaling: &Scaling) -> Result<Lcp, LcpError> {
        let entry = |p: usize, q: usize| self.exchange.T[(self.pairs[p].row, self.pairs[q].col)];
        let k = self.pairs.len();
        // An exchanged pair has z in the row and w in the column.
        let unit = |pair: &Pair, of_row: bool| {
            let i = pair.index;
            if pair.exchanged == of_row {
                (scaled.unscaled_z(i, 1.0), scaling.z()[i])
            } else {
                (scaled.unscaled_w(i, 1.0), scaling.w()[i])
            }
        };
        let rows: Vec<(f64, f64)> = self.pairs.iter().map(|pair| unit(pair, true)).collect();
        let cols: Vec<(f64, f64)> = self.pairs.iter().map(|pair| unit(pair, false)).collect();
        let A = Matrix::from_fn(k, k, |p, q| rows[p].0 * entry(p, q) / cols[q].0);
        let b = (0..k).map(|p| rows[p].0 * self.exchange.t[self.pairs[p].row]).collect();
        let weights = |units: &[(f64, f64)]| units.iter().map(|unit| unit.1).collect();
        let scaling = Scaling::new(weights(&cols), weights(&rows))?;
        Lcp::with_scaling(A, b, scaling)
    }

    fn reduced_basis(&self, basis: &Basis) -> Basis {
        Basis { z_basic: self.pairs.iter().map(|pair| basis.z_basic[pair.index] != pair.exchanged).collect() }
    }
}

/// Pivots on a 2×2 block through the pair that makes it most regular; false when there is none.
fn join_through_pair(
    exchange: &mut Exchange,
    rows: &mut Vec<usize>,
    cols: &mut Vec<usize>,
    pairs: &mut [Pair],
) -> bool {
    let mut best: (f64, Option<(usize, usize, usize)>) = (SMALLEST_PIVOT, None);
    for (p, pair) in pairs.iter().enumerate().filter(|(_, pair)| !pair.exchanged) {
        let along = Exchange::largest(rows, &[pair.col], |i, j| exchange.T[(i, j)].abs());
        let across = Exchange::largest(&[pair.row], cols, |i, j| exchange.T[(i, j)].abs());
        if let (Some((r, _)), Some((_, c))) = (along, across) {
            let size = exchange.T[(rows[r], pair.col)].abs().min(exchange.T[(pair.row, cols[c])].abs());
            if size > best.0 {
                best = (size, Some((p, r, c)));
            }
        }
    }
    let Some((p, r, c)) = best.1 else {
        return false;
    };
    let pair = &mut pairs[p];
    let (row, col) = (rows.swap_remove(r), cols.swap_remove(c));
    exchange.pivot(row, pair.col);
    exchange.pivot(pair.row, col);
    (pair.row, pair.col, pair.exchanged) = (row, col, true);
    true
}

impl Exchange {
    /// The free rows left over, which must read 0 = 0.
    fn redundant_rows(&self, rows: &[usize], pairs: &[Pair]) -> Result<Vec<usize>, Status> {
        for &i in rows {
            if pairs.iter().any(|pair| self.T[(i, pair.col)].abs() > SMALLEST_PIVOT) {
                return Err(Status::Singular);
            }
            if self.t[i].abs() > CONSISTENT {
                return Err(Status::Inconsistent { row: self.basic[i] });
            }
        }
        Ok(rows.iter().map(|&i| self.basic[i]).collect())
    }
}

impl Reduction {
    /// The solution of the whole problem from that of the reduced one.
    fn lift(&self, problem: &MixedLcp, scaled: &Scaled, inner: Solution, tolerance: f64) -> Solution {
        let n = problem.len();
        let mut basis = Basis { z_basic: problem.free().to_vec() };
        for (pair, z_basic) in self.pairs.iter().zip(&inner.basis.z_basic) {
            basis.z_basic[pair.index] = z_basic != &pair.exchanged;
        }
        let (mut z, _) = self.point(scaled, &inner.z, &inner.w, 1.0);
        let mut residual = problem.residual(&z);
        let without = |left_out: &[usize]| -> Vec<usize> {
            (0..n).filter(|i| basis.z_basic[*i] && !left_out.contains(i)).collect()
        };
        let (rows, cols) = (without(&self.redundant), without(&self.idle));
        let mut polished = vec![0.0; n];
        if Polish::default().solve_active(problem.A(), problem.b(), problem.scaling(), &rows, &cols, &mut polished) {
            let clamp = |(z, &free): (&mut f64, &bool)| *z = if free { *z } else { z.max(0.0) };
            polished.iter_mut().zip(problem.free()).for_each(clamp);
            let polished_residual = problem.residual(&polished);
            if polished_residual.value < residual.value {
                (z, residual) = (polished, polished_residual);
            }
        }
        let status = match inner.status {
            _ if residual.within(tolerance) => Status::Solved,
            Status::Solved => Status::Inaccurate,
            Status::Ray(ray) => Status::Ray(self.lift_ray(scaled, &ray)),
            Status::Refused(refusal) => Status::Refused(refusal.moved(|p| self.pairs[p].index)),
            Status::Infeasible(farkas) => Status::Infeasible(self.lift_certificate(scaled, &farkas)),
            other => other,
        };
        let (iterations, report) = (inner.iterations, inner.report);
        Solution { w: problem.w(&z), z, status, basis, iterations, residual, report }
    }

    /// All `z` and `w` from those of the reduced problem; `constant` is 1 for a point and 0 for a direction.
    fn point(&self, scaled: &Scaled, reduced_z: &[f64], reduced_w: &[f64], constant: f64) -> (Vec<f64>, Vec<f64>) {
        let n = self.exchange.t.len();
        let (mut z, mut w) = (vec![0.0; n], vec![0.0; n]);
        let mut values = vec![0.0; n];
        for ((pair, &x), &y) in self.pairs.iter().zip(reduced_z).zip(reduced_w) {
            let i = pair.index;
            let (z_i, w_i) = if pair.exchanged { (y, x) } else { (x, y) };
            (z[i], w[i]) = (z_i, w_i);
            let unit = if pair.exchanged { scaled.unscaled_w(i, 1.0) } else { scaled.unscaled_z(i, 1.0) };
            values[pair.col] = x / unit;
        }
        for row in 0..n {
            let variable = self.exchange.basic[row];
            let free = variable >= n && self.pairs.iter().all(|pair| pair.row != row);
            if free {
                let sum: f64 = self.exchange.T.row(row).iter().zip(&values).map(|(t, x)| t * x).sum();
                z[variable - n] = scaled.unscaled_z(variable - n, sum + constant * self.exchange.t[row]);
            }
        }
        (z, w)
    }

    fn lift_ray(&self, scaled: &Scaled, ray: &Ray) -> Ray {
        let (z, w) = self.point(scaled, &ray.z, &ray.w, 0.0);
        let support = (0..z.len()).filter(|&i| z[i] != 0.0).collect();
        Ray { z, w, z0: ray.z0, support }
    }

    /// Multipliers of all rows: with `y` for the reduced rows, those of the variables in the columns are `−Tᵀy`.
    fn lift_certificate(&self, scaled: &Scaled, farkas: &Farkas) -> Farkas {
        let n = self.exchange.t.len();
        let mut y = vec![0.0; n];
        let mut in_columns = vec![0.0; n];
        for (pair, &multiplier) in self.pairs.iter().zip(&farkas.y) {
            let i = pair.index;
            let unit = if pair.exchanged { scaled.unscaled_z(i, 1.0) } else { scaled.unscaled_w(i, 1.0) };
            if !pair.exchanged {
                y[i] = multiplier;
            }
            for (sum, t) in in_columns.iter_mut().zip(self.exchange.T.row(pair.row)) {
                *sum -= multiplier * unit * t;
            }
        }
        for (col, &variable) in self.exchange.nonbasic.iter().enumerate() {
            if variable < n {
                y[variable] = in_columns[col] / scaled.unscaled_w(variable, 1.0);
            }
        }
        Farkas { y }
    }
}
