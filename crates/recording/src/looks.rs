//! What surfaces look like, and from where and by what light they are seen. Nothing of the motion depends on it.

use std::io::Cursor;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::FilterType;
use image::{ImageReader, RgbImage};
use serde::{Deserialize, Serialize};

use crate::frame::PoseArray;

/// Quality of JPEG, of 100.
const QUALITY: u8 = 85;

/// What a surface looks like beside its colour.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LookVisual {
    /// Visibility group: 0 to 2 are shown where nothing else is asked for.
    pub group: u8,
    /// Strength of highlights, 0 to 1.
    pub specular: f32,
    /// Narrowness of highlights, 0 to 1.
    pub shininess: f32,
    /// Share of its colour that it gives off without light, 0 to 1.
    pub emission: f32,
    /// Squares of two colours, which multiply its colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checker: Option<CheckerVisual>,
    /// An image whose colours multiply its colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureVisual>,
}

impl Default for LookVisual {
    /// Grey plastic in group 0.
    fn default() -> Self {
        Self { group: 0, specular: 0.5, shininess: 0.5, emission: 0.0, checker: None, texture: None }
    }
}

impl LookVisual {
    pub(crate) fn is_plain(&self) -> bool {
        *self == Self::default()
    }
}

/// Squares in the x–y plane of a geom, one corner of four at its origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CheckerVisual {
    /// Red, green, blue of the two colours, each 0 to 1.
    pub colors: [[f32; 3]; 2],
    /// Lengths of a square along x and y, m.
    pub square: [f64; 2],
}

/// An image on a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TextureVisual {
    /// Index into [`Header::images`](crate::Header::images).
    pub image: usize,
    /// Where it is.
    pub spread: SpreadVisual,
}

/// Where on a surface an image is: (0, 0) is its lower left corner, (1, 1) its upper right one, and beyond it repeats.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpreadVisual {
    /// Image coordinates of the corners of every triangle of a mesh.
    Corners(Vec<[[f32; 2]; 3]>),
    /// In the geom's x–y plane with its middle at the origin: lengths of the image, m.
    Plane([f64; 2]),
    /// On the sides of a box about the origin: lengths of the image along x, y, z, m.
    Cube([f64; 3]),
}

/// An image as a JPEG file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ImageFile {
    /// The bytes of the file as base64 text.
    pub base64: String,
}

impl ImageFile {
    /// An image of pixels, rows from the upper one on; none where their number is not that of its size.
    ///
    /// - `rgb`: `[height × width × 3]`
    /// - `longest`: longer sides are made as short as this, in pixels
    pub fn new(width: u32, height: u32, rgb: &[u8], longest: u32) -> Option<Self> {
        let image = RgbImage::from_raw(width, height, rgb.to_vec())?;
        Self::encoded(image, longest)
    }

    /// The same image with no side longer than `longest` pixels.
    pub(crate) fn smaller(&self, longest: u32) -> Option<Self> {
        let bytes = STANDARD.decode(&self.base64).ok()?;
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?;
        Self::encoded(reader.decode().ok()?.into_rgb8(), longest)
    }

    fn encoded(image: RgbImage, longest: u32) -> Option<Self> {
        let (width, height) = image.dimensions();
        let side = width.max(height).max(1);
        let image = if side > longest {
            let part = |n: u32| (u64::from(n) * u64::from(longest) / u64::from(side)).max(1) as u32;
            image::imageops::resize(&image, part(width), part(height), FilterType::Triangle)
        } else {
            image
        };
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&image).ok()?;
        Some(Self { base64: STANDARD.encode(bytes) })
    }
}

/// A light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LightVisual {
    /// The body that carries it, index into [`Header::bodies`](crate::Header::bodies).
    pub body: usize,
    /// Place in the body's frame, m.
    pub position: [f64; 3],
    /// Unit vector in the body's frame along which it shines.
    pub direction: [f64; 3],
    /// Whether its rays are parallel.
    pub directional: bool,
    /// Red, green, blue.
    pub color: [f32; 3],
    /// Whether it casts shadows.
    pub shadows: bool,
}

/// A camera that is part of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraVisual {
    /// Name.
    pub name: String,
    /// The body, index into [`Header::bodies`](crate::Header::bodies).
    pub body: usize,
    /// PoseArray in the body's frame: x to the right of the picture, y up, −z into the scene.
    pub pose: PoseArray,
    /// Angle between the picture's lower and upper edge, rad.
    pub field_of_view: f64,
}
