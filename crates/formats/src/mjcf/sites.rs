//! `<site>`: frames for sensors and actuators.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Geometry, Pose, Site, unit_rotation};

use super::geoms::from_to;
use super::importer::Importer;
use super::scope::Scope;
use crate::error::FormatError;
use crate::xml::Element;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Sphere,
    Capsule,
    Ellipsoid,
    Cylinder,
    Box,
}

const TYPES: [(&str, Type); 5] = [
    ("sphere", Type::Sphere),
    ("capsule", Type::Capsule),
    ("ellipsoid", Type::Ellipsoid),
    ("cylinder", Type::Cylinder),
    ("box", Type::Box),
];

pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
    body: BodyId,
) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, scope.class, &["site"])?;
    let sort = a.choice("type", &TYPES)?.unwrap_or(Type::Sphere);
    let (size, _) = a.overlay::<3>("size", [0.005; 3])?;
    let (mut size, mut placement) = (DVec3::from_array(size), importer.compiler(element).pose(&a)?);
    if let Some((placed, half)) = from_to(&a)? {
        placement = placed;
        size = match sort {
            Type::Capsule | Type::Cylinder => DVec3::new(size.x, half, 0.0),
            Type::Box | Type::Ellipsoid => DVec3::new(size.x, size.x, half),
            Type::Sphere => return Err(a.invalid("fromto", "a site of another type than sphere")),
        };
    }
    let zone = match sort {
        Type::Sphere => Geometry::Sphere { radius: size.x },
        Type::Capsule => Geometry::Capsule { radius: size.x, half_length: size.y },
        Type::Cylinder => Geometry::Cylinder { radius: size.x, half_length: size.y },
        Type::Ellipsoid => Geometry::Ellipsoid { semi_axes: size },
        Type::Box => Geometry::Box { half_extents: size },
    };
    zone.check().map_err(|reason| a.element().invalid(format!("{} site: {reason}", zone.kind_name())))?;
    let placement = scope.frame * placement;
    let placement = Pose::new(placement.position, unit_rotation(placement.rotation));
    importer.parts.add_site(
        element,
        scope.name(element),
        body,
        Site::new(String::new()).with_placement(placement).with_zone(zone),
    )?;
    Ok(())
}
