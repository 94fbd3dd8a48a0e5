//! Mass properties of triangle meshes.

use signorini_multibody::Inertia;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::model::Mesh;

use crate::inertia::symmetric;

/// How the volume under a face is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Orientation {
    /// By the side to which the face looks: exact for closed, consistently oriented meshes.
    Signed,
    /// Always as positive: exact for convex meshes, too much for others, whatever way the faces look.
    Ignored,
}

/// Inertia of the solid inside a mesh at density 1 kg/m³. The tetrahedra from each face to the centroid of the surface
/// give the centre of mass, those to the centre of mass the rest; this matters only where their sign is ignored, and is
/// what MuJoCo does. None if there is no volume.
///
/// # Source
/// F. Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor, J. Math. Stat. 1 (2005).
pub(crate) fn solid(mesh: &Mesh, orientation: Orientation) -> Option<Inertia> {
    let inner = surface_centroid(mesh)?;
    let volume = |[a, b, c]: [DVec3; 3], apex: DVec3| {
        let v = (a - apex).dot((b - apex).cross(c - apex)) / 6.0;
        if orientation == Orientation::Ignored { v.abs() } else { v }
    };
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for [a, b, c] in faces(mesh) {
        let v = volume([a, b, c], inner);
        mass += v;
        moment += (a + b + c + inner) * (v / 4.0);
    }
    if mass.is_nan() || mass <= 1e-30 {
        return None;
    }
    let center_of_mass = moment / mass;
    let (mut mass, mut second) = (0.0, DMat3::ZERO);
    for face in faces(mesh) {
        let v = volume(face, center_of_mass);
        mass += v;
        second += tetrahedron(face.map(|p| p - center_of_mass)) * v;
    }
    Some(Inertia { mass, center_of_mass, rotational: from_second_moment(second) })
}

/// Inertia of the surface of a mesh at 1 kg/m². None if there is no area.
pub(crate) fn shell(mesh: &Mesh) -> Option<Inertia> {
    let center_of_mass = surface_centroid(mesh)?;
    let (mut mass, mut second) = (0.0, DMat3::ZERO);
    for face in faces(mesh) {
        let [a, b, c] = face.map(|p| p - center_of_mass);
        let area = (b - a).cross(c - a).length() / 2.0;
        let s = a + b + c;
        mass += area;
        second += (outer(a) + outer(b) + outer(c) + outer(s)) * (area / 12.0);
    }
    Some(Inertia { mass, center_of_mass, rotational: from_second_moment(second) })
}

/// Mean of the faces' centroids weighted by area.
fn surface_centroid(mesh: &Mesh) -> Option<DVec3> {
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for [a, b, c] in faces(mesh) {
        let s = (b - a).cross(c - a).length() / 2.0;
        area += s;
        moment += (a + b + c) * (s / 3.0);
    }
    (area > 0.0 && area.is_finite()).then(|| moment / area)
}

fn faces(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    mesh.triangles.iter().map(|t| t.map(|k| mesh.vertices[k as usize]))
}

/// `∫ p pᵀ / V` over the tetrahedron of the origin and three points: `(Σ pᵢ pᵢᵀ + s sᵀ) / 20`, `s = Σ pᵢ`.
fn tetrahedron([a, b, c]: [DVec3; 3]) -> DMat3 {
    (outer(a) + outer(b) + outer(c) + outer(a + b + c)) * (1.0 / 20.0)
}

fn outer(p: DVec3) -> DMat3 {
    DMat3::from_cols(p * p.x, p * p.y, p * p.z)
}

/// `tr(S) 1 − S`.
fn from_second_moment(s: DMat3) -> DMat3 {
    let trace = s.x_axis.x + s.y_axis.y + s.z_axis.z;
    symmetric(DMat3::from_diagonal(DVec3::splat(trace)) - s)
}
