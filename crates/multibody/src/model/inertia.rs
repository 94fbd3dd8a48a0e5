//! Mass, centre of mass and rotational inertia: of solids, and of several parts together.

use glamx::glam::{DMat3, DVec3};

use super::Geometry;
use crate::math::Pose;

/// Mass distribution of a body in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the body frame, m.
    pub center_of_mass: DVec3,
    /// Rotational inertia about the centre of mass in the body's axes, kg·m², symmetric.
    pub rotational: DMat3,
}

impl Inertia {
    /// No mass.
    pub const ZERO: Self = Self { mass: 0.0, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };

    /// Of a uniform solid of this shape and mass (kg) in the shape's frame; none for what has no volume (plane, height field) and
    /// for meshes, whose volume depends on how their faces are read.
    ///
    /// # Source
    /// Integrals of r² over the solids; the capsule is a cylinder and two half balls moved by the parallel-axis theorem, the cone's
    /// centre of mass is a quarter of its height above its base.
    pub fn of_solid(geometry: &Geometry, mass: f64) -> Option<Self> {
        let mut center_of_mass = DVec3::ZERO;
        let moments = match *geometry {
            Geometry::Sphere { radius: r } => DVec3::splat(0.4 * r * r),
            Geometry::Box { half_extents: e } => across(e * e) / 3.0,
            Geometry::Ellipsoid { semi_axes: e } => across(e * e) / 5.0,
            Geometry::Cylinder { radius: r, half_length: h } => {
                let side = r * r / 4.0 + h * h / 3.0;
                DVec3::new(side, side, r * r / 2.0)
            }
            Geometry::Cone { radius: r, half_length: h } => {
                center_of_mass.z = -0.5 * h;
                let side = 0.15 * (r * r + h * h);
                DVec3::new(side, side, 0.3 * r * r)
            }
            Geometry::Capsule { radius: r, half_length: h } => {
                // Shares of the volume π r² (2 h + 4 r/3).
                let balls = (2.0 * r) / (2.0 * r + 3.0 * h);
                let cylinder = 1.0 - balls;
                let side = cylinder * (r * r / 4.0 + h * h / 3.0) + balls * (0.4 * r * r + h * h + 0.75 * h * r);
                DVec3::new(side, side, cylinder * r * r / 2.0 + balls * 0.4 * r * r)
            }
            Geometry::Plane | Geometry::ConvexMesh(_) | Geometry::TriangleMesh(_) | Geometry::HeightField(_) => {
                return None;
            }
        };
        Some(Self { mass, center_of_mass, rotational: DMat3::from_diagonal(moments * mass) })
    }

    /// An inertia given in frame G, expressed in frame B where G stands at `X_BG`.
    pub fn placed(self, placement: &Pose) -> Self {
        let r = placement.rotation_matrix();
        Self {
            mass: self.mass,
            center_of_mass: placement.transform_point(self.center_of_mass),
            rotational: symmetric(r * self.rotational * r.transpose()),
        }
    }

    /// Several inertias in the same frame as one; [`ZERO`](Self::ZERO) where they have no mass.
    pub fn sum(parts: &[Self]) -> Self {
        let mass: f64 = parts.iter().map(|p| p.mass).sum();
        if mass <= 0.0 {
            return Self::ZERO;
        }
        if let [only] = parts {
            return *only;
        }
        let center_of_mass = parts.iter().map(|p| p.center_of_mass * p.mass).sum::<DVec3>() / mass;
        let about_center = |p: &Self| p.rotational + steiner(p.mass, p.center_of_mass - center_of_mass);
        let rotational = parts.iter().map(about_center).fold(DMat3::ZERO, |a, b| a + b);
        Self { mass, center_of_mass, rotational }
    }
}

/// `(y² + z², x² + z², x² + y²)` from the squares.
fn across(squares: DVec3) -> DVec3 {
    DVec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y)
}

/// `m (|d|² 1 − d dᵀ)`: what a point mass adds at distance `d`.
fn steiner(mass: f64, d: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    (DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer) * mass
}

fn symmetric(a: DMat3) -> DMat3 {
    (a + a.transpose()) * 0.5
}
