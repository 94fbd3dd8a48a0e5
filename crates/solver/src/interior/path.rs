//! The central path of Coulomb's law, from a convex problem and around its folds.
//!
//! Coulomb's law is not monotone: on the way to its solution the product `τ` of the pairs may have to rise before it can fall on, and
//! Newton's steps to a smaller one become short there. So `τ` is one more unknown here, and steps go along the path itself, in the
//! direction in which they came: Keller's pseudo-arclength continuation (1977), with all lengths relative to the positive numbers,
//! `δx/x` and `δτ/τ`, and with [series](super::series) in place of tangents.
//!
//! A path needs a point to begin at. That of the associated law, whose velocity along the normal is `u_N − Σ γ μ h` with the multipliers `γ`
//! of the edges, is one of a convex problem: it has no folds, and Newton's method finds every point of it. From a point with large
//! products a first leg takes the law to Coulomb's, `u_N − (1 − θ) Σ γ μ h` with `θ` from 0 to 1, and a second one the products to
//! zero. Where the associated law has no solution its impulses are huge, and the first leg is lost.
//!
//! A second leg that comes back to the products from which it went down goes on with a first one, back towards `θ = 0` until that turns,
//! and so forth: both are one path, whose only other end is the point at `θ = 0`. As in Lemke's method there is then one way to go at
//! every point; unlike there thousands of contacts change their modes along one smooth curve. Steps that jump off it, to where
//! it is passed through the other way round, are [known](super::control) by the sign of the system's determinant, which turns
//! with the parameter at every fold.

use super::control::{Control, Move, Point};
use super::parts::{Edge, Unit};
use super::point::{Ground, INTERIOR, InteriorPoint};
use super::series::{Ahead, Parameter, Rates, SERIES, Series};
use super::unit::UnitSystem;

/// What is tuned in paths.
struct Tuning {
    /// Steps of a path at most.
    path_steps: u32,
    /// Places kept to go back to.
    places: usize,
}

/// Chosen by: `contact_lcp --seeds 74..76 --directions 4,8,16 --no-growth --no-shared`, 23 November 2026.
const TUNING: Tuning = Tuning { path_steps: 8000, places: 8 };

/// How a leg ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LegEnd {
    /// At the small product that was wanted.
    Arrived,
    /// At the other end: with Coulomb's law, or at the product from which it went down.
    Passed,
    Lost,
}

/// Numbers of the interior point, and where on a path it is.
#[derive(Clone, Debug, Default)]
struct Place {
    units: Vec<Unit>,
    edges: Vec<Edge>,
    velocity: Vec<f64>,
    bilateral_impulse: Vec<f64>,
    product: f64,
    share: f64,
    /// The direction in which the path came there.
    direction: Vec<f64>,
}

/// Memory of the steps along a path.
#[derive(Clone, Debug, Default)]
pub(super) struct PathSteps {
    /// Newton's step to the path at the present parameter, and the rates along it for one unit of the parameter.
    correction: Rates,
    tangent: Rates,
    /// The direction of the path in relative numbers, of length 1; empty before the first step.
    direction: Vec<f64>,
    series: Series,
    step: Rates,
    /// Where the last steps along the path began, the latest at the end, and how many of these places are.
    places: Vec<Place>,
    place_count: usize,
    /// What the bilateral rows lack at the present point.
    bilateral_residual: Vec<f64>,
    steps_left: u32,
}

impl InteriorPoint {
    /// Follows the path from near its first point, with this product, until the product has fallen to `target`; both are in units of
    /// a squared velocity. Where it gets no further, that stays.
    pub(super) fn follow(&mut self, ground: &mut Ground, (product, target): (f64, f64), path: &mut PathSteps) {
        let mut ahead = 1.0;
        path.steps_left = TUNING.path_steps;
        loop {
            let law = Parameter::Law { product, ahead };
            if self.follow_leg(ground, law, path) != LegEnd::Passed {
                break;
            }
            self.share = 1.0;
            let fall = Parameter::Product { target, most: product };
            if self.follow_leg(ground, fall, path) != LegEnd::Passed {
                break;
            }
            ahead = -1.0;
        }
    }

    fn follow_leg(&mut self, ground: &mut Ground, parameter: Parameter, path: &mut PathSteps) -> LegEnd {
        let (mut product, ahead) = match parameter {
            Parameter::Law { product, ahead } => (product, ahead),
            Parameter::Product { most, .. } => (most, -1.0),
        };
        let mut control = Control::new();
        path.direction.clear();
        path.place_count = 0;
        while path.steps_left > 0 {
            path.steps_left -= 1;
            match parameter {
                Parameter::Law { .. } if self.share < 0.0 => return LegEnd::Lost,
                Parameter::Product { target, .. } if product <= target => return LegEnd::Arrived,
                _ => {}
            }
            let Some(boundary) = self.look_around(ground, parameter, product, path) else {
                return LegEnd::Lost;
            };
            let orientation = self.orientation(ground, parameter);
            let PathSteps { correction, tangent, direction, .. } = path;
            let point = Point { correction, tangent, boundary, ahead, orientation };
            match control.decide(&point, direction, INTERIOR.steps) {
                Move::Back => {
                    let place = if control.go_back() { path.take_place() } else { None };
                    let Some(place) = place else { return LegEnd::Lost };
                    product = self.restore(ground, &path.places[place]);
                    path.direction.clone_from(&path.places[place].direction);
                }
                Move::Correct { part, along } => {
                    path.step.set(part, &path.correction);
                    path.step.add(part * along, &path.tangent);
                    product = self.take_step(ground, path, part, (parameter, product));
                }
                Move::Advance(ahead) => {
                    let part = self.sum_series(ground, path, (parameter, product), (&mut control, ahead));
                    product = self.take_step(ground, path, part, (parameter, product));
                }
                Move::Land => {
                    path.step.clone_from(&path.correction);
                    self.take_step(ground, path, 1.0, (parameter, product));
                    return LegEnd::Passed;
                }
            }
        }
        LegEnd::Lost
    }

    /// Keeps the present place, and makes the step at hand the way along the path for as long as its series is accurate, at most to
    /// where the leg ends; returns which part of the length ahead that is.
    fn sum_series(
        &mut self,
        ground: &mut Ground,
        path: &mut PathSteps,
        (parameter, product): (Parameter, f64),
        (control, ahead): (&mut Control, Ahead),
    ) -> f64 {
        self.keep(ground, product, path);
        let PathSteps { correction, tangent, direction, series, step, .. } = path;
        series.find(self, ground, parameter, (direction, tangent, correction), ahead);
        let accurate = series.accurate_length(ahead.length, parameter.skipped());
        let end = series.length_to(self.way_to_end(parameter, product), accurate);
        control.is_landing = end.is_some();
        let length = end.unwrap_or(accurate);
        control.note(length / ahead.length);
        series.sum(length, step);
        series.find_direction((ahead.along, tangent), length, parameter.skipped(), direction);
        length / ahead.length
    }

    /// Finds the step to the path and the rates along it at the present point, and leaves no residuals; returns the part of that step
    /// that keeps all numbers positive, or nothing if the system is singular.
    fn look_around(
        &mut self,
        ground: &mut Ground,
        parameter: Parameter,
        product: f64,
        path: &mut PathSteps,
    ) -> Option<f64> {
        self.find_residuals(ground);
        let island = ground.task.island;
        self.find_slopes(island);
        ground.map.effort.factorizations += 1;
        if !ground.map.system.factor_slopes(island, |c| Some(self.units[c].slope)) {
            return None;
        }
        self.find_rates(ground, product, true);
        path.correction.take(self, 0.0);
        let boundary = self.longest_step(INTERIOR.fraction);
        path.bilateral_residual.clone_from(&self.bilateral_residual);
        self.find_tangent(ground, product, parameter);
        path.tangent.take(self, 1.0);
        Some(boundary)
    }

    /// The sign of the parameter's change along the path, on the way from its first point to small products: that of the determinant,
    /// which is positive at the beginning.
    fn orientation(&self, ground: &Ground, parameter: Parameter) -> f64 {
        let towards = if let Parameter::Law { .. } = parameter { 1.0 } else { -1.0 };
        let units: f64 = self.systems.iter().map(UnitSystem::determinant_sign).product();
        towards * units * ground.map.system.determinant_sign()
    }

    /// How much the parameter may grow to where the leg ends.
    fn way_to_end(&self, parameter: Parameter, product: f64) -> f64 {
        match parameter {
            Parameter::Law { .. } => 1.0 - self.share,
            Parameter::Product { most, .. } => most / product - 1.0,
        }
    }

    /// Moves by the step at hand, which makes up for a part of what the bilateral rows lack; returns the product.
    fn take_step(
        &mut self,
        ground: &mut Ground,
        path: &PathSteps,
        part: f64,
        (parameter, product): (Parameter, f64),
    ) -> f64 {
        path.step.give(self);
        self.bilateral_residual.clear();
        self.bilateral_residual.extend(path.bilateral_residual.iter().map(|r| part * r));
        self.advance(ground, 1.0);
        match parameter {
            Parameter::Law { .. } => {
                self.share += path.step.parameter;
                product
            }
            Parameter::Product { .. } => product * (1.0 + path.step.parameter).max(SERIES.least_left),
        }
    }

    /// The rates along the path, for one unit of the parameter.
    fn find_tangent(&mut self, ground: &mut Ground, product: f64, parameter: Parameter) {
        self.momentum_residual.fill(0.0);
        self.bilateral_residual.fill(0.0);
        for (unit, g) in self.units.iter_mut().zip(&ground.task.island.scale) {
            // What the pairs lack is all of the product, or nothing.
            let lack = if let Parameter::Law { product, .. } = parameter { product / g } else { 0.0 };
            unit.correction = lack - unit.impulse[0] * unit.slack;
            (unit.normal_residual, unit.tangential_residual) = (0.0, [0.0; 2]);
            for edge in &mut self.edges[unit.edges.0..unit.edges.1] {
                edge.correction = lack - edge.distance * edge.multiplier;
                if lack > 0.0 {
                    unit.normal_residual += edge.multiplier * edge.reach;
                }
            }
        }
        self.find_rates(ground, product, true);
    }

    /// Keeps the present place as the last one.
    fn keep(&self, ground: &Ground, product: f64, path: &mut PathSteps) {
        let place = path.new_place();
        place.units.clone_from(&self.units);
        place.edges.clone_from(&self.edges);
        place.velocity.clone_from(&ground.iterate.velocity);
        place.bilateral_impulse.clone_from(&ground.iterate.bilateral);
        (place.product, place.share) = (product, self.share);
    }

    /// Goes back to a place; returns its product.
    fn restore(&mut self, ground: &mut Ground, place: &Place) -> f64 {
        self.units.clone_from(&place.units);
        self.edges.clone_from(&place.edges);
        self.units.iter_mut().for_each(|unit| unit.correction = 0.0);
        self.edges.iter_mut().for_each(|edge| edge.correction = 0.0);
        ground.iterate.velocity.clone_from(&place.velocity);
        ground.iterate.bilateral.clone_from(&place.bilateral_impulse);
        self.share = place.share;
        place.product
    }
}

impl PathSteps {
    /// The place where a step is about to begin, in the direction at hand; the oldest is forgotten where there are many.
    fn new_place(&mut self) -> &mut Place {
        if self.place_count == TUNING.places {
            self.places.rotate_left(1);
            self.place_count -= 1;
        }
        if self.place_count == self.places.len() {
            self.places.push(Place::default());
        }
        let place = &mut self.places[self.place_count];
        place.direction.clone_from(&self.direction);
        self.place_count += 1;
        place
    }

    /// The last place. It is no longer among the places: where no step can be made from it, the next one to go back to is an earlier
    /// one.
    fn take_place(&mut self) -> Option<usize> {
        self.place_count = self.place_count.checked_sub(1)?;
        Some(self.place_count)
    }
}

#[cfg(test)]
mod tests;
