//! What the readers do with shapes alike.

use std::path::Path;

use signorini_multibody::Geometry;

use crate::options::MissingMeshes;
use crate::report::Reporter;
use crate::xml::Element;

/// Whether a mesh file is not there and its geom is to be left out for it, which the report tells.
pub(crate) fn leave_out_if_missing(
    report: &mut Reporter,
    element: Element,
    path: &Path,
    missing_meshes: MissingMeshes,
) -> bool {
    let missing = missing_meshes == MissingMeshes::Skip && !path.exists();
    if missing {
        let what = format!("the file '{}' is missing", path.display());
        let effect = "the geom is left out, as asked: nothing touches it, and it has no mass";
        report.motion(element.at(), element.name(), what, effect);
    }
    missing
}

/// Whether a primitive has a size of zero, so that there is nothing to touch. It is then to be left out, which the report tells.
pub(crate) fn leave_out_if_flat(report: &mut Reporter, element: Element, geometry: &Geometry) -> bool {
    let sizes = match *geometry {
        Geometry::Sphere { radius } => vec![radius],
        Geometry::Box { half_extents: sizes } | Geometry::Ellipsoid { semi_axes: sizes } => sizes.to_array().to_vec(),
        Geometry::Capsule { radius, half_length }
        | Geometry::Cylinder { radius, half_length }
        | Geometry::Cone { radius, half_length } => vec![radius, half_length],
        _ => return false,
    };
    let flat = sizes.contains(&0.0) && sizes.iter().all(|x| *x >= 0.0);
    if flat {
        let what = format!("{} with a size of 0", geometry.kind_name());
        let effect = "it is left out: nothing touches it; give it its size, or remove it";
        report.motion(element.at(), element.name(), what, effect);
    }
    flat
}
