//! `<collision>` shapes, coloured as the link's `<visual>`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;
use signorini_multibody::{BodyId, Geom, Geometry, Pose};

use super::{Importer, origin};
use crate::error::FormatError;
use crate::xml::{Attributes, Element};
use crate::{mesh, packages};

type MeshKey = (PathBuf, [u64; 3]);

/// Colours and meshes of a file, and where it looks for meshes.
pub(super) struct Shapes<'t> {
    materials: HashMap<&'t str, [f32; 4]>,
    meshes: HashMap<MeshKey, Arc<Mesh>>,
    base: PathBuf,
    package_dirs: Vec<PathBuf>,
}

impl<'t> Shapes<'t> {
    pub fn read(root: Element<'t>, base: &Path, package_dirs: &[PathBuf]) -> Result<Self, FormatError> {
        let mut materials = HashMap::new();
        let nested = root.children_named("link").flat_map(|l| l.children_named("visual"));
        let everywhere = root.children_named("material").chain(nested.flat_map(|v| v.children_named("material")));
        for material in everywhere {
            if let (Some(name), Some(rgba)) = (material.attributes().text("name"), colour(material)?) {
                materials.entry(name).or_insert(rgba);
            }
        }
        Ok(Self { materials, meshes: HashMap::new(), base: base.to_owned(), package_dirs: package_dirs.to_owned() })
    }

    /// The colour of the link's first visual that has one.
    fn link_colour(&self, link: Element<'t>) -> Result<Option<[f32; 4]>, FormatError> {
        for material in link.children_named("visual").filter_map(|v| v.child("material")) {
            let named = material.attributes().text("name").and_then(|name| self.materials.get(name)).copied();
            if let Some(rgba) = colour(material)?.or(named) {
                return Ok(Some(rgba));
            }
        }
        Ok(None)
    }

    fn mesh(&mut self, a: &Attributes, path: PathBuf) -> Result<Arc<Mesh>, FormatError> {
        let scale = a.vec3("scale")?.unwrap_or(DVec3::ONE);
        let key = (path, scale.to_array().map(f64::to_bits));
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let asset = |reason| {
            let (at, path) = (a.at("filename"), key.0.clone());
            FormatError::Asset { at, element: "mesh".into(), path, reason }
        };
        let mesh = Arc::new(mesh::scaled(mesh::load(&key.0).map_err(asset)?, scale));
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }
}

/// Adds the collision shapes of a link to its body.
///
/// `offset`: the link in its body.
pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    link: Element<'t>,
    body: BodyId,
    offset: &Pose,
) -> Result<(), FormatError> {
    let rgba = importer.shapes.link_colour(link)?;
    let link_name = link.attributes().text("name").unwrap_or_default();
    for collision in link.children_named("collision") {
        let Some(geometry) = geometry(importer, collision)? else { continue };
        geometry.check().map_err(|reason| collision.invalid(format!("{}: {reason}", geometry.kind_name())))?;
        let mut geom = Geom::new("", geometry);
        geom.placement = *offset * origin(collision)?;
        geom.rgba = rgba.unwrap_or(geom.rgba);
        let given = collision.attributes().text("name").filter(|n| !n.is_empty());
        let name = importer.parts.unused_geom_name(given.unwrap_or(link_name));
        importer.parts.add_geom(collision, Some(name), body, geom)?;
    }
    Ok(())
}

/// The shape; none if its file format is not supported.
fn geometry(importer: &mut Importer, collision: Element) -> Result<Option<Geometry>, FormatError> {
    let missing = "<geometry> with a <box>, <cylinder>, <sphere>, <capsule> or <mesh>";
    let shape = collision.child("geometry").and_then(|g| g.children().next());
    let shape = shape.ok_or_else(|| collision.incomplete(missing))?;
    let a = shape.attributes();
    let size = |name: &'static str| a.number(name)?.ok_or_else(|| shape.incomplete(format!("attribute '{name}': m")));
    let geometry = match shape.name() {
        "box" => {
            let full = a.vec3("size")?.ok_or_else(|| shape.incomplete("attribute 'size': three full lengths, m"))?;
            Geometry::Box { half_extents: full / 2.0 }
        }
        "sphere" => Geometry::Sphere { radius: size("radius")? },
        "cylinder" => Geometry::Cylinder { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "capsule" => Geometry::Capsule { radius: size("radius")?, half_length: size("length")? / 2.0 },
        "mesh" => return mesh_geometry(importer, &a),
        _ => return Err(collision.incomplete(missing)),
    };
    Ok(Some(geometry))
}

/// A mesh as its convex hull.
fn mesh_geometry(importer: &mut Importer, a: &Attributes) -> Result<Option<Geometry>, FormatError> {
    let uri = a.required("filename", "the mesh file")?;
    let path = packages::resolve(uri, &importer.shapes.base, &importer.shapes.package_dirs);
    if !mesh::is_supported(&path) {
        let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
        let what = format!("mesh format '{extension}' is not supported");
        let effect = "the shape is left out: nothing touches it; convert the file to STL, OBJ or COLLADA";
        importer.report.motion(a.at("filename"), "mesh", what, effect);
        return Ok(None);
    }
    Ok(Some(Geometry::ConvexMesh(importer.shapes.mesh(a, path)?)))
}

/// `<color rgba="…">` of a material.
fn colour(material: Element) -> Result<Option<[f32; 4]>, FormatError> {
    let Some(color) = material.child("color") else { return Ok(None) };
    Ok(color.attributes().vector::<4>("rgba")?.map(|rgba| rgba.map(|x| x as f32)))
}
