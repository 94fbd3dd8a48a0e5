//! `<texture>`: squares of two colours, and images from files.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use signorini_multibody::{Checker, Geometry, Image, Look, Spread, Texture};

use super::assets::{Material, MeshAsset};
use super::compiler::Compilers;
use super::defaults::Defaults;
use crate::error::FormatError;
use crate::mesh::painted::Corners;
use crate::mesh::picture;
use crate::xml::{Attributes, Element};

/// A texture that surfaces can have.
enum Sort<'t> {
    /// Two colours.
    Checker([[f32; 3]; 2]),
    /// An image; `cube`: on all sides of a box.
    File { attributes: Attributes<'t>, cube: bool },
}

/// The textures of a file; images are read when a geom first needs them.
pub(super) struct Textures<'t> {
    known: HashMap<String, Sort<'t>>,
    images: RefCell<HashMap<PathBuf, Option<Arc<Image>>>>,
}

/// Whether a texture is taken over: a checkered one, or one image from a file that is no sky.
pub(super) fn is_read(element: Element) -> bool {
    let a = element.attributes();
    a.text("builtin") == Some("checker") || (a.text("file").is_some() && a.text("type") != Some("skybox"))
}

impl<'t> Textures<'t> {
    pub fn read(root: Element<'t>, defaults: &Defaults<'t>, images: bool) -> Result<Self, FormatError> {
        let mut known = HashMap::new();
        for element in root.children_named("asset").flat_map(|a| a.children_named("texture")) {
            let a = defaults.of(element, None, &["texture"])?;
            let color = |name, initial| a.overlay::<3>(name, initial).map(|(rgb, _)| rgb.map(|x| x as f32));
            let stem = || Some(PathBuf::from(a.text("file")?).file_stem()?.to_string_lossy().into_owned());
            let Some(name) = a.text("name").map(str::to_owned).or_else(stem) else { continue };
            if a.text("builtin") == Some("checker") {
                known.insert(name, Sort::Checker([color("rgb1", [0.8; 3])?, color("rgb2", [0.5; 3])?]));
            } else if images && a.text("file").is_some() && a.text("type") != Some("skybox") {
                let cube = a.text("type").unwrap_or("cube") == "cube";
                known.insert(name, Sort::File { attributes: a, cube });
            }
        }
        Ok(Self { known, images: RefCell::default() })
    }

    /// Puts a material's texture on a surface.
    ///
    /// - `size`: of the geom, as the file gives it
    /// - `mesh`: that of the geom
    pub fn put_on(
        &self,
        look: &mut Look,
        material: &Material,
        (geometry, size): (&Geometry, [f64; 2]),
        mesh: Option<&MeshAsset>,
        compilers: &Compilers,
    ) {
        let Some(texture) = material.texture.as_ref().and_then(|name| self.known.get(name)) else { return };
        match texture {
            Sort::Checker(colors) => look.checker = Some(checker(material, *colors, geometry, size)),
            Sort::File { attributes, cube } => {
                let corners = mesh.and_then(|mesh| mesh.corners.clone());
                let spread = spread(material, geometry, size, *cube, corners);
                look.texture = self.image(attributes, compilers).map(|image| Texture { image, spread });
            }
        }
    }

    /// The image of a texture; none, which is noted, where it cannot be read.
    fn image(&self, a: &Attributes, compilers: &Compilers) -> Option<Arc<Image>> {
        let path = compilers.texture_path(a.element(), a.text("file")?);
        if let Some(known) = self.images.borrow().get(&path) {
            return known.clone();
        }
        let image = match picture::load(&path) {
            Ok(image) => Some(Arc::new(image)),
            Err(reason) => {
                let what = format!("the image '{}' cannot be read: {reason}", path.display());
                a.element().note(a.at("file"), what, "surfaces have their colour alone", false);
                None
            }
        };
        self.images.borrow_mut().insert(path, image.clone());
        image
    }
}

/// Lengths of what is repeated `texrepeat` times: per metre, or over the geom's lengths along its axes.
fn sides<const N: usize>(material: &Material, extents: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| {
        let repeat = material.repeat[k.min(1)].max(1e-6);
        if material.uniform || extents[k] <= 0.0 { 1.0 / repeat } else { 2.0 * extents[k] / repeat }
    })
}

/// Half-lengths along x and y of what has an end; planes have that of the file.
fn half_lengths(geometry: &Geometry, size: [f64; 2]) -> [f64; 2] {
    match geometry {
        Geometry::Plane => size,
        Geometry::Box { half_extents } => [half_extents.x, half_extents.y],
        Geometry::HeightField(field) => field.half_extents,
        _ => [0.0; 2],
    }
}

/// Squares: a picture of two by two of them is repeated.
fn checker(material: &Material, colors: [[f32; 3]; 2], geometry: &Geometry, size: [f64; 2]) -> Checker {
    Checker { colors, square: sides(material, half_lengths(geometry, size)).map(|side| 0.5 * side) }
}

fn spread(
    material: &Material,
    geometry: &Geometry,
    size: [f64; 2],
    cube: bool,
    corners: Option<Arc<Vec<Corners>>>,
) -> Spread {
    match corners {
        Some(corners) => Spread::Corners(corners),
        None if cube => Spread::Cube(sides(material, box_around(geometry))),
        None => Spread::Plane(sides(material, half_lengths(geometry, size))),
    }
}

/// Half-lengths of the box about the origin that holds a shape, m; zero where it has no end.
fn box_around(geometry: &Geometry) -> [f64; 3] {
    match geometry {
        Geometry::Plane => [0.0; 3],
        Geometry::Box { half_extents: half } | Geometry::Ellipsoid { semi_axes: half } => half.to_array(),
        Geometry::Capsule { radius, half_length } => [*radius, *radius, half_length + radius],
        Geometry::Cylinder { radius, half_length } | Geometry::Cone { radius, half_length } => {
            [*radius, *radius, *half_length]
        }
        other => [other.bounding_radius(); 3],
    }
}
