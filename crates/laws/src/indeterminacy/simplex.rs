//! Linear programs over one polyhedron `{x ≥ 0 : A x = b}`, by the primal simplex method from vertex to vertex.
//!
//! Every objective starts at the vertex where the last one ended, which is why this is not posed as an LCP: hundreds of
//! objectives over the same set cost a few pivots each.

use signorini_lcp::linalg::Lu;

use super::row_space::{Row, orthonormal};
use signorini_contact::vector::inner;

/// Reduced costs up to this are zero; objectives have entries of size 1.
const REDUCED_COST: f64 = 1e-10;
/// Entries of a transformed column up to this are zero; the rows are orthonormal.
const PIVOT: f64 = 1e-9;
/// Ratios within this of the smallest are tied; variables are of size 1.
const TIE: f64 = 1e-12;
/// Columns this close to the span of others are not taken into the first basis with them.
const DEPENDENT: f64 = 1e-6;
/// Pivots between fresh inverses.
const UPDATES: usize = 30;
/// Pivots without progress before the rule changes to Bland's, which cannot cycle.
const STALLED: usize = 12;

/// How well linear programs were solved, from their data: each is 0 for an exact solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearProgramResidual {
    /// Violation of `A x = b` or of `x ≥ 0`, relative to the largest sum of absolute terms; for an unbounded program, of
    /// `A r = 0`, `r ≥ 0` by its ray.
    pub primal: f64,
    /// Largest reduced cost of the wrong sign, relative to the objective's largest coefficient.
    pub dual: f64,
    /// Distance between the primal and the dual objective, relative to the larger of both and the largest variable.
    pub gap: f64,
}

impl LinearProgramResidual {
    /// The largest of the three.
    pub fn worst(&self) -> f64 {
        self.primal.max(self.dual).max(self.gap)
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.primal = self.primal.max(other.primal);
        self.dual = self.dual.max(other.dual);
        self.gap = self.gap.max(other.gap);
    }
}

/// How a program ended.
pub(super) enum Maximum {
    /// At [`Simplex::x`].
    Attained(f64),
    /// Without bound along this ray from [`Simplex::x`].
    Unbounded(Vec<f64>),
}

/// The polyhedron with a basis.
pub(super) struct Simplex {
    /// The equations as given, for the residual.
    given: Vec<Row>,
    /// Columns of the orthonormal equations, `[n][r]`.
    columns: Vec<Vec<f64>>,
    right: Vec<f64>,
    basis: Vec<usize>,
    is_basic: Vec<bool>,
    /// Rows of the inverse of the basis.
    inverse: Vec<Vec<f64>>,
    updates: usize,
    /// The current vertex.
    pub x: Vec<f64>,
    /// Residuals of all programs so far.
    pub residual: LinearProgramResidual,
    pub pivots: usize,
}

impl Simplex {
    /// The polyhedron of these equations, at a vertex found from a point `start` of it (entries of size 1).
    pub fn new(given: Vec<Row>, start: Vec<f64>) -> Self {
        let rows = orthonormal(given.clone());
        let columns = (0..start.len()).map(|j| rows.iter().map(|row| row.a[j]).collect()).collect();
        let right = rows.iter().map(|row| row.b).collect();
        let mut simplex = Self {
            given,
            columns,
            right,
            basis: Vec::new(),
            is_basic: vec![false; start.len()],
            inverse: Vec::new(),
            updates: 0,
            x: start,
            residual: LinearProgramResidual::default(),
            pivots: 0,
        };
        simplex.choose_basis();
        simplex.invert();
        simplex.move_to_vertex();
        simplex
    }

    /// Takes independent columns, positive variables first.
    fn choose_basis(&mut self) {
        let r = self.right.len();
        let mut rest = self.columns.clone();
        for (positive, least) in [(true, DEPENDENT), (false, 0.0)] {
            while self.basis.len() < r {
                let free = (0..rest.len()).filter(|&j| !self.is_basic[j] && (self.x[j] > 0.0 || !positive));
                let longest = free.map(|j| (inner(&rest[j], &rest[j]), j)).max_by(|a, b| a.0.total_cmp(&b.0));
                let Some((square, j)) = longest.filter(|(square, _)| *square > least * least) else { break };
                let unit: Vec<f64> = rest[j].iter().map(|x| x / square.sqrt()).collect();
                for column in &mut rest {
                    let along = inner(column, &unit);
                    column.iter_mut().zip(&unit).for_each(|(x, u)| *x -= along * u);
                }
                self.basis.push(j);
                self.is_basic[j] = true;
            }
        }
    }

    /// Pushes positive variables outside the basis to zero, or into it.
    fn move_to_vertex(&mut self) {
        for j in 0..self.x.len() {
            if self.is_basic[j] || self.x[j] <= 0.0 {
                continue;
            }
            let column = self.transformed(j);
            let mut limit = (self.x[j], None);
            for (i, &alpha) in column.iter().enumerate() {
                let ratio = self.x[self.basis[i]].max(0.0) / -alpha;
                if alpha < -PIVOT && ratio < limit.0 {
                    limit = (ratio, Some(i));
                }
            }
            for (i, alpha) in column.iter().enumerate() {
                self.x[self.basis[i]] += limit.0 * alpha;
            }
            match limit.1 {
                None => self.x[j] = 0.0,
                Some(leaving) => {
                    self.x[j] -= limit.0;
                    self.exchange(leaving, j, &column);
                }
            }
        }
        self.solve_basis();
    }

    /// Maximises `cᵀx`.
    pub fn maximize(&mut self, c: &[f64]) -> Maximum {
        let mut stalled = 0;
        let most = 50 * (self.x.len() + 10);
        for _ in 0..most {
            let y = self.dual(c);
            let bland = stalled > STALLED;
            let Some(entering) = self.entering(c, &y, bland) else { break };
            let column = self.transformed(entering);
            let Some((leaving, ratio)) = self.leaving(&column, bland) else {
                let ray = self.ray(entering, &column);
                self.certify_ray(&ray);
                return Maximum::Unbounded(ray);
            };
            stalled = if ratio > TIE { 0 } else { stalled + 1 };
            for (i, alpha) in column.iter().enumerate() {
                self.x[self.basis[i]] -= ratio * alpha;
            }
            self.x[self.basis[leaving]] = 0.0;
            self.x[entering] = ratio;
            self.exchange(leaving, entering, &column);
        }
        self.solve_basis();
        self.certify(c);
        Maximum::Attained(inner(c, &self.x))
    }

    /// `y` with `Bᵀy = c_B`.
    fn dual(&self, c: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.basis.len()];
        for (row, &j) in self.inverse.iter().zip(&self.basis) {
            if c[j] != 0.0 {
                y.iter_mut().zip(row).for_each(|(y, x)| *y += c[j] * x);
            }
        }
        y
    }

    /// The variable with the largest reduced cost, or by Bland's rule the first with a positive one.
    fn entering(&self, c: &[f64], y: &[f64], bland: bool) -> Option<usize> {
        let tolerance = REDUCED_COST * largest(c);
        let mut best = (tolerance, None);
        for j in (0..c.len()).filter(|&j| !self.is_basic[j]) {
            let reduced = c[j] - inner(y, &self.columns[j]);
            if reduced > best.0 {
                best = (reduced, Some(j));
                if bland {
                    break;
                }
            }
        }
        best.1
    }

    /// The basic variable that reaches zero first, and the step. Of tied ones the largest pivot is taken, or by Bland's rule
    /// the lowest index.
    fn leaving(&self, column: &[f64], bland: bool) -> Option<(usize, f64)> {
        let ratio = |i: usize| self.x[self.basis[i]].max(0.0) / column[i];
        let falling = || (0..column.len()).filter(|&i| column[i] > PIVOT);
        let smallest = falling().map(ratio).fold(f64::INFINITY, f64::min);
        let tied = falling().filter(|&i| ratio(i) <= smallest + TIE);
        let chosen = if bland {
            tied.min_by_key(|&i| self.basis[i])
        } else {
            tied.max_by(|&a, &b| column[a].total_cmp(&column[b]))
        };
        chosen.map(|i| (i, ratio(i)))
    }

    fn ray(&self, entering: usize, column: &[f64]) -> Vec<f64> {
        let mut ray = vec![0.0; self.x.len()];
        ray[entering] = 1.0;
        for (&j, alpha) in self.basis.iter().zip(column) {
            ray[j] = (-alpha).max(0.0);
        }
        ray
    }

    /// `B⁻¹ a_j`.
    fn transformed(&self, j: usize) -> Vec<f64> {
        self.inverse.iter().map(|row| inner(row, &self.columns[j])).collect()
    }

    fn exchange(&mut self, leaving: usize, entering: usize, column: &[f64]) {
        self.pivots += 1;
        self.is_basic[self.basis[leaving]] = false;
        self.is_basic[entering] = true;
        self.basis[leaving] = entering;
        self.updates += 1;
        if self.updates >= UPDATES {
            self.invert();
            return;
        }
        let pivot_row: Vec<f64> = self.inverse[leaving].iter().map(|x| x / column[leaving]).collect();
        for (i, row) in self.inverse.iter_mut().enumerate() {
            if i != leaving {
                row.iter_mut().zip(&pivot_row).for_each(|(x, p)| *x -= column[i] * p);
            }
        }
        self.inverse[leaving] = pivot_row;
    }

    /// The inverse of the basis, afresh.
    fn invert(&mut self) {
        let r = self.basis.len();
        let mut lu = Lu::default();
        let data = lu.start(r);
        for (k, &j) in self.basis.iter().enumerate() {
            for i in 0..r {
                data[i * r + k] = self.columns[j][i];
            }
        }
        self.updates = 0;
        if lu.factorize() == 0.0 {
            return;
        }
        self.inverse = vec![vec![0.0; r]; r];
        let mut unit = vec![0.0; r];
        for k in 0..r {
            unit.fill(0.0);
            unit[k] = 1.0;
            lu.solve(&mut unit);
            (0..r).for_each(|i| self.inverse[i][k] = unit[i]);
        }
    }

    /// The basic variables afresh, with one step of refinement; rounding below zero is cut off.
    fn solve_basis(&mut self) {
        self.invert();
        let nonbasic = (0..self.x.len()).filter(|&j| !self.is_basic[j]);
        nonbasic.for_each(|j| self.x[j] = 0.0);
        self.basis.iter().for_each(|&j| self.x[j] = 0.0);
        for _ in 0..2 {
            let mut rest = self.right.clone();
            for &j in &self.basis {
                rest.iter_mut().zip(&self.columns[j]).for_each(|(r, a)| *r -= a * self.x[j]);
            }
            for (row, &j) in self.inverse.iter().zip(&self.basis) {
                self.x[j] += inner(row, &rest);
            }
        }
        self.basis.iter().for_each(|&j| self.x[j] = if self.x[j] < TIE { 0.0 } else { self.x[j] });
    }

    fn certify(&mut self, c: &[f64]) {
        let y = self.dual(c);
        let size = largest(c);
        let reduced = (0..c.len()).map(|j| c[j] - inner(&y, &self.columns[j])).fold(0.0, f64::max);
        let (primal, dual) = (inner(c, &self.x), inner(&y, &self.right));
        let scale = primal.abs().max(dual.abs()).max(size * largest(&self.x));
        let residual = LinearProgramResidual {
            primal: self.violation(&self.x, true),
            dual: if size > 0.0 { reduced / size } else { 0.0 },
            gap: if scale > 0.0 { (primal - dual).abs() / scale } else { 0.0 },
        };
        self.residual.merge(&residual);
    }

    fn certify_ray(&mut self, ray: &[f64]) {
        let residual = LinearProgramResidual { primal: self.violation(ray, false), ..Default::default() };
        self.residual.merge(&residual);
    }

    /// `‖A x − b‖_∞`, or `‖A x‖_∞`, over the largest sum of absolute terms, in the equations as given.
    fn violation(&self, x: &[f64], with_right_side: bool) -> f64 {
        let (mut worst, mut scale) = (0.0_f64, 0.0_f64);
        for row in &self.given {
            let b = if with_right_side { row.b } else { 0.0 };
            worst = worst.max((inner(&row.a, x) - b).abs());
            scale = scale.max(row.a.iter().zip(x).map(|(a, x)| (a * x).abs()).sum::<f64>().max(b.abs()));
        }
        let negative = x.iter().fold(0.0, |n: f64, x| n.max(-x));
        let balance = if scale > 0.0 { worst / scale } else { 0.0 };
        balance.max(negative)
    }
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |l: f64, x| l.max(x.abs()))
}
