//! PNG, still and animated.

use std::io::Write;

use crate::error::RenderError;
use crate::picture::Picture;

/// Writes a picture as PNG.
///
/// # Errors
/// [`RenderError::Write`], [`RenderError::Encode`].
pub fn write_png(picture: &Picture, out: impl Write) -> Result<(), RenderError> {
    let mut encoder = png::Encoder::new(out, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb)?;
    Ok(writer.finish()?)
}

/// Writes pictures as one animated PNG that repeats; browsers show it where they show a picture.
///
/// - `frames`: of one size
/// - `rate`: frames per second
///
/// # Errors
/// [`RenderError::FrameSize`], [`RenderError::Write`], [`RenderError::Encode`].
pub fn write_animated_png(frames: &[Picture], rate: f64, out: impl Write) -> Result<(), RenderError> {
    let Some(first) = frames.first() else { return Err(RenderError::Encode("a film without frames".into())) };
    let mut encoder = png::Encoder::new(out, first.width as u32, first.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_animated(frames.len() as u32, 0)?;
    let milliseconds = (1000.0 / rate).round().clamp(1.0, 60_000.0) as u16;
    encoder.set_frame_delay(milliseconds, 1000)?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        let (expected, found) = ([first.width, first.height], [frame.width, frame.height]);
        if expected != found {
            return Err(RenderError::FrameSize { expected, found });
        }
        writer.write_image_data(&frame.rgb)?;
    }
    Ok(writer.finish()?)
}
