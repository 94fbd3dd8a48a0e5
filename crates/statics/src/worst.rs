//! The worst direction of a load over all.

use std::f64::consts::TAU;

use signorini_contact::ContactProblem;
use signorini_contact::statics::certify_mechanism;
use signorini_multibody::glam::{DVec2, DVec3};
use signorini_multibody::{BodyId, JointKind};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::family::{Family, Kind, Sideways, pushes};
use crate::question::SafetyQuestion;
use crate::safety::{Safety, limit};
use crate::settings::StabilitySettings;

/// Directions that are looked at first.
const FIRST: usize = 4;
/// Directions that are looked at, at most.
const MOST: usize = 200;
/// The outline is known where its nearest side is as near as this, relative to the distance.
const CLOSE: f64 = 1e-9;
/// Limits beyond this are none.
const FAR: f64 = 1e6;

/// What acts in every direction across gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sideload {
    /// A tilting table; rad. Gravity has to be the only load.
    Tilt,
    /// A horizontal share of gravity.
    Horizontal,
    /// A horizontal force at a body's centre of mass, N.
    Push(BodyId),
}

/// The direction in which the least is borne.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct WorstDirection {
    /// The direction in world, of length 1.
    pub direction: DVec3,
    /// The limit in it, with both proofs.
    pub limit: Safety,
    /// No direction has a limit below this: the nearest side of the polygon whose corners were proved to be borne. Infinite where
    /// everything is borne.
    pub at_least: f64,
    /// That polygon: directions of length 1 in world and what is borne along each, in order around. For a tilt these are shares of
    /// gravity, tangents of the angles.
    pub outline: Vec<(DVec3, f64)>,
}

impl Configuration<'_> {
    /// The worst of all directions.
    ///
    /// Loads that are borne form a convex set, as contact forces that balance two loads do so in between. Its outline in the plane across gravity is found from
    /// inside, nearest side first, until that side is one of the outline itself (the expanding polygon of G. van den Bergen, 2001, in the
    /// plane of loads). So the answer is that of all directions and not of some.
    ///
    /// # Errors
    /// As [`safety`](Self::safety); [`SimulationError::Setting`] for a tilt where gravity is not the only load.
    pub fn worst_direction(
        &self,
        settings: &StabilitySettings,
        load: Sideload,
    ) -> Result<WorstDirection, SimulationError> {
        let down = self.model.gravity.try_normalize();
        let down = down.ok_or_else(|| no_gravity(0.0))?;
        let first = down.any_orthonormal_vector();
        let plane = [first, down.cross(first)];
        let (problem, along) = match load {
            Sideload::Push(body) => {
                let problem = self.problem(self.model, &self.input, settings)?.0.problem;
                (problem, pushes(self, settings, body, &plane)?)
            }
            Sideload::Tilt | Sideload::Horizontal => {
                let sideways = Sideways::new(self, settings, &plane)?;
                if load == Sideload::Tilt {
                    only_gravity(&sideways)?;
                }
                (sideways.problem, sideways.along)
            }
        };
        let mut outline = Outline { problem, along, sides: Vec::new(), corners: Vec::new(), settings };
        let (worst, at_least) = outline.find();
        let in_world = |unit: DVec2| unit.x * plane[0] + unit.y * plane[1];
        let direction = in_world(worst.0);
        let (limit, at_least) = match load {
            Sideload::Tilt if worst.1.holds < FAR => {
                (self.safety(settings, &SafetyQuestion::Tilt(direction))?, at_least.atan())
            }
            _ => (worst.1, at_least),
        };
        let outline = outline.corners.iter().map(|(unit, limit)| (in_world(*unit), limit.holds)).collect();
        Ok(WorstDirection { direction, limit, at_least, outline })
    }

    /// How far every body can be pushed: the least horizontal force at its centre of mass, over all directions, that nothing balances
    /// any more. Those with the least are what collapse begins with.
    ///
    /// Bodies that cannot move, and links of robots other than free bodies, are left out. On all cores.
    ///
    /// # Errors
    /// As [`worst_direction`](Self::worst_direction).
    pub fn critical_bodies(&self, settings: &StabilitySettings) -> Result<Vec<CriticalBody>, SimulationError> {
        use rayon::prelude::*;
        let model = self.model;
        let is_free =
            |body: &usize| model.joints.iter().any(|j| j.body.index() == *body && matches!(j.kind, JointKind::Free));
        let bodies: Vec<usize> = (1..model.bodies.len()).filter(is_free).collect();
        let of = |&body: &usize| {
            let id = BodyId(body as u32);
            let worst = self.worst_direction(settings, Sideload::Push(id))?;
            let weight = model.bodies[body].inertia.mass * model.gravity.length();
            Ok(CriticalBody { body: id, direction: worst.direction, force: worst.limit.holds, weight })
        };
        bodies.par_iter().map(of).collect()
    }
}

/// What a body bears.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CriticalBody {
    /// The body.
    pub body: BodyId,
    /// The direction in which it bears least, in world.
    pub direction: DVec3,
    /// Force at its centre of mass that is balanced in this direction, N; no number where not even its weight is.
    pub force: f64,
    /// Its weight, N.
    pub weight: f64,
}

fn no_gravity(found: f64) -> SimulationError {
    let expected = "gravity";
    SimulationError::Setting { setting: "worst direction", expected, found }
}

/// Loads other than gravity make turned gravity another question than a share of it.
fn only_gravity(sideways: &Sideways) -> Result<(), SimulationError> {
    let size = |v: &[f64]| v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let (free, gravity) = (&sideways.problem.free_velocity, &sideways.gravity);
    let other = free.iter().zip(gravity).fold(0.0, |most: f64, (v, g)| most.max((v - g).abs()));
    let bounds = sideways.problem.friction_groups.bound.iter().map(|bound| bound.constant());
    let constant = bounds.fold(0.0, f64::max);
    if other > CLOSE * size(gravity) || constant > 0.0 {
        let expected = "gravity as the only load for a tilt; ask for a horizontal share";
        return Err(SimulationError::Setting { setting: "worst direction", expected, found: other.max(constant) });
    }
    Ok(())
}

/// The outline of the loads that are borne, in units of the two changes `along`.
struct Outline<'a> {
    problem: ContactProblem,
    along: Vec<Vec<f64>>,
    /// Lines beyond which nothing is borne: `a·x ≤ b`.
    sides: Vec<(DVec2, f64)>,
    /// Unit vectors in order around, with their limits.
    corners: Vec<(DVec2, Safety)>,
    settings: &'a StabilitySettings,
}

impl Outline<'_> {
    /// The worst corner, and the least distance of the polygon's sides.
    fn find(&mut self) -> ((DVec2, Safety), f64) {
        for k in 0..FIRST {
            let (sin, cos) = (TAU * k as f64 / FIRST as f64).sin_cos();
            self.look(DVec2::new(cos, sin));
        }
        let mut at_least = 0.0;
        while self.corners.len() < MOST && self.corners.iter().all(|(_, limit)| limit.holds > 0.0) {
            let (foot, distance) = self.nearest_side();
            at_least = distance;
            if !(distance > 0.0 && distance < FAR / 4.0) {
                break;
            }
            let borne = self.look(foot / distance);
            if borne.is_nan() || borne <= distance * (1.0 + CLOSE) {
                break;
            }
        }
        let least = |a: &&(DVec2, Safety), b: &&(DVec2, Safety)| a.1.holds.total_cmp(&b.1.holds);
        let worst = self.corners.iter().min_by(least).cloned();
        let nothing = || (DVec2::X, Safety { holds: f64::NAN, falls: f64::NAN, at_holds: None, at_falls: None });
        let worst = worst.unwrap_or_else(nothing);
        if worst.1.holds.is_nan() || worst.1.holds == 0.0 {
            return (worst, 0.0);
        }
        let at_least = if at_least >= FAR / 4.0 { f64::INFINITY } else { at_least };
        (worst, at_least)
    }

    /// The point of the polygon's boundary that is nearest to the origin, with its distance.
    fn nearest_side(&self) -> (DVec2, f64) {
        let place = |k: usize| {
            let (unit, limit) = &self.corners[k % self.corners.len()];
            *unit * limit.holds
        };
        let foot = |k: usize| {
            let (a, b) = (place(k), place(k + 1));
            let side = b - a;
            let part = (-a.dot(side) / side.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            a + part * side
        };
        let feet = (0..self.corners.len()).map(foot).map(|p| (p, p.length()));
        feet.min_by(|p, q| p.1.total_cmp(&q.1)).unwrap_or((DVec2::ZERO, 0.0))
    }

    /// Adds the limit in a direction; what is borne.
    fn look(&mut self, unit: DVec2) -> f64 {
        let change = self.along[0].iter().zip(&self.along[1]).map(|(a, b)| unit.x * a + unit.y * b).collect();
        let family = Family { problem: self.problem.clone(), kind: Kind::Linear(change) };
        // Known mechanisms say where it ends at the latest.
        let latest = self.sides.iter().map(|(a, b)| (a.dot(unit), b)).filter(|(a, _)| *a > 0.0).map(|(a, b)| b / a);
        let latest = latest.fold(FAR, f64::min) * (1.0 + CLOSE);
        let mut found = limit(&family, [0.0, latest], self.settings);
        if !found.falls.is_finite() && latest < FAR {
            found = limit(&family, [0.0, FAR], self.settings);
        }
        if let Some((_, proof)) = &found.at_falls
            && let Some(motion) = &proof.mechanism
        {
            self.sides.push(self.side(motion));
        }
        let borne = found.holds;
        let angle = |v: DVec2| v.y.atan2(v.x);
        let place = self.corners.partition_point(|(other, _)| angle(*other) < angle(unit));
        self.corners.insert(place, (unit, found));
        borne
    }

    /// The line beyond which the loads have power along a mechanism.
    fn side(&self, motion: &[f64]) -> (DVec2, f64) {
        let mut momentum = vec![0.0; motion.len()];
        self.problem.mass.multiply_into(motion, &mut momentum);
        let along = |v: &[f64]| momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>();
        let own = certify_mechanism(&self.problem, motion).power;
        (DVec2::new(along(&self.along[0]), along(&self.along[1])), -own)
    }
}
