//! Mass, centre of mass and rotational inertia of shapes, and their sums.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{Geometry, Inertia, Pose};

use std::f64::consts::PI;

/// Inertia of a solid primitive of density 1 kg/m³ in its own frame; none for shapes without volume (plane, height
/// field) and for meshes, whose volume depends on how their faces are read.
///
/// # Source
/// Integrals of r² over the solids; the capsule is a cylinder and two half balls moved by the parallel-axis theorem.
pub(crate) fn solid(geometry: &Geometry) -> Option<Inertia> {
    let (mass, moments) = match *geometry {
        Geometry::Sphere { radius: r } => {
            let m = 4.0 / 3.0 * PI * r.powi(3);
            (m, DVec3::splat(0.4 * m * r * r))
        }
        Geometry::Box { half_extents: e } => {
            let m = 8.0 * e.x * e.y * e.z;
            (m, across(e * e) * (m / 3.0))
        }
        Geometry::Ellipsoid { semi_axes: e } => {
            let m = 4.0 / 3.0 * PI * e.x * e.y * e.z;
            (m, across(e * e) * (m / 5.0))
        }
        Geometry::Cylinder { radius: r, half_length: h } => {
            let m = 2.0 * PI * r * r * h;
            let side = m * (r * r / 4.0 + h * h / 3.0);
            (m, DVec3::new(side, side, m * r * r / 2.0))
        }
        Geometry::Capsule { radius: r, half_length: h } => {
            let cylinder = 2.0 * PI * r * r * h;
            let balls = 4.0 / 3.0 * PI * r.powi(3);
            let side = cylinder * (r * r / 4.0 + h * h / 3.0) + balls * (0.4 * r * r + h * h + 0.75 * h * r);
            (cylinder + balls, DVec3::new(side, side, cylinder * r * r / 2.0 + balls * 0.4 * r * r))
        }
        _ => return None,
    };
    Some(Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(moments) })
}

/// `(y² + z², x² + z², x² + y²)` from the squares.
fn across(squares: DVec3) -> DVec3 {
    DVec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y)
}

/// All masses multiplied by `factor`.
pub(crate) fn scaled(inertia: Inertia, factor: f64) -> Inertia {
    Inertia { mass: inertia.mass * factor, rotational: inertia.rotational * factor, ..inertia }
}

/// The inertia given in frame G, expressed in frame B where G stands at `X_BG`.
pub(crate) fn moved(inertia: Inertia, placement: &Pose) -> Inertia {
    let r = placement.rotation_matrix();
    Inertia {
        mass: inertia.mass,
        center_of_mass: placement.transform_point(inertia.center_of_mass),
        rotational: symmetric(r * inertia.rotational * r.transpose()),
    }
}

/// Several inertias in the same frame as one.
pub(crate) fn sum(parts: &[Inertia]) -> Inertia {
    let mass: f64 = parts.iter().map(|p| p.mass).sum();
    if mass <= 0.0 {
        return Inertia::ZERO;
    }
    let center_of_mass = parts.iter().map(|p| p.center_of_mass * p.mass).sum::<DVec3>() / mass;
    let about_center = |p: &Inertia| p.rotational + steiner(p.mass, p.center_of_mass - center_of_mass);
    let rotational = parts.iter().map(about_center).fold(DMat3::ZERO, |a, b| a + b);
    Inertia { mass, center_of_mass, rotational }
}

/// `m (|d|² 1 − d dᵀ)`: what a point mass adds at distance `d`.
pub(crate) fn steiner(mass: f64, d: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    (DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer) * mass
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
