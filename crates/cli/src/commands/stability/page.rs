//! A page that shows a verdict: forces, friction use, the collapse as an animation, margins.

use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};
use signorini::multibody::glam::DVec3;
use signorini::multibody::{Geometry, Input, Kinematics, Model, Pose, State, forward_kinematics_into};

use crate::error::CliError;
use crate::results::StabilityResult;

/// The page, with a place for the data.
const PAGE: &str = include_str!("../../../assets/stability.html");
/// The place.
const PLACE: &str = "\"DATA\"";

/// A geom in world.
#[derive(Serialize)]
struct Shape {
    /// Index of the body.
    body: usize,
    position: [f64; 3],
    /// w, x, y, z.
    rotation: [f64; 4],
    shape: Value,
}

/// Writes the page.
pub fn write(
    path: &Path,
    model: &Model,
    state: &State,
    input: &Input,
    result: &StabilityResult,
) -> Result<(), CliError> {
    let mut kinematics = Kinematics::new(model);
    kinematics.place_mocap(model, input);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let shape = |geom: &signorini::multibody::Geom| {
        let Pose { position, rotation: r } = kinematics.pose[geom.body.index()] * geom.placement;
        let (body, position) = (geom.body.index(), position.to_array());
        Shape { body, position, rotation: [r.w, r.x, r.y, r.z], shape: of(&geom.geometry) }
    };
    let shapes: Vec<Shape> = model.geoms.iter().map(shape).collect();
    let body = |k: usize| json!({"name": model.bodies[k].name, "origin": kinematics.pose[k].position.to_array()});
    let bodies: Vec<Value> = (0..model.bodies.len()).map(body).collect();
    let down = model.gravity.try_normalize().unwrap_or(-DVec3::Z).to_array();
    let data = json!({"result": result, "bodies": bodies, "shapes": shapes, "down": down});
    // Text of a model must not end the script that it stands in.
    let data = data.to_string().replace('<', "\\u003c");
    let page = PAGE.replacen(PLACE, &data, 1);
    signorini_files::write(path, page.as_bytes()).map_err(|source| CliError::Write { path: path.to_owned(), source })
}

fn of(geometry: &Geometry) -> Value {
    match geometry {
        Geometry::Plane => json!({"plane": true}),
        Geometry::Sphere { radius } => json!({"ball": [radius, radius, radius]}),
        Geometry::Ellipsoid { semi_axes } => json!({"ball": semi_axes.to_array()}),
        Geometry::Box { half_extents } => json!({"box": half_extents.to_array()}),
        Geometry::Capsule { radius, half_length } => json!({"turned": [[radius, -half_length], [radius, half_length]]}),
        Geometry::Cylinder { radius, half_length } => {
            json!({"turned": [[radius, -half_length], [radius, half_length]]})
        }
        Geometry::Cone { radius, half_length } => json!({"turned": [[radius, -half_length], [0, half_length]]}),
        Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh) => {
            let vertices: Vec<[f64; 3]> = mesh.vertices.iter().map(|p| p.to_array()).collect();
            json!({"vertices": vertices, "triangles": mesh.triangles})
        }
        Geometry::HeightField(_) => json!({}),
    }
}
