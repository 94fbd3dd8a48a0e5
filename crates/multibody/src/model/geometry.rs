//! Shapes, without position, mass or material.

use std::sync::Arc;

use glamx::glam::DVec3;

/// The shape of a geom in its own frame. Axes of revolution are Z; sizes are half-extents.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// The half-space `z ≤ 0`; its outward normal is +Z. Only on bodies that are welded to the world.
    Plane,
    /// A ball about the origin.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A cuboid about the origin.
    Box {
        /// Half-lengths along x, y, z, m.
        half_extents: DVec3,
    },
    /// A cylinder about Z with hemispherical ends.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Half the distance between the centres of the two ends, m.
        half_length: f64,
    },
    /// A cylinder about Z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Half the height, m.
        half_length: f64,
    },
    /// A cone about Z, apex at `+half_length`, base at `−half_length`.
    Cone {
        /// Radius of the base, m.
        radius: f64,
        /// Half the height, m.
        half_length: f64,
    },
    /// An ellipsoid about the origin.
    Ellipsoid {
        /// Semi-axes along x, y, z, m.
        semi_axes: DVec3,
    },
    /// The convex hull of a mesh's vertices.
    ConvexMesh(Arc<Mesh>),
    /// A triangle mesh taken as it is (not necessarily convex); meant for static surroundings.
    TriangleMesh(Arc<Mesh>),
    /// Terrain over a rectangle in x–y.
    HeightField(Arc<HeightField>),
}

/// Triangles over shared vertices, outward normals by the right-hand rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices in the geom's frame, m.
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Heights on a regular grid over `[−half_x, half_x] × [−half_y, half_y]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeightField {
    /// Number of grid points along x and along y, at least 2 each.
    pub size: [usize; 2],
    /// Half-lengths of the rectangle along x and y, m.
    pub half_extents: [f64; 2],
    /// Heights in m, row after row: `heights[iy * size[0] + ix]`.
    pub heights: Vec<f64>,
}

impl Geometry {
    /// Radius of the smallest known ball about the geom's origin that holds the shape, m; infinite for a plane.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::Plane => f64::INFINITY,
            Self::Sphere { radius } => *radius,
            Self::Box { half_extents } => half_extents.length(),
            Self::Capsule { radius, half_length } => radius + half_length,
            Self::Cylinder { radius, half_length } | Self::Cone { radius, half_length } => radius.hypot(*half_length),
            Self::Ellipsoid { semi_axes } => semi_axes.max_element(),
            Self::ConvexMesh(mesh) | Self::TriangleMesh(mesh) => {
                mesh.vertices.iter().map(|p| p.length()).fold(0.0, f64::max)
            }
            Self::HeightField(field) => {
                let top = field.heights.iter().fold(0.0_f64, |a, h| a.max(h.abs()));
                DVec3::new(field.half_extents[0], field.half_extents[1], top).length()
            }
        }
    }

    /// What the shape is called in messages.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Sphere { .. } => "sphere",
            Self::Box { .. } => "box",
            Self::Capsule { .. } => "capsule",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::ConvexMesh(_) => "convex mesh",
            Self::TriangleMesh(_) => "triangle mesh",
            Self::HeightField(_) => "height field",
        }
    }

    /// Whether every size is finite and positive and every mesh index in range; otherwise what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let positive = |name: &str, x: f64| {
            if x.is_finite() && x > 0.0 {
                Ok(())
            } else {
                Err(format!("{name} must be positive and finite, found {x}"))
            }
        };
        match self {
            Self::Plane => Ok(()),
            Self::Sphere { radius } => positive("radius", *radius),
            Self::Box { half_extents: e } | Self::Ellipsoid { semi_axes: e } => {
                e.to_array().iter().try_for_each(|x| positive("every size", *x))
            }
            Self::Capsule { radius, half_length }
            | Self::Cylinder { radius, half_length }
            | Self::Cone { radius, half_length } => {
                positive("radius", *radius)?;
                positive("half length", *half_length)
            }
            Self::ConvexMesh(mesh) | Self::TriangleMesh(mesh) => mesh.check(),
            Self::HeightField(field) => field.check(),
        }
    }
}

impl Mesh {
    fn check(&self) -> Result<(), String> {
        if self.vertices.len() < 3 {
            return Err(format!("a mesh needs at least 3 vertices, found {}", self.vertices.len()));
        }
        if let Some(i) = self.vertices.iter().position(|p| !p.is_finite()) {
            return Err(format!("mesh vertex {i} is not finite"));
        }
        let n = self.vertices.len() as u32;
        match self.triangles.iter().position(|t| t.iter().any(|&k| k >= n)) {
            Some(i) => Err(format!("mesh triangle {i} names a vertex beyond the last ({n})")),
            None => Ok(()),
        }
    }
}

impl HeightField {
    fn check(&self) -> Result<(), String> {
        let [nx, ny] = self.size;
        if nx < 2 || ny < 2 || nx.checked_mul(ny) != Some(self.heights.len()) {
            return Err(format!("a height field of {nx} x {ny} points holds {} heights", self.heights.len()));
        }
        let sizes_ok = self.half_extents.iter().all(|x| x.is_finite() && *x > 0.0);
        if !sizes_ok || self.heights.iter().any(|h| !h.is_finite()) {
            return Err("height field sizes must be positive and heights finite".into());
        }
        Ok(())
    }
}
