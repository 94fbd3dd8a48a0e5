//! Images for surfaces, from files and from bytes.

use std::io::Cursor;
use std::path::Path;

use image::imageops::FilterType;
use image::{ImageReader, Limits, RgbImage};
use signorini_multibody::Image;

use super::bytes::read_file;

/// Image files larger than this are refused.
const MAX_BYTES: u64 = 128 << 20;
/// Longer and wider images are refused.
const MAX_SIDE: u32 = 16_384;
/// Larger images are made smaller: no picture of a robot shows more.
const KEPT_SIDE: u32 = 2048;

/// Reads an image file: PNG, JPEG, TGA or BMP, as its content says, else its extension.
pub(crate) fn load(path: &Path) -> Result<Image, String> {
    let bytes = read_file(path, MAX_BYTES)?;
    let mut reader = ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none()
        && let Ok(format) = image::ImageFormat::from_path(path)
    {
        reader.set_format(format);
    }
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    kept(reader.decode().map_err(|e| e.to_string())?.into_rgb8())
}

/// The image, no larger than it is worth.
pub(super) fn kept(image: RgbImage) -> Result<Image, String> {
    let (width, height) = image.dimensions();
    let longest = width.max(height);
    let image = if longest > KEPT_SIDE {
        let scaled = |n: u32| (u64::from(n) * u64::from(KEPT_SIDE) / u64::from(longest)).max(1) as u32;
        image::imageops::resize(&image, scaled(width), scaled(height), FilterType::Triangle)
    } else {
        image
    };
    let (width, height) = image.dimensions();
    Image::new(width, height, image.into_raw()).ok_or_else(|| "an image without pixels".into())
}
