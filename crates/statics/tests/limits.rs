//! Limits of statics in closed form, each between two proofs.

use signorini_contact::statics::certify_stability;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Input, Model, ModelBuilder, State};
use signorini_statics::{
    Safety, SafetyQuestion, StabilitySettings, Verdict, held_by_motors, placements, safety, stability,
};

/// A box of 0.2 m × 0.2 m on the floor, with this half height.
fn block(half_height: f64, friction: f64) -> Model {
    let mut world = ModelBuilder::new("block");
    world.floor();
    let shape = Geometry::Box { half_extents: DVec3::new(0.1, 0.1, half_height) };
    let body = world.body("block").at([0.0, 0.0, half_height]).free();
    body.solid(Geom::new("", shape).with_friction(friction), 2.0).add().expect("a block");
    world.build().expect("a model")
}

fn limit(model: &Model, question: SafetyQuestion) -> Safety {
    let settings = StabilitySettings::default();
    let found = safety(model, &State::new(model), &Input::default(), &settings, &question).expect("a limit");
    for (problem, proof) in found.at_holds.iter().chain(&found.at_falls) {
        for (name, residual) in certify_stability(problem, proof) {
            assert!(residual <= 1e-8, "{name} {residual:e}");
        }
    }
    found
}

/// The closed form lies between the two values, which are near each other.
fn assert_limit(found: &Safety, expected: f64) {
    let (low, high) = (found.holds.min(found.falls), found.holds.max(found.falls));
    // A balance is that of loads which differ by its residual, 1e-11 of the largest, at most.
    assert!(low <= expected * (1.0 + 1e-10) && expected * (1.0 - 1e-10) <= high, "{low} {expected} {high}");
    assert!(high - low <= 1e-9 * high, "{low} {expected} {high}");
}

#[test]
fn a_block_slides_or_tips() {
    let slides = block(0.1, 0.5);
    assert_limit(&limit(&slides, SafetyQuestion::Horizontal(DVec3::X)), 0.5);
    assert_limit(&limit(&slides, SafetyQuestion::Tilt(DVec3::Y)), 0.5_f64.atan());
    let tips = block(0.4, 0.5);
    assert_limit(&limit(&tips, SafetyQuestion::Horizontal(DVec3::X)), 0.25);
    assert_limit(&limit(&tips, SafetyQuestion::Tilt(-DVec3::X)), 0.25_f64.atan());
}

#[test]
fn the_least_friction_is_that_of_the_slope() {
    let mut tilted = block(0.1, 0.8);
    tilted.gravity = 9.81 * DVec3::new(0.3_f64.sin(), 0.0, -0.3_f64.cos());
    assert_limit(&limit(&tilted, SafetyQuestion::Friction), 0.3_f64.tan() / 0.8);
    let level = limit(&block(0.1, 0.8), SafetyQuestion::Friction);
    assert!(level.holds == 0.0 && level.falls.is_nan(), "no friction is needed on level ground");
}

/// A force at the centre of mass along x: μ m g; one along −z is never too much.
#[test]
fn a_load_has_a_multiplier() {
    let model = block(0.1, 0.5);
    let mut force = vec![0.0; model.nv];
    force[0] = 1.0;
    assert_limit(&limit(&model, SafetyQuestion::Load(force.clone())), 0.5 * 2.0 * 9.81);
    (force[0], force[2]) = (0.0, -1.0);
    assert_eq!(limit(&model, SafetyQuestion::Load(force)).falls, f64::INFINITY);
}

/// A weight on a box that stands out over the edge of the one below by less than half: it tips when the common centre is at the edge.
#[test]
fn a_weight_has_a_limit() {
    let mut world = ModelBuilder::new("overhang");
    world.floor();
    let cube = |mass: f64| (Geom::new("", Geometry::Box { half_extents: DVec3::splat(0.1) }).with_friction(0.6), mass);
    for (name, x, z, mass) in [("lower", 0.0, 0.1, 1.0), ("middle", 0.04, 0.3, 2.0), ("upper", 0.12, 0.5, 1.0)] {
        let (geom, mass) = cube(mass);
        world.body(name).at([x, 0.0, z]).free().solid(geom, mass).add().expect("a box");
    }
    let model = world.build().expect("a model");
    let upper = model.bodies.iter().position(|body| body.name == "upper").expect("the upper box");
    // Over the lower box: 2 · 0.04 + (1 + m) · 0.12 = (3 + m) · 0.1.
    let found = limit(&model, SafetyQuestion::Weight(signorini_multibody::BodyId(upper as u32)));
    assert_limit(&found, (0.3 - 0.08 - 0.12) / 0.02);
}

/// Two links held out at angles by motors: torques are those of the weights, and the margin is the larger share of its range.
#[test]
fn motors_hold_an_arm_by_their_torque() {
    use signorini_multibody::model::{Actuator, ActuatorKind};
    use signorini_multibody::{Inertia, Joint};
    let (length, masses, angles) = (0.5, [3.0, 2.0], [0.4_f64, -0.3]);
    let mut world = ModelBuilder::new("arm");
    let point = |mass: f64| Inertia {
        mass,
        center_of_mass: DVec3::new(length, 0.0, 0.0),
        rotational: signorini_multibody::glam::DMat3::from_diagonal(DVec3::splat(1e-3)),
    };
    let upper = world.body("upper").mass(point(masses[0])).joint(Joint::hinge("shoulder", -DVec3::Y));
    let upper = upper.add().expect("a link");
    let lower = world.body("lower").on(upper).at([length, 0.0, 0.0]).mass(point(masses[1]));
    lower.joint(Joint::hinge("elbow", -DVec3::Y)).add().expect("a link");
    // Both centres are at the ends of the links.
    let arms = [length * angles[0].cos(), length * (angles[0] + angles[1]).cos()];
    let elbow = 9.81 * masses[1] * arms[1];
    let shoulder = 9.81 * (masses[0] * arms[0] + masses[1] * arms[0]) + elbow;
    for (joint, range) in [(0, [-2.0 * shoulder, 1.6 * shoulder]), (1, [-3.0 * elbow, 1.25 * elbow])] {
        let joint = signorini_multibody::JointId(joint);
        let motor = Actuator::new(format!("motor {}", joint.0), joint, ActuatorKind::Motor);
        world.add_actuator(motor.with_force_range(range));
    }
    let model = held_by_motors(&world.build().expect("a model")).expect("motors with ranges");
    let mut state = State::new(&model);
    state.q.copy_from_slice(&angles);
    let settings = StabilitySettings::default();
    let ask = |model: &Model| stability(model, &state, &Input::default(), &settings).expect("a verdict").stability;
    assert_eq!(ask(&model).verdict(), Verdict::Stays);
    let found = safety(&model, &state, &Input::default(), &settings, &SafetyQuestion::Motors).expect("a margin");
    assert!((found.holds - 0.8).abs() < 1e-7 && (found.falls - 0.8).abs() < 1e-7, "{} {}", found.holds, found.falls);
    let mut weak = model.clone();
    weak.actuators[1].force_range = Some([-elbow, 0.99 * elbow]);
    assert_eq!(ask(&weak).verdict(), Verdict::MustMove);
    weak.actuators[1].force_range = None;
    weak.actuators[1].kind = ActuatorKind::Position { kp: 100.0, kv: 1.0 };
    let error = held_by_motors(&weak).expect_err("a servo without bounds").to_string();
    assert!(error.contains("'motor 1'"), "{error}");
}

/// Placements are judged as one by one.
#[test]
fn placements_are_judged_as_one_by_one() {
    let model = block(0.1, 0.5);
    let states: Vec<State> = (0..20)
        .map(|k| {
            let mut state = State::new(&model);
            state.q[2] += if k % 3 == 0 { 1e-3 } else { 0.0 };
            state
        })
        .collect();
    let count = std::sync::atomic::AtomicUsize::new(0);
    let (settings, question) = (StabilitySettings::default(), SafetyQuestion::Tilt(DVec3::X));
    let found = placements(&model, &states, &Input::default(), &settings, Some(&question), || {
        count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    });
    assert_eq!(count.into_inner(), 20);
    for (k, placement) in found.into_iter().enumerate() {
        let placement = placement.expect("a verdict");
        let (verdict, margin) =
            if k % 3 == 0 { (Verdict::MustMove, f64::NAN) } else { (Verdict::Stays, 0.5_f64.atan()) };
        assert_eq!(placement.verdict, verdict);
        assert!(margin.is_nan() && placement.margin.is_nan() || (placement.margin - margin).abs() < 1e-9);
    }
}

/// What motors are said to hold with is what they push with in a simulation, in the long run, under controls beyond all ranges.
#[test]
fn motors_hold_with_what_they_can_push_with() {
    use signorini_multibody::glam::DMat3;
    use signorini_multibody::model::{Activation, ActivationKind, Actuator, ActuatorKind};
    use signorini_multibody::{Inertia, Joint, JointId};
    use signorini_simulation::{Settings, Simulation};
    let cart = |actuator: &Actuator| {
        let mut world = ModelBuilder::new("cart");
        let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
        world.body("cart").mass(inertia).joint(Joint::slide("rail", DVec3::X)).add().expect("a cart");
        world.add_actuator(actuator.clone());
        world.build().expect("a model")
    };
    let of_kind = |kind: ActuatorKind| Actuator::new("motor", JointId(0), kind).with_control_range([-4.0, 7.0]);
    let motor = || of_kind(ActuatorKind::Motor);
    let filter = Activation::new(ActivationKind::ExactFilter { time_constant: 0.01 });
    let integrator = Activation::new(ActivationKind::Integrator);
    for actuator in [
        motor(),
        motor().with_force_range([-5.0, 5.0]),
        motor().with_force_range([-2.0, 20.0]),
        motor().with_force_range([-20.0, -5.0]),
        of_kind(ActuatorKind::Affine { gain: [-3.0, 0.0, 0.0], bias: [0.0; 3] }).with_force_range([-15.0, 30.0]),
        motor().with_activation(filter),
        motor().with_activation(filter.with_range([-5.0, 2.0])),
        motor().with_activation(integrator.with_range([-12.0, 9.0])),
        motor().with_activation(integrator).with_force_range([-9.0, 8.0]),
    ] {
        let model = cart(&actuator);
        let mut pushed = [-1e3, 1e3].map(|control| {
            let mut simulation = Simulation::new(model.clone(), Settings::default()).expect("a simulation");
            simulation.input.control = vec![control];
            (0..2000).for_each(|_| _ = simulation.step().expect("a step"));
            let before = simulation.state().v[0];
            simulation.step().expect("a step");
            (simulation.state().v[0] - before) / simulation.timestep()
        });
        pushed.sort_by(f64::total_cmp);
        let held = held_by_motors(&model).expect("a motor with bounds").actuators[0].force_range.expect("a range");
        let is_near = held.iter().zip(pushed).all(|(held, pushed)| (held - pushed).abs() < 1e-6);
        assert!(is_near, "{held:?} for {pushed:?} of {actuator:?}");
    }
    assert!(held_by_motors(&cart(&motor().with_activation(integrator))).is_err(), "nothing bounds what it adds up to");
}
