//! `<geom>`: shape, place, weight, contact properties.

use std::rc::Rc;
use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Pose, SpinResistance, unit_rotation};

use super::assets::MeshAsset;
use super::compiler::z_to;
use super::importer::Importer;
use super::looks;
use super::scope::{OpenBody, Scope};
use crate::error::FormatError;
use crate::inertia::solid;
use crate::xml::{Attributes, Element};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Plane,
    HeightField,
    Sphere,
    Capsule,
    Ellipsoid,
    Cylinder,
    Box,
    Mesh,
    SignedDistance,
}

const TYPES: [(&str, Type); 9] = [
    ("plane", Type::Plane),
    ("hfield", Type::HeightField),
    ("sphere", Type::Sphere),
    ("capsule", Type::Capsule),
    ("ellipsoid", Type::Ellipsoid),
    ("cylinder", Type::Cylinder),
    ("box", Type::Box),
    ("mesh", Type::Mesh),
    ("sdf", Type::SignedDistance),
];

/// A geometry, where it is in the element's frame, and the mesh behind it.
struct Shape {
    geometry: Geometry,
    placement: Pose,
    mesh: Option<Rc<MeshAsset>>,
}

pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
    body: &mut OpenBody,
) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, scope.class, &["geom"])?;
    let Some(shape) = read_shape(importer, &a)? else { return Ok(()) };
    let placement = scope.frame * shape.placement;
    let placement = Pose::new(placement.position, unit_rotation(placement.rotation));
    weigh(&a, &shape, &placement, body)?;
    let mut geom = Geom::new("", shape.geometry);
    geom.placement = placement;
    read_contact(importer, &a, &mut geom)?;
    let name = scope.name(element);
    show_as_it_is(importer, name.as_deref(), &mut geom);
    (geom.rgba, geom.look) = looks::look(importer, &a, &geom.geometry, shape.mesh.as_deref(), geom.rgba)?;
    geom.margin = a.non_negative("margin")?.unwrap_or(0.0);
    if let Some(layer) = a.non_negative("gap")?.filter(|gap| *gap > 0.0) {
        let own = importer.layers.entry(body.id).or_insert(layer);
        *own = own.max(layer);
    }
    let priority = a.integer("priority")?.unwrap_or(0);
    geom.priority = i32::try_from(priority).map_err(|_| a.invalid("priority", "a number of 32 bits"))?;
    read_belt(importer, &a, &mut geom)?;
    geom.grain = name.as_deref().and_then(|name| importer.grains.get(name)).map(|(grain, _)| *grain);
    geom.restitution = importer.restitution.of(name.as_deref());
    for (k, geometry) in touching_parts(importer, element, name.as_deref(), &geom).into_iter().enumerate() {
        let name = name.as_deref().map(|name| match k {
            0 => name.to_owned(),
            _ => importer.parts.unused_name(&format!("{name}_part{k}")),
        });
        let mut part = geom.clone();
        if part.geometry != geometry {
            // Parts of a mesh have other triangles than the image was made for.
            part.look.texture = None;
        }
        part.geometry = geometry;
        let id = importer.parts.add_geom(element, name, body.id, part)?;
        importer.mesh_geoms.extend(shape.mesh.as_ref().map(|_| id));
    }
    Ok(())
}

/// The shapes of a geom: the convex parts of its mesh, where these are asked for and nothing names the geom, which is one thing then.
fn touching_parts(importer: &mut Importer, element: Element, name: Option<&str>, geom: &Geom) -> Vec<Geometry> {
    let is_mesh = matches!(geom.geometry, Geometry::ConvexMesh(_));
    if importer.parts.decomposer.is_none() || !is_mesh {
        return vec![geom.geometry.clone()];
    }
    if name.is_some_and(|name| importer.paired.contains(name) || importer.measured.contains(name)) {
        let what = "is not taken apart, because a pair or a sensor names it";
        importer.report.motion(element.at(), "geom", what, "its convex hull is used");
        return vec![geom.geometry.clone()];
    }
    importer.parts.convex_parts(&mut importer.report, element, geom.geometry.clone())
}

/// `surfacevel`: a belt.
fn read_belt(importer: &mut Importer, a: &Attributes, geom: &mut Geom) -> Result<(), FormatError> {
    let ([x, y, z, turn @ ..], _) = a.overlay::<6>("surfacevel", [0.0; 6])?;
    geom.surface_velocity = DVec3::new(x, y, z);
    if turn != [0.0; 3] {
        let effect = "only the constant part of the surface's velocity acts";
        importer.report.motion(a.at("surfacevel"), "geom", "a surface that turns is not supported", effect);
    }
    Ok(())
}

/// Leaves the faces of a mesh that nothing can touch as they are, instead of taking their hull: many are flat.
fn show_as_it_is(importer: &Importer, name: Option<&str>, geom: &mut Geom) {
    let touches = geom.contact_type != 0 || geom.contact_affinity != 0;
    if touches || name.is_some_and(|name| importer.paired.contains(name)) {
        return;
    }
    if let Geometry::ConvexMesh(mesh) = &geom.geometry
        && !mesh.triangles.is_empty()
    {
        geom.geometry = Geometry::TriangleMesh(mesh.clone());
    }
}

/// The shape; none if it is of a sort that is not supported.
fn read_shape(importer: &mut Importer, a: &Attributes) -> Result<Option<Shape>, FormatError> {
    let sort = a.choice("type", &TYPES)?.unwrap_or(Type::Sphere);
    let ([x, y, z], _) = a.overlay::<3>("size", [0.0; 3])?;
    let (mut size, mut placement) = (DVec3::new(x, y, z), importer.compiler(a.element()).pose(a)?);
    if a.has("mesh") || sort == Type::Mesh {
        return mesh_shape(importer, a, sort, placement);
    }
    if let Some((placed, half)) = from_to(a)? {
        size = match sort {
            Type::Capsule | Type::Cylinder => DVec3::new(x, half, 0.0),
            Type::Box | Type::Ellipsoid => DVec3::new(x, x, half),
            _ => return Err(a.invalid("fromto", "only capsules, cylinders, boxes and ellipsoids have 'fromto'")),
        };
        placement = placed;
    }
    let geometry = match sort {
        Type::Plane => Geometry::Plane,
        Type::Sphere => Geometry::Sphere { radius: size.x },
        Type::Capsule => Geometry::Capsule { radius: size.x, half_length: size.y },
        Type::Cylinder => Geometry::Cylinder { radius: size.x, half_length: size.y },
        Type::Ellipsoid => Geometry::Ellipsoid { semi_axes: size },
        Type::Box => Geometry::Box { half_extents: size },
        Type::HeightField => Geometry::HeightField(Arc::new(importer.assets.height_field(a, &importer.compilers)?)),
        Type::Mesh | Type::SignedDistance => return Ok(left_out(importer, a, "type 'sdf' is not supported")),
    };
    geometry.check().map_err(|reason| a.element().invalid(format!("{} geom: {reason}", geometry.kind_name())))?;
    Ok(Some(Shape { geometry, placement, mesh: None }))
}

/// `fromto`: the pose whose z axis leads from the second point to the first, in the middle between them, and half their
/// distance.
pub(super) fn from_to(a: &Attributes) -> Result<Option<(Pose, f64)>, FormatError> {
    let Some([ax, ay, az, bx, by, bz]) = a.vector::<6>("fromto")? else { return Ok(None) };
    if a.element().raw("pos").is_some() {
        a.element().note(a.at("pos"), "has both 'pos' and 'fromto'", "'fromto' counts: remove 'pos'", false);
    }
    let (from, to) = (DVec3::new(ax, ay, az), DVec3::new(bx, by, bz));
    let axis = crate::xml::unit(from - to).ok_or_else(|| a.invalid("fromto", "two different points"))?;
    Ok(Some((Pose::new((from + to) / 2.0, z_to(axis)), (from - to).length() / 2.0)))
}

fn left_out(importer: &mut Importer, a: &Attributes, what: &str) -> Option<Shape> {
    importer.report.motion(a.element().at(), "geom", what, "the geom is left out: nothing touches it");
    None
}

/// A mesh as its convex hull, or as it is where its type is "sdf", in the frame of the file.
fn mesh_shape(
    importer: &mut Importer,
    a: &Attributes,
    sort: Type,
    placement: Pose,
) -> Result<Option<Shape>, FormatError> {
    if let Some(what) = importer.assets.left_out(a, &importer.compilers, importer.missing_meshes) {
        return Ok(left_out(importer, a, &what));
    }
    let asset = importer.assets.mesh(a, &importer.compilers)?;
    if sort == Type::SignedDistance && !asset.mesh.triangles.is_empty() {
        // The distance from the mesh itself: its triangles touch, not its hull.
        let geometry = Geometry::TriangleMesh(asset.mesh.clone());
        geometry.check().map_err(|reason| a.element().invalid(format!("mesh geom: {reason}")))?;
        return Ok(Some(Shape { geometry, placement, mesh: Some(asset) }));
    }
    if !matches!(sort, Type::Mesh | Type::SignedDistance) {
        let effect = "the mesh's convex hull is used";
        importer.report.motion(a.at("mesh"), "geom", "fitting a primitive to a mesh is not supported", effect);
    }
    let geometry = Geometry::ConvexMesh(asset.mesh.clone());
    geometry.check().map_err(|reason| a.element().invalid(format!("mesh geom: {reason}")))?;
    Ok(Some(Shape { geometry, placement, mesh: Some(asset) }))
}

fn weigh(a: &Attributes, shape: &Shape, placement: &Pose, body: &mut OpenBody) -> Result<(), FormatError> {
    let (mass, density) = (a.non_negative("mass")?, a.non_negative("density")?.unwrap_or(1000.0));
    let group = a.integer("group")?.unwrap_or(0);
    let [first, last] = body.weighing_groups;
    let weightless = mass == Some(0.0) || (mass.is_none() && density == 0.0);
    if !body.weighs_geoms || weightless || group < first || group > last {
        return Ok(());
    }
    let unit = match &shape.mesh {
        Some(asset) => asset.unit_inertia().ok_or_else(|| {
            a.element().invalid("the mesh encloses no volume: give the body an <inertial>, or the geom mass=\"0\"")
        })?,
        None => match solid(&shape.geometry) {
            Some(unit) => unit,
            None => return Ok(()),
        },
    };
    body.weigh(unit, mass, density, placement);
    Ok(())
}

fn read_contact(importer: &mut Importer, a: &Attributes, geom: &mut Geom) -> Result<(), FormatError> {
    let (friction, _) = a.overlay::<3>("friction", [geom.friction, geom.spinning_friction, geom.rolling_friction])?;
    if friction.iter().any(|x| *x < 0.0) {
        return Err(a.invalid("friction", "numbers that are not negative"));
    }
    [geom.friction, geom.spinning_friction, geom.rolling_friction] = friction;
    (geom.frictional, geom.spin_resistance) = importer.condim(a)?.unwrap_or((true, SpinResistance::None));
    let masks = (mask(a, "contype")?, mask(a, "conaffinity")?);
    (geom.contact_type, geom.contact_affinity) = if importer.contacts_disabled { (0, 0) } else { masks };
    Ok(())
}

fn mask(a: &Attributes, name: &'static str) -> Result<u32, FormatError> {
    match a.integer(name)? {
        None => Ok(1),
        Some(bits) if (i64::from(i32::MIN)..=i64::from(u32::MAX)).contains(&bits) => Ok(bits as u32),
        Some(_) => Err(a.invalid(name, "a bit mask of 32 bits")),
    }
}
