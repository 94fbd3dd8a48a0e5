//! Robots from URDF files above a floor.

use std::error::Error;
use std::path::Path;

use signorini::collision::{Collider, CollisionError, Reach};
use signorini::multibody::{
    ActuatorKind, BodyId, Geom, Geometry, JointKind, Keyframe, Kinematics, Model, State, Transmission,
    forward_kinematics_into,
};
use signorini_formats::{FormatError, ImportReport, LoadOptions, load};

/// A robot that is published as a URDF file.
#[derive(Clone, Copy, Debug)]
pub struct Robot {
    /// What it is called here.
    pub name: &'static str,
    /// Its file in the folder of all robots.
    pub path: &'static str,
    /// Whether its base is free; otherwise it is fixed to the world.
    pub floats: bool,
}

const fn floating(name: &'static str, path: &'static str) -> Robot {
    Robot { name, path, floats: true }
}

/// The robots of the benchmark, as `benchmarks/robots/fetch.py` places them.
pub const ROBOTS: [Robot; 6] = [
    floating("solo12", "solo_description/robots/solo12.urdf"),
    floating("a1", "a1_description/urdf/a1.urdf"),
    floating("go1", "go1_description/urdf/go1.urdf"),
    floating("anymal", "anymal_b_simple_description/robots/anymal.urdf"),
    Robot { name: "panda", path: "panda_description/urdf/panda.urdf", floats: false },
    floating("talos", "talos_data/robots/talos_reduced.urdf"),
];

/// Loads a robot and adds a floor, the plane z = 0 with friction `friction`, as the last geom.
///
/// The convex hulls of a robot's links often overlap where the links themselves do not. Without `self_collision` the
/// robot's shapes meet the floor only.
///
/// # Errors
/// [`FormatError`] if the file cannot be read.
pub fn load_above_floor(
    folder: &Path,
    robot: &Robot,
    friction: f64,
    self_collision: bool,
) -> Result<(Model, ImportReport), FormatError> {
    let options = LoadOptions::default().with_floating_base(robot.floats);
    let mut imported = load(folder.join(robot.path), &options)?;
    let mut floor = Geom::new("floor", Geometry::Plane);
    floor.body = BodyId::WORLD;
    floor.friction = friction;
    if !self_collision {
        imported.model.geoms.iter_mut().for_each(|geom| geom.contact_affinity = 0);
    }
    imported.model.geoms.push(floor);
    Ok((imported.model, imported.report))
}

/// The reference configuration with every joint inside its limits and, if the base floats, the robot's lowest point at
/// `clearance` (m) above the floor.
///
/// # Errors
/// [`CollisionError`] if a shape cannot be prepared.
pub fn state_above_floor(model: &Model, clearance: f64) -> Result<State, CollisionError> {
    placed_above_floor(model, clearance, State::new(model))
}

/// The same in another posture.
///
/// # Errors
/// [`CollisionError`] if a shape cannot be prepared.
pub fn placed_above_floor(model: &Model, clearance: f64, mut state: State) -> Result<State, CollisionError> {
    clamp_to_limits(model, &mut state);
    if let Some(base) = model.joints.iter().find(|j| j.kind == JointKind::Free) {
        state.q[base.q_index + 2] += clearance - lowest_point(model, &state)?;
    }
    Ok(state)
}

/// The A1 over a floor, crouched on its feet, with servos that hold it there: its only keyframe.
///
/// # Errors
/// If its file cannot be read, or is not that of an A1.
pub fn a1_on_its_feet(folder: &Path) -> Result<Model, Box<dyn Error>> {
    let robot = ROBOTS.iter().find(|robot| robot.name == "a1").ok_or("there is no A1")?;
    let model = load_above_floor(folder, robot, 0.8, false)?.0;
    let mut state = State::new(&model);
    for joint in &model.joints {
        let is_of = |names: [&str; 2]| names.iter().any(|name| joint.name.contains(name));
        if is_of(["thigh", "upper"]) {
            state.q[joint.q_index] = 0.8;
        } else if is_of(["calf", "lower"]) {
            state.q[joint.q_index] = -1.6;
        }
    }
    let state = placed_above_floor(&model, 0.0, state)?;
    held(model, state, [60.0, 2.0])
}

/// A robot whose motors are servos that hold a posture, its only keyframe.
///
/// - `gains`: kp (N/m or N·m/rad) and kv (N·s/m or N·m·s/rad) of all
///
/// # Errors
/// If a motor drives something else than a joint.
pub fn held(mut model: Model, posture: State, [kp, kv]: [f64; 2]) -> Result<Model, Box<dyn Error>> {
    let mut control = Vec::new();
    for actuator in &mut model.actuators {
        let Transmission::Joint(joint) = actuator.transmission else {
            return Err(format!("motor '{}' drives no joint", actuator.name).into());
        };
        actuator.kind = ActuatorKind::Position { kp, kv };
        control.push(posture.q[model.joints[joint.index()].q_index]);
    }
    let mut held = Keyframe::new("held", posture.q);
    (held.v, held.control) = (posture.v, control);
    model.keyframes = vec![held];
    Ok(model)
}

/// Puts every joint inside its limits.
pub fn clamp_to_limits(model: &Model, state: &mut State) {
    for joint in &model.joints {
        if let Some([lower, upper]) = joint.limits {
            state.q[joint.q_index] = state.q[joint.q_index].clamp(lower, upper.max(lower));
        }
    }
}

/// Height of the lowest point of all shapes that can meet the floor, m: the collider is asked with a reach so large that
/// no point is left out.
fn lowest_point(model: &Model, state: &State) -> Result<f64, CollisionError> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let reach = vec![Reach { linear: 10.0, angular: 0.0 }; model.bodies.len()];
    let mut points = Vec::new();
    Collider::new(model)?.find(model, &kinematics.pose, &reach, &mut points);
    let floor = model.geoms.len() - 1;
    let on_floor = points.iter().filter(|p| p.geom_b.index() == floor);
    Ok(on_floor.map(|p| p.gap).fold(f64::INFINITY, f64::min))
}

/// Depth of the deepest overlap of two shapes of the model at a state, m (≥ 0), and the names of the two.
///
/// # Errors
/// [`CollisionError`] if a shape cannot be prepared.
pub fn deepest_overlap(model: &Model, state: &State) -> Result<(f64, String), CollisionError> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let reach = vec![Reach { linear: 0.0, angular: 0.0 }; model.bodies.len()];
    let mut points = Vec::new();
    Collider::new(model)?.find(model, &kinematics.pose, &reach, &mut points);
    let name = |id: signorini::multibody::GeomId| model.geoms[id.index()].name.as_str();
    let deepest = points.iter().filter(|p| p.gap < 0.0).min_by(|a, b| a.gap.total_cmp(&b.gap));
    Ok(deepest.map_or((0.0, String::new()), |p| (-p.gap, format!("{} and {}", name(p.geom_a), name(p.geom_b)))))
}
