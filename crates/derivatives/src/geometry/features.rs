//! Which features of two shapes meet at a contact point, told from where it lies.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, GeomId, Geometry, Kinematics, Model};

use super::motion::true_gap;

/// A place within this part of a shape's size of an edge or an end is there.
const AT: f64 = 1e-9;

/// A feature fixed to a body, world axes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Feature {
    /// A face; the normal turns with its body.
    Plane,
    /// A line with a radius about it: an edge (0), the axis of a capsule.
    Line { core: DVec3, along: DVec3, radius: f64 },
    /// A point with a radius about it: a vertex (0), the centre of a sphere, an end of a capsule's axis.
    Point { core: DVec3, radius: f64, is_tie: bool },
}

/// The features of A and B, where the pair of shapes has closed forms.
pub(super) fn of(model: &Model, kinematics: &Kinematics, point: &ContactPoint) -> Option<[Feature; 2]> {
    use Geometry::{Box, Capsule, ConvexMesh, Plane, Sphere, TriangleMesh};
    let ids = [point.geom_a, point.geom_b];
    let shapes = ids.map(|id| &model.geoms[id.index()].geometry);
    let is_closed = |a: &Geometry, b: &Geometry| match a {
        Plane => matches!(b, Sphere { .. } | Capsule { .. } | Box { .. } | ConvexMesh(_) | TriangleMesh(_)),
        Sphere { .. } => matches!(b, Sphere { .. } | Capsule { .. } | Box { .. }),
        Capsule { .. } => matches!(b, Capsule { .. }),
        _ => false,
    };
    if !is_closed(shapes[0], shapes[1]) && !is_closed(shapes[1], shapes[0]) {
        return None;
    }
    let half = point.normal * (0.5 * true_gap(model, point));
    let faces_plane = shapes.iter().any(|shape| matches!(shape, Plane));
    let a = feature(model, kinematics, ids[0], point.position - half, point.normal, faces_plane, point.feature)?;
    let b = feature(model, kinematics, ids[1], point.position + half, -point.normal, faces_plane, point.feature)?;
    Some([a, b])
}

/// The feature of a geom at a point of its surface.
///
/// - `outward`: towards the other shape
fn feature(
    model: &Model,
    kinematics: &Kinematics,
    id: GeomId,
    surface: DVec3,
    outward: DVec3,
    faces_plane: bool,
    code: u32,
) -> Option<Feature> {
    let geom = &model.geoms[id.index()];
    let pose = kinematics.pose[geom.body.index()] * geom.placement;
    match geom.geometry {
        Geometry::Plane => Some(Feature::Plane),
        Geometry::Sphere { radius } => Some(Feature::Point { core: pose.position, radius, is_tie: false }),
        Geometry::Capsule { radius, half_length } => {
            let core = surface - outward * radius;
            let axis = pose.rotation * DVec3::Z;
            let place = axis.dot(core - pose.position);
            let size = half_length + radius;
            if half_length - place.abs() > AT * size {
                let is_near = half_length - place.abs() < 1e2 * AT * size;
                return (!is_near).then_some(Feature::Line { core, along: axis, radius });
            }
            // The nearest place changes from the end to the side where the normal is across the axis.
            let is_tie = !faces_plane && code == 0 && (axis.dot(outward) * place.signum()) < AT.sqrt();
            let core = pose.position + axis * half_length.copysign(place);
            Some(Feature::Point { core, radius, is_tie })
        }
        Geometry::Box { half_extents } if !faces_plane => {
            let local = pose.rotation.conjugate() * (surface - pose.position);
            let size = half_extents.max_element();
            let is_at = [0, 1, 2].map(|i| (local[i].abs() - half_extents[i]).abs() <= AT * size);
            // At the border between a face and an edge the normal is across the edge: nothing here is the feature alone.
            let leans = pose.rotation.conjugate() * outward;
            if (0..3).any(|i| is_at[i] && leans[i] * local[i].signum() < AT.sqrt()) {
                return None;
            }
            match is_at.iter().filter(|at| **at).count() {
                1 => Some(Feature::Plane),
                2 => {
                    let free = (0..3).find(|&i| !is_at[i])?;
                    Some(Feature::Line { core: surface, along: pose.rotation * DVec3::AXES[free], radius: 0.0 })
                }
                3 => Some(Feature::Point { core: surface, radius: 0.0, is_tie: false }),
                _ => None,
            }
        }
        // Vertices are what a plane meets of polyhedra.
        Geometry::Box { .. } | Geometry::ConvexMesh(_) | Geometry::TriangleMesh(_) if faces_plane => {
            Some(Feature::Point { core: surface, radius: 0.0, is_tie: false })
        }
        _ => None,
    }
}

/// What a shape's surface does where it touches, per unit of one of its sizes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeMotion {
    /// Displacement of the face, the line or the point that the feature is about, world axes.
    pub core: DVec3,
    /// Growth of the radius about it.
    pub outward: f64,
}

/// How a feature moves with size number `size` of its shape.
pub(super) fn grow(
    model: &Model,
    kinematics: &Kinematics,
    (point, gap): (&ContactPoint, f64),
    side: usize,
    size: usize,
    feature: Feature,
) -> Option<SizeMotion> {
    let geom = &model.geoms[[point.geom_a, point.geom_b][side].index()];
    let pose = kinematics.pose[geom.body.index()] * geom.placement;
    let still = SizeMotion { core: DVec3::ZERO, outward: 0.0 };
    match (&geom.geometry, size) {
        (Geometry::Sphere { .. } | Geometry::Capsule { .. }, 0) => Some(SizeMotion { outward: 1.0, ..still }),
        (Geometry::Capsule { .. }, 1) => match feature {
            Feature::Point { core, .. } => {
                let axis = pose.rotation * DVec3::Z;
                Some(SizeMotion { core: axis * axis.dot(core - pose.position).signum(), ..still })
            }
            _ => Some(still),
        },
        (Geometry::Box { half_extents }, k) if k < 3 => {
            let surface = point.position + point.normal * if side == 0 { -0.5 * gap } else { 0.5 * gap };
            let local = (pose.rotation.conjugate() * (surface - pose.position)).to_array();
            let touches = (local[k].abs() - half_extents[k]).abs() <= AT * half_extents.max_element();
            let core = pose.rotation * DVec3::AXES[k] * local[k].signum();
            Some(if touches { SizeMotion { core, ..still } } else { still })
        }
        _ => None,
    }
}
