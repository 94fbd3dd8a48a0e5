//! Shapes and forces as Foxglove draws them.

use serde_json::{Value, json};
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_recording::{Frame, GeomVisual, Header, PoseArray, ShapeVisual};

use super::messages::{norm, quaternion, vector};
use super::stamp::Stamp;
use crate::export::parts::force;

/// Planes end in pictures, m.
const PLANE_SIZE: f64 = 20.0;
const PLANE_THICKNESS: f64 = 0.01;
/// Colour of shapes without one, and of forces.
const GREY: [f32; 4] = [0.6, 0.6, 0.65, 1.0];
const FORCE_COLOR: [f32; 4] = [0.9, 0.3, 0.1, 1.0];

/// The shapes of all bodies: one entity for each body that has some, which follows the body's frame.
pub fn shapes(header: &Header, stamp: Stamp) -> Value {
    let bodies = header.bodies.iter().enumerate();
    let entities = bodies.filter_map(|(body, name)| {
        let mut primitives = Primitives::default();
        header.geoms.iter().filter(|geom| geom.body == body).for_each(|geom| primitives.add(geom));
        (!primitives.is_empty()).then(|| primitives.into_entity(name, name, stamp))
    });
    json!({ "deletions": [], "entities": entities.collect::<Vec<_>>() })
}

/// An arrow for each contact that pushes; they replace those of the step before.
///
/// - `scale`: m per N
pub fn forces(header: &Header, frame: &Frame, stamp: Stamp, scale: f64) -> Value {
    let mut primitives = Primitives::default();
    for contact in &frame.contacts {
        let force = force(contact, header.timestep);
        let length = scale * norm(force);
        if length.is_finite() && length > 0.0 {
            let turn = DQuat::from_rotation_arc(DVec3::X, DVec3::from(force).normalize());
            let head = 0.3 * length;
            primitives.arrows.push(json!({
                "pose": pose(contact.point.into(), turn),
                "shaft_length": length - head, "shaft_diameter": 0.06 * length,
                "head_length": head, "head_diameter": 0.12 * length,
                "color": color(FORCE_COLOR),
            }));
        }
    }
    json!({ "deletions": [], "entities": [primitives.into_entity("contact forces", &header.bodies[0], stamp)] })
}

/// The primitives of an entity.
#[derive(Default)]
struct Primitives {
    arrows: Vec<Value>,
    cubes: Vec<Value>,
    spheres: Vec<Value>,
    cylinders: Vec<Value>,
    triangles: Vec<Value>,
}

impl Primitives {
    fn is_empty(&self) -> bool {
        [&self.arrows, &self.cubes, &self.spheres, &self.cylinders, &self.triangles].iter().all(|list| list.is_empty())
    }

    /// Adds a shape; the frame of the entity is that of its body.
    fn add(&mut self, geom: &GeomVisual) {
        let color = color(geom.rgba.unwrap_or(GREY));
        let at = |z: f64| raised(&geom.pose, z);
        let bounded = |z: f64, size: [f64; 3]| json!({ "pose": at(z), "size": vector(size), "color": color });
        let mut cylinder = |radius: f64, half: f64, top: f64| {
            let mut shape = bounded(0.0, [2.0 * radius, 2.0 * radius, 2.0 * half]);
            (shape["bottom_scale"], shape["top_scale"]) = (json!(1.0), json!(top));
            self.cylinders.push(shape);
        };
        match &geom.shape {
            ShapeVisual::Plane => {
                let size = [PLANE_SIZE, PLANE_SIZE, PLANE_THICKNESS];
                self.cubes.push(bounded(-PLANE_THICKNESS / 2.0, size));
            }
            ShapeVisual::Sphere { radius } => self.spheres.push(bounded(0.0, [2.0 * radius; 3])),
            ShapeVisual::Box { half_extents } => self.cubes.push(bounded(0.0, half_extents.map(|h| 2.0 * h))),
            ShapeVisual::Capsule { radius, half_length } => {
                cylinder(*radius, *half_length, 1.0);
                for z in [-half_length, *half_length] {
                    self.spheres.push(bounded(z, [2.0 * radius; 3]));
                }
            }
            ShapeVisual::Cylinder { radius, half_length } => cylinder(*radius, *half_length, 1.0),
            ShapeVisual::Cone { radius, half_height } => cylinder(*radius, *half_height, 0.0),
            ShapeVisual::Ellipsoid { radii } => self.spheres.push(bounded(0.0, radii.map(|r| 2.0 * r))),
            ShapeVisual::Mesh { vertices, faces } => {
                let points = vertices.iter().map(|p| p.map(f64::from)).collect();
                self.triangles.push(triangles(at(0.0), points, faces.as_flattened().to_vec(), color));
            }
            ShapeVisual::HeightField { half_extents, rows, cols, heights } => {
                let points = grid(*half_extents, *rows, *cols, heights);
                self.triangles.push(triangles(at(0.0), points, grid_faces(*rows, *cols), color));
            }
            _ => {}
        }
    }

    fn into_entity(self, id: &str, frame: &str, stamp: Stamp) -> Value {
        json!({
            "timestamp": stamp.to_json(), "frame_id": frame, "id": id, "lifetime": { "sec": 0, "nsec": 0 },
            "frame_locked": true, "metadata": [], "arrows": self.arrows, "cubes": self.cubes, "spheres": self.spheres,
            "cylinders": self.cylinders, "lines": [], "triangles": self.triangles, "texts": [], "models": [],
        })
    }
}

fn color([r, g, b, a]: [f32; 4]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": a })
}

fn pose(position: DVec3, turn: DQuat) -> Value {
    json!({
        "position": vector(position.to_array()),
        "orientation": quaternion([turn.w, turn.x, turn.y, turn.z]),
    })
}

/// A pose, moved by `z` along its own third axis.
fn raised(&[x, y, z, qw, qx, qy, qz]: &PoseArray, along: f64) -> Value {
    let turn = DQuat::from_xyzw(qx, qy, qz, qw);
    pose(DVec3::new(x, y, z) + turn * (along * DVec3::Z), turn)
}

fn triangles(pose: Value, points: Vec<[f64; 3]>, indices: Vec<u32>, color: Value) -> Value {
    let points: Vec<Value> = points.into_iter().map(vector).collect();
    json!({ "pose": pose, "points": points, "color": color, "colors": [], "indices": indices })
}

/// The grid points of a height field, row by row.
fn grid([hx, hy]: [f64; 2], rows: usize, cols: usize, heights: &[f32]) -> Vec<[f64; 3]> {
    let along = |half: f64, i: usize, count: usize| half * (2.0 * i as f64 / (count.max(2) - 1) as f64 - 1.0);
    let points = heights.iter().take(rows * cols).enumerate();
    points.map(|(i, height)| [along(hx, i % cols, cols), along(hy, i / cols, rows), f64::from(*height)]).collect()
}

/// Two triangles for each cell, counter-clockwise seen from above.
fn grid_faces(rows: usize, cols: usize) -> Vec<u32> {
    let cells =
        (0..rows.saturating_sub(1)).flat_map(|row| (0..cols.saturating_sub(1)).map(move |col| row * cols + col));
    let faces = cells.flat_map(|i| [i, i + 1, i + cols + 1, i, i + cols + 1, i + cols]);
    faces.map(|i| i as u32).collect()
}
