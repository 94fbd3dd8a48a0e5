//! Half-lines and where they meet a surface.

use signorini_multibody::glam::DVec3;

/// A half-line with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

/// Where a ray meets a surface first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// From the ray's origin, m.
    pub distance: f64,
    /// Unit normal of the surface.
    pub face: DVec3,
    /// Unit normal for the light; another one where flat triangles stand for something smooth.
    pub normal: DVec3,
    /// Of a mesh: the triangle, and the weights of its second and third corner.
    pub on_triangle: Option<(u32, [f32; 2])>,
}

impl Hit {
    pub fn smooth(distance: f64, normal: DVec3) -> Self {
        Self { distance, face: normal, normal, on_triangle: None }
    }
}
