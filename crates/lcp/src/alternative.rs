//! Farkas' alternative as a least squares problem with signs.

use signorini_complementarity::dot;

/// What counts as zero of a unit column or of the unit target: rounding of its sums of up to 1e4 products.
const ZERO: f64 = 1e-13;

/// The point of a cone nearest to `(0, …, 0, −1)`: of all combinations of columns with coefficients ≥ 0. Memory is reused.
///
/// Where the target is met, the coefficients prove that no `x` has a product ≥ 0 with every column and −1 in its last entry.
///
/// ```
/// # use signorini_lcp::Alternative;
/// // No x satisfies x ≥ 1 and x ≤ 0: once the first and once the second inequality are 0 ≥ 1.
/// let mut alternative = Alternative::default();
/// alternative.begin(2);
/// alternative.push().copy_from_slice(&[1.0, -1.0]);
/// alternative.push().copy_from_slice(&[-1.0, 0.0]);
/// alternative.find();
/// assert!(alternative.missed() < 1e-12);
/// assert!(alternative.coefficients().iter().all(|y| (y - 1.0).abs() < 1e-12));
/// ```
///
/// # Cost
/// Dense: `size · k²` with the `k ≤ size` columns that take part, for each column that is taken in or dropped.
///
/// # Source
/// C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems* (1974), ch. 23.
#[derive(Clone, Debug, Default)]
pub struct Alternative {
    size: usize,
    /// One column after the other; of length 1 once they were brought to one unit.
    columns: Vec<f64>,
    /// Largest entry of each row.
    scale: Vec<f64>,
    /// Length of each column in that unit; 0 for those that are left out.
    lengths: Vec<f64>,
    basis: Basis,
    /// The columns that take part, and their coefficients.
    taken: Vec<usize>,
    x: Vec<f64>,
    wanted: Vec<f64>,
    /// What is left of the target in that unit.
    left: Vec<f64>,
    coefficients: Vec<f64>,
    rest: Vec<f64>,
}

impl Alternative {
    /// Begins anew.
    ///
    /// - `size`: entries of a column
    pub fn begin(&mut self, size: usize) {
        self.size = size;
        self.columns.clear();
        self.coefficients.clear();
    }

    /// Adds a column of zeros, `[size]`, to be written to. The entries in a place may have any unit, and so may the columns.
    pub fn push(&mut self) -> &mut [f64] {
        let from = self.columns.len();
        self.columns.resize(from + self.size, 0.0);
        self.coefficients.push(0.0);
        &mut self.columns[from..]
    }

    /// Finds the point. The rows are brought to size 1 and the columns to length 1 first.
    pub fn find(&mut self) {
        self.bring_to_one_unit();
        self.go_to_the_nearest();
        self.coefficients.fill(0.0);
        for (&c, x) in self.taken.iter().zip(&self.x) {
            self.coefficients[c] = x / self.lengths[c];
        }
        self.rest.clear();
        let plain = self.left.iter().zip(&self.scale);
        self.rest.extend(plain.map(|(r, scale)| if *scale > 0.0 { r / scale } else { *r }));
    }

    /// Coefficient of every column, ≥ 0.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// What is left of the target, `[size]`: no column has a positive product with it, and where the target is missed its last entry is
    /// negative. `x = rest / |rest_last|` then is the negative of a point that there is.
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Length of what is left of the target where the rows have size 1: 0 where it is met, 1 where no column leads towards it.
    pub fn missed(&self) -> f64 {
        dot(&self.left, &self.left).sqrt()
    }

    fn bring_to_one_unit(&mut self) {
        let Self { size, columns, scale, lengths, .. } = self;
        scale.clear();
        scale.resize(*size, 0.0f64);
        for column in columns.chunks_exact(*size) {
            scale.iter_mut().zip(column).for_each(|(scale, x)| *scale = scale.max(x.abs()));
        }
        lengths.clear();
        for column in columns.chunks_exact_mut(*size) {
            column.iter_mut().zip(&*scale).for_each(|(x, scale)| *x = if *scale > 0.0 { *x / scale } else { 0.0 });
            let length = dot(column, column).sqrt();
            let length = if length.is_finite() { length } else { 0.0 };
            lengths.push(length);
            column.iter_mut().for_each(|x| *x = if length > 0.0 { *x / length } else { 0.0 });
        }
    }

    /// The columns that take part with their coefficients, > 0, and what they leave of the target: Lawson and Hanson's algorithm.
    fn go_to_the_nearest(&mut self) {
        self.basis.begin(self.size);
        self.taken.clear();
        self.x.clear();
        let count = self.lengths.len();
        // Every round takes in the column that leads towards the target most; the distance falls strictly, so that no set comes twice.
        for _ in 0..3 * (self.size + count) {
            self.basis.rest(&mut self.left);
            let leads = |c: usize| dot(column(&self.columns, self.size, c), &self.left);
            let free = (0..count).filter(|c| !self.taken.contains(c)).map(|c| (c, leads(c)));
            let Some((best, lead)) = free.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            if lead <= ZERO || !self.basis.push(column(&self.columns, self.size, best)) {
                break;
            }
            self.taken.push(best);
            self.x.push(0.0);
            self.step_back();
        }
        self.basis.rest(&mut self.left);
    }

    /// Goes to the coefficients of the columns taken in, and drops those whose coefficient vanishes on the way.
    fn step_back(&mut self) {
        let Self { size, columns, basis, taken, x, wanted, .. } = self;
        loop {
            basis.coefficients(wanted);
            let Some(step) = step_to_the_first_zero(x, wanted) else {
                x.clone_from(wanted);
                return;
            };
            x.iter_mut().zip(&*wanted).for_each(|(x, w)| *x += step * (w - *x));
            let mut kept = 0;
            for k in 0..taken.len() {
                if x[k] > ZERO {
                    (taken[kept], x[kept]) = (taken[k], x[k]);
                    kept += 1;
                }
            }
            taken.truncate(kept);
            x.truncate(kept);
            basis.begin(*size);
            for &c in taken.iter() {
                basis.push(column(columns, *size, c));
            }
        }
    }
}

fn column(columns: &[f64], size: usize, c: usize) -> &[f64] {
    &columns[c * size..(c + 1) * size]
}

/// How far one may go from `x ≥ 0` to `wanted` until an entry vanishes; nothing if none does.
fn step_to_the_first_zero(x: &[f64], wanted: &[f64]) -> Option<f64> {
    let blocked = x.iter().zip(wanted).filter(|(_, w)| **w <= 0.0);
    blocked.map(|(x, w)| if x > w { x / (x - w) } else { 0.0 }).min_by(f64::total_cmp)
}

/// An orthonormal basis of the columns taken in, `Q R`, by Gram and Schmidt's process carried out twice.
#[derive(Clone, Debug, Default)]
struct Basis {
    size: usize,
    count: usize,
    /// `Q`, one direction after the other.
    directions: Vec<f64>,
    /// The columns of `R`, of one entry, of two, and so on.
    triangle: Vec<f64>,
}

impl Basis {
    fn begin(&mut self, size: usize) {
        (self.size, self.count) = (size, 0);
        self.directions.clear();
        self.triangle.clear();
    }

    /// Takes in a unit column; false if it is a combination of the others.
    fn push(&mut self, column: &[f64]) -> bool {
        let (at, from) = (self.directions.len(), self.triangle.len());
        self.directions.extend_from_slice(column);
        self.triangle.resize(from + self.count + 1, 0.0);
        let (others, direction) = self.directions.split_at_mut(at);
        for _ in 0..2 {
            for (entry, q) in self.triangle[from..].iter_mut().zip(others.chunks_exact(self.size)) {
                let part = dot(q, direction);
                *entry += part;
                direction.iter_mut().zip(q).for_each(|(d, q)| *d -= part * q);
            }
        }
        let length = dot(direction, direction).sqrt();
        if length <= ZERO {
            self.directions.truncate(at);
            self.triangle.truncate(from);
            return false;
        }
        direction.iter_mut().for_each(|d| *d /= length);
        self.triangle[from + self.count] = length;
        self.count += 1;
        true
    }

    /// What the columns leave of the target `(0, …, 0, −1)`.
    fn rest(&self, rest: &mut Vec<f64>) {
        rest.clear();
        rest.resize(self.size, 0.0);
        rest[self.size - 1] = -1.0;
        for _ in 0..2 {
            for q in self.directions.chunks_exact(self.size) {
                let part = dot(q, rest);
                rest.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
            }
        }
    }

    /// The coefficients of the columns at the point nearest to the target.
    fn coefficients(&self, x: &mut Vec<f64>) {
        x.clear();
        x.extend(self.directions.chunks_exact(self.size).map(|q| -q[self.size - 1]));
        for c in (0..self.count).rev() {
            let entries = &self.triangle[c * (c + 1) / 2..][..=c];
            x[c] /= entries[c];
            let (above, own) = x.split_at_mut(c);
            above.iter_mut().zip(entries).for_each(|(x, entry)| *x -= entry * own[0]);
        }
    }
}
