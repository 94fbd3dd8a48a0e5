use crate::equilibrate::Scaled;
use crate::linalg::{add_scaled, dot};

/// `φ(a, b) = √(a² + b²) − a − b`, zero exactly where `0 ≤ a ⟂ b ≥ 0`.
///
/// Source: Fischer (1992).
fn fischer_burmeister(a: f64, b: f64) -> f64 {
    // Without cancellation where a + b is positive.
    if a + b > 0.0 { -2.0 * a * b / (a.hypot(b) + a + b) } else { a.hypot(b) - a - b }
}

/// A point of the equilibrated problem with the Fischer–Burmeister merit function `Ψ = ½ Σ φ(z_i, w_i)²`.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    pub(super) z: Vec<f64>,
    pub(super) w: Vec<f64>,
    pub(super) phi: Vec<f64>,
    pub(super) merit: f64,
}

impl Point {
    /// Evaluates everything at `z`.
    pub(super) fn evaluate(&mut self, problem: &Scaled) {
        self.w.clear();
        self.w.extend_from_slice(&problem.b);
        for (j, &z) in self.z.iter().enumerate().filter(|(_, z)| **z != 0.0) {
            problem.add_column(j, z, &mut self.w);
        }
        self.phi.clear();
        self.phi.extend(self.z.iter().zip(&self.w).map(|(&z, &w)| fischer_burmeister(z, w)));
        self.merit = 0.5 * dot(&self.phi, &self.phi);
    }

    /// Sets this point to `from + step · direction`.
    pub(super) fn move_from(&mut self, from: &Self, direction: &[f64], step: f64, problem: &Scaled) {
        self.z.clone_from(&from.z);
        add_scaled(&mut self.z, step, direction);
        self.evaluate(problem);
    }
}

/// An element `diag(of_z) + diag(of_w) A` of the generalised Jacobian of a map of the pairs `(z_i, w_i)`.
#[derive(Clone, Debug, Default)]
pub(super) struct Jacobian {
    pub(super) of_z: Vec<f64>,
    pub(super) of_w: Vec<f64>,
}

impl Jacobian {
    /// Of the Fischer–Burmeister map; where it has a kink the limit along a fixed direction.
    ///
    /// Source: De Luca, Facchinei, Kanzow (1996), §7.
    pub(super) fn fischer_burmeister(&mut self, problem: &Scaled, point: &Point) {
        let n = problem.n;
        let kink = |i: usize| point.z[i].hypot(point.w[i]) <= 1e-14;
        let mut along = vec![0.0; n];
        for j in (0..n).filter(|&j| kink(j)) {
            problem.add_column(j, 1.0, &mut along);
        }
        let slope = |i: usize| {
            let (a, b) = if kink(i) { (1.0, along[i]) } else { (point.z[i], point.w[i]) };
            let r = f64::hypot(a, b);
            (a / r - 1.0, b / r - 1.0)
        };
        (self.of_z, self.of_w) = (0..n).map(slope).unzip();
    }

    /// Of `min(z, w)`.
    pub(super) fn minimum(&mut self, point: &Point) {
        let slope = |(z, w): (&f64, &f64)| if z <= w { (1.0, 0.0) } else { (0.0, 1.0) };
        (self.of_z, self.of_w) = point.z.iter().zip(&point.w).map(slope).unzip();
    }

    /// The matrix, row-major.
    pub(super) fn fill(&self, problem: &Scaled, data: &mut [f64]) {
        let n = problem.n;
        for j in 0..n {
            problem.for_each_in_column(j, |i, a| data[i * n + j] = self.of_w[i] * a);
            data[j * n + j] += self.of_z[j];
        }
    }

    /// `out = matrixᵀ v`.
    pub(super) fn transposed_times(&self, problem: &Scaled, v: &[f64], out: &mut Vec<f64>) {
        let weighted: Vec<f64> = self.of_w.iter().zip(v).map(|(q, v)| q * v).collect();
        out.clear();
        out.extend((0..problem.n).map(|j| self.of_z[j] * v[j] + dot(problem.column(j), &weighted)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_vanishes_on_complementary_pairs_only() {
        for (a, b) in [(0.0, 0.0), (3.0, 0.0), (0.0, 1e-9)] {
            assert_eq!(fischer_burmeister(a, b), 0.0);
        }
        // √(9 + 16) − 7, and −√2/… : by hand.
        assert!((fischer_burmeister(3.0, 4.0) + 2.0).abs() < 1e-15);
        assert_eq!(fischer_burmeister(-3.0, -4.0), 12.0);
        assert!((fischer_burmeister(1.0, 1e-20) + 1e-20).abs() < 1e-35);
    }
}
