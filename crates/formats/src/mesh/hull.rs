//! Convex hull of a set of points, for what it weighs.

use std::collections::{HashMap, HashSet};

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

/// The hull as triangles that look outwards, point after point (Preparata & Shamos, Computational Geometry, §3.4.2).
/// None if the points lie in a plane. Points nearer to the hull than 1e-10 of its size count as on it.
///
/// # Cost
/// O(points · faces).
pub(crate) fn convex_hull(points: &[DVec3]) -> Option<Mesh> {
    let size = points.iter().map(|p| (*p - points[0]).length()).fold(0.0, f64::max);
    let slack = 1e-10 * size;
    let mut faces = tetrahedron(points, slack)?;
    for (k, &p) in points.iter().enumerate() {
        let sees = |f: &[usize; 3]| distance(points, f, p) > slack;
        let visible: Vec<[usize; 3]> = faces.iter().filter(|f| sees(f)).copied().collect();
        if visible.is_empty() {
            continue;
        }
        let edges: HashSet<(usize, usize)> = visible.iter().flat_map(edges_of).collect();
        faces.retain(|f| !sees(f));
        let mut horizon: Vec<_> = edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))).copied().collect();
        horizon.sort_unstable();
        faces.extend(horizon.into_iter().map(|(a, b)| [a, b, k]));
    }
    Some(compact(points, &faces))
}

fn edges_of(f: &[usize; 3]) -> [(usize, usize); 3] {
    [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]
}

/// Signed distance of `p` from the plane of a face, positive outside; −∞ for a face without area.
fn distance(points: &[DVec3], f: &[usize; 3], p: DVec3) -> f64 {
    let [a, b, c] = f.map(|k| points[k]);
    let normal = (b - a).cross(c - a);
    let length = normal.length();
    if length > 0.0 { normal.dot(p - a) / length } else { f64::NEG_INFINITY }
}

/// Four points far from each other's planes, as faces that look outwards.
fn tetrahedron(points: &[DVec3], slack: f64) -> Option<Vec<[usize; 3]>> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let best = (0..points.len()).max_by(|&i, &j| measure(points[i]).total_cmp(&measure(points[j])))?;
        (measure(points[best]) > slack).then_some(best)
    };
    let a = 0;
    let origin = *points.first()?;
    let b = farthest(&|p| (p - origin).length())?;
    let line = (points[b] - origin).normalize();
    let c = farthest(&|p| (p - origin).cross(line).length())?;
    let d = farthest(&|p| distance(points, &[a, b, c], p).abs())?;
    let (b, c) = if distance(points, &[a, b, c], points[d]) > 0.0 { (c, b) } else { (b, c) };
    Some(vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]])
}

/// The mesh of the faces with only the vertices that they use.
fn compact(points: &[DVec3], faces: &[[usize; 3]]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut known = HashMap::new();
    for face in faces {
        let triangle = face.map(|k| {
            *known.entry(k).or_insert_with(|| {
                mesh.vertices.push(points[k]);
                (mesh.vertices.len() - 1) as u32
            })
        });
        mesh.triangles.push(triangle);
    }
    mesh
}
