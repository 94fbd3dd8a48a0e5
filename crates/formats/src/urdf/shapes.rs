//! `<collision>` shapes, coloured as the link's `<visual>`.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Geom, Geometry, Pose};

use super::importer::{Importer, origin};
use super::materials::Materials;
use crate::error::FormatError;
use crate::mesh_store::Named;
use crate::shapes::leave_out_if_flat;
use crate::xml::{Attributes, Element};

/// The colour of the link's first visual that has one.
fn link_colour(materials: &Materials, link: Element) -> Option<[f32; 4]> {
    link.children_named("visual").filter_map(|v| v.child("material")).fold(None, |found, material| {
        let own = materials.of(material);
        found.or(own.rgba)
    })
}

/// Adds the collision shapes of a link to its body.
///
/// `offset`: the link in its body.
pub(super) fn read(
    importer: &mut Importer,
    (index, link_name, link): (usize, &str, Element),
    body: BodyId,
    offset: &Pose,
) -> Result<(), FormatError> {
    let rgba = link_colour(&importer.materials, link);
    for collision in link.children_named("collision") {
        let Some(geometry) = geometry(importer, collision)? else { continue };
        if leave_out_if_flat(&mut importer.report, collision, &geometry) {
            continue;
        }
        geometry.check().map_err(|reason| collision.invalid(format!("{}: {reason}", geometry.kind_name())))?;
        let placement = *offset * origin(collision)?;
        let given = collision.attributes().text("name").filter(|n| !n.is_empty());
        for geometry in importer.parts.convex_parts(&mut importer.report, collision, geometry) {
            let mut geom = Geom::new("", geometry);
            geom.placement = placement;
            geom.rgba = rgba.unwrap_or(geom.rgba);
            let name = importer.parts.unused_geom_name(given.unwrap_or(link_name));
            let geom = importer.parts.add_geom(collision, Some(name), body, geom)?;
            importer.touching.push((index, geom));
        }
    }
    Ok(())
}

/// The shape; none if its file format is not supported.
fn geometry(importer: &mut Importer, collision: Element) -> Result<Option<Geometry>, FormatError> {
    let effect = "it is left out: nothing touches it; give a <box>, <cylinder>, <sphere>, <capsule> or <mesh>";
    let Some(shape) = collision.child("geometry").and_then(|g| g.children().next()) else {
        importer.report.motion(collision.at(), "collision", "has no shape", effect);
        return Ok(None);
    };
    if shape.is("mesh") {
        return mesh_geometry(importer, &shape.attributes());
    }
    let geometry = primitive(shape)?;
    if geometry.is_none() {
        let what = format!("shape '{}' is not supported", shape.name().chars().take(40).collect::<String>());
        importer.report.motion(shape.at(), "geometry", what, effect);
    }
    Ok(geometry)
}

/// A shape that is no mesh; none if it is of a sort that is not supported.
pub(super) fn primitive(shape: Element) -> Result<Option<Geometry>, FormatError> {
    let a = shape.attributes();
    let size = |name: &'static str| a.number(name)?.ok_or_else(|| shape.incomplete(format!("attribute '{name}': m")));
    Ok(Some(match shape.name() {
        "box" => {
            let full = a.vec3("size")?.ok_or_else(|| shape.incomplete("attribute 'size': three full lengths, m"))?;
            Geometry::Box { half_extents: full / 2.0 }
        }
        "sphere" => Geometry::Sphere { radius: size("radius")? },
        "cylinder" => Geometry::Cylinder { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "capsule" => Geometry::Capsule { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "ellipsoid" => {
            // Drake's <drake:ellipsoid> has an attribute for each.
            let lacks = || shape.incomplete("attribute 'radii': three semi-axes, m, or 'a', 'b' and 'c'");
            let each = [a.number("a")?, a.number("b")?, a.number("c")?];
            let each = each.into_iter().collect::<Option<Vec<f64>>>().map(|axes| DVec3::from_slice(&axes));
            Geometry::Ellipsoid { semi_axes: a.vec3("radii")?.or(each).ok_or_else(lacks)? }
        }
        _ => return Ok(None),
    }))
}

/// A mesh as its convex hull.
fn mesh_geometry(importer: &mut Importer, a: &Attributes) -> Result<Option<Geometry>, FormatError> {
    let uri = a.required("filename", "the mesh file")?;
    let scale = a.scale("scale")?.unwrap_or(DVec3::ONE);
    let named = Named { uri: (uri, a.at("filename")), part: None, scale };
    importer.meshes.hull(&mut importer.report, a.element(), named)
}
