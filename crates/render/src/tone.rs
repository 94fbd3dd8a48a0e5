//! Between light and the numbers of pixels.

use signorini_multibody::glam::Vec3;

/// From sRGB to linear light.
pub(crate) fn linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// From linear light to sRGB in bytes; what is brighter than white keeps its hue as long as it can.
pub(crate) fn bytes(color: Vec3) -> [u8; 3] {
    let peak = color.max_element();
    // A shoulder from 0.8 on, as film has it: 1 at infinity.
    let shoulder = |x: f32| if x <= 0.8 { x } else { 1.0 - 0.04 / (x - 0.6) };
    let color = if peak > 0.8 { color * (shoulder(peak) / peak) } else { color };
    color.to_array().map(|x| (255.0 * encoded(x) + 0.5).clamp(0.0, 255.0) as u8)
}

/// From linear light to sRGB.
pub(crate) fn encoded(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
