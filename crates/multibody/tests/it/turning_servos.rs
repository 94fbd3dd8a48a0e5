//! Servos of angles that are the same after a turn go the shorter way round: forces and activations beside those of MuJoCo 4.0.0.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorKind, BodyId, FreeMotion, Geometry, Input, Joint, JointId, JointKind,
    Kinematics, ModelBuilder, Site, SiteId, State, Transmission, advance_activations_into, forward_kinematics_into,
    free_motion_into,
};

/// Turned by 2.5 rad about z.
const ANGLE: f64 = 2.5;

/// Force of an actuator on a ball with a control and an activation, and its activation after 2 ms.
fn force(actuator: Actuator, [control, activation]: [f64; 2]) -> (f64, f64) {
    let mut builder = ModelBuilder::new("ball");
    let ball = builder.body("ball").joint(Joint::new("ball", JointKind::Ball));
    let ball = ball.solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    builder.add_site(ball, Site::new("on it")).unwrap();
    builder.add_site(BodyId::WORLD, Site::new("on the world")).unwrap();
    builder.gravity(DVec3::ZERO);
    builder.add_actuator(actuator);
    let model = builder.build().unwrap();
    let mut state = State::new(&model);
    state.q = vec![(ANGLE / 2.0).cos(), 0.0, 0.0, (ANGLE / 2.0).sin()];
    state.activation = vec![activation; model.na];
    let input = Input::default().with_control(vec![control]);
    let mut kinematics = Kinematics::new(&model);
    forward_kinematics_into(&model, &state.q, &state.v, &mut kinematics);
    let mut motion = FreeMotion::new(&model);
    free_motion_into(&model, &kinematics, &state, &input, 1e-9, &mut motion).unwrap();
    let mut after = vec![0.0; model.na];
    advance_activations_into(&model, &state, &input, 0.002, &mut after);
    (motion.actuator_force[0], after.first().copied().unwrap_or(0.0))
}

const SERVO: ActuatorKind = ActuatorKind::Position { kp: 1.0, kv: 0.0 };
const SHORT_WAY: f64 = 1.2831853071795862;

fn on_ball(axes: [f64; 3], kind: ActuatorKind) -> Actuator {
    let [x, y, z] = axes;
    Actuator::new("servo", Transmission::JointAxes { joint: JointId(0), axes: [x, y, z, 0.0, 0.0, 0.0] }, kind)
}

fn on_site(wrench: [f64; 6]) -> Actuator {
    Actuator::new("servo", Transmission::Site { site: SiteId(0), reference: Some(SiteId(1)), wrench }, SERVO)
}

#[track_caller]
fn assert_force(actuator: Actuator, control: f64, expected: f64) {
    let (found, _) = force(actuator, [control, 0.0]);
    assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
}

#[test]
fn servos_of_angles_go_the_shorter_way_round() {
    assert_force(on_ball([0.0, 0.0, 1.0], SERVO), -2.5, SHORT_WAY);
    assert_force(on_ball([0.0, 0.0, 2.0], SERVO), -5.0, 2.5663706143591725);
    assert_force(on_ball([0.0, 0.0, 1.0], SERVO).with_gear(2.0), -5.0, 2.5663706143591725);
    assert_force(on_ball([0.0, 1.0, 1.0], SERVO), -2.5, 3.885765876316732);
    let affine = ActuatorKind::Affine { gain: [1.0, 0.0, 0.0], bias: [3.0, -1.0, 0.0] };
    assert_force(on_ball([0.0, 0.0, 1.0], affine), -2.5, 3.0 + SHORT_WAY);
    assert_force(on_site([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), -2.5, SHORT_WAY);
}

#[test]
fn what_is_no_servo_of_an_angle_alone_goes_on() {
    assert_force(on_ball([0.0, 0.0, 1.0], ActuatorKind::Velocity { kv: 1.0 }), -2.5, -2.5);
    assert_force(on_site([0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), -2.5, -5.0);
}

#[test]
fn activations_of_such_servos_go_the_shorter_way_round() {
    let filter = Activation::new(ActivationKind::ExactFilter { time_constant: 1.0 });
    let servo = || on_ball([0.0, 0.0, 1.0], SERVO).with_activation(filter);
    let (found, after) = force(servo(), [-2.5, 2.5]);
    assert!(found.abs() < 1e-6 && (after - 2.50256381).abs() < 1e-7, "{found} {after}");
    let (found, _) = force(servo(), [-2.5, -2.5]);
    assert!((found - SHORT_WAY).abs() < 1e-6, "{found}");
}
