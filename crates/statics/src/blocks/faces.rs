//! Where faces of two solids lie on each other.

use signorini_multibody::convex_outline;
use signorini_multibody::glam::{DVec2, DVec3};
use signorini_multibody::model::Mesh;

/// Faces whose normals are less opposite than this do not lie on each other, whatever their distance.
const OPPOSITE: f64 = -0.9;
/// Triangles of one plane have normals this close.
const ONE_PLANE: f64 = 1.0 - 1e-12;

/// The part of two solids' surfaces where one plane of each lies on the other.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Corners of its convex hull in world, m: forces there are worth as much as any over the patch.
    pub corners: Vec<DVec3>,
    /// Unit normal from the first solid to the second.
    pub normal: DVec3,
}

/// Triangles of a solid in one plane.
#[derive(Clone, Debug)]
struct Facet {
    normal: DVec3,
    origin: DVec3,
    triangles: Vec<[DVec3; 3]>,
    bounds: [DVec3; 2],
}

/// The surface of a solid, with normals that look outward.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    facets: Vec<Facet>,
    pub bounds: [DVec3; 2],
}

impl Surface {
    /// Of a closed mesh with faces that all look to one side. `tolerance`: of planes, m.
    pub fn new(mesh: &Mesh, tolerance: f64) -> Self {
        let corners = |t: &[u32; 3]| t.map(|k| mesh.vertices[k as usize]);
        let volume: f64 = mesh.triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let mut facets: Vec<Facet> = Vec::new();
        for [a, b, c] in mesh.triangles.iter().map(corners) {
            let triangle = if volume < 0.0 { [a, c, b] } else { [a, b, c] };
            let Some(normal) = (triangle[1] - a).cross(triangle[2] - a).try_normalize() else { continue };
            let bounds = bounds(&triangle);
            let in_plane = |f: &&mut Facet| {
                f.normal.dot(normal) > ONE_PLANE
                    && triangle.iter().all(|p| (p - f.origin).dot(f.normal).abs() <= 0.5 * tolerance)
            };
            match facets.iter_mut().find(in_plane) {
                Some(facet) => {
                    facet.bounds = [facet.bounds[0].min(bounds[0]), facet.bounds[1].max(bounds[1])];
                    facet.triangles.push(triangle);
                }
                None => facets.push(Facet { normal, origin: a, triangles: vec![triangle], bounds }),
            }
        }
        let all: Vec<DVec3> = facets.iter().flat_map(|f| f.bounds).collect();
        Self { bounds: bounds(&all), facets }
    }

    /// Where another solid lies on it.
    pub fn touching(&self, other: &Self, tolerance: f64) -> Vec<Patch> {
        let mut patches = Vec::new();
        for a in self.facets.iter().filter(|a| overlap(&a.bounds, &other.bounds, tolerance)) {
            let near = |b: &&Facet| a.normal.dot(b.normal) < OPPOSITE && overlap(&a.bounds, &b.bounds, tolerance);
            for b in other.facets.iter().filter(near) {
                let mut points = Vec::new();
                for triangle in &a.triangles {
                    b.triangles.iter().for_each(|other| meet(a, triangle, other, tolerance, &mut points));
                }
                patches.extend(patch(points, a.normal, tolerance));
            }
        }
        patches
    }

    /// Where it lies on the plane `z = height`; the normals look up.
    pub fn on_floor(&self, height: f64, tolerance: f64) -> Vec<Patch> {
        let on = |p: &DVec3| (p.z - height).abs() <= tolerance;
        let flat = |f: &&Facet| f.normal.z < OPPOSITE && f.triangles.iter().flatten().all(on);
        let lying = self.facets.iter().filter(flat);
        lying.filter_map(|f| patch(f.triangles.iter().flatten().copied().collect(), DVec3::Z, tolerance)).collect()
    }
}

fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points.iter().fold(start, |[low, high], p| [low.min(*p), high.max(*p)])
}

/// Whether two boxes come within a distance.
pub(super) fn overlap(a: &[DVec3; 2], b: &[DVec3; 2], distance: f64) -> bool {
    let apart = (a[0] - b[1]).max(b[0] - a[1]);
    apart.max_element() <= distance
}

/// Adds the corners of what two triangles have in common, if it lies within the tolerance of both planes: midway between them.
fn meet(a: &Facet, triangle: &[DVec3; 3], other: &[DVec3; 3], tolerance: f64, points: &mut Vec<DVec3>) {
    if !overlap(&bounds(triangle), &bounds(other), tolerance) {
        return;
    }
    let mut polygon = other.to_vec();
    for k in 0..3 {
        let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
        polygon = clipped(&polygon, from, a.normal.cross(to - from));
        if polygon.len() < 3 {
            return;
        }
    }
    let height = |p: &DVec3| (p - a.origin).dot(a.normal);
    let fan = polygon[1..].windows(2).map(|w| (w[0] - polygon[0]).cross(w[1] - polygon[0]));
    let area = fan.sum::<DVec3>().length();
    let longest = polygon.iter().map(|p| p.distance(polygon[0])).fold(0.0, f64::max);
    if area > tolerance * longest && polygon.iter().all(|p| height(p).abs() <= tolerance) {
        points.extend(polygon.iter().map(|p| p - 0.5 * height(p) * a.normal));
    }
}

/// The part of a polygon on the side of a plane to which its normal looks (I. Sutherland, G. Hodgman, CACM 17, 1974).
fn clipped(polygon: &[DVec3], on_plane: DVec3, normal: DVec3) -> Vec<DVec3> {
    let side = |p: DVec3| (p - on_plane).dot(normal);
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (s, t) = (side(p), side(next));
        if s >= 0.0 {
            out.push(p);
        }
        if (s < 0.0) != (t < 0.0) {
            out.push(p + (next - p) * (s / (s - t)));
        }
    }
    out
}

/// A patch from points of a plane: the corners of their hull.
fn patch(points: Vec<DVec3>, normal: DVec3, tolerance: f64) -> Option<Patch> {
    let across = normal.any_orthonormal_vector();
    let along = normal.cross(across);
    let flat: Vec<DVec2> = points.iter().map(|p| DVec2::new(p.dot(across), p.dot(along))).collect();
    let hull = convex_outline(&flat).into_iter().map(|k| points[k]).collect();
    let corners = without_idle(hull, 0.1 * tolerance);
    (corners.len() >= 3).then_some(Patch { corners, normal })
}

/// The corners of a polygon less those that lie on the side between their neighbours. Beyond its ends a corner is none of the side's, as near
/// as it may be to its line: rounding puts points of a side outside of it, and the last of them is no reason to lose the corner behind it.
fn without_idle(mut corners: Vec<DVec3>, tolerance: f64) -> Vec<DVec3> {
    let mut k = 0;
    while k < corners.len() && corners.len() >= 3 {
        let n = corners.len();
        let (from, to) = (corners[(k + n - 1) % n], corners[(k + 1) % n]);
        let (side, corner) = (to - from, corners[k] - from);
        let part = corner.dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
        if corner.distance(part.clamp(0.0, 1.0) * side) <= tolerance {
            corners.remove(k);
        } else {
            k += 1;
        }
    }
    corners
}
