//! Wavefront OBJ: vertices and faces of all objects of the file; normals, textures, materials, lines are passed over.

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

/// Faces with more than three corners are cut into the triangles of a fan about their first corner.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh::default();
    for (k, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let result = match words.next() {
            Some("v") => vertex(words).map(|p| mesh.vertices.push(p)),
            // A line or a point is no part of a surface.
            Some("f") => face(words, mesh.vertices.len()).map(|f| {
                let (first, rest) = f.split_first().unwrap_or((&0, &[]));
                mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }),
            _ => Ok(()),
        };
        result.map_err(|reason| format!("line {}: {reason}", k + 1))?;
    }
    // A face may name vertices that follow it.
    let count = mesh.vertices.len();
    match mesh.triangles.iter().flatten().find(|&&i| i as usize >= count) {
        Some(i) => Err(format!("a face names vertex {}, but there are only {count}", u64::from(*i) + 1)),
        None => Ok(mesh),
    }
}

/// Three finite numbers; a weight or a colour may follow.
fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut next = || words.next()?.parse().ok().filter(|x: &f64| x.is_finite());
    let numbers = (next(), next(), next());
    let (Some(x), Some(y), Some(z)) = numbers else { return Err("a vertex needs 3 finite numbers".into()) };
    Ok(DVec3::new(x, y, z))
}

/// Vertex indices from 0 of corners written `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1 or, if negative, back from
/// the last of the `count` vertices so far.
fn face<'a>(words: impl Iterator<Item = &'a str>, count: usize) -> Result<Vec<u32>, String> {
    let index = |word: &str| {
        let number: i64 = word.split('/').next()?.parse().ok()?;
        let from_zero = if number > 0 { number - 1 } else { number.checked_add(count as i64)? };
        u32::try_from(from_zero).ok().filter(|_| number != 0)
    };
    let corners: Option<Vec<u32>> = words.take_while(|w| !w.starts_with('#')).map(index).collect();
    match corners {
        Some(corners) if corners.is_empty() => Err("a face without corners".into()),
        Some(corners) => Ok(corners),
        None => Err("a face corner is not a vertex number".into()),
    }
}
