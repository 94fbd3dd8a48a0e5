//! Mass, centre of mass and rotational inertia of shapes, and what makes an inertia physical.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{Geometry, Inertia};

use std::f64::consts::PI;

/// Inertia of a solid primitive of density 1 kg/m³ in its own frame; none for shapes without volume (plane, height
/// field) and for meshes, whose volume depends on how their faces are read.
pub(crate) fn solid(geometry: &Geometry) -> Option<Inertia> {
    let volume = match *geometry {
        Geometry::Sphere { radius: r } => 4.0 / 3.0 * PI * r.powi(3),
        Geometry::Box { half_extents: e } => 8.0 * e.x * e.y * e.z,
        Geometry::Ellipsoid { semi_axes: e } => 4.0 / 3.0 * PI * e.x * e.y * e.z,
        Geometry::Cylinder { radius: r, half_length: h } => 2.0 * PI * r * r * h,
        Geometry::Cone { radius: r, half_length: h } => 2.0 / 3.0 * PI * r * r * h,
        Geometry::Capsule { radius: r, half_length: h } => 2.0 * PI * r * r * h + 4.0 / 3.0 * PI * r.powi(3),
        _ => return None,
    };
    Inertia::of_solid(geometry, volume)
}

/// `(y² + z², x² + z², x² + y²)` from the squares.
fn across(squares: DVec3) -> DVec3 {
    DVec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y)
}

/// All masses multiplied by `factor`.
pub(crate) fn scaled(inertia: Inertia, factor: f64) -> Inertia {
    Inertia { mass: inertia.mass * factor, rotational: inertia.rotational * factor, ..inertia }
}

/// The symmetric part.
pub(crate) fn symmetric(a: DMat3) -> DMat3 {
    (a + a.transpose()) * 0.5
}

/// Principal moments and axes (columns) of a symmetric matrix by cyclic Jacobi rotations
/// (Golub & Van Loan, Matrix Computations, §8.5).
pub(crate) fn principal(a: DMat3) -> (DVec3, DMat3) {
    let mut a = symmetric(a).to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..32 {
        let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        let size = a[0][0].abs() + a[1][1].abs() + a[2][2].abs();
        if off <= 1e-17 * size || !off.is_finite() {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut axes, p, q);
        }
    }
    (DVec3::new(a[0][0], a[1][1], a[2][2]), DMat3::from_cols_array_2d(&axes))
}

/// Rotational inertia nearest to a given one that a rigid body can have: the principal second moments
/// `∫ x² dm = tr(I)/2 − I_k` that are negative become zero. None if none is, up to rounding.
///
/// # Source
/// P. Wensing, S. Kim, J.-J. Slotine, Linear matrix inequalities for physically consistent inertial parameter
/// identification, IEEE RA-L 3 (2018): an inertia is physical where the matrix of second moments is positive semidefinite.
pub(crate) fn nearest_physical(rotational: DMat3) -> Option<DMat3> {
    let (moments, axes) = principal(rotational);
    let second = DVec3::splat(moments.element_sum() / 2.0) - moments;
    if second.min_element() >= -1e-7 * moments.abs().max_element() {
        return None;
    }
    let possible = across(second.max(DVec3::ZERO));
    Some(symmetric(axes * DMat3::from_diagonal(possible) * axes.transpose()))
}

/// One Jacobi rotation that clears `a[p][q]`; `axes[k]` is the k-th axis.
fn rotate(a: &mut [[f64; 3]; 3], axes: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for k in 0..3 {
        (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
    }
    for k in 0..3 {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        (axes[p][k], axes[q][k]) = (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
    }
}
