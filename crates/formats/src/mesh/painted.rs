//! Meshes with what their files say of their surfaces.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use signorini_multibody::Image;
use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

/// Image coordinates of the corners of a triangle, as [`Spread::Corners`](signorini_multibody::Spread) has them.
pub(crate) type Corners = [[f32; 2]; 3];

/// An image that a surface names.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// A file.
    File(PathBuf),
    /// Inside the mesh file.
    Here(Arc<Image>),
}

/// Colour of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Paint {
    /// Red, green, blue, opacity; none where the file does not say.
    pub rgba: Option<[f32; 4]>,
    pub image: Option<Source>,
}

/// A mesh, with what every triangle has on it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Painted {
    pub mesh: Mesh,
    /// Empty, or one for each triangle; not a number where a triangle has none.
    pub corners: Vec<Corners>,
    /// Index into `paints` for each triangle; empty, or one for each.
    pub paint_of: Vec<u32>,
    pub paints: Vec<Paint>,
    /// Parts that the file names: the first triangle of each, in order; a part goes on until the next one.
    pub parts: Vec<(usize, String)>,
}

/// A part of a mesh file (SDF's `<submesh>`).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Part {
    pub name: String,
    /// Whether the middle of its bounding box is moved to the origin.
    pub centered: bool,
}

/// The triangles of a mesh that have the same paint.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub mesh: Mesh,
    /// Empty where the file gives none.
    pub corners: Vec<Corners>,
    pub paint: Paint,
}

/// Triangles without image coordinates.
pub(super) const NOWHERE: Corners = [[f32::NAN; 2]; 3];

impl From<Mesh> for Painted {
    fn from(mesh: Mesh) -> Self {
        Self { mesh, ..Self::default() }
    }
}

impl Painted {
    /// Without lists that say nothing.
    pub fn tidy(mut self) -> Self {
        if self.paints.is_empty() {
            self.paint_of.clear();
        }
        if !self.corners.iter().any(is_somewhere) {
            self.corners.clear();
        }
        self
    }

    /// Lets the triangles that follow belong to the part of this name.
    pub fn begin_part(&mut self, name: &str) {
        if self.parts.last().is_none_or(|(_, last)| last != name) {
            self.parts.push((self.mesh.triangles.len(), name.to_owned()));
        }
    }

    /// What belongs to a part, with the vertices that it needs.
    ///
    /// # Errors
    /// There is none of this name, with those that there are.
    pub fn part(&self, Part { name, centered }: &Part) -> Result<Self, String> {
        let ends = self.parts.iter().skip(1).map(|(first, _)| *first).chain([self.mesh.triangles.len()]);
        let own = self.parts.iter().zip(ends).filter(|((_, part), _)| part == name);
        let chosen: Vec<usize> = own.flat_map(|((first, _), end)| *first..end).collect();
        if chosen.is_empty() {
            let mut known: Vec<&str> = self.parts.iter().map(|(_, name)| name.as_str()).collect();
            known.dedup();
            return Err(format!("has no part '{name}'; parts: {}", known.join(", ")));
        }
        let mut part = Self { paints: self.paints.clone(), ..Self::default() };
        let mut places = HashMap::new();
        for i in chosen {
            part.mesh.triangles.push(self.mesh.triangles[i].map(|k| {
                *places.entry(k).or_insert_with(|| {
                    part.mesh.vertices.push(self.mesh.vertices[k as usize]);
                    part.mesh.vertices.len() as u32 - 1
                })
            }));
            part.corners.extend(self.corners.get(i));
            part.paint_of.extend(self.paint_of.get(i));
        }
        if *centered {
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (low, high) = part.mesh.vertices.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
            part.mesh.vertices.iter_mut().for_each(|p| *p -= 0.5 * (low + high));
        }
        Ok(part.tidy())
    }

    /// Image coordinates of all triangles; none where one of them has none.
    pub fn whole_corners(&self) -> Option<Vec<Corners>> {
        let complete = self.corners.len() == self.mesh.triangles.len() && self.corners.iter().all(is_somewhere);
        (complete && !self.corners.is_empty()).then(|| self.corners.clone())
    }

    /// The mesh by paint, in the order of their first triangles, each with the vertices that it needs.
    pub fn surfaces(&self) -> Vec<Surface> {
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut places: HashMap<u32, usize> = HashMap::new();
        let mut known: Vec<HashMap<u32, u32>> = Vec::new();
        for (i, triangle) in self.mesh.triangles.iter().enumerate() {
            let paint = self.paint_of.get(i).copied().unwrap_or(u32::MAX);
            let place = *places.entry(paint).or_insert_with(|| {
                let paint = self.paints.get(paint as usize).cloned().unwrap_or_default();
                surfaces.push(Surface { mesh: Mesh::default(), corners: Vec::new(), paint });
                known.push(HashMap::new());
                surfaces.len() - 1
            });
            let (surface, known) = (&mut surfaces[place], &mut known[place]);
            let own = triangle.map(|k| {
                *known.entry(k).or_insert_with(|| {
                    surface.mesh.vertices.push(self.mesh.vertices[k as usize]);
                    surface.mesh.vertices.len() as u32 - 1
                })
            });
            surface.mesh.triangles.push(own);
            surface.corners.push(self.corners.get(i).copied().unwrap_or(NOWHERE));
        }
        for surface in surfaces.iter_mut().filter(|surface| !surface.corners.iter().all(is_somewhere)) {
            surface.corners.clear();
        }
        surfaces
    }
}

fn is_somewhere(corners: &Corners) -> bool {
    corners.as_flattened().iter().all(|x| x.is_finite())
}
