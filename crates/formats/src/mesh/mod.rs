//! Meshes from files and from numbers in a model, and what they weigh.

mod builtin;
mod bytes;
mod dae;
mod dae_effects;
mod dae_xml;
mod gltf_file;
pub(crate) mod heights;
mod hull;
mod msh;
mod mtl;
mod obj;
pub(crate) mod painted;
pub(crate) mod picture;
mod stl;
mod volume;

pub(crate) use builtin::builtin;
pub(crate) use bytes::read_file;
pub(crate) use hull::convex_hull;
pub(crate) use painted::{Painted, Part};
pub(crate) use volume::{Orientation, shell, solid};

use std::path::Path;

use signorini_multibody::Inertia;
use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

use crate::error::FormatError;

/// Mesh files larger than this are refused.
const MAX_BYTES: u64 = 512 << 20;

/// The formats of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// STL, binary or text.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// MuJoCo's binary format.
    Msh,
    /// COLLADA: the geometry of its scene, in metres, along the axes of the file.
    Dae,
    /// glTF 2.0, as text or as GLB: the geometry of its scene, along the axes of the file.
    Gltf,
}

impl MeshFormat {
    /// From the extension of a file name.
    fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "msh" => Some(Self::Msh),
            "dae" => Some(Self::Dae),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Reads triangles from the bytes of a mesh file. Vertices at the same place are one vertex; triangles without area
/// stay. Lengths are as in the file (COLLADA: in metres).
///
/// # Errors
/// What is wrong, in words.
pub fn read_mesh(bytes: &[u8], format: MeshFormat) -> Result<Mesh, String> {
    let mesh = match format {
        MeshFormat::Stl => stl::read(bytes)?,
        MeshFormat::Obj => obj::read(bytes)?,
        MeshFormat::Msh => msh::read(bytes)?,
        MeshFormat::Dae => dae::read(bytes, Path::new(""))?.mesh,
        MeshFormat::Gltf => gltf_file::read(bytes)?.mesh,
    };
    checked(mesh)
}

fn checked(mesh: Mesh) -> Result<Mesh, String> {
    if mesh.vertices.len() < 3 {
        return Err(format!("holds {} vertices, a mesh needs at least 3", mesh.vertices.len()));
    }
    Ok(mesh)
}

/// The area vectors of a closed surface add up to zero; this part of its area may be rounding of coordinates in single precision.
const CLOSED: f64 = 1e-4;

/// Whether a mesh is closed and its faces all look to one side, as far as the areas of its faces tell.
fn is_closed(mesh: &Mesh) -> bool {
    let area = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|k| mesh.vertices[k as usize]);
        (b - a).cross(c - a)
    };
    let areas = mesh.triangles.iter().map(area);
    let (sum, size) = areas.fold((DVec3::ZERO, 0.0), |(sum, size), area| (sum + area, size + area.length()));
    sum.length() <= CLOSED * size
}

/// Mass properties of the solid inside a closed mesh whose faces all look to one side, in the mesh's frame; none where it is not closed, some
/// faces look to the other side, or it encloses no volume.
///
/// - `density`: kg/m³
pub fn solid_inertia(mesh: &Mesh, density: f64) -> Option<Inertia> {
    if !is_closed(mesh) {
        return None;
    }
    let turned = || {
        let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Mesh { vertices: mesh.vertices.clone(), triangles }
    };
    let of_one = solid(mesh, Orientation::Signed).or_else(|| solid(&turned(), Orientation::Signed))?;
    let Inertia { mass, center_of_mass, rotational } = of_one;
    Some(Inertia { mass: density * mass, center_of_mass, rotational: rotational * density })
}

/// Reads Wavefront OBJ.
pub(crate) fn read_obj(bytes: &[u8]) -> Result<Mesh, String> {
    read_mesh(bytes, MeshFormat::Obj)
}

/// Reads a mesh file; its extension says which format it is (`.stl`, `.obj`, `.msh`, `.dae`, `.gltf`, `.glb`).
///
/// # Errors
/// [`FormatError::Unreadable`] with what is wrong.
pub fn read_mesh_file(path: &Path) -> Result<Mesh, FormatError> {
    load_painted(path)
        .map(|painted| painted.mesh)
        .map_err(|reason| FormatError::Unreadable { path: path.to_owned(), reason })
}

/// Whether the extension of a file is that of a mesh format that can be read.
pub(crate) fn is_supported(path: &Path) -> bool {
    MeshFormat::of(path).is_some()
}

/// Reads a mesh file with what it says of its surfaces.
pub(crate) fn load_painted(path: &Path) -> Result<Painted, String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let bytes = || read_file(path, MAX_BYTES);
    let mut painted = match format_of(path)? {
        MeshFormat::Gltf => gltf_file::load(path)?,
        MeshFormat::Dae => dae::read(&bytes()?, folder)?,
        MeshFormat::Obj => obj::read_painted(&bytes()?, folder)?,
        MeshFormat::Msh => msh::read_painted(&bytes()?)?,
        MeshFormat::Stl => stl::read(&bytes()?)?.into(),
    };
    painted.mesh = checked(painted.mesh)?;
    Ok(painted.tidy())
}

fn format_of(path: &Path) -> Result<MeshFormat, String> {
    MeshFormat::of(path).ok_or_else(|| "unknown mesh format: convert it to STL, OBJ, COLLADA or glTF".into())
}

/// The mesh with its coordinates multiplied; a mirrored one keeps its faces looking outwards.
pub(crate) fn scaled(mut mesh: Mesh, scale: DVec3) -> Mesh {
    mesh.vertices.iter_mut().for_each(|p| *p *= scale);
    if scale.x * scale.y * scale.z < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}
