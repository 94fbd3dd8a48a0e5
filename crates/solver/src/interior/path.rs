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
//! zero. Where the associated law has no solution its impulses are huge, and the first leg is lost; another one begins at Coulomb's law
//! with all contacts opened, `u_N + (1 − θ) z`, which is Lemke's covering vector.
//!
//! A second leg that comes back to the products from which it went down goes on with a first one, back towards `θ = 0` until that turns,
//! and so forth: both are one path, whose only other end is the point at `θ = 0`. As in Lemke's method there is then one way to go at
//! every point; unlike there thousands of contacts change their modes along one smooth curve. Steps that jump off it, to where
//! it is passed through the other way round, are [known](super::control) by the sign of the system's determinant, which turns
//! with the parameter at every fold.

use super::control::{Control, Move, Point};
use super::parts::{Edge, Unit};
use super::point::{Ground, InteriorPoint};
use super::series::{Parameter, Rates, SHARE_UNIT, Series};
use super::unit::UnitSystem;

/// Steps of one leg at most, and legs.
const STEPS: u32 = 8000;
const LEGS: u32 = 100;
/// How often the directions to the path and along it are refined.
const REFINEMENTS: u32 = 2;
/// Part of the way to the boundary that a step to the first point of a path goes at most.
const FRACTION: f64 = 0.9;
/// The product, relative to the squared velocity scale, from which the path ends where it gets no further for rounding: where a step
/// fails, needs so many corrections, or takes off less than this part of it.
const ENDED: f64 = 1e-9;
const MOST_CORRECTORS: u32 = 2;
const LITTLE: f64 = 0.1;
/// Places kept to go back to.
const PLACES: usize = 8;
/// What a step leaves of the product at least.
const LEAST_CHANGE: f64 = 0.02;

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
    /// Whether it is very close to the path.
    is_closest: bool,
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
}

impl InteriorPoint {
    /// Follows the path from near its first point, with this product, until the product has fallen to `target`; both are in units of
    /// a squared velocity. Where it gets no further, that stays.
    pub(super) fn follow(&mut self, ground: &mut Ground, (product, target): (f64, f64), path: &mut PathSteps) {
        let mut ahead = 1.0;
        for _ in 0..LEGS {
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
        let ended = ENDED * ground.map.velocity_scale * ground.map.velocity_scale;
        let mut control = Control::new();
        path.direction.clear();
        path.place_count = 0;
        for _ in 0..STEPS {
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
            match control.decide(&point, direction) {
                Move::Back => {
                    let Some(closer) = control.go_back() else { return LegEnd::Lost };
                    if product <= ended {
                        return LegEnd::Arrived;
                    }
                    let Some(place) = path.take_place(closer) else { return LegEnd::Lost };
                    product = self.restore(ground, &path.places[place]);
                    path.direction.clone_from(&path.places[place].direction);
                }
                Move::Correct { .. } if product <= ended && control.correctors > MOST_CORRECTORS => {
                    return LegEnd::Arrived;
                }
                Move::Correct { part, along } => {
                    path.step.set(part, &path.correction);
                    path.step.add(part * along, &path.tangent);
                    self.take_step(ground, path, part);
                    product = self.move_parameter(parameter, product, path.step.parameter);
                }
                Move::Advance { ahead, closest } => {
                    self.keep(ground, product, path, closest);
                    let PathSteps { correction, tangent, direction, series, step, .. } = path;
                    series.find(self, ground, parameter, (direction, tangent, correction), ahead);
                    let accurate = series.accurate_length(ahead.length, parameter.skipped());
                    let end = series.length_to(self.way_to_end(parameter, product), accurate);
                    control.is_landing = end.is_some();
                    let length = end.unwrap_or(accurate);
                    control.note(length / ahead.length);
                    series.sum(length, step);
                    series.find_direction((ahead.along, tangent), length, parameter.skipped(), direction);
                    self.take_step(ground, path, length / ahead.length);
                    product = self.move_parameter(parameter, product, path.step.parameter);
                    if product <= ended && path.step.parameter > -LITTLE {
                        return LegEnd::Arrived;
                    }
                }
                Move::Land => {
                    path.step.clone_from(&path.correction);
                    self.take_step(ground, path, 1.0);
                    return LegEnd::Passed;
                }
            }
        }
        LegEnd::Lost
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
        self.find_rates(ground, product, REFINEMENTS);
        path.correction.take(self, 0.0);
        let boundary = self.longest_step(FRACTION);
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
            Parameter::Law { .. } => (1.0 - self.share) / SHARE_UNIT,
            Parameter::Product { most, .. } => most / product - 1.0,
        }
    }

    /// Changes the parameter; returns the product.
    fn move_parameter(&mut self, parameter: Parameter, product: f64, change: f64) -> f64 {
        match parameter {
            Parameter::Law { .. } => {
                self.share += SHARE_UNIT * change;
                product
            }
            Parameter::Product { .. } => product * (1.0 + change).max(LEAST_CHANGE),
        }
    }

    /// Moves by the step at hand, which makes up for a part of what the bilateral rows lack.
    fn take_step(&mut self, ground: &mut Ground, path: &PathSteps, part: f64) {
        path.step.give(self);
        self.bilateral_residual.clear();
        self.bilateral_residual.extend(path.bilateral_residual.iter().map(|r| part * r));
        self.advance(ground, 1.0);
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
                if lack > 0.0 && self.opening == 0.0 {
                    unit.normal_residual += SHARE_UNIT * edge.multiplier * edge.reach;
                }
            }
            if lack > 0.0 {
                unit.normal_residual -= SHARE_UNIT * self.opening;
            }
        }
        self.find_rates(ground, product, REFINEMENTS);
    }

    /// Keeps the present place as the last one.
    fn keep(&self, ground: &Ground, product: f64, path: &mut PathSteps, is_closest: bool) {
        let place = path.new_place();
        place.units.clone_from(&self.units);
        place.edges.clone_from(&self.edges);
        place.velocity.clone_from(&ground.iterate.velocity);
        place.bilateral_impulse.clone_from(&ground.iterate.bilateral);
        (place.product, place.share, place.is_closest) = (product, self.share, is_closest);
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
        if self.place_count == PLACES {
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

    /// The last place, or the last very close one, if there is one. It is no longer among the places: where no step can be made from
    /// it, the next one to go back to is an earlier one.
    fn take_place(&mut self, closer: bool) -> Option<usize> {
        let places = &self.places[..self.place_count];
        let closest = places.iter().rposition(|place| place.is_closest).filter(|_| closer);
        self.place_count = closest.or(places.len().checked_sub(1))?;
        Some(self.place_count)
    }
}

#[cfg(test)]
mod tests;
