//! `<collision>` shapes, coloured as the link's `<visual>`.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{BodyId, Geom, GeomId, Geometry, Pose};

use super::frames::Frames;
use super::importer::Importer;
use super::values;
use crate::error::FormatError;
use crate::mesh::Part;
use crate::mesh_store::Named;
use crate::shapes::leave_out_if_flat;
use crate::xml::Element;

/// A collision shape before meshes are taken apart.
pub(super) struct Solid<'t> {
    pub collision: Element<'t>,
    pub geometry: Geometry,
    /// In the body of the link.
    pub placement: Pose,
}

/// What the collision shapes of a link have become.
pub(super) struct Shapes<'t> {
    pub touching: Vec<GeomId>,
    pub solids: Vec<Solid<'t>>,
}

/// Adds the collision shapes of a link to its body, in which the link stands at `offset`.
pub(super) fn read<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    entity: usize,
    body: BodyId,
    offset: &Pose,
) -> Result<Shapes<'t>, FormatError> {
    let link = frames.entities[entity].element;
    let rgba = colour(link);
    let mut shapes = Shapes { touching: Vec::new(), solids: Vec::new() };
    for collision in link.children_named("collision") {
        let Some((geometry, turn)) = geometry(importer, collision)? else { continue };
        if leave_out_if_flat(&mut importer.report, collision, &geometry) {
            continue;
        }
        geometry.check().map_err(|reason| collision.invalid(format!("{}: {reason}", geometry.kind_name())))?;
        let mut geom = Geom::new("", geometry);
        let base = base_of(frames, entity, collision)?;
        let placement = *offset * base * values::pose(collision)? * Pose::new(DVec3::ZERO, turn);
        geom.placement = Pose::new(placement.position, placement.rotation.normalize());
        geom.rgba = rgba.unwrap_or(geom.rgba);
        let ode = collision.child("surface").and_then(|s| s.child("friction")).and_then(|f| f.child("ode"));
        if let Some(mu) = ode.map_or(Ok(None), |ode| friction(importer, ode))? {
            geom.friction = mu;
        }
        let mask = mask(importer, collision)?;
        (geom.contact_type, geom.contact_affinity) = (mask, mask);
        let given = collision.attributes().text("name").filter(|n| !n.is_empty());
        for geometry in importer.parts.convex_parts(&mut importer.report, collision, geom.geometry.clone()) {
            let name = importer.parts.unused_geom_name(given.unwrap_or("collision"));
            let mut part = geom.clone();
            part.geometry = geometry;
            shapes.touching.push(importer.parts.add_geom(collision, Some(name), body, part)?);
        }
        shapes.solids.push(Solid { collision, geometry: geom.geometry, placement: geom.placement });
    }
    Ok(shapes)
}

/// What a collision touches: `<collide_bitmask>`, or nothing where it is to be found and not felt.
fn mask(importer: &Importer, collision: Element) -> Result<u32, FormatError> {
    let Some(contact) = collision.child("surface").and_then(|surface| surface.child("contact")) else {
        return Ok(importer.common_mask);
    };
    if values::flag(contact, "collide_without_contact")?.unwrap_or(false) {
        return Ok(0);
    }
    Ok(values::bits(contact, "collide_bitmask")?.unwrap_or(importer.common_mask))
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

/// The frame, in the link, that the pose of a collision or visual is relative to.
pub(super) fn base_of<'t>(frames: &Frames<'t>, link: usize, collision: Element<'t>) -> Result<Pose, FormatError> {
    let pose = collision.child("pose").map(|pose| pose.attributes());
    let given = pose.and_then(|a| a.text("relative_to").or(a.text("frame"))).filter(|n| !n.is_empty());
    if given.is_none() || frames.entities[link].element.attributes().text("name") == given {
        return Ok(Pose::IDENTITY);
    }
    let here = frames.pose(link);
    Ok(here.inverse() * frames.named_pose(collision, &frames.entities[link].scope, given, here)?)
}

/// The shape and how it is turned in the collision's frame; none if it has none or one of a sort that is not supported.
fn geometry(importer: &mut Importer, collision: Element) -> Result<Option<(Geometry, DQuat)>, FormatError> {
    let shape = collision.child("geometry").and_then(|g| g.children().next());
    let Some(shape) = shape else {
        let effect = "nothing touches it: give it a <geometry> with a shape, or <empty/> if that is meant";
        importer.report.motion(collision.at(), "collision", "has no shape", effect);
        return Ok(None);
    };
    match shape.name() {
        "mesh" => Ok(mesh_geometry(importer, shape)?.map(|geometry| (geometry, DQuat::IDENTITY))),
        "empty" => Ok(None),
        name => {
            let found = primitive(shape)?;
            if found.is_none() {
                let what = format!("shape '{}' is not supported", name.chars().take(40).collect::<String>());
                importer.report.motion(shape.at(), "geometry", what, "the shape is left out: nothing touches it");
            }
            Ok(found)
        }
    }
}

/// A shape that is no mesh, and how it is turned; none if it is of a sort that is not supported.
pub(super) fn primitive(shape: Element) -> Result<Option<(Geometry, DQuat)>, FormatError> {
    // The specification's defaults.
    let radius = if shape.is("capsule") || shape.is("cone") { 0.5 } else { 1.0 };
    let size = |name: &'static str| {
        let default = if name == "radius" { radius } else { 1.0 };
        Ok::<f64, FormatError>(values::number(shape, name)?.unwrap_or(default))
    };
    let vector = |name: &'static str| Ok::<DVec3, FormatError>(values::vec3(shape, name)?.unwrap_or(DVec3::ONE));
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
        _ => Ok(None),
    }
}

/// A mesh as its convex hull.
fn mesh_geometry(importer: &mut Importer, shape: Element) -> Result<Option<Geometry>, FormatError> {
    let uri = shape.child("uri").ok_or_else(|| shape.incomplete("<uri>: the mesh file"))?;
    let scale = values::scale(shape, "scale")?;
    let named = Named { uri: (uri.text(), uri.at()), part: part(shape)?, scale };
    importer.meshes.hull(&mut importer.report, shape, named)
}

/// The part of a mesh that is meant, where not all of it is.
pub(super) fn part(mesh: Element) -> Result<Option<Part>, FormatError> {
    let Some(submesh) = mesh.child("submesh") else { return Ok(None) };
    let name = submesh.child("name").ok_or_else(|| submesh.incomplete("<name>: the part of the mesh"))?;
    let centered = values::flag(submesh, "center")?.unwrap_or(false);
    Ok(Some(Part { name: name.text().to_owned(), centered }))
}

/// The diffuse colour of the link's first visual that has one.
fn colour(link: Element) -> Option<[f32; 4]> {
    let materials = link.children_named("visual").filter_map(|v| v.child("material"));
    rgba(materials.filter_map(|m| m.child("diffuse")).next()?)
}

/// A colour. Only pictures depend on it: one that cannot be read is noted.
pub(super) fn rgba(diffuse: Element) -> Option<[f32; 4]> {
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
