//! Farkas' alternative as a least squares problem with signs.

use signorini_complementarity::dot;

/// What counts as zero of a unit column or of the unit target: rounding of its sums of up to 1e4 products.
const ZERO: f64 = 1e-13;

/// The point of a cone nearest to `(0, …, 0, −1)`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Alternative {
    /// Coefficient of every column, ≥ 0. Where the target is met, they prove that no `x` has a product ≥ 0 with every column and −1 in its
    /// last entry.
    pub coefficients: Vec<f64>,
    /// What is left of the target, `[size]`: no column has a positive product with it, and where the target is missed its last entry is
    /// negative. `x = rest / |rest_last|` then is the negative of a point that there is.
    pub rest: Vec<f64>,
}

/// The point nearest to `(0, …, 0, −1)` of all combinations of `columns` with coefficients ≥ 0.
///
/// - `columns`: each `[size]`; their entries in a place may have any unit, and so may the columns
///
/// The rows are brought to size 1 and the columns to length 1 first.
///
/// # Cost
/// Dense: `size · k²` with the `k ≤ size` columns that take part, for each column that is taken in or dropped.
///
/// # Source
/// C. L. Lawson and R. J. Hanson, *Solving Least Squares Problems* (1974), ch. 23.
pub fn alternative(size: usize, columns: &[Vec<f64>]) -> Alternative {
    let columns = UnitColumns::of(size, columns);
    let (taken, rest) = columns.nearest();
    let mut coefficients = vec![0.0; columns.lengths.len()];
    for (c, x) in taken {
        coefficients[c] = x / columns.lengths[c];
    }
    let rest = rest.iter().zip(&columns.scale).map(|(r, scale)| if *scale > 0.0 { r / scale } else { *r }).collect();
    Alternative { coefficients, rest }
}

/// The columns brought to one unit.
struct UnitColumns {
    size: usize,
    /// Largest entry of each row.
    scale: Vec<f64>,
    /// Length of each column in that unit; 0 for those that are left out.
    lengths: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl UnitColumns {
    fn of(size: usize, given: &[Vec<f64>]) -> Self {
        let mut scale = vec![0.0f64; size];
        for column in given {
            scale.iter_mut().zip(column).for_each(|(scale, x)| *scale = scale.max(x.abs()));
        }
        let mut lengths = Vec::with_capacity(given.len());
        let unit = |column: &Vec<f64>| {
            let one = |(x, scale): (&f64, &f64)| if *scale > 0.0 { x / scale } else { 0.0 };
            let mut column: Vec<f64> = column.iter().zip(&scale).map(one).collect();
            let length = dot(&column, &column).sqrt();
            let length = if length.is_finite() { length } else { 0.0 };
            lengths.push(length);
            column.iter_mut().for_each(|x| *x = if length > 0.0 { *x / length } else { 0.0 });
            column
        };
        let columns = given.iter().map(unit).collect();
        Self { size, scale, lengths, columns }
    }

    /// The columns that take part with their coefficients, > 0, and what they leave of the target: Lawson and Hanson's algorithm.
    fn nearest(&self) -> (Vec<(usize, f64)>, Vec<f64>) {
        let mut basis = Basis::new(self.size);
        let mut taken: Vec<usize> = Vec::new();
        let mut x: Vec<f64> = Vec::new();
        // Every round takes in the column that leads towards the target most; the distance falls strictly, so that no set comes twice.
        for _ in 0..3 * (self.size + self.columns.len()) {
            let rest = basis.rest();
            let leads = |c: usize| dot(&self.columns[c], &rest);
            let free = (0..self.columns.len()).filter(|c| !taken.contains(c)).map(|c| (c, leads(c)));
            let Some((best, lead)) = free.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            if lead <= ZERO || !basis.push(&self.columns[best]) {
                break;
            }
            taken.push(best);
            x.push(0.0);
            self.step_back(&mut basis, &mut taken, &mut x);
        }
        let rest = basis.rest();
        (taken.into_iter().zip(x).collect(), rest)
    }

    /// Goes to the coefficients of the columns taken in, and drops those whose coefficient vanishes on the way.
    fn step_back(&self, basis: &mut Basis, taken: &mut Vec<usize>, x: &mut Vec<f64>) {
        loop {
            let wanted = basis.coefficients();
            let Some(step) = step_to_the_first_zero(x, &wanted) else {
                *x = wanted;
                return;
            };
            x.iter_mut().zip(&wanted).for_each(|(x, w)| *x += step * (w - *x));
            let stays: Vec<bool> = x.iter().map(|x| *x > ZERO).collect();
            let mut keep = stays.iter();
            taken.retain(|_| *keep.next().unwrap_or(&false));
            let mut keep = stays.iter();
            x.retain(|_| *keep.next().unwrap_or(&false));
            *basis = Basis::new(self.size);
            for &c in taken.iter() {
                basis.push(&self.columns[c]);
            }
        }
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
        if length <= ZERO {
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
