//! The solutions of one complementary basis whose matrix is singular: a convex polyhedron.

use crate::equilibrate::Scaled;
use crate::linalg::dot;
use crate::{Lcp, Lemke, Matrix, Method};

/// Pivots and rows below this count as zero; the entries of the equilibrated problem have size 1.
const ZERO: f64 = 1e-10;
/// A constant below this in a vanishing row counts as zero; `b` of the equilibrated problem has size 1.
const CONSISTENT: f64 = 1e-9;
/// How far from the polyhedron the points lie that are projected on it to see its extent.
const FAR: f64 = 1e3;
/// Points of a polyhedron further apart than this, relative to their size, are different.
const APART: f64 = 1e-6;

/// The points `z_α = p + N t`, `z = 0` elsewhere, with `G t + h ≥ 0`: all solutions of a basis α.
#[derive(Debug)]
pub(crate) struct Piece {
    /// `p` and the columns of `N`, by pair.
    origin: Vec<f64>,
    directions: Vec<Vec<f64>>,
    /// Rows of `G` with their `h`: the signs of `z_α` and of the other `w`.
    rows: Vec<(Vec<f64>, f64)>,
}

impl Piece {
    /// The piece of the basis `active`; `None` where its matrix is regular or its equations have no solution.
    pub(crate) fn of(problem: &Scaled, active: &[usize]) -> Option<Self> {
        let (origin, directions) = affine_solutions(problem, active)?;
        let mut rows = Vec::with_capacity(problem.n);
        for i in 0..problem.n {
            let value = |z: &[f64]| match active.contains(&i) {
                true => z[i],
                false => active.iter().map(|&j| problem.column(j)[i] * z[j]).sum(),
            };
            let constant = if active.contains(&i) { 0.0 } else { problem.b[i] };
            let row: Vec<f64> = directions.iter().map(|direction| value(direction)).collect();
            let h = value(&origin) + constant;
            let size = dot(&row, &row).sqrt();
            if size > ZERO {
                rows.push((row.iter().map(|x| x / size).collect(), h / size));
            } else if h < -CONSISTENT {
                return None;
            }
        }
        Some(Self { origin, directions, rows })
    }

    /// The point nearest to `p + N target` in `t`, in the units of the problem; `None` for an empty piece.
    ///
    /// With the multipliers `v` of `G t + h ≥ 0` it is `t = target + Gᵀv`, `0 ≤ v ⟂ G Gᵀ v + (G target + h) ≥ 0`.
    fn nearest(&self, lemke: &mut Lemke, target: &[f64]) -> Option<Vec<f64>> {
        let m = self.rows.len();
        let A = Matrix::from_fn(m, m, |i, j| dot(&self.rows[i].0, &self.rows[j].0));
        let b = self.rows.iter().map(|(row, h)| dot(row, target) + h).collect();
        let solution = lemke.solve(&Lcp::new(A, b).ok()?, None);
        let mut t = target.to_vec();
        for ((row, _), v) in self.rows.iter().zip(&solution.z) {
            t.iter_mut().zip(row).for_each(|(t, g)| *t += g * v);
        }
        solution.status.is_solved().then_some(t)
    }

    /// A point of the piece in the units of the problem; `None` for an empty piece.
    pub(crate) fn point(&self, problem: &Scaled, lemke: &mut Lemke) -> Option<Vec<f64>> {
        let t = self.nearest(lemke, &vec![0.0; self.directions.len()])?;
        Some(self.place(problem, &t))
    }

    /// Two different points of the piece in the units of the problem, where it has more than one.
    pub(crate) fn extremes(&self, problem: &Scaled, lemke: &mut Lemke) -> Option<[Vec<f64>; 2]> {
        let d = self.directions.len();
        let near = self.nearest(lemke, &vec![0.0; d])?;
        let size = near.iter().fold(1.0f64, |max, t| max.max(t.abs()));
        // Two lines without a relation to simple data, lest one is perpendicular to a piece.
        [0.6180339887498949, 1.7320508075688772].into_iter().find_map(|angle: f64| {
            let mut end = |sign: f64| {
                let target: Vec<f64> = (0..d).map(|k| sign * FAR * size * (1.0 + angle * k as f64).cos()).collect();
                self.nearest(lemke, &target)
            };
            let (first, second) = (end(1.0)?, end(-1.0)?);
            let apart = first.iter().zip(&second).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
            (apart > APART * size).then(|| [self.place(problem, &first), self.place(problem, &second)])
        })
    }

    fn place(&self, problem: &Scaled, t: &[f64]) -> Vec<f64> {
        let mut z = self.origin.clone();
        for (direction, t) in self.directions.iter().zip(t) {
            z.iter_mut().zip(direction).for_each(|(z, x)| *z += t * x);
        }
        (0..z.len()).map(|j| problem.unscaled_z(j, z[j])).collect()
    }
}

/// One solution of `A_αα z_α = −b_α` and a basis of the null space, by pair.
///
/// Gaussian elimination with complete pivoting; `None` where the matrix is regular or the system inconsistent.
fn affine_solutions(problem: &Scaled, active: &[usize]) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let k = active.len();
    let mut T = Matrix::from_fn(k, k, |i, j| problem.column(active[j])[active[i]]);
    let mut rhs: Vec<f64> = active.iter().map(|&i| -problem.b[i]).collect();
    let mut pivots: Vec<(usize, usize)> = Vec::with_capacity(k);
    let (mut rows, mut cols): (Vec<usize>, Vec<usize>) = ((0..k).collect(), (0..k).collect());
    while let Some((r, c)) = largest(&T, &rows, &cols) {
        rows.retain(|&i| i != r);
        cols.retain(|&j| j != c);
        pivots.push((r, c));
        for &i in &rows {
            let factor = T[(i, c)] / T[(r, c)];
            if factor != 0.0 {
                cols.iter().for_each(|&j| T[(i, j)] -= factor * T[(r, j)]);
                rhs[i] -= factor * rhs[r];
            }
        }
    }
    if cols.is_empty() || rows.iter().any(|&i| rhs[i].abs() > CONSISTENT) {
        return None;
    }
    // The last pivots first; `x` holds the free variables at the start.
    let substitute = |mut x: Vec<f64>, rhs: &dyn Fn(usize) -> f64| {
        for (step, &(r, c)) in pivots.iter().enumerate().rev() {
            let later = pivots[step + 1..].iter().map(|&(_, j)| j).chain(cols.iter().copied());
            let sum: f64 = later.map(|j| T[(r, j)] * x[j]).sum();
            x[c] = (rhs(r) - sum) / T[(r, c)];
        }
        let mut z = vec![0.0; problem.n];
        active.iter().zip(x).for_each(|(&j, x)| z[j] = x);
        z
    };
    let unit = |free: usize| (0..k).map(|j| f64::from(u8::from(j == free))).collect();
    let origin = substitute(vec![0.0; k], &|r| rhs[r]);
    Some((origin, cols.iter().map(|&free| substitute(unit(free), &|_| 0.0)).collect()))
}

/// The place of the largest entry among these rows and columns, where it is not zero.
fn largest(T: &Matrix, rows: &[usize], cols: &[usize]) -> Option<(usize, usize)> {
    let mut best = (ZERO, None);
    for &i in rows {
        let row = T.row(i);
        for &j in cols {
            if row[j].abs() > best.0 {
                best = (row[j].abs(), Some((i, j)));
            }
        }
    }
    best.1
}
