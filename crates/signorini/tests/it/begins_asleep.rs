//! Trees that begin asleep: still to the bit until something disturbs them, and from then on as if they had just been put there.

use signorini::multibody::glam::DVec3;
use signorini::multibody::{BodyId, Pose, SpatialVector};
use signorini::{Settings, Simulation};

use crate::sleeping::difference;
use crate::support::bits;

/// A ball that falls on two crates in mid-air that touch each other; a pebble that falls on an arm with a motor, a limit of a tendon, dry friction and an
/// equation between joints; a lamp that is welded to a box that falls.
const SCENE: &str = r#"<mujoco model="asleep">
  <option timestep="0.002"><flag sleep="enable"/></option>
  <default><geom friction="0.5"/></default>
  <worldbody>
    <geom name="floor" type="plane"/>
    <body name="low" pos="0 0 1" sleep="init"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
    <body name="high" pos="0 0 1.2" sleep="init"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
    <body name="ball" pos="0.02 0.01 1.5"><freejoint/><geom size=".05" mass="1"/></body>
    <body name="arm" pos="2 0 1" sleep="init">
      <joint name="shoulder" axis="0 1 0" frictionloss="0.05"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="0.4" contype="0" conaffinity="0"/>
      <body name="hand" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 -0.3" size="0.02" mass="0.4"/>
        <body name="tip" pos="0.3 0 -0.3"><joint name="wrist" axis="0 1 0"/><geom size="0.03" mass="0.1" contype="0" conaffinity="0"/></body>
      </body>
    </body>
    <body name="pebble" pos="2.5 0 0.98"><freejoint/><geom size=".02" mass="0.5"/></body>
    <body name="lamp" pos="-2 0 1" sleep="init"><freejoint/><geom size=".05" mass="1"/></body>
    <body name="box" pos="-2 0 1.5"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
  </worldbody>
  <tendon><fixed name="cord" limited="true" range="0.02 0.5"><joint joint="elbow" coef="1"/></fixed></tendon>
  <equality><weld body1="lamp" body2="box"/><joint joint1="wrist" joint2="elbow" polycoef="0.1 1 0 0 0"/></equality>
  <actuator><motor name="lift" joint="shoulder" gear="1"/></actuator>
</mujoco>"#;

fn scene(text: &str) -> Simulation {
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.input.control = vec![0.1];
    simulation
}

/// The same with everyone awake.
fn awake() -> Simulation {
    scene(&SCENE.replace(" sleep=\"init\"", ""))
}

fn body(simulation: &Simulation, name: &str) -> BodyId {
    simulation.model().body_named(name).unwrap()
}

fn sleeps(simulation: &Simulation, name: &str) -> bool {
    simulation.workspace().sleeps(body(simulation, name))
}

/// The coordinates of the tree that moves a body.
fn coordinates(simulation: &Simulation, name: &str) -> Vec<u64> {
    let (model, state) = (simulation.model(), simulation.state());
    let joints = model.joints.iter().filter(|joint| {
        let mut dofs = model.dofs_moving(body(simulation, name));
        dofs.any(|dof| dof >= joint.v_index && dof < joint.v_index + joint.kind.nv())
    });
    joints.flat_map(|joint| &state.q[joint.q_index..joint.q_index + joint.kind.nq()]).map(|q| q.to_bits()).collect()
}

fn certified(simulation: &mut Simulation) {
    let report = simulation.step().unwrap();
    assert!(report.advanced() && !report.missed_tolerance && report.certificate.holds(1e-9), "{report:?}");
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |apart, (a, b)| f64::max(apart, (a - b).abs()))
}

/// Steps both from the first's state, and gives back how far they are apart after as many steps.
fn part_from_here(one: &mut Simulation, steps: usize) -> f64 {
    let mut other = awake();
    other.set_state(one.state()).unwrap();
    other.input = one.input.clone();
    for _ in 0..steps {
        certified(one);
        certified(&mut other);
    }
    difference(one, &other)
}

/// The numbers of `q` that belong to the trees of bodies.
fn places(simulation: &Simulation, names: &[&str]) -> Vec<f64> {
    names.iter().flat_map(|name| coordinates(simulation, name)).map(f64::from_bits).collect()
}

/// Nothing is held in the air by a law: with everyone awake all of it falls. Asleep it stays to the bit until something is there, and then what is struck, and what that
/// touches, goes on as in a run that begins there, with the controls of the moment.
#[test]
fn what_begins_asleep_stands_until_it_is_touched() {
    for (first, falls, trees) in [("low", 0.15, &["low", "high", "ball"][..]), ("hand", 0.0234, &["tip", "pebble"])] {
        let mut simulation = scene(SCENE);
        let start = places(&simulation, &trees[..trees.len() - 1]);
        let mut before = simulation.state().clone();
        certified(&mut simulation);
        simulation.input.control = vec![0.7];
        while sleeps(&simulation, first) {
            assert_eq!(places(&simulation, &trees[..trees.len() - 1]), start);
            before.clone_from(simulation.state());
            certified(&mut simulation);
            assert!(simulation.state().time < 0.5, "nothing has woken {first}");
        }
        let fallen = 0.5 * 9.81 * before.time.powi(2);
        assert!((0.8 * falls..1.1 * falls).contains(&fallen), "{first} wakes when that above it has fallen {fallen} m");
        assert!(trees.iter().all(|name| !sleeps(&simulation, name)));
        let mut other = awake();
        other.set_state(&before).unwrap();
        other.input = simulation.input.clone();
        certified(&mut other);
        for _ in 0..40 {
            assert!(apart(&places(&simulation, trees), &places(&other, trees)) < 1e-9, "{first}");
            certified(&mut simulation);
            certified(&mut other);
        }
        assert!(places(&simulation, &trees[..trees.len() - 1]) != start);
    }
}

/// Forces, wrenches, velocities and places from outside wake, and controls do not.
#[test]
fn what_acts_on_it_wakes_it() {
    type Change = (&'static str, &'static str, fn(&mut Simulation));
    let nv = scene(SCENE).model().nv;
    let arm =
        |simulation: &Simulation| simulation.model().joints.iter().find(|j| j.name == "shoulder").unwrap().v_index;
    assert_eq!((nv, arm(&scene(SCENE))), (39, 18));
    let changes: [Change; 4] = [
        ("arm", "a force", |simulation| {
            simulation.input.generalized_force = vec![0.0; 39];
            simulation.input.generalized_force[19] = 1e-3;
        }),
        ("low", "a wrench", |simulation| {
            simulation.input.wrench = vec![SpatialVector::ZERO; simulation.model().bodies.len()];
            simulation.input.wrench[1].linear = DVec3::X;
        }),
        ("high", "a velocity", |simulation| {
            let mut state = simulation.state().clone();
            state.v[9] = 0.1;
            simulation.set_state(&state).unwrap();
        }),
        ("arm", "a place", |simulation| {
            let mut state = simulation.state().clone();
            state.q[22] += 0.1;
            simulation.set_state(&state).unwrap();
        }),
    ];
    for (name, what, change) in changes {
        let mut simulation = scene(SCENE);
        for _ in 0..10 {
            certified(&mut simulation);
        }
        simulation.input.control = vec![0.7];
        certified(&mut simulation);
        assert!(sleeps(&simulation, name), "{what}: controls alone wake nobody");
        change(&mut simulation);
        let others = ["arm", "low"].into_iter().filter(|other| *other != name && !(name == "high" && *other == "low"));
        let others: Vec<_> = others.map(|other| (other, coordinates(&simulation, other))).collect();
        let mut other = awake();
        other.set_state(simulation.state()).unwrap();
        other.input = simulation.input.clone();
        certified(&mut simulation);
        certified(&mut other);
        assert!(!sleeps(&simulation, name), "{what}");
        let range = if name == "arm" { 18..21 } else { 0..12 };
        assert!(apart(&simulation.state().v[range.clone()], &other.state().v[range]) < 1e-12, "{what}");
        for (other, place) in others {
            assert_eq!(coordinates(&simulation, other), place, "{what}: {other}");
        }
    }
}

/// What is tied to something awake begins awake, and is told of; where the settings forbid sleep all is awake.
#[test]
fn who_is_awake_from_the_start_is_told() {
    let mut simulation = scene(SCENE);
    certified(&mut simulation);
    let note = simulation.workspace().start_note(simulation.model(), simulation.settings()).unwrap();
    assert!(note.contains("begin awake") && note.ends_with("'lamp'"), "{note}");
    assert!(!sleeps(&simulation, "lamp") && sleeps(&simulation, "arm"));
    let settings = Settings::default().with_sleeping(false);
    let mut all_awake = Simulation::new(scene(SCENE).model().clone(), settings).unwrap();
    all_awake.input = simulation.input.clone();
    assert!(part_from_here(&mut all_awake, 20) < 1e-12);
    assert!(all_awake.state().v[2] < -0.3, "it falls");
}

/// A body that is moved from outside wakes what it comes to, and nothing else.
#[test]
fn what_is_moved_from_outside_wakes_what_it_touches() {
    let hand = "<body name='mocap' mocap='true' pos='-1 0 3'><geom type='box' size='.1 .1 .1'/></body>";
    let mut simulation = scene(&SCENE.replace("</worldbody>", &format!("{hand}</worldbody>")));
    let at = |x: f64, z: f64| vec![Pose::from_position(DVec3::new(x, 0.0, z))];
    for (place, is_there) in [(at(-1.0, 3.0), false), (at(-0.5, 1.0), false), (at(-0.19, 1.1), true)] {
        simulation.input.mocap = place;
        certified(&mut simulation);
        let asleep = ["low", "high", "arm"].map(|name| sleeps(&simulation, name));
        assert_eq!(asleep, [!is_there, !is_there, true]);
    }
}

/// A run that is stored and taken up again goes on with the same bits, and recordings of it are certified again.
#[test]
fn it_is_the_state_that_says_who_sleeps() {
    let mut simulation = scene(SCENE);
    for _ in 0..30 {
        certified(&mut simulation);
    }
    let mut later = scene(SCENE);
    later.set_state(simulation.state()).unwrap();
    later.set_warm_start(&simulation.workspace().warm_start()).unwrap();
    for _ in 0..150 {
        certified(&mut simulation);
        certified(&mut later);
        assert_eq!(bits(later.state()), bits(simulation.state()));
    }
    crate::recertify::shows_the_same(scene(SCENE), 150, "trees that begin asleep");
}
