//! Friction apart from sliding: in joints, at servos, against spinning and rolling, on belts.

use signorini::contact::ContactMode;
use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{
    Actuator, ActuatorId, ActuatorKind, BodyId, Geometry, Inertia, Joint, JointId, JointKind, Pose, Sensor, SensorKind,
    Site, SpinResistance, Tendon, Transmission,
};
use signorini::{FrictionSource, Settings, Simulation};

use crate::support::{G, World, run_certified, run_observed};

/// A body of 1 kg whose centre of mass is 0.5 m from a hinge about y, with 0.01 kg·m² about it.
fn pendulum(friction_loss: f64, gravity: f64) -> Simulation {
    let mut world = World::new(1e-3, DVec3::NEG_Z * gravity, 0.5);
    let rotational = DMat3::from_diagonal(DVec3::splat(0.01));
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::NEG_Z * 0.5, rotational };
    let body = world.builder.add_body("bob", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    let mut hinge = Joint::new("hinge", JointKind::Hinge { axis: DVec3::Y });
    hinge.friction_loss = friction_loss;
    world.builder.add_joint(body, hinge).unwrap();
    world.simulation(Settings::default())
}

fn start(simulation: &mut Simulation, q: f64, v: f64) {
    let mut state = simulation.state().clone();
    (state.q[0], state.v[0]) = (q, v);
    simulation.set_state(&state).unwrap();
}

/// Without gravity `ω² / 2 = τ θ / I`: the angle at rest is known, and in steps of Δt it is reached by
/// `θ = Δt Σ (ω − k a Δt)`, exactly; after that nothing moves.
#[test]
fn a_hinge_with_dry_friction_stops_at_the_analytic_angle_and_stays() {
    let (torque, speed, inertia, dt) = (0.3, 2.0, 0.26, 1e-3);
    let mut simulation = pendulum(torque, 0.0);
    start(&mut simulation, 0.0, speed);
    run_certified(&mut simulation, 3.0);
    let slowed = torque / inertia * dt;
    let steps = (speed / slowed).floor();
    let wanted = dt * (steps * speed - slowed * steps * (steps + 1.0) / 2.0);
    let stopped = simulation.state().q[0];
    assert!((stopped - wanted).abs() < 1e-12, "{stopped} and {wanted}");
    assert!((stopped - speed * speed * inertia / (2.0 * torque)).abs() < speed * dt, "of the continuous motion");
    assert_eq!(simulation.state().v[0], 0.0);
    run_certified(&mut simulation, 1.0);
    assert_eq!(simulation.state().q[0], stopped);
}

/// Under gravity the bob stays wherever `m g l |sin θ| ≤ τ` and else moves.
#[test]
fn a_pendulum_sticks_within_its_cone_of_friction_and_slips_outside() {
    let torque = 1.0;
    let largest = (torque / (G * 0.5)).asin();
    let mut simulation = pendulum(torque, G);
    for q in [0.0, 0.5 * largest, 0.999 * largest, -0.999 * largest] {
        start(&mut simulation, q, 0.0);
        run_certified(&mut simulation, 1.0);
        assert!((simulation.state().q[0] - q).abs() < 1e-12, "{q}: {:?}", simulation.state());
        assert_eq!(simulation.workspace().solution().group_modes, [ContactMode::Sticking]);
    }
    start(&mut simulation, 1.001 * largest, 0.0);
    run_certified(&mut simulation, 0.1);
    assert!((simulation.state().q[0] - 1.001 * largest).abs() > 1e-7);
    // A swing from 1 rad ends within the cone, at rest to the last digit.
    start(&mut simulation, 1.0, 0.0);
    run_certified(&mut simulation, 3.0);
    let stopped = simulation.state().q[0];
    assert!(stopped.abs() <= largest && simulation.state().v[0].abs() < 1e-15, "{:?}", simulation.state());
    run_certified(&mut simulation, 1.0);
    assert!((simulation.state().q[0] - stopped).abs() < 1e-12);
    assert_eq!(simulation.workspace().friction_source(0), Some(FrictionSource::Joint { joint: 0, dof: 0 }));
}

/// A motor of ±2 N·m through a gear of 3 lifts the bob (at most 4.905 N·m at the joint) at its speed, and the weight shows
/// in the impulse. A motor of ±1 N·m stalls where `3 N·m = m g l sin θ`; an uneven range is shifted.
#[test]
fn a_servo_of_speed_holds_until_its_limit() {
    let run = |force_range: [f64; 2], control: f64, duration: f64| {
        let mut world = World::upright(1e-3, 0.5);
        let rotational = DMat3::from_diagonal(DVec3::splat(0.01));
        let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::NEG_Z * 0.5, rotational };
        let body = world.builder.add_body("bob", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
        world.builder.add_joint(body, Joint::new("hinge", JointKind::Hinge { axis: DVec3::NEG_Y })).unwrap();
        world.builder.add_actuator(
            Actuator::new("servo", Transmission::Joint(JointId(0)), ActuatorKind::Speed)
                .with_gear(3.0)
                .with_force_range(force_range),
        );
        world.builder.add_sensor(Sensor::new("force", SensorKind::ActuatorForce(ActuatorId(0))));
        let mut simulation = world.simulation(Settings::default());
        simulation.input.control = vec![control];
        run_certified(&mut simulation, duration);
        simulation
    };
    let mut strong = run([-2.0, 2.0], 1.5, 3.0);
    assert!((strong.state().v[0] - 0.5).abs() < 1e-13);
    assert!((strong.state().q[0] - 1.5).abs() < 0.01);
    let holding = 3.0 * strong.workspace().solution().group_impulse[0][0] / 1e-3;
    let weight = G * 0.5 * (strong.state().q[0] - 0.5e-3).sin();
    assert!((holding - weight).abs() < 1e-9, "{holding} and {weight} N m");
    assert!((3.0 * strong.sensors()[0] - weight).abs() < 1e-9);
    let mut uneven = run([-2.0, 6.0], 1.5, 2.0);
    assert!((uneven.state().v[0] - 0.5).abs() < 1e-13);
    let weight = G * 0.5 * (uneven.state().q[0] - 0.5e-3).sin();
    assert!((3.0 * uneven.sensors()[0] - weight).abs() < 1e-9);
    let mut weak = run([-1.0, 1.0], 0.3, 20.0);
    let wanted = (3.0_f64 / (G * 0.5)).asin();
    let (q, v) = (weak.state().q[0], weak.state().v[0]);
    assert!((q - wanted).abs() < 0.2 && v.abs() < 0.2, "swings about the place where it stalls: {q}, {v}");
    weak.input.control = vec![0.0];
    run_certified(&mut weak, 5.0);
    assert!(weak.state().v[0].abs() < 1e-13, "a servo at 0 holds");
}

/// Two slides, 1 and 2 kg, on a tendon `q₁ + 2 q₂` whose servo keeps its length at a speed: from rest they move along
/// `M⁻¹ (1, 2)`. A third one is driven at a site against the world.
#[test]
fn servos_of_speed_drive_tendons_and_sites() {
    let mut world = World::new(1e-3, DVec3::ZERO, 0.5);
    let mut slide = |name: &str, mass| {
        let inertia = Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
        let body = world.builder.add_body(name, BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
        let joint = Joint::new(name, JointKind::Slide { axis: DVec3::Z });
        (body, world.builder.add_joint(body, joint).unwrap())
    };
    let [(_, first), (_, second), (body, _)] = [slide("first", 1.0), slide("second", 2.0), slide("third", 3.0)];
    let tendon = world.builder.add_tendon(Tendon::new("tendon", vec![(first, 1.0), (second, 2.0)]));
    let zone = Geometry::Sphere { radius: 0.1 };
    let site = Site::new("site").with_placement(Pose::IDENTITY).with_zone(zone);
    let site = world.builder.add_site(body, site).unwrap();
    let wrench = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
    let transmissions = [Transmission::Tendon(tendon), Transmission::Site { site, reference: None, wrench }];
    for (name, transmission) in ["tendon", "site"].into_iter().zip(transmissions) {
        world.builder.add_actuator(
            Actuator::new(name, transmission, ActuatorKind::Speed).with_gear(2.0).with_force_range([-1e4, 1e4]),
        );
    }
    let mut simulation = world.simulation(Settings::default());
    simulation.input.control = vec![0.6, 0.8];
    run_certified(&mut simulation, 0.01);
    // 2 (v₁ + 2 v₂) = 0.6 with v₁ = v₂, and 2 · 2 v₃ = 0.8.
    for (v, wanted) in simulation.state().v.iter().zip([0.1, 0.1, 0.2]) {
        assert!((v - wanted).abs() < 1e-12, "{:?}", simulation.state().v);
    }
}

fn ball_on_floor(resistance: SpinResistance, spinning: f64, rolling: f64) -> Simulation {
    let mut world = World::upright(1e-3, 0.8);
    world.floor();
    let body = world.body(Geometry::Sphere { radius: 0.1 }, 2.0, Pose::from_position(DVec3::Z * 0.1));
    world.builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let mut model = world.builder.build().unwrap();
    let geom = model.geoms.last_mut().unwrap();
    (geom.spin_resistance, geom.spinning_friction, geom.rolling_friction) = (resistance, spinning, rolling);
    Simulation::new(model, Settings::default().with_directions(16)).unwrap()
}

/// `I ω̇ = −c m g`: a ball of 0.008 kg·m² that spins at 10 rad/s stops after `I ω / (c m g)`; without resistance it spins on.
#[test]
fn a_spinning_ball_is_braked_by_its_spinning_friction() {
    let stop = |resistance| {
        let mut simulation = ball_on_floor(resistance, 0.005, 0.0);
        let mut state = simulation.state().clone();
        state.v[5] = 10.0;
        simulation.set_state(&state).unwrap();
        let mut stopped = None;
        run_observed(&mut simulation, 1.5, |now, _| {
            if stopped.is_none() && now.state().v[5].abs() < 1e-12 {
                stopped = Some(now.state().time);
            }
        });
        (stopped, simulation.state().v[5])
    };
    let wanted = 0.4 * 2.0 * 0.01 * 10.0 / (0.005 * 2.0 * G);
    let (stopped, _) = stop(SpinResistance::Spinning);
    assert!((stopped.unwrap() - wanted).abs() <= 1.5e-3, "{stopped:?} and {wanted} s");
    let (never, speed) = stop(SpinResistance::None);
    assert!(never.is_none() && (speed - 10.0).abs() < 1e-9, "{never:?}");
}

/// A ball that rolls at v: `(I + m r²) ω̇ = −c m g`, so that it stops after `v (I + m r²) / (r c m g)`, and stays.
#[test]
fn a_rolling_ball_is_braked_by_its_rolling_friction() {
    let (c, v) = (0.01, 0.7);
    let mut simulation = ball_on_floor(SpinResistance::Rolling, 0.005, c);
    let mut state = simulation.state().clone();
    (state.v[0], state.v[4]) = (v, v / 0.1);
    simulation.set_state(&state).unwrap();
    let wanted = v * (0.4 * 2.0 * 0.01 + 2.0 * 0.01) / (0.1 * c * 2.0 * G);
    run_certified(&mut simulation, wanted - 0.05);
    assert!(simulation.state().v[0] > 1e-3);
    run_certified(&mut simulation, 0.1);
    let stopped = simulation.state().clone();
    assert!(stopped.v.iter().all(|v| v.abs() < 1e-12), "{stopped:?}");
    assert!((stopped.q[0] - v * wanted / 2.0).abs() < v * 2e-3, "{stopped:?}");
    run_certified(&mut simulation, 0.5);
    assert!((simulation.state().q[0] - stopped.q[0]).abs() < 1e-12);
}

/// A box that is put on a belt is taken along with `μ g` until it has the belt's speed, and then rests on it.
#[test]
fn a_belt_takes_a_box_along() {
    let mut world = World::upright(1e-3, 0.5);
    world.fixed(Geometry::Box { half_extents: DVec3::new(5.0, 1.0, 0.5) }, Pose::from_position(DVec3::Z * -0.5));
    world.free_box(DVec3::splat(0.1), 3.0, DVec3::Z * 0.1);
    let mut model = world.builder.build().unwrap();
    model.geoms[0].surface_velocity = DVec3::new(1.0, 0.0, 0.0);
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    run_certified(&mut simulation, 0.1);
    assert!((simulation.state().v[0] - 0.5 * G * 0.1).abs() < 1e-9, "{:?}", simulation.state());
    run_certified(&mut simulation, 0.9);
    assert!((simulation.state().v[0] - 1.0).abs() < 1e-9, "{:?}", simulation.state());
    let before = simulation.state().q[0];
    run_certified(&mut simulation, 0.5);
    assert!((simulation.state().q[0] - before - 0.5).abs() < 1e-9);
}

/// The impulse that a contact shows is all that acted there: with it the momentum balances, drive of the belt included, and
/// what lifts a box out of the belt is told apart.
#[test]
fn impulses_of_a_belt_balance_the_momentum() {
    let (depth, dt) = (1e-4, 1e-3);
    let mut world = World::upright(dt, 0.5);
    world.fixed(Geometry::Box { half_extents: DVec3::new(5.0, 1.0, 0.5) }, Pose::from_position(DVec3::Z * -0.5));
    world.free_box(DVec3::splat(0.1), 3.0, DVec3::Z * (0.1 - depth));
    let mut model = world.builder.build().unwrap();
    model.geoms[0].surface_velocity = DVec3::new(1.0, 0.5, 0.0);
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.step().unwrap();
    let (workspace, v) = (simulation.workspace(), &simulation.state().v);
    let (problem, mut force) = (workspace.problem(), vec![0.0; 6]);
    for i in 0..problem.contact_count() {
        problem.jacobian.add_transposed(i, workspace.contact_impulse(i), &mut force);
    }
    let (mut gained, mut change) = (vec![0.0; 6], vec![0.0; 6]);
    change.iter_mut().zip(v).zip(&problem.free_velocity).for_each(|((d, v), f)| *d = v - f);
    problem.mass.multiply_into(&change, &mut gained);
    assert!(gained.iter().zip(&force).all(|(a, b)| (a - b).abs() < 1e-12), "{gained:?} and {force:?}");
    assert!(force[0] > 0.1 && force[1] > 0.05, "the belt drives: {force:?}");
    let part = workspace.stabilized_step().expect("it penetrates").impulses(simulation.settings()).unwrap();
    let lift: f64 = part.iter().map(|p| p[0]).sum();
    assert!((lift - 3.0 * depth / dt).abs() < 1e-9, "{lift}");
    assert!(part.iter().map(|p| p[1]).sum::<f64>() > 0.0, "a larger load is driven more");
}

/// A rod on a ball joint falls onto its cone and stays on it.
#[test]
fn a_ball_joint_stays_within_its_cone() {
    let mut world = World::upright(1e-3, 0.5);
    let rotational = DMat3::from_diagonal(DVec3::splat(0.02));
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::Z * 0.5, rotational };
    let body = world.builder.add_body("rod", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    let mut ball = Joint::new("ball", JointKind::Ball);
    (ball.limits, ball.damping) = (Some([0.0, 0.8]), 0.3);
    world.builder.add_joint(body, ball).unwrap();
    let mut simulation = world.simulation(Settings::default());
    let mut state = simulation.state().clone();
    state.v[..2].copy_from_slice(&[0.5, 0.3]);
    simulation.set_state(&state).unwrap();
    let mut widest = 0.0_f64;
    run_observed(&mut simulation, 6.0, |now, _| widest = widest.max(2.0 * now.state().q[0].min(1.0).acos()));
    // The cone is curved: the step's linearisation passes it by the order of Δt² ω².
    assert!(widest < 0.8 + 1e-4, "{widest}");
    let rest = 2.0 * simulation.state().q[0].acos();
    assert!((rest - 0.8).abs() < 1e-9, "{rest}");
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-9), "{:?}", simulation.state());
}
