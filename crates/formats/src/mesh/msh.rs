//! MSH, MuJoCo's own binary mesh format.

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

use super::painted::Painted;

const HEADER: usize = 16;

/// Four counts (vertices, normals, texture coordinates, faces), then the numbers in that order, all 32-bit little-endian.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    read_painted(bytes).map(|painted| painted.mesh)
}

/// The same with image coordinates, whose v leads down in the file.
pub(super) fn read_painted(bytes: &[u8]) -> Result<Painted, String> {
    let word = |k: usize| bytes.get(4 * k..4 * k + 4).map(|b| [b[0], b[1], b[2], b[3]]);
    let header: Option<Vec<i32>> = (0..HEADER / 4).map(|k| word(k).map(i32::from_le_bytes)).collect();
    let header = header.ok_or("too short for an MSH file")?;
    let counts: Option<Vec<usize>> = header.iter().map(|&n| usize::try_from(n).ok()).collect();
    let [vertices, normals, textures, faces] = counts.ok_or("an MSH file with negative counts")?[..] else {
        return Err("an MSH file without four counts".into());
    };
    let words = 3 * (vertices as u64 + normals as u64 + faces as u64) + 2 * textures as u64;
    if HEADER as u64 + 4 * words != bytes.len() as u64 {
        return Err("an MSH file whose length is not what its counts say".into());
    }
    let number = |k: usize| word(k + HEADER / 4).map_or(0.0, |b| f64::from(f32::from_le_bytes(b)));
    let index = |k: usize| word(k + HEADER / 4).map_or(u32::MAX, u32::from_le_bytes);
    let first_face = 3 * vertices + 3 * normals + 2 * textures;
    let mesh = Mesh {
        vertices: (0..vertices).map(|k| DVec3::new(number(3 * k), number(3 * k + 1), number(3 * k + 2))).collect(),
        triangles: (0..faces).map(|k| [0, 1, 2].map(|i| index(first_face + 3 * k + i))).collect(),
    };
    if mesh.triangles.iter().flatten().any(|&k| k as usize >= vertices) {
        return Err("a face names a vertex that is not there".into());
    }
    if let Some(k) = mesh.vertices.iter().position(|p| !p.is_finite()) {
        return Err(format!("vertex {k} is not finite"));
    }
    let place = |k: u32| {
        let at = 3 * vertices + 3 * normals + 2 * k as usize;
        [number(at) as f32, 1.0 - number(at + 1) as f32]
    };
    let with_places = textures == vertices && textures > 0;
    let corners = if with_places { mesh.triangles.iter().map(|t| t.map(place)).collect() } else { Vec::new() };
    Ok(Painted { mesh, corners, ..Painted::default() })
}
