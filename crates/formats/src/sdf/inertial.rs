//! `<inertial>`: what links weigh.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{Geometry, Inertia, Pose};

use super::importer::Importer;
use super::shapes::Solid;
use super::values;
use crate::error::FormatError;
use crate::inertia::{nearest_physical, scaled, solid};
use crate::mesh::{self, Orientation};
use crate::xml::Element;

/// Of shapes that do not say theirs, kg/m³.
const WATER: f64 = 1000.0;

/// `<inertial>` of a link in the link's frame: what is written there, or what its shapes weigh.
pub(super) fn read(importer: &mut Importer, link: Element, solids: &[Solid]) -> Result<Inertia, FormatError> {
    let inertial = link.child("inertial");
    match inertial {
        Some(inertial) if values::attribute_flag(inertial, "auto")? => of_shapes(importer, inertial, solids),
        _ => written(importer, inertial),
    }
}

/// What the shapes of a link weigh together: in all what `<mass>` says, if it does.
fn of_shapes(importer: &mut Importer, inertial: Element, solids: &[Solid]) -> Result<Inertia, FormatError> {
    for given in ["pose", "inertia"].into_iter().filter_map(|name| inertial.child(name)) {
        let effect = "it is left out: the shapes give it; remove it, or auto=\"true\"";
        importer.report.motion(given.at(), given.name(), "stands in an <inertial auto=\"true\">", effect);
    }
    let density = values::non_negative(inertial, "density")?;
    let mut weights: Vec<Inertia> = Vec::new();
    for Solid { collision, geometry, placement } in solids {
        let density = values::non_negative(*collision, "density")?.or(density).unwrap_or(WATER);
        if let Some(unit) = of_density_one(importer, *collision, geometry) {
            weights.push(scaled(unit, density).placed(placement));
        }
    }
    let mass = values::non_negative(inertial, "mass")?;
    let whole = Inertia::sum(&weights);
    if weights.is_empty() || (whole.mass == 0.0 && mass.is_some_and(|mass| mass > 0.0)) {
        let effect = "the link has the mass that <mass> says, or 1 kg, and 1 kg m² about every axis: write its inertia";
        importer.report.motion(
            inertial.at(),
            "inertial",
            "auto=\"true\" without a shape that weighs something",
            effect,
        );
        let rotational = DMat3::IDENTITY;
        return Ok(Inertia { mass: mass.unwrap_or(1.0), center_of_mass: DVec3::ZERO, rotational });
    }
    Ok(match mass {
        Some(mass) if whole.mass > 0.0 => scaled(whole, mass / whole.mass),
        _ => whole,
    })
}

/// The inertia of a shape at 1 kg/m³; none if it has no volume, which is reported.
fn of_density_one(importer: &mut Importer, collision: Element, geometry: &Geometry) -> Option<Inertia> {
    let unit = match geometry {
        Geometry::ConvexMesh(mesh) => mesh::solid_inertia(mesh, 1.0).or_else(|| {
            let effect = "it weighs what its convex hull weighs: close the mesh, or write the link's inertia";
            importer.report.motion(collision.at(), "collision", "a mesh that is not closed", effect);
            mesh::solid(&mesh::convex_hull(&mesh.vertices)?, Orientation::Signed)
        }),
        _ => solid(geometry),
    };
    if unit.is_none() {
        let what = format!("{} without a volume", geometry.kind_name());
        importer.report.motion(collision.at(), "collision", what, "it weighs nothing: write the link's inertia");
    }
    unit
}

/// What is written; 1 kg and 1 kg·m² about every axis where nothing is, as SDF defines.
fn written(importer: &mut Importer, inertial: Option<Element>) -> Result<Inertia, FormatError> {
    let mass = inertial.map_or(Ok(None), |i| values::non_negative(i, "mass"))?.unwrap_or(1.0);
    let matrix = inertial.and_then(|i| i.child("inertia"));
    let entry = |name, default| {
        Ok::<f64, FormatError>(match matrix {
            Some(matrix) => values::number(matrix, name)?.unwrap_or(default),
            None => default,
        })
    };
    let (xx, yy, zz) = (entry("ixx", 1.0)?, entry("iyy", 1.0)?, entry("izz", 1.0)?);
    let (xy, xz, yz) = (entry("ixy", 0.0)?, entry("ixz", 0.0)?, entry("iyz", 0.0)?);
    let mut rotational = DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    if let (Some(possible), Some(matrix)) = (nearest_physical(rotational), matrix) {
        let what = "is not that of a rigid body (a principal moment is negative or exceeds the sum of the others)";
        importer.report.motion(matrix.at(), "inertia", what, "it is replaced by the nearest possible one");
        rotational = possible;
    }
    let placement = inertial.map_or(Ok(Pose::IDENTITY), values::pose)?;
    Ok(Inertia { mass, center_of_mass: DVec3::ZERO, rotational }.placed(&placement))
}
