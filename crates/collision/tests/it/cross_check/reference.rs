//! The independent method: membership in closed form, and the best separation over all directions.

use glamx::glam::DVec3;
use signorini_multibody::{Geometry, Pose};

use crate::support::{directions, extent, separation};

/// A bound on the distance of a point from a shape, m: 0 inside.
pub fn outside((shape, pose): (&Geometry, &Pose), point: DVec3) -> f64 {
    let p = pose.rotation.conjugate() * (point - pose.position);
    let radial = p.x.hypot(p.y);
    let distance = match shape {
        Geometry::Plane => p.z,
        Geometry::Sphere { radius } => p.length() - radius,
        Geometry::Box { half_extents } => (p.abs() - half_extents).max(DVec3::ZERO).length(),
        Geometry::Capsule { radius, half_length } => {
            (p - DVec3::Z * p.z.clamp(-half_length, *half_length)).length() - radius
        }
        Geometry::Cylinder { radius, half_length } => {
            (radial - radius).max(0.0).hypot((p.z.abs() - half_length).max(0.0))
        }
        Geometry::Cone { radius, half_length } => {
            // Along the axis into the slab, then towards the axis.
            let z = p.z.clamp(-half_length, *half_length);
            let here = radius * (half_length - z) / (2.0 * half_length);
            (radial - here).max(0.0).hypot(p.z - z)
        }
        Geometry::Ellipsoid { semi_axes } => p.length() * (1.0 - 1.0 / (p / semi_axes).length().max(1.0)),
        Geometry::ConvexMesh(mesh) => {
            // The largest excess over a facet; a corner's neighbourhood is that sharp to a factor of its angles.
            facets(&mesh.vertices).iter().map(|(n, d)| n.dot(p) - d).fold(f64::NEG_INFINITY, f64::max)
        }
        other => panic!("no membership for a {}", other.kind_name()),
    };
    distance.max(0.0)
}

/// Facets of a hull by trying all triples of vertices: outward unit normal and offset.
fn facets(vertices: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut found: Vec<(DVec3, f64)> = Vec::new();
    for i in 0..vertices.len() {
        for j in 0..i {
            for k in 0..j {
                let Some(n) = (vertices[j] - vertices[i]).cross(vertices[k] - vertices[i]).try_normalize() else {
                    continue;
                };
                let d = n.dot(vertices[i]);
                let side = |s: f64| vertices.iter().all(|v| s * (n.dot(*v) - d) <= 1e-12);
                for s in [1.0, -1.0] {
                    if side(s) && !found.iter().any(|(m, _)| m.dot(n * s) > 1.0 - 1e-15) {
                        found.push((n * s, d * s));
                    }
                }
            }
        }
    }
    found
}

/// Directions of all edges of a hull: where two of its facets meet, and perhaps more.
fn edges(facets: &[(DVec3, f64)]) -> Vec<DVec3> {
    let mut found: Vec<DVec3> = Vec::new();
    for (i, (m, _)) in facets.iter().enumerate() {
        for (n, _) in &facets[..i] {
            if let Some(edge) = m.cross(*n).try_normalize()
                && !found.iter().any(|e| e.dot(edge).abs() > 1.0 - 1e-14)
            {
                found.push(edge);
            }
        }
    }
    found
}

/// Corners of a polyhedron in world.
fn corners((shape, pose): (&Geometry, &Pose)) -> Option<Vec<DVec3>> {
    match shape {
        Geometry::Box { half_extents } => {
            let sign = |k: u32, bit: u32| if k & bit == 0 { -1.0 } else { 1.0 };
            let corner = |k| *half_extents * DVec3::new(sign(k, 1), sign(k, 2), sign(k, 4));
            Some((0..8).map(|k| pose.transform_point(corner(k))).collect())
        }
        Geometry::ConvexMesh(mesh) => Some(mesh.vertices.iter().map(|v| pose.transform_point(*v)).collect()),
        _ => None,
    }
}

/// Two shapes as seen from directions.
pub struct Vantage<'a> {
    a: (&'a Geometry, &'a Pose),
    b: (&'a Geometry, &'a Pose),
}

impl<'a> Vantage<'a> {
    pub fn new(a: (&'a Geometry, &'a Pose), b: (&'a Geometry, &'a Pose)) -> Self {
        Self { a, b }
    }

    /// Separation along a unit vector from A to B, m.
    pub fn separation(&self, n: DVec3) -> f64 {
        match self.a.0 {
            Geometry::Plane if (n - DVec3::Z).length() < 1e-12 => -extent(self.b.0, self.b.1, -n),
            Geometry::Plane => f64::NEG_INFINITY,
            _ => separation(self.a, self.b, n),
        }
    }

    /// The largest separation: for polyhedra also over the normals of all facets and all pairs of edges, among which that of two that
    /// overlap is; else, and besides, by climbing from the best of many directions.
    pub fn best(&self) -> f64 {
        if matches!(self.a.0, Geometry::Plane) {
            return self.separation(DVec3::Z);
        }
        let mut best = f64::NEG_INFINITY;
        if let (Some(a), Some(b)) = (corners(self.a), corners(self.b)) {
            let (facets_a, facets_b) = (facets(&a), facets(&b));
            let (edges_a, edges_b) = (edges(&facets_a), edges(&facets_b));
            let mut axes: Vec<DVec3> = facets_a.iter().chain(&facets_b).map(|f| f.0).collect();
            for e in &edges_a {
                // Nearly parallel edges have no direction of their own.
                axes.extend(edges_b.iter().map(|f| e.cross(*f)).filter(|n| n.length() > 1e-6).map(DVec3::normalize));
            }
            best = axes.iter().flat_map(|n| [*n, -*n]).map(|n| self.separation(n)).fold(best, f64::max);
            if best < 0.0 {
                return best;
            }
        }
        let mut starts: Vec<(f64, DVec3)> = directions(600).map(|n| (self.separation(n), n)).collect();
        starts.sort_by(|p, q| q.0.total_cmp(&p.0));
        starts[..5].iter().map(|start| self.climb(*start)).fold(best, f64::max)
    }

    /// Pattern search whose star turns from step to step, so that it finds its way along ridges.
    fn climb(&self, (mut best, mut n): (f64, DVec3)) -> f64 {
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let mut step = 0.1;
        for k in 0..400 {
            let (u, v) = n.any_orthonormal_pair();
            let around = (0..6).map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_3 + f64::from(k) * GOLDEN).sin_cos();
                (n + (u * cos + v * sin) * step).normalize()
            });
            match around.map(|m| (self.separation(m), m)).max_by(|p, q| p.0.total_cmp(&q.0)) {
                Some((found, m)) if found > best => (best, n, step) = (found, m, 1.3 * step),
                _ => step *= 0.7,
            }
            if step < 1e-12 {
                break;
            }
        }
        best
    }
}
