//! How bodies look, as recordings say it.

use std::sync::Arc;

use signorini_multibody::{Camera, CameraMode, Geom, Geometry, Image, Light, Model, Spread, Texture};
use signorini_recording::{
    CameraVisual, CheckerVisual, ImageFile, LightVisual, LookVisual, SpreadVisual, TextureVisual,
};

/// Longest side of an image in a recording, in pixels, of few and of many images.
const SIDES: [u32; 2] = [512, 256];
/// More images than this are many.
const FEW: usize = 16;

/// The images met so far.
pub(super) struct Looks {
    images: Vec<(Arc<Image>, ImageFile)>,
    side: u32,
}

impl Looks {
    pub fn of(model: &Model) -> Self {
        let textures = model.geoms.iter().filter_map(|geom| geom.look.texture.as_ref());
        let mut pointers: Vec<*const Image> = textures.map(|texture| Arc::as_ptr(&texture.image)).collect();
        pointers.sort_unstable();
        pointers.dedup();
        Self { images: Vec::new(), side: SIDES[usize::from(pointers.len() > FEW)] }
    }

    pub fn visual(&mut self, geom: &Geom) -> LookVisual {
        let look = &geom.look;
        LookVisual {
            group: look.group,
            specular: look.specular,
            shininess: look.shininess,
            emission: look.emission,
            checker: look.checker.map(|checker| CheckerVisual { colors: checker.colors, square: checker.square }),
            texture: look.texture.as_ref().and_then(|texture| self.texture(texture, &geom.geometry)),
        }
    }

    /// None where the image is none, or its places are those of another mesh.
    fn texture(&mut self, texture: &Texture, geometry: &Geometry) -> Option<TextureVisual> {
        let spread = match (&texture.spread, geometry) {
            (Spread::Corners(corners), Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh)) => {
                (corners.len() == mesh.triangles.len()).then(|| SpreadVisual::Corners(corners.to_vec()))?
            }
            (Spread::Corners(_), _) => return None,
            (Spread::Plane(sides), _) => SpreadVisual::Plane(*sides),
            (Spread::Cube(sides), _) => SpreadVisual::Cube(*sides),
        };
        let image = match self.images.iter().position(|(known, _)| Arc::ptr_eq(known, &texture.image)) {
            Some(known) => known,
            None => {
                let Image { width, height, rgb } = &*texture.image;
                self.images.push((texture.image.clone(), ImageFile::new(*width, *height, rgb, self.side)?));
                self.images.len() - 1
            }
        };
        Some(TextureVisual { image, spread })
    }

    pub fn images(self) -> Vec<ImageFile> {
        self.images.into_iter().map(|(_, file)| file).collect()
    }
}

pub(super) fn light_visual(light: &Light) -> LightVisual {
    LightVisual {
        body: light.body.index(),
        position: light.position.to_array(),
        direction: light.direction.to_array(),
        directional: light.directional,
        color: light.color,
        shadows: light.shadows,
    }
}

/// A camera that is part of a body; those that follow or aim are left out.
///
/// - `pose`: its placement
pub(super) fn camera_visual(camera: &Camera, pose: [f64; 7]) -> Option<CameraVisual> {
    (camera.mode == CameraMode::Fixed).then(|| CameraVisual {
        name: camera.name.clone(),
        body: camera.body.index(),
        pose,
        field_of_view: camera.field_of_view,
    })
}
