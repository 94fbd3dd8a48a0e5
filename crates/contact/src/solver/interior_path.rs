//! The central path of Coulomb's law, from a convex problem and around its folds.
//!
//! Coulomb's law is not monotone: on the way to its solution the product `τ` of the pairs may have to rise before it can fall on, and
//! Newton's steps to a smaller one become short there. So `τ` is one more unknown here, and steps go along the path itself, by its
//! tangent, in the direction in which they came: Keller's pseudo-arclength continuation (1977), with all lengths relative to the
//! positive numbers, `δx/x` and `δτ/τ`.
//!
//! A path needs a point to begin at. That of the associated law, whose velocity along the normal is `u_N − Σ γ μ h` with the multipliers `γ`
//! of the edges, is one of a convex problem: it has no folds, and Newton's method finds every point of it. From a point with large
//! products a first path takes the law to Coulomb's, `u_N − (1 − θ) Σ γ μ h` with `θ` from 0 to 1, and a second one the products to
//! zero. As in Lemke's method there is then one way to go at every point; unlike there thousands of contacts change their modes
//! along one smooth curve.

use super::interior_start::{Edge, InteriorStart, Unit};
use super::island::Island;
use super::island_solver::IslandSolver;
use super::mode::Cones;
use crate::ContactProblem;
use crate::vector::inner;

/// Steps along one path at most.
const STEPS: u32 = 8000;
/// The path is lost where the mean product has grown to this, relative to the squared velocity scale.
const OUTSIDE: f64 = 100.0;
/// ... or the law has gone so far away from Coulomb's.
const LEAST_SHARE: f64 = -3.0;
/// The law is Coulomb's within this.
const ARRIVED: f64 = 1e-9;
/// A change of the law by this much counts as one of the products by a factor of e.
const SHARE_UNIT: f64 = 0.3;
/// The largest relative change of a number in the first step along a path, and in any, and in one that is too small to go on with.
const FIRST_REACH: f64 = 0.5;
const MOST_REACH: f64 = 0.9;
const LEAST_REACH: f64 = 1e-6;
/// Distances from the path, in parts of the reach, at which a step along it is made: usually, and where the path bends or steps failed.
const CLOSE: f64 = 0.4;
const CLOSER: f64 = 0.2;
/// ... and at which a place is worth keeping for when the last one does not help.
const CLOSEST: f64 = 0.1;
/// These distances are never more, and never less.
const MOST_DISTANCE: [f64; 2] = [0.2, 0.06];
const LEAST_DISTANCE: f64 = 1e-5;
/// Newton steps back to the path at most, and to its first point; how far one of them goes, and the distance from where none is tried.
const CORRECTORS: u32 = 5;
const FIRST_CORRECTORS: u32 = 100;
const CORRECTION: f64 = 0.7;
const FAR: f64 = 3.0;
/// Cosine of the angle between tangents one after the other: where the path bends, where it bends much, and where a step has jumped off it.
const BENT: f64 = 0.97;
const SHARP: f64 = 0.95;
const JUMPED: f64 = 0.7;
/// How the reach changes: after a step that needed no correction, in bends, after two and after more corrections, and on going back.
const LONGER: f64 = 1.5;
const IN_BENDS: f64 = 0.7;
const AFTER_TWO: f64 = 0.8;
const AFTER_MORE: f64 = 0.5;
const BACK: f64 = 0.3;
/// How often directions are refined.
const REFINEMENTS: u32 = 2;
/// Part of the way to the boundary that a step to the first point of a path goes at most.
const FRACTION: f64 = 0.9;

/// What changes along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Parameter {
    /// The law, from the associated one to Coulomb's, at this product.
    Law { product: f64 },
    /// The product, down to this one. All products are in units of a squared velocity.
    Product { target: f64 },
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
    /// The direction in which the path went on from there.
    direction: Vec<f64>,
}

/// Memory of the steps along a path. Directions are the parameter's part, and then `δx/x` of all pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct PathSteps {
    /// Newton's direction to the path at the present parameter: impulses and slacks, distances and multipliers, velocity.
    unit_rates: Vec<[f64; 4]>,
    edge_rates: Vec<[f64; 2]>,
    velocity_rate: Vec<f64>,
    correction: Vec<f64>,
    tangent: Vec<f64>,
    /// The direction of the last step along the path; empty before the first.
    direction: Vec<f64>,
    /// Where that step began, and an earlier place that was closer to the path.
    last: Place,
    close: Place,
    work: Vec<f64>,
}

/// What controls the steps.
#[derive(Clone, Copy, Debug)]
struct Control {
    reach: f64,
    correctors: u32,
    /// Whether the path bends, or steps failed.
    careful: bool,
    /// How often steps from the last place failed, and the reach of the first of them.
    failures: u32,
    failed_reach: f64,
}

/// What to do at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Move {
    /// To the last place, and more carefully on.
    Back,
    /// Part of Newton's step to the path, and so much along the tangent.
    Correct { part: f64, along: f64 },
    /// That, and a step along the path; whether the place is very close to it.
    Advance { along: f64, length: f64, closest: bool },
}

impl InteriorStart {
    /// Goes along a path from near one of its points; whether it arrives. What is reached stays, wherever that is.
    pub(super) fn follow(
        &mut self,
        solver: &mut IslandSolver,
        (problem, cones, island): (&ContactProblem, &Cones, &Island),
        parameter: Parameter,
    ) -> bool {
        let mut path = std::mem::take(&mut self.path);
        let arrived = self.step_along(solver, (problem, cones, island), parameter, &mut path);
        self.path = path;
        arrived
    }

    fn step_along(
        &mut self,
        solver: &mut IslandSolver,
        (problem, cones, island): (&ContactProblem, &Cones, &Island),
        parameter: Parameter,
        path: &mut PathSteps,
    ) -> bool {
        let square = solver.velocity_scale * solver.velocity_scale;
        let (mean, _) = self.find_residuals(solver, problem, cones, island);
        let mut product = if let Parameter::Law { product } = parameter { product } else { mean };
        let mut control = Control::new();
        path.direction.clear();
        path.close.units.clear();
        for _ in 0..STEPS {
            self.find_residuals(solver, problem, cones, island);
            let arrived = match parameter {
                Parameter::Law { .. } => self.share >= 1.0 - ARRIVED,
                Parameter::Product { target } => product <= target,
            };
            if arrived || product > OUTSIDE * square || self.share < LEAST_SHARE {
                return arrived;
            }
            self.find_slopes(island);
            solver.effort.factorizations += 1;
            if !solver.system.factor_slopes(island, |c| Some(self.units[c].slope)) {
                return false;
            }
            self.find_rates(solver, problem, island, product, REFINEMENTS);
            let boundary = self.longest_step(FRACTION);
            path.take_rates(self);
            self.find_tangent(solver, problem, island, product, parameter, &mut path.work);
            self.relative_rates(1.0, &mut path.tangent);
            let ahead = if matches!(parameter, Parameter::Law { .. }) { 1.0 } else { -1.0 };
            let (part, total) = match control.decide(path, ahead, boundary) {
                Move::Back => {
                    if path.direction.is_empty() || !control.go_back(path) {
                        return false;
                    }
                    product = self.restore(solver, path);
                    continue;
                }
                Move::Correct { part, along } => (part, part * along),
                Move::Advance { along, length, closest } => {
                    let length = if let Parameter::Law { .. } = parameter {
                        length.min((1.0 - self.share) / SHARE_UNIT - along)
                    } else {
                        length
                    };
                    self.keep(solver, product, path);
                    if closest {
                        path.close.clone_from(&path.last);
                    }
                    (1.0, along + length)
                }
            };
            self.combine(path, part, total);
            self.bilateral_residual.iter_mut().for_each(|r| *r *= part);
            self.advance(solver, island, 1.0);
            match parameter {
                Parameter::Law { .. } => self.share += SHARE_UNIT * total,
                Parameter::Product { .. } => product *= (1.0 + total).max(0.05),
            }
        }
        false
    }

    /// The rates at hand, relative to the numbers, after that of the parameter.
    fn relative_rates(&self, parameter: f64, out: &mut Vec<f64>) {
        out.clear();
        out.push(parameter);
        for unit in self.units.iter().filter(|unit| unit.has_normal) {
            out.extend([unit.impulse_rate[0] / unit.impulse[0], unit.slack_rate / unit.slack]);
        }
        for edge in &self.edges {
            out.extend([edge.distance_rate / edge.distance, edge.multiplier_rate / edge.multiplier]);
        }
    }

    /// The rates along the path, for one unit of the parameter.
    fn find_tangent(
        &mut self,
        solver: &mut IslandSolver,
        problem: &ContactProblem,
        island: &Island,
        product: f64,
        parameter: Parameter,
        work: &mut Vec<f64>,
    ) {
        work.clear();
        work.extend_from_slice(&self.momentum_residual);
        work.extend_from_slice(&self.bilateral_residual);
        self.momentum_residual.fill(0.0);
        self.bilateral_residual.fill(0.0);
        for (unit, g) in self.units.iter_mut().zip(&island.scale) {
            // What the pairs lack is all of the product, or nothing.
            let lack = if let Parameter::Law { product } = parameter { product / g } else { 0.0 };
            unit.correction = lack - unit.impulse[0] * unit.slack;
            (unit.normal_residual, unit.tangential_residual) = (0.0, [0.0; 2]);
            for edge in &mut self.edges[unit.edges.0..unit.edges.1] {
                edge.correction = lack - edge.distance * edge.multiplier;
                if lack > 0.0 {
                    unit.normal_residual += SHARE_UNIT * edge.multiplier * edge.reach;
                }
            }
        }
        self.find_rates(solver, problem, island, product, REFINEMENTS);
        let (momentum, bilateral) = work.split_at(self.momentum_residual.len());
        self.momentum_residual.copy_from_slice(momentum);
        self.bilateral_residual.copy_from_slice(bilateral);
    }

    /// Makes the rates at hand, those of the tangent, `total` times them and `part` of the correction.
    fn combine(&mut self, path: &PathSteps, part: f64, total: f64) {
        for (unit, correction) in self.units.iter_mut().zip(&path.unit_rates) {
            let sum = |rate: f64, r: usize| total * rate + part * correction[r];
            unit.impulse_rate = std::array::from_fn(|r| sum(unit.impulse_rate[r], r));
            unit.slack_rate = sum(unit.slack_rate, 3);
        }
        for (edge, correction) in self.edges.iter_mut().zip(&path.edge_rates) {
            edge.distance_rate = total * edge.distance_rate + part * correction[0];
            edge.multiplier_rate = total * edge.multiplier_rate + part * correction[1];
        }
        for (rate, correction) in self.velocity_rate.iter_mut().zip(&path.velocity_rate) {
            *rate = total * *rate + part * correction;
        }
    }

    /// Keeps the present place as the last one.
    fn keep(&self, solver: &IslandSolver, product: f64, path: &mut PathSteps) {
        let place = &mut path.last;
        place.units.clone_from(&self.units);
        place.edges.clone_from(&self.edges);
        place.velocity.clone_from(&solver.velocity);
        place.bilateral_impulse.clone_from(&solver.bilateral_impulse);
        place.direction.clone_from(&path.direction);
        (place.product, place.share) = (product, self.share);
    }

    /// Goes back to the last place; returns its product.
    fn restore(&mut self, solver: &mut IslandSolver, path: &mut PathSteps) -> f64 {
        let place = &path.last;
        path.direction.clone_from(&place.direction);
        self.units.clone_from(&place.units);
        self.edges.clone_from(&place.edges);
        self.units.iter_mut().for_each(|unit| unit.correction = 0.0);
        self.edges.iter_mut().for_each(|edge| edge.correction = 0.0);
        solver.velocity.clone_from(&place.velocity);
        solver.bilateral_impulse.clone_from(&place.bilateral_impulse);
        self.share = place.share;
        place.product
    }
}

impl PathSteps {
    /// Takes the rates at hand as the correction.
    fn take_rates(&mut self, interior: &InteriorStart) {
        self.unit_rates.clear();
        let rates = |unit: &Unit| {
            let [n, a, b] = unit.impulse_rate;
            [n, a, b, unit.slack_rate]
        };
        self.unit_rates.extend(interior.units.iter().map(rates));
        self.edge_rates.clear();
        self.edge_rates.extend(interior.edges.iter().map(|edge| [edge.distance_rate, edge.multiplier_rate]));
        self.velocity_rate.clone_from(&interior.velocity_rate);
        interior.relative_rates(0.0, &mut self.correction);
    }
}

impl Control {
    fn new() -> Self {
        Self { reach: FIRST_REACH, correctors: 0, careful: false, failures: 0, failed_reach: 0.0 }
    }

    /// What to do with the correction and the tangent at hand, which becomes the direction of a step along the path.
    ///
    /// - `ahead`: the sign of the parameter's change with which a path begins
    /// - `boundary`: the part of the correction that keeps all numbers positive
    fn decide(&mut self, path: &mut PathSteps, ahead: f64, boundary: f64) -> Move {
        let PathSteps { correction, tangent, direction, .. } = path;
        let size = inner(tangent, tangent).sqrt();
        let started = !direction.is_empty();
        let onward = if started { inner(tangent, direction) } else { ahead };
        let turn = if started { onward.abs() / size } else { 1.0 };
        // The correction is made across the direction of the last step, the first one without leaving the parameter.
        let along = if started { -inner(direction, correction) / onward } else { 0.0 };
        let distance = correction.iter().zip(&*tangent).fold(0.0, |m: f64, (c, t)| m.max((c + along * t).abs()));
        let wary = self.correctors > 0 || self.careful || turn < BENT;
        let (part, most) = if wary { (CLOSER, MOST_DISTANCE[1]) } else { (CLOSE, MOST_DISTANCE[0]) };
        let is_close = distance <= (part * self.reach).clamp(LEAST_DISTANCE, most);
        let lost = self.correctors >= CORRECTORS || distance > FAR || (is_close && turn < JUMPED);
        if started && lost || self.correctors >= FIRST_CORRECTORS {
            return Move::Back;
        }
        if !is_close {
            self.correctors += 1;
            return Move::Correct { part: if started { (CORRECTION / distance).min(1.0) } else { boundary }, along };
        }
        self.reach *= match self.correctors {
            _ if turn < SHARP => IN_BENDS,
            0 if distance < CLOSEST && !self.careful => LONGER,
            0 | 1 => 1.0,
            2 => AFTER_TWO,
            _ => AFTER_MORE,
        };
        self.reach = self.reach.min(MOST_REACH);
        (self.correctors, self.careful) = (0, turn < BENT);
        let largest = tangent.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let forward = onward.signum();
        direction.clear();
        direction.extend(tangent.iter().map(|t| forward * t / size));
        if self.reach >= self.failed_reach {
            self.failures = 0;
        }
        let length = forward * self.reach.min(0.95 - distance) / largest;
        Move::Advance { along, length, closest: distance <= CLOSEST * self.reach }
    }

    /// Makes `last` the place to go back to, every second time the one that was closer to the path; `false` if steps have become too
    /// small.
    fn go_back(&mut self, path: &mut PathSteps) -> bool {
        self.failures += 1;
        if self.failures == 1 {
            self.failed_reach = self.reach;
        }
        if self.failures.is_multiple_of(2) && !path.close.units.is_empty() {
            path.last.clone_from(&path.close);
        }
        self.reach *= BACK;
        (self.correctors, self.careful) = (0, true);
        self.reach >= LEAST_REACH
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::BlockDiagonal;

    use super::super::interior_start::InteriorLaw;
    use super::super::island_solver::started_on;
    use super::super::random::Random;
    use super::*;
    use crate::FrictionPolygon;

    const BODIES: usize = 4;
    const CONTACTS: usize = 12;

    /// Bodies of unit inertia, every contact with random rows on two of them and a friction of 4: far from any convex problem.
    fn tangle(seed: u32) -> ContactProblem {
        let mut random = Random::new(seed);
        let n = 6 * BODIES;
        let identity: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
        let mass = BlockDiagonal::from_dense(n, &identity).expect("definite");
        let free_velocity = (0..n).map(|_| random.between(-1.0, 1.0)).collect();
        let mut problem = ContactProblem::new(mass, free_velocity, 1e-2).expect("numbers");
        let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
        for c in 0..CONTACTS {
            let (one, other) = (c % BODIES, (c + 1 + c / BODIES) % BODIES);
            let columns = [one.min(other), one.max(other)].into_iter().flat_map(|body| 6 * body..6 * body + 6);
            let entry = |k: usize| (k as u32, std::array::from_fn(|_| random.between(-1.0, 1.0)));
            let row: Vec<(u32, [f64; 3])> = columns.map(entry).collect();
            problem.push_contact(row, 0.0, 4.0, &polygon);
        }
        problem
    }

    /// Where Newton's steps to smaller products come to an end because the path turns back, the path around its folds still arrives,
    /// and all laws hold there.
    #[test]
    fn paths_arrive_around_their_folds() {
        let (mut folded, mut arrived) = (0, 0);
        for seed in 0..300 {
            let problem = tangle(seed);
            let (cones, islands, mut solver) = started_on(&problem);
            let island = &islands.all()[0];
            solver.system.analyse(&problem, island);
            assert!(solver.interior_start(&problem, &cones, island, InteriorLaw::Coulomb));
            if !solver.interior.is_lagged {
                continue;
            }
            folded += 1;
            solver.start(&problem, island);
            assert!(solver.interior_start(&problem, &cones, island, InteriorLaw::Path));
            let mut interior = std::mem::take(&mut solver.interior);
            let (product, missing) = interior.find_residuals(&solver, &problem, &cones, island);
            let scale = solver.velocity_scale;
            arrived += u32::from(!interior.is_lagged && product < 2e-9 * scale * scale && missing < 1e-8 * scale);
        }
        assert!(folded >= 20 && 3 * arrived >= 2 * folded, "{arrived} of {folded}");
    }
}
