//! The Taylor series of a central path around one of its points.
//!
//! All equations of the path are linear but for the products of the pairs and, on the way to Coulomb's law, for that of its share with
//! the multipliers. So each coefficient of the series solves the linear system of the tangent, with sums of products of the
//! coefficients before it on the other side: one factorisation gives as many as one likes, each for a solve, and a step goes as far
//! as they are accurate. This is the asymptotic numerical method of Cochelin (1994). The series' variable is the length along the
//! tangent at the point, with all numbers measured relative to their values there.

use super::point::{Ground, InteriorPoint};
use signorini_contact::vector::inner;

/// What is tuned in series.
pub(super) struct Tuning {
    /// Coefficients.
    order: usize,
    /// What the last of them may add to a number, relative to its value at the end of the step.
    accurate: f64,
    /// What is left of a number at the end of a step at least.
    pub least_left: f64,
}

/// Chosen by: no command on record, since 22 November 2026.
pub(super) const SERIES: Tuning = Tuning { order: 8, accurate: 0.005, least_left: 0.02 };

const ORDER: usize = SERIES.order;

/// What changes along a leg of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Parameter {
    /// The law at this product: to Coulomb's if `ahead` is 1; from Coulomb's back, until it is that again, if `ahead` is −1.
    Law { product: f64, ahead: f64 },
    /// The product, from `most` down to `target`, or until it is `most` again. All products are in units of a squared velocity.
    Product { target: f64, most: f64 },
}

impl Parameter {
    /// Of the numbers relative to themselves, the parameter's first: how many are not.
    pub fn skipped(self) -> usize {
        usize::from(matches!(self, Self::Law { .. }))
    }
}

/// How an interior point changes: by its rates, or by a coefficient of a series.
#[derive(Clone, Debug, Default)]
pub(super) struct Rates {
    /// In parts of the product, or in units of the law's share.
    pub parameter: f64,
    /// Of each unit's impulse and slack.
    units: Vec<[f64; 4]>,
    /// Of each edge's distance and multiplier.
    edges: Vec<[f64; 2]>,
    velocity: Vec<f64>,
    /// The parameter's, and then those of all pairs, relative to their numbers.
    pub relative: Vec<f64>,
}

impl Rates {
    /// Takes the rates at hand.
    pub fn take(&mut self, interior: &InteriorPoint, parameter: f64) {
        self.parameter = parameter;
        self.units.clear();
        self.edges.clear();
        self.relative.clear();
        self.relative.push(parameter);
        for unit in &interior.units {
            let [n, a, b] = unit.impulse_rate;
            self.units.push([n, a, b, unit.slack_rate]);
            if unit.has_normal {
                self.relative.extend([n / unit.impulse[0], unit.slack_rate / unit.slack]);
            }
        }
        for edge in &interior.edges {
            self.edges.push([edge.distance_rate, edge.multiplier_rate]);
            self.relative.extend([edge.distance_rate / edge.distance, edge.multiplier_rate / edge.multiplier]);
        }
        self.velocity.clone_from(&interior.velocity_rate);
    }

    /// Makes them the rates at hand.
    pub fn give(&self, interior: &mut InteriorPoint) {
        for (unit, [n, a, b, slack]) in interior.units.iter_mut().zip(&self.units) {
            (unit.impulse_rate, unit.slack_rate) = ([*n, *a, *b], *slack);
        }
        for (edge, [distance, multiplier]) in interior.edges.iter_mut().zip(&self.edges) {
            (edge.distance_rate, edge.multiplier_rate) = (*distance, *multiplier);
        }
        interior.velocity_rate.clone_from(&self.velocity);
    }

    /// Makes them `factor` times others.
    pub fn set(&mut self, factor: f64, other: &Self) {
        self.clone_from(other);
        self.change(|x, _| factor * x, other);
    }

    /// Adds `factor` times others.
    pub fn add(&mut self, factor: f64, other: &Self) {
        self.change(|x, y| x + factor * y, other);
    }

    fn change(&mut self, f: impl Fn(f64, f64) -> f64, other: &Self) {
        let all = |own: &mut [f64], other: &[f64]| own.iter_mut().zip(other).for_each(|(x, y)| *x = f(*x, *y));
        self.parameter = f(self.parameter, other.parameter);
        all(self.units.as_flattened_mut(), other.units.as_flattened());
        all(self.edges.as_flattened_mut(), other.edges.as_flattened());
        all(&mut self.velocity, &other.velocity);
        all(&mut self.relative, &other.relative);
    }
}

/// A step along a path: the length that it may have, and how the series goes with the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ahead {
    /// Of the tangent, for one unit of length; negative where the parameter falls.
    pub along: f64,
    /// The most, over which the correction is made.
    pub length: f64,
    /// Of the tangent, in the correction.
    pub correction: f64,
}

/// The coefficients of a series, the first one first.
#[derive(Clone, Debug, Default)]
pub(super) struct Series {
    orders: [Rates; ORDER],
    /// All numbers at a length, relative to those at the beginning.
    values: Vec<f64>,
}

impl Series {
    /// Finds the coefficients at the present point, whose system is factorised. Momentum and bilateral rows have no residuals, as a
    /// tangent leaves them.
    ///
    /// - `direction`: the direction of the path there, of length 1 in relative numbers
    /// - `tangent`, `correction`: the rates for one unit of the parameter, and those of Newton's step to the path
    pub fn find(
        &mut self,
        interior: &mut InteriorPoint,
        ground: &mut Ground,
        parameter: Parameter,
        (direction, tangent, correction): (&[f64], &Rates, &Rates),
        ahead: Ahead,
    ) {
        let [first, ..] = &mut self.orders;
        first.set(ahead.along + ahead.correction / ahead.length, tangent);
        first.add(1.0 / ahead.length, correction);
        for n in 2..=ORDER {
            let (known, rest) = self.orders.split_at_mut(n - 1);
            interior.take_products(known, parameter);
            interior.find_rates(ground, 0.0, false);
            let next = &mut rest[0];
            next.take(interior, 0.0);
            // The variable is the length along the direction: the coefficients after the first one are across it.
            next.add(-ahead.along * inner(&next.relative, direction), tangent);
        }
    }

    /// The length, `most` at most, to which the series is accurate and all numbers stay positive. The first `skipped` numbers may have any
    /// sign.
    pub fn accurate_length(&mut self, most: f64, skipped: usize) -> f64 {
        let last = &self.orders[ORDER - 1].relative;
        let largest = last.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut high = most.min((SERIES.accurate / largest).powf(1.0 / ORDER as f64));
        if self.is_accurate(high, skipped) {
            return high;
        }
        let mut low = 0.0;
        // As many halvings as coefficients are enough: an error of the length counts in this power.
        for _ in 0..ORDER {
            let middle = 0.5 * (low + high);
            *if self.is_accurate(middle, skipped) { &mut low } else { &mut high } = middle;
        }
        if low > 0.0 { low } else { high }
    }

    fn is_accurate(&mut self, length: f64, skipped: usize) -> bool {
        self.find_values(length);
        let (last, power) = (&self.orders[ORDER - 1].relative, length.powi(ORDER as i32));
        let holds = |(x, last): (&f64, &f64)| *x > SERIES.least_left && last.abs() * power <= SERIES.accurate * x;
        self.values.iter().zip(last).skip(skipped).all(holds)
    }

    /// The length, `most` at most, at which the parameter has changed by `change`; none if it has not there.
    pub fn length_to(&self, change: f64, most: f64) -> Option<f64> {
        if self.parameter_change(most) < change {
            return None;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            *if self.parameter_change(middle) < change { &mut low } else { &mut high } = middle;
        }
        Some(high)
    }

    fn parameter_change(&self, length: f64) -> f64 {
        self.orders.iter().rev().fold(0.0, |sum, rates| (sum + rates.parameter) * length)
    }

    /// Adds up the changes over a length.
    pub fn sum(&self, length: f64, sum: &mut Rates) {
        let mut power = length;
        sum.set(power, &self.orders[0]);
        for rates in &self.orders[1..] {
            power *= length;
            sum.add(power, rates);
        }
    }

    /// The direction of the path at a length, of length 1 in numbers relative to those there; it has no part in the correction that the
    /// series makes, which ends there. The first `skipped` numbers are relative to what they always are.
    pub fn find_direction(
        &mut self,
        (along, tangent): (f64, &Rates),
        length: f64,
        skipped: usize,
        direction: &mut Vec<f64>,
    ) {
        self.find_values(length);
        direction.clear();
        direction.resize(self.values.len(), 0.0);
        for (k, rates) in self.orders.iter().enumerate().skip(1).rev() {
            let factor = (k + 1) as f64;
            direction.iter_mut().zip(&rates.relative).for_each(|(d, x)| *d = (*d + factor * x) * length);
        }
        direction.iter_mut().zip(&tangent.relative).for_each(|(d, t)| *d += along * t);
        direction.iter_mut().zip(&self.values).skip(skipped).for_each(|(d, x)| *d /= x);
        let size = inner(direction, direction).sqrt();
        direction.iter_mut().for_each(|d| *d /= size);
    }

    fn find_values(&mut self, length: f64) {
        self.values.clear();
        self.values.resize(self.orders[0].relative.len(), 0.0);
        for rates in self.orders.iter().rev() {
            self.values.iter_mut().zip(&rates.relative).for_each(|(sum, x)| *sum = (*sum + x) * length);
        }
        self.values.iter_mut().for_each(|x| *x += 1.0);
    }
}

impl InteriorPoint {
    /// Makes what the pairs lack, and the normal velocities, those of the coefficient after the ones that are known.
    fn take_products(&mut self, known: &[Rates], parameter: Parameter) {
        let pairs = || known.iter().zip(known.iter().rev());
        for (c, unit) in self.units.iter_mut().enumerate() {
            let products: f64 = pairs().map(|(a, b)| a.units[c][0] * b.units[c][3]).sum();
            // Less the product itself, which is no part of a coefficient.
            unit.correction = products - unit.impulse[0] * unit.slack;
            (unit.normal_residual, unit.tangential_residual) = (0.0, [0.0; 2]);
            for e in unit.edges.0..unit.edges.1 {
                let edge = &mut self.edges[e];
                let products: f64 = pairs().map(|(a, b)| a.edges[e][0] * b.edges[e][1]).sum();
                edge.correction = products - edge.distance * edge.multiplier;
                if matches!(parameter, Parameter::Law { .. }) {
                    let products: f64 = pairs().map(|(a, b)| a.parameter * b.edges[e][1]).sum();
                    unit.normal_residual += edge.reach * products;
                }
            }
        }
    }
}
