//! What can be said about a problem that was not solved.

use microlp::{ComparisonOp, OptimizationDirection, SolveOutcome};
use signorini::contact::{ContactProblem, FrictionBound};
use signorini::lcp::{Basis, Lemke, Method, MixedLcp, Status, solve_mixed};

/// Residual up to which a point that was found otherwise counts as a solution.
const SOLVES: f64 = 1e-9;

/// Multipliers prove infeasibility where impulses this many times larger than the data would be needed to undo them.
const OUT_OF_REACH: f64 = 1e6;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// Multipliers, checked here, prove that the rows contradict each other.
    Infeasible,
    /// The linear program of every choice of `z_i = 0` or `w_i = 0` is infeasible.
    NoSolution,
    /// This is a solution; its residual was computed from the assembled problem.
    Solvable(Vec<f64>),
    /// Lemke's path ends on a ray, and whether there is a solution was not settled.
    Open,
}

/// Whether theory promises a solution: no bilateral rows, no negative gaps, and no moving friction group that a contact bounds
/// (formulation §4).
pub fn promised(problem: &ContactProblem) -> bool {
    let groups = &problem.friction_groups;
    let mut pairs = groups.bound.iter().zip(&groups.target);
    problem.bilateral_violation.is_empty()
        && problem.gap.iter().all(|gap| *gap >= 0.0)
        && pairs.all(|(bound, target)| matches!(bound, FrictionBound::Impulse(_)) || *target == [0.0; 2])
}

/// Looks for a solution or for a proof that there is none. `programs`: linear programs to solve at most; with 0 there is only
/// Lemke's method, whose ray proves nothing and whose multipliers are checked.
pub fn examine(problem: &ContactProblem, programs: usize) -> Finding {
    let Ok(lcp) = problem.condensed_lcp() else { return Finding::Open };
    let unit = OneUnit::of(problem, &lcp);
    let solution = solve_mixed(&lcp, &mut Lemke::default(), None);
    if unit.residual(&solution.z) <= SOLVES {
        return Finding::Solvable(solution.z);
    }
    if let Status::Infeasible(proof) = &solution.status
        && unit.proves_infeasible(&proof.y, &lcp)
    {
        return Finding::Infeasible;
    }
    let mut search = Search { unit: &unit, lcp: &lcp, programs };
    match search.branch(&mut vec![None; lcp.len()]) {
        Branch::Solution(z) => Finding::Solvable(z),
        Branch::None => Finding::NoSolution,
        Branch::Open => Finding::Open,
    }
}

/// The problem with all `z` and `w` in one unit and relative to the data's velocity: `w̃ = Ã z̃ + b̃`.
struct OneUnit {
    n: usize,
    a: Vec<f64>,
    b: Vec<f64>,
    free: Vec<bool>,
    /// `z̃_i = weight[i] z_i`.
    weight: Vec<f64>,
}

impl OneUnit {
    fn of(problem: &ContactProblem, lcp: &MixedLcp) -> Self {
        let n = lcp.len();
        let (z, w) = (lcp.scaling().z(), lcp.scaling().w());
        let velocity_rows = &lcp.b()[..problem.standard_layout().bounds];
        let scale = velocity_rows.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let entry = |k: usize| w[k / n] * lcp.A()[(k / n, k % n)] / z[k % n];
        Self {
            n,
            a: (0..n * n).map(entry).collect(),
            b: (0..n).map(|i| w[i] * lcp.b()[i] / scale).collect(),
            free: lcp.free().to_vec(),
            weight: z.iter().map(|z| z / scale).collect(),
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.a[i * self.n..(i + 1) * self.n]
    }

    fn w(&self, i: usize, z: &[f64]) -> f64 {
        self.b[i] + self.row(i).iter().zip(z).map(|(a, z)| a * z).sum::<f64>()
    }

    /// `|min(z̃_i, w̃_i)|`, or `|w̃_i|` where `z_i` is free.
    fn violation(&self, i: usize, z: &[f64]) -> f64 {
        let w = self.w(i, z);
        let size = if self.free[i] { w.abs() } else { z[i].min(w).abs() };
        if z[i].is_finite() && w.is_finite() { size } else { f64::INFINITY }
    }

    /// The largest violation of a point in its own units.
    fn residual(&self, z: &[f64]) -> f64 {
        let z: Vec<f64> = z.iter().zip(&self.weight).map(|(z, weight)| z * weight).collect();
        (0..self.n).map(|i| self.violation(i, &z)).fold(0.0, f64::max)
    }

    /// `ỹ ≥ 0`, `b̃ᵀỹ = −d < 0` and `Ãᵀỹ ≤ ε` (`= 0` in free columns) ask for `‖z̃‖₁ ≥ d/ε` of every solution.
    fn proves_infeasible(&self, y: &[f64], lcp: &MixedLcp) -> bool {
        let clipped = |i: usize| {
            let y = y[i] / lcp.scaling().w()[i];
            if self.free[i] { y } else { y.max(0.0) }
        };
        let y: Vec<f64> = (0..self.n).map(clipped).collect();
        let terms = || self.b.iter().zip(&y).map(|(b, y)| b * y);
        let (depth, size) = (-terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
        let mut slope = 0.0_f64;
        for j in 0..self.n {
            let c: f64 = (0..self.n).map(|i| self.a[i * self.n + j] * y[i]).sum();
            slope = slope.max(if self.free[j] { c.abs() } else { c });
        }
        depth > 1e-9 * size && depth >= OUT_OF_REACH * slope
    }
}

/// Which variable of a pair is zero.
#[derive(Clone, Copy, PartialEq)]
enum Zero {
    Z,
    W,
}

/// What is known about a branch.
enum Branch {
    Solution(Vec<f64>),
    None,
    Open,
}

/// Branches over the pairs, with a linear program at each node.
struct Search<'a> {
    unit: &'a OneUnit,
    lcp: &'a MixedLcp,
    programs: usize,
}

impl Search<'_> {
    fn branch(&mut self, zero: &mut Vec<Option<Zero>>) -> Branch {
        if self.programs == 0 {
            return Branch::Open;
        }
        self.programs -= 1;
        let z = match self.relaxation(zero) {
            Ok(Some(z)) => z,
            Ok(None) => return Branch::None,
            Err(()) => return Branch::Open,
        };
        let undecided = (0..self.unit.n).filter(|&i| zero[i].is_none() && !self.unit.free[i]);
        let worst = undecided.map(|i| (self.unit.violation(i, &z), i)).max_by(|a, b| a.0.total_cmp(&b.0));
        if worst.is_none_or(|(violation, _)| violation <= 1e-6)
            && let Some(z) = self.polished(zero, &z)
        {
            return Branch::Solution(z);
        }
        let Some((_, pair)) = worst else { return Branch::Open };
        let first = if z[pair] < self.unit.w(pair, &z) { Zero::Z } else { Zero::W };
        let mut open = false;
        for side in [first, if first == Zero::Z { Zero::W } else { Zero::Z }] {
            zero[pair] = Some(side);
            let found = self.branch(zero);
            zero[pair] = None;
            match found {
                Branch::Solution(z) => return Branch::Solution(z),
                Branch::Open => open = true,
                Branch::None => {}
            }
        }
        if open { Branch::Open } else { Branch::None }
    }

    /// A point with `z ≥ 0`, `w ≥ 0` and these zeros, of least `Σ z`; `Ok(None)` where there is none.
    fn relaxation(&self, zero: &[Option<Zero>]) -> Result<Option<Vec<f64>>, ()> {
        let mut program = microlp::Problem::new(OptimizationDirection::Minimize);
        let bounds = |i: usize| match zero[i] {
            _ if self.unit.free[i] => (f64::NEG_INFINITY, f64::INFINITY),
            Some(Zero::Z) => (0.0, 0.0),
            _ => (0.0, f64::INFINITY),
        };
        let cost = |i: usize| if self.unit.free[i] { 0.0 } else { 1.0 };
        let variables: Vec<_> = (0..self.unit.n).map(|i| program.add_var(cost(i), bounds(i))).collect();
        for i in 0..self.unit.n {
            let terms: Vec<_> = variables.iter().copied().zip(self.unit.row(i).iter().copied()).collect();
            let relation =
                if self.unit.free[i] || zero[i] == Some(Zero::W) { ComparisonOp::Eq } else { ComparisonOp::Ge };
            program.add_constraint(terms, relation, -self.unit.b[i]);
        }
        match program.solve() {
            Ok(SolveOutcome::Solution(point)) => Ok(Some(variables.iter().map(|&v| point.var_value(v)).collect())),
            Err(microlp::Error::Infeasible) => Ok(None),
            _ => Err(()),
        }
    }

    /// The solution of the point's basis, if it is one.
    fn polished(&self, zero: &[Option<Zero>], z: &[f64]) -> Option<Vec<f64>> {
        let basic = |i: usize| zero[i].map_or_else(|| z[i] > self.unit.w(i, z), |side| side == Zero::W);
        let basis = Basis { z_basic: (0..self.unit.n).map(basic).collect() };
        let method: &mut dyn Method = &mut Lemke::default();
        let solution = solve_mixed(self.lcp, method, Some(&basis));
        (self.unit.residual(&solution.z) <= SOLVES).then_some(solution.z)
    }
}
