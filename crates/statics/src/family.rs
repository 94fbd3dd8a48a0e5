//! The problem of a configuration for every value of what is increased.

use signorini_contact::statics::certify_mechanism;
use signorini_contact::{ContactProblem, FrictionBound};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Model, SpatialVector};
use signorini_simulation::{FrictionSource, SimulationError};

use crate::configuration::Configuration;
use crate::question::SafetyQuestion;
use crate::settings::StabilitySettings;

/// Halvings of the interval in which a motion loses its power: to the last digits.
const HALVINGS: u32 = 160;

/// The problem for every value of what is asked.
#[derive(Clone)]
pub(crate) struct Family {
    pub problem: ContactProblem,
    pub kind: Kind,
}

#[derive(Clone)]
pub(crate) enum Kind {
    /// `v^f + f Δv`.
    Linear(Vec<f64>),
    /// `v^f + (cos f − 1) v_g + sin f Δv`, with `v_g` what gravity gives.
    Turned(Vec<f64>, Vec<f64>),
    /// `f μ`.
    Friction,
    /// Friction groups with `f` times their bounds, and `v^f + (f − 1) Δv`, with Δv what the middles of the force ranges give.
    Bounds(Vec<usize>, Vec<f64>),
}

/// Gravity turned sideways, as changes of the free velocity.
pub(crate) struct Sideways<const N: usize> {
    /// The problem as it is.
    pub problem: ContactProblem,
    /// What gravity gives.
    pub gravity: Vec<f64>,
    /// What gravity of its size along each direction gives.
    pub along: [Vec<f64>; N],
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

impl<const N: usize> Sideways<N> {
    /// For these unit directions.
    pub fn new(
        configuration: &Configuration,
        settings: &StabilitySettings,
        units: &[DVec3; N],
    ) -> Result<Self, SimulationError> {
        let with_gravity = |gravity: DVec3| -> Result<Vec<f64>, SimulationError> {
            let mut other = configuration.model.clone();
            other.gravity = gravity;
            Ok(configuration.problem(&other, &configuration.input, settings)?.0.problem.free_velocity)
        };
        let still = with_gravity(DVec3::ZERO)?;
        let size = configuration.model.gravity.length();
        let mut along = [const { Vec::new() }; N];
        for (change, unit) in along.iter_mut().zip(units) {
            *change = difference(&with_gravity(size * *unit)?, &still);
        }
        let problem = configuration.problem(configuration.model, &configuration.input, settings)?.0.problem;
        let gravity = difference(&problem.free_velocity, &still);
        Ok(Self { problem, gravity, along })
    }
}

/// The unit vector of a direction across gravity.
pub(crate) fn across_gravity(model: &Model, direction: DVec3) -> Result<DVec3, SimulationError> {
    let expected = "a finite direction of some length across gravity, which is not zero";
    let wrong = |found| SimulationError::Setting { setting: "direction", expected, found };
    let down = model.gravity.try_normalize().ok_or(wrong(0.0))?;
    direction.reject_from(down).try_normalize().ok_or(wrong(direction.length()))
}

/// Changes of the free velocity by forces of 1 N at a body's centre of mass.
pub(crate) fn pushes<const N: usize>(
    configuration: &Configuration,
    settings: &StabilitySettings,
    body: BodyId,
    units: &[DVec3; N],
) -> Result<[Vec<f64>; N], SimulationError> {
    let model = configuration.model;
    if body.index() == 0 || body.index() >= model.bodies.len() {
        let expected = "a body of the model that is not the world";
        return Err(SimulationError::Setting { setting: "body", expected, found: f64::from(body.0) });
    }
    let under = |force: DVec3| -> Result<Vec<f64>, SimulationError> {
        let mut input = configuration.input.clone();
        input.wrench.resize(model.bodies.len(), SpatialVector::ZERO);
        input.wrench[body.index()].linear += force;
        Ok(configuration.problem(model, &input, settings)?.0.problem.free_velocity)
    };
    // In units of the body's weight, so that differences keep their digits.
    let mass = model.bodies[body.index()].inertia.mass;
    let unit = if mass > 0.0 { mass * model.gravity.length().max(1.0) } else { 1.0 };
    let still = under(DVec3::ZERO)?;
    let mut changes = [const { Vec::new() }; N];
    for (change, e) in changes.iter_mut().zip(units) {
        *change = difference(&under(unit * *e)?, &still).into_iter().map(|v| v / unit).collect();
    }
    Ok(changes)
}

impl Family {
    /// The family of a question.
    pub fn new(
        configuration: &Configuration,
        settings: &StabilitySettings,
        question: &SafetyQuestion,
    ) -> Result<Self, SimulationError> {
        let model = configuration.model;
        let (rest, _) = configuration.problem(model, &configuration.input, settings)?;
        let problem = rest.problem;
        let kind = match question {
            SafetyQuestion::Friction => Kind::Friction,
            SafetyQuestion::Motors => {
                let is_servo = |j: &usize| matches!(rest.groups[*j], FrictionSource::Servo { .. });
                let servos = (0..rest.groups.len()).filter(is_servo).collect();
                let mut idle = model.clone();
                let ranges = idle.actuators.iter_mut().filter_map(|actuator| actuator.force_range.as_mut());
                ranges.for_each(|[lower, upper]| (*lower, *upper) = (0.5 * (*lower - *upper), 0.5 * (*upper - *lower)));
                let idle = configuration.problem(&idle, &configuration.input, settings)?.0.problem.free_velocity;
                Kind::Bounds(servos, difference(&problem.free_velocity, &idle))
            }
            SafetyQuestion::Load(load) => Kind::Linear(of_load(&problem, load)?),
            SafetyQuestion::Weight(body) => Kind::Linear(of_weight(configuration, settings, *body, &problem)?),
            SafetyQuestion::Push(body, direction) => {
                let expected = "a finite direction of some length";
                let found = direction.length();
                let unit = direction.try_normalize();
                let unit = unit.ok_or(SimulationError::Setting { setting: "direction", expected, found })?;
                let [change] = pushes(configuration, settings, *body, &[unit])?;
                Kind::Linear(change)
            }
            SafetyQuestion::Horizontal(direction) | SafetyQuestion::Tilt(direction) => {
                let unit = across_gravity(model, *direction)?;
                let Sideways { gravity, along: [along], .. } = Sideways::new(configuration, settings, &[unit])?;
                match question {
                    SafetyQuestion::Tilt(_) => Kind::Turned(gravity, along),
                    _ => Kind::Linear(along),
                }
            }
        };
        Ok(Self { problem, kind })
    }

    /// The problem at a value.
    pub fn at(&self, value: f64) -> ContactProblem {
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

    /// The value at which the largest entry of what is increased is as large as that of the loads; 0 where it is no load.
    pub fn as_large_as_loads(&self) -> f64 {
        let Kind::Linear(change) = &self.kind else { return 0.0 };
        let largest = |velocity: &[f64]| {
            let mut momentum = vec![0.0; velocity.len()];
            self.problem.mass.multiply_into(velocity, &mut momentum);
            momentum.into_iter().fold(0.0, |most: f64, p| most.max(p.abs()))
        };
        let (loads, increased) = (largest(&self.problem.free_velocity), largest(change));
        if increased > 0.0 { loads / increased } else { 0.0 }
    }

    /// The value nearest to `falls` at which the loads have no power along a motion that has power there.
    pub fn powerless(&self, motion: &[f64], holds: f64, falls: f64) -> Option<f64> {
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
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if own + change(middle) > 0.0 { &mut high } else { &mut low }) = middle;
        }
        Some(high)
    }
}

fn of_load(problem: &ContactProblem, load: &[f64]) -> Result<Vec<f64>, SimulationError> {
    if load.len() != problem.nv() || !load.iter().all(|x| x.is_finite()) {
        let expected = "nv finite numbers";
        return Err(SimulationError::Setting { setting: "load", expected, found: load.len() as f64 });
    }
    let mut change: Vec<f64> = load.iter().map(|x| problem.timestep * x).collect();
    problem.mass_factor.solve_in_place(&mut change);
    Ok(change)
}

/// Gravity on a body alone, by its mass.
fn of_weight(
    configuration: &Configuration,
    settings: &StabilitySettings,
    body: BodyId,
    problem: &ContactProblem,
) -> Result<Vec<f64>, SimulationError> {
    let model = configuration.model;
    if model.bodies.get(body.index()).is_none_or(|b| b.inertia.mass <= 0.0) {
        let expected = "a body of the model that has mass";
        return Err(SimulationError::Setting { setting: "body", expected, found: f64::from(body.0) });
    }
    let mut weightless = model.clone();
    let mass = weightless.bodies[body.index()].inertia.mass;
    weightless.bodies[body.index()].gravity_compensation += 1.0;
    let without = configuration.problem(&weightless, &configuration.input, settings)?.0.problem.free_velocity;
    Ok(difference(&problem.free_velocity, &without).iter().map(|v| v / mass).collect())
}
