//! Scenes of a JSON file (`benchmarks/sim/scenes.py`): every body explicit, the same numbers for every engine. And fields of
//! stacks of any size.
//!
//! A scene has `gravity`, `mu`, `dt`, `duration`, `planes` as `[nx, ny, nz, offset]`, `bodies` as `["b" or "s", three
//! half-sizes, mass, position, quaternion wxyz]`, `joints` (`hinge` or `slider` with bodies `a`, `b`, world `anchor`, `axis`),
//! constant world `forces` as `[body, fx, fy, fz]`, `collide`, and where bodies move at the beginning their `velocities`, linear and
//! angular in world axes. Instead of bodies a robot's scene has the name of an MJCF file.

use std::path::Path;

use serde_json::Value;
use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{
    BodyId, Geom, Geometry, Inertia, Input, Joint, JointKind, Model, ModelBuilder, ModelError, Pose,
};
use signorini_formats::{LoadOptions, load};

/// A scene as a model with what acts on it.
pub struct Scene {
    /// The model.
    pub model: Model,
    /// Constant forces.
    pub input: Input,
    /// Length of the run, s.
    pub duration: f64,
    /// Velocity at the beginning `[nv]`, where it is not zero.
    pub velocity: Option<Vec<f64>>,
}

/// Builds a scene; `robots` is the folder with the model files that scenes name.
///
/// # Errors
/// What is missing or malformed, as a sentence.
pub fn build(name: &str, scene: &Value, robots: &Path) -> Result<Scene, String> {
    if let Some(file) = scene["mjcf"].as_str() {
        return load_robot(name, scene, &robots.join(file));
    }
    let bodies = scene["bodies"].as_array().ok_or(format!("{name}: no bodies"))?;
    let mut builder = ModelBuilder::new(name);
    builder.gravity(vector(&scene["gravity"])?).timestep(number(&scene["dt"])?);
    let friction = number(&scene["mu"])?;
    let collide = scene["collide"].as_bool().unwrap_or(true);
    let text = |e: ModelError| format!("{name}: {e}");
    for (k, plane) in scene["planes"].as_array().into_iter().flatten().enumerate() {
        let normal = vector(plane)?;
        let mut geom = Geom::new(format!("plane{k}"), Geometry::Plane);
        geom.placement = Pose::new(normal * number(&plane[3])?, DQuat::from_rotation_arc(DVec3::Z, normal));
        geom.friction = friction;
        builder.add_geom(BodyId::WORLD, geom).map_err(text)?;
    }
    let joints = scene["joints"].as_array().cloned().unwrap_or_default();
    let mut ids = Vec::new();
    for (k, row) in bodies.iter().enumerate() {
        let joint = joints.iter().find(|j| j["b"].as_u64() == Some(k as u64));
        let id = add_body(&mut builder, k, row, joint, &ids).map_err(|e| format!("{name}: {e}"))?;
        let mut geom = Geom::new(format!("geom{k}"), shape(row)?);
        geom.friction = friction;
        if !collide {
            (geom.contact_type, geom.contact_affinity) = (0, 0);
        }
        builder.add_geom(id.0, geom).map_err(text)?;
        ids.push(id);
    }
    let model = builder.build().map_err(text)?;
    let input = forces(&model, scene, &joints)?;
    let velocity = scene["velocities"].as_array().map(|rows| velocity(bodies, rows)).transpose()?;
    if velocity.as_ref().is_some_and(|v| v.len() != model.nv) {
        return Err(format!("{name}: velocities are of free bodies, one row for each"));
    }
    Ok(Scene { model, input, duration: number(&scene["duration"])?, velocity })
}

fn load_robot(name: &str, scene: &Value, file: &Path) -> Result<Scene, String> {
    let mut model = load(file, &LoadOptions::default()).map_err(|e| format!("{name}: {e}"))?.model;
    model.timestep = number(&scene["dt"])?;
    let input =
        Input::default().with_control(vec![0.0; model.actuators.len()]).with_generalized_force(vec![0.0; model.nv]);
    Ok(Scene { model, input, duration: number(&scene["duration"])?, velocity: None })
}

/// Velocity of free bodies from rows in world axes: the angular one in the body's.
fn velocity(bodies: &[Value], rows: &[Value]) -> Result<Vec<f64>, String> {
    let mut velocity = Vec::with_capacity(6 * rows.len());
    for (body, row) in bodies.iter().zip(rows) {
        let at = |k: usize| number(&row[k]);
        let spin = pose(body)?.rotation.inverse() * DVec3::new(at(3)?, at(4)?, at(5)?);
        velocity.extend([at(0)?, at(1)?, at(2)?, spin.x, spin.y, spin.z]);
    }
    Ok(velocity)
}

/// A field of stacks on a plane, far enough apart to be islands of their own: `stacks` of `height` cubes of 0.2 m and 1 kg,
/// turned against each other about the vertical, the lowest 1 mm above the plane and each 1 mm above the one below. Friction
/// 0.5, Δt 5 ms.
///
/// # Errors
/// [`ModelError`] if the model is refused.
pub fn field(stacks: usize, height: usize) -> Result<Model, ModelError> {
    let (half, gap, distance) = (0.1, 0.001, 0.5);
    let moments = DVec3::splat(half * half * 2.0 / 3.0);
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(moments) };
    let mut builder = ModelBuilder::new(format!("field of {stacks} x {height}"));
    builder.gravity(DVec3::NEG_Z * 9.81).timestep(0.005);
    let frictional = |name: String, shape: Geometry| Geom::new(name, shape).with_friction(0.5);
    builder.add_geom(BodyId::WORLD, frictional("plane".into(), Geometry::Plane))?;
    let columns = (stacks as f64).sqrt().ceil() as usize;
    for k in 0..stacks {
        for level in 0..height {
            let (x, y) = ((k % columns) as f64 * distance, (k / columns) as f64 * distance);
            let position = DVec3::new(x, y, half + gap + (2.0 * half + gap) * level as f64);
            let turn = DQuat::from_rotation_z(0.05 * ((k + 3 * level) % 7) as f64);
            let name = format!("cube{k}_{level}");
            let body = builder.add_body(name.clone(), BodyId::WORLD, Pose::new(position, turn), inertia)?;
            builder.add_joint(body, Joint::new(name.clone(), JointKind::Free))?;
            builder.add_geom(body, frictional(name, Geometry::Box { half_extents: DVec3::splat(half) }))?;
        }
    }
    builder.build()
}

fn number(value: &Value) -> Result<f64, String> {
    value.as_f64().ok_or(format!("expected a number, found {value}"))
}

fn vector(value: &Value) -> Result<DVec3, String> {
    Ok(DVec3::new(number(&value[0])?, number(&value[1])?, number(&value[2])?))
}

fn sizes(row: &Value) -> Result<DVec3, String> {
    Ok(DVec3::new(number(&row[1])?, number(&row[2])?, number(&row[3])?))
}

fn shape(row: &Value) -> Result<Geometry, String> {
    let size = sizes(row)?;
    match row[0].as_str() {
        Some("b") => Ok(Geometry::Box { half_extents: size }),
        Some("s") => Ok(Geometry::Sphere { radius: size.x }),
        other => Err(format!("unknown shape {other:?}")),
    }
}

/// World pose of a body's row.
fn pose(row: &Value) -> Result<Pose, String> {
    let at = |k: usize| number(&row[k]);
    let rotation = DQuat::from_xyzw(at(9)?, at(10)?, at(11)?, at(8)?).normalize();
    Ok(Pose::new(DVec3::new(at(5)?, at(6)?, at(7)?), rotation))
}

fn add_body(
    builder: &mut ModelBuilder,
    k: usize,
    row: &Value,
    joint: Option<&Value>,
    earlier: &[(BodyId, Pose)],
) -> Result<(BodyId, Pose), String> {
    let (world, mass, s) = (pose(row)?, number(&row[4])?, sizes(row)?);
    let moments = match row[0].as_str() {
        Some("b") => DVec3::new(s.y * s.y + s.z * s.z, s.x * s.x + s.z * s.z, s.x * s.x + s.y * s.y) * (mass / 3.0),
        _ => DVec3::splat(0.4 * mass * s.x * s.x),
    };
    let inertia = Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(moments) };
    let parent = joint.and_then(|j| j["a"].as_u64()).map(|a| earlier[a as usize]);
    let (parent, parent_pose) = parent.unwrap_or((BodyId::WORLD, Pose::IDENTITY));
    let text = |e: ModelError| e.to_string();
    let id = builder.add_body(format!("body{k}"), parent, parent_pose.inverse() * world, inertia).map_err(text)?;
    let kind = match joint {
        None => Joint::new(format!("joint{k}"), JointKind::Free),
        Some(j) => {
            let axis = world.rotation.conjugate() * vector(&j["axis"])?;
            let hinge = j["type"] == "hinge";
            let kind = if hinge { JointKind::Hinge { axis } } else { JointKind::Slide { axis } };
            let mut joint = Joint::new(format!("joint{k}"), kind);
            joint.anchor = world.inverse().transform_point(vector(&j["anchor"])?);
            joint
        }
    };
    builder.add_joint(id, kind).map_err(text)?;
    Ok((id, world))
}

/// Constant forces on free bodies and along sliders.
fn forces(model: &Model, scene: &Value, joints: &[Value]) -> Result<Input, String> {
    let mut input = Input::default().with_control(Vec::new()).with_generalized_force(vec![0.0; model.nv]);
    for row in scene["forces"].as_array().into_iter().flatten() {
        let k = row[0].as_u64().ok_or("a force needs its body")? as usize;
        let force = DVec3::new(number(&row[1])?, number(&row[2])?, number(&row[3])?);
        let joint = &model.joints[k];
        match joints.iter().find(|j| j["b"].as_u64() == Some(k as u64)) {
            Some(j) => input.generalized_force[joint.v_index] += force.dot(vector(&j["axis"])?),
            None => {
                for (a, f) in force.to_array().into_iter().enumerate() {
                    input.generalized_force[joint.v_index + a] += f;
                }
            }
        }
    }
    Ok(input)
}
