//! STL, binary and text.

use std::collections::HashMap;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads a binary or a text STL. A file is binary if its length is what its triangle count says; many binary files begin
/// with the word "solid" too.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let needed = |n: usize| n.checked_mul(TRIANGLE).and_then(|m| m.checked_add(HEADER));
    match count {
        Some(n) if needed(n) == Some(bytes.len()) => binary(bytes, n),
        _ if is_text(bytes) => text(bytes),
        Some(n) if needed(n).is_some_and(|m| m < bytes.len()) => binary(bytes, n),
        Some(n) => Err(format!("a binary STL with {n} triangles must be longer than {} bytes", bytes.len())),
        None => Err("too short for an STL file".into()),
    }
}

fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.starts_with(b"solid") && start[..start.len().min(4096)].windows(5).any(|w| w == b"facet")
}

fn binary(bytes: &[u8], count: usize) -> Result<Mesh, String> {
    let mut welder = Welder::default();
    for (k, record) in bytes[HEADER..].chunks_exact(TRIANGLE).take(count).enumerate() {
        let number = |i: usize| f64::from(f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]));
        let corner = |i: usize| DVec3::new(number(12 + 12 * i), number(16 + 12 * i), number(20 + 12 * i));
        welder.triangle([corner(0), corner(1), corner(2)]).map_err(|e| format!("triangle {k}: {e}"))?;
    }
    Ok(welder.mesh)
}

fn text(bytes: &[u8]) -> Result<Mesh, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut welder = Welder::default();
    let mut corners = Vec::with_capacity(3);
    for (k, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => corners.push(vertex(words).ok_or(format!("line {}: expected 3 numbers", k + 1))?),
            Some("endloop") => {
                let triangle = <[DVec3; 3]>::try_from(corners.as_slice())
                    .map_err(|_| format!("line {}: a facet with {} vertices", k + 1, corners.len()))?;
                welder.triangle(triangle).map_err(|e| format!("line {}: {e}", k + 1))?;
                corners.clear();
            }
            _ => {}
        }
    }
    Ok(welder.mesh)
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut next = || words.next()?.parse().ok();
    Some(DVec3::new(next()?, next()?, next()?))
}

/// Gives vertices at the same place the same index.
#[derive(Default)]
struct Welder {
    mesh: Mesh,
    known: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn triangle(&mut self, corners: [DVec3; 3]) -> Result<(), String> {
        if corners.iter().any(|p| !p.is_finite()) {
            return Err("a vertex is not finite".into());
        }
        let triangle = corners.map(|p| self.index(p));
        self.mesh.triangles.push(triangle);
        Ok(())
    }

    fn index(&mut self, p: DVec3) -> u32 {
        let key = (p + DVec3::ZERO).to_array().map(f64::to_bits);
        *self.known.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(p);
            (self.mesh.vertices.len() - 1) as u32
        })
    }
}
