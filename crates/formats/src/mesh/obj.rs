//! Wavefront OBJ, by `tobj`; materials are not read.

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

/// All objects of the file as one mesh, faces cut into triangles.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut &bytes[..], &options, no_materials).map_err(|e| e.to_string())?;
    let mut mesh = Mesh::default();
    for model in models {
        let offset = mesh.vertices.len() as u32;
        let corners = model.mesh.positions.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2]));
        mesh.vertices.extend(corners);
        let count = mesh.vertices.len() as u32 - offset;
        if model.mesh.indices.iter().any(|&i| i >= count) {
            return Err("a face names a vertex that is not there".into());
        }
        mesh.triangles
            .extend(model.mesh.indices.chunks_exact(3).map(|t| [t[0] + offset, t[1] + offset, t[2] + offset]));
    }
    match mesh.vertices.iter().position(|p| !p.is_finite()) {
        Some(k) => Err(format!("vertex {k} is not finite")),
        None => Ok(mesh),
    }
}
