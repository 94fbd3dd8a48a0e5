//! Equality constraints: closed loops, redundant rows, contradictions, drift.

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{BodyId, EqualityKind, Inertia, Joint, JointKind, ModelBuilder, Pose};
use signorini::{InfeasiblePolicy, RunEnd, Settings, Simulation, SimulationError};

use crate::support::{G, World, run_certified};

/// A slender rod of 1 kg per metre from its frame's origin along x.
fn rod(length: f64) -> Inertia {
    let (mass, thin) = (length, 1e-4);
    let across = mass * length * length / 12.0;
    let rotational = DMat3::from_diagonal(DVec3::new(thin, across + thin, across + thin));
    Inertia { mass, center_of_mass: DVec3::X * (length / 2.0), rotational }
}

fn builder() -> ModelBuilder {
    let mut builder = ModelBuilder::new("mechanism");
    builder.timestep(1e-3);
    builder
}

fn hinge(name: &str, axis: DVec3) -> Joint {
    Joint::new(name, JointKind::Hinge { axis })
}

/// Turns x to the direction of `v` by the shortest rotation.
fn along(v: DVec3) -> DQuat {
    DQuat::from_rotation_arc(DVec3::X, v.normalize())
}

/// Crank, coupler and rocker that turn about `axis`, closed to the world by a ball joint: one row more than the plane needs, and
/// in axes that are not those of the world.
fn four_bar(tilt: DQuat) -> Simulation {
    four_bar_of(tilt, [DVec3::Y; 3], Settings::default().with_position_iterations(3))
}

fn four_bar_of(tilt: DQuat, axes: [DVec3; 3], settings: Settings) -> Simulation {
    let mut b = builder();
    let points = [DVec3::ZERO, DVec3::new(0.0, 0.0, 0.4), DVec3::new(1.0, 0.0, 0.9), DVec3::new(1.2, 0.0, 0.0)];
    let (mut parent, mut pose) = (BodyId::WORLD, Pose::IDENTITY);
    for k in 0..3 {
        let link = points[k + 1] - points[k];
        let world = Pose::new(tilt * points[k], tilt * along(link));
        let body = b.add_body(format!("link{k}"), parent, pose.inverse() * world, rod(link.length())).unwrap();
        let axis = world.rotation.conjugate() * (tilt * axes[k].normalize());
        b.add_joint(body, hinge(&format!("hinge{k}"), axis)).unwrap();
        (parent, pose) = (body, world);
    }
    let length = (points[3] - points[2]).length();
    let end = EqualityKind::Connect {
        body_a: BodyId::WORLD,
        point_a: tilt * points[3],
        body_b: parent,
        point_b: DVec3::X * length,
    };
    b.add_equality("loop", end);
    Simulation::new(b.build().unwrap(), settings).unwrap()
}

/// Hinges that are parallel to the digits of a file move as parallel ones do, with impulses of the usual size and no step limited.
#[test]
fn hinges_that_are_parallel_to_seven_digits_do_not_lock() {
    let run = |off: f64| {
        let axes = [[1.0, 0.0], [0.0, -1.0], [-0.5, 1.0]].map(|[x, z]| DVec3::new(off * x, 1.0, off * z));
        let mut simulation =
            four_bar_of(DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9)), axes, Settings::default());
        let end = simulation.run(1.0, |now, report| {
            let largest = now.workspace().solution().bilateral.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            assert!(report.theta == 1.0 && report.solves == 1 && largest < 1.0, "{largest} N s, {report:?}");
            report.certificate.holds(1e-9)
        });
        assert_eq!(end.unwrap(), RunEnd::Finished, "{off}: {:?}", simulation.report());
        simulation.state().q.clone()
    };
    let parallel = run(0.0);
    for off in [1e-9, 1e-8, 1e-7] {
        assert!(parallel.iter().zip(run(off)).all(|(a, b)| (a - b).abs() < 100.0 * off), "{off}: {parallel:?}");
    }
}

/// A loop that begins open by a millimetre closes, though the hinges that are parallel to the digits of a file say less and less different things on the
/// way.
#[test]
fn an_open_loop_closes() {
    for off in [0.0, 1e-8, 1e-7] {
        let axes = [[1.0, 0.0], [0.0, -1.0], [-0.5, 1.0]].map(|[x, z]| DVec3::new(off * x, 1.0, off * z));
        for seed in 0..8 {
            let turn = DVec3::new(0.3, -0.2, 0.9) * f64::from(seed);
            let mut simulation = four_bar_of(DQuat::from_scaled_axis(turn), axes, Settings::default());
            let mut state = simulation.state().clone();
            state.q.iter_mut().zip(1..).for_each(|(q, k)| *q += 1e-3 * f64::from(k * (seed + 3)).sin());
            simulation.set_state(&state).unwrap();
            let end = simulation.run(0.2, |_, report| report.certificate.holds(1e-9));
            assert_eq!(end.unwrap(), RunEnd::Finished, "{off}, {seed}: {:?}", simulation.report());
        }
    }
}

/// Base and platform of six legs, each two bodies on a universal joint and a slide, closed by a ball joint at the platform.
fn stewart_platform() -> Simulation {
    let mut b = builder();
    let platform =
        Inertia { mass: 5.0, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(0.2)) };
    let top = b.add_body("platform", BodyId::WORLD, Pose::from_position(DVec3::Z), platform).unwrap();
    b.add_joint(top, Joint::new("platform", JointKind::Free)).unwrap();
    let ring = |radius: f64, angle: f64| DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0);
    for k in 0..6 {
        let third = (k / 2) as f64 * std::f64::consts::TAU / 3.0;
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let (foot, head) = (ring(1.0, third + side * 0.2), ring(0.5, third + side * 0.8));
        let leg = DVec3::Z + head - foot;
        let lower = b.add_body(format!("lower{k}"), BodyId::WORLD, Pose::new(foot, along(leg)), rod(0.6)).unwrap();
        b.add_joint(lower, hinge(&format!("first{k}"), DVec3::Y)).unwrap();
        b.add_joint(lower, hinge(&format!("second{k}"), DVec3::Z)).unwrap();
        let upper = b.add_body(format!("upper{k}"), lower, Pose::IDENTITY, rod(0.6)).unwrap();
        let mut slide = Joint::new(format!("slide{k}"), JointKind::Slide { axis: DVec3::X });
        (slide.stiffness, slide.damping) = (300.0, 1.0);
        b.add_joint(upper, slide).unwrap();
        let point_b = DVec3::X * leg.length();
        let kind = EqualityKind::Connect { body_a: top, point_a: head, body_b: upper, point_b };
        b.add_equality(format!("leg{k}"), kind);
    }
    Simulation::new(b.build().unwrap(), Settings::default().with_position_iterations(3)).unwrap()
}

/// Three arms, each with two parallel rods that end at the platform: with ball joints at both ends of six rods.
fn delta_robot() -> Simulation {
    let mut b = builder();
    let inertia =
        Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(0.01)) };
    let top = b.add_body("platform", BodyId::WORLD, Pose::from_position(DVec3::Z * -0.8), inertia).unwrap();
    b.add_joint(top, Joint::new("platform", JointKind::Free)).unwrap();
    for k in 0..3 {
        let turn = DQuat::from_rotation_z(k as f64 * std::f64::consts::TAU / 3.0);
        let shoulder = Pose::new(turn * DVec3::new(0.2, 0.0, 0.0), turn);
        let arm = b.add_body(format!("arm{k}"), BodyId::WORLD, shoulder, rod(0.4)).unwrap();
        let mut joint = hinge(&format!("arm{k}"), DVec3::Y);
        (joint.stiffness, joint.damping) = (20.0, 0.05);
        b.add_joint(arm, joint).unwrap();
        for (side, y) in [("left", -0.05), ("right", 0.05)] {
            let (from, to) = (DVec3::new(0.6, y, 0.0), DVec3::new(0.1, y, -0.8));
            let local = Pose::new(DVec3::new(0.4, y, 0.0), along(to - from));
            let name = format!("{side}{k}");
            let forearm = b.add_body(&name, arm, local, rod((to - from).length())).unwrap();
            b.add_joint(forearm, Joint::new(&name, JointKind::Ball)).unwrap();
            let (point_a, point_b) = (turn * (to + DVec3::Z * 0.8), DVec3::X * (to - from).length());
            b.add_equality(&name, EqualityKind::Connect { body_a: top, point_a, body_b: forearm, point_b });
        }
    }
    Simulation::new(b.build().unwrap(), Settings::default().with_position_iterations(3)).unwrap()
}

/// Moves for 10 s at 1 ms; loops stay closed to 1e-8 m, every step is certified.
fn stays_closed(mut simulation: Simulation, name: &str) {
    run_certified(&mut simulation, 10.0);
    let summary = simulation.summary();
    println!("{name}: loop error {:e}, worst residual {:e}", summary.constraint_error, summary.worst.worst());
    assert!(summary.constraint_error < 1e-8, "{name}: {:e}", summary.constraint_error);
}

#[test]
fn four_bar_stays_closed() {
    stays_closed(four_bar(DQuat::IDENTITY), "four-bar in the plane of the axes");
    stays_closed(four_bar(DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(0.4)), "four-bar, tilted");
}

#[test]
fn stewart_platform_stays_closed() {
    stays_closed(stewart_platform(), "Stewart platform");
}

#[test]
fn delta_robot_stays_closed() {
    stays_closed(delta_robot(), "delta robot");
}

/// The energy of the four-bar: the loop does no work.
#[test]
fn a_closed_loop_conserves_energy_to_first_order() {
    let change = |dt: f64| {
        let mut simulation = four_bar(DQuat::IDENTITY);
        let settings = simulation.settings().clone().with_timestep(dt);
        simulation = Simulation::new(simulation.model().clone(), settings).unwrap();
        let (kinetic, potential) = simulation.energy();
        let before = kinetic + potential;
        run_certified(&mut simulation, 1.0);
        let (kinetic, potential) = simulation.energy();
        (kinetic + potential - before).abs()
    };
    let (coarse, fine) = (change(2e-3), change(5e-4));
    assert!(coarse < 0.2 && fine < 0.4 * coarse, "{coarse:e}, {fine:e} J");
}

/// A rod pinned to the world at its origin, which for a free body is a linear constraint.
fn pinned_drift(dt: f64, speed: f64, duration: f64) -> f64 {
    let mut b = builder();
    b.gravity(DVec3::ZERO);
    let body = b.add_body("rod", BodyId::WORLD, Pose::IDENTITY, rod(1.0)).unwrap();
    b.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let (point_a, point_b) = (DVec3::ZERO, DVec3::ZERO);
    b.add_equality("pin", EqualityKind::Connect { body_a: BodyId::WORLD, point_a, body_b: body, point_b });
    let settings = Settings::default().with_timestep(dt);
    let mut simulation = Simulation::new(b.build().unwrap(), settings).unwrap();
    let mut state = simulation.state().clone();
    state.v[5] = speed;
    // An angle at which nothing is aligned with the axes.
    state.q[3..].copy_from_slice(&[0.8, 0.36, 0.0, 0.48]);
    simulation.set_state(&state).unwrap();
    run_certified(&mut simulation, duration);
    simulation.summary().constraint_error
}

/// Without position steps the drift is of the order Δt² ‖v‖² (Anitescu & Hart 2004).
#[test]
fn drift_is_of_second_order_in_the_step_and_the_speed() {
    let slope = |a: f64, b: f64, factor: f64| (a / b).ln() / factor.ln();
    let steps = [8e-3, 4e-3, 2e-3, 1e-3].map(|dt| loop_drift(dt, 1.0, 1.0));
    for pair in steps.windows(2) {
        let order = slope(pair[0], pair[1], 2.0);
        assert!((order - 2.0).abs() < 0.15, "order {order} in the step: {steps:?}");
    }
    // Without gravity the same path, faster.
    let speeds = [0.5, 1.0, 2.0].map(|speed| loop_drift(1e-3, speed, 0.4 / speed));
    for pair in speeds.windows(2) {
        let order = slope(pair[1], pair[0], 2.0);
        assert!((order - 2.0).abs() < 0.15, "order {order} in the speed: {speeds:?}");
    }
    assert!(pinned_drift(1e-3, 1.0, 1.0) < 1e-12, "a linear constraint does not drift");
}

/// The four-bar without gravity, its crank turning at `speed`, by stabilization alone.
fn loop_drift(dt: f64, speed: f64, duration: f64) -> f64 {
    let mut model = four_bar(DQuat::IDENTITY).model().clone();
    model.gravity = DVec3::ZERO;
    let mut simulation = Simulation::new(model, Settings::default().with_timestep(dt)).unwrap();
    let mut state = simulation.state().clone();
    state.v[0] = speed;
    simulation.set_state(&state).unwrap();
    run_certified(&mut simulation, duration);
    simulation.summary().constraint_error
}

/// A box welded to the world twice, at two places: six rows follow from the other six.
#[test]
fn a_box_welded_twice_stays() {
    let mut world = World::upright(1e-3, 0.5);
    let half = DVec3::new(0.1, 0.2, 0.3);
    let body = world.free_box(half, 2.0, DVec3::new(0.3, 0.1, 1.0));
    for (name, point) in [("left", DVec3::new(0.1, 0.0, 0.0)), ("right", DVec3::new(-0.1, 0.1, 0.2))] {
        let frame_a = Pose::from_position(DVec3::new(0.3, 0.1, 1.0) + point);
        let kind =
            EqualityKind::Weld { body_a: BodyId::WORLD, frame_a, body_b: body, frame_b: Pose::from_position(point) };
        world.builder.add_equality(name, kind);
    }
    let mut simulation = world.simulation(Settings::default());
    run_certified(&mut simulation, 0.5);
    let state = simulation.state();
    assert!((state.q[2] - 1.0).abs() < 1e-12 && state.v.iter().all(|v| v.abs() < 1e-12), "{state:?}");
    let workspace = simulation.workspace();
    assert_eq!(workspace.problem().bilateral_violation.len(), 6, "those that follow are left out");
    let upward = (0..6).filter(|&k| matches!(workspace.bilateral_row(k), Some([_, 0, 2])));
    let carried: f64 = upward.map(|k| workspace.solution().bilateral[k]).sum();
    assert!((carried - 2.0 * G * 1e-3).abs() < 1e-11, "the others carry the weight: {carried}");
}

/// Two welds that ask for places 1 mm apart.
#[test]
fn contradicting_constraints_are_named() {
    let mut world = World::upright(1e-3, 0.5);
    let body = world.free_ball(0.1, 1.0, DVec3::Z);
    for (name, height) in [("low", 1.0), ("high", 1.001)] {
        let frame_a = Pose::from_position(DVec3::Z * height);
        let kind = EqualityKind::Weld { body_a: BodyId::WORLD, frame_a, body_b: body, frame_b: Pose::IDENTITY };
        world.builder.add_equality(name, kind);
    }
    let model = world.builder.build().unwrap();
    let stops = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
    let mut simulation = Simulation::new(model.clone(), stops.clone()).unwrap();
    match simulation.step() {
        Err(SimulationError::NotAssembled { violations, .. }) => {
            let [(name, size)] = &violations[..] else { panic!("{violations:?}") };
            assert!(name == "high" && (size - 1e-3).abs() < 1e-15);
        }
        other => panic!("{other:?}"),
    }
    let mut simulation = Simulation::new(model.clone(), stops.with_assembly_tolerance(0.01)).unwrap();
    match simulation.step() {
        Err(SimulationError::ContradictingEqualities { names }) => assert_eq!(names, ["low", "high"]),
        other => panic!("{other:?}"),
    }
    // Going on, the body stays between them, and what is not closed is told.
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let report = simulation.step().unwrap();
    assert!(report.certificate.holds(1e-9) && report.theta == 0.0 && !report.kept.is_empty(), "{report:?}");
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-12));
}

/// A start that is off is refused, and assembled on request by the smallest change.
#[test]
fn a_start_that_is_off_is_assembled() {
    let model = four_bar(DQuat::IDENTITY).model().clone();
    let stops = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
    let mut simulation = Simulation::new(model, stops).unwrap();
    let mut state = simulation.state().clone();
    state.q[0] += 0.1;
    simulation.set_state(&state).unwrap();
    let error = simulation.step().unwrap_err().to_string();
    assert!(error.contains("'loop' by ") && error.contains("assemble"), "{error}");
    assert!(simulation.assemble().unwrap() < 1e-12);
    let moved = simulation.state().q.iter().zip(&state.q).fold(0.0, |a: f64, (x, y)| a.max((x - y).abs()));
    assert!(moved > 0.01 && moved < 0.2, "{moved}");
    simulation.step().unwrap();
}

/// Gears and a cam: one joint follows another by a polynomial; the momentum of both shows in the leader's.
#[test]
fn coupled_joints_follow_their_polynomial() {
    let mut b = builder();
    let disc = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(0.5)) };
    let mut ids = Vec::new();
    for name in ["leader", "follower"] {
        let body = b.add_body(name, BodyId::WORLD, Pose::IDENTITY, disc).unwrap();
        ids.push(b.add_joint(body, hinge(name, DVec3::Z)).unwrap());
    }
    let coupling = |polynomial| EqualityKind::Joint { joint: ids[1], driver: Some(ids[0]), polynomial };
    let run = |polynomial: [f64; 5], b: &ModelBuilder| {
        let mut b = b.clone();
        b.add_equality("gear", coupling(polynomial));
        let settings = Settings::default().with_position_iterations(3);
        let mut simulation = Simulation::new(b.build().unwrap(), settings).unwrap();
        simulation.assemble().unwrap();
        simulation.input.generalized_force = vec![3.0, 0.0];
        run_certified(&mut simulation, 1.0);
        simulation.state().clone()
    };
    // I + 2² I = 2.5 kg·m² at 3 N·m
    let gear = run([0.0, -2.0, 0.0, 0.0, 0.0], &b);
    assert!((gear.v[0] - 1.2).abs() < 1e-12 && (gear.v[1] + 2.4).abs() < 1e-12, "{gear:?}");
    assert!((gear.q[1] + 2.0 * gear.q[0]).abs() < 1e-12);
    let cam = run([0.1, 0.5, 0.3, -0.2, 0.05], &b);
    let x = cam.q[0];
    let wanted = 0.1 + x * (0.5 + x * (0.3 + x * (-0.2 + x * 0.05)));
    assert!((cam.q[1] - wanted).abs() < 1e-12 && x > 0.5, "{cam:?}");
}

/// Everything in one problem: a four-bar with dry friction in its joints and a coupled finger strikes a box and a rolling ball on
/// a floor that resists rolling. Every step is certified, and what was moving comes to rest.
#[test]
fn loops_contacts_and_dry_friction_are_solved_together() {
    let text = "<mujoco><option timestep='0.002'/><default><joint axis='0 1 0' frictionloss='.02'/><geom friction='.6 .01 .005'/></default>
        <worldbody><geom type='plane' size='5 5 1' condim='6'/>
        <body name='crank' pos='0 0 .3'><joint name='crank'/><geom type='capsule' fromto='0 0 0 0 0 .3' size='.02' mass='.5'/>
        <body name='coupler' pos='0 0 .3'><joint/><geom type='capsule' fromto='0 0 0 .5 0 .1' size='.02' mass='.5'/></body></body>
        <body name='rocker' pos='.6 0 .3'><joint/><geom type='capsule' fromto='0 0 0 -.1 0 .4' size='.02' mass='.5'/></body>
        <body name='finger' pos='.9 0 .5'><joint name='finger'/><geom type='capsule' fromto='0 0 0 0 0 -.4' size='.02' mass='.3'/></body>
        <body name='box' pos='1.1 0 .1'><freejoint/><geom type='box' size='.1 .1 .1' mass='.4'/></body>
        <body name='ball' pos='1.4 0 .1'><freejoint/><geom size='.1' mass='.4'/></body></worldbody>
        <equality><connect body1='coupler' body2='rocker' anchor='.5 0 .1'/>
        <joint joint1='finger' joint2='crank' polycoef='0 -1.5 0 0 0'/></equality>
        <contact><exclude body1='coupler' body2='rocker'/></contact></mujoco>";
    let imported = signorini_formats::load_mjcf_str(text, "").unwrap();
    assert_eq!(imported.report.motion_warnings().count(), 0, "{}", imported.report);
    let settings = Settings::default().with_position_iterations(3);
    let mut simulation = Simulation::new(imported.model, settings).unwrap();
    let mut state = simulation.state().clone();
    (state.v[0], state.v[3]) = (2.0, -3.0);
    simulation.set_state(&state).unwrap();
    run_certified(&mut simulation, 2.5);
    assert!(simulation.summary().constraint_error < 1e-9 && simulation.summary().contacts_max >= 5);
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-9), "{:?}", simulation.state().v);
    let first_free = simulation.model().joints.iter().find(|j| j.kind == JointKind::Free).unwrap();
    let moved = simulation.state().q[first_free.q_index] - 1.1;
    assert!(moved > 0.01, "the finger pushed the box by {moved} m");
}

/// A swing of `cranks` parallel cranks of 0.5 m that carry one platform; two are enough, and each more adds rows that follow from
/// the others as long as the loops are closed, and only then.
fn parallel_swing(cranks: usize, position_iterations: u32) -> (Simulation, Vec<f64>) {
    let mut b = builder();
    let crank = |b: &mut ModelBuilder, k: usize| {
        let inertia =
            Inertia { mass: 1e-3, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(1e-4)) };
        let place = Pose::new(DVec3::X * k as f64, DQuat::from_rotation_y(1.0));
        let body = b.add_body(format!("crank{k}"), BodyId::WORLD, place, inertia).unwrap();
        b.add_joint(body, hinge(&format!("crank{k}"), DVec3::Y)).unwrap();
        body
    };
    let first = crank(&mut b, 0);
    let inertia = Inertia { mass: 2.0, center_of_mass: DVec3::X, rotational: DMat3::from_diagonal(DVec3::splat(0.3)) };
    let local = Pose::new(DVec3::X * 0.5, DQuat::from_rotation_y(-1.0));
    let platform = b.add_body("platform", first, local, inertia).unwrap();
    b.add_joint(platform, hinge("platform", DVec3::Y)).unwrap();
    for k in 1..cranks {
        let body_a = crank(&mut b, k);
        let (point_a, point_b) = (DVec3::X * 0.5, DVec3::X * k as f64);
        b.add_equality(format!("end{k}"), EqualityKind::Connect { body_a, point_a, body_b: platform, point_b });
    }
    let settings = Settings::default().with_position_iterations(position_iterations);
    let mut simulation = Simulation::new(b.build().unwrap(), settings).unwrap();
    let mut angles = Vec::new();
    for _ in 0..1000 {
        let report = simulation.step().unwrap();
        assert!(report.certificate.holds(1e-9), "{report:?}");
        angles.push(simulation.state().q[0]);
    }
    (simulation, angles)
}

/// The overconstrained swing moves as the one with two cranks does, and as the pendulum that both are.
#[test]
fn an_overconstrained_swing_swings() {
    let (_, two) = parallel_swing(2, 3);
    let (four, angles) = parallel_swing(4, 3);
    let difference = two.iter().zip(&angles).fold(0.0, |a: f64, (x, y)| a.max((x - y).abs()));
    // The cranks weigh 1 g, with 1e-4 kg·m² each: two more of them slow the swing of 2 kg at 0.5 m by 2e-4.
    assert!(difference < 2e-3, "{difference}");
    let widest = angles.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    assert!((widest - 2.0 * (std::f64::consts::FRAC_PI_2 - 1.0)).abs() < 0.01, "from one side to the other: {widest}");
    assert!(four.summary().constraint_error < 1e-8);
}
