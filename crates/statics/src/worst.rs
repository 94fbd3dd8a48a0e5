//! The worst direction of a load over all.

use signorini_multibody::glam::{DVec2, DVec3};
use signorini_multibody::{BodyId, JointKind};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::family::{Sideways, pushes};
use crate::outline::{Nearest, Outline, nearest_side};
use crate::question::SafetyQuestion;
use crate::safety::Safety;
use crate::settings::StabilitySettings;

/// Loads beside gravity that are no larger than this part of it are its rounding.
const ROUNDING: f64 = 1e-9;

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
    /// No direction has a limit below this: the nearest side of the polygon whose corners were proved to be borne. Infinite, of a tilt a
    /// quarter turn, where everything is borne, zero where the outline is not known.
    pub at_least: f64,
    /// That polygon: directions of length 1 in world and what is borne along each, in order around. For a tilt these are shares of
    /// gravity, tangents of the angles.
    pub outline: Vec<(DVec3, f64)>,
}

impl Configuration<'_> {
    /// The worst of all directions.
    ///
    /// Loads that are borne form a convex set, as contact forces that balance two loads do so in between. Its outline in the plane across gravity
    /// is found from inside, nearest side first, by a linear program for what is borne farthest along the side's normal. So the answer is that
    /// of all directions and not of some.
    ///
    /// # Errors
    /// As [`safety`](Self::safety); [`SimulationError::Setting`] for a tilt where gravity is not the only load.
    pub fn worst_direction(
        &self,
        settings: &StabilitySettings,
        load: Sideload,
    ) -> Result<WorstDirection, SimulationError> {
        let plane = self.across()?;
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
        let mut outline = Outline::new(problem, along, settings);
        let Nearest { direction, limit, is_known } = outline.nearest();
        let in_world = |unit: DVec2| unit.x * plane[0] + unit.y * plane[1];
        let corners = if limit.holds > 0.0 { outline.proved() } else { Vec::new() };
        let at_least = if !is_known || corners.len() < 3 {
            0.0
        } else if limit.falls == f64::INFINITY {
            f64::INFINITY
        } else {
            nearest_side(&corners).1.max(0.0)
        };
        let direction = in_world(direction);
        let (limit, at_least) = match load {
            // Where all shares are borne the table may be turned beyond a quarter.
            Sideload::Tilt if !limit.holds.is_nan() => {
                (self.safety(settings, &SafetyQuestion::Tilt(direction))?, at_least.atan())
            }
            _ => (limit, at_least),
        };
        let outline = corners.iter().map(|p| (in_world(*p).normalize_or_zero(), p.length())).collect();
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
        let plane = self.across()?;
        let problem = self.problem(model, &self.input, settings)?.0.problem;
        let of = |&body: &usize| {
            let id = BodyId(body as u32);
            let pushed = pushes(self, settings, id, &plane)?;
            let Nearest { direction, limit, is_known } = Outline::new(problem.clone(), pushed, settings).nearest();
            let weight = model.bodies[body].inertia.mass * model.gravity.length();
            let force = if is_known { limit.holds } else { f64::NAN };
            Ok(CriticalBody { body: id, direction: direction.x * plane[0] + direction.y * plane[1], force, weight })
        };
        bodies.par_iter().map(of).collect()
    }

    /// Two unit vectors across gravity.
    fn across(&self) -> Result<[DVec3; 2], SimulationError> {
        let down = self.model.gravity.try_normalize();
        let down = down.ok_or_else(|| no_gravity(0.0))?;
        let first = down.any_orthonormal_vector();
        Ok([first, down.cross(first)])
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
    /// Force at its centre of mass that is balanced in this direction, N; no number where not even the weights are, or no program found the outline.
    pub force: f64,
    /// Its weight, N.
    pub weight: f64,
}

fn no_gravity(found: f64) -> SimulationError {
    let expected = "gravity";
    SimulationError::Setting { setting: "worst direction", expected, found }
}

/// Loads other than gravity make turned gravity another question than a share of it.
fn only_gravity(sideways: &Sideways<2>) -> Result<(), SimulationError> {
    let size = |v: &[f64]| v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let (free, gravity) = (&sideways.problem.free_velocity, &sideways.gravity);
    let other = free.iter().zip(gravity).fold(0.0, |most: f64, (v, g)| most.max((v - g).abs()));
    let bounds = sideways.problem.friction_groups.bound.iter().map(|bound| bound.constant());
    let constant = bounds.fold(0.0, f64::max);
    if other > ROUNDING * size(gravity) || constant > 0.0 {
        let expected = "gravity as the only load for a tilt; ask for a horizontal share";
        return Err(SimulationError::Setting { setting: "worst direction", expected, found: other.max(constant) });
    }
    Ok(())
}
