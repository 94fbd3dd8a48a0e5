//! Muscles beside numbers of MuJoCo 3.3 and 4.0.0 (`mju_muscleGain`, `mju_muscleBias`, `mju_muscleDynamics`), and slopes beside differences.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorKind, FreeMotion, Geometry, Input, Joint, JointId, JointKind,
    ModelBuilder, Muscle, State, advance_activations_into, free_motion_into,
};

use crate::identities::kinematics;

fn muscle() -> Muscle {
    Muscle::new(300.0, [0.3, 0.6])
        .with_range([0.7, 1.1])
        .with_shortest(0.45)
        .with_longest(1.5)
        .with_fastest(3.0)
        .with_passive(1.1)
        .with_lengthening(1.3)
}

/// Length, rate and activation, and the force: every part of each curve.
const FORCES: [([f64; 3], f64); 18] = [
    ([0.075, -2.7, 0.66], 0.0),
    ([0.165, -1.35, 0.91], -1.415087603305779),
    ([0.285, -0.45, 0.8], -53.72191735537188),
    ([0.375, 0.225, 0.3], -77.2314049586777),
    ([0.473, 0.562, 0.37], -138.8101979022977),
    ([0.578, 0.787, 0.89], -346.41685120000005),
    ([0.675, -2.025, 0.1], -105.80400000000017),
    ([0.75, 0.112, 0.84], -319.00212005925937),
    ([0.84, -0.9, 0.82], -393.9342720000004),
    ([0.975, 0.45, 0.52], -627.0000000000005),
    ([0.473, -2.7, 0.66], 0.0),
    ([0.675, -3.1, 0.5], -105.60000000000018),
    ([0.35, -0.1, 0.4], -70.12906166037476),
    ([0.45, 0.02, 0.9], -256.5649954086317),
    ([0.52, 0.3, 0.2], -72.42315682073259),
    ([0.62, -2.0, 1.0], -45.58564609053498),
    ([0.7, 0.9, 0.5], -253.80000000000004),
    ([0.2, 0.0, 0.7], -18.898071625344347),
];

#[test]
fn muscles_pull_as_mujocos_do() {
    for ([length, rate, activation], force) in FORCES {
        let [found, by_length, by_rate, by_activation] = muscle().force_with_slopes(activation, length, rate);
        assert!((found - force).abs() < 1e-10, "{length} {rate}: {found} instead of {force}");
        let at = |a, l, v| muscle().force_with_slopes(a, l, v)[0];
        let slope = |f: &dyn Fn(f64) -> f64| (f(1e-6) - f(-1e-6)) / 2e-6;
        let slopes = [
            (by_length, slope(&|h| at(activation, length + h, rate))),
            (by_rate, slope(&|h| at(activation, length, rate + h))),
            (by_activation, slope(&|h| at(activation + h, length, rate))),
        ];
        for (found, expected) in slopes {
            assert!((found - expected).abs() < 1e-5, "{length} {rate}: slope {found} instead of {expected}");
        }
    }
}

/// A muscle without other numbers has the curves that MuJoCo's documentation names.
#[test]
fn a_muscle_has_the_curves_of_the_documentation() {
    let muscle = Muscle::new(10.0, [1.0, 2.0]);
    // At its resting length, and half way to where it has no force; the actuator's length 1 is 0.75 of the resting one, 2 is 1.05.
    let length = |of_resting: f64| 1.0 + (of_resting - 0.75) / 0.3;
    let force = |of_resting: f64, activation: f64| muscle.force_with_slopes(activation, length(of_resting), 0.0)[0];
    for (of_resting, expected) in [(1.0, -10.0), (0.75, -5.0), (0.5, 0.0), (0.4, 0.0)] {
        assert!((force(of_resting, 1.0) - expected).abs() < 1e-12, "{of_resting}: {}", force(of_resting, 1.0));
    }
    // The passive force is 1.3 of the peak at the longest, 1.6.
    assert!((force(1.3, 0.0) + 0.5 * 13.0).abs() < 1e-12 && (force(1.6, 0.0) + 1.5 * 13.0).abs() < 1e-12);
}

/// Activation, control and smoothing, and MuJoCo's rate of activation for time constants of 0.01 and 0.04 s.
const RATES: [([f64; 3], f64); 10] = [
    ([0.2, 0.9, 0.0], 87.49999999999999),
    ([0.7, 0.1, 0.0], -23.249999999999996),
    ([0.5, 0.53, 0.2], 1.7558437451971523),
    ([0.5, 0.44, 0.2], -1.9435993386579316),
    ([0.3, 0.6, 0.2], 31.578947368421048),
    ([0.8, 0.3, 0.2], -21.25),
    ([1.3, 0.4, 0.0], -45.0),
    ([-0.2, 0.7, 0.1], 179.99999999999983),
    ([0.4, 1.7, 0.5], 54.54545454545453),
    ([0.4, -0.6, 0.9], -11.012097194105552),
];

#[test]
fn activations_of_muscles_move_as_mujocos_do() {
    for ([activation, control, smoothing], rate) in RATES {
        let mut builder = ModelBuilder::new("arm");
        let joint = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
        builder.body("mass").joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
        let kind = ActivationKind::Muscle { times: [0.01, 0.04], smoothing };
        let actuator = Actuator::new("muscle", JointId(0), ActuatorKind::Muscle(muscle()));
        builder.add_actuator(actuator.with_activation(Activation::new(kind).with_range(None)));
        let model = builder.build().unwrap();
        let state = State::new(&model).with_activation(vec![activation]);
        let mut out = vec![f64::NAN];
        let dt = 0.003;
        advance_activations_into(&model, &state, &Input::default().with_control(vec![control]), dt, &mut out);
        let expected = activation + dt * rate;
        assert!((out[0] - expected).abs() < 1e-13, "{activation} {control}: {} instead of {expected}", out[0]);
    }
}

/// In a step the force of a muscle on a mass is linear about its beginning, by differences: at the velocity of the end and the length there
/// where these slow the mass, and at the beginning where they would drive it.
#[test]
fn a_step_of_a_muscle_is_linearly_implicit_where_that_slows() {
    let mut builder = ModelBuilder::new("pulled");
    builder.gravity(DVec3::ZERO);
    let joint = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    builder.body("mass").joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 2.0).add().unwrap();
    builder.add_actuator(Actuator::new("muscle", JointId(0), ActuatorKind::Muscle(muscle())));
    let model = builder.build().unwrap();
    let (dt, mut signs) = (0.01, [[0; 2]; 2]);
    for ([length, rate, activation], _) in FORCES {
        let force = |l: f64, v: f64| muscle().force_with_slopes(activation, l, v)[0];
        let by_length = (force(length + 1e-6, rate) - force(length - 1e-6, rate)) / 2e-6;
        let by_rate = (force(length, rate + 1e-6) - force(length, rate - 1e-6)) / 2e-6;
        [by_length, by_rate].into_iter().zip(&mut signs).for_each(|(slope, seen)| seen[usize::from(slope < -1.0)] += 1);
        let state = State::at(vec![length], vec![rate]);
        let input = Input::default().with_control(vec![activation]);
        let mut motion = FreeMotion::new(&model);
        free_motion_into(&model, &kinematics(&model, &state), &state, &input, dt, &mut motion).unwrap();
        let end = motion.free_velocity[0];
        let taken = force(length, rate) + by_rate.min(0.0) * (end - rate) + by_length.min(0.0) * dt * end;
        let needed = 2.0 * (end - rate) / dt;
        assert!((needed - taken).abs() < 1e-6 * (1.0 + taken.abs()), "{length} {rate}: {needed} instead of {taken}");
    }
    assert!(signs.as_flattened().iter().all(|&count| count > 2), "{signs:?}");
}
