//! From rays to pixels.

use rayon::prelude::*;
use signorini_multibody::glam::{DVec2, Vec3};

use crate::error::RenderError;
use crate::shade::{Lighting, Sample};
use crate::tone::bytes;
use crate::view::{Lens, View};
use crate::world::World;

/// What a camera sees.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green, blue in sRGB, `[height × width × 3]`, rows from the upper one on.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// A picture of given pixels, `[height × width × 3]`.
    ///
    /// # Errors
    /// [`RenderError::WrongLength`].
    pub fn new(width: usize, height: usize, rgb: Vec<u8>) -> Result<Self, RenderError> {
        let expected = width.saturating_mul(height).saturating_mul(3);
        match rgb.len() == expected {
            true => Ok(Self { width, height, rgb }),
            false => Err(RenderError::WrongLength { what: "the list of bytes", expected, found: rgb.len() }),
        }
    }
}

/// What is where in a picture, by the ray through the centre of every pixel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sight {
    /// Pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Distance along the camera's axis, m, `[height × width]`; infinite where there is nothing.
    pub depth: Vec<f64>,
    /// Index of the geom, `[height × width]`; −1 where there is none.
    pub geoms: Vec<i32>,
}

/// Neighbours whose colours differ by more than this (of 255) have an edge between them: less is not seen.
const EDGE: u8 = 10;
/// Samples of a pixel with an edge: rays through a grid of 3 × 3.
const EDGE_SAMPLES: usize = 9;

/// Depth and geoms.
pub(crate) fn sight(world: &World, view: &View, [width, height]: [usize; 2]) -> Sight {
    let lens = Lens::new(view, [width, height]);
    let mut seen = vec![(f64::INFINITY, -1); width * height];
    seen.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let (ray, cosine) = lens.ray(x as f64 + 0.5, y as f64 + 0.5);
            if let Some(met) = world.first(&ray, f64::INFINITY) {
                *pixel = (met.hit.distance * cosine, world.things[met.thing].geom as i32);
            }
        }
    });
    let (depth, geoms) = seen.into_iter().unzip();
    Sight { width, height, depth, geoms }
}

/// Colours: with one sample one ray through every pixel and more where neighbours differ; with more of them that many everywhere, soft
/// shadows and dark corners. Every pixel depends on the scene alone, not on threads.
pub(crate) fn color(world: &World, light: &Lighting, view: &View, size: [usize; 2], samples: usize) -> Picture {
    let [width, height] = size;
    let lens = Lens::new(view, size);
    let fine = samples > 1;
    let shot = |x: usize, y: usize, count: usize| -> Vec3 {
        let sum: Vec3 = (0..count)
            .map(|k| {
                let place = if count == 1 { DVec2::splat(0.5) } else { grid(k, count) };
                let (ray, _) = lens.ray(x as f64 + place.x, y as f64 + place.y);
                let met = world.first(&ray, f64::INFINITY);
                light.along(world, &ray, met, lens.pixel(), &sample(x, y, k, fine))
            })
            .sum();
        sum / count as f32
    };
    let mut pixels = vec![[0_u8; 3]; width * height];
    pixels.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, pixel)| *pixel = bytes(shot(x, y, samples.max(1))));
    });
    if !fine {
        let first = pixels.clone();
        let differs = |a: [u8; 3], b: [u8; 3]| (0..3).any(|k| a[k].abs_diff(b[k]) > EDGE);
        let at_edge = |x: usize, y: usize| {
            let own = first[y * width + x];
            let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
            around.iter().any(|&(x, y)| x < width && y < height && differs(own, first[y * width + x]))
        };
        pixels.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate().filter(|(x, _)| at_edge(*x, y)) {
                *pixel = bytes(shot(x, y, EDGE_SAMPLES));
            }
        });
    }
    Picture { width, height, rgb: pixels.into_flattened() }
}

/// Points that fill the unit square: the R₂ sequence (Roberts 2018), from half a step on.
fn grid(k: usize, count: usize) -> DVec2 {
    let side = (count as f64).sqrt().round() as usize;
    if side * side == count {
        return DVec2::new(((k % side) as f64 + 0.5) / side as f64, ((k / side) as f64 + 0.5) / side as f64);
    }
    sequence(k, DVec2::splat(0.5))
}

fn sequence(k: usize, start: DVec2) -> DVec2 {
    // 1/g and 1/g² of the plastic number g.
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);
    let p = start + k as f64 * STEP;
    p - p.floor()
}

/// Where a sample looks on the sun's disc and among the surroundings: a sequence that starts elsewhere in every pixel.
fn sample(x: usize, y: usize, k: usize, fine: bool) -> Sample {
    if !fine {
        return Sample { light: DVec2::splat(0.0), ambient: DVec2::splat(0.0), fine };
    }
    let hash = |salt: u64| {
        // SplitMix64 (Steele, Lea, Flood 2014).
        let mut z = (x as u64) << 32 | y as u64;
        z = (z ^ salt).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    let starts = [DVec2::new(hash(1), hash(2)), DVec2::new(hash(3), hash(4))];
    Sample { light: sequence(k, starts[0]), ambient: sequence(k, starts[1]), fine }
}
