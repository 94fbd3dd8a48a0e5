use crate::Outcome;
use crate::equilibrate::Scaled;
use crate::factored_basis::FactoredBasis;
use crate::fingerprint::{Seen, mix};
use crate::linalg::{add_scaled_wide, ratio_bound};

/// Numbers that steer one walk; all refer to the equilibrated problem, whose data have size 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) pivots: usize,
    /// Updates of the basis before it is factorised afresh.
    pub(super) updates: usize,
    /// Ratios closer than this, relative to the size of the basic solution, are a tie.
    pub(super) tie: f64,
    /// Entries of a transformed column below this, relative to its largest, count as zero.
    pub(super) pivot: f64,
    /// Whether a ray is looked at once more with fresh factors: not where one is known and a solution is all that is sought.
    pub(super) confirm: bool,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    pub(super) outcome: Outcome,
    pub(super) pivots: usize,
    pub(super) factorizations: usize,
    /// The variable that was to enter when the walk ended; with the column `a` it makes the ray.
    pub(super) entering: usize,
}

/// Lemke's path through the almost complementary bases of one problem.
///
/// Degeneracy is resolved lexicographically on the rows of `[B⁻¹b | B⁻¹P]`: `b` is read as `b + εP` with an
/// infinitesimal ε and a seeded positive `P`, of which no two rows are in proportion.
///
/// Source: Cottle, Pang, Stone (2009), §4.4 and §4.9.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    pub(super) basis: FactoredBasis,
    /// Basic solution `B⁻¹b` by position.
    pub(super) x: Vec<f64>,
    /// First-order change of the basic solution, `B⁻¹P`.
    xp: Vec<f64>,
    p: Vec<f64>,
    /// Transformed entering column `B⁻¹ a`.
    pub(super) a: Vec<f64>,
    rhs: Vec<f64>,
    work: Vec<f64>,
    /// Positions whose ratio may be the smallest.
    near: Vec<usize>,
    seen: Seen,
    /// The hashes of the basic variables, added without carries.
    hash: u64,
}

/// The choice of a ratio test.
enum Leaving {
    Position(usize),
    /// The smallest ratio hangs on an entry too small to trust.
    Doubtful(usize),
    None,
}

impl Path {
    /// Walks from the complementary basis `z_basic` with the covering vector `d = B c`.
    ///
    /// - `cover`: c > 0, by position
    /// - `perturbation`: B⁻¹P at the start, positive
    pub(super) fn walk(
        &mut self,
        problem: &Scaled,
        z_basic: &[bool],
        cover: &[f64],
        perturbation: &[f64],
        limits: Limits,
    ) -> Walk {
        let n = problem.n;
        for v in [&mut self.x, &mut self.xp, &mut self.p, &mut self.a, &mut self.rhs, &mut self.work] {
            v.clear();
            v.resize(n, 0.0);
        }
        self.seen.clear();
        self.basis.start(n, z_basic);
        let mut walk = Walk { outcome: Outcome::Singular, pivots: 0, factorizations: 0, entering: 2 * n };
        if self.basis.factorize(problem) == 0.0 {
            return walk;
        }
        let mut d = std::mem::take(&mut self.basis.d);
        self.basis.multiply_into(problem, cover, &mut d);
        self.basis.multiply_into(problem, perturbation, &mut self.p);
        self.basis.d = d;
        self.hash = self.basis.head.iter().fold(0, |hash, &v| hash ^ mix(v as u64));
        if z_basic.contains(&true) {
            if !self.refresh(problem, &mut walk) {
                return walk;
            }
        } else {
            self.x.copy_from_slice(&problem.b);
            self.xp.copy_from_slice(&self.p);
        }
        if self.x.iter().all(|&x| x >= -limits.tie * self.size()) {
            walk.outcome = Outcome::Complementary;
            return walk;
        }
        self.enter_covering(cover, &mut walk, limits);
        self.follow(problem, &mut walk, limits);
        walk
    }

    /// The first pivot: `z0` becomes so large that every basic variable is nonnegative.
    fn enter_covering(&mut self, cover: &[f64], walk: &mut Walk, limits: Limits) {
        let n = self.basis.n;
        let least = (0..n).map(|i| self.x[i] / cover[i]).fold(f64::INFINITY, f64::min);
        let slack = limits.tie * self.size();
        let leaving = (0..n)
            .filter(|&i| self.x[i] / cover[i] <= least + slack)
            .min_by(|&i, &j| (self.xp[i] / cover[i]).total_cmp(&(self.xp[j] / cover[j])))
            .unwrap_or(0);
        self.a.iter_mut().zip(cover).for_each(|(a, c)| *a = -c);
        walk.entering = self.pivot(leaving, 2 * n);
        walk.pivots = 1;
    }

    fn follow(&mut self, problem: &Scaled, walk: &mut Walk, limits: Limits) {
        let z0 = 2 * problem.n;
        loop {
            if walk.pivots >= limits.pivots {
                walk.outcome = Outcome::IterationLimit;
                return;
            }
            if self.basis.updates() >= limits.updates && !self.refresh(problem, walk) {
                return;
            }
            self.transform(problem, walk.entering);
            let leaving = match self.ratio_test(z0, limits) {
                Leaving::Position(position) => position,
                Leaving::None if !limits.confirm => {
                    walk.outcome = Outcome::Ray;
                    return;
                }
                // Decide again on exactly recomputed numbers; if these say the same, it is so.
                _ if self.basis.updates() > 0 => {
                    if !self.refresh(problem, walk) {
                        return;
                    }
                    continue;
                }
                Leaving::Doubtful(position) => position,
                Leaving::None => {
                    walk.outcome = Outcome::Ray;
                    return;
                }
            };
            let done = self.basis.head[leaving] == z0;
            walk.entering = self.pivot(leaving, walk.entering);
            walk.pivots += 1;
            if done {
                walk.outcome = Outcome::Complementary;
                return;
            }
            // The basis, and what enters it.
            if !self.seen.insert(self.hash ^ mix(walk.entering as u64 ^ 0x5bd1_e995)) {
                walk.outcome = Outcome::Cycle;
                return;
            }
        }
    }

    /// `a ← B⁻¹ (column of entering)`, refined once when the factors are fresh.
    fn transform(&mut self, problem: &Scaled, entering: usize) {
        self.basis.column_into(problem, entering, &mut self.a);
        if self.basis.updates() > 0 {
            self.basis.solve(problem, &mut self.a);
            return;
        }
        self.rhs.copy_from_slice(&self.a);
        self.basis.solve(problem, &mut self.a);
        self.basis.residual_into(problem, &self.rhs, &self.a, &mut self.work);
        self.basis.solve(problem, &mut self.work);
        self.a.iter_mut().zip(&self.work).for_each(|(a, da)| *a += da);
    }

    /// Fresh factors and basic solution, refined; false when the basis is singular.
    fn refresh(&mut self, problem: &Scaled, walk: &mut Walk) -> bool {
        walk.factorizations += 1;
        if self.basis.factorize(problem) == 0.0 {
            walk.outcome = Outcome::Singular;
            return false;
        }
        for (x, rhs) in [(&mut self.x, &problem.b), (&mut self.xp, &self.p)] {
            x.copy_from_slice(rhs);
            self.basis.solve(problem, x);
            self.basis.residual_into(problem, rhs, x, &mut self.work);
            self.basis.solve(problem, &mut self.work);
            x.iter_mut().zip(&self.work).for_each(|(x, dx)| *x += dx);
        }
        true
    }

    fn size(&self) -> f64 {
        self.x.iter().fold(1.0, |max, x| max.max(x.abs()))
    }

    /// The lexicographic minimum ratio over positive entries of the column; a tie with `z0` ends the walk.
    fn ratio_test(&mut self, z0: usize, limits: Limits) -> Leaving {
        let bound = ratio_bound(&self.x, &self.a, limits.tie, limits.pivot, &mut self.near);
        let mut best: Option<usize> = None;
        for &i in &self.near {
            if self.a[i] > bound.floor && self.x[i].max(0.0) / self.a[i] <= bound.ratio {
                if self.basis.head[i] == z0 {
                    return Leaving::Position(i);
                }
                if best.is_none_or(|j| self.precedes(i, j)) {
                    best = Some(i);
                }
            }
        }
        match best {
            None => Leaving::None,
            Some(i) if self.a[i] < 1e-5 * bound.largest => Leaving::Doubtful(i),
            Some(i) => Leaving::Position(i),
        }
    }

    /// Whether row `i` comes before row `j` in the second column of the lexicographic order; where that is tied
    /// too, the larger pivot comes first.
    fn precedes(&self, i: usize, j: usize) -> bool {
        let (left, right) = (self.xp[i] * self.a[j], self.xp[j] * self.a[i]);
        let tie = 1e-10 * (left.abs() + right.abs());
        if (left - right).abs() <= tie { self.a[i] > self.a[j] } else { left < right }
    }

    /// Exchanges the variable at `position` for `entering` and returns the complement of the one that left.
    fn pivot(&mut self, position: usize, entering: usize) -> usize {
        let n = self.basis.n;
        let leaving = self.basis.head[position];
        for x in [&mut self.x, &mut self.xp] {
            let step = x[position] / self.a[position];
            if step != 0.0 {
                add_scaled_wide(x, -step, &self.a);
            }
            x[position] = step;
        }
        self.basis.replace(position, entering, &self.a);
        self.hash ^= mix(leaving as u64) ^ mix(entering as u64);
        if leaving < n { leaving + n } else { leaving - n }
    }
}
