//! Sensors of the state and cameras: poses beside products of transforms, velocities beside differences of what is measured.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{
    Actuator, ActuatorId, ActuatorKind, BodyId, Camera, CameraId, CameraMode, Centroidal, FrameId, Geom, GeomId,
    Geometry, Joint, JointId, JointKind, Kinematics, LengthRow, Model, ModelBuilder, Pose, Sensor, SensorKind, Site,
    SiteId, State, Tendon, TendonId, camera_pose, centroidal_momentum_matrix_into, integrate_into, state_sensors_into,
};

use crate::identities::kinematics;
use crate::random_model::{Random, random_state};

const PLACES: [[f64; 6]; 3] =
    [[0.1, -0.2, 0.3, 0.4, 0.5, -0.6], [-0.3, 0.1, 0.2, -0.7, 0.2, 0.1], [0.2, 0.2, -0.1, 0.3, -0.4, 0.8]];

fn place(k: usize) -> Pose {
    Pose::new(DVec3::from_slice(&PLACES[k]), DQuat::from_scaled_axis(DVec3::from_slice(&PLACES[k][3..])))
}

/// Of cameras on the middle body.
const MODES: [CameraMode; 5] = [
    CameraMode::Fixed,
    CameraMode::Track,
    CameraMode::TrackCenterOfMass,
    CameraMode::Target(BodyId(3)),
    CameraMode::TargetCenterOfMass(BodyId(3)),
];

/// A free body that carries one on a ball joint that carries one on a hinge, with these sensors.
fn chain(sensors: &[SensorKind]) -> Model {
    let mut builder = ModelBuilder::new("chain");
    let shape = |k: usize| {
        let half_extents = DVec3::new(0.1, 0.15, 0.2) * (1.0 + k as f64);
        Geom::new(format!("geom {k}"), Geometry::Box { half_extents }).with_placement(place(k))
    };
    let base = builder.body("base").free().solid(shape(0), 1.0).add().unwrap();
    let ball = builder.body("middle").on(base).at([0.1, 0.3, 0.2]).joint(Joint::new("ball", JointKind::Ball));
    let middle = ball.solid(shape(1), 2.0).add().unwrap();
    let hinge = Joint::new("hinge", JointKind::Hinge { axis: DVec3::new(1.0, 2.0, -1.0).normalize() });
    let tip = builder.body("tip").on(middle).at([0.0, 0.2, 0.4]).joint(hinge).solid(shape(2), 0.7).add().unwrap();
    for (k, body) in [base, middle, tip].into_iter().enumerate() {
        let site = Site::new(format!("site {k}")).with_placement(place((k + 1) % 3));
        builder.add_site(body, site).unwrap();
    }
    let camera = Camera::new("camera").with_placement(place(2)).with_resolution([640, 480]);
    builder.add_camera(middle, camera.clone()).unwrap();
    builder.add_camera(base, camera.clone().with_name("focal").with_focal([1.2, 0.8])).unwrap();
    for mode in MODES {
        builder.add_camera(middle, camera.clone().with_name(format!("{mode:?}")).with_mode(mode)).unwrap();
    }
    builder.add_tendon(Tendon::new("tendon", vec![(JointId(2), 0.3)]));
    builder.add_actuator(Actuator::new("motor", JointId(2), ActuatorKind::Motor).with_gear(3.0));
    for (k, &kind) in sensors.iter().enumerate() {
        builder.add_sensor(Sensor::new(format!("sensor {k}"), kind));
    }
    builder.build().unwrap()
}

/// A random state in which nothing is so quick that differences tell less of it, at a time that is not zero.
fn moving(model: &Model, random: &mut Random) -> State {
    let mut state = random_state(random, model).with_time(random.uniform(1.0, 9.0));
    state.v.iter_mut().for_each(|v| *v *= 0.5);
    state
}

/// What the sensors measure, one after the other.
fn measured(model: &Model, state: &State) -> Vec<Vec<f64>> {
    let mut out = vec![f64::NAN; model.sensor_size];
    state_sensors_into(model, state, &kinematics(model, state), &mut LengthRow::new(model), &mut out);
    let own = |sensor: &Sensor| out[sensor.address..sensor.address + sensor.kind.size()].to_vec();
    model.sensors.iter().map(own).collect()
}

/// What they measure a little later and a little earlier at the same velocity.
fn beside(model: &Model, state: &State) -> [Vec<Vec<f64>>; 2] {
    [STEP, -STEP].map(|dt| {
        let mut moved = state.clone();
        integrate_into(model, &state.q, &state.v, dt, &mut moved.q);
        measured(model, &moved)
    })
}

const STEP: f64 = 1e-5;

fn vector(values: &[f64]) -> DVec3 {
    DVec3::from_slice(values)
}

fn rotation(values: &[f64]) -> DQuat {
    DQuat::from_xyzw(values[1], values[2], values[3], values[0])
}

/// The slope of what a sensor of a position measures.
fn slope([after, before]: [&[f64]; 2]) -> DVec3 {
    (vector(after) - vector(before)) / (2.0 * STEP)
}

/// Angular velocity in the axes that the rotation leads to.
fn turning([after, before]: [&[f64]; 2]) -> DVec3 {
    (rotation(after) * rotation(before).conjugate()).to_scaled_axis() / (2.0 * STEP)
}

#[track_caller]
fn assert_near(found: DVec3, expected: DVec3, tolerance: f64) {
    assert!((found - expected).length() < tolerance, "{found} instead of {expected}");
}

#[test]
fn frames_are_measured_beside_each_other() {
    use SensorKind::{FrameAngularVelocity, FrameAxis, FrameLinearVelocity, FramePosition, FrameQuaternion};
    let frames: Vec<FrameId> = (0..3)
        .flat_map(|k| {
            let body = BodyId(k + 1);
            [FrameId::Body(body), FrameId::CenterOfMass(body), FrameId::Geom(GeomId(k)), FrameId::Site(SiteId(k))]
        })
        .collect();
    let mut random = Random(21);
    for &own in &frames {
        for reference in [None, Some(frames[0]), Some(frames[5]), Some(frames[6]), Some(frames[11])] {
            let axes = [0, 1, 2].map(|axis| FrameAxis(own, reference, axis));
            let kinds = [
                FramePosition(own, reference),
                FrameQuaternion(own, reference),
                FrameLinearVelocity(own, reference),
                FrameAngularVelocity(own, reference),
            ];
            let model = chain(&[&kinds[..], &axes[..]].concat());
            let state = moving(&model, &mut random);
            let (now, [after, before]) = (measured(&model, &state), beside(&model, &state));
            let at = kinematics(&model, &state);
            let pose = |frame| match frame {
                FrameId::Body(body) => at.pose[body.index()],
                FrameId::CenterOfMass(body) => {
                    Pose::new(at.center_of_mass[body.index()], at.pose[body.index()].rotation)
                }
                FrameId::Geom(GeomId(k)) => at.pose[k as usize + 1] * place(k as usize),
                FrameId::Site(SiteId(k)) => at.pose[k as usize + 1] * place((k as usize + 1) % 3),
            };
            let expected = reference.map_or(Pose::IDENTITY, pose).inverse() * pose(own);
            assert_near(vector(&now[0]), expected.position, 1e-13);
            assert!(rotation(&now[1]).dot(expected.rotation).abs() > 1.0 - 1e-14);
            assert_near(vector(&now[2]), slope([&after[0], &before[0]]), 1e-8);
            assert_near(vector(&now[3]), turning([&after[1], &before[1]]), 1e-8);
            for (k, axis) in DVec3::AXES.into_iter().enumerate() {
                assert_near(vector(&now[4 + k]), rotation(&now[1]) * axis, 1e-14);
            }
        }
    }
}

#[test]
fn sites_measure_in_their_own_axes() {
    use SensorKind::{FramePosition, FrameQuaternion, Gyro, Magnetometer, Velocimeter};
    let mut random = Random(22);
    for site in [0, 1, 2].map(SiteId) {
        let frame = FrameId::Site(site);
        let kinds = [
            FramePosition(frame, None),
            FrameQuaternion(frame, None),
            Velocimeter(site),
            Gyro(site),
            Magnetometer(site),
        ];
        let model = chain(&kinds);
        let state = moving(&model, &mut random);
        let (now, [after, before]) = (measured(&model, &state), beside(&model, &state));
        let back = rotation(&now[1]).conjugate();
        assert_near(vector(&now[2]), back * slope([&after[0], &before[0]]), 1e-8);
        assert_near(vector(&now[3]), back * turning([&after[1], &before[1]]), 1e-8);
        // MuJoCo's default field.
        assert_near(vector(&now[4]), back * DVec3::new(0.0, -0.5, 0.0), 1e-14);
    }
}

#[test]
fn subtrees_are_measured_as_their_bodies_are() {
    use SensorKind::{SubtreeAngularMomentum, SubtreeCenterOfMass, SubtreeLinearVelocity};
    let mut random = Random(23);
    for root in 1..4 {
        let body = BodyId(root as u32);
        let kinds = [SubtreeCenterOfMass(body), SubtreeLinearVelocity(body), SubtreeAngularMomentum(body)];
        let model = chain(&kinds);
        let state = moving(&model, &mut random);
        let (now, [after, before]) = (measured(&model, &state), beside(&model, &state));
        let at = kinematics(&model, &state);
        let inertia = |i: usize| &model.bodies[i].inertia;
        let mass: f64 = (root..4).map(|i| inertia(i).mass).sum();
        let center: DVec3 = (root..4).map(|i| inertia(i).mass * at.center_of_mass[i]).sum::<DVec3>() / mass;
        assert_near(vector(&now[0]), center, 1e-13);
        assert_near(vector(&now[1]), slope([&after[0], &before[0]]), 1e-8);
        let momentum = match root {
            1 => {
                let mut whole = Centroidal::new(&model);
                centroidal_momentum_matrix_into(&model, &at, &mut whole);
                whole.momentum(&state.v).angular
            }
            _ => (root..4)
                .map(|i| {
                    let turned = DMat3::from_quat(at.pose[i].rotation);
                    let spin = turned * inertia(i).rotational * turned.transpose() * at.angular_velocity[i];
                    let velocity = at.point_velocity(BodyId(i as u32), at.center_of_mass[i]);
                    // About a point that moves with the whole, the whole's own momentum has no moment.
                    spin + (at.center_of_mass[i] - center).cross(inertia(i).mass * velocity)
                })
                .sum(),
        };
        assert_near(vector(&now[2]), momentum, 1e-13);
    }
}

/// Where nothing has mass the origin of the body stands for the centre of mass.
#[test]
fn a_subtree_without_mass_is_where_its_body_is() {
    let mut builder = ModelBuilder::new("pointer");
    let shape = Geometry::Sphere { radius: 0.1 };
    let hand = builder.body("hand").free().solid(shape, 1.0).add().unwrap();
    let pointer = builder.body("pointer").on(hand).at([0.1, 0.3, -0.2]).add().unwrap();
    builder.add_sensor(Sensor::new("place", SensorKind::SubtreeCenterOfMass(pointer)));
    builder.add_sensor(Sensor::new("velocity", SensorKind::SubtreeLinearVelocity(pointer)));
    let model = builder.build().unwrap();
    let turn = DQuat::from_rotation_z(0.7);
    let q = vec![1.0, 2.0, 3.0, turn.w, turn.x, turn.y, turn.z];
    let state = State::at(q, vec![0.4, 0.5, 0.6, 0.7, -0.8, 0.9]);
    let now = measured(&model, &state);
    let arm = turn * DVec3::new(0.1, 0.3, -0.2);
    assert_near(vector(&now[0]), DVec3::new(1.0, 2.0, 3.0) + arm, 1e-14);
    let omega = turn * DVec3::new(0.7, -0.8, 0.9);
    assert_near(vector(&now[1]), DVec3::new(0.4, 0.5, 0.6) + omega.cross(arm), 1e-14);
}

#[test]
fn coordinates_are_measured_as_they_are() {
    use SensorKind::{
        ActuatorPosition, ActuatorVelocity, BallAngularVelocity, BallQuaternion, Clock, JointPosition, JointVelocity,
        TendonPosition, TendonVelocity,
    };
    let (hinge, ball) = (JointId(2), JointId(1));
    let (tendon, actuator) = (TendonId(0), ActuatorId(0));
    let model = chain(&[
        JointPosition(hinge),
        JointVelocity(hinge),
        BallQuaternion(ball),
        BallAngularVelocity(ball),
        TendonPosition(tendon),
        TendonVelocity(tendon),
        ActuatorPosition(actuator),
        ActuatorVelocity(actuator),
        Clock,
    ]);
    let mut state = moving(&model, &mut Random(24));
    // Of length 1 without rounding.
    state.q[7..11].copy_from_slice(&[0.5, -0.5, 0.5, 0.5]);
    let (q, v) = (state.q[11], state.v[9]);
    let expected = [
        vec![q],
        vec![v],
        state.q[7..11].to_vec(),
        state.v[6..9].to_vec(),
        vec![0.3 * q],
        vec![0.3 * v],
        vec![3.0 * q],
        vec![3.0 * v],
        vec![state.time],
    ];
    assert_eq!(measured(&model, &state), expected);
}

/// A point straight ahead is in the middle of the picture, and a point at half the field of view above that on its upper edge.
#[test]
fn cameras_see_points_where_their_lines_meet_the_picture() {
    let mut random = Random(25);
    let kinds = [0, 1].map(|camera| SensorKind::CameraProjection(SiteId(2), CameraId(camera)));
    let model = chain(&kinds);
    for _ in 0..20 {
        let state = moving(&model, &mut random);
        let at = kinematics(&model, &state);
        let point = (at.pose[3] * place(0)).position;
        let now = measured(&model, &state);
        for (k, body) in [2, 1].into_iter().enumerate() {
            let seen = (at.pose[body] * place(2)).inverse().transform_point(point);
            let ahead = -seen.z;
            // Tangents of the angles to the right and upwards, in units of the half picture.
            let half = (0.5 * 45.0_f64.to_radians()).tan();
            let pixels = match k {
                0 => [320.0 + 240.0 * seen.x / ahead / half, 240.0 - 240.0 * seen.y / ahead / half],
                _ => [320.0 + 1.2 * 640.0 * seen.x / ahead, 240.0 - 0.8 * 480.0 * seen.y / ahead],
            };
            for (found, expected) in now[k].iter().zip(pixels) {
                assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} instead of {expected}");
            }
        }
    }
}

#[test]
fn cameras_follow_and_look_as_their_modes_say() {
    let [middle, tip] = [BodyId(2), BodyId(3)];
    let model = chain(&[]);
    let mut random = Random(27);
    let reference = State::new(&model);
    for state in [reference.clone(), moving(&model, &mut random)] {
        let [start, at] = [&reference, &state].map(|state| kinematics(&model, state));
        let [before, carried] = [&start, &at].map(|at| at.pose[middle.index()] * place(2));
        let center = |at: &Kinematics| {
            let bodies =
                [middle, tip].map(|body| (model.bodies[body.index()].inertia.mass, at.center_of_mass[body.index()]));
            bodies.iter().map(|(m, c)| *m * *c).sum::<DVec3>() / bodies.iter().map(|(m, _)| m).sum::<f64>()
        };
        let origin = |at: &Kinematics| at.pose[middle.index()].position;
        let followed = [DVec3::ZERO, origin(&at) - origin(&start), center(&at) - center(&start)];
        let targets = [at.pose[tip.index()].position, at.center_of_mass[tip.index()]];
        for (k, camera) in model.cameras[2..].iter().enumerate() {
            let found = camera_pose(&model, &at, camera);
            if (1..3).contains(&k) {
                assert_near(found.position, before.position + followed[k], 1e-13);
                assert!(found.rotation.dot(before.rotation).abs() > 1.0 - 1e-14, "{}", camera.name);
                continue;
            }
            assert_near(found.position, carried.position, 1e-13);
            if k == 0 {
                assert!(found.rotation.dot(carried.rotation).abs() > 1.0 - 1e-14);
            } else {
                let ahead = (targets[k - 3] - carried.position).normalize();
                assert_near(found.rotation * DVec3::NEG_Z, ahead, 1e-13);
                // Upright: its x axis is level, and up is up.
                assert!((found.rotation * DVec3::X).z.abs() < 1e-13 && (found.rotation * DVec3::Y).z > 0.0);
            }
        }
    }
}

/// A cutoff bounds numbers either way, and directions not at all.
#[test]
fn a_cutoff_bounds_what_is_measured() {
    let frame = FrameId::Body(BodyId(3));
    let kinds = [SensorKind::FrameLinearVelocity(frame, None), SensorKind::FrameQuaternion(frame, None)];
    let mut model = chain(&kinds);
    let mut random = Random(26);
    let states: Vec<State> = (0..20).map(|_| moving(&model, &mut random)).collect();
    let whole: Vec<_> = states.iter().map(|state| measured(&model, state)).collect();
    model.sensors.iter_mut().for_each(|sensor| sensor.cutoff = Some(0.2));
    for (state, whole) in states.iter().zip(whole) {
        let bounded: Vec<f64> = whole[0].iter().map(|x| x.signum() * x.abs().min(0.2)).collect();
        assert_eq!(measured(&model, state), [bounded, whole[1].clone()]);
    }
    // Numbers that a step or shapes have to give are left as they are.
    let force = SensorKind::ActuatorForce(ActuatorId(0));
    let mut model = chain(&[SensorKind::Clock, force, SensorKind::Rangefinder(SiteId(0))]);
    model.sensors.iter_mut().for_each(|sensor| sensor.cutoff = Some(0.2));
    let (state, mut out) = (moving(&model, &mut random), vec![7.0; 3]);
    state_sensors_into(&model, &state, &kinematics(&model, &state), &mut LengthRow::new(&model), &mut out);
    assert_eq!(out, [0.2, 7.0, 7.0]);
    let ray = Sensor::new("ray", SensorKind::Rangefinder(SiteId(0))).with_cutoff(0.2);
    let mut values = [-1.0, 0.1, 0.5];
    ray.cut_off(&mut values);
    assert_eq!(values, [-0.2, 0.1, 0.2], "MuJoCo 4.0.0 bounds the -1 of a ray that meets nothing, too");
}

/// Only the limit that is passed is told of, with what it is passed by and how fast; a ball joint has a cone.
#[test]
fn limits_are_measured_where_they_are_passed() {
    use SensorKind::{JointLimitPosition, JointLimitVelocity, TendonLimitPosition, TendonLimitVelocity};
    let mut builder = ModelBuilder::new("limits");
    let shape = || Geom::from(Geometry::Sphere { radius: 0.1 });
    let hinge = Joint::new("hinge", JointKind::Hinge { axis: DVec3::Z }).with_limits([-0.5, 0.75]);
    let ball = Joint::new("ball", JointKind::Ball).with_limits([0.0, 0.5]);
    let arm = builder.body("arm").joint(hinge).solid(shape(), 1.0).add().unwrap();
    builder.body("hand").on(arm).joint(ball).solid(shape(), 1.0).add().unwrap();
    builder.add_tendon(Tendon::new("tendon", vec![(JointId(0), 2.0)]).with_limits([-2.0, 1.0]));
    let (hinge, ball, tendon) = (JointId(0), JointId(1), TendonId(0));
    let kinds =
        [JointLimitPosition(hinge), JointLimitVelocity(hinge), JointLimitPosition(ball), JointLimitVelocity(ball)];
    for kind in kinds.into_iter().chain([TendonLimitPosition(tendon), TendonLimitVelocity(tendon)]) {
        builder.add_sensor(Sensor::new(format!("{kind:?}"), kind));
    }
    let model = builder.build().unwrap();
    let axis = DVec3::new(0.6, 0.0, -0.8);
    let omega = DVec3::new(0.3, 5.0, 0.7);
    // Angle and rate of the hinge, angle of the ball; then what is passed by how much.
    let cases = [
        ([0.25, 3.0, 0.25], [0.0; 6]),
        ([-0.75, 3.0, 0.75], [-0.25, 3.0, -0.25, -axis.dot(omega), 0.0, 0.0]),
        ([1.0, 3.0, 0.5], [-0.25, -3.0, 0.0, 0.0, -1.0, -6.0]),
    ];
    for ([angle, rate, turn], wanted) in cases {
        let r = DQuat::from_axis_angle(axis, turn);
        let q = vec![angle, r.w, r.x, r.y, r.z];
        let found: Vec<f64> = measured(&model, &State::at(q, vec![rate, omega.x, omega.y, omega.z])).concat();
        assert!(found.iter().zip(wanted).all(|(x, y)| (x - y).abs() < 1e-15), "{angle}, {turn}: {found:?}");
    }
}

/// The energy of a body that falls freely stays, and is what its height and speed make of it; a site notices what is in its zone.
#[test]
fn energies_and_zones_are_measured() {
    let mut builder = ModelBuilder::new("falling");
    let half_extents = DVec3::new(0.1, 0.2, 0.3);
    let body = builder.body("box").free().solid(Geom::from(Geometry::Box { half_extents }), 2.0).add().unwrap();
    let site = Site::new("gate").with_placement([1.0, 0.0, 0.0]).with_zone(Geometry::Box { half_extents });
    builder.add_site(BodyId::WORLD, site).unwrap();
    let inside = SensorKind::InsideSite(FrameId::Body(body), SiteId(0));
    for kind in [SensorKind::PotentialEnergy, SensorKind::KineticEnergy, inside] {
        builder.add_sensor(Sensor::new(format!("{kind:?}"), kind));
    }
    let model = builder.build().unwrap();
    for (place, is_inside) in [([1.09, -0.19, 0.29], 1.0), ([1.11, 0.0, 0.0], 0.0), ([1.0, 0.0, -0.31], 0.0)] {
        let q = vec![place[0], place[1], place[2], 1.0, 0.0, 0.0, 0.0];
        let found = measured(&model, &State::at(q, vec![3.0, 0.0, 4.0, 0.0, 0.0, 0.5])).concat();
        // A box turns about z with m (a² + b²)/12 of its sides.
        let inertia = 2.0 * (0.2 * 0.2 + 0.4 * 0.4) / 12.0;
        let wanted = [2.0 * 9.81 * place[2], 0.5 * 2.0 * 25.0 + 0.5 * inertia * 0.25, is_inside];
        assert!(found.iter().zip(wanted).all(|(x, y)| (x - y).abs() < 1e-12), "{found:?}, not {wanted:?}");
    }
}
