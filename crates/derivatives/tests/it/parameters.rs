//! Derivatives by numbers of the model against extrapolated differences of steps of changed models.

use crate::common::{Bench, Signature, disturbed, model_of};
use signorini_derivatives::{Direction, ScalarParameter, StepDerivatives};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, GeomId, Geometry, Input, JointId, Model, ModelBuilder, State, difference_into};
use signorini_simulation::Settings;
use signorini_testkit::Random;

/// Relative error inside modes, as the differences resolve it.
const TOLERANCE: f64 = 1e-7;
/// A residual with which a step's velocity is left as it is, relative to the largest velocity at hand.
const EXACT: f64 = 2e-13;
/// The largest change of a number, in parts of it.
const LARGEST: f64 = 0.2;

/// What a number is changed in parts of.
fn unit_of(model: &Model, parameter: ScalarParameter) -> f64 {
    match parameter {
        // A fifth of the least moment leaves an inertia positive definite.
        ScalarParameter::Inertia(body, _) => {
            let moments = model.bodies[body.index()].inertia.rotational;
            0.2 * [moments.x_axis.x, moments.y_axis.y, moments.z_axis.z].into_iter().fold(f64::INFINITY, f64::min)
        }
        ScalarParameter::Armature(_) => 1e-3,
        ScalarParameter::Timestep | ScalarParameter::Mass(_) => parameter.value(model).expect("a value"),
        _ => parameter.value(model).unwrap_or(0.1).abs().max(0.02),
    }
}

/// The end of the step with parameters moved by `h` along a direction, relative to `next`, `[2 nv]`, and what its contacts do.
fn end_at(
    bench: &Bench,
    (state, input): (&State, &Input),
    direction: &Direction,
    h: f64,
    next: &State,
) -> (Vec<f64>, Signature) {
    let (mut model, mut state) = (bench.model.clone(), state.clone());
    for &(parameter, weight) in direction {
        match (parameter, parameter.value(&model)) {
            (ScalarParameter::Activation(actuator), _) => {
                let activation = model.actuators[actuator.index()].activation.as_ref().expect("an activation");
                state.activation[activation.index] += h * weight;
            }
            (_, value) => assert!(parameter.set(&mut model, value.expect("a value") + h * weight)),
        }
    }
    let mut own = Bench::new(model, bench.settings.clone());
    let (q, v, signature) = own.end(&state, input);
    let mut place = vec![0.0; own.model.nv];
    difference_into(&own.model, &q, &next.q, &mut place);
    place.extend(v);
    (place, signature)
}

/// The extrapolated central difference, exact to `h⁶`; nothing where it leaves the mode.
fn difference(bench: &Bench, given: (&State, &Input), direction: &Direction, h: f64, next: &State) -> Option<Vec<f64>> {
    let signature = bench.signature();
    let central = |h: f64| {
        let [(ahead, one), (behind, other)] = [h, -h].map(|h| end_at(bench, given, direction, h, next));
        let slope = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<_>>();
        (one == signature && other == signature).then_some(slope)
    };
    let [coarse, middle, fine] = [central(h)?, central(h / 2.0)?, central(h / 4.0)?];
    let better = |fine: &[f64], coarse: &[f64], order: f64| -> Vec<f64> {
        fine.iter().zip(coarse).map(|(f, c)| f + (f - c) / (order - 1.0)).collect()
    };
    let (first, second) = (better(&middle, &coarse, 4.0), better(&fine, &middle, 4.0));
    Some(better(&second, &first, 16.0))
}

/// Runs a model and compares all its columns at a few disturbed states.
pub fn compare(name: &str, model: Model, sizes: [f64; 3], steps: u32, least: usize) {
    compare_under(Settings::default(), name, model, sizes, steps, least);
}

/// The same of steps with other settings.
pub fn compare_under(settings: Settings, name: &str, model: Model, sizes: [f64; 3], steps: u32, least: usize) {
    let directions = ScalarParameter::all(&model).into_iter().map(|parameter| vec![(parameter, 1.0)]);
    let directions: Vec<Direction> = directions.collect();
    let mut bench = Bench::new(model, settings);
    let mut random = Random::new(7);
    let (mut state, mut input) = bench.start();
    let (mut compared, mut refused, mut left, mut worst) = (0, 0, 0, 0.0_f64);
    for n in 0..steps {
        if n % 12 == 3 {
            let (near, with) = disturbed(&bench, &mut random, &state, &input, sizes);
            for direction in &directions {
                bench.derivatives = StepDerivatives::with_parameters(&bench.model, vec![direction.clone()]);
                bench.workspace.clear_warm_start();
                let Some(next) = bench.differentiate(&near, &with) else { continue };
                if !bench.is_exact() {
                    continue;
                }
                let Ok(column) = bench.derivatives.parameter_matrix() else {
                    refused += 1;
                    continue;
                };
                let column = column.data();
                let unit = unit_of(&bench.model, direction[0].0);
                let size = column.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
                // So much of their velocities is left by steps that are solved as they should be, and about seven times that by the extrapolation.
                let speed = next.v.iter().fold(0.0, |s: f64, v| s.max(v.abs()));
                let left_by_steps = 7.0 * EXACT * speed / (LARGEST * unit);
                let mut best = f64::INFINITY;
                for h in [LARGEST, 0.05, 1e-2, 1e-3, 1e-4, 1e-5] {
                    let h = h * unit;
                    let Some(found) = difference(&bench, (&near, &with), direction, h, &next) else { continue };
                    let off = found.iter().zip(column).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
                    // A change of the whole number that moves velocities by less than 1e-5 is lost in the rounding of differences.
                    best = best.min((off - left_by_steps).max(0.0) / size.max(1e-5 / unit));
                    if best < 1e-9 {
                        break;
                    }
                }
                if best == f64::INFINITY {
                    left += 1;
                    continue;
                }
                assert!(best < TOLERANCE, "{name}, step {n}, {direction:?}: {best:.1e} of {size:.1e}");
                (compared, worst) = (compared + 1, worst.max(best));
            }
            input.control.iter_mut().for_each(|u| *u += 0.2 * random.normal());
        }
        let Some(next) = bench.differentiate(&state, &input) else { break };
        state = next;
    }
    println!("{name}: {compared} columns, {refused} without, {left} near the border of their mode, worst {worst:.1e}");
    assert!(compared >= least, "{name}: only {compared} columns were compared");
}

#[test]
fn shapes_that_tumble_slide_and_rebound() {
    let mut world = ModelBuilder::new("shapes");
    world.floor().timestep(0.004);
    let shapes = [
        Geometry::Sphere { radius: 0.08 },
        Geometry::Capsule { radius: 0.05, half_length: 0.09 },
        Geometry::Box { half_extents: DVec3::new(0.07, 0.05, 0.09) },
        Geometry::Sphere { radius: 0.05 },
        Geometry::Capsule { radius: 0.04, half_length: 0.1 },
    ];
    for (i, geometry) in shapes.into_iter().enumerate() {
        let x = 0.07 * i as f64;
        let mut shape = Geom::from(geometry).with_friction(1.1 + 0.1 * i as f64).with_placement([0.01, -0.008, 0.012]);
        if i % 2 == 0 {
            shape = shape.with_restitution(0.3 + 0.1 * i as f64);
        }
        let body = world.body(format!("part{i}")).at([x, 0.5 * x, 0.1 + 0.1 * i as f64]).free();
        body.solid(shape, 0.5 + 0.3 * i as f64).add().expect("a body");
    }
    compare("shapes", world.build().expect("a model"), [1e-4, 1.0, 0.0], 100, 300);
}

const SPINNING: &str = "<mujoco><option timestep='0.005'/><worldbody><geom type='plane' condim='6' friction='0.3 0.01 0.004'/>
  <body pos='0 0 0.1'><freejoint/><geom size='0.1' mass='2' condim='6' friction='0.5 0.02 0.01'/></body>
  <body pos='0.5 0 0.2'><joint name='swing' type='hinge' axis='0 1 0' damping='0.1' stiffness='3' frictionloss='0.2' springref='20'/>
    <geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.4' contype='0' conaffinity='0'/>
    <body pos='0.2 0 0'><joint name='turn' type='ball' armature='0.001'/><geom type='box' size='0.05 0.03 0.02' pos='0.03 0 0.02' mass='0.3'/></body></body>
  </worldbody><actuator><general joint='swing' dyntype='filter' dynprm='0.05' gainprm='3' biastype='affine' biasprm='0.1 -2 -0.3'/>
  <position joint='swing' kp='4' kv='0.2'/></actuator></mujoco>";

#[test]
fn springs_activations_and_friction_that_turns() {
    compare("spinning", model_of(SPINNING), [1e-3, 1.0, 0.2], 60, 150);
}

#[test]
fn a_quadruped_on_its_feet() {
    let scene = signorini_scenes::named("quadruped").expect("a scene");
    compare("quadruped", model_of(scene.text), [1e-4, 0.05, 0.1], 40, 100);
}

#[test]
fn loops_welds_and_coupled_joints() {
    compare("four-bar", model_of(include_str!("../../testdata/four_bar.xml")), [1e-5, 0.02, 0.1], 40, 60);
}

#[test]
fn tendons_around_geoms_and_muscles() {
    compare("tendons", model_of(include_str!("../../testdata/tendons.xml")), [1e-4, 0.3, 0.1], 40, 60);
}

const SMOOTH: &str = "<mujoco><worldbody><geom name='f' type='plane' condim='6' friction='0 0 0'/>
  <body pos='0 0 0.1'><freejoint/><geom size='0.1' mass='1' condim='6' friction='0 0 0'/></body>
  <body pos='3 0 1'><joint name='slide' type='slide' axis='1 0 0'/><geom size='0.1' mass='1'/></body></worldbody>
  </mujoco>";

/// The change of the first velocity that a number of 0 makes when it grows is lost where its law has no row.
#[test]
fn a_friction_of_zero_is_a_border() {
    let model = model_of(SMOOTH);
    let (floor, ball) = (GeomId(0), GeomId(1));
    let both = |of: fn(GeomId) -> ScalarParameter| vec![(of(floor), 1.0), (of(ball), 1.0)];
    let slide = JointId(1);
    let numbers = [
        (both(ScalarParameter::Friction), [1.0, 0.0, 0.0], "a friction of 0"),
        (both(ScalarParameter::SpinningFriction), [0.0, 0.0, 1.0], "a friction against spinning of 0"),
        (both(ScalarParameter::RollingFriction), [0.0, 1.0, 0.0], "a friction against rolling of 0"),
        (vec![(ScalarParameter::FrictionLoss(slide), 1.0)], [0.0; 3], "a dry friction of 0"),
    ];
    for (direction, turning, expected) in numbers {
        let mut bench = Bench::new(model.clone(), Settings::default());
        let (mut state, input) = bench.start();
        (state.v[0], state.v[6]) = (turning[0], 1.0);
        (state.v[4], state.v[5]) = (turning[1], turning[2]);
        bench.derivatives = StepDerivatives::with_parameters(&model, vec![direction.clone()]);
        let next = bench.differentiate(&state, &input).expect("a step");
        let reason = bench.derivatives.parameter_matrix().expect_err("it has one side alone");
        assert!(reason.contains(expected), "{reason}");
        let ahead = end_at(&bench, (&state, &input), &direction, 1e-3, &next).0;
        let off = ahead[model.nv..].iter().zip(&next.v).fold(0.0, |off: f64, (a, b)| off.max((a - b).abs()));
        assert!(off > 1e-7, "{expected} does nothing when it grows: {off}");
    }
    // Where the ball flies, its friction does nothing, and that is exact.
    let mut bench = Bench::new(model.clone(), Settings::default());
    let (mut state, input) = bench.start();
    (state.q[2], state.v[0]) = (1.0, 1.0);
    bench.derivatives = StepDerivatives::with_parameters(&model, vec![both(ScalarParameter::Friction)]);
    bench.differentiate(&state, &input).expect("a step");
    let column = bench.derivatives.parameter_matrix().expect("a derivative");
    assert!(column.data().iter().all(|x| *x == 0.0));
}
