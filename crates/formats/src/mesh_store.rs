//! Meshes that a file names by URI, each read once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::Geometry;
use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

use crate::error::{FormatError, Location};
use crate::mesh::Painted;
use crate::options::{LoadOptions, MissingMeshes};
use crate::report::Reporter;
use crate::shapes::leave_out_if_missing;
use crate::xml::Element;
use crate::{mesh, packages};

/// Meshes of a file, and where it looks for them.
pub(crate) struct MeshStore {
    files: HashMap<PathBuf, Arc<Painted>>,
    meshes: HashMap<(PathBuf, [u64; 3]), Arc<Mesh>>,
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
    /// - `uri`: names its file, with the place in the model's file
    pub fn hull(
        &mut self,
        report: &mut Reporter,
        element: Element,
        (uri, at): (&str, Location),
        scale: DVec3,
    ) -> Result<Option<Geometry>, FormatError> {
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
        let asset = |reason| FormatError::Asset { at, element: "mesh".into(), path: path.clone(), reason };
        self.scaled(&path, scale).map(|mesh| Some(Geometry::ConvexMesh(mesh))).map_err(asset)
    }

    /// All triangles of a file in the size that a model gives them.
    pub fn scaled(&mut self, path: &Path, scale: DVec3) -> Result<Arc<Mesh>, String> {
        let key = (path.to_owned(), scale.to_array().map(f64::to_bits));
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let mesh = Arc::new(mesh::scaled(self.painted(path)?.mesh.clone(), scale));
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }

    /// What is in a file.
    pub fn painted(&mut self, path: &Path) -> Result<Arc<Painted>, String> {
        if let Some(file) = self.files.get(path) {
            return Ok(file.clone());
        }
        let file = Arc::new(mesh::load_painted(path)?);
        self.files.insert(path.to_owned(), file.clone());
        Ok(file)
    }
}
