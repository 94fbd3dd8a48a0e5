//! Limits under circular cones of friction, between polygons inside and outside them.

use std::f64::consts::PI;

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::family::Family;
use crate::mechanism::BalanceProgram;
use crate::question::SafetyQuestion;
use crate::safety::{Safety, farthest_limit};
use crate::settings::StabilitySettings;

/// Rounds in which the polygons are turned: the distance of the two limits is squared in each.
const ROUNDS: usize = 6;
/// Two limits this near, relative to the larger, are one.
const CLOSE: f64 = 2e-9;
/// Slips and impulses below this part of the largest have no direction.
const NO_DIRECTION: f64 = 1e-6;

/// The limit under circular cones.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CircularSafety {
    /// The limits with the regular polygons of the settings inside the circles, and with those of as many corners outside.
    pub polygons: [f64; 2],
    /// The limit with polygons inside the circles: what holds there holds with circles.
    pub inside: Safety,
    /// The limit with polygons outside the circles: what falls there falls with circles.
    pub outside: Safety,
}

impl Configuration<'_> {
    /// The limit of a question under circular cones of friction, commonly to 1e-7 of its size.
    ///
    /// Polygons inside and outside the circles bound it, each with both proofs of polygons. A conic program at the outer limit says where
    /// friction points at the collapse; turned there, the polygons miss the circle by the square of what is missing in the direction, which is to say by what the conic program misses in its optimum. Friction of
    /// joints, servos, spinning and rolling keeps its polygons.
    ///
    /// # Errors
    /// As [`safety`](Self::safety); [`SimulationError::Problem`] where the friction of a contact is anisotropic.
    pub fn circular_safety(
        &self,
        settings: &StabilitySettings,
        question: &SafetyQuestion,
    ) -> Result<CircularSafety, SimulationError> {
        let family = Family::new(self, settings, question)?;
        let count = settings.simulation.directions;
        let regular = family.problem.with_directions(count)?;
        let angles: Vec<f64> = (0..regular.contact_count()).map(|i| first_angle(&regular, i)).collect();
        let range = question.range();
        let find = |polygons: Polygons, angles: &[f64], range: [f64; 2]| {
            let family = Family { problem: polygons.of(&regular, count, angles), kind: family.kind.clone() };
            farthest_limit(&family, range, settings)
        };
        let (mut inside, mut outside) =
            (find(Polygons::Inside, &angles, range), find(Polygons::Outside, &angles, range));
        let polygons = [inside.holds, outside.falls];
        for _ in 0..ROUNDS {
            let (low, high) = (inside.holds, outside.falls);
            let is_known = low.is_finite() && high.is_finite();
            if !is_known || (high - low).abs() <= CLOSE * low.abs().max(high.abs()) {
                break;
            }
            let Some(turned) = turned(&family.at(high), &angles) else { break };
            let better = |own: Safety, other: Safety, of: fn(&Safety) -> f64, sign: f64| {
                let gain = sign * (of(&own) - of(&other)) * (high - low).signum();
                if gain > 0.0 { own } else { other }
            };
            let begin = [range[0], high];
            let (new_inside, new_outside) =
                (find(Polygons::Inside, &turned, begin), find(Polygons::Outside, &turned, begin));
            inside = better(new_inside, inside, |s| s.holds, 1.0);
            outside = better(new_outside, outside, |s| s.falls, -1.0);
            if (inside.holds, outside.falls) == (low, high) {
                break;
            }
        }
        Ok(CircularSafety { polygons, inside, outside })
    }
}

fn first_angle(problem: &ContactProblem, i: usize) -> f64 {
    problem.directions_of(i).first().map_or(0.0, |d| d[1].atan2(d[0]))
}

/// Regular polygons with a corner on the circle at the angle of every contact, or with the middle of a side there.
#[derive(Clone, Copy)]
enum Polygons {
    Inside,
    Outside,
}

impl Polygons {
    fn of(self, regular: &ContactProblem, count: usize, angles: &[f64]) -> ContactProblem {
        let mut problem = regular.clone();
        let (turn, stretch) = match self {
            Self::Inside => (0.0, 1.0),
            Self::Outside => (PI / count as f64, 1.0 / (PI / count as f64).cos()),
        };
        for (i, angle) in angles.iter().enumerate() {
            let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
            if let Ok(polygon) = FrictionPolygon::regular(count, angle + turn)
                && polygon.directions().len() == range.len()
            {
                problem.directions[range].copy_from_slice(polygon.directions());
                problem.friction[i] *= stretch;
            }
        }
        problem
    }
}

/// The angles at which friction points in the collapse under circular cones.
fn turned(problem: &ContactProblem, angles: &[f64]) -> Option<Vec<f64>> {
    let (motion, tangential) = BalanceProgram::circular(problem).solve_circular()?;
    let slips: Vec<[f64; 2]> = (0..problem.contact_count())
        .map(|i| {
            let [_, a, b] = problem.jacobian.multiply_with_terms(i, &motion).0;
            [a, b]
        })
        .collect();
    let largest = |all: &[[f64; 2]]| all.iter().fold(0.0, |most: f64, [a, b]| most.max(a.hypot(*b)));
    let (fastest, strongest) = (largest(&slips), largest(&tangential));
    let angle = |i: usize| {
        let ([a, b], [f, g]) = (slips[i], tangential[i]);
        if a.hypot(b) > NO_DIRECTION * fastest {
            (-b).atan2(-a)
        } else if f.hypot(g) > NO_DIRECTION * strongest {
            g.atan2(f)
        } else {
            angles[i]
        }
    };
    Some((0..slips.len()).map(angle).collect())
}
