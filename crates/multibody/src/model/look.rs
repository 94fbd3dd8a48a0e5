//! What pictures need to know of a model. Nothing of the motion depends on it, and neither does the model's hash.

use std::sync::Arc;

use derive_setters::Setters;
use glamx::glam::DVec3;

use super::BodyId;
use crate::math::Pose;

/// How the surface of a geom looks, beside its colour.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Look {
    /// Visibility group (MJCF `group`): 0 to 2 are shown where nothing else is asked for; robots keep their collision shapes in 3.
    pub group: u8,
    /// Strength of highlights, 0 to 1.
    pub specular: f32,
    /// Narrowness of highlights, 0 to 1.
    pub shininess: f32,
    /// Share of the surroundings that the surface mirrors, 0 to 1.
    pub reflectance: f32,
    /// Share of its colour that it gives off without light, 0 to 1.
    pub emission: f32,
    /// Squares of two colours instead of one colour.
    #[setters(into)]
    pub checker: Option<Checker>,
    /// An image whose colours multiply the geom's.
    #[setters(into)]
    pub texture: Option<Texture>,
}

impl Default for Look {
    /// MuJoCo's defaults for a geom without material.
    fn default() -> Self {
        Self { group: 0, specular: 0.5, shininess: 0.5, reflectance: 0.0, emission: 0.0, checker: None, texture: None }
    }
}

/// Squares in the geom's x–y plane, one corner of four at its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The two colours, which multiply the geom's: red, green, blue, each 0 to 1.
    pub colors: [[f32; 3]; 2],
    /// Lengths of a square along x and y, m, > 0.
    pub square: [f64; 2],
}

/// An image on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image, which surfaces share.
    pub image: Arc<Image>,
    /// Where on the surface it is.
    pub spread: Spread,
}

/// Pixels, rows from the upper one on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Red, green, blue in sRGB, `[height × width × 3]`.
    pub rgb: Vec<u8>,
}

/// Where on a surface an image is. Image coordinates (u, v) lead from its lower left corner, (0, 0), to the upper right one, (1, 1);
/// beyond them the image repeats.
#[derive(Clone, Debug, PartialEq)]
pub enum Spread {
    /// The image coordinates of the corners of every triangle of a mesh, as many as it has triangles.
    Corners(Arc<Vec<[[f32; 2]; 3]>>),
    /// Along the geom's x and y axes with the image's middle at the origin: lengths of the image along them, m, > 0.
    Plane([f64; 2]),
    /// On the six sides of a box about the origin: lengths of the image along x, y and z, m, > 0.
    Cube([f64; 3]),
}

impl Image {
    /// An image of given pixels; none where their number is not that of its size.
    ///
    /// - `rgb`: `[height × width × 3]`
    pub fn new(width: u32, height: u32, rgb: Vec<u8>) -> Option<Self> {
        let bytes = (width as usize).checked_mul(height as usize)?.checked_mul(3)?;
        (bytes > 0 && rgb.len() == bytes).then_some(Self { width, height, rgb })
    }
}

/// A camera of the model.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Camera {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// The body it is fixed to.
    #[setters(skip)]
    pub body: BodyId,
    /// `X_BC`: x to the right of the picture, y up, −z into the scene.
    #[setters(into)]
    pub placement: Pose,
    /// Angle between the picture's lower and upper edge, rad, in (0, π).
    pub field_of_view: f64,
    /// How it moves.
    pub mode: CameraMode,
    /// Pixels of its picture, width and height, for sensors that measure in it.
    pub resolution: [u32; 2],
    /// Focal lengths in units of the picture's width and height, for sensors that measure in it; none: those of the field of view with
    /// square pixels.
    #[setters(into)]
    pub focal: Option<[f64; 2]>,
    /// `X_WC` at the reference configuration with the origin of what it tracks as origin; set by the builder.
    #[setters(skip)]
    pub(crate) start: Pose,
}

impl Camera {
    /// A camera at its body's origin with a field of view of 45°, fixed to the body.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            body: BodyId::WORLD,
            placement: Pose::IDENTITY,
            field_of_view: 45.0_f64.to_radians(),
            mode: CameraMode::Fixed,
            resolution: [1; 2],
            focal: None,
            start: Pose::IDENTITY,
        }
    }
}

/// How a camera follows its body (MJCF `mode`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraMode {
    /// It is part of the body.
    Fixed,
    /// It keeps its distance from the body's origin and its own orientation, as they are at the reference configuration.
    Track,
    /// The same with the centre of mass of the body's subtree.
    TrackCenterOfMass,
    /// It is carried by the body and looks at the origin of another one.
    Target(BodyId),
    /// It is carried by the body and looks at the centre of mass of another one's subtree.
    TargetCenterOfMass(BodyId),
}

/// A light of the model.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Light {
    /// Name; may be empty.
    #[setters(into)]
    pub name: String,
    /// The body it is fixed to.
    #[setters(skip)]
    pub body: BodyId,
    /// Where it is in the body's frame, m; of no meaning for a directional one.
    #[setters(into)]
    pub position: DVec3,
    /// Where it shines, in the body's axes, unit.
    #[setters(into)]
    pub direction: DVec3,
    /// Whether its rays are parallel, as those of the sun.
    pub directional: bool,
    /// Red, green, blue, each 0 to 1.
    pub color: [f32; 3],
    /// Whether things throw shadows in it.
    pub shadows: bool,
}

impl Light {
    /// A white sun along a direction (world axes, any length) that throws shadows.
    pub fn sun(direction: impl Into<DVec3>) -> Self {
        Self {
            name: String::new(),
            body: BodyId::WORLD,
            position: DVec3::ZERO,
            direction: direction.into().normalize_or(DVec3::NEG_Z),
            directional: true,
            color: [0.7; 3],
            shadows: true,
        }
    }
}
