use crate::{Refusal, Residual};

/// A complementary basis: for every pair, which of the two variables may be positive.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Basis {
    /// `true` where `z_i` is basic (and `w_i = 0`), `false` where `w_i` is basic (and `z_i = 0`).
    pub z_basic: Vec<bool>,
}

impl Basis {
    /// The basis of all `w`, in which Lemke's method starts: `z = 0`.
    pub fn slack(n: usize) -> Self {
        Self { z_basic: vec![false; n] }
    }

    /// The basis with `z_i` basic where it exceeds `w_i`, both in one unit.
    pub fn from_signs(z: &[f64], w: &[f64]) -> Self {
        Self { z_basic: z.iter().zip(w).map(|(z, w)| z > w).collect() }
    }

    /// Indices of the basic `z`.
    pub fn active(&self) -> Vec<usize> {
        (0..self.z_basic.len()).filter(|&i| self.z_basic[i]).collect()
    }
}

/// What a method can say about a problem. Decided from the residual of the original data, never from the
/// method's own arithmetic.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// The residual is within the tolerance.
    Solved,
    /// A complementary point was found, but its residual exceeds the tolerance.
    Inaccurate,
    /// A pivoting method ended on a ray: for many classes of matrices the problem has no solution.
    Ray(Ray),
    /// No `z ≥ 0` has `A z + b ≥ 0`: proved by the certificate.
    Infeasible(Farkas),
    /// Every complementary basis was tried and none solves the problem.
    NoSolution,
    /// The number of pivots, sweeps or steps allowed was used up.
    IterationLimit,
    /// The problem does not meet a hypothesis without which the method has no theory.
    Refused(Refusal),
    /// The descent of a merit function stalled at a point that is no solution: the matrix is not P₀ there, or the
    /// problem has no solution.
    Stationary {
        /// Largest entry of the merit function's gradient, relative to its value, in the equilibrated problem.
        gradient: f64,
    },
    /// The equation of this free row contradicts the others: no `z` of any sign satisfies them together.
    Inconsistent {
        /// The free row.
        row: usize,
    },
    /// A linear system on the way was singular to working precision.
    Singular,
    /// The problem is too large for the method.
    TooLarge {
        /// The largest number of pairs the method accepts.
        limit: usize,
    },
}

impl Status {
    /// Whether the status is [`Status::Solved`].
    pub fn is_solved(&self) -> bool {
        matches!(self, Self::Solved)
    }
}

/// A ray on which a pivoting method ended (for Lemke's a secondary ray): `w = A z + d z0` with `z, w, z0 ≥ 0` and `z_i w_i = 0`, not all of
/// `z, z0` zero.
///
/// In a contact problem `z` are impulses that hold each other in balance: what is wedged.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ray {
    /// Direction in `z`, scaled so that its largest entry in one unit is 1.
    pub z: Vec<f64>,
    /// Direction in `w`.
    pub w: Vec<f64>,
    /// Direction in the covering variable of Lemke's method; 0 for others.
    pub z0: f64,
    /// The indices with `z_i > 0`.
    pub support: Vec<usize>,
}

/// A proof of infeasibility: `y ≥ 0`, `Aᵀ y ≤ 0`, `bᵀ y < 0`.
///
/// For any `z ≥ 0`, `yᵀ(A z + b) = (Aᵀy)ᵀz + bᵀy < 0`, so `A z + b ≥ 0` is impossible. In a mixed problem `y` has
/// any sign on free rows and `Aᵀy = 0` in free columns.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Farkas {
    /// The multipliers, one per row.
    pub y: Vec<f64>,
}

/// A run of a method on a problem: what was asked, used and reached.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// The point, `[n]`; the best one found where the status is not [`Status::Solved`].
    pub z: Vec<f64>,
    /// `w = A z + b`, `[n]`.
    pub w: Vec<f64>,
    /// Why the method ended.
    pub status: Status,
    /// The complementary basis of `z`, to start the next, similar problem from.
    pub basis: Basis,
    /// Pivots, bases (enumeration), sweeps (PSOR) or Newton steps over all attempts.
    pub iterations: usize,
    /// The residual of `z` in the original data.
    pub residual: Residual,
    /// What happened on the way.
    pub report: Report,
}

/// The history of a solve: one entry per attempt, in order.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// The attempts, of which the one with the smallest residual gave the solution; none where `z = 0` was it.
    pub attempts: Vec<Attempt>,
}

/// One attempt of a method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Attempt {
    /// Where it started.
    pub start: Start,
    /// How it ended.
    pub outcome: Outcome,
    /// Pivots, sweeps or Newton steps made.
    pub pivots: usize,
    /// Factorisations of a basis or of a Newton matrix.
    pub factorizations: usize,
    /// Residual of its point in the original data, where it reached one.
    pub residual: Option<f64>,
}

/// Where an attempt started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// The caller's basis, solved directly without pivots.
    Warm,
    /// Pivots from an advanced basis (the caller's, or one found before).
    Advanced,
    /// Pivots from `z = 0` with the covering vector of this number: 0 is the vector of ones; the others are drawn
    /// with a seed from [1, 2], times 1, 8 or 1/8 by turns in rows without a diagonal.
    Cold {
        /// Number of the covering vector.
        covering: u32,
    },
    /// Pivots from `z = 0` on `A + ε I` in the equilibrated problem, then the basis found is solved with `A`.
    Regularized {
        /// Decimal exponent of ε.
        exponent: i32,
    },
    /// All complementary bases, one after another.
    Enumeration,
    /// `z = 0`.
    Zero,
}

/// How an attempt ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// At a complementary basis.
    Complementary,
    /// At the basis given, which does not solve the problem.
    Rejected,
    /// On a secondary ray that survived a fresh factorisation.
    Ray,
    /// A basis came back: the ties were not resolved.
    Cycle,
    /// No pivots, sweeps or steps left.
    IterationLimit,
    /// At a hypothesis that the matrix does not meet.
    Refused,
    /// Where the merit function does not descend.
    Stationary,
    /// The basis was singular to working precision.
    Singular,
}
