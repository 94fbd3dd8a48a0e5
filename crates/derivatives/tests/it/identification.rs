//! Parameters from motions that were made with known ones.

use signorini_derivatives::ScalarParameter;
use signorini_derivatives::identification::{
    IdentificationError, IdentificationSettings, Recording, Unknown, identify,
};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Geom, GeomId, Geometry, Input, Joint, JointId, Model, ModelBuilder, State};
use signorini_simulation::{Settings, Simulation};
use signorini_testkit::Random;

use crate::common::random_vector;

const INTERVAL: f64 = 0.02;

const BOX: Geometry = Geometry::Box { half_extents: DVec3::new(0.1, 0.08, 0.06) };
/// For exact comparisons: which corners of a box brake it while it slides is not determined.
const BALL: Geometry = Geometry::Sphere { radius: 0.1 };

/// A body thrown on a floor, where it slides, with friction `mu` and centre of mass off its middle by `offset`.
fn thrown(shape: Geometry, mu: f64, offset: f64) -> Model {
    let mut world = ModelBuilder::new("thrown");
    world.floor();
    let shape = Geom::from(shape);
    let shape = shape.with_friction(mu).with_placement([-offset, 0.0, 0.0]);
    world.body("thrown").at([0.0, 0.0, 0.3]).free().solid(shape, 2.0).add().expect("a body");
    let mut model = world.build().expect("a model");
    model.geoms[0].friction = mu;
    model.bodies[1].inertia.center_of_mass = DVec3::ZERO;
    model
}

/// Motions of a model from random states, sampled with noise of positions.
fn recorded(model: &Model, count: u64, noise: f64) -> Vec<Recording> {
    let settings = Settings::default().with_timestep(Some(INTERVAL / 4.0));
    let motion = |seed: u64| {
        let mut random = Random::new(seed);
        let mut state = State::new(model);
        let v = random_vector(&mut random, 6, 1.0);
        state.v.copy_from_slice(&v);
        let mut simulation = Simulation::new(model.clone(), settings.clone()).expect("a simulation");
        simulation.set_state(&state).expect("a state");
        let mut states = vec![state];
        for _ in 0..30 {
            simulation.run(INTERVAL, |_, _| true).expect("steps");
            let mut sample = simulation.state().clone();
            sample.q[..3].iter_mut().for_each(|x| *x += noise * random.normal());
            states.push(sample);
        }
        Recording::new(states)
    };
    (0..count).map(motion).collect()
}

fn friction() -> Unknown {
    let both = vec![(ScalarParameter::Friction(GeomId(0)), 1.0), (ScalarParameter::Friction(GeomId(1)), 1.0)];
    Unknown::new("friction", both).with_bounds([0.01, 1.5])
}

fn asked() -> IdentificationSettings {
    let mut asked = IdentificationSettings::new(INTERVAL);
    asked.substeps = 4;
    asked.window = 10;
    asked.tolerance = 1e-12;
    asked
}

#[test]
fn friction_and_the_place_of_a_shape_are_found_from_exact_motions() {
    let recordings = recorded(&thrown(BALL, 0.35, 0.01), 6, 0.0);
    let unknowns = [friction(), Unknown::new("offset", vec![(ScalarParameter::GeomPosition(GeomId(1), 0), 1.0)])];
    let start = thrown(BALL, 0.5, 0.0);
    let found = identify(&start, &Settings::default(), &recordings, &unknowns, &asked(), |_| true).expect("an answer");
    assert!(
        (found.values[0] - 0.35).abs() < 1e-6 && (found.values[1] + 0.01).abs() < 1e-7,
        "{:?} {:?}",
        found.values,
        found.objective
    );
    assert!(found.determined.iter().all(|determined| *determined) && found.objective[1] < 1e-10 * found.objective[0]);
    assert_eq!(found.model.geoms[0].friction, found.model.geoms[1].friction);
}

#[test]
fn what_the_data_leave_open_is_said() {
    // A free body that slides tells neither mass nor inertia apart from the others: all scale together.
    let model = thrown(BOX, 0.4, 0.0);
    let recordings = recorded(&model, 4, 0.0);
    let body = BodyId(1);
    let moments: Vec<_> = (0..3)
        .map(|k| (ScalarParameter::Inertia(body, [k, k]), model.bodies[1].inertia.rotational.col(k)[k]))
        .collect();
    let scale = Unknown::new("inertia", moments).with_bounds([1e-4, 1.0]);
    let mass = Unknown::new("mass", vec![(ScalarParameter::Mass(body), 1.0)]).with_bounds([0.1, 10.0]);
    let unknowns = [friction(), mass, scale];
    let found = identify(&model, &Settings::default(), &recordings, &unknowns, &asked(), |_| true).expect("an answer");
    assert_eq!(found.determined, [true, false, false]);
    assert!(found.covariance[4].is_infinite() && found.covariance[0].is_finite());
}

#[test]
fn the_covariance_is_the_spread_of_repeated_data() {
    let (model, truth) = (thrown(BOX, 0.4, 0.0), 0.4);
    let (mut sum, mut squares, mut predicted) = (0.0, 0.0, 0.0);
    let sets = 24;
    for set in 0..sets {
        // The same motions with other noise, so that noise alone makes the spread.
        let clean = recorded(&model, 8, 0.0);
        let mut random = Random::new(900 + set);
        let noisy = clean.into_iter().map(|mut recording| {
            for state in recording.states.iter_mut().skip(1) {
                state.q[..3].iter_mut().for_each(|x| *x += 1e-3 * random.normal());
            }
            recording
        });
        let mut whole = asked();
        (whole.window, whole.tolerance) = (0, 1e-8);
        let recordings: Vec<_> = noisy.collect();
        let found = identify(&model, &Settings::default(), &recordings, &[friction()], &whole, |_| true);
        let found = found.expect("an answer");
        let off = found.values[0] - truth;
        (sum, squares, predicted) = (sum + off, squares + off * off, predicted + found.covariance[0].sqrt());
    }
    let n = sets as f64;
    let spread = ((squares - sum * sum / n) / (n - 1.0)).sqrt();
    let ratio = predicted / n / spread;
    // 24 draws of a spread are within a factor of 1.4 with 99 %; eight recordings make a covariance of as few.
    assert!((0.5..2.0).contains(&ratio), "{ratio:.2}: predicted {:.1e}, found {spread:.1e}", predicted / n);
}

#[test]
fn drawn_sets_spread_as_the_gradients_of_smooth_motions_say() {
    let mut random = Random::new(77);
    let recordings: Vec<_> = recorded(&thrown(BALL, 0.4, 0.0), 16, 0.0)
        .into_iter()
        .map(|mut recording| {
            for state in recording.states.iter_mut().skip(1) {
                state.q[..3].iter_mut().for_each(|x| *x += 1e-3 * random.normal());
            }
            recording
        })
        .collect();
    let mut drawn = asked();
    drawn.tolerance = 1e-8;
    let find = |asked: &IdentificationSettings| {
        let model = thrown(BALL, 0.4, 0.0);
        identify(&model, &Settings::default(), &recordings, &[friction()], asked, |_| true).expect("an answer")
    };
    let by_gradients = find(&drawn);
    drawn.draws = 40;
    let by_draws = find(&drawn);
    assert_eq!(by_gradients.values, by_draws.values);
    let ratio = (by_draws.covariance[0] / by_gradients.covariance[0]).sqrt();
    // 40 draws of a spread are within 1.3 with 99 %.
    assert!((0.6..1.6).contains(&ratio), "{ratio:.2}");
}

/// Motions ask for a negative damping, and for moments that no rigid body has: what is found is a model all the same.
#[test]
fn what_is_found_is_a_model() {
    let mut world = ModelBuilder::new("cart");
    let joint = Joint::slide("track", DVec3::X).with_damping(0.5);
    world.body("cart").joint(joint).solid(Geom::from(BALL), 2.0).add().expect("a body");
    let cart = world.build().expect("a model");
    // m v̇ = c v with c = 0.4 N·s/m.
    let sample = |k: usize| {
        let (rate, t) = (0.2, INTERVAL * k as f64);
        State::at(vec![((rate * t).exp() - 1.0) / rate], vec![(rate * t).exp()])
    };
    let recordings = [Recording::new((0..30).map(sample).collect())];
    let damping = Unknown::new("damping", vec![(ScalarParameter::Damping(JointId(0)), 1.0)]);
    let run = |model: &Model, recordings: &[Recording], unknown: Unknown| {
        identify(model, &Settings::default(), recordings, &[unknown], &asked(), |_| true).expect("an answer")
    };
    let found = run(&cart, &recordings, damping);
    assert_eq!((found.values[0], found.at_bound[0]), (0.0, true));

    let model = thrown(BOX, 0.4, 0.0);
    let mut other = model.clone();
    other.bodies[1].inertia.rotational.x_axis.x *= 10.0;
    let recordings = recorded(&other, 4, 0.0);
    let moment = Unknown::new("moment", vec![(ScalarParameter::Inertia(BodyId(1), [0, 0]), 1.0)]);
    let found = run(&model, &recordings, moment);
    let moments = found.model.bodies[1].inertia.rotational;
    assert!(found.values[0] > model.bodies[1].inertia.rotational.x_axis.x, "{moments}");
    assert!(found.values[0] < 1.01 * (moments.y_axis.y + moments.z_axis.z), "{moments}");
    found.model.check_numbers().expect("moments of a rigid body");
}

#[test]
fn faults_are_named() {
    let model = thrown(BOX, 0.4, 0.0);
    let run = |unknown: Unknown, recordings: &[Recording]| {
        identify(&model, &Settings::default(), recordings, &[unknown], &asked(), |_| true).expect_err("a fault")
    };
    let recordings = recorded(&model, 1, 0.0);
    let missing = Unknown::new("no geom", vec![(ScalarParameter::Friction(GeomId(9)), 1.0)]);
    assert!(matches!(run(missing, &recordings), IdentificationError::NoSuchNumber(name) if name == "no geom"));
    assert!(matches!(run(friction().with_bounds([0.5, 1.0]), &recordings), IdentificationError::OutsideBounds { .. }));
    let cut = recordings[0].clone().with_inputs(vec![Input::default(); 3]);
    let text = run(friction(), &[cut]).to_string();
    assert!(text.contains("31 samples and 3 inputs"), "{text}");
    let text = run(friction().with_prior(1.0, 0.0), &recordings).to_string();
    assert!(text.contains("'friction' has the prior 1 ± 0"), "{text}");
}
