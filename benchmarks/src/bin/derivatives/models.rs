//! Robots and mechanisms whose derivatives are compared with differences.

use std::error::Error;
use std::path::Path;

use signorini::multibody::glam::DVec3;
use signorini::multibody::{
    BodyId, Geom, Geometry, Input, Kinematics, Model, ModelBuilder, ModelError, Pose, State, forward_kinematics_into,
};
use signorini_benchmarks::derivative_scenes;
use signorini_benchmarks::robots::{ROBOTS, a1_on_its_feet, held, load_above_floor};
use signorini_formats::load_mjcf_str;
use signorini_testkit::Random;

use crate::bench::Bench;

/// A model, where it begins, and how far its states are disturbed.
pub struct Subject {
    pub name: &'static str,
    pub bench: Bench,
    pub state: State,
    pub input: Input,
    /// Sizes of random changes of `q`, `v` and `u`.
    pub sizes: [f64; 3],
}

impl Subject {
    fn bundled(name: &'static str, text: &str, sizes: [f64; 3]) -> Result<Self, Box<dyn Error>> {
        Self::new(name, load_mjcf_str(text, ".")?.model, sizes)
    }

    fn new(name: &'static str, mut model: Model, sizes: [f64; 3]) -> Result<Self, Box<dyn Error>> {
        tell_geoms_apart(&mut model);
        let bench = Bench::new(model)?;
        let (state, input) = bench.start();
        Ok(Self { name, bench, state, input, sizes })
    }
}

/// The subjects that there are: those of published robots where their folder is given.
pub fn all(robots: Option<&Path>) -> Result<Vec<Subject>, Box<dyn Error>> {
    let gripper = signorini_scenes::named("gripper").ok_or("there is no scene of a gripper")?;
    let four_bar = include_str!("../../../../crates/derivatives/testdata/four_bar.xml");
    let humanoid = include_str!("../../../derivatives/humanoid.xml");
    let mut subjects = vec![
        Subject::bundled("humanoid", humanoid, [1e-4, 0.05, 0.1])?,
        Subject::bundled("gripper", gripper.text, [3e-5, 0.02, 0.5])?,
        Subject::bundled("four-bar loop", four_bar, [1e-5, 0.02, 0.1])?,
        pile()?,
    ];
    if let Some(folder) = robots {
        subjects.push(Subject::new("A1", a1_on_its_feet(folder)?, [1e-4, 0.05, 0.05])?);
        subjects.push(panda(folder)?);
    }
    Ok(subjects)
}

/// Gives every geom its own friction, rolling and spinning included, and restitution: of two that are equal neither alone has a derivative.
fn tell_geoms_apart(model: &mut Model) {
    let mut random = Random::new(2);
    for geom in model.geoms.iter_mut().filter(|geom| geom.friction > 0.0) {
        geom.friction *= random.between(0.9, 1.1);
        geom.spinning_friction = random.between(0.001, 0.004);
        geom.rolling_friction = random.between(0.0002, 0.001);
        geom.restitution = random.between(0.05, 0.2);
    }
}

/// A pile that has fallen and goes on to settle.
fn pile() -> Result<Subject, Box<dyn Error>> {
    let model = derivative_scenes::pile(&mut Random::new(1), 20)?;
    let mut pile = Subject::new("pile of 20", model, [1e-5, 0.05, 0.0])?;
    for _ in 0..400 {
        pile.state = pile.bench.step(&pile.state, &pile.input).ok_or("a pile that cannot go on")?.0;
    }
    Ok(pile)
}

/// A Panda that holds a box between its fingers.
fn panda(folder: &Path) -> Result<Subject, Box<dyn Error>> {
    let robot = ROBOTS.iter().find(|robot| robot.name == "panda").ok_or("there is no Panda")?;
    let arm = load_above_floor(folder, robot, 0.8, false)?.0;
    let mut state = State::new(&arm);
    let posture = [0.0, 0.4, 0.0, -2.0, 0.0, 2.4, 0.785];
    for joint in &arm.joints {
        let number = joint.name.trim_start_matches("panda_joint").parse::<usize>();
        state.q[joint.q_index] = number.map_or(HALF_BOX.y, |k| posture[k - 1]);
    }
    let mut kinematics = Kinematics::new(&arm);
    forward_kinematics_into(&arm, &state.q, &state.v, &mut kinematics);
    let finger = |name: &str| {
        let body = arm.bodies.iter().position(|body| body.name == name).ok_or(format!("there is no {name}"))?;
        Ok::<Pose, String>(kinematics.pose[body])
    };
    let [left, right] = [finger("panda_leftfinger")?, finger("panda_rightfinger")?];
    let middle = 0.5 * (left.position + right.position) + left.rotation * DVec3::new(0.0, 0.0, PADS);
    let place = Pose { position: middle, ..left };
    let mut world = rebuilt(&arm)?;
    let shape = Geom::from(Geometry::Box { half_extents: HALF_BOX }).with_friction(0.9);
    world.body("box").at(place).free().solid(shape, 0.2).add()?;
    let model = world.build()?;
    let mut with_box = State::new(&model);
    with_box.q[..state.q.len()].copy_from_slice(&state.q);
    let mut subject = Subject::new("Panda with a box", held(model, with_box, [400.0, 40.0])?, [1e-5, 0.01, 0.002])?;
    // The fingers close, with some 10 N each.
    let fingers = subject.bench.model.actuators.iter().zip(&mut subject.input.control);
    fingers.filter(|(actuator, _)| actuator.name.contains("finger")).for_each(|(_, target)| *target -= 0.025);
    Ok(subject)
}

/// Half-extents of the box that the Panda holds, m.
const HALF_BOX: DVec3 = DVec3::new(0.02, 0.018, 0.02);
/// How far the pads of the fingers are from the frames of these, m.
const PADS: f64 = 0.045;

/// A builder with the parts of a robot, for more to be added.
fn rebuilt(model: &Model) -> Result<ModelBuilder, ModelError> {
    let mut world = ModelBuilder::new(&*model.name);
    world.gravity(model.gravity).timestep(model.timestep);
    for (i, body) in model.bodies.iter().enumerate().skip(1) {
        let id = world.add_body(&*body.name, body.parent, body.placement, body.inertia)?;
        debug_assert_eq!(id, BodyId(i as u32));
        for joint in &model.joints[body.first_joint..body.first_joint + body.joint_count] {
            world.add_joint(id, joint.clone())?;
        }
    }
    for geom in &model.geoms {
        world.add_geom(geom.body, geom.clone())?;
    }
    for equality in &model.equalities {
        world.add_equality(&*equality.name, equality.kind);
    }
    for actuator in &model.actuators {
        world.add_actuator(actuator.clone());
    }
    Ok(world)
}
