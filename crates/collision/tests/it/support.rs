//! Support functions written for the tests: the reference of the property tests.

use glamx::glam::DVec3;
use signorini_multibody::{Geometry, Pose};

/// `max d·p` over the shape, m.
pub fn extent(shape: &Geometry, pose: &Pose, d: DVec3) -> f64 {
    let l = pose.rotation.conjugate() * d;
    let side = l.x.hypot(l.y);
    let local = match shape {
        Geometry::Sphere { radius } => radius * l.length(),
        Geometry::Box { half_extents: e } => e.x * l.x.abs() + e.y * l.y.abs() + e.z * l.z.abs(),
        Geometry::Capsule { radius, half_length } => radius * l.length() + half_length * l.z.abs(),
        Geometry::Cylinder { radius, half_length } => radius * side + half_length * l.z.abs(),
        Geometry::Cone { radius, half_length } => (half_length * l.z).max(radius * side - half_length * l.z),
        Geometry::Ellipsoid { semi_axes } => (*semi_axes * l).length(),
        Geometry::ConvexMesh(mesh) => mesh.vertices.iter().map(|p| p.dot(l)).fold(f64::NEG_INFINITY, f64::max),
        other => panic!("no support function for a {}", other.kind_name()),
    };
    local + d.dot(pose.position)
}

/// Separation of B from A along the unit vector `n`, m.
pub fn separation(a: (&Geometry, &Pose), b: (&Geometry, &Pose), n: DVec3) -> f64 {
    -extent(b.0, b.1, -n) - extent(a.0, a.1, n)
}

/// Directions spread evenly over the sphere (Fibonacci).
pub fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / count as f64;
        let r = (1.0 - z * z).sqrt();
        let angle = golden * k as f64;
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

/// The largest separation over all directions and where it is attained, by sampling and pattern search from the best samples.
pub fn largest_separation(a: (&Geometry, &Pose), b: (&Geometry, &Pose)) -> (f64, DVec3) {
    let value = |n: DVec3| separation(a, b, n);
    let mut starts: Vec<(f64, DVec3)> = directions(2000).map(|n| (value(n), n)).collect();
    starts.sort_by(|p, q| q.0.total_cmp(&p.0));
    let climb = |&(mut best, mut n): &(f64, DVec3)| {
        let mut step = 0.05;
        for _ in 0..300 {
            let (u, v) = n.any_orthonormal_pair();
            let around = (0..12).map(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
                (n + (u * cos + v * sin) * step).normalize()
            });
            match around.map(|m| (value(m), m)).max_by(|p, q| p.0.total_cmp(&q.0)) {
                Some((found, m)) if found > best => (best, n) = (found, m),
                _ => step *= 0.6,
            }
        }
        (best, n)
    };
    starts[..6].iter().map(climb).max_by(|p, q| p.0.total_cmp(&q.0)).unwrap()
}
