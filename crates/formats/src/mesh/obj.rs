//! Wavefront OBJ: vertices and faces of all objects of the file, their image coordinates and materials; normals and lines are passed over.

use std::collections::HashMap;
use std::path::Path;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

use super::bytes::read_file;
use super::mtl;
use super::painted::{Corners, NOWHERE, Painted};

/// Libraries of materials larger than this are passed over.
const MAX_LIBRARY: u64 = 16 << 20;

/// A file as it is read.
#[derive(Default)]
struct Reading<'a> {
    mesh: Mesh,
    places: Vec<[f32; 2]>,
    /// Of every triangle, counted from 0; none where a corner has none.
    places_of: Vec<Option<[u32; 3]>>,
    libraries: Vec<&'a str>,
    materials: Vec<&'a str>,
    known: HashMap<&'a str, u32>,
    paint_of: Vec<u32>,
    paint: u32,
    /// Objects: the first triangle and the name.
    objects: Vec<(usize, String)>,
}

/// Reads the triangles.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    Reading::of(&String::from_utf8_lossy(bytes)).map(|reading| reading.mesh)
}

/// Reads the triangles and what is on them; libraries of materials that cannot be read are passed over.
///
/// - `folder`: that of the file
pub(super) fn read_painted(bytes: &[u8], folder: &Path) -> Result<Painted, String> {
    let text = String::from_utf8_lossy(bytes);
    let reading = Reading::of(&text)?;
    let mut named = HashMap::new();
    for library in &reading.libraries {
        let path = folder.join(library.replace('\\', "/"));
        let Ok(bytes) = read_file(&path, MAX_LIBRARY) else { continue };
        named.extend(mtl::read(&String::from_utf8_lossy(&bytes), path.parent().unwrap_or(folder)));
    }
    let paints = reading.materials.iter().map(|name| named.get(*name).cloned().unwrap_or_default()).collect();
    let place = |k: u32| reading.places.get(k as usize).copied().unwrap_or([f32::NAN; 2]);
    let corners: Vec<Corners> = reading.places_of.iter().map(|of| of.map_or(NOWHERE, |of| of.map(place))).collect();
    Ok(Painted { mesh: reading.mesh, corners, paint_of: reading.paint_of, paints, parts: reading.objects })
}

impl<'a> Reading<'a> {
    /// Faces with more than three corners are cut into the triangles of a fan about their first corner.
    fn of(text: &'a str) -> Result<Self, String> {
        let mut reading = Self { paint: u32::MAX, ..Self::default() };
        for (k, line) in text.lines().enumerate() {
            let mut words = line.split_ascii_whitespace();
            let result = match words.next() {
                Some("v") => vertex(words).map(|p| reading.mesh.vertices.push(p)),
                Some("vt") => {
                    let mut next = || words.next()?.parse().ok();
                    reading.places.push([next().unwrap_or(f32::NAN), next().unwrap_or(0.0)]);
                    Ok(())
                }
                // A line or a point is no part of a surface.
                Some("f") => reading.face(words),
                Some("mtllib") => {
                    reading.libraries.push(line.trim()["mtllib".len()..].trim());
                    Ok(())
                }
                Some("o") => {
                    reading.objects.push((reading.mesh.triangles.len(), line.trim()["o".len()..].trim().to_owned()));
                    Ok(())
                }
                Some("usemtl") => {
                    reading.use_material(line.trim()["usemtl".len()..].trim());
                    Ok(())
                }
                _ => Ok(()),
            };
            result.map_err(|reason| format!("line {}: {reason}", k + 1))?;
        }
        // A face may name vertices that follow it.
        let count = reading.mesh.vertices.len();
        match reading.mesh.triangles.iter().flatten().find(|&&i| i as usize >= count) {
            Some(i) => Err(format!("a face names vertex {}, but there are only {count}", u64::from(*i) + 1)),
            None => Ok(reading),
        }
    }

    fn face(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let corners = face(words, self.mesh.vertices.len(), self.places.len())?;
        let (first, rest) = corners.split_first().ok_or("a face without corners")?;
        for pair in rest.windows(2) {
            let triangle = [*first, pair[0], pair[1]];
            self.mesh.triangles.push(triangle.map(|(vertex, _)| vertex));
            let [a, b, c] = triangle.map(|(_, place)| place);
            self.places_of.push(a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]));
            self.paint_of.push(self.paint);
        }
        Ok(())
    }

    fn use_material(&mut self, name: &'a str) {
        let materials = &mut self.materials;
        self.paint = *self.known.entry(name).or_insert_with(|| {
            materials.push(name);
            materials.len() as u32 - 1
        });
    }
}

/// Three finite numbers; a weight or a colour may follow.
fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut next = || words.next()?.parse().ok().filter(|x: &f64| x.is_finite());
    let numbers = (next(), next(), next());
    let (Some(x), Some(y), Some(z)) = numbers else { return Err("a vertex needs 3 finite numbers".into()) };
    Ok(DVec3::new(x, y, z))
}

/// Vertices and image coordinates, from 0, of corners written `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1 or, if negative, back from
/// the last of the `vertices` and `places` so far.
fn face<'a>(
    words: impl Iterator<Item = &'a str>,
    vertices: usize,
    places: usize,
) -> Result<Vec<(u32, Option<u32>)>, String> {
    let index = |word: Option<&str>, count: usize| {
        let number: i64 = word?.parse().ok()?;
        let from_zero = if number > 0 { number - 1 } else { number.checked_add(count as i64)? };
        u32::try_from(from_zero).ok().filter(|_| number != 0)
    };
    let corner = |word: &'a str| {
        let mut parts = word.split('/');
        Some((index(parts.next(), vertices)?, index(parts.next(), places)))
    };
    let corners: Option<Vec<_>> = words.take_while(|w| !w.starts_with('#')).map(corner).collect();
    match corners {
        Some(corners) if corners.is_empty() => Err("a face without corners".into()),
        Some(corners) => Ok(corners),
        None => Err("a face corner is not a vertex number".into()),
    }
}
