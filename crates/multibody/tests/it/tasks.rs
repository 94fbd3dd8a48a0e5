//! What tasks ask: centres of mass of subtrees, operational-space inertia, applied wrenches, inverse kinematics.

use std::cell::Cell;

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    AxisRates, BodyId, Frame, FrameTarget, Input, InverseKinematicsSettings, JointKind, Kinematics, Model, Pose,
    SpatialVector, State, applied_force_into, axis_rates_into, center_of_mass, integrate_into, inverse_kinematics_into,
    operational_space_inertia, point_jacobian_into, rotation_log, subtree_center_of_mass, subtree_jacobian_into,
    subtree_jacobian_rate_into, total_mass,
};

use crate::identities::{FIXED, forward_dynamics, kinematics, mass_matrix, relative_error};
use crate::random_model::{Random, for_random_models};

/// Step of the central differences.
const H: f64 = 1e-5;

fn around(model: &Model, state: &State) -> [Kinematics; 2] {
    [-H, H].map(|h| {
        let mut next = state.clone();
        integrate_into(model, &state.q, &state.v, h, &mut next.q);
        kinematics(model, &next)
    })
}

fn times(matrix: &[f64], v: &[f64]) -> Vec<f64> {
    matrix.chunks(v.len()).map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum()).collect()
}

#[test]
fn jacobians_of_subtrees_are_derivatives_of_their_centres() {
    for_random_models(91, FIXED, |model, state, _| {
        if model.nv == 0 {
            return;
        }
        let at = kinematics(model, state);
        let (whole, center) = subtree_center_of_mass(model, &at, BodyId::WORLD);
        assert!((whole - total_mass(model)).abs() < 1e-12 && (center - center_of_mass(model, &at)).length() < 1e-12);
        let mut rates = AxisRates::new(model);
        axis_rates_into(model, &at, &state.v, &mut rates);
        for body in (0..model.bodies.len() as u32).map(BodyId) {
            let [before, after] = around(model, state);
            let jacobian = |at: &Kinematics| {
                let mut out = vec![f64::NAN; 3 * model.nv];
                subtree_jacobian_into(model, at, body, &mut out);
                out
            };
            let speed = subtree_center_of_mass(model, &after, body).1 - subtree_center_of_mass(model, &before, body).1;
            assert!(relative_error(&times(&jacobian(&at), &state.v), &(speed / (2.0 * H)).to_array()) < 1e-8);
            let differences = jacobian(&before).into_iter().zip(jacobian(&after)).map(|(a, b)| (b - a) / (2.0 * H));
            let mut rate = vec![f64::NAN; 3 * model.nv];
            subtree_jacobian_rate_into(model, &at, &rates, body, &mut rate);
            assert!(relative_error(&rate, &differences.collect::<Vec<_>>()) < 1e-7);
        }
    });
}

/// A force `Λ a` along the rows of a point accelerates it by `a`, whatever else moves: forward dynamics by another algorithm.
#[test]
fn the_operational_space_inertia_is_what_a_force_feels() {
    let checked = Cell::new(0);
    for_random_models(92, FIXED, |model, state, random: &mut Random| {
        if model.nv < 3 {
            return;
        }
        let at = kinematics(model, state);
        let body = BodyId(model.bodies.len() as u32 - 1);
        let point = at.pose[body.index()].transform_point(random.vector(0.5));
        let mut jacobian = vec![0.0; 3 * model.nv];
        point_jacobian_into(model, &at, body, point, &mut jacobian);
        let factor = mass_matrix(model, &at).matrix;
        let Some(inertia) = operational_space_inertia(&factor.factor().unwrap(), &jacobian) else { return };
        let wanted = random.vector(2.0).to_array();
        let force = times(&inertia, &wanted);
        let tau: Vec<f64> =
            (0..model.nv).map(|k| (0..3).map(|r| jacobian[r * model.nv + k] * force[r]).sum()).collect();
        let (with, without) = (forward_dynamics(model, &at, &tau), forward_dynamics(model, &at, &vec![0.0; model.nv]));
        let change: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        assert!(relative_error(&times(&jacobian, &change), &wanted) < 1e-6);
        checked.set(checked.get() + 1);
    });
    assert!(checked.get() > 10, "{checked:?}");
}

#[test]
fn rows_that_depend_on_each_other_have_no_operational_space_inertia() {
    let factor = signorini_multibody::BlockDiagonal::from_dense(2, &[2.0, 0.5, 0.5, 1.0]).unwrap().factor().unwrap();
    assert!(operational_space_inertia(&factor, &[1.0, 2.0, 2.0, 4.0]).is_none());
    let inertia = operational_space_inertia(&factor, &[1.0, 0.0, 0.0, 1.0]).unwrap();
    assert!(relative_error(&inertia, &[2.0, 0.5, 0.5, 1.0]) < 1e-14, "the mass matrix itself");
}

/// The power of wrenches on moving bodies is that of their generalized force.
#[test]
fn wrenches_do_the_work_of_their_generalized_force() {
    for_random_models(93, FIXED, |model, state, random: &mut Random| {
        let at = kinematics(model, state);
        let wrench: Vec<SpatialVector> = model
            .bodies
            .iter()
            // Forces alone and moments alone, too.
            .map(|_| match random.below(3) {
                0 => SpatialVector { angular: DVec3::ZERO, linear: random.vector(3.0) },
                1 => SpatialVector { angular: random.vector(3.0), linear: DVec3::ZERO },
                _ => SpatialVector { angular: random.vector(3.0), linear: random.vector(3.0) },
            })
            .collect();
        let own = random.list(model.nv, 1.0);
        let input = Input::of_force(own.clone()).with_wrench(wrench.clone());
        input.check(model).unwrap();
        let mut applied = vec![f64::NAN; model.nv];
        applied_force_into(model, &at, &input, &mut applied);
        let power: f64 = applied.iter().zip(&own).zip(&state.v).map(|((a, b), v)| (a - b) * v).sum();
        let of_bodies = wrench.iter().enumerate().map(|(i, w)| {
            let speed = at.point_velocity(BodyId(i as u32), at.center_of_mass[i]);
            w.linear.dot(speed) + w.angular.dot(at.angular_velocity[i])
        });
        let expected: f64 = of_bodies.sum();
        assert!((power - expected).abs() < 1e-10 * (1.0 + expected.abs()));
    });
}

/// Targets that are reached at some other configuration are met, within the limits.
#[test]
fn inverse_kinematics_meets_targets_within_reach() {
    let (met, asked) = (Cell::new(0), Cell::new(0));
    for_random_models(94, FIXED, |model, state, random: &mut Random| {
        if model.nv < 3 {
            return;
        }
        let mut limited = model.clone();
        let mut wanted = state.q.clone();
        for joint in &mut limited.joints {
            if let JointKind::Hinge { .. } | JointKind::Slide { .. } = joint.kind {
                let at = joint.reference + random.uniform(-0.5, 0.5);
                wanted[joint.q_index] = at;
                joint.limits = Some([joint.reference - 0.6, joint.reference + 0.6]);
            }
        }
        let there = kinematics(&limited, &State::at(wanted, vec![0.0; model.nv]));
        let frame = Frame { body: BodyId(model.bodies.len() as u32 - 1), placement: random.pose() };
        let goal = frame.pose(&there);
        let target = FrameTarget::pose(frame, goal);
        let mut q = limited.reference_configuration();
        let mut storage = Kinematics::new(&limited);
        let settings = InverseKinematicsSettings::default();
        let report = inverse_kinematics_into(&limited, &[target], &settings, &mut storage, &mut q);
        let found = frame.pose(&kinematics(&limited, &State::at(q.clone(), vec![0.0; model.nv])));
        let apart = (found.position - goal.position).length();
        let turned = rotation_log((goal.rotation * found.rotation.conjugate()).normalize()).length();
        assert!((apart - report.position_error).abs() < 1e-12 && (turned - report.angle_error).abs() < 1e-9);
        for joint in limited.joints.iter().filter(|joint| joint.kind.nv() == 1) {
            assert!((q[joint.q_index] - joint.reference).abs() <= 0.6 + 1e-15);
        }
        asked.set(asked.get() + 1);
        met.set(met.get() + usize::from(report.converged));
    });
    // From the reference a local minimum between limits can be in the way.
    assert!(asked.get() > 15 && met.get() * 10 >= asked.get() * 8, "{met:?} of {asked:?}");
}

/// A target out of reach of an arm of two links: the arm stretches towards it.
#[test]
fn inverse_kinematics_stretches_towards_what_is_out_of_reach() {
    let mut world = signorini_multibody::ModelBuilder::new("arm");
    let ball = signorini_multibody::Geometry::Sphere { radius: 0.1 };
    let hinge = |name: &str| signorini_multibody::Joint::hinge(name, DVec3::Y);
    let upper = world.body("upper").joint(hinge("shoulder")).solid(ball.clone(), 1.0).add().unwrap();
    let elbow = hinge("elbow").with_limits([-2.5, 2.5]);
    let lower = world.body("lower").on(upper).at([1.0, 0.0, 0.0]).joint(elbow).solid(ball, 1.0).add().unwrap();
    let model = world.build().unwrap();
    let tip = Frame { body: lower, placement: Pose::from_position(DVec3::X) };
    let mut q = vec![0.3, 0.9];
    let goal = DVec3::new(0.0, 0.0, -5.0);
    let settings = InverseKinematicsSettings::default().with_max_iterations(1000);
    let mut storage = Kinematics::new(&model);
    let report = inverse_kinematics_into(&model, &[FrameTarget::at(tip, goal)], &settings, &mut storage, &mut q);
    assert!(!report.converged && (report.position_error - 3.0).abs() < 1e-6, "{report:?} at {q:?}");
    assert!((tip.pose(&storage).position - DVec3::new(0.0, 0.0, -2.0)).length() < 1e-2);
    // With the elbow held only the shoulder turns.
    let only = settings.with_movable(vec![true, false]);
    let mut q = vec![0.3, 0.9];
    inverse_kinematics_into(&model, &[FrameTarget::at(tip, goal)], &only, &mut storage, &mut q);
    assert_eq!(q[1], 0.9);
    let turn = FrameTarget::at(tip, DVec3::ZERO).with_position(None).with_rotation(Some(DQuat::from_rotation_y(0.7)));
    let report = inverse_kinematics_into(&model, &[turn], &only, &mut storage, &mut q);
    assert!(report.converged && (q[0] + q[1] - 0.7).abs() < 1e-9);
}

/// A target inwards is reached from a limit, however weak the pull towards it is, and one beyond the limit leaves the joint at it.
#[test]
fn inverse_kinematics_leaves_a_limit_inwards_alone() {
    for axis in [DVec3::Y, DVec3::NEG_Y] {
        check_limits_inwards(axis);
    }
}

fn check_limits_inwards(axis: DVec3) {
    let mut world = signorini_multibody::ModelBuilder::new("arm");
    let pivot = signorini_multibody::Joint::hinge("pivot", axis).with_limits([-0.4, 0.7]);
    let ball = signorini_multibody::Geometry::Sphere { radius: 0.1 };
    let arm = world.body("arm").joint(pivot).solid(ball, 1.0).add().unwrap();
    let model = world.build().unwrap();
    let frame = Frame { body: arm, placement: Pose::IDENTITY };
    let settings = InverseKinematicsSettings::default();
    let mut storage = Kinematics::new(&model);
    for (start, wanted, end) in
        [(-0.4, -0.3, -0.3), (-0.4, 0.6, 0.6), (0.7, 0.65, 0.65), (0.7, 0.9, 0.7), (-0.4, -0.5, -0.4)]
    {
        let turn = FrameTarget::at(frame, DVec3::ZERO)
            .with_position(None)
            .with_rotation(Some(DQuat::from_scaled_axis(axis * wanted)));
        let mut q = vec![start];
        let report = inverse_kinematics_into(&model, &[turn], &settings, &mut storage, &mut q);
        assert!((q[0] - end).abs() < 1e-9, "from {start} to {wanted}: {report:?} at {q:?}");
        assert_eq!(report.converged, wanted == end);
        assert!((report.angle_error - (wanted - end).abs()).abs() < 1e-9);
    }
}

/// As many evaluations are made, and reported, as are allowed.
#[test]
fn inverse_kinematics_ends_after_the_iterations_that_it_may_make() {
    let mut world = signorini_multibody::ModelBuilder::new("mass");
    let slide = signorini_multibody::Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    let ball = signorini_multibody::Geometry::Sphere { radius: 0.1 };
    let mass = world.body("mass").joint(slide).solid(ball, 1.0).add().unwrap();
    let model = world.build().unwrap();
    let frame = Frame { body: mass, placement: Pose::IDENTITY };
    let aside = [FrameTarget::at(frame, DVec3::new(1.0, 2.0, 0.0))];
    let mut storage = Kinematics::new(&model);
    for most in [1, 2, 7] {
        let settings = InverseKinematicsSettings::default().with_max_iterations(most);
        let mut q = vec![0.0];
        let report = inverse_kinematics_into(&model, &aside, &settings, &mut storage, &mut q);
        assert!(!report.converged && report.iterations == most, "{report:?}");
        assert_eq!(q[0] == 0.0, most == 1);
    }
}

/// A ball turns about the way to its target as far as its limit lets it, and one that is there already is evaluated once.
#[test]
fn inverse_kinematics_turns_a_ball_up_to_its_limit() {
    let mut world = signorini_multibody::ModelBuilder::new("joystick");
    let ball = signorini_multibody::Joint::new("ball", JointKind::Ball).with_limits([0.0, 0.5]);
    let shape = signorini_multibody::Geometry::Sphere { radius: 0.1 };
    let slide = signorini_multibody::Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    let base = world.body("base").joint(slide).solid(shape.clone(), 1.0).add().unwrap();
    let stick = world.body("stick").on(base).joint(ball).solid(shape, 1.0).add().unwrap();
    let model = world.build().unwrap();
    let frame = Frame { body: stick, placement: Pose::IDENTITY };
    let axis = DVec3::new(0.48, -0.6, 0.64);
    let mut storage = Kinematics::new(&model);
    for (wanted, end) in [(0.4, 0.4), (1.2, 0.5), (-0.8, -0.5)] {
        let goal = DQuat::from_scaled_axis(axis * wanted);
        let turn = FrameTarget::at(frame, DVec3::ZERO).with_position(None).with_rotation(Some(goal));
        let settings = InverseKinematicsSettings::default();
        let mut q = model.reference_configuration();
        let report = inverse_kinematics_into(&model, std::slice::from_ref(&turn), &settings, &mut storage, &mut q);
        let found = rotation_log(DQuat::from_xyzw(q[2], q[3], q[4], q[1]));
        assert!((found - axis * end).length() < 1e-8, "{wanted}: {report:?} at {found}");
        assert_eq!(report.converged, wanted == end);
        if report.converged {
            assert_eq!(inverse_kinematics_into(&model, &[turn], &settings, &mut storage, &mut q).iterations, 1);
        }
    }
}
