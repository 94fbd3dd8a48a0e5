//! What URDF and SDF show in place of what touches: meshes by colour, images on them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Geom, Geometry, Image, Look, Pose, Spread, Texture};

use crate::error::FormatError;
use crate::mesh::painted::{Corners, Paint, Source, Surface};
use crate::mesh::{self, picture};
use crate::mesh_store::{FileKey, MeshKey, MeshStore, Named};
use crate::options::LoadOptions;
use crate::packages;
use crate::parts::Parts;
use crate::xml::Element;

/// Visibility group of what is only seen, and of what only touches where the same link is seen otherwise: those of published MJCF robots.
pub(crate) const SEEN: u8 = 2;
pub(crate) const TOUCHED: u8 = 3;

/// Something to see.
#[derive(Clone)]
pub(crate) struct Shown {
    pub geometry: Geometry,
    /// Turned in the visual's frame.
    pub placement: Pose,
    pub rgba: Option<[f32; 4]>,
    pub image: Option<Arc<Image>>,
    /// Where on a mesh images are.
    corners: Option<Arc<Vec<Corners>>>,
}

impl Shown {
    pub fn new(geometry: Geometry) -> Self {
        Self { geometry, placement: Pose::IDENTITY, rgba: None, image: None, corners: None }
    }

    /// The image where it is; none on a mesh that does not say where.
    fn texture(&self) -> Option<Texture> {
        let image = self.image.clone()?;
        let spread = match (&self.corners, &self.geometry) {
            (Some(corners), _) => Spread::Corners(corners.clone()),
            (None, Geometry::TriangleMesh(_)) => return None,
            (None, Geometry::Plane) => Spread::Plane([1.0; 2]),
            (None, Geometry::Box { half_extents }) => Spread::Cube((2.0 * *half_extents).to_array()),
            (None, other) => Spread::Cube([2.0 * other.bounding_radius(); 3]),
        };
        Some(Texture { image, spread })
    }
}

/// Where a visual belongs.
pub(crate) struct Place {
    pub name: String,
    pub body: BodyId,
    pub placement: Pose,
}

/// The meshes and images that visuals show, each read once.
pub(crate) struct Visuals {
    /// Whether they are asked for.
    pub wanted: bool,
    meshes: HashMap<MeshKey, Vec<Shown>>,
    images: HashMap<PathBuf, Option<Arc<Image>>>,
    base: PathBuf,
    package_dirs: Vec<PathBuf>,
}

impl Visuals {
    pub fn new(base: &Path, options: &LoadOptions) -> Self {
        Self {
            wanted: options.visuals,
            meshes: HashMap::new(),
            images: HashMap::new(),
            base: base.to_owned(),
            package_dirs: options.package_dirs.clone(),
        }
    }

    /// The file that a URI names.
    pub fn path(&self, uri: &str) -> PathBuf {
        packages::resolve(uri, &self.base, &self.package_dirs)
    }

    /// The file or folder that a URI names.
    pub fn place(&self, uri: &str) -> PathBuf {
        packages::resolve_where(uri, &self.base, &self.package_dirs, Path::exists)
    }

    /// The parts of a mesh by colour; nothing, which is noted, where the file cannot be read.
    pub fn mesh(&mut self, meshes: &mut MeshStore, element: Element, named: Named) -> Vec<Shown> {
        let Named { uri: (uri, at), part, scale } = named;
        let key = ((self.path(uri), part), scale.to_array().map(f64::to_bits));
        if let Some(known) = self.meshes.get(&key) {
            return known.clone();
        }
        let shown = self.parts_of(meshes, element, &key.0, scale).unwrap_or_else(|reason| {
            let what = format!("'{}' cannot be shown: {reason}", key.0.0.display());
            element.note(at, what, "pictures show what the link touches with", false);
            Vec::new()
        });
        self.meshes.insert(key, shown.clone());
        shown
    }

    fn parts_of(
        &mut self,
        meshes: &mut MeshStore,
        element: Element,
        file: &FileKey,
        scale: DVec3,
    ) -> Result<Vec<Shown>, String> {
        let painted = meshes.painted(file)?;
        if painted.paint_of.is_empty() && painted.corners.is_empty() {
            // One mesh, which may be what touches, too.
            return Ok(vec![Shown::new(Geometry::TriangleMesh(meshes.scaled(file, scale)?))]);
        }
        let folder = file.0.parent().unwrap_or(Path::new(""));
        Ok(painted.surfaces().into_iter().map(|surface| self.shown(element, surface, scale, folder)).collect())
    }

    fn shown(&mut self, element: Element, surface: Surface, scale: DVec3, folder: &Path) -> Shown {
        let Surface { mesh, mut corners, paint: Paint { rgba, image } } = surface;
        if scale.x * scale.y * scale.z < 0.0 {
            // The triangles turn round, too.
            corners.iter_mut().for_each(|c| c.swap(1, 2));
        }
        let mut shown = Shown::new(Geometry::TriangleMesh(Arc::new(mesh::scaled(mesh, scale))));
        shown.rgba = rgba;
        shown.image = match image {
            Some(Source::Here(image)) => Some(image),
            Some(Source::File(path)) => self.image(element, &self.found(path, folder)),
            None => None,
        };
        shown.corners = Some(corners).filter(|corners| !corners.is_empty()).map(Arc::new);
        shown
    }

    /// The image of a mesh file: a URI, a path, or by its name where images are kept.
    fn found(&self, path: PathBuf, folder: &Path) -> PathBuf {
        let text = path.to_string_lossy();
        match ["package://", "model://", "file://"].iter().find_map(|scheme| text.find(scheme)) {
            Some(start) => self.path(&text[start..]),
            None => found_near(path, folder),
        }
    }

    /// An image; none, which is noted, where it cannot be read.
    pub fn image(&mut self, element: Element, path: &Path) -> Option<Arc<Image>> {
        if let Some(known) = self.images.get(path) {
            return known.clone();
        }
        let image = match picture::load(path) {
            Ok(image) => Some(Arc::new(image)),
            Err(reason) => {
                let what = format!("the image '{}' cannot be read: {reason}", path.display());
                element.note(element.at(), what, "the surface has a colour alone", false);
                None
            }
        };
        self.images.insert(path.to_owned(), image.clone());
        image
    }

    /// Adds what a visual shows; what no model can have is noted.
    pub fn add(
        &self,
        parts: &mut Parts,
        visual: Element,
        place: &Place,
        shown: Vec<Shown>,
    ) -> Result<bool, FormatError> {
        let mut seen = false;
        for part in shown {
            if let Err(reason) = part.geometry.check() {
                let what = format!("cannot be shown: {}: {reason}", part.geometry.kind_name());
                visual.note(visual.at(), what, "it is left out of pictures", false);
                continue;
            }
            let look = Look::default().with_group(SEEN).with_texture(part.texture());
            let mut geom = Geom::new("", part.geometry);
            let at = place.placement * part.placement;
            geom.placement = Pose::new(at.position, at.rotation.normalize());
            (geom.contact_type, geom.contact_affinity) = (0, 0);
            geom.rgba = part.rgba.unwrap_or(geom.rgba);
            geom.look = look;
            let name = parts.unused_geom_name(&place.name);
            parts.add_geom(visual, Some(name), place.body, geom)?;
            seen = true;
        }
        Ok(seen)
    }
}

/// The image of a mesh file: where the file says, else by its name beside it or where Gazebo keeps textures.
fn found_near(path: PathBuf, folder: &Path) -> PathBuf {
    let Some(name) = path.file_name().filter(|_| !path.is_file()) else { return path };
    let places = ["", "../materials/textures", "../textures", "textures"];
    let mut candidates = places.iter().map(|place| folder.join(place).join(name));
    candidates.find(|candidate| candidate.is_file()).unwrap_or(path.clone())
}
