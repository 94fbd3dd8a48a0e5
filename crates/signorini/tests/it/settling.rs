//! States that are brought to rest.

use std::ops::ControlFlow;

use signorini::contact::ContactMode;
use signorini::lcp::MethodKind;
use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{Actuator, ActuatorKind, BodyId, Geometry, Inertia, Joint, JointKind, Pose, Transmission};
use signorini::{ContactMethod, FrictionLaw, Settings, SettleSettings, Simulation, SimulationError};

use crate::support::{G, Random, World, bits, body_poses, largest_move, position, run_certified, set_velocity};

/// Half-size of the bin, m.
const BIN: f64 = 0.3;

/// Boxes of all shapes, turned at random, in layers above the floor of a bin.
fn heap(count: usize, seed: u64) -> Simulation {
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    for normal in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
        world.plane(-BIN * normal, normal);
    }
    let mut random = Random(seed);
    for k in 0..count {
        let half = DVec3::new(random.between(0.04, 0.08), random.between(0.04, 0.08), random.between(0.04, 0.08));
        let (column, row, layer) = (k % 2, k / 2 % 2, k / 4);
        let at = DVec3::new(0.3 * column as f64 - 0.15, 0.3 * row as f64 - 0.15, 0.15 + 0.26 * layer as f64);
        let axis = DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let pose = Pose::new(at, DQuat::from_axis_angle(axis.normalize(), random.between(-1.0, 1.0)));
        world.free(Geometry::Box { half_extents: half }, 8000.0 * half.x * half.y * half.z, pose);
    }
    world.simulation(Settings::default())
}

/// A box on a slope of 20° under tilted gravity.
fn on_a_slope(friction: f64) -> Simulation {
    let slope = 20.0_f64.to_radians();
    let mut world = World::new(0.005, G * DVec3::new(slope.sin(), 0.0, -slope.cos()), friction);
    world.floor();
    world.free_box(DVec3::new(0.1, 0.1, 0.05), 4.0, DVec3::new(0.0, 0.0, 0.05));
    world.simulation(Settings::default())
}

/// The forces of the last step on the world, N.
fn load_on_world(simulation: &Simulation) -> DVec3 {
    let (workspace, dt) = (simulation.workspace(), simulation.timestep());
    let points = workspace.contact_points().iter().zip(workspace.contact_frames()).enumerate();
    let of_world = points.filter(|(_, (point, _))| point.body_a == BodyId::WORLD || point.body_b == BodyId::WORLD);
    let forces = of_world.map(|(k, (point, frame))| {
        // The force acts on body B.
        let sign = if point.body_b == BodyId::WORLD { 1.0 } else { -1.0 };
        sign / dt * frame.to_world(workspace.contact_impulse(k))
    });
    forces.sum()
}

#[test]
fn a_heap_comes_to_rest_and_stays_to_the_bit() {
    for seed in 1..4 {
        let mut simulation = heap(32, seed);
        let weight: f64 = G * simulation.model().bodies.iter().map(|body| body.inertia.mass).sum::<f64>();
        let start = body_poses(&simulation);
        let report = simulation.settle(&SettleSettings::default()).unwrap();
        assert!(report.steps > 10 && report.at_rest.certificate.holds(1e-9), "{report:?}");
        assert!(largest_move(&start, &body_poses(&simulation)) > 0.1, "nothing fell");
        assert!(simulation.state().v.iter().all(|v| *v == 0.0) && simulation.state().time == 0.0);
        assert_eq!(simulation.summary().steps, 0);
        let rest = bits(simulation.state());
        run_certified(&mut simulation, 0.5);
        assert_eq!(bits(simulation.state()), rest, "seed {seed}");
        // What carries the boxes is what the laws of statics ask for, and nothing overlaps.
        let load = load_on_world(&simulation);
        assert!((load + weight * DVec3::Z).length() < 1e-9 * weight, "{load} under {weight} N");
        assert!(simulation.summary().deepest_penetration < 1e-13);
        let inside =
            body_poses(&simulation)[1..].iter().all(|pose| pose.position.x.abs().max(pose.position.y.abs()) < BIN);
        assert!(inside && simulation.workspace().solution().modes.contains(&ContactMode::Sticking));
    }
}

/// Where a state rests, the impulses that hold it are found anew, and it stays as it is: always where bodies stand on each other, and in most
/// heaps. In most others, where a cold solution leaves some last digits of velocity, it comes to rest again where it was; one heap in some fifteen is wedged so
/// that its laws have another solution, in which it moves on.
#[test]
fn a_state_at_rest_stays_as_it_is() {
    let mut stack = World::upright(0.005, 0.5);
    stack.floor();
    for level in 0..10 {
        stack.free_box(DVec3::splat(0.5), 1.0, DVec3::new(0.0, 0.0, 0.5 + f64::from(level)));
    }
    for resting in [stack.simulation(Settings::default()), on_a_slope(0.5)] {
        let (mut simulation, steps) = settled_anew(&resting);
        assert_eq!(steps, 0);
        assert_eq!(bits(simulation.state()), bits(resting.state()));
        run_certified(&mut simulation, 0.2);
        assert_eq!(bits(simulation.state()), bits(resting.state()));
    }
    let (mut kept, mut wedged) = (0, 0);
    for seed in 0..24 {
        let mut settled = heap(24, seed);
        settled.settle(&SettleSettings::default()).unwrap();
        let (mut simulation, steps) = settled_anew(&settled);
        let pairs = simulation.state().q.iter().zip(&settled.state().q);
        let moved = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("seed {seed}: {steps} steps, {moved:e}");
        // Without a settling step there may be ordinary ones, which take up last digits of velocity: what the certificate allows of a step's weight.
        let (settings, dt) = (Settings::default(), simulation.model().timestep);
        assert!(steps > 0 || moved < settings.tolerance * 9.81 * dt * dt, "seed {seed}");
        if steps == 0 && moved == 0.0 {
            assert_eq!(bits(simulation.state()), bits(settled.state()), "seed {seed}");
            run_certified(&mut simulation, 0.2);
            assert_eq!(bits(simulation.state()), bits(settled.state()), "seed {seed}");
            kept += 1;
        }
        wedged += u32::from(moved > 1e-6);
    }
    assert!(kept >= 16 && wedged <= 3, "{kept} of 24 heaps stayed, {wedged} went elsewhere");
}

/// A new simulation that is settled from another one's state, and the steps that this took.
fn settled_anew(resting: &Simulation) -> (Simulation, u32) {
    let mut simulation = Simulation::new(resting.model().clone(), Settings::default()).unwrap();
    simulation.set_state(resting.state()).unwrap();
    let report = simulation.settle(&SettleSettings::default()).unwrap();
    (simulation, report.steps)
}

/// Where the steps of a run are Lemke's, whose velocities at rest are rounding, a heap comes to the same rest as with the structured solver.
#[test]
fn rest_is_the_same_with_another_method() {
    let lemke = Settings::default().with_method(ContactMethod::Lcp("lemke".parse::<MethodKind>().unwrap()));
    let mut structured = heap(8, 2);
    let by_lemke = || Simulation::new(structured.model().clone(), lemke.clone()).unwrap();
    let [mut settled, mut moved_there] = [by_lemke(), by_lemke()];
    let expected = structured.settle(&SettleSettings::default()).unwrap();
    let report = settled.settle(&SettleSettings::default()).unwrap();
    assert_eq!((report.steps, bits(settled.state())), (expected.steps, bits(structured.state())));
    // The steps from there are Lemke's again.
    moved_there.set_state(settled.state()).unwrap();
    for simulation in [&mut settled, &mut moved_there] {
        assert!(simulation.step().unwrap().certificate.holds(1e-9));
    }
    assert_eq!(bits(settled.state()), bits(moved_there.state()));
    assert_eq!(settled.workspace().solution().report.stages, Default::default());
}

#[test]
fn a_moving_box_stops() {
    let mut simulation = on_a_slope(0.5);
    set_velocity(&mut simulation, 0, DVec3::X, DVec3::ZERO);
    let start = position(&simulation, 0);
    let report = simulation.settle(&SettleSettings::default()).unwrap();
    assert!(report.steps > 0 && report.at_rest.certificate.holds(1e-9));
    assert!(position(&simulation, 0).x - start.x > 0.005);
    assert!(simulation.state().v.iter().all(|v| *v == 0.0));
}

#[test]
fn what_slides_for_ever_is_not_settled() {
    let mut simulation = on_a_slope(0.3);
    let start = position(&simulation, 0);
    let error = simulation.settle(&SettleSettings::default().with_max_steps(60)).unwrap_err();
    let SimulationError::NotSettled { steps: 60, kinetic_energy, body, speed } = error else { panic!("{error}") };
    // With half of the velocity taken away after every step it slides at `a Δt` in the end.
    let slope = 20.0_f64.to_radians();
    let expected = 0.5 * G * (slope.sin() - 0.3 * slope.cos()) * 4.0 * simulation.timestep() / 0.5;
    assert_eq!(body, "part2");
    assert!((speed / expected - 1.0).abs() < 1e-2, "{speed}, expected {expected}");
    assert!((kinetic_energy / (0.5 * 4.0 * speed * speed) - 1.0).abs() < 1e-2);
    assert!(position(&simulation, 0).x > start.x + 0.02 && simulation.state().v[0] == speed);
    assert!(simulation.step().unwrap().certificate.holds(1e-9));
}

/// An arm of two links on servos that are too weak to hold it straight: it sags until their torques are those of statics, also where
/// they let go by `e^(−t/1 s)` only, for which 2000 steps of the usual length are not enough.
#[test]
fn an_arm_on_servos_rests_where_they_carry_it() {
    for kv in [1.0, 60.0] {
        let steps = settle_arm(kv);
        assert!(steps < 1000, "{kv}: {steps}");
    }
}

fn settle_arm(kv: f64) -> u32 {
    let (kp, mass, length) = (30.0, 2.0, 0.3);
    let mut world = World::upright(0.005, 0.5);
    let mut parent = BodyId::WORLD;
    for k in 0..2 {
        let inertia = Inertia { mass, center_of_mass: length * DVec3::X, rotational: DMat3::IDENTITY * 0.01 };
        let at = Pose::new(f64::from(k) * length * DVec3::X, DQuat::IDENTITY);
        parent = world.builder.add_body(format!("link{k}"), parent, at, inertia).unwrap();
        let hinge = Joint::new(format!("hinge{k}"), JointKind::Hinge { axis: DVec3::NEG_Y });
        let joint = world.builder.add_joint(parent, hinge).unwrap();
        world.builder.add_actuator(Actuator::new(
            format!("servo{k}"),
            Transmission::Joint(joint),
            ActuatorKind::Position { kp, kv },
        ));
    }
    let mut simulation = world.simulation(Settings::default());
    let report = simulation.settle(&SettleSettings::default()).unwrap();
    let [shoulder, elbow] = [simulation.state().q[0], simulation.state().q[1]];
    let outer = mass * G * length * (shoulder + elbow).cos();
    let inner = mass * G * length * shoulder.cos();
    assert!(shoulder < -0.3 && report.steps > 0);
    assert!((kp * shoulder + 2.0 * inner + outer).abs() < 1e-10, "{shoulder} {elbow}");
    assert!((kp * elbow + outer).abs() < 1e-10, "{shoulder} {elbow}");
    assert!(report.speed < 1e-12 * G * simulation.timestep(), "{:e}", report.speed);
    assert!(simulation.state().v.iter().all(|v| v.abs() <= report.speed));
    report.steps
}

/// Who watches is told of every step, and may end it: the state is then the one reached, from which it can be gone on.
#[test]
fn settling_can_be_watched_and_ended() {
    let (mut whole, mut parts) = (heap(8, 1), heap(8, 1));
    let report = whole.settle(&SettleSettings::default()).unwrap();
    let mut told = Vec::new();
    let error = parts.settle_while(&SettleSettings::default(), |progress| {
        told.push(*progress);
        if progress.steps < 20 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    let Err(SimulationError::NotSettled { steps: 20, speed, .. }) = error else { panic!("{error:?}") };
    let steps: Vec<u32> = told.iter().map(|progress| progress.steps).filter(|steps| *steps > 0).collect();
    assert_eq!(steps, (1..=20).collect::<Vec<_>>());
    assert!(report.steps > 20 && told[19].speed > 0.0 && told[19].factorizations < report.factorizations);
    assert_eq!(parts.state().v.iter().fold(0.0, |most: f64, v| most.max(v.abs())), speed);
    parts.settle(&SettleSettings::default()).unwrap();
    assert!(parts.state().v.iter().all(|v| *v == 0.0));
}

#[test]
fn what_the_steps_do_not_have_is_refused() {
    let mut world = World::upright(0.005, 0.5);
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::X, rotational: DMat3::from_diagonal(DVec3::splat(0.1)) };
    let arm = world.builder.add_body("arm", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    let mut hinge = Joint::new("hinge", JointKind::Hinge { axis: DVec3::Y });
    hinge.friction_loss = 0.3;
    world.builder.add_joint(arm, hinge).unwrap();
    let mut simulation = world.simulation(Settings::default());
    let error = simulation.settle(&SettleSettings::default()).unwrap_err();
    assert!(matches!(error, SimulationError::Problem(_)) && error.to_string().contains("friction groups"), "{error}");
    let circular = Settings::default().with_friction_law(FrictionLaw::Circular);
    let mut simulation = Simulation::new(on_a_slope(0.5).model().clone(), circular).unwrap();
    let error = simulation.settle(&SettleSettings::default()).unwrap_err();
    assert!(matches!(error, SimulationError::Incompatible { .. }), "{error}");
    for (settings, setting) in [
        (SettleSettings::default().with_momentum(1.0), "settle.momentum"),
        (SettleSettings::default().with_timestep(0.0), "settle.timestep"),
    ] {
        let error = on_a_slope(0.5).settle(&settings).unwrap_err();
        assert!(error.to_string().contains(setting), "{error}");
    }
}
