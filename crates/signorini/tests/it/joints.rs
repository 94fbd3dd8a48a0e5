//! Joint limits and actuators.

use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{
    Actuator, ActuatorKind, BodyId, Geometry, Inertia, Joint, JointId, JointKind, Pose, Tendon, Transmission,
};
use signorini::{Settings, Simulation, Workspace};

use crate::support::{G, World, run_certified, run_observed};

/// A body of 1 kg on one joint; the world is empty but for it.
fn on_joint(gravity: DVec3, joint: Joint, center_of_mass: DVec3) -> World {
    let mut world = World::new(0.002, gravity, 0.5);
    let inertia = Inertia { mass: 1.0, center_of_mass, rotational: DMat3::from_diagonal(DVec3::splat(0.01)) };
    let body = world.builder.add_body("body", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    world.builder.add_joint(body, joint).unwrap();
    world
}

fn down() -> DVec3 {
    DVec3::new(0.0, 0.0, -G)
}

/// Falls until it is on a limit, is never beyond it, and stays.
fn falls_onto(mut simulation: Simulation, limit: f64, sign: f64) {
    run_observed(&mut simulation, 2.0, |now, _| {
        let beyond = sign * (now.state().q[0] - limit);
        assert!(beyond < 1e-12, "t = {} s: {beyond:e} beyond", now.state().time);
    });
    assert!((simulation.state().q[0] - limit).abs() < 1e-12);
    assert!(simulation.state().v[0].abs() < 1e-12);
}

#[test]
fn pendulum_falls_onto_its_limit() {
    let mut hinge = Joint::new("hinge", JointKind::Hinge { axis: DVec3::Y });
    hinge.limits = Some([-0.4, 1.1]);
    falls_onto(on_joint(down(), hinge.clone(), DVec3::X * 0.5).simulation(Settings::default()), 1.1, 1.0);
    falls_onto(on_joint(down(), hinge, DVec3::X * -0.5).simulation(Settings::default()), -0.4, -1.0);
}

#[test]
fn slide_falls_onto_its_limit() {
    let mut slide = Joint::new("slide", JointKind::Slide { axis: DVec3::Z });
    slide.limits = Some([-0.3, 0.2]);
    falls_onto(on_joint(down(), slide, DVec3::ZERO).simulation(Settings::default()), -0.3, -1.0);
}

/// At 50 m/s the limit is not in the problem until the velocity says so.
#[test]
fn fast_slide_does_not_pass_its_limit() {
    let mut slide = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    slide.limits = Some([-1.0, 0.05]);
    let mut simulation = on_joint(DVec3::ZERO, slide, DVec3::ZERO).simulation(Settings::default());
    let mut state = simulation.state().clone();
    state.v[0] = 50.0;
    simulation.set_state(&state).unwrap();
    simulation.step().unwrap();
    assert!((simulation.state().q[0] - 0.05).abs() < 1e-12);
}

/// A limited slide that a free ball strikes: the limit enters because of the impact, behind that of a tendon. What the step
/// leaves for the next one can be stored all the same.
#[test]
fn struck_slide_does_not_pass_its_limit() {
    let mut world = World::new(0.005, DVec3::ZERO, 0.5);
    let paddle = world.body(Geometry::Box { half_extents: DVec3::new(0.01, 0.1, 0.1) }, 0.2, Pose::IDENTITY);
    let mut slide = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    slide.limits = Some([-0.1, 0.1]);
    world.builder.add_joint(paddle, slide).unwrap();
    world.free_ball(0.05, 5.0, DVec3::X * -0.1);
    let far = world.body(Geometry::Sphere { radius: 0.1 }, 1.0, Pose::from_position(DVec3::Y * 9.0));
    let other = world.builder.add_joint(far, Joint::new("other", JointKind::Slide { axis: DVec3::X })).unwrap();
    world.builder.add_tendon(Tendon::new("tendon", vec![(other, 1.0)]).with_limits([0.0, 1.0]));
    let mut simulation = world.simulation(Settings::default());
    let mut state = simulation.state().clone();
    state.v[1] = 100.0;
    simulation.set_state(&state).unwrap();
    let mut stored = Workspace::new(simulation.model(), &Settings::default()).unwrap();
    run_observed(&mut simulation, 0.05, |now, _| {
        assert!(now.state().q[0] < 0.1 + 1e-12);
        stored.set_warm_start(&now.workspace().warm_start()).unwrap();
    });
    assert!((simulation.state().q[0] - 0.1).abs() < 1e-12);
}

/// At rest the servo's force `kp (u − q)` carries the weight.
#[test]
fn position_servo_reaches_its_target() {
    let (kp, kv, target) = (400.0, 40.0, 0.2);
    let slide = Joint::new("slide", JointKind::Slide { axis: DVec3::Z });
    let mut world = on_joint(down(), slide, DVec3::ZERO);
    let kind = ActuatorKind::Position { kp, kv };
    let servo = Actuator::new("servo", Transmission::Joint(JointId(0)), kind);
    world.builder.add_actuator(servo);
    let mut simulation = world.simulation(Settings::default());
    simulation.input.control = vec![target];
    run_certified(&mut simulation, 4.0);
    assert!((simulation.state().q[0] - (target - G / kp)).abs() < 1e-9);
    assert!(simulation.state().v[0].abs() < 1e-9);
}

/// A weight on a slide hangs on a tendon over a second slide: `q₁ + 2 q₂ ≥ −0.1` stops both.
#[test]
fn tendon_limits_hold() {
    let slide = || Joint::new("first", JointKind::Slide { axis: DVec3::Z });
    let mut world = on_joint(down(), slide(), DVec3::ZERO);
    let inertia =
        Inertia { mass: 0.5, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(0.01)) };
    let second = world.builder.add_body("second", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    let joint = slide().with_name("second");
    let second = world.builder.add_joint(second, joint).unwrap();
    let terms = vec![(JointId(0), 1.0), (second, 2.0)];
    world.builder.add_tendon(Tendon::new("rope", terms).with_limits([-0.1, 0.2]));
    let mut simulation = world.simulation(Settings::default());
    let length = |now: &Simulation| now.state().q[0] + 2.0 * now.state().q[1];
    run_observed(&mut simulation, 0.5, |now, _| assert!(length(now) > -0.1 - 1e-12));
    assert!((length(&simulation) + 0.1).abs() < 1e-12);
    // What the rope gives both is in the ratio of its coefficients: m a + m g = c λ with a₁ + 2 a₂ = 0.
    let before = simulation.state().v.clone();
    simulation.step().unwrap();
    let force: Vec<f64> = (0..2).map(|k| [1.0, 0.5][k] * ((simulation.state().v[k] - before[k]) / 0.002 + G)).collect();
    assert!((force[1] - 2.0 * force[0]).abs() < 1e-9 && force[0] > 0.0, "{force:?}");
}

/// However fast a limit is come back to, and whatever part of that a jam permits, the distance to it is that of the coordinate.
#[test]
fn the_distance_to_a_crossed_limit_is_that_of_its_coordinate() {
    let mut slide = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    slide.limits = Some([-1.0, 0.0]);
    for wall in [false, true] {
        let mut world = on_joint(DVec3::ZERO, slide.clone(), DVec3::ZERO);
        if wall {
            // The only body after the world.
            let body = BodyId(1);
            let ball = signorini::multibody::Geom::new("ball", Geometry::Sphere { radius: 0.1 });
            world.builder.add_geom(body, ball).unwrap();
            world.fixed(Geometry::Box { half_extents: DVec3::splat(0.1) }, Pose::from_position(DVec3::X * -0.179));
        }
        let mut simulation = world.simulation(Settings::default());
        let mut state = simulation.state().clone();
        state.q[0] = 0.02;
        simulation.set_state(&state).unwrap();
        let theta = simulation.step().unwrap().theta;
        assert_eq!(theta == 0.0, wall);
        let workspace = simulation.workspace();
        let limit = workspace.problem().contact_count() - 1;
        assert!(workspace.problem().gap[limit] > -0.01, "{:?}", workspace.problem().gap);
        assert_eq!(workspace.limit_distance(limit), Some(-0.02));
        assert_eq!(workspace.limit_axis(limit), None);
    }
}
