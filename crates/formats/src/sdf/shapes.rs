//! `<collision>` shapes, coloured as the link's `<visual>`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{BodyId, Geom, Geometry, Pose};

use super::{Importer, values};
use crate::error::FormatError;
use crate::shapes::leave_out_if_flat;
use crate::xml::Element;
use crate::{mesh, packages};

/// Meshes of a file, and where it looks for them.
pub(super) struct Shapes {
    meshes: HashMap<(PathBuf, [u64; 3]), Arc<Mesh>>,
    base: PathBuf,
    package_dirs: Vec<PathBuf>,
}

impl Shapes {
    pub fn new(base: &Path, package_dirs: &[PathBuf]) -> Self {
        Self { meshes: HashMap::new(), base: base.to_owned(), package_dirs: package_dirs.to_owned() }
    }
}

/// Adds the collision shapes of a link to its body.
pub(super) fn read(importer: &mut Importer, link: Element, body: BodyId) -> Result<(), FormatError> {
    let rgba = colour(link);
    for collision in link.children_named("collision") {
        let Some((geometry, turn)) = geometry(importer, collision)? else { continue };
        if leave_out_if_flat(&mut importer.report, collision, &geometry) {
            continue;
        }
        geometry.check().map_err(|reason| collision.invalid(format!("{}: {reason}", geometry.kind_name())))?;
        let mut geom = Geom::new("", geometry);
        let placement = values::pose(collision)? * Pose::new(DVec3::ZERO, turn);
        geom.placement = Pose::new(placement.position, placement.rotation.normalize());
        geom.rgba = rgba.unwrap_or(geom.rgba);
        if let Some(relative) = relative_to(collision, link) {
            return Err(collision.invalid(format!("a pose relative to '{relative}': give it relative to its link")));
        }
        let ode = collision.child("surface").and_then(|s| s.child("friction")).and_then(|f| f.child("ode"));
        if let Some(mu) = ode.map_or(Ok(None), |ode| friction(importer, ode))? {
            geom.friction = mu;
        }
        let given = collision.attributes().text("name").filter(|n| !n.is_empty());
        let name = importer.parts.unused_geom_name(given.unwrap_or("collision"));
        importer.parts.add_geom(collision, Some(name), body, geom)?;
    }
    Ok(())
}

/// `<mu>`. A negative one, which Gazebo takes for a bound that is never reached, is reported and does not count.
fn friction(importer: &mut Importer, ode: Element) -> Result<Option<f64>, FormatError> {
    let mu = values::number(ode, "mu")?;
    let Some(element) = ode.child("mu").filter(|_| mu.is_some_and(|mu| mu < 0.0)) else { return Ok(mu) };
    let effect =
        "the friction is the default, 1: give the coefficient (Gazebo takes a negative one for 'without bound')";
    importer.report.motion(element.at(), "mu", "is negative", effect);
    Ok(None)
}

/// What the pose of a collision is relative to, if not to its link.
fn relative_to<'t>(collision: Element<'t>, link: Element<'t>) -> Option<&'t str> {
    let pose = collision.child("pose")?.attributes();
    let given = pose.text("relative_to").or(pose.text("frame")).filter(|n| !n.is_empty())?;
    (link.attributes().text("name") != Some(given)).then_some(given)
}

/// The shape and how it is turned in the collision's frame; none if it is of a sort that is not supported.
fn geometry(importer: &mut Importer, collision: Element) -> Result<Option<(Geometry, DQuat)>, FormatError> {
    let shape = collision.child("geometry").and_then(|g| g.children().next());
    let shape = shape.ok_or_else(|| collision.incomplete("<geometry> with a shape"))?;
    let size =
        |name: &'static str| values::number(shape, name)?.ok_or_else(|| shape.incomplete(format!("<{name}>, m")));
    let vector = |name: &'static str| {
        values::vec3(shape, name)?.ok_or_else(|| shape.incomplete(format!("<{name}>: three lengths, m")))
    };
    let upright = |geometry| Ok(Some((geometry, DQuat::IDENTITY)));
    match shape.name() {
        "box" => upright(Geometry::Box { half_extents: vector("size")? / 2.0 }),
        "sphere" => upright(Geometry::Sphere { radius: size("radius")? }),
        "cylinder" => upright(Geometry::Cylinder { radius: size("radius")?, half_length: size("length")? / 2.0 }),
        "capsule" => upright(Geometry::Capsule { radius: size("radius")?, half_length: size("length")? / 2.0 }),
        "cone" => upright(Geometry::Cone { radius: size("radius")?, half_length: size("length")? / 2.0 }),
        "ellipsoid" => upright(Geometry::Ellipsoid { semi_axes: vector("radii")? }),
        "plane" => {
            let normal = values::direction(shape, "normal", DVec3::Z)?;
            Ok(Some((Geometry::Plane, DQuat::from_rotation_arc(DVec3::Z, normal))))
        }
        "mesh" => Ok(mesh_geometry(importer, shape)?.map(|geometry| (geometry, DQuat::IDENTITY))),
        "empty" => Ok(None),
        other => {
            let what = format!("shape '{}' is not supported", other.chars().take(40).collect::<String>());
            importer.report.motion(shape.at(), "geometry", what, "the shape is left out: nothing touches it");
            Ok(None)
        }
    }
}

/// A mesh as its convex hull.
fn mesh_geometry(importer: &mut Importer, shape: Element) -> Result<Option<Geometry>, FormatError> {
    let uri = shape.child("uri").ok_or_else(|| shape.incomplete("<uri>: the mesh file"))?;
    let shapes = &mut importer.shapes;
    let path = packages::resolve(uri.text(), &shapes.base, &shapes.package_dirs);
    if !mesh::is_supported(&path) {
        let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
        let what = format!("mesh format '{extension}' is not supported");
        let effect = "the shape is left out: nothing touches it; convert the file to STL, OBJ or COLLADA";
        importer.report.motion(uri.at(), "mesh", what, effect);
        return Ok(None);
    }
    let scale = values::scale(shape, "scale")?;
    let key = (path, scale.to_array().map(f64::to_bits));
    if let Some(mesh) = shapes.meshes.get(&key) {
        return Ok(Some(Geometry::ConvexMesh(mesh.clone())));
    }
    let asset = |reason| {
        let (at, path) = (uri.at(), key.0.clone());
        FormatError::Asset { at, element: "mesh".into(), path, reason }
    };
    let mesh = Arc::new(mesh::scaled(mesh::load(&key.0).map_err(asset)?, scale));
    shapes.meshes.insert(key, mesh.clone());
    Ok(Some(Geometry::ConvexMesh(mesh)))
}

/// The diffuse colour of the link's first visual that has one. Only pictures depend on it: one that cannot be read is noted.
fn colour(link: Element) -> Option<[f32; 4]> {
    let materials = link.children_named("visual").filter_map(|v| v.child("material"));
    let diffuse = materials.filter_map(|m| m.child("diffuse")).next()?;
    let numbers: Vec<f32> = diffuse.text().split_ascii_whitespace().filter_map(|w| w.parse().ok()).collect();
    match numbers[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => {
            let effect = "it is passed over: write red, green, blue, opacity";
            diffuse.note(diffuse.at(), "is not a colour", effect, false);
            None
        }
    }
}
