//! Meshes as unions of convex parts.

use glamx::glam::DVec3;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use signorini_multibody::model::Mesh;

use crate::convex_hull;

/// Voxels along the longest side of a mesh: what is thinner than one of them may be filled. Chosen with the library's default in mind, at
/// which a mesh of a robot takes less than a second.
const VOXELS: u32 = 64;

/// A mesh has at most so many parts.
const MOST_PARTS: u32 = 64;

/// Parts with less than this share of the volume of the mesh's hull are nothing but rounding of voxels.
const SMALLEST: f64 = 1e-6;

/// A closed mesh as a union of convex parts, by approximate convex decomposition of its voxels (K. Mamou, "Volumetric hierarchical
/// approximate convex decomposition", Game Engine Gems 3, 2016). The parts are hulls of pieces of the mesh's own surface, so that they stay
/// inside its hull; they may overlap each other, and fill what is thinner than a 64th of its longest side. The same mesh has the same parts.
///
/// - `concavity`: how far a part may be from convex, in (0, 1]: the volume that its hull has and the mesh has not, over that of the
///   mesh's hull; with 1 there is one part, the hull
///
/// # Errors
/// A message if the mesh has no triangles, a number that is not finite or an index out of range, or if it encloses no volume.
pub fn convex_parts(mesh: &Mesh, concavity: f64) -> Result<Vec<Mesh>, String> {
    if !(concavity > 0.0 && concavity <= 1.0) {
        return Err(format!("a concavity of {concavity}: it must be in (0, 1]"));
    }
    let count = mesh.vertices.len();
    if mesh.triangles.is_empty() || mesh.triangles.iter().flatten().any(|&i| i as usize >= count) {
        return Err("a mesh without triangles, or one that names vertices that it does not have".into());
    }
    let whole = convex_hull(&mesh.vertices)?;
    if concavity == 1.0 {
        return Ok(vec![whole]);
    }
    let parameters =
        VHACDParameters { concavity, resolution: VOXELS, max_convex_hulls: MOST_PARTS, ..VHACDParameters::default() };
    // In a unit box no length of the library is small.
    let (low, high) = mesh.vertices.iter().fold((DVec3::MAX, DVec3::MIN), |(a, b), p| (a.min(*p), b.max(*p)));
    let size = (high - low).max_element();
    let vertices: Vec<DVec3> = mesh.vertices.iter().map(|p| (*p - low) / size).collect();
    let found = VHACD::decompose(&parameters, &vertices, &mesh.triangles, true);
    let smallest = SMALLEST * volume(&whole);
    let hulls = found.compute_primitive_intersections(&vertices, &mesh.triangles).into_iter().filter_map(|points| {
        let points: Vec<DVec3> = points.into_iter().map(|p| p * size + low).collect();
        convex_hull(&points).ok().filter(|hull| volume(hull) > smallest)
    });
    let parts: Vec<Mesh> = hulls.collect();
    Ok(if parts.is_empty() { vec![whole] } else { parts })
}

/// Of the solid inside a closed surface, m³.
fn volume(mesh: &Mesh) -> f64 {
    let corner = |i: u32| mesh.vertices[i as usize];
    mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of boxes in a grid of unit cells, those for which `solid` holds.
    fn cells(n: i32, solid: impl Fn(i32, i32, i32) -> bool) -> Mesh {
        let inside = |[x, y, z]: [i32; 3]| [x, y, z].iter().all(|k| (0..n).contains(k)) && solid(x, y, z);
        let mut mesh = Mesh::default();
        for cell in (0..n * n * n).map(|k| [k % n, k / n % n, k / n / n]).filter(|cell| inside(*cell)) {
            for (axis, step) in [(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)] {
                let mut beside = cell;
                beside[axis] += step;
                if inside(beside) {
                    continue;
                }
                let place = DVec3::from(cell.map(f64::from)) + DVec3::splat(0.5);
                let [normal, u, v] = [0, 1, 2].map(|k| DVec3::AXES[(axis + k) % 3] * 0.5);
                let (out, first) = (place + normal * f64::from(step), mesh.vertices.len() as u32);
                mesh.vertices.extend([out - u - v, out + u - v, out + u + v, out - u + v]);
                let turn = |[a, b, c]: [u32; 3]| if step > 0 { [a, b, c] } else { [a, c, b] };
                mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| turn(t.map(|i| i + first))));
            }
        }
        mesh
    }

    /// Whether a part holds a point, from the signs of its faces.
    fn holds(part: &Mesh, point: DVec3, margin: f64) -> bool {
        part.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| part.vertices[i as usize]);
            let normal = (b - a).cross(c - a);
            normal.dot(point - a) <= margin * normal.length()
        })
    }

    #[test]
    fn a_frame_keeps_its_hole_and_all_of_its_solid() {
        let frame = cells(6, |x, y, z| z < 2 && !((2..4).contains(&x) && (2..4).contains(&y)));
        let parts = convex_parts(&frame, 0.01).unwrap();
        assert!((4..20).contains(&parts.len()), "{}", parts.len());
        assert!(!parts.iter().any(|part| holds(part, DVec3::new(3.0, 3.0, 1.0), 0.0)), "the hole is filled");
        for k in 0..6 * 6 * 2 {
            let place = DVec3::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)) + DVec3::splat(0.5);
            if (place - DVec3::new(3.0, 3.0, place.z)).abs().max_element() > 1.0 {
                assert!(parts.iter().any(|part| holds(part, place, 1e-9)), "nothing holds {place}");
            }
        }
        // Neighbours overlap by the voxels that the cuts go through.
        let sum: f64 = parts.iter().map(volume).sum();
        assert!((sum / volume(&frame) - 1.0).abs() < 0.15, "{sum} of {}", volume(&frame));
        assert_eq!(convex_parts(&frame, 0.01).unwrap(), parts);
    }

    #[test]
    fn what_is_convex_is_one_part() {
        let block = cells(2, |_, _, z| z < 1);
        let parts = convex_parts(&block, 0.01).unwrap();
        assert_eq!(parts.len(), 1);
        assert!((volume(&parts[0]) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_taken_apart_is_refused() {
        let block = cells(1, |_, _, _| true);
        assert!(convex_parts(&block, 0.0).is_err() && convex_parts(&block, f64::NAN).is_err());
        assert!(convex_parts(&Mesh { triangles: Vec::new(), ..block.clone() }, 0.1).is_err());
        assert!(convex_parts(&Mesh { triangles: vec![[0, 1, 99]], ..block.clone() }, 0.1).is_err());
        assert!(convex_parts(&Mesh { vertices: vec![DVec3::NAN; block.vertices.len()], ..block }, 0.1).is_err());
    }
}
