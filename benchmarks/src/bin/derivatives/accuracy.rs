//! How near the derivatives of steps are to differences of the steps inside their modes, by states, controls, forces and parameters.

use std::collections::BTreeMap;
use std::error::Error;

use signorini::derivatives::{Direction, ScalarParameter, StepDerivatives, Validity};
use signorini::multibody::{ActuatorId, Input, Model, State};
use signorini_testkit::Random;

use crate::Options;
use crate::bench::{Bench, Unit};
use crate::models::{self, Subject};

/// Widths of differences, as parts of a change as large as a step makes.
const WIDTHS: [f64; 9] = [1e-1, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 1e-7];
/// A derivative this near to differences is right, relative to its largest entry.
const AGREES: f64 = 1e-7;
/// Differences that agree so well are not taken at other widths.
const WELL: f64 = 1e-9;
/// Columns are not compared more finely than if a change of the whole number gave this part of the speeds of the step: [`AGREES`] of that is 1e-9, to
/// which steps are solved by default.
const LOST: f64 = 1e-2;
/// Steps of a motion, every fourth of which is disturbed and looked at.
const STEPS: u32 = 80;
/// Numbers of a kind that are tried for one that the step feels.
const TRIES: u32 = 20;
/// Steps are solved to this, so that differences resolve them.
const TOLERANCE: f64 = 1e-12;
/// Motions for each state that is wanted: most states of some models have no derivative.
const MOST: u64 = 20;

/// Compares random states of each model with differences; how many derivatives differ from differences that agree among themselves.
pub fn compare(options: &Options, states: usize) -> Result<u64, Box<dyn Error>> {
    println!("{:<18} {:<18} compared   median     99 %    worst  above  unresolved  left  without", "", "by");
    let mut wrong = 0;
    for mut subject in models::all(options.robots.as_deref())? {
        if options.only.as_deref().is_none_or(|only| only == subject.name) {
            subject.bench.settings.tolerance = TOLERANCE;
            let comparison = Comparison::of(&mut subject, states);
            println!(
                "{}: {:.1} closed contacts and limits in a state",
                comparison.subject.name,
                comparison.closed_in_the_mean()
            );
            for (kind, tally) in &comparison.tallies {
                wrong += tally.report(comparison.subject.name, kind);
            }
        }
    }
    Ok(wrong)
}

/// What became of the comparisons by one kind of number.
#[derive(Default)]
struct Tally {
    errors: Vec<f64>,
    /// Errors above [`AGREES`] while differences of different widths agree no better.
    unresolved: u64,
    /// Of which no difference stays in the mode.
    left: u64,
    /// Which have no derivative.
    without: u64,
    wrong: u64,
}

impl Tally {
    fn add(&mut self, found: Option<Found>, told: impl FnOnce() -> String) {
        let Some(found) = found else {
            self.left += 1;
            return;
        };
        if found.error > AGREES {
            let resolved = found.scatter <= AGREES;
            println!(
                "{}: off by {:.1e} of {:.1e}, differences by {:.1e} among themselves",
                told(),
                found.error,
                found.size,
                found.scatter
            );
            if resolved { self.wrong += 1 } else { self.unresolved += 1 }
        }
        self.errors.push(found.error);
    }

    fn report(&self, name: &str, kind: &str) -> u64 {
        let mut errors = self.errors.clone();
        errors.sort_by(f64::total_cmp);
        let at =
            |part: f64| errors.get((part * errors.len().saturating_sub(1) as f64) as usize).map_or(f64::NAN, |x| *x);
        let above = errors.iter().filter(|error| **error > AGREES).count();
        let (count, [median, most, worst]) = (errors.len(), [0.5, 0.99, 1.0].map(at));
        println!(
            "{name:<18} {kind:<18} {count:>8} {median:>8.1e} {most:>8.1e} {worst:>8.1e} {above:>6} {:>11} {:>5} {:>8}",
            self.unresolved, self.left, self.without
        );
        self.wrong
    }
}

/// How far a derivative is from differences, and they from each other at two widths, both at best and relative to the size of the derivative.
struct Found {
    error: f64,
    scatter: f64,
    size: f64,
}

struct Comparison<'a> {
    subject: &'a mut Subject,
    kinds: BTreeMap<String, Vec<ScalarParameter>>,
    random: Random,
    tallies: BTreeMap<String, Tally>,
    /// Contacts and limits that are closed, summed over the states that were compared.
    closed: usize,
}

impl<'a> Comparison<'a> {
    fn of(subject: &'a mut Subject, states: usize) -> Self {
        let mut kinds: BTreeMap<String, Vec<ScalarParameter>> = BTreeMap::new();
        for parameter in ScalarParameter::all(&subject.bench.model) {
            let told = format!("{parameter:?}");
            let kind = told.split('(').next().unwrap_or_default();
            kinds.entry(kind.to_owned()).or_default().push(parameter);
        }
        let (random, tallies) = (Random::new(1), BTreeMap::new());
        let mut comparison = Self { subject, kinds, random, tallies, closed: 0 };
        for seed in 0..MOST * states as u64 {
            comparison.motion(seed, states);
            if comparison.count() >= states {
                break;
            }
        }
        comparison
    }

    fn closed_in_the_mean(&self) -> f64 {
        self.closed as f64 / self.count().max(1) as f64
    }

    fn count(&self) -> usize {
        self.tallies.get(MOTION).map_or(0, |tally| tally.errors.len())
    }

    /// One motion from the beginning at random velocities, with controls that change.
    fn motion(&mut self, seed: u64, states: usize) {
        self.random = Random::new(seed);
        let (mut state, mut input) = (self.subject.state.clone(), self.subject.input.clone());
        let [_, by_velocity, by_control] = self.subject.sizes;
        for n in 0..STEPS {
            if n % 20 == 0 {
                input.control.iter_mut().for_each(|u| *u += by_control * self.random.normal());
                state.v.iter_mut().for_each(|v| *v += by_velocity * self.random.normal());
            }
            if n % 4 == 0 && self.count() < states {
                let (near, with) = self.disturbed(&state, &input);
                self.look(&near, &with);
            }
            let Some((next, _)) = self.subject.bench.step(&state, &input) else { return };
            state = next;
        }
    }

    fn disturbed(&mut self, state: &State, input: &Input) -> (State, Input) {
        let bench = &self.subject.bench;
        let (nv, nu) = (bench.model.nv, bench.model.actuators.len());
        let sizes = self.subject.sizes.into_iter().zip([nv, nv, nu]).flat_map(|(size, n)| vec![size; n]);
        let mut change: Vec<f64> = sizes.map(|size| size * self.random.normal()).collect();
        change.resize(3 * nv + nu, 0.0);
        bench.moved(state, input, &change, 1.0)
    }

    /// Compares the derivatives of one step, where they exist.
    fn look(&mut self, state: &State, input: &Input) {
        let bench = &mut self.subject.bench;
        bench.workspace.clear_warm_start();
        let Some(next) = bench.differentiate(state, input) else { return };
        let tally = self.tallies.entry(MOTION.to_owned()).or_default();
        if *bench.derivatives.validity() != Validity::Exact {
            tally.without += 1;
            return;
        }
        let change = bench.change(&mut self.random);
        let product = bench.derivatives.product(&change).unwrap_or_default();
        let size = largest(&product);
        let signature = bench.signature();
        let closed = signature.iter().filter(|unit| matches!(unit, Unit::Contact(..))).count();
        let found = nearest(&product, size, |h| {
            let end = bench.end((state, input), &next, &change, h)?;
            (bench.signature() == signature).then_some(end)
        });
        let count = tally.errors.len();
        let is_left = found.is_none();
        tally.add(found, || format!("state {count}"));
        if !is_left {
            self.closed += closed;
            self.look_at_parameters(state, input);
        }
    }

    /// The same by one number of each kind that the step feels, where one of a few has a part in it.
    fn look_at_parameters(&mut self, state: &State, input: &Input) {
        for (kind, all) in &self.kinds {
            let tally = self.tallies.entry(kind.clone()).or_default();
            for _ in 0..TRIES {
                let parameter = self.random.choice(all);
                match by_parameter(&mut self.subject.bench, (state, input), parameter) {
                    Ok(Column::Unfelt) => continue,
                    Ok(Column::Left) => tally.left += 1,
                    Ok(Column::Near(found)) => tally.add(Some(found), || format!("{parameter:?}")),
                    Err(_) => tally.without += 1,
                }
                break;
            }
        }
        self.subject.bench.derivatives = StepDerivatives::new(&self.subject.bench.model);
    }
}

/// What the comparison by one number of a model came to.
enum Column {
    /// The step does not depend on it.
    Unfelt,
    /// No difference stays in the mode.
    Left,
    Near(Found),
}

/// The kind of changes of state, control and force.
const MOTION: &str = " q, v, u, τ";

/// How near the column of a parameter is to differences of steps of changed models.
fn by_parameter(
    bench: &mut Bench,
    (state, input): (&State, &Input),
    parameter: ScalarParameter,
) -> Result<Column, String> {
    let direction: Direction = vec![(parameter, 1.0)];
    bench.derivatives = StepDerivatives::with_parameters(&bench.model, vec![direction]);
    bench.workspace.clear_warm_start();
    let next = bench.differentiate(state, input).ok_or("no step")?;
    let matrix = bench.derivatives.parameter_matrix()?;
    let (column, unit, signature) = (matrix.data(), unit_of(&bench.model, parameter), bench.signature());
    // By parts of the unit.
    let column: Vec<f64> = column.iter().map(|x| x * unit).collect();
    if column.iter().all(|x| *x == 0.0) {
        return Ok(Column::Unfelt);
    }
    let size = largest(&column).max(natural_size(&bench.model, parameter, unit, &next));
    let found = nearest(&column, size, |part| {
        let (mut model, mut state) = (bench.model.clone(), state.clone());
        let h = part * unit;
        match parameter {
            ScalarParameter::Activation(ActuatorId(a)) => {
                state.activation[model.actuators[a as usize].activation.as_ref()?.index] += h;
            }
            _ => {
                let value = parameter.value(&model)?;
                parameter.set(&mut model, value + h).then_some(())?;
            }
        }
        let mut changed = Bench::new(model).ok()?;
        changed.settings.tolerance = TOLERANCE;
        let (end, _) = changed.step(&state, input)?;
        (changed.signature() == signature).then(|| bench.between(&end, &next))
    });
    Ok(found.map_or(Column::Left, Column::Near))
}

/// The size of velocities that a number has to do with: those with which places and sizes are made up for in a step, and a part of those at hand.
fn natural_size(model: &Model, parameter: ScalarParameter, unit: f64, next: &State) -> f64 {
    match parameter {
        ScalarParameter::GeomPosition(..) | ScalarParameter::GeomSize(..) | ScalarParameter::Margin(_) => {
            unit / model.timestep
        }
        _ => LOST * largest(&next.v).max(model.gravity.length() * model.timestep),
    }
}

/// What a number is changed in parts of.
fn unit_of(model: &Model, parameter: ScalarParameter) -> f64 {
    let value = parameter.value(model).unwrap_or(0.1).abs();
    match parameter {
        // A fifth of the least moment leaves an inertia positive definite.
        ScalarParameter::Inertia(body, _) => {
            let moments = model.bodies[body.index()].inertia.rotational;
            0.2 * [moments.x_axis.x, moments.y_axis.y, moments.z_axis.z].into_iter().fold(f64::INFINITY, f64::min)
        }
        ScalarParameter::Armature(_) => value.max(1e-3),
        ScalarParameter::Gravity(_) => model.gravity.length(),
        ScalarParameter::Timestep | ScalarParameter::Mass(_) => value,
        _ => value.max(0.02),
    }
}

/// The distance of a derivative from extrapolated central differences; none where all of them leave the mode.
///
/// - `size`: what the distance is relative to
/// - `end`: the end of the step at a distance along the change, where that is in the mode
fn nearest(derivative: &[f64], size: f64, mut end: impl FnMut(f64) -> Option<Vec<f64>>) -> Option<Found> {
    let mut found: Option<Found> = None;
    let mut last: Option<Vec<f64>> = None;
    for h in WIDTHS {
        let Some(slope) = extrapolated(&mut end, h) else { continue };
        let off = |other: &[f64]| distance(&slope, other) / size;
        let error = off(derivative);
        let scatter = last.as_deref().map_or(f64::INFINITY, off);
        found = Some(match found {
            Some(so_far) => Found { error: so_far.error.min(error), scatter: so_far.scatter.min(scatter), size },
            None => Found { error, scatter, size },
        });
        if error <= WELL {
            break;
        }
        last = Some(slope);
    }
    found
}

/// Richardson's extrapolation of central differences, exact to `h⁶`.
fn extrapolated(end: &mut impl FnMut(f64) -> Option<Vec<f64>>, h: f64) -> Option<Vec<f64>> {
    let mut central = |h: f64| -> Option<Vec<f64>> {
        let (ahead, behind) = (end(h)?, end(-h)?);
        Some(ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    };
    let better = |fine: &[f64], coarse: &[f64], order: f64| -> Vec<f64> {
        fine.iter().zip(coarse).map(|(f, c)| f + (f - c) / (order - 1.0)).collect()
    };
    let [coarse, middle, fine] = [central(h)?, central(h / 2.0)?, central(h / 4.0)?];
    let (first, second) = (better(&middle, &coarse, 4.0), better(&fine, &middle, 4.0));
    Some(better(&second, &first, 16.0))
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(f64::MIN_POSITIVE, |s, x| s.max(x.abs()))
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).fold(0.0, |s, (x, y)| s.max((x - y).abs()))
}
