//! `<collision>` shapes, coloured as the link's `<visual>`.

use std::collections::HashMap;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Geom, Geometry, Pose};

use super::importer::{Importer, origin};
use crate::error::FormatError;
use crate::shapes::leave_out_if_flat;
use crate::xml::{Attributes, Element};

/// The colours that a file defines, by name.
pub(super) fn materials<'t>(root: Element<'t>) -> HashMap<&'t str, [f32; 4]> {
    let mut materials = HashMap::new();
    let nested = root.children_named("link").flat_map(|l| l.children_named("visual"));
    let everywhere = root.children_named("material").chain(nested.flat_map(|v| v.children_named("material")));
    for material in everywhere {
        if let (Some(name), Some(rgba)) = (material.attributes().text("name"), colour(material)) {
            materials.entry(name).or_insert(rgba);
        }
    }
    materials
}

/// The colour of the link's first visual that has one.
fn link_colour(materials: &HashMap<&str, [f32; 4]>, link: Element) -> Option<[f32; 4]> {
    let mut found = None;
    for material in link.children_named("visual").filter_map(|v| v.child("material")) {
        let name = material.attributes().text("name").filter(|n| !n.is_empty());
        let rgba = colour(material).or(name.and_then(|name| materials.get(name)).copied());
        // A texture is a definition, too, which is not read.
        if let (Some(name), None, None) = (name, rgba, material.children().next()) {
            let what = format!("'{}' is not defined", name.chars().take(60).collect::<String>());
            material.note(material.at(), what, "the link has the default colour", false);
        }
        found = found.or(rgba);
    }
    found
}

/// Adds the collision shapes of a link to its body.
///
/// `offset`: the link in its body.
pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    (link_name, link): (&'t str, Element<'t>),
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
            importer.parts.add_geom(collision, Some(name), body, geom)?;
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
    let a = shape.attributes();
    let size = |name: &'static str| a.number(name)?.ok_or_else(|| shape.incomplete(format!("attribute '{name}': m")));
    let geometry = match shape.name() {
        "box" => {
            let full = a.vec3("size")?.ok_or_else(|| shape.incomplete("attribute 'size': three full lengths, m"))?;
            Geometry::Box { half_extents: full / 2.0 }
        }
        "sphere" => Geometry::Sphere { radius: size("radius")? },
        "cylinder" => Geometry::Cylinder { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "capsule" => Geometry::Capsule { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "mesh" => return mesh_geometry(importer, &a),
        "ellipsoid" => {
            let radii = a.vec3("radii")?.ok_or_else(|| shape.incomplete("attribute 'radii': three semi-axes, m"))?;
            Geometry::Ellipsoid { semi_axes: radii }
        }
        other => {
            let what = format!("shape '{}' is not supported", other.chars().take(40).collect::<String>());
            importer.report.motion(shape.at(), "geometry", what, effect);
            return Ok(None);
        }
    };
    Ok(Some(geometry))
}

/// A mesh as its convex hull.
fn mesh_geometry(importer: &mut Importer, a: &Attributes) -> Result<Option<Geometry>, FormatError> {
    let uri = a.required("filename", "the mesh file")?;
    let scale = a.scale("scale")?.unwrap_or(DVec3::ONE);
    importer.meshes.hull(&mut importer.report, a.element(), (uri, a.at("filename")), scale)
}

/// `<color rgba="…">` of a material, opaque where there are three numbers. Only pictures depend on it: a colour that cannot be read
/// is noted.
fn colour(material: Element) -> Option<[f32; 4]> {
    let a = material.child("color")?.attributes();
    let rgba = match a.numbers("rgba") {
        Ok(numbers) => numbers?.iter().map(|x| *x as f32).collect::<Vec<f32>>(),
        Err(_) => Vec::new(),
    };
    match rgba[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => {
            let (what, effect) = ("'rgba' is not a colour", "it is passed over: write red, green, blue, opacity");
            a.element().note(a.at("rgba"), what, effect, false);
            None
        }
    }
}
