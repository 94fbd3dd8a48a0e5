//! Proofs that a complementarity problem has no solution.

use crate::MixedLcp;

/// What a case says of a complementary pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PairCase {
    /// Nothing: `z ≥ 0` and `w ≥ 0`.
    #[default]
    Open,
    /// `z = 0`, `w ≥ 0`.
    NoZ,
    /// `w = 0`, `z ≥ 0`.
    NoW,
}

/// A case that has no solution, and the multipliers that prove it (Farkas' lemma).
///
/// With `y_i ≥ 0` where the case lets `w_i` be positive, and of any sign where `w_i = 0`,
///
/// ```text
/// (Aᵀy)_j ≤ 0 where z_j ≥ 0,   (Aᵀy)_j = 0 where z_j is free,   s = −bᵀy > 0
/// ```
///
/// leave no `z`: `yᵀw = (Aᵀy)ᵀz + bᵀy ≤ −s` for every `z` of the case, and `yᵀw ≥ 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcludedCase {
    /// What is decided of every pair, `[n]`; nothing on free rows.
    pub pairs: Vec<PairCase>,
    /// `y`, `[n]`.
    pub multipliers: Vec<f64>,
}

/// A proof that a problem has no solution: cases that together are all there are, each of them excluded.
///
/// One case in which nothing is decided is the proof that already the inequalities `z ≥ 0`, `w ≥ 0` contradict each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exclusion {
    /// The cases.
    pub cases: Vec<ExcludedCase>,
}

impl Exclusion {
    /// Whether the inequalities alone contradict each other: no complementarity was needed.
    pub fn is_infeasible(&self) -> bool {
        matches!(&self.cases[..], [case] if case.pairs.iter().all(|pair| *pair == PairCase::Open))
    }

    /// How far this is from a proof, from the data alone: 0 for one without rounding, infinite where a case is missing or not excluded at
    /// all, else the worst of its [cases](ExcludedCase::residual).
    pub fn residual(&self, problem: &MixedLcp) -> f64 {
        let fits = |case: &ExcludedCase| {
            let still = case.pairs.iter().zip(problem.free()).all(|(pair, free)| !free || *pair == PairCase::Open);
            case.pairs.len() == problem.len() && still
        };
        if !self.cases.iter().all(fits) || !covers_all(&self.cases) {
            return f64::INFINITY;
        }
        self.cases.iter().map(|case| case.residual(problem)).fold(0.0, f64::max)
    }

    /// Rows with a multiplier in some case, ascending.
    pub fn rows(&self) -> Vec<usize> {
        let n = self.cases.iter().map(|case| case.multipliers.len()).max().unwrap_or(0);
        let involved = |i: &usize| self.cases.iter().any(|case| case.multipliers.get(*i).is_some_and(|y| *y != 0.0));
        (0..n).filter(involved).collect()
    }
}

impl ExcludedCase {
    /// How far the multipliers are from a proof; 0 for a proof without rounding, infinite for none at all.
    ///
    /// Rounding leaves a remainder in the columns that should not be positive, which excludes `z` up to a certain size alone: there is no
    /// `z` whose terms `|A_ij z_j|` all are below `s / Σ_j ε_j Y_j`, with `ε_j` the part of the terms of `(Aᵀy)_j` that did not cancel and
    /// `Y_j` the sum of the multipliers of the rows that have column j, all in the unit of the [scaling](crate::Scaling). The residual is
    /// `max|b|` over that size.
    pub fn residual(&self, problem: &MixedLcp) -> f64 {
        let (n, y, unit) = (problem.len(), &self.multipliers, problem.scaling().w());
        let fits = y.len() == n && self.pairs.len() == n;
        if !fits || !(0..n).all(|i| y[i].is_finite() && (y[i] >= 0.0 || self.is_equation(problem, i))) {
            return f64::INFINITY;
        }
        let shortfall = -(0..n).map(|i| problem.b()[i] * y[i]).sum::<f64>();
        if shortfall <= 0.0 || !shortfall.is_finite() {
            return f64::INFINITY;
        }
        let (mut sums, mut terms, mut multipliers) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for i in (0..n).filter(|&i| y[i] != 0.0) {
            for (j, a) in problem.A().row(i).iter().enumerate().filter(|(_, a)| **a != 0.0) {
                sums[j] += a * y[i];
                terms[j] += (a * y[i]).abs();
                multipliers[j] += y[i].abs() / unit[i];
            }
        }
        let left = |j: usize| match self.pairs[j] {
            _ if terms[j] == 0.0 => 0.0,
            _ if problem.free()[j] => f64::abs(sums[j]),
            PairCase::NoZ => 0.0,
            _ => f64::max(sums[j], 0.0),
        };
        let size = (0..n).map(|i| (problem.b()[i] * unit[i]).abs()).fold(0.0, f64::max);
        size * (0..n).map(|j| left(j) / terms[j].max(f64::MIN_POSITIVE) * multipliers[j]).sum::<f64>() / shortfall
    }

    /// Whether the case says `w_i = 0`.
    fn is_equation(&self, problem: &MixedLcp, i: usize) -> bool {
        problem.free()[i] || self.pairs[i] == PairCase::NoW
    }
}

/// Whether every choice of `z_i = 0` or `w_i = 0` for all pairs is within one of the cases.
fn covers_all(cases: &[ExcludedCase]) -> bool {
    let mut parts: Vec<(Vec<usize>, Vec<usize>)> = vec![((0..cases.len()).collect(), Vec::new())];
    // A part: the cases that do not contradict what has been decided, and the pairs that were.
    while let Some((members, decided)) = parts.pop() {
        let next = |case: &ExcludedCase| {
            (0..case.pairs.len()).find(|i| case.pairs[*i] != PairCase::Open && !decided.contains(i))
        };
        let Some(&first) = members.first() else { return false };
        if members.iter().any(|&m| next(&cases[m]).is_none()) {
            continue;
        }
        let Some(pair) = next(&cases[first]) else { continue };
        for excluded in [PairCase::NoZ, PairCase::NoW] {
            let rest = members.iter().copied().filter(|&m| cases[m].pairs[pair] != excluded).collect();
            parts.push((rest, decided.iter().copied().chain([pair]).collect()));
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(pairs: &str) -> ExcludedCase {
        let pair = |c| match c {
            'z' => PairCase::NoZ,
            'w' => PairCase::NoW,
            _ => PairCase::Open,
        };
        ExcludedCase { pairs: pairs.chars().map(pair).collect(), multipliers: vec![0.0; pairs.len()] }
    }

    #[test]
    fn a_missing_case_is_seen() {
        let covers = |cases: &[&str]| covers_all(&cases.iter().map(|text| case(text)).collect::<Vec<_>>());
        assert!(covers(&["..."]) && covers(&["z..", "w.."]) && covers(&["zz.", "zw.", "w.z", "w.w"]));
        assert!(covers(&["z..", ".w.", "wz."]));
        assert!(!covers(&[]) && !covers(&["z.."]) && !covers(&["zz.", "ww."]) && !covers(&["zz.", "zw.", "w.z"]));
    }

    /// Every set of cases over three pairs that a binary number chooses, against all eight choices one by one.
    #[test]
    fn covering_agrees_with_counting() {
        let words: Vec<String> =
            (0..27).map(|k: usize| [k / 9, k / 3 % 3, k % 3].iter().map(|d| ['.', 'z', 'w'][*d]).collect()).collect();
        for number in 0..5000_u64 {
            let chosen = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 37;
            let cases: Vec<_> =
                (0..27).filter(|k| chosen >> k & 1 == 1 && k % 3 != 0).map(|k| case(&words[k])).collect();
            let within = |choice: usize, case: &ExcludedCase| {
                (0..3).all(|i| {
                    case.pairs[i] == PairCase::Open || (case.pairs[i] == PairCase::NoZ) == (choice >> i & 1 == 0)
                })
            };
            let all = (0..8).all(|choice| cases.iter().any(|case| within(choice, case)));
            assert_eq!(covers_all(&cases), all, "{number}");
        }
    }
}
