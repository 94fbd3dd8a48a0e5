//! `<asset>`: meshes, height fields, material colours.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use signorini_multibody::Inertia;
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::model::{HeightField, Mesh};

use super::compiler::{Compilers, portable};
use super::defaults::Defaults;
use crate::error::FormatError;
use crate::mesh::heights::{self, Grid};
use crate::mesh::painted::Corners;
use crate::mesh::{self, Orientation, Painted};
use crate::options::MissingMeshes;
use crate::xml::{Attributes, Element, most_similar};

/// Height fields with more points than this are refused.
const MAX_POINTS: usize = 10_000_000;

/// How the mass of a mesh is spread.
#[derive(Clone, Copy)]
enum MeshInertia {
    Convex,
    Exact,
    Legacy,
    Shell,
}

/// A mesh as geoms use it: offset, turned and scaled as its asset says.
pub(super) struct MeshAsset {
    pub mesh: Arc<Mesh>,
    /// Where on it images are.
    pub corners: Option<Arc<Vec<Corners>>>,
    inertia: MeshInertia,
}

impl MeshAsset {
    /// Inertia at density 1 kg/m³ (of a shell: 1 kg/m²); none if the mesh encloses nothing.
    pub fn unit_inertia(&self) -> Option<Inertia> {
        let hull;
        let mesh = match self.inertia {
            MeshInertia::Convex => {
                hull = mesh::convex_hull(&self.mesh.vertices)?;
                &hull
            }
            _ if self.mesh.triangles.is_empty() => {
                hull = mesh::convex_hull(&self.mesh.vertices)?;
                &hull
            }
            _ => &*self.mesh,
        };
        match self.inertia {
            MeshInertia::Convex | MeshInertia::Exact => mesh::solid(mesh, Orientation::Signed),
            MeshInertia::Legacy => mesh::solid(mesh, Orientation::Ignored),
            MeshInertia::Shell => mesh::shell(mesh),
        }
    }
}

/// How surfaces look that name it.
pub(super) struct Material {
    pub rgba: [f32; 4],
    pub specular: f32,
    pub shininess: f32,
    pub reflectance: f32,
    pub emission: f32,
    pub texture: Option<String>,
    pub repeat: [f64; 2],
    pub uniform: bool,
}

/// The assets of a file; meshes are read when a geom first needs them.
pub(super) struct Assets<'t> {
    meshes: HashMap<String, Attributes<'t>>,
    height_fields: HashMap<String, Element<'t>>,
    materials: HashMap<&'t str, Material>,
    loaded: RefCell<HashMap<String, Rc<MeshAsset>>>,
}

impl<'t> Assets<'t> {
    pub fn read(root: Element<'t>, defaults: &Defaults<'t>) -> Result<Self, FormatError> {
        let mut assets = Self {
            meshes: HashMap::new(),
            height_fields: HashMap::new(),
            materials: HashMap::new(),
            loaded: RefCell::default(),
        };
        for element in root.children_named("asset").flat_map(|a| a.children()) {
            match element.name() {
                "mesh" => {
                    let attributes = defaults.of(element, None, &["mesh"])?;
                    let name = asset_name(&attributes)?;
                    if let Some(first) = assets.meshes.insert(name.clone(), attributes) {
                        return Err(duplicate(element, "mesh", name, first.element()));
                    }
                }
                "hfield" => {
                    let name = asset_name(&element.attributes())?;
                    if let Some(first) = assets.height_fields.insert(name.clone(), element) {
                        return Err(duplicate(element, "height field", name, first));
                    }
                }
                "material" => {
                    let attributes = defaults.of(element, None, &["material"])?;
                    let name = element.attributes().required("name", "geoms refer to the material by it")?;
                    assets.materials.insert(name, material(&attributes)?);
                }
                _ => {}
            }
        }
        Ok(assets)
    }

    /// The material that `attributes` names, if it names one that is defined.
    pub fn material(&self, attributes: &Attributes) -> Result<Option<&Material>, FormatError> {
        let Some(name) = attributes.text("material").filter(|m| !m.is_empty()) else { return Ok(None) };
        match self.materials.get(name) {
            Some(material) => Ok(Some(material)),
            None => {
                let names = self.materials.keys().copied().filter(|n| !n.is_empty());
                let similar = most_similar(name, names).map(|n| format!("; did you mean '{n}'?")).unwrap_or_default();
                let what = format!("the material '{name}' is not defined");
                let effect = format!("the geom has a colour of its own or the default one{similar}");
                attributes.element().note(attributes.at("material"), what, effect, false);
                Ok(None)
            }
        }
    }

    /// Why the mesh that a geom names is not there and its geom is to be left out; nothing where it is to be read.
    pub fn left_out(&self, geom: &Attributes, compilers: &Compilers, missing: MissingMeshes) -> Option<String> {
        let name = geom.text("mesh")?;
        let a = self.meshes.get(name)?;
        if a.element().child("plugin").is_some() && !a.has("file") && !a.has("vertex") {
            return Some(format!("the mesh '{name}' is made by a plugin, which is not supported"));
        }
        if a.text("builtin") == Some("wedge") {
            return Some(format!("the mesh '{name}' is a wedge, which serves tactile sensors and is not supported"));
        }
        let path = compilers.asset_path(a.element(), a.text("file")?);
        let skipped = missing == MissingMeshes::Skip && !path.exists();
        skipped.then(|| format!("the file '{}' of its mesh is missing", path.display()))
    }

    /// The mesh that a geom names.
    pub fn mesh(&self, geom: &Attributes, compilers: &Compilers) -> Result<Rc<MeshAsset>, FormatError> {
        let name = geom.required("mesh", "the mesh asset to use")?;
        if let Some(asset) = self.loaded.borrow().get(name) {
            return Ok(asset.clone());
        }
        let Some(attributes) = self.meshes.get(name) else {
            return Err(geom.unknown("mesh", "mesh", self.meshes.keys().map(String::as_str)));
        };
        let asset = Rc::new(load_mesh(attributes, compilers)?);
        self.loaded.borrow_mut().insert(name.to_owned(), asset.clone());
        Ok(asset)
    }

    /// The height field that a geom names.
    pub fn height_field(&self, geom: &Attributes, compilers: &Compilers) -> Result<HeightField, FormatError> {
        let name = geom.required("hfield", "the height field asset to use")?;
        let Some(element) = self.height_fields.get(name) else {
            return Err(geom.unknown("hfield", "height field", self.height_fields.keys().map(String::as_str)));
        };
        let a = element.attributes();
        let [half_x, half_y, top, _base] =
            a.vector::<4>("size")?.ok_or_else(|| element.incomplete("attribute 'size': half x, half y, top, base"))?;
        let Grid { rows, columns, mut heights } = match a.text("file") {
            Some(file) => {
                let path = compilers.asset_path(*element, file);
                heights::load(&path, MAX_POINTS).map_err(|reason| FormatError::Asset {
                    at: a.at("file"),
                    element: "hfield".into(),
                    path: path.clone(),
                    reason,
                })?
            }
            None => elevation(&a)?,
        };
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let span = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low;
        heights.iter_mut().for_each(|h| *h = if span > 0.0 { (*h - low) / span * top } else { 0.0 });
        Ok(HeightField { size: [columns, rows], half_extents: [half_x, half_y], heights })
    }
}

/// `elevation`, whose first row is the one at the largest y; a flat field without it.
fn elevation(a: &Attributes) -> Result<Grid, FormatError> {
    let (rows, columns) = (grid(a, "nrow")?, grid(a, "ncol")?);
    let count = rows.checked_mul(columns).filter(|n| *n <= MAX_POINTS);
    let count = count.ok_or_else(|| a.element().invalid(format!("more than {MAX_POINTS} grid points")))?;
    let elevation = a.numbers("elevation")?.unwrap_or_else(|| vec![0.0; count]);
    if elevation.len() != count {
        let expected = format!("nrow x ncol = {rows} x {columns} numbers, found {}", elevation.len());
        return Err(a.invalid("elevation", expected));
    }
    let heights = elevation.chunks_exact(columns).rev().flatten().copied().collect();
    Ok(Grid { rows, columns, heights })
}

fn load_mesh(a: &Attributes, compilers: &Compilers) -> Result<MeshAsset, FormatError> {
    let painted = match a.text("file") {
        Some(file) => {
            let path = compilers.asset_path(a.element(), file);
            let asset =
                |reason| FormatError::Asset { at: a.at("file"), element: "mesh".into(), path: path.clone(), reason };
            mesh::load_painted(&path).map_err(asset)?
        }
        None => match a.text("builtin").filter(|kind| *kind != "none") {
            Some(kind) => {
                let parameters = a.numbers("params")?.unwrap_or_default();
                mesh::builtin(kind, &parameters).map_err(|expected| a.invalid("params", expected))?.into()
            }
            None => inline_mesh(a)?,
        },
    };
    let mut corners = painted.whole_corners();
    let mut mesh = painted.mesh;
    let offset = a.vec3("refpos")?.unwrap_or(DVec3::ZERO);
    let turn = a.quaternion("refquat")?.unwrap_or(DQuat::IDENTITY).conjugate();
    let scale = a.scale("scale")?.unwrap_or(DVec3::ONE);
    mesh.vertices.iter_mut().for_each(|p| *p = turn * (*p - offset) * scale);
    if scale.x * scale.y * scale.z < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        corners.iter_mut().flatten().for_each(|c| c.swap(1, 2));
    }
    let kinds = [
        ("convex", MeshInertia::Convex),
        ("exact", MeshInertia::Exact),
        ("legacy", MeshInertia::Legacy),
        ("shell", MeshInertia::Shell),
    ];
    let inertia = a.choice("inertia", &kinds)?.unwrap_or(MeshInertia::Legacy);
    Ok(MeshAsset { mesh: Arc::new(mesh), corners: corners.map(Arc::new), inertia })
}

fn material(a: &Attributes) -> Result<Material, FormatError> {
    let share = |name, default: f64| a.number_or(name, default).map(|x| x.clamp(0.0, 1.0) as f32);
    let layers = a.element().children_named("layer").find_map(|layer| layer.attributes().text("texture"));
    Ok(Material {
        rgba: colour(a, [1.0; 4])?,
        specular: share("specular", 0.5)?,
        shininess: share("shininess", 0.5)?,
        reflectance: share("reflectance", 0.0)?,
        emission: share("emission", 0.0)?,
        texture: a.text("texture").or(layers).map(str::to_owned),
        repeat: a.overlay::<2>("texrepeat", [1.0; 2])?.0,
        uniform: a.flag("texuniform")?.unwrap_or(false),
    })
}

fn grid(a: &Attributes, name: &'static str) -> Result<usize, FormatError> {
    match a.integer(name)? {
        Some(n) if n >= 2 => usize::try_from(n).map_err(|_| a.invalid(name, "a smaller number")),
        _ => Err(a.invalid(name, "a number of grid points, at least 2")),
    }
}

/// Vertices and faces given in the model file.
fn inline_mesh(a: &Attributes) -> Result<Painted, FormatError> {
    let numbers = match a.numbers("vertex")? {
        Some(numbers) if numbers.len() >= 9 && numbers.len() % 3 == 0 => numbers,
        Some(n) => {
            return Err(a.invalid("vertex", format!("3 numbers for each of at least 3 vertices, found {}", n.len())));
        }
        None => return Err(a.element().incomplete("attribute 'file' or 'vertex': the shape of the mesh")),
    };
    let vertices: Vec<DVec3> = numbers.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect();
    let faces = a.integers("face")?.unwrap_or_default();
    if faces.len() % 3 != 0 || faces.iter().any(|&k| k < 0 || k as usize >= vertices.len()) {
        return Err(a.invalid("face", format!("3 vertex numbers for each face, 0 to {}", vertices.len() - 1)));
    }
    let triangles: Vec<[u32; 3]> = faces.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect();
    // Two for each vertex, with v downwards.
    let places = a.numbers("texcoord")?.filter(|places| places.len() == 2 * vertices.len()).unwrap_or_default();
    let place = |k: u32| [places[2 * k as usize] as f32, 1.0 - places[2 * k as usize + 1] as f32];
    let corners = if places.is_empty() { Vec::new() } else { triangles.iter().map(|t| t.map(place)).collect() };
    Ok(Painted { mesh: Mesh { vertices, triangles }, corners, ..Painted::default() })
}

/// The asset's name, or that of its file without folder and extension.
fn asset_name(a: &Attributes) -> Result<String, FormatError> {
    if let Some(name) = a.text("name").filter(|n| !n.is_empty()) {
        return Ok(name.to_owned());
    }
    let file = a.required("file", "the asset needs a name or a file")?;
    let stem = portable(file).file_stem().map(|s| s.to_string_lossy().into_owned());
    stem.ok_or_else(|| a.invalid("file", "the name of a file"))
}

fn duplicate(element: Element, sort: &'static str, name: String, first: Element) -> FormatError {
    FormatError::DuplicateName { at: element.at(), sort, name, first: Box::new(first.at()) }
}

/// `rgba` written over `initial`.
pub(super) fn colour(a: &Attributes, initial: [f32; 4]) -> Result<[f32; 4], FormatError> {
    let (rgba, _) = a.overlay::<4>("rgba", initial.map(f64::from))?;
    Ok(rgba.map(|x| x as f32))
}
