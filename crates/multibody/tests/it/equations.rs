//! Signs, references and constants of single equations, each against its closed form or a difference of what it is the slope of.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorKind, BodyId, EqualityBlock, EqualityKind, Geometry, Input, Joint,
    JointId, JointKind, LengthRow, Model, ModelBuilder, Pose, Site, State, Tendon, Transmission, actuator_length_into,
    advance_activations_into, equality_block_into, integrate_into, potential_energy,
};

use crate::identities::{entry, kinematics};
use crate::random_model::Random;

/// Two free boxes.
fn boxes(equality: EqualityKind) -> Model {
    let mut builder = ModelBuilder::new("two");
    for (name, x) in [("a", 0.0), ("b", 1.0)] {
        let shape = Geometry::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) };
        builder.body(name).at([x, 0.0, 0.0]).free().solid(shape, 1.5).add().unwrap();
    }
    builder.add_equality("held", equality);
    builder.build().unwrap()
}

fn block(model: &Model, q: &[f64], k: usize) -> EqualityBlock {
    let state = State::at(q.to_vec(), vec![0.0; model.nv]);
    let mut block = EqualityBlock::new(model);
    equality_block_into(model, &kinematics(model, &state), q, &model.equalities[0].kind, k, &mut block);
    block
}

fn rate(block: &EqualityBlock, v: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (&k, column) in block.rows.dofs.iter().zip(&block.rows.columns) {
        sum.iter_mut().zip(column).for_each(|(x, c)| *x += c * v[k]);
    }
    sum
}

fn random_q(random: &mut Random) -> Vec<f64> {
    let mut q = Vec::new();
    for x in [0.0, 1.0] {
        let (p, r) = (random.vector(0.3), random.vector(1.0));
        let r = DQuat::from_scaled_axis(r);
        q.extend([x + p.x, p.y, p.z, r.w, r.x, r.y, r.z]);
    }
    q
}

fn pose(q: &[f64]) -> Pose {
    Pose::new(DVec3::from_slice(q), DQuat::from_xyzw(q[4], q[5], q[6], q[3]))
}

#[test]
fn points_are_apart_from_a_to_b_and_move_with_their_rows() {
    let (point_a, point_b) = (DVec3::new(0.5, 0.1, -0.2), DVec3::new(-0.4, 0.0, 0.3));
    let (body_a, body_b) = (BodyId(1), BodyId(2));
    let connect = EqualityKind::Connect { body_a, point_a, body_b, point_b };
    let weld = EqualityKind::Weld {
        body_a,
        frame_a: Pose::new(point_a, DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.5))),
        body_b,
        frame_b: Pose::new(point_b, DQuat::from_scaled_axis(DVec3::new(-0.1, 0.4, 0.2))),
    };
    let mut random = Random(5);
    for kind in [connect, weld] {
        let model = boxes(kind);
        for _ in 0..20 {
            let q = random_q(&mut random);
            let found = block(&model, &q, 0);
            let expected = pose(&q[7..]).transform_point(point_b) - pose(&q).transform_point(point_a);
            assert!((DVec3::from(found.violation) - expected).length() < 1e-13);
            let v: Vec<f64> = (0..model.nv).map(|_| random.uniform(-1.0, 1.0)).collect();
            let moved = |h: f64| {
                let mut out = q.clone();
                integrate_into(&model, &q, &v, h, &mut out);
                DVec3::from(block(&model, &out, 0).violation)
            };
            let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((DVec3::from(rate(&found, &v)) - difference).length() < 1e-8);
        }
    }
}

#[test]
fn a_weld_turns_from_a_to_b_and_one_step_takes_the_turn_away() {
    let (frame_a, frame_b) = (DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.5)), DQuat::from_rotation_z(0.4));
    let model = boxes(EqualityKind::Weld {
        body_a: BodyId(1),
        frame_a: Pose::new(DVec3::ZERO, frame_a),
        body_b: BodyId(2),
        frame_b: Pose::new(DVec3::ZERO, frame_b),
    });
    let mut random = Random(6);
    for _ in 0..20 {
        let q = random_q(&mut random);
        let found = block(&model, &q, 1);
        let turn = DVec3::from(found.violation);
        let [a, b] = [pose(&q).rotation * frame_a, pose(&q[7..]).rotation * frame_b];
        assert!((DQuat::from_scaled_axis(turn) * a).dot(b).abs() > 1.0 - 1e-13);
        // Body B alone turns: its angular velocity in its own axes takes the whole turn away.
        let spin = pose(&q[7..]).rotation.conjugate() * -turn;
        let mut v = vec![0.0; model.nv];
        v[9..12].copy_from_slice(&spin.to_array());
        assert!((DVec3::from(rate(&found, &v)) + turn).length() < 1e-13);
        let mut out = q.clone();
        integrate_into(&model, &q, &v, 1.0, &mut out);
        assert!(DVec3::from(block(&model, &out, 1).violation).length() < 1e-12);
    }
}

#[test]
fn coupled_joints_count_from_their_references() {
    let mut builder = ModelBuilder::new("gears");
    for (name, reference) in [("leader", 0.3), ("follower", -0.2)] {
        let joint = Joint::new(name, JointKind::Hinge { axis: DVec3::Z }).with_reference(reference);
        builder.body(name).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    }
    let polynomial = [0.1, 2.0, -0.5, 0.25, 0.125];
    let mut alone = builder.clone();
    alone.add_equality("held", EqualityKind::Joint { joint: JointId(1), driver: None, polynomial });
    let held = block(&alone.build().unwrap(), &[0.9, 0.7], 0);
    assert!((held.violation[0] - ((0.7 + 0.2) - 0.1)).abs() < 1e-14 && rate(&held, &[1.0, 0.0]) == [0.0; 3]);
    builder.add_equality("gear", EqualityKind::Joint { joint: JointId(1), driver: Some(JointId(0)), polynomial });
    let model = builder.build().unwrap();
    let x: f64 = 0.9 - 0.3;
    let wanted = 0.1 + 2.0 * x - 0.5 * x.powi(2) + 0.25 * x.powi(3) + 0.125 * x.powi(4);
    let slope = 2.0 - x + 0.75 * x.powi(2) + 0.5 * x.powi(3);
    let found = block(&model, &[0.9, 0.7], 0);
    assert_eq!((found.count, &found.violation[1..]), (1, &[0.0; 2][..]));
    assert!((found.violation[0] - ((0.7 + 0.2) - wanted)).abs() < 1e-14);
    assert!((rate(&found, &[1.0, 0.0])[0] + slope).abs() < 1e-14 && rate(&found, &[0.0, 1.0])[0] == 1.0);
}

/// Lengths count from those at the reference configuration, here q = (0.3, −0.2).
#[test]
fn coupled_tendons_count_from_their_reference_lengths() {
    let mut builder = ModelBuilder::new("pulleys");
    for (name, reference) in [("a", 0.3), ("b", -0.2)] {
        let joint = Joint::new(name, JointKind::Slide { axis: DVec3::Z }).with_reference(reference);
        builder.body(name).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    }
    let (a, b) = (JointId(0), JointId(1));
    let driver = builder.add_tendon(Tendon::new("driver", vec![(a, 2.0), (b, 0.5)]));
    let tendon = builder.add_tendon(Tendon::new("follower", vec![(a, -1.0), (b, 3.0)]));
    let polynomial = [0.1, 2.0, -0.5, 0.25, 0.125];
    let coupled = |driver| {
        let mut builder = builder.clone();
        builder.add_equality("pulley", EqualityKind::Tendon { tendon, driver, polynomial });
        builder.build().unwrap()
    };
    let q: [f64; 2] = [0.9, 0.7];
    let (x, y) = (2.0 * (q[0] - 0.3) + 0.5 * (q[1] + 0.2), 3.0 * (q[1] + 0.2) - (q[0] - 0.3));
    let wanted = 0.1 + 2.0 * x - 0.5 * x.powi(2) + 0.25 * x.powi(3) + 0.125 * x.powi(4);
    let slope = 2.0 - x + 0.75 * x.powi(2) + 0.5 * x.powi(3);
    let found = block(&coupled(Some(driver)), &q, 0);
    assert!(found.count == 1 && (found.violation[0] - (y - wanted)).abs() < 1e-13, "{:?}", found.violation);
    assert_eq!(found.violation[1..], [0.0; 2]);
    let rates = [[1.0, 0.0], [0.0, 1.0]].map(|v| rate(&found, &v)[0]);
    assert!(
        (rates[0] - (-1.0 - 2.0 * slope)).abs() < 1e-13 && (rates[1] - (3.0 - 0.5 * slope)).abs() < 1e-13,
        "{rates:?}"
    );
    let alone = block(&coupled(None), &q, 0);
    assert!((alone.violation[0] - (y - 0.1)).abs() < 1e-13, "{:?}", alone.violation);
    assert_eq!([[1.0, 0.0], [0.0, 1.0]].map(|v| rate(&alone, &v)[0]), [-1.0, 3.0]);
    assert_eq!(rate(&found, &[1.0, 1.0])[1..], [0.0; 2]);
    // Storage that held three rows, or a row with a driver, holds the one without.
    let mut both = builder.clone();
    both.add_equality("with", EqualityKind::Tendon { tendon, driver: Some(driver), polynomial });
    both.add_equality("without", EqualityKind::Tendon { tendon, driver: None, polynomial });
    let model = both.build().unwrap();
    let kinematics = kinematics(&model, &State::at(q.to_vec(), vec![0.0; 2]));
    let mut used = EqualityBlock::new(&model);
    used.count = 3;
    for (equality, fresh) in [(0, &found), (1, &alone)] {
        equality_block_into(&model, &kinematics, &q, &model.equalities[equality].kind, 0, &mut used);
        assert_eq!((used.count, used.violation, &used.rows), (1, fresh.violation, &fresh.rows));
    }
}

#[test]
fn what_is_held_up_has_less_weight_to_fall_with() {
    let mut builder = ModelBuilder::new("balloon");
    let shape = Geometry::Sphere { radius: 0.1 };
    let body = builder.body("balloon").at([0.0, 0.0, 1.5]).free().solid(shape, 2.0).add().unwrap();
    for (share, expected) in [(0.0, 1.0), (0.3, 0.7), (1.0, 0.0), (1.5, -0.5)] {
        builder.set_gravity_compensation(body, share).unwrap();
        let model = builder.clone().build().unwrap();
        let state = State::new(&model);
        let energy = potential_energy(&model, &kinematics(&model, &state), &state.q);
        assert!((energy - expected * 2.0 * 9.81 * 1.5).abs() < 1e-12, "{share}: {energy}");
    }
}

/// A slide with one actuator.
fn driven(activation: Activation) -> Model {
    let mut builder = ModelBuilder::new("driven");
    let joint = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    builder.body("mass").joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    let actuator = Actuator::new("drive", JointId(0), ActuatorKind::Motor).with_control_range([-1.0, 2.0]);
    builder.add_actuator(actuator.with_activation(activation));
    builder.build().unwrap()
}

#[test]
fn activations_follow_their_equations_within_their_ranges() {
    let (dt, tau, a) = (0.02, 0.1, 0.4);
    // The control is cut to 2 before it counts.
    let cases = [
        (ActivationKind::Integrator, 0.4 + 0.02 * 2.0),
        (ActivationKind::Filter { time_constant: tau }, 0.4 + 0.02 * (2.0 - 0.4) / 0.1),
        (ActivationKind::ExactFilter { time_constant: tau }, 2.0 + (0.4 - 2.0) * (-0.2_f64).exp()),
    ];
    for (kind, expected) in cases {
        for (range, early) in [(None, false), (None, true), (Some([0.0, 0.43]), true), (Some([0.5, 0.9]), false)] {
            let model = driven(Activation::new(kind).with_range(range).with_early(early));
            let state = State::new(&model).with_activation(vec![a]);
            let input = Input::default().with_control(vec![5.0]);
            let mut out = vec![f64::NAN];
            advance_activations_into(&model, &state, &input, dt, &mut out);
            let after = range.map_or(expected, |[low, high]: [f64; 2]| expected.clamp(low, high));
            assert!((out[0] - after).abs() < 1e-15, "{kind:?} {range:?}: {out:?}, not {after}");
            let drive = model.actuators[0].drive(&state, &input, 0, dt);
            assert!((drive - if early { after } else { a }).abs() < 1e-15, "{kind:?} {early}: {drive}");
        }
    }
}

#[test]
fn a_wrench_at_a_site_acts_in_its_axes_or_in_those_of_its_reference() {
    let [at, turned] = [DVec3::new(0.2, -0.1, 0.3), DVec3::new(0.4, -0.3, 0.8)];
    let wrench = [0.7, -1.1, 0.4, 0.3, 0.6, -0.9];
    let mut builder = ModelBuilder::new("thruster");
    let shape = Geometry::Sphere { radius: 0.1 };
    let body = builder.body("ship").free().solid(shape, 1.0).add().unwrap();
    let site = Site::new("nozzle").with_placement(Pose::new(at, DQuat::from_scaled_axis(turned)));
    let site = builder.add_site(body, site).unwrap();
    let axes = DQuat::from_scaled_axis(DVec3::new(-0.5, 0.2, 0.1));
    let frame = Site::new("frame").with_placement(Pose::new(DVec3::new(1.0, 2.0, 3.0), axes));
    let frame = builder.add_site(BodyId::WORLD, frame).unwrap();
    for (name, reference) in [("own", None), ("against", Some(frame))] {
        let transmission = Transmission::Site { site, reference, wrench };
        builder.add_actuator(Actuator::new(name, transmission, ActuatorKind::Motor).with_gear(1.5));
    }
    let model = builder.build().unwrap();
    let rotation = DQuat::from_scaled_axis(DVec3::new(0.9, 0.1, -0.4));
    let q = vec![0.3, 0.4, 0.5, rotation.w, rotation.x, rotation.y, rotation.z];
    let state = State::at(q.clone(), vec![0.0; 6]);
    let (force, moment) = (DVec3::from_slice(&wrench), DVec3::from_slice(&wrench[3..]));
    for (a, axes) in [rotation * DQuat::from_scaled_axis(turned), axes].into_iter().enumerate() {
        let mut row = LengthRow::new(&model);
        actuator_length_into(&model, &kinematics(&model, &state), &q, &model.actuators[a], &mut row);
        let (force, moment) = (axes * force * 1.5, axes * moment * 1.5);
        // Velocities are those of the origin in world axes and the angular one in the body's.
        let about = rotation.conjugate() * (moment + (rotation * at).cross(force));
        let expected = [force.to_array(), about.to_array()].concat();
        for (k, x) in expected.iter().enumerate() {
            let found = entry(&row, k);
            assert!((found - x).abs() < 1e-13, "{a}: {:?}, not {expected:?}", row.gradient);
        }
        let length = match a {
            0 => 0.0,
            _ => {
                let place = axes.conjugate() * (DVec3::new(0.3, 0.4, 0.5) + rotation * at - DVec3::new(1.0, 2.0, 3.0));
                let turn = axes.conjugate() * rotation * DQuat::from_scaled_axis(turned);
                1.5 * (place.dot(DVec3::from_slice(&wrench))
                    + turn.to_scaled_axis().dot(DVec3::from_slice(&wrench[3..])))
            }
        };
        assert!((row.length - length).abs() < 1e-13, "{a}: {} instead of {length}", row.length);
    }
}

/// What takes the opposite wrench is the body of the reference, at its site.
#[test]
fn a_wrench_between_two_bodies_acts_on_both() {
    let wrench = [0.7, -1.1, 0.4, 0.3, 0.6, -0.9];
    let places = [DVec3::new(0.2, -0.1, 0.3), DVec3::new(-0.4, 0.5, 0.1)];
    let turns = [DVec3::new(0.4, -0.3, 0.8), DVec3::new(-0.5, 0.2, 0.1)].map(DQuat::from_scaled_axis);
    let mut builder = ModelBuilder::new("tugs");
    let mut sites = Vec::new();
    for (k, name) in ["tug", "barge"].into_iter().enumerate() {
        let body = builder.body(name).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
        let site = Site::new(name).with_placement(Pose::new(places[k], turns[k]));
        sites.push(builder.add_site(body, site).unwrap());
    }
    let transmission = Transmission::Site { site: sites[0], reference: Some(sites[1]), wrench };
    builder.add_actuator(Actuator::new("tow", transmission, ActuatorKind::Motor));
    let model = builder.build().unwrap();
    let q = random_q(&mut Random(5));
    let state = State::at(q.clone(), vec![0.0; 12]);
    let mut row = LengthRow::new(&model);
    actuator_length_into(&model, &kinematics(&model, &state), &q, &model.actuators[0], &mut row);
    let axes = pose(&q[7..]).rotation * turns[1];
    let (force, moment) = (axes * DVec3::from_slice(&wrench), axes * DVec3::from_slice(&wrench[3..]));
    for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
        let rotation = pose(&q[7 * k..]).rotation;
        let about = rotation.conjugate() * (moment + (rotation * places[k]).cross(force));
        for (i, x) in [force.to_array(), about.to_array()].concat().into_iter().enumerate() {
            let found = entry(&row, 6 * k + i);
            assert!((found - sign * x).abs() < 1e-13, "body {k}: {:?}", row.gradient);
        }
    }
}

/// Energy is what was put into the springs against their forces: half the stiffness times the square of each stretch, the slack part left out.
#[test]
fn springs_of_joints_and_tendons_hold_energy() {
    for (own, cross) in [(1.0, 1.0), (3.0, 7.0), (0.0, 5.0), (2.0, 0.0)] {
        let mut builder = ModelBuilder::new("springs");
        builder.gravity(DVec3::ZERO);
        let mut joints = Vec::new();
        for name in ["a", "b"] {
            let joint =
                Joint::new(name, JointKind::Slide { axis: DVec3::X }).with_stiffness(own).with_spring_reference(0.2);
            builder.body(name).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
            joints.push(JointId(joints.len() as u32));
        }
        let terms = vec![(joints[0], 1.0), (joints[1], -2.0)];
        builder.add_tendon(Tendon::new("cross", terms).with_stiffness(cross).with_rest([-0.1, 0.3]));
        let model = builder.build().unwrap();
        for q in [[0.7, -0.4], [-0.9, 0.1], [0.1, 0.0]] {
            let state = State::at(q.to_vec(), vec![0.0; 2]);
            let length: f64 = q[0] - 2.0 * q[1];
            let stretch = (length - 0.3).max(0.0) + (length + 0.1).min(0.0);
            let of_joints: f64 = q.iter().map(|q| 0.5 * own * (q - 0.2) * (q - 0.2)).sum();
            let expected = of_joints + 0.5 * cross * stretch * stretch;
            let found = potential_energy(&model, &kinematics(&model, &state), &state.q);
            assert!((found - expected).abs() < 1e-14, "{own} {cross} {q:?}: {found} instead of {expected}");
        }
    }
}

/// Storage that held one row of a gear holds the three rows of a point afterwards, and the other way round.
#[test]
fn storage_of_one_equation_serves_another() {
    let mut builder = ModelBuilder::new("both");
    for name in ["leader", "follower"] {
        let joint = Joint::new(name, JointKind::Hinge { axis: DVec3::Z });
        builder.body(name).joint(joint).solid(Geometry::Box { half_extents: DVec3::ONE }, 1.0).add().unwrap();
    }
    let polynomial = [0.1, 2.0, -0.5, 0.25, 0.125];
    builder.add_equality("gear", EqualityKind::Joint { joint: JointId(1), driver: Some(JointId(0)), polynomial });
    let (body_a, body_b) = (BodyId(1), BodyId(2));
    let (point_a, point_b) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.0, -0.5, 0.0));
    builder.add_equality("point", EqualityKind::Connect { body_a, point_a, body_b, point_b });
    let frame_a = Pose::new(point_a, DQuat::from_rotation_z(0.3));
    builder.add_equality("weld", EqualityKind::Weld { body_a, frame_a, body_b, frame_b: Pose::IDENTITY });
    let model = builder.build().unwrap();
    let q = [0.4, -0.9];
    let kinematics = kinematics(&model, &State::at(q.to_vec(), vec![0.0; 2]));
    let mut used = EqualityBlock::new(&model);
    for (equality, part, count) in [(0, 0, 1), (1, 0, 3), (0, 0, 1), (2, 0, 3), (0, 0, 1), (2, 1, 3)] {
        let mut fresh = EqualityBlock::new(&model);
        let kind = &model.equalities[equality].kind;
        equality_block_into(&model, &kinematics, &q, kind, part, &mut used);
        equality_block_into(&model, &kinematics, &q, kind, part, &mut fresh);
        assert_eq!((used.count, used.violation, &used.rows), (count, fresh.violation, &fresh.rows));
    }
}
