//! Multipliers that prove that gaps and bilateral rows contradict each other.

use signorini_contact::{ContactProblem, GapContradiction};

/// What is tuned here.
struct Tuning {
    /// What counts as zero of a unit column or of the unit target: rounding of its sums.
    zero: f64,
    /// A proof whose residual is larger is none.
    accept: f64,
}

/// Chosen by: the sums of up to 1e4 products of unit vectors, and the tolerance of certificates.
const TUNING: Tuning = Tuning { zero: 1e-13, accept: 1e-9 };

/// Proves that no velocity satisfies a problem's gap rows and bilateral rows together; nothing where they do not contradict each other,
/// or where rounding hides it.
///
/// - `suspects`: contacts whose rows are tried first, as a denial names them; all contacts are tried after them
///
/// Farkas' alternative as a least squares problem with signs (C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems*, 1974, ch.
/// 23): among `y ≥ 0` and `z = z₊ − z₋` the point nearest to `J_Nᵀ y + J_Bᵀ z = 0`, `(φᵀ y + Θᵀ z)/Δt = −1`, columns scaled to unit
/// length. It is hit where the rows contradict each other and missed where a velocity satisfies them.
///
/// # Cost
/// Dense: (nv + 1) × k² with the k ≤ nv + 1 rows that take part, for each row that is taken in or dropped.
pub fn gap_contradiction(problem: &ContactProblem, suspects: &[usize]) -> Option<GapContradiction> {
    let everything: Vec<usize> = (0..problem.contact_count()).collect();
    let first = (!suspects.is_empty() && suspects.iter().all(|&i| i < everything.len())).then_some(suspects);
    [first, Some(everything.as_slice())].into_iter().flatten().find_map(|contacts| {
        let proof = Columns::of(problem, contacts).proof(problem);
        (proof.residual(problem) <= TUNING.accept).then_some(proof)
    })
}

/// Where a column's multiplier belongs.
#[derive(Clone, Copy)]
enum Row {
    Gap(usize),
    Bilateral(usize, f64),
}

/// The rows of `(J, b)` as unit columns.
struct Columns {
    size: usize,
    rows: Vec<Row>,
    lengths: Vec<f64>,
    all: Vec<Vec<f64>>,
}

impl Columns {
    fn of(problem: &ContactProblem, contacts: &[usize]) -> Self {
        let size = problem.nv() + 1;
        let mut columns = Self { size, rows: Vec::new(), lengths: Vec::new(), all: Vec::new() };
        // A column per degree of freedom is brought to one unit: to the largest entry that any row has in it.
        let mut scale = vec![0.0f64; size];
        let mut dense: Vec<(Row, Vec<f64>)> = Vec::new();
        let mut push = |row: Row, sign: f64, indices: &[u32], entries: &mut dyn Iterator<Item = f64>, distance: f64| {
            let mut column = vec![0.0; size];
            indices.iter().zip(entries).for_each(|(&k, e)| column[k as usize] = sign * e);
            column[size - 1] = sign * distance / problem.timestep;
            column.iter().zip(&mut scale).for_each(|(x, scale)| *scale = scale.max(x.abs()));
            dense.push((row, column));
        };
        for &i in contacts {
            let (indices, entries) = problem.jacobian.group(i);
            push(Row::Gap(i), 1.0, indices, &mut entries.iter().map(|e| e[0]), problem.gap[i]);
        }
        for (k, &violation) in problem.bilateral_violation.iter().enumerate() {
            let (indices, entries) = problem.bilateral_jacobian.group(k);
            for sign in [1.0, -1.0] {
                push(Row::Bilateral(k, sign), sign, indices, &mut entries.iter().map(|e| e[0]), violation);
            }
        }
        for (row, mut column) in dense {
            column.iter_mut().zip(&scale).filter(|(_, scale)| **scale > 0.0).for_each(|(x, scale)| *x /= scale);
            let length = dot(&column, &column).sqrt();
            if length > 0.0 && length.is_finite() {
                column.iter_mut().for_each(|x| *x /= length);
                columns.rows.push(row);
                columns.lengths.push(length);
                columns.all.push(column);
            }
        }
        columns
    }

    /// The multipliers of the nearest point.
    fn proof(&self, problem: &ContactProblem) -> GapContradiction {
        let mut proof = GapContradiction {
            normal: vec![0.0; problem.contact_count()],
            bilateral: vec![0.0; problem.bilateral_violation.len()],
        };
        for (c, x) in self.nearest() {
            let multiplier = x / self.lengths[c];
            match self.rows[c] {
                Row::Gap(i) => proof.normal[i] += multiplier,
                Row::Bilateral(k, sign) => proof.bilateral[k] += sign * multiplier,
            }
        }
        proof
    }

    /// The columns that take part and their coefficients, > 0: Lawson and Hanson's algorithm.
    fn nearest(&self) -> Vec<(usize, f64)> {
        let mut basis = Basis::new(self.size);
        let mut taken: Vec<usize> = Vec::new();
        let mut x: Vec<f64> = Vec::new();
        // Every round takes in the column that leads towards the target most; the distance falls strictly, so that no set comes twice.
        for _ in 0..3 * (self.size + self.all.len()) {
            let rest = basis.rest();
            let leads = |c: usize| dot(&self.all[c], &rest);
            let free = (0..self.all.len()).filter(|c| !taken.contains(c));
            let Some(best) = free.max_by(|&a, &b| leads(a).total_cmp(&leads(b))) else { break };
            if leads(best) <= TUNING.zero || !basis.push(&self.all[best]) {
                break;
            }
            taken.push(best);
            x.push(0.0);
            loop {
                let wanted = basis.coefficients();
                let Some(step) = step_to_the_first_zero(&x, &wanted) else {
                    x = wanted;
                    break;
                };
                x.iter_mut().zip(&wanted).for_each(|(x, w)| *x += step * (w - *x));
                let stays: Vec<bool> = x.iter().map(|x| *x > TUNING.zero).collect();
                let mut keep = stays.iter();
                taken.retain(|_| *keep.next().unwrap_or(&false));
                let mut keep = stays.iter();
                x.retain(|_| *keep.next().unwrap_or(&false));
                basis = Basis::new(self.size);
                for &c in &taken {
                    basis.push(&self.all[c]);
                }
            }
        }
        taken.into_iter().zip(x).collect()
    }
}

/// How far one may go from `x ≥ 0` to `wanted` until an entry vanishes; nothing if none does.
fn step_to_the_first_zero(x: &[f64], wanted: &[f64]) -> Option<f64> {
    let blocked = x.iter().zip(wanted).filter(|(_, w)| **w <= 0.0);
    blocked.map(|(x, w)| if x > w { x / (x - w) } else { 0.0 }).min_by(f64::total_cmp)
}

/// An orthonormal basis of the columns taken in, `Q R`, by Gram and Schmidt's process carried out twice.
struct Basis {
    size: usize,
    directions: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
}

impl Basis {
    fn new(size: usize) -> Self {
        Self { size, directions: Vec::new(), triangle: Vec::new() }
    }

    /// Takes in a unit column; false if it is a combination of the others.
    fn push(&mut self, column: &[f64]) -> bool {
        let (mut direction, mut entries) = (column.to_vec(), vec![0.0; self.directions.len()]);
        for _ in 0..2 {
            for (entry, q) in entries.iter_mut().zip(&self.directions) {
                let part = dot(q, &direction);
                *entry += part;
                direction.iter_mut().zip(q).for_each(|(d, q)| *d -= part * q);
            }
        }
        let length = dot(&direction, &direction).sqrt();
        if length <= TUNING.zero {
            return false;
        }
        direction.iter_mut().for_each(|d| *d /= length);
        entries.push(length);
        self.directions.push(direction);
        self.triangle.push(entries);
        true
    }

    /// What the columns leave of the target `(0, …, 0, −1)`.
    fn rest(&self) -> Vec<f64> {
        let mut rest = vec![0.0; self.size];
        rest[self.size - 1] = -1.0;
        for _ in 0..2 {
            for q in &self.directions {
                let part = dot(q, &rest);
                rest.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
            }
        }
        rest
    }

    /// The coefficients of the columns at the point nearest to the target.
    fn coefficients(&self) -> Vec<f64> {
        let count = self.directions.len();
        let mut x: Vec<f64> = self.directions.iter().map(|q| -q[self.size - 1]).collect();
        for c in (0..count).rev() {
            x[c] /= self.triangle[c][c];
            for r in 0..c {
                x[r] -= self.triangle[c][r] * x[c];
            }
        }
        x
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
