use crate::Refusal;
use crate::equilibrate::Scaled;
use crate::factored_basis::FactoredBasis;
use crate::fingerprint::{Seen, mix};

/// Numbers that steer a walk; all refer to the equilibrated problem, whose data have size 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) pivots: usize,
    pub(super) updates: usize,
    pub(super) tie: f64,
    pub(super) pivot: f64,
}

/// How a walk ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    Complementary,
    /// The driving variable of this pair grows without bound.
    Unbounded(usize),
    Refused(Refusal),
    Cycle,
    Limit,
    Singular,
}

/// The walk through principal (complementary) bases.
///
/// In every basis one variable of a pair is basic, the other is not. A nonbasic variable stands at its bound: 0, or
/// `lower < 0`, below every basic variable of the start. A pair is in order when both its variables are nonnegative. In
/// a major cycle the nonbasic variable of a pair that is not in order, the driving variable, grows until the pair is;
/// the basic variable of any other pair stops it on the way at its bound, which is 0 for a nonnegative one and `lower`
/// for a negative one, and leaves in exchange with its complement, or, where their diagonal entry vanishes, together
/// with the driving pair in a 2×2 pivot. Pairs in order stay in order, so there are at most n major cycles.
///
/// Of tied blocking variables the one of the least index leaves.
///
/// Source: Dantzig, Cottle (1967); Cottle, Pang, Stone (2009), §4.3; the least-index rule for sufficient matrices is
/// that of Cottle, Chang (1992).
#[derive(Clone, Debug, Default)]
pub(super) struct Walk {
    pub(super) basis: FactoredBasis,
    pub(super) pivots: usize,
    pub(super) factorizations: usize,
    /// Basic variables by position, and the position of each pair's.
    pub(super) x: Vec<f64>,
    place: Vec<usize>,
    /// The nonbasic variable of each pair: which, and its value.
    pub(super) nonbasic: Vec<usize>,
    value: Vec<f64>,
    lower: f64,
    /// Transformed columns of the driving variable and of a blocking variable's complement.
    pub(super) driving: Vec<f64>,
    blocked: Vec<f64>,
    rhs: Vec<f64>,
    work: Vec<f64>,
    seen: Seen,
}

/// What stops the driving variable, and after which step.
enum Stop {
    InOrder(f64),
    Blocked(usize, f64),
    Never,
}

impl Walk {
    /// Walks from the complementary basis `z_basic`.
    pub(super) fn run(&mut self, problem: &Scaled, z_basic: &[bool], limits: Limits) -> End {
        let n = problem.n;
        (self.pivots, self.factorizations) = (0, 0);
        for v in [&mut self.x, &mut self.value, &mut self.driving, &mut self.blocked, &mut self.rhs, &mut self.work] {
            v.clear();
            v.resize(n, 0.0);
        }
        self.basis.start(n, z_basic);
        self.nonbasic.clear();
        self.nonbasic.extend((0..n).map(|i| if z_basic[i] { i } else { n + i }));
        if !self.refresh(problem) {
            return End::Singular;
        }
        self.lower = -2.0 * self.size();
        while let Some(pair) = self.worst_pair(limits) {
            if let Err(end) = self.drive(problem, pair, limits) {
                return end;
            }
        }
        End::Complementary
    }

    fn size(&self) -> f64 {
        self.x.iter().fold(1.0, |max, x| max.max(x.abs()))
    }

    /// The pair that is furthest from being in order.
    fn worst_pair(&self, limits: Limits) -> Option<usize> {
        let slack = limits.tie * self.size();
        let least = |i: usize| self.value[i].min(self.x[self.place[i]]);
        (0..self.place.len()).filter(|&i| least(i) < -slack).min_by(|&i, &j| least(i).total_cmp(&least(j)))
    }

    /// One major cycle.
    fn drive(&mut self, problem: &Scaled, pair: usize, limits: Limits) -> Result<(), End> {
        self.seen.clear();
        loop {
            if self.pivots >= limits.pivots {
                return Err(End::Limit);
            }
            if self.basis.updates() >= limits.updates && !self.refresh(problem) {
                return Err(End::Singular);
            }
            let memory = [&mut self.rhs[..], &mut self.work[..]];
            transformed(&mut self.basis, problem, self.nonbasic[pair], &mut self.driving, memory);
            let done = match self.step(problem, pair, limits) {
                // Believed only with fresh factors.
                Err(_) if self.basis.updates() > 0 => {
                    if !self.refresh(problem) {
                        return Err(End::Singular);
                    }
                    continue;
                }
                other => other?,
            };
            if done {
                return Ok(());
            }
            if !self.seen.insert(self.fingerprint()) {
                return Err(End::Cycle);
            }
        }
    }

    /// Grows the driving variable until something stops it, and pivots; true when the pair is in order.
    fn step(&mut self, problem: &Scaled, pair: usize, limits: Limits) -> Result<bool, End> {
        let place = self.place[pair];
        let floor = self.floor(&self.driving, limits);
        let diagonal = -self.driving[place];
        if diagonal < -floor {
            return Err(End::Refused(Refusal::NotSufficient { row: pair, col: pair, value: diagonal }));
        }
        match self.ratio_test(pair, floor, limits) {
            Stop::Never => Err(End::Unbounded(pair)),
            Stop::InOrder(step) => {
                self.advance(pair, step);
                if self.x[place] <= self.value[pair] && diagonal > floor {
                    self.x[place] = self.value[pair];
                    self.nonbasic[pair] = self.replace(place, self.nonbasic[pair]);
                }
                self.value[pair] = 0.0;
                Ok(true)
            }
            Stop::Blocked(other, step) => {
                self.leave(problem, pair, other, step, limits)?;
                Ok(false)
            }
        }
    }

    /// Entries of a column below this count as zero.
    fn floor(&self, column: &[f64], limits: Limits) -> f64 {
        limits.pivot * column.iter().fold(1e-3f64, |max, a| max.max(a.abs()))
    }

    /// What happens first: the pair gets in order, or the basic variable of another pair reaches its bound.
    fn ratio_test(&self, pair: usize, floor: f64, limits: Limits) -> Stop {
        let slack = limits.tie * self.size();
        let (basic, rate) = (self.x[self.place[pair]], -self.driving[self.place[pair]]);
        let for_basic = match basic {
            x if x >= 0.0 => 0.0,
            x if rate > floor => -x / rate,
            _ => f64::INFINITY,
        };
        let in_order = for_basic.max(-self.value[pair]);
        let room = |i: usize| {
            let x = self.x[self.place[i]];
            (if x >= -slack { x.max(0.0) } else { x - self.lower }).max(0.0)
        };
        let blocking = |i: &usize| *i != pair && self.driving[self.place[*i]] > floor;
        // Harris: within this bound every basic variable stays above its own less `slack`.
        let bound = (0..self.place.len())
            .filter(blocking)
            .map(|i| (room(i) + slack) / self.driving[self.place[i]])
            .fold(f64::INFINITY, f64::min);
        let first = (0..self.place.len())
            .filter(blocking)
            .map(|i| (i, room(i) / self.driving[self.place[i]]))
            .find(|(_, ratio)| *ratio <= bound);
        match first {
            _ if in_order.is_finite() && in_order <= bound => Stop::InOrder(in_order),
            Some((i, ratio)) => Stop::Blocked(i, ratio),
            None => Stop::Never,
        }
    }

    fn advance(&mut self, pair: usize, step: f64) {
        self.value[pair] += step;
        self.x.iter_mut().zip(&self.driving).for_each(|(x, a)| *x -= step * a);
    }

    /// Exchanges the variables of `other`, or both pairs where its diagonal entry vanishes.
    fn leave(&mut self, problem: &Scaled, pair: usize, other: usize, step: f64, limits: Limits) -> Result<(), End> {
        let memory = [&mut self.rhs[..], &mut self.work[..]];
        transformed(&mut self.basis, problem, self.nonbasic[other], &mut self.blocked, memory);
        let floor = self.floor(&self.blocked, limits);
        let (place, other_place) = (self.place[pair], self.place[other]);
        let diagonal = -self.blocked[other_place];
        let across = -self.blocked[place];
        if diagonal < -floor {
            return Err(End::Refused(Refusal::NotSufficient { row: other, col: other, value: diagonal }));
        }
        if diagonal <= floor && across <= floor {
            return Err(End::Refused(Refusal::NotSufficient { row: pair, col: other, value: across }));
        }
        let bound = if self.x[other_place] >= -limits.tie * self.size() { 0.0 } else { self.lower };
        self.advance(pair, step);
        self.x[other_place] = self.value[other];
        self.value[other] = bound;
        if diagonal > floor {
            std::mem::swap(&mut self.driving, &mut self.blocked);
            self.nonbasic[other] = self.replace(other_place, self.nonbasic[other]);
            return Ok(());
        }
        // 2×2: the driving variable takes the place of the blocking one, whose complement takes that of the basic
        // variable of the pair, which becomes the driving one.
        let (driving_value, basic_value, entering_value) = (self.value[pair], self.x[place], self.x[other_place]);
        let ratio = self.blocked[other_place] / self.driving[other_place];
        self.blocked.iter_mut().zip(&self.driving).for_each(|(b, a)| *b -= ratio * a);
        self.blocked[other_place] = ratio;
        let blocking = self.replace(other_place, self.nonbasic[pair]);
        std::mem::swap(&mut self.driving, &mut self.blocked);
        self.nonbasic[pair] = self.replace(place, self.nonbasic[other]);
        self.nonbasic[other] = blocking;
        self.place.swap(pair, other);
        self.x[other_place] = driving_value;
        self.x[place] = entering_value;
        self.value[pair] = basic_value;
        Ok(())
    }

    /// Puts a variable, transformed in `driving`, in the place of the one at `position`, which it returns.
    fn replace(&mut self, position: usize, entering: usize) -> usize {
        let leaving = self.basis.head[position];
        self.basis.replace(position, entering, &self.driving);
        self.pivots += 1;
        leaving
    }

    /// Fresh factors and basic variables, refined; false when the basis is singular.
    fn refresh(&mut self, problem: &Scaled) -> bool {
        let n = problem.n;
        self.factorizations += 1;
        if self.basis.factorize(problem) == 0.0 {
            return false;
        }
        self.place.clear();
        self.place.resize(n, 0);
        for (position, &variable) in self.basis.head.iter().enumerate() {
            self.place[if variable < n { variable } else { variable - n }] = position;
        }
        self.rhs.copy_from_slice(&problem.b);
        for (&variable, &value) in self.nonbasic.iter().zip(&self.value).filter(|(_, value)| **value != 0.0) {
            match variable {
                v if v < n => self.rhs[v] -= value,
                v => problem.add_column(v - n, value, &mut self.rhs),
            }
        }
        self.x.copy_from_slice(&self.rhs);
        refined(&mut self.basis, problem, &self.rhs, &mut self.x, &mut self.work);
        true
    }

    /// A hash of the basis and of the bounds at which the nonbasic variables stand.
    fn fingerprint(&self) -> u64 {
        let at = |(&variable, &value): (&usize, &f64)| mix(2 * variable as u64 + u64::from(value < 0.0));
        self.nonbasic.iter().zip(&self.value).map(at).fold(0, |hash, x| hash ^ x)
    }
}

/// `out ← B⁻¹ (column of variable)`, refined once when the factors are fresh; `rhs` and `work` are memory.
fn transformed(
    basis: &mut FactoredBasis,
    problem: &Scaled,
    variable: usize,
    out: &mut [f64],
    [rhs, work]: [&mut [f64]; 2],
) {
    basis.column_into(problem, variable, out);
    if basis.updates() > 0 {
        basis.solve(problem, out);
        return;
    }
    rhs.copy_from_slice(out);
    refined(basis, problem, rhs, out, work);
}

/// `x ← B⁻¹ x` with one step of refinement; `rhs` holds a copy of `x`.
fn refined(basis: &mut FactoredBasis, problem: &Scaled, rhs: &[f64], x: &mut [f64], work: &mut [f64]) {
    basis.solve(problem, x);
    basis.residual_into(problem, rhs, x, work);
    basis.solve(problem, work);
    x.iter_mut().zip(work).for_each(|(x, dx)| *x += *dx);
}
