//! Convex polyhedra from point clouds, with flat faces merged into polygons.

use glamx::glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;

/// A convex polyhedron.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<HullFace>,
}

/// A flat face.
#[derive(Clone, Debug)]
pub(crate) struct HullFace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// `normal · p` of the face's points, m.
    pub offset: f64,
    /// Vertex indices, counter-clockwise seen from outside.
    pub loop_: Vec<u32>,
}

/// Triangles whose normals differ by less than this sine and whose planes agree are one face.
const FLAT: f64 = 1e-6;

impl Hull {
    /// The convex hull of points.
    ///
    /// # Errors
    /// A message if the points span no volume.
    pub fn new(points: &[DVec3]) -> Result<Self, String> {
        let (vertices, triangles) = try_convex_hull(points).map_err(|e| e.to_string())?;
        let center = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
        let size = vertices.iter().map(|p| (*p - center).length()).fold(0.0, f64::max);
        let volume: f64 = triangles.iter().map(|t| volume_below(&vertices, t, center)).sum();
        if volume.is_nan() || volume <= 1e-9 * size.powi(3) {
            return Err(format!("volume {volume:.3e} m³ at size {size:.3e} m"));
        }
        let faces = merge_faces(&vertices, &triangles, size);
        Ok(Self { vertices, faces })
    }

    /// A vertex farthest along `d`.
    pub fn support(&self, d: DVec3) -> DVec3 {
        self.vertices[self.support_index(d)]
    }

    /// Index of a vertex farthest along `d`, the first of equals.
    pub fn support_index(&self, d: DVec3) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (i, p) in self.vertices.iter().enumerate() {
            let reach = d.dot(*p);
            if reach > best.1 {
                best = (i, reach);
            }
        }
        best.0
    }

    /// The face whose normal is most along `d`, the first of equals.
    pub fn face_towards(&self, d: DVec3) -> &HullFace {
        let mut best = &self.faces[0];
        for face in &self.faces[1..] {
            if d.dot(face.normal) > d.dot(best.normal) {
                best = face;
            }
        }
        best
    }
}

fn volume_below(vertices: &[DVec3], t: &[u32; 3], center: DVec3) -> f64 {
    let [a, b, c] = t.map(|i| vertices[i as usize] - center);
    a.dot(b.cross(c)) / 6.0
}

/// One face per plane: all vertices on the plane of a triangle, in convex order.
fn merge_faces(vertices: &[DVec3], triangles: &[[u32; 3]], size: f64) -> Vec<HullFace> {
    let mut by_area: Vec<(f64, DVec3, f64)> = triangles
        .iter()
        .filter_map(|t| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            let area = (b - a).cross(c - a);
            let normal = area.try_normalize()?;
            Some((area.length(), normal, normal.dot(a).max(normal.dot(b)).max(normal.dot(c))))
        })
        .collect();
    by_area.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut faces: Vec<HullFace> = Vec::new();
    for (_, normal, offset) in by_area {
        let same = |f: &HullFace| f.normal.dot(normal) > 0.0 && f.normal.cross(normal).length() < FLAT;
        if faces.iter().any(|f| same(f) && (f.offset - offset).abs() < FLAT * size) {
            continue;
        }
        let on_plane = (0..vertices.len() as u32)
            .filter(|&i| (normal.dot(vertices[i as usize]) - offset).abs() < FLAT * size)
            .collect::<Vec<_>>();
        let loop_ = counter_clockwise(vertices, on_plane, normal);
        if loop_.len() >= 3 {
            faces.push(HullFace { normal, offset, loop_ });
        }
    }
    faces
}

fn counter_clockwise(vertices: &[DVec3], mut ids: Vec<u32>, normal: DVec3) -> Vec<u32> {
    let (u, v) = normal.any_orthonormal_pair();
    let center = ids.iter().map(|&i| vertices[i as usize]).sum::<DVec3>() / ids.len().max(1) as f64;
    let angle = |i: u32| {
        let r = vertices[i as usize] - center;
        // (u, v, n) is left- or right-handed by the choice of glam: the sign makes the order counter-clockwise.
        (r.dot(v) * u.cross(v).dot(normal)).atan2(r.dot(u))
    };
    ids.sort_by(|&i, &j| angle(i).total_cmp(&angle(j)));
    ids
}
