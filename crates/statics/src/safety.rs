//! How far a configuration at rest is from collapse, with a proof on either side of the limit.

use signorini_contact::statics::{StabilityProof, Verdict, certify_mechanism};
use signorini_contact::{ContactProblem, FrictionBound};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Input, Model, State};
use signorini_simulation::{FrictionSource, RestProblem, SimulationError, rest_problem};

use crate::search::Search;
use crate::settings::StabilitySettings;
use crate::verdict::{Decided, decide};

/// Halvings of the interval at most: from 10⁶ to the last digits.
const HALVINGS: u32 = 80;
/// Two values this near, relative to the larger, are the limit.
const CLOSE: f64 = 1e-9;
/// How far beside a limit proofs are looked for, relative to it.
const NUDGE: f64 = 2e-10;

/// What is increased until the configuration must move.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SafetyQuestion {
    /// A horizontal share of gravity in this direction (any length) beside gravity itself; a number, as in seismic design.
    Horizontal(DVec3),
    /// The angle by which gravity is turned towards this direction (any length, not along gravity), rad: a tilting table.
    Tilt(DVec3),
    /// The multiplier of all coefficients of friction of contacts, which is lowered instead.
    Friction,
    /// The multiplier of a generalized force beside the loads, `[nv]`, N and N·m.
    Load(Vec<f64>),
    /// The multiplier of the force ranges of all servos of speed, which is lowered instead: the torque margin of motors that
    /// [hold](crate::held_by_motors).
    Motors,
    /// A weight that is added to a body at its centre of mass, kg.
    Weight(BodyId),
}

impl SafetyQuestion {
    /// From where it balances to where it is looked for at most.
    fn range(&self) -> [f64; 2] {
        match self {
            Self::Horizontal(_) | Self::Load(_) | Self::Weight(_) => [0.0, 1e6],
            Self::Tilt(_) => [0.0, std::f64::consts::PI],
            Self::Friction | Self::Motors => [1.0, 0.0],
        }
    }
}

/// The limit of a safety question, between two values with a proof each.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Safety {
    /// The loads are balanced here, to [`balance_tolerance`](StabilitySettings::balance_tolerance). Where they are not even at the beginning (friction: as it is), this is no number.
    pub holds: f64,
    /// No forces balance them here; infinite (friction: no number) where they are balanced over the whole range: 10⁶, half a turn, no friction.
    pub falls: f64,
    /// The problem at [`holds`](Self::holds) with its balance. The verdict says `stands`: nothing was asked about motion.
    pub at_holds: Option<(ContactProblem, StabilityProof)>,
    /// The problem at [`falls`](Self::falls) with its mechanism.
    pub at_falls: Option<(ContactProblem, StabilityProof)>,
}

/// Finds the limit of a safety question to 1e-9 of its size, or as near as both proofs can be had.
///
/// Newton's method from above: the mechanism at a value shows that the loads are not balanced wherever they have power along it, so that
/// the next value is where they have none. Where that leads nowhere the interval is halved.
///
/// A limit of statics: up to it forces exist that balance the loads, and beyond it none do. As friction is not associated, motion may begin
/// earlier. Loads that are balanced at two values of a load's multiplier are balanced between them, and with more friction if with less.
///
/// # Errors
/// [`SimulationError::Setting`] for a direction without length or a load of another size than nv; otherwise as
/// [`stability`](crate::stability()).
pub fn safety(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &StabilitySettings,
    question: &SafetyQuestion,
) -> Result<Safety, SimulationError> {
    let build = |model: &Model| rest_problem(model, state, input, &settings.simulation, settings.contact_tolerance);
    safety_of(model, &build, settings, question)
}

/// The same of a model whose problem is made in this way.
pub(crate) fn safety_of(
    model: &Model,
    build: &dyn Fn(&Model) -> Result<RestProblem, SimulationError>,
    settings: &StabilitySettings,
    question: &SafetyQuestion,
) -> Result<Safety, SimulationError> {
    let family = Family::new(model, build, question)?;
    let [begin, end] = question.range();
    let mut found = Safety { holds: f64::NAN, falls: f64::NAN, at_holds: None, at_falls: None };
    if !found.take(&family, begin, settings) || found.at_holds.is_none() {
        return Ok(found);
    }
    let reached = found.take(&family, end, settings);
    if !reached || found.at_falls.is_none() {
        found.falls = if end > begin { f64::INFINITY } else { f64::NAN };
        return Ok(found);
    }
    for _ in 0..HALVINGS {
        let (holds, falls) = (found.holds, found.falls);
        if (holds - falls).abs() <= CLOSE * holds.abs().max(falls.abs()) {
            break;
        }
        if found.newton(&family, settings) && (found.holds, found.falls) != (holds, falls) {
            continue;
        }
        // Near the limit rounding leaves values at which neither proof can be had; others of the interval may do.
        let (holds, falls) = (found.holds, found.falls);
        let middle = middle(holds, falls);
        let rest = [0.25, 0.75, 0.125, 0.875].map(|part| holds + part * (falls - holds));
        if !std::iter::once(middle).chain(rest).any(|value| found.take(&family, value, settings)) {
            break;
        }
    }
    Ok(found)
}

/// Between two values: large ranges are halved by their exponents first.
fn middle(holds: f64, falls: f64) -> f64 {
    if holds > 0.0 && falls > 4.0 * holds {
        (holds * falls).sqrt()
    } else if holds == 0.0 && falls > 1.0 {
        falls.sqrt().min(0.5 * falls)
    } else {
        0.5 * (holds + falls)
    }
}

impl Safety {
    /// Looks beside the value at which the loads have no power along the last mechanism; whether that showed anything.
    fn newton(&mut self, family: &Family, settings: &StabilitySettings) -> bool {
        let Some(proof) = self.at_falls.as_ref() else { return false };
        let Some(motion) = proof.1.mechanism.as_ref() else { return false };
        let (holds, falls) = (self.holds, self.falls);
        let Some(root) = family.powerless(motion, holds, falls) else { return false };
        let nudge = (falls - holds).signum() * NUDGE * root.abs().max(holds.abs());
        // The same mechanism proves as much just beyond.
        let beyond = root + nudge;
        if (beyond - holds).abs() < (falls - holds).abs() {
            let problem = family.at(beyond);
            if certify_mechanism(&problem, motion).residual <= settings.tolerance {
                let mut proof = StabilityProof::new(Verdict::MustMove);
                proof.mechanism = Some(motion.clone());
                (self.falls, self.at_falls) = (beyond, Some((problem, proof)));
            }
        }
        let before = root - nudge;
        let inside = (before - holds).signum() == (falls - holds).signum();
        inside && self.take(family, before, settings)
    }

    /// Looks at a value; whether a proof was found there.
    fn take(&mut self, family: &Family, value: f64, settings: &StabilitySettings) -> bool {
        let problem = family.at(value);
        let mut search = Search::new();
        match decide(&problem, &mut search, settings) {
            Decided::Balance => {
                let mut proof = StabilityProof::new(Verdict::Stands);
                proof.balance = search.balance.map(Box::new);
                (self.holds, self.at_holds) = (value, Some((problem, proof)));
            }
            Decided::Mechanism(mechanism) => {
                let mut proof = StabilityProof::new(Verdict::MustMove);
                // The motion of most power cuts deepest, where it proves as much.
                let sharp = certify_mechanism(&problem, &mechanism.collapse).residual <= settings.tolerance;
                proof.mechanism = Some(if sharp { mechanism.collapse } else { mechanism.motion });
                (self.falls, self.at_falls) = (value, Some((problem, proof)));
            }
            Decided::Neither { .. } => return false,
        }
        true
    }
}

/// The problem for every value of what is asked.
struct Family {
    problem: ContactProblem,
    kind: Kind,
}

enum Kind {
    /// `v^f + f Δv`.
    Linear(Vec<f64>),
    /// `v^f + (cos f − 1) v_g + sin f Δv`, with `v_g` what gravity gives.
    Turned(Vec<f64>, Vec<f64>),
    /// `f μ`.
    Friction,
    /// Friction groups with `f` times their bounds, and `v^f + (f − 1) Δv`, with Δv what the middles of the force ranges give.
    Bounds(Vec<usize>, Vec<f64>),
}

impl Family {
    fn new(
        model: &Model,
        build: &dyn Fn(&Model) -> Result<RestProblem, SimulationError>,
        question: &SafetyQuestion,
    ) -> Result<Self, SimulationError> {
        let rest = build(model)?;
        let problem = rest.problem.clone();
        let with_gravity = |gravity: DVec3| -> Result<Vec<f64>, SimulationError> {
            let mut other = model.clone();
            other.gravity = gravity;
            Ok(build(&other)?.problem.free_velocity)
        };
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let wrong = |found| {
            let expected = "a finite direction of some length across gravity, which is not zero";
            Err(SimulationError::Setting { setting: "direction", expected, found })
        };
        let gravity = model.gravity;
        let kind = match question {
            SafetyQuestion::Friction => Kind::Friction,
            SafetyQuestion::Motors => {
                let is_servo = |j: &usize| matches!(rest.groups[*j], FrictionSource::Servo { .. });
                let servos = (0..rest.groups.len()).filter(is_servo).collect();
                let mut idle = model.clone();
                let ranges = idle.actuators.iter_mut().filter_map(|actuator| actuator.force_range.as_mut());
                ranges.for_each(|[lower, upper]| (*lower, *upper) = (0.5 * (*lower - *upper), 0.5 * (*upper - *lower)));
                Kind::Bounds(servos, difference(&problem.free_velocity, &build(&idle)?.problem.free_velocity))
            }
            SafetyQuestion::Load(load) => {
                if load.len() != model.nv || !load.iter().all(|x| x.is_finite()) {
                    let expected = "nv finite numbers";
                    return Err(SimulationError::Setting { setting: "load", expected, found: load.len() as f64 });
                }
                let mut change: Vec<f64> = load.iter().map(|x| problem.timestep * x).collect();
                problem.mass_factor.solve_in_place(&mut change);
                Kind::Linear(change)
            }
            SafetyQuestion::Weight(body) => {
                if model.bodies.get(body.index()).is_none_or(|b| b.inertia.mass <= 0.0) {
                    let expected = "a body of the model that has mass";
                    return Err(SimulationError::Setting { setting: "body", expected, found: f64::from(body.0) });
                }
                // Gravity on this body alone, by its mass.
                let mut weightless = model.clone();
                let mass = weightless.bodies[body.index()].inertia.mass;
                weightless.bodies[body.index()].gravity_compensation += 1.0;
                let without = build(&weightless)?.problem.free_velocity;
                Kind::Linear(difference(&problem.free_velocity, &without).iter().map(|v| v / mass).collect())
            }
            SafetyQuestion::Horizontal(direction) | SafetyQuestion::Tilt(direction) => {
                let across = direction.reject_from(gravity.try_normalize().unwrap_or(DVec3::Z));
                let Some(unit) = across.try_normalize() else { return wrong(direction.length()) };
                if gravity == DVec3::ZERO {
                    return wrong(0.0);
                }
                let still = with_gravity(DVec3::ZERO)?;
                let sideways = difference(&with_gravity(gravity.length() * unit)?, &still);
                match question {
                    SafetyQuestion::Tilt(_) => Kind::Turned(difference(&problem.free_velocity, &still), sideways),
                    _ => Kind::Linear(sideways),
                }
            }
        };
        Ok(Self { problem, kind })
    }

    fn at(&self, value: f64) -> ContactProblem {
        let mut problem = self.problem.clone();
        let free = problem.free_velocity.iter_mut();
        match &self.kind {
            Kind::Linear(change) => free.zip(change).for_each(|(v, d)| *v += value * d),
            Kind::Turned(own, sideways) => {
                let (sin, cos) = value.sin_cos();
                free.zip(own.iter().zip(sideways)).for_each(|(v, (g, d))| *v += (cos - 1.0) * g + sin * d);
            }
            Kind::Friction => problem.friction.iter_mut().for_each(|mu| *mu *= value),
            Kind::Bounds(groups, middle) => {
                free.zip(middle).for_each(|(v, d)| *v += (value - 1.0) * d);
                let bounds = groups.iter().map(|&j| (j, problem.friction_groups.bound[j].constant()));
                let scaled: Vec<(usize, f64)> = bounds.map(|(j, bound)| (j, value * bound)).collect();
                for (j, bound) in scaled {
                    problem.friction_groups.bound[j] = FrictionBound::Impulse(bound);
                }
            }
        }
        problem
    }

    /// The value nearest to `falls` at which the loads have no power along a motion that has power there.
    fn powerless(&self, motion: &[f64], holds: f64, falls: f64) -> Option<f64> {
        if matches!(self.kind, Kind::Friction | Kind::Bounds(..)) {
            return None;
        }
        let mut momentum = vec![0.0; motion.len()];
        self.problem.mass.multiply_into(motion, &mut momentum);
        let along = |v: &[f64]| momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>();
        let own = certify_mechanism(&self.at(falls), motion).power;
        let change = |value: f64| match &self.kind {
            Kind::Linear(change) => (value - falls) * along(change),
            Kind::Turned(gravity, sideways) => {
                (value.cos() - falls.cos()) * along(gravity) + (value.sin() - falls.sin()) * along(sideways)
            }
            Kind::Friction | Kind::Bounds(..) => 0.0,
        };
        let (mut low, mut high) = (holds, falls);
        if own + change(low) > 0.0 {
            return None;
        }
        for _ in 0..2 * HALVINGS {
            let middle = 0.5 * (low + high);
            *(if own + change(middle) > 0.0 { &mut high } else { &mut low }) = middle;
        }
        Some(high)
    }
}
