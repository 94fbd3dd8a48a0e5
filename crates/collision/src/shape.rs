//! Geoms made ready for the search.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glamx::glam::DVec3;
use signorini_multibody::model::Mesh;
use signorini_multibody::{Geom, Geometry, Pose};

use crate::CollisionError;
use crate::convex::Convex;
use crate::hull::Hull;
use crate::mesh::TriangleSet;

/// A geometry made ready.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// Of a geom that can touch nothing.
    Absent,
    HalfSpace,
    Convex(Convex),
    Triangles(TriangleSet),
}

/// Polyhedra that are made already, by the address of the mesh that geoms share.
pub(crate) type KnownHulls = HashMap<*const Mesh, Arc<Hull>>;

/// A geom made ready.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub shape: Shape,
    pub body: usize,
    /// `X_BG`.
    pub placement: Pose,
    /// Centre of the shape's bounding box in its own frame, m.
    pub center: DVec3,
    /// Half-lengths of the bounding box, m; zero for a half-space.
    pub half: DVec3,
    /// Distance of the farthest point of the shape from the body's origin (an upper bound), m.
    pub arm: f64,
    /// Radius of a ball about `center` that holds the shape, m.
    pub size: f64,
}

impl Prepared {
    /// A geom that can touch nothing.
    pub fn absent(geom: &Geom) -> Self {
        let (center, half) = (DVec3::ZERO, DVec3::ZERO);
        let (body, placement) = (geom.body.index(), geom.placement);
        Self { shape: Shape::Absent, body, placement, center, half, arm: 0.0, size: 0.0 }
    }

    /// A geom that questions are asked about, whether or not it can touch anything: a mesh whose hull is flat as its triangles.
    pub fn for_queries(geom: &Geom, known: &mut KnownHulls) -> Self {
        match (Self::new(geom, known), &geom.geometry) {
            (Ok(prepared), _) => prepared,
            (Err(_), Geometry::ConvexMesh(mesh)) => {
                Self::of_shape(geom, Shape::Triangles(TriangleSet::from_mesh(mesh)))
            }
            (Err(_), _) => Self::absent(geom),
        }
    }

    pub fn new(geom: &Geom, known: &mut KnownHulls) -> Result<Self, CollisionError> {
        let shape = match &geom.geometry {
            Geometry::Plane => Shape::HalfSpace,
            Geometry::Sphere { radius } => Shape::Convex(Convex::Sphere { radius: *radius }),
            Geometry::Box { half_extents } => Shape::Convex(Convex::Box { half: *half_extents }),
            &Geometry::Capsule { radius, half_length } => Shape::Convex(Convex::Capsule { radius, half_length }),
            &Geometry::Cylinder { radius, half_length } => Shape::Convex(Convex::Cylinder { radius, half_length }),
            &Geometry::Cone { radius, half_length } => Shape::Convex(Convex::Cone { radius, half_length }),
            Geometry::Ellipsoid { semi_axes } => Shape::Convex(Convex::Ellipsoid { axes: *semi_axes }),
            Geometry::ConvexMesh(mesh) => {
                let flat = |reason| CollisionError::FlatHull { geom: geom.name.clone(), reason };
                let hull = match known.entry(Arc::as_ptr(mesh)) {
                    Entry::Occupied(made) => made.get().clone(),
                    Entry::Vacant(place) => place.insert(Arc::new(Hull::new(&mesh.vertices).map_err(flat)?)).clone(),
                };
                Shape::Convex(Convex::Hull(hull))
            }
            Geometry::TriangleMesh(mesh) => Shape::Triangles(TriangleSet::from_mesh(mesh)),
            Geometry::HeightField(field) => Shape::Triangles(TriangleSet::from_height_field(field)),
        };
        Ok(Self::of_shape(geom, shape))
    }

    /// Whether it was made of a mesh or height field, whose size does not change.
    pub fn is_of_mesh(&self) -> bool {
        matches!(self.shape, Shape::Convex(Convex::Hull(_)) | Shape::Triangles(_))
    }

    /// The same shape where the geom says.
    pub fn moved(&self, geom: &Geom) -> Self {
        Self::of_shape(geom, self.shape.clone())
    }

    fn of_shape(geom: &Geom, shape: Shape) -> Self {
        let (low, high) = match &shape {
            Shape::Absent | Shape::HalfSpace => (DVec3::ZERO, DVec3::ZERO),
            Shape::Convex(convex) => convex.bounds(),
            Shape::Triangles(set) => set.bounds(),
        };
        let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
        let size = match &shape {
            Shape::Convex(Convex::Sphere { radius }) => *radius,
            Shape::Convex(Convex::Capsule { radius, half_length }) => radius + half_length,
            _ => half.length(),
        };
        let arm = geom.placement.transform_point(center).length() + size;
        Self { shape, body: geom.body.index(), placement: geom.placement, center, half, arm, size }
    }
}
