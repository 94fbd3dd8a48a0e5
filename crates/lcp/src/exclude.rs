//! Is there any solution? A tree of cases, each with a point or a proof.

use crate::alternative::Alternative;
use crate::polish::Polish;
use crate::{Basis, ExcludedCase, Exclusion, Farkas, MixedLcp, PairCase, Solution, Status};

/// A proof whose residual is larger is none.
const ACCEPTED: f64 = 1e-9;
/// A point whose residual is at most this is a solution; one whose residual is at most that may have one in its basis.
const SOLVED: f64 = 1e-10;
const CLOSE: f64 = 1e-6;

/// What a search for all solutions came to.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Existence {
    /// There is none, with the proof.
    Excluded(Exclusion),
    /// There is one: this `z`, `[n]`, solves the problem within 1e-10.
    Solved(Vec<f64>),
    /// Neither was found: more cases would have to be looked at, or rounding hides the answer.
    Undecided,
}

/// Looks for a solution in all complementary cases of a problem of any matrix, and proves of every case that has none that it has none.
///
/// - `most_cases`: largest number of cases that are looked at
///
/// A case decides of some pairs which of `z_i` and `w_i` is zero. By Farkas' alternative either multipliers exclude it, or there is a `z`
/// that satisfies all but the complementarity of the pairs that are open. Where that does not hold it is the solution; otherwise the pair
/// that violates it most makes two cases.
///
/// # Guarantee
/// Both answers are judged by the data of the problem: [`Exclusion::residual`] ≤ 1e-9, [`MixedLcp::residual`] ≤ 1e-10.
///
/// # Cost
/// A least squares problem with signs in `n + 1` rows and up to `2n` columns for each case; at worst 2ⁿ⁺¹ cases, mostly a few times n.
///
/// # Source
/// Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §1.4 (complementary cones), §2.8 (Farkas); branching as for mixed
/// integer programs: Al-Khayyal, *Linear, quadratic, and bilinear programming approaches to the LCP* (1986).
pub fn exclude(problem: &MixedLcp, most_cases: usize) -> Existence {
    let mut waiting = vec![vec![PairCase::Open; problem.len()]];
    let mut exclusion = Exclusion::default();
    let mut looked_at = 0;
    while let Some(pairs) = waiting.pop() {
        looked_at += 1;
        if looked_at > most_cases {
            return Existence::Undecided;
        }
        let (case, point) = look_at(problem, pairs);
        if case.residual(problem) <= ACCEPTED {
            exclusion.cases.push(case);
            continue;
        }
        let Some(z) = point else { return Existence::Undecided };
        if let Some(z) = solution_near(problem, &case.pairs, z.clone()) {
            return Existence::Solved(z);
        }
        let Some(pair) = most_violated(problem, &case.pairs, &z) else { return Existence::Undecided };
        for decided in [PairCase::NoZ, PairCase::NoW] {
            let mut pairs = case.pairs.clone();
            pairs[pair] = decided;
            waiting.push(pairs);
        }
    }
    Existence::Excluded(exclusion)
}

/// Multipliers of a case that should exclude it, and the point that there is where they do not.
fn look_at(problem: &MixedLcp, pairs: Vec<PairCase>) -> (ExcludedCase, Option<Vec<f64>>) {
    let n = problem.len();
    let is_free = |i: usize| problem.free()[i];
    // A place for each z that may be other than zero, and one for b.
    let present: Vec<usize> = (0..n).filter(|&j| is_free(j) || pairs[j] != PairCase::NoZ).collect();
    let size = present.len() + 1;
    let mut nearest = Alternative::default();
    nearest.begin(size);
    let mut rows = Vec::new();
    let mut push = |i: usize, sign: f64| {
        let column = nearest.push();
        column.iter_mut().zip(&present).for_each(|(entry, &j)| *entry = sign * problem.A()[(i, j)]);
        column[size - 1] = sign * problem.b()[i];
        rows.push((i, sign));
    };
    for i in 0..n {
        if is_free(i) || pairs[i] == PairCase::NoW {
            push(i, -1.0);
        }
        push(i, 1.0);
    }
    for (place, _) in present.iter().enumerate().filter(|(_, j)| !is_free(**j)) {
        nearest.push()[place] = 1.0;
    }
    nearest.find();
    let mut multipliers = vec![0.0; n];
    for (&(i, sign), y) in rows.iter().zip(nearest.coefficients()) {
        multipliers[i] += sign * y;
    }
    let last = nearest.rest()[size - 1];
    let point = (last < 0.0).then(|| {
        let mut z = vec![0.0; n];
        for (&j, r) in present.iter().zip(nearest.rest()) {
            let x = r / last;
            z[j] = if is_free(j) { x } else { x.max(0.0) };
        }
        z
    });
    (ExcludedCase { pairs, multipliers }, point.filter(|z| z.iter().all(|x| x.is_finite())))
}

/// The point itself, or that of the basis it shows where it is close to a solution, if that solves the problem.
fn solution_near(problem: &MixedLcp, pairs: &[PairCase], z: Vec<f64>) -> Option<Vec<f64>> {
    let is_solution = |z: &[f64]| problem.residual(z).within(SOLVED);
    if is_solution(&z) {
        return Some(z);
    }
    if !problem.residual(&z).within(CLOSE) {
        return None;
    }
    let (w, scaling) = (problem.w(&z), problem.scaling());
    let is_basic = |i: &usize| match pairs[*i] {
        _ if problem.free()[*i] => true,
        PairCase::Open => scaling.z()[*i] * z[*i] > scaling.w()[*i] * w[*i],
        decided => decided == PairCase::NoW,
    };
    let active: Vec<usize> = (0..z.len()).filter(is_basic).collect();
    let mut exact = vec![0.0; z.len()];
    let solved = Polish::default().solve_active(problem.A(), problem.b(), scaling, &active, &active, &mut exact);
    exact.iter_mut().zip(problem.free()).for_each(|(z, free)| *z = if *free { *z } else { z.max(0.0) });
    (solved && is_solution(&exact)).then_some(exact)
}

/// The open pair whose complementarity a point violates most.
fn most_violated(problem: &MixedLcp, pairs: &[PairCase], z: &[f64]) -> Option<usize> {
    let (w, scaling) = (problem.w(z), problem.scaling());
    let violation = |i: &usize| (scaling.z()[*i] * z[*i]).min(scaling.w()[*i] * w[*i]);
    let open = (0..z.len()).filter(|&i| !problem.free()[i] && pairs[i] == PairCase::Open);
    open.max_by(|a, b| violation(a).total_cmp(&violation(b)))
}

/// Cases that can be looked at in a problem with `n` rows within some seconds; none in very large ones.
pub fn tractable_cases(n: usize) -> usize {
    const PRODUCTS: f64 = 4e9;
    const MOST: f64 = 1e4;
    (PRODUCTS / (n as f64).powi(3)).min(MOST) as usize
}

/// Decides a problem that a method left open, where a search through its cases is tractable: the solution gets the point or the status that
/// the search ended with. Gives back the proof that there is no solution.
///
/// Without it a method's [`Ray`](Status::Ray) says that the method found no solution, and nothing else.
pub fn decide(problem: &MixedLcp, solution: &mut Solution) -> Option<Exclusion> {
    if solution.status.is_solved() {
        return None;
    }
    match exclude(problem, tractable_cases(problem.len())) {
        Existence::Excluded(exclusion) => {
            solution.status = match &exclusion.cases[..] {
                [case] if exclusion.is_infeasible() => Status::Infeasible(Farkas { y: case.multipliers.clone() }),
                _ => Status::NoSolution,
            };
            Some(exclusion)
        }
        Existence::Solved(z) => {
            (solution.w, solution.residual) = (problem.w(&z), problem.residual(&z));
            solution.basis = Basis::from_signs(&z, &solution.w);
            (solution.z, solution.status) = (z, Status::Solved);
            None
        }
        Existence::Undecided => None,
    }
}

/// Looks for a proof that the inequalities `z ≥ 0`, `w ≥ 0` of a problem contradict each other, without any complementarity.
///
/// A ray of Lemke's method says that the method found no solution; this says whether the inequalities already exclude one (squeezed).
/// `None` where they do not, or where rounding hides it.
pub fn infeasibility(problem: &MixedLcp) -> Option<Farkas> {
    let (case, _) = look_at(problem, vec![PairCase::Open; problem.len()]);
    (case.residual(problem) <= ACCEPTED).then_some(Farkas { y: case.multipliers })
}
