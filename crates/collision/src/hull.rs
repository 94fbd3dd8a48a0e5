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

/// A point may be so far outside of its hull, relative to the size.
const OUTSIDE: f64 = 1e-5;

/// Triangles whose normals differ by less than this sine and whose planes agree are one face.
const FLAT: f64 = 1e-6;

impl Hull {
    /// The convex hull of points.
    ///
    /// # Errors
    /// A message if the points span no volume.
    pub fn new(points: &[DVec3]) -> Result<Self, String> {
        let direct =
            try_convex_hull(points).map_err(|e| e.to_string()).and_then(|hull| Self::of_triangles(hull, points));
        direct.or_else(|reason| {
            // The library loses thin membranes; stretched to a cube's proportions they have the same hull.
            let frame = Stretched::around(points).ok_or(reason.clone())?;
            let stretched: Vec<DVec3> = points.iter().map(|p| frame.stretch(*p)).collect();
            let (mut vertices, triangles) = try_convex_hull(&stretched).map_err(|_| reason)?;
            vertices.iter_mut().for_each(|p| *p = frame.restore(*p));
            Self::of_triangles((vertices, triangles), points)
        })
    }

    /// Checks triangles that claim to be the hull of points: they enclose a volume, and no point is outside.
    fn of_triangles((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>), points: &[DVec3]) -> Result<Self, String> {
        let center = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
        let size = vertices.iter().map(|p| (*p - center).length()).fold(0.0, f64::max);
        let volume: f64 = triangles.iter().map(|t| volume_below(&vertices, t, center)).sum();
        if volume.is_nan() || volume <= 1e-9 * size.powi(3) {
            return Err(format!("volume {volume:.3e} m³ at size {size:.3e} m"));
        }
        let faces = merge_faces(&vertices, &triangles, size);
        let outside = |f: &HullFace| points.iter().map(|p| f.normal.dot(*p) - f.offset).fold(0.0, f64::max);
        match faces.iter().map(outside).fold(0.0, f64::max) {
            farthest if farthest > OUTSIDE * size => Err(format!("a point is {farthest:.3e} m outside of its hull")),
            _ => Ok(Self { vertices, faces }),
        }
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

/// A right-handed frame along the length, breadth and thickness of points, with these as its units.
struct Stretched {
    origin: DVec3,
    axes: [DVec3; 3],
    extent: [f64; 3],
}

impl Stretched {
    /// None if the points lie in a plane to rounding.
    fn around(points: &[DVec3]) -> Option<Self> {
        let origin = *points.first()?;
        let farthest = |across: &dyn Fn(DVec3) -> DVec3| {
            let offsets = points.iter().map(|p| across(*p - origin));
            offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::ZERO)
        };
        let x = farthest(&|p| p).try_normalize()?;
        let y = farthest(&|p| p - x * x.dot(p)).try_normalize()?;
        let axes = [x, y, x.cross(y)];
        let extent = axes.map(|axis| {
            let along = |p: &DVec3| axis.dot(*p - origin);
            points.iter().map(along).fold(0.0, f64::max) - points.iter().map(along).fold(0.0, f64::min)
        });
        (extent[2] > 1e-9 * extent[0]).then_some(Self { origin, axes, extent })
    }

    fn stretch(&self, p: DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| self.axes[k].dot(p - self.origin) / self.extent[k]))
    }

    fn restore(&self, p: DVec3) -> DVec3 {
        let along = p.to_array();
        self.origin + (0..3).map(|k| self.axes[k] * (along[k] * self.extent[k])).sum::<DVec3>()
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
