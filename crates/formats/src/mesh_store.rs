//! Meshes that a file names by URI, each read once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::Geometry;
use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

use crate::error::{FormatError, Location};
use crate::mesh::{Painted, Part};
use crate::options::{LoadOptions, MissingMeshes};
use crate::report::Reporter;
use crate::shapes::leave_out_if_missing;
use crate::xml::Element;
use crate::{mesh, packages};

/// How a model names a mesh.
pub(crate) struct Named<'a> {
    /// The file, with the place in the model's file.
    pub uri: (&'a str, Location),
    /// The part that is meant; all of it where there is none.
    pub part: Option<Part>,
    /// By which its coordinates are multiplied.
    pub scale: DVec3,
}

/// A file, or a part of it.
pub(crate) type FileKey = (PathBuf, Option<Part>);
/// The same in some size, by its bits.
pub(crate) type MeshKey = (FileKey, [u64; 3]);

/// Meshes of a file, and where it looks for them.
pub(crate) struct MeshStore {
    files: HashMap<FileKey, Arc<Painted>>,
    meshes: HashMap<MeshKey, Arc<Mesh>>,
    base: PathBuf,
    package_dirs: Vec<PathBuf>,
    missing_meshes: MissingMeshes,
}

impl MeshStore {
    pub fn new(base: &Path, options: &LoadOptions) -> Self {
        let LoadOptions { package_dirs, missing_meshes, .. } = options.clone();
        Self { files: HashMap::new(), meshes: HashMap::new(), base: base.to_owned(), package_dirs, missing_meshes }
    }

    /// The convex hull of a mesh; none where its format is not supported or it is to be left out, which the report tells.
    ///
    /// - `element`: has the mesh
    pub fn hull(
        &mut self,
        report: &mut Reporter,
        element: Element,
        named: Named,
    ) -> Result<Option<Geometry>, FormatError> {
        let Named { uri: (uri, at), part, scale } = named;
        let path = packages::resolve(uri, &self.base, &self.package_dirs);
        if !mesh::is_supported(&path) {
            let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
            let what = format!("mesh format '{extension}' is not supported");
            let effect = "the shape is left out: nothing touches it; convert the file to STL, OBJ or COLLADA";
            report.motion(at, "mesh", what, effect);
            return Ok(None);
        }
        if leave_out_if_missing(report, element, &path, self.missing_meshes) {
            return Ok(None);
        }
        let key = (path, part);
        let asset = |reason| FormatError::Asset { at, element: "mesh".into(), path: key.0.clone(), reason };
        self.scaled(&key, scale).map(|mesh| Some(Geometry::ConvexMesh(mesh))).map_err(asset)
    }

    /// All triangles of a file, or of a part of it, in the size that a model gives them.
    pub fn scaled(&mut self, file: &FileKey, scale: DVec3) -> Result<Arc<Mesh>, String> {
        let key = (file.clone(), scale.to_array().map(f64::to_bits));
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let mesh = Arc::new(mesh::scaled(self.painted(file)?.mesh.clone(), scale));
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }

    /// What is in a file, or in a part of it.
    pub fn painted(&mut self, file: &FileKey) -> Result<Arc<Painted>, String> {
        if let Some(known) = self.files.get(file) {
            return Ok(known.clone());
        }
        let (path, part) = file;
        let painted = Arc::new(match part {
            None => mesh::load_painted(path)?,
            Some(part) => self.painted(&(path.clone(), None))?.part(part)?,
        });
        self.files.insert(file.clone(), painted.clone());
        Ok(painted)
    }
}
