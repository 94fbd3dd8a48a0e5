//! Bodies that are moved from outside.

use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{BodyId, Inertia, Input, Joint, JointKind, ModelBuilder, ModelError, Pose};
use signorini::{Settings, Simulation};

use crate::support::run_certified;

const HAND: &str = "<mujoco><option timestep='0.002'/><worldbody><body name='hand' mocap='true' pos='0 0 1'>
    <body name='finger' pos='0.1 0 0'><geom size='.01' contype='0' conaffinity='0'/></body></body>
    <body name='tool' pos='0 0 1'><freejoint/><geom size='.1' mass='1' contype='0' conaffinity='0'/></body></worldbody>
    <equality><weld body1='hand' body2='tool'/></equality>
    <keyframe><key name='away' mpos='1 2 3' mquat='0 0 0 2' qpos='1 2 3 0 0 0 1'/></keyframe></mujoco>";

const PLATE: &str = "<mujoco><option timestep='0.002'/><worldbody><geom type='plane'/>
    <body mocap='true' pos='0 0 0'><geom type='box' size='.5 .5 .1'/></body>
    <body pos='0 0 0.3'><freejoint/><geom size='.1' mass='1'/></body></worldbody></mujoco>";

fn load(text: &str, settings: Settings) -> Simulation {
    let imported = signorini_formats::load_mjcf_str(text, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    Simulation::new(imported.model, settings).unwrap()
}

fn position(simulation: &Simulation) -> DVec3 {
    DVec3::from_slice(&simulation.state().q[..3])
}

/// What is welded to it goes where it goes; what hangs on it without a joint, too.
#[test]
fn a_welded_body_follows() {
    let mut simulation = load(HAND, Settings::default());
    assert_eq!((simulation.model().mocap_bodies.len(), simulation.model().nv), (1, 6));
    for k in 0..200 {
        let x = 5e-5 * f64::from(k);
        let turn = DQuat::from_rotation_z(x);
        simulation.input.mocap = vec![Pose::new(DVec3::new(x, -x, 1.0 + x), turn)];
        assert!(simulation.step().unwrap().advanced());
        assert!((position(&simulation) - DVec3::new(x, -x, 1.0 + x)).length() < 1e-9);
        let q = &simulation.state().q;
        let tool = DQuat::from_xyzw(q[4], q[5], q[6], q[3]);
        assert!(tool.dot(turn).abs() > 1.0 - 1e-12, "{tool} instead of {turn}");
    }
}

#[test]
fn a_keyframe_places_it() {
    let mut simulation = load(HAND, Settings::default());
    simulation.reset_to("away").unwrap();
    let [pose] = simulation.input.mocap[..] else { panic!("one body") };
    assert_eq!((pose.position.to_array(), pose.rotation.to_array()), ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0, 0.0]));
    assert!(simulation.constraint_violation() < 1e-12);
    assert!(simulation.step().unwrap().advanced());
    simulation.input.mocap.clear();
    assert!(simulation.constraint_violation() > 1.0, "without an input it stands where the model places it");
}

/// A ball rests on it, awake and asleep, and is lifted by it; the floor does not hold it up.
#[test]
fn it_touches_what_moves_and_nothing_that_stands() {
    for sleeping in [false, true] {
        let mut simulation = load(PLATE, Settings::default().with_sleeping(sleeping));
        run_certified(&mut simulation, 1.0);
        assert!((position(&simulation).z - 0.2).abs() < 1e-6);
        assert!(simulation.workspace().contact_points().iter().all(|point| point.geom_a.0 == 1));
        for k in 0..100 {
            simulation.input.mocap = vec![Pose::from_position(DVec3::new(0.0, 0.0, 1e-4 * f64::from(k)))];
            assert!(simulation.step().unwrap().advanced());
        }
        let height = position(&simulation).z;
        assert!((0.2099 - 1e-6..0.2105).contains(&height), "{height}");
    }
}

#[test]
fn snapshots_hold_its_pose() {
    let mut simulation = load(HAND, Settings::default());
    simulation.step().unwrap();
    simulation.input.mocap = vec![Pose::from_position(DVec3::new(0.0, 0.0, 1.00001))];
    simulation.step().unwrap();
    let snapshot = simulation.save();
    let stored = signorini::Snapshot::from_bytes(&snapshot.to_bytes()).unwrap();
    assert_eq!(stored, snapshot);
    assert_eq!(stored.input().mocap, simulation.input.mocap);
}

#[test]
fn what_cannot_be_is_refused() {
    let mut builder = ModelBuilder::new("m");
    let ball = Inertia { mass: 1.0, ..Inertia::ZERO };
    let body = builder.add_body("hand", BodyId::WORLD, Pose::IDENTITY, ball).unwrap();
    builder.set_mocap(body).unwrap();
    builder.add_joint(body, Joint::new("j", JointKind::Slide { axis: DVec3::X })).unwrap();
    assert!(matches!(builder.build(), Err(ModelError::InvalidMocap { body }) if body == "hand"));
    let mut simulation = load(HAND, Settings::default());
    for (mocap, expected) in
        [(vec![Pose::IDENTITY; 2], "mocap has 2 entries"), (vec![Pose::from_position(DVec3::NAN)], "hand")]
    {
        simulation.input = Input::default().with_mocap(mocap);
        let message = simulation.step().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}
