//! `<collision>` shapes, coloured as the link's `<visual>`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;
use signorini_multibody::{BodyId, Geom, Geometry, Pose};

use super::{Importer, origin};
use crate::error::FormatError;
use crate::shapes::{leave_out_if_flat, leave_out_if_missing};
use crate::xml::{Attributes, Element};
use crate::{LoadOptions, MissingMeshes};
use crate::{mesh, packages};

type MeshKey = (PathBuf, [u64; 3]);

/// Colours and meshes of a file, and where it looks for meshes.
pub(super) struct Shapes<'t> {
    materials: HashMap<&'t str, [f32; 4]>,
    meshes: HashMap<MeshKey, Arc<Mesh>>,
    base: PathBuf,
    package_dirs: Vec<PathBuf>,
    missing_meshes: MissingMeshes,
}

impl<'t> Shapes<'t> {
    pub fn read(root: Element<'t>, base: &Path, options: &LoadOptions) -> Self {
        let mut materials = HashMap::new();
        let nested = root.children_named("link").flat_map(|l| l.children_named("visual"));
        let everywhere = root.children_named("material").chain(nested.flat_map(|v| v.children_named("material")));
        for material in everywhere {
            if let (Some(name), Some(rgba)) = (material.attributes().text("name"), colour(material)) {
                materials.entry(name).or_insert(rgba);
            }
        }
        let LoadOptions { package_dirs, missing_meshes, .. } = options.clone();
        Self { materials, meshes: HashMap::new(), base: base.to_owned(), package_dirs, missing_meshes }
    }

    /// The colour of the link's first visual that has one.
    fn link_colour(&self, link: Element<'t>) -> Option<[f32; 4]> {
        let mut found = None;
        for material in link.children_named("visual").filter_map(|v| v.child("material")) {
            let name = material.attributes().text("name").filter(|n| !n.is_empty());
            let rgba = colour(material).or(name.and_then(|name| self.materials.get(name)).copied());
            // A texture is a definition, too, which is not read.
            if let (Some(name), None, None) = (name, rgba, material.children().next()) {
                let what = format!("'{}' is not defined", name.chars().take(60).collect::<String>());
                material.note(material.at(), what, "the link has the default colour", false);
            }
            found = found.or(rgba);
        }
        found
    }

    fn mesh(&mut self, a: &Attributes, path: PathBuf) -> Result<Arc<Mesh>, FormatError> {
        let scale = a.scale("scale")?.unwrap_or(DVec3::ONE);
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
    (link_name, link): (&'t str, Element<'t>),
    body: BodyId,
    offset: &Pose,
) -> Result<(), FormatError> {
    let rgba = importer.shapes.link_colour(link);
    for collision in link.children_named("collision") {
        let Some(geometry) = geometry(importer, collision)? else { continue };
        if leave_out_if_flat(&mut importer.report, collision, &geometry) {
            continue;
        }
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
    let effect = "it is left out: nothing touches it; give a <box>, <cylinder>, <sphere>, <capsule> or <mesh>";
    let Some(shape) = collision.child("geometry").and_then(|g| g.children().next()) else {
        importer.report.motion(collision.at(), "collision", "has no shape", effect);
        return Ok(None);
    };
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
        "ellipsoid" => {
            let radii = a.vec3("radii")?.ok_or_else(|| shape.incomplete("attribute 'radii': three semi-axes, m"))?;
            Geometry::Ellipsoid { semi_axes: radii }
        }
        other => {
            let what = format!("shape '{}' is not supported", other.chars().take(40).collect::<String>());
            importer.report.motion(shape.at(), "geometry", what, effect);
            return Ok(None);
        }
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
    if leave_out_if_missing(&mut importer.report, a.element(), &path, importer.shapes.missing_meshes) {
        return Ok(None);
    }
    Ok(Some(Geometry::ConvexMesh(importer.shapes.mesh(a, path)?)))
}

/// `<color rgba="…">` of a material, opaque where there are three numbers. Only pictures depend on it: a colour that cannot be read
/// is noted.
fn colour(material: Element) -> Option<[f32; 4]> {
    let a = material.child("color")?.attributes();
    let rgba = match a.numbers("rgba") {
        Ok(numbers) => numbers?.iter().map(|x| *x as f32).collect::<Vec<f32>>(),
        Err(_) => Vec::new(),
    };
    match rgba[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => {
            let (what, effect) = ("'rgba' is not a colour", "it is passed over: write red, green, blue, opacity");
            a.element().note(a.at("rgba"), what, effect, false);
            None
        }
    }
}
