//! Laws that few scenes have, each with all its numbers: limits of every joint, couplings by every power, servos of speed, shapes with margins that meet within
//! the step, pairs with laws of their own, and corrections by a part.

use crate::common::{Bench, model_of, random_vector};
use crate::differences::{compare_under, polished};
use crate::parameters;
use signorini_derivatives::{Direction, ScalarParameter, StepDerivatives};
use signorini_multibody::integrate_into;
use signorini_simulation::{FrictionSource, Settings};
use signorini_testkit::Random;

/// A ball joint, hinges, slides and tendons with and without a path, all pulled against their limits on either side.
const LIMITS: &str = "<mujoco><option timestep='0.004'/>
  <default><geom contype='0' conaffinity='0'/><site size='0.005'/><joint damping='0.02'/></default>
  <worldbody><site name='hook' pos='0.1 0.02 1.2'/>
  <body pos='0 0 1'><joint name='ball' type='ball' range='0 30' limited='true'/><geom type='box' size='0.2 0.03 0.05' pos='0.2 0.01 0.02' mass='1'/>
    <body pos='0.4 0 0'><joint name='hinge' axis='0.2 1 0' range='-25 20' limited='true'/><geom type='box' size='0.1 0.04 0.03' pos='0.1 0 0.01' mass='0.4'/>
      <body pos='0.2 0 0'><joint name='wrist' type='ball' range='0 20' limited='true'/><geom type='box' size='0.05 0.04 0.03' pos='0.04 0.02 -0.01' mass='0.2'/></body></body></body>
  <body pos='1 0 1'><joint name='lift' type='slide' axis='0 0.3 1' range='-0.02 0.03' limited='true'/><geom size='0.05' mass='0.5'/>
    <body pos='0.1 0 0'><joint name='flap' axis='1 0 0' range='-20 25' limited='true'/><geom type='capsule' size='0.02 0.1' pos='0 0.08 0.01' mass='0.3'/></body></body>
  <body pos='2 0 1'><joint name='one' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/><site name='a' pos='0.15 0 0.02'/></body>
  <body pos='2 1 1'><joint name='two' axis='0 1 0.1'/><geom type='capsule' fromto='0 0 0 -0.2 0 0' size='0.02' mass='0.3'/><site name='b' pos='-0.15 0.01 0'/></body>
  <body pos='3 0 1'><joint name='three' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/><site name='c' pos='0.15 0 0.02'/></body>
  <site name='over' pos='2.05 0 1.3'/><site name='under' pos='3.02 0.03 0.9'/>
  </worldbody>
  <tendon><fixed name='sum' range='-0.1 0.15' limited='true'><joint joint='one' coef='0.6'/><joint joint='two' coef='-0.5'/></fixed>
    <spatial name='rope' range='0.1 0.31' limited='true'><site site='over'/><site site='a'/></spatial>
    <spatial name='strut' range='0.17 0.6' limited='true'><site site='under'/><site site='c'/></spatial></tendon>
  <actuator><motor joint='lift' gear='10'/><motor joint='flap' gear='2'/><motor joint='hinge' gear='2'/><motor joint='two' gear='1'/></actuator></mujoco>";

#[test]
fn limits_on_either_side_of_every_joint() {
    compare_under(polished(), "limits", model_of(LIMITS), 0..8, [1e-3, 0.3, 0.5], 60);
}

#[test]
fn numbers_of_bodies_at_their_limits() {
    parameters::compare_under(Settings::default(), "limits", model_of(LIMITS), [1e-3, 0.3, 0.5], 40, 100);
}

/// Joints and tendons that follow others by polynomials of the fourth degree without a coefficient that is zero, and one that follows nothing.
const COUPLINGS: &str = "<mujoco><option timestep='0.004'/>
  <default><geom contype='0' conaffinity='0'/><site size='0.005'/></default>
  <worldbody><site name='high' pos='0 0.1 1.5'/><site name='far' pos='2 0.2 1.4'/>
  <body pos='0 0 1'><joint name='a' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='0.5'/><site name='a' pos='0.2 0 0.02'/>
    <body pos='0.3 0 0'><joint name='b' axis='0 1 0.2'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body></body>
  <body pos='1 0 1'><joint name='c' axis='0 1 0' ref='10'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body>
  <body pos='2 0 1'><joint name='d' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='0.4'/><site name='d' pos='0.2 0 0.02'/></body>
  <body pos='3 0 1'><joint name='e' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='0.4'/></body>
  <body pos='4 0 1'><joint name='f' type='slide' axis='0 0 1'/><geom size='0.05' mass='0.4'/></body>
  </worldbody>
  <tendon><spatial name='leader'><site site='high'/><site site='a'/></spatial><spatial name='follower'><site site='far'/><site site='d'/></spatial>
    <fixed name='turn'><joint joint='e' coef='0.7'/></fixed></tendon>
  <equality><joint joint1='b' joint2='a' polycoef='0 0.8 0.5 -0.7 0.9'/><joint joint1='c' joint2='a' polycoef='0 -0.4 0.3 0.6 -0.5'/><joint joint1='f' polycoef='0 0 0 0 0'/>
    <tendon tendon1='follower' tendon2='leader' polycoef='0 0.7 1.1 -2.1 3.3'/><tendon tendon1='turn' tendon2='leader' polycoef='0 0.5 -0.9 1.3 2.7'/></equality>
  <actuator><motor joint='a' gear='2'/></actuator></mujoco>";

#[test]
fn couplings_by_every_power() {
    compare_under(polished(), "couplings", model_of(COUPLINGS), 0..6, [1e-6, 0.5, 0.5], 60);
}

/// Servos that hold a speed with the force they have, on joints, on tendons with and without a path and on a ball joint, with and without a range of their control.
const SPEEDS: &str = "<mujoco><option timestep='0.004'/>
  <custom><numeric name='signorini:speed:wheel' data='1'/><numeric name='signorini:speed:both' data='1'/><numeric name='signorini:speed:lift' data='1'/>
    <numeric name='signorini:speed:rope' data='1'/><numeric name='signorini:speed:turn' data='1'/></custom>
  <default><geom contype='0' conaffinity='0'/></default>
  <worldbody>
  <body pos='0 0 1'><joint name='wheel' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='0.5'/>
    <body pos='0.3 0 0'><joint name='free' axis='0 1 0.2' frictionloss='0.05'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body></body>
  <body pos='1 0 1'><joint name='one' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body>
  <body pos='2 0 1'><joint name='two' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body>
  <body pos='3 0 1'><joint name='lift' type='slide' axis='0 0.2 1'/><geom size='0.05' mass='0.5'/></body>
  <body pos='4 0 1'><joint name='arm' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='0.4'/><site name='arm' pos='0.2 0.03 0.02'/></body>
  <site name='post' pos='4 0.1 1.3'/>
  <body pos='5 0 1'><joint name='turn' type='ball'/><geom type='box' size='0.1 0.03 0.05' pos='0.1 0.02 0' mass='0.4'/></body>
  </worldbody>
  <tendon><spatial name='rope'><site site='post'/><site site='arm'/></spatial><fixed name='both'><joint joint='one' coef='1.5'/><joint joint='two' coef='-0.7'/></fixed></tendon>
  <actuator><velocity name='wheel' joint='wheel' kv='1' gear='1.4' ctrlrange='-0.4 0.5' ctrllimited='true' forcerange='-1 1.5'/>
    <velocity name='both' tendon='both' kv='1' forcerange='-0.3 0.2'/><velocity name='lift' joint='lift' kv='1' forcerange='4 6'/>
    <velocity name='rope' tendon='rope' kv='1' gear='1.2' forcerange='-3 4'/><velocity name='turn' joint='turn' kv='1' gear='0.4 0.8 -0.3' forcerange='-0.2 0.3'/></actuator></mujoco>";

#[test]
fn servos_that_hold_a_speed() {
    compare_under(polished(), "speeds", model_of(SPEEDS), 0..6, [1e-2, 0.3, 0.3], 60);
    let mut bench = Bench::new(model_of(SPEEDS), Settings::default());
    let (state, mut input) = bench.start();
    input.control = vec![0.1, 0.2, -0.1, 0.1, 0.2];
    bench.differentiate(&state, &input).expect("a step");
    let servos = (0..6).filter(|&j| matches!(bench.workspace.friction_source(j), Some(FrictionSource::Servo { .. })));
    assert_eq!(servos.count(), 5);
}

#[test]
fn numbers_of_bodies_that_servos_of_speed_hold() {
    parameters::compare_under(Settings::default(), "speeds", model_of(SPEEDS), [1e-2, 0.3, 0.3], 40, 60);
}

/// Shapes that meet from some way off within a long step, on the floor and on each other, with margins, rebounds, spinning and rolling friction, and pairs
/// with laws of their own.
const MEETING: &str = "<mujoco><option timestep='0.012'/>
  <default><geom margin='0.004' friction='0.4'/></default>
  <worldbody><geom name='floor' type='plane' margin='0.003'/>
  <body pos='0 0 0.13'><freejoint/><geom name='ball' size='0.1' mass='0.7' pos='0.01 0.005 0'/></body>
  <body pos='0.03 0.02 0.36'><freejoint/><geom name='upper' size='0.09' mass='0.4' margin='0.01' pos='0 -0.01 0.01'/></body>
  <body pos='0.5 0 0.12'><freejoint/><geom name='rod' type='capsule' size='0.06 0.12' mass='0.8' euler='80 10 0'/></body>
  <body pos='0.52 0.02 0.27'><freejoint/><geom name='cross' type='capsule' size='0.05 0.12' mass='0.5' euler='85 0 70' friction='0.7'/></body>
  <body pos='1 0 0.12'><freejoint/><geom name='box' type='box' size='0.12 0.1 0.08' mass='0.9'/></body>
  <body pos='1.02 0.01 0.28'><freejoint/><geom name='on' size='0.06' mass='0.3' condim='6' friction='0.5 0.01 0.004'/></body>
  <body pos='1.5 0 0.18'><freejoint/><geom name='brick' type='box' size='0.07 0.1 0.08' mass='0.9' euler='20 30 10'/></body>
  <body pos='1.52 0.01 0.38'><freejoint/><geom name='stick' type='capsule' size='0.04 0.08' mass='0.3' euler='70 20 0'/></body>
  </worldbody>
  <contact><pair geom1='floor' geom2='box' friction='0.3 0.3' condim='3' margin='0.006'/><pair geom1='cross' geom2='rod' friction='0.9 0.9' condim='3'/></contact></mujoco>";

/// The same, of which some rebound.
fn meeting(rebounds: bool) -> signorini_multibody::Model {
    let mut model = model_of(MEETING);
    if rebounds {
        (0..).zip(&mut model.geoms).skip(1).for_each(|(k, geom)| geom.restitution = 0.2 + 0.07 * f64::from(k));
    }
    model
}

#[test]
fn shapes_that_meet_within_a_long_step() {
    for rebounds in [false, true] {
        compare_under(polished(), "meeting", meeting(rebounds), 0..8, [2e-3, 0.5, 0.0], 60);
    }
}

#[test]
fn numbers_of_shapes_that_meet_within_a_long_step() {
    for rebounds in [false, true] {
        parameters::compare_under(Settings::default(), "meeting", meeting(rebounds), [2e-3, 0.5, 0.0], 30, 100);
    }
}

/// A part of what is violated, at any speed; and gaps that count as closed.
#[test]
fn corrections_by_a_part_and_gaps_that_count_as_closed() {
    let part = polished()
        .with_stabilization(0.3)
        .with_correction_speed(f64::INFINITY)
        .with_correction_angular_speed(f64::INFINITY);
    let fast = polished().with_correction_speed(4.0).with_correction_angular_speed(9.0);
    let coarse = polished().with_gap_resolution(1e-3);
    for settings in [part, fast, coarse] {
        compare_under(settings.clone(), "meeting", meeting(false), 0..4, [2e-3, 0.3, 0.0], 20);
        compare_under(settings.clone(), "limits", model_of(LIMITS), 0..3, [1e-3, 0.3, 0.5], 20);
        compare_under(settings, "couplings", model_of(COUPLINGS), 0..3, [1e-4, 0.5, 0.5], 20);
    }
}

/// The gradient of a function of the end of the step by numbers of the model is its product with their columns.
#[test]
fn gradients_by_parameters_are_products_with_their_columns() {
    for text in [MEETING, LIMITS, SPEEDS] {
        let model = model_of(text);
        let directions: Vec<Direction> = ScalarParameter::all(&model).into_iter().map(|p| vec![(p, 0.7)]).collect();
        let (nv, nu) = (model.nv, model.actuators.len());
        let mut random = Random::new(3);
        let mut checked = 0;
        for direction in directions {
            let mut bench = Bench::new(model.clone(), Settings::default());
            bench.derivatives = StepDerivatives::with_parameters(&model, vec![direction.clone()]);
            let (mut state, input) = bench.start();
            state.v.copy_from_slice(&random_vector(&mut random, nv, 0.3));
            bench.differentiate(&state, &input).expect("a step");
            let Ok(column) = bench.derivatives.parameter_matrix() else { continue };
            let gradient = random_vector(&mut random, 2 * nv, 1.0);
            let Some(back) = bench.derivatives.transposed_product(&gradient) else { continue };
            let expected: f64 = column.data().iter().zip(&gradient).map(|(x, y)| x * y).sum();
            let size: f64 = column.data().iter().zip(&gradient).map(|(x, y)| (x * y).abs()).sum();
            let found = back[3 * nv + nu];
            // A column of zeros is so to rounding of what it is the difference of.
            assert!((found - expected).abs() <= 1e-9 * size + 1e-12, "{direction:?}: {found}, not {expected}");
            checked += usize::from(size > 1e-6);
        }
        assert!(checked > 20, "{checked}");
    }
}

/// A box on a floor that carries a weight which is fixed at one point above it: more contact points than it needs, and rows of a constraint beside them. The
/// velocity has a derivative, and its impulses lie well inside.
#[test]
fn a_box_that_carries_a_weight_stands_with_impulses_inside_their_cones() {
    const CARRYING: &str = "<mujoco><option timestep='0.004'/><worldbody><geom type='plane' friction='0.6'/>
      <body name='box' pos='0 0 0.1'><freejoint/><geom type='box' size='0.1 0.1 0.1' mass='1' friction='0.6'/></body>
      <body name='weight' pos='0.01 0.02 0.3'><freejoint/><geom size='0.05' mass='0.7' contype='0' conaffinity='0'/></body></worldbody>
      <equality><connect body1='box' body2='weight' anchor='0.01 0.02 0.2'/></equality></mujoco>";
    let mut bench = Bench::new(model_of(CARRYING), polished());
    let (mut state, mut input) = bench.start();
    let mut random = Random::new(6);
    let nv = bench.model.nv;
    input.generalized_force[0] = 1.5;
    for n in 0..6 {
        let next = bench.differentiate(&state, &input).expect("a step");
        assert!(bench.is_exact(), "{:?}", bench.derivatives.validity());
        let lightest = bench.derivatives.margins().iter().map(|m| m.value).fold(f64::INFINITY, f64::min);
        assert!(lightest > 1e-4, "impulses lie {lightest:.1e} from the border");
        let mut change = vec![0.0; nv];
        change.extend(random_vector(&mut random, nv, 1e-4));
        change.extend(random_vector(&mut random, nv, 1e-3));
        let signature = bench.signature();
        let product = bench.derivatives.product(&change).expect("a derivative");
        let (found, _) = bench.central((&state, &input), &change, 1e-3, (&next, &signature));
        let off = found.iter().zip(&product).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
        assert!(off < 1e-9, "step {n}: {off:.1e}");
        state = next;
    }
}

/// Two arms of a body that floats and turns hold each other at a point, or hand in hand, and are a millimetre apart: what carries both turns what they lack.
#[test]
fn loops_that_are_open_have_the_derivatives_of_differences() {
    let arms = |equality: &str| {
        format!(
            "<mujoco><option timestep='0.01' gravity='0 0 0'/><worldbody><body name='base'><freejoint/>
             <geom type='box' size='.1 .08 .05' mass='2' contype='0' conaffinity='0'/>
             <body name='a' pos='.1 0 0'><joint axis='0 0 1'/><joint axis='0 1 0.3'/><geom type='capsule' fromto='0 0 0 .2 .1 0' size='.02' mass='.4'
               contype='0' conaffinity='0'/><body name='c' pos='.2 .1 0'><joint type='ball'/><geom size='.03' pos='.02 0 .01' mass='.3'
               contype='0' conaffinity='0'/></body></body>
             <body name='b' pos='-.1 0 0'><joint axis='0 1 1'/><joint axis='1 0 0'/><geom type='capsule' fromto='0 0 0 .2 .2 0' size='.02' mass='.5'
               contype='0' conaffinity='0'/></body></body></worldbody><equality>{equality}</equality></mujoco>"
        )
    };
    for equality in ["<connect body1='c' body2='b' anchor='.02 .03 .01'/>", "<weld body1='b' body2='c'/>"] {
        let mut bench = Bench::new(model_of(&arms(equality)), polished());
        let mut random = Random::new(71);
        let nv = bench.model.nv;
        for n in 0..6 {
            let (mut state, mut input) = bench.start();
            let closed = state.q.clone();
            integrate_into(&bench.model, &closed, &random_vector(&mut random, nv, 1e-3), 1.0, &mut state.q);
            state.v.copy_from_slice(&random_vector(&mut random, nv, 1.0));
            input.generalized_force.copy_from_slice(&random_vector(&mut random, nv, 0.5));
            let next = bench.differentiate(&state, &input).expect("a step");
            assert!(bench.is_exact(), "{:?}", bench.derivatives.validity());
            let change = bench.random_change(&mut random);
            let off = bench.error_along(&state, &input, &change, &next).expect("the same modes");
            assert!(off < 1e-7, "{equality}, {n}: {off:.1e}");
        }
    }
}
