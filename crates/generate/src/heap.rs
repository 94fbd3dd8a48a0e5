//! Objects that fall on a heap.

use derive_setters::Setters;

use crate::error::{GenerateError, count, extent, not_negative};
use crate::objects::{self, Shapes};
use crate::random::Random;
use crate::text::{Text, list};

/// Random objects above each other that fall into a bin, or onto the floor.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Heap {
    /// Number of objects.
    pub count: usize,
    /// What they are.
    pub shapes: Shapes,
    /// About their radius, m.
    pub radius: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Whether there are four walls around.
    pub bin: bool,
    /// Which of all such heaps.
    pub seed: u64,
}

impl Heap {
    /// A heap of boxes of about 5 cm in a bin, with friction 0.6 and seed 0.
    pub fn new(count: usize) -> Self {
        Self { count, shapes: Shapes::default(), radius: 0.05, friction: 0.6, bin: true, seed: 0 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { count: n, shapes, radius, friction, bin, seed } = *self;
        count("count", n, 1)?;
        extent("radius", radius)?;
        not_negative("friction", friction)?;
        let mut random = Random::new(seed);
        let how = format!("{n} objects fall ({shapes:?}, radius {radius} m, seed {seed}); made by signorini-generate");
        let mut text = Text::new("heap", how);
        text.floor();
        // Objects begin in cells in which they cannot touch, in layers about as wide as the heap will be high.
        let side = ((n as f64).cbrt().ceil() as usize).max(2);
        let cell = 2.2 * radius;
        if bin {
            walls(&mut text, 0.5 * cell * side as f64 + 0.2 * radius, radius);
        }
        let middle = 0.5 * (side as f64 - 1.0);
        for k in 0..n {
            let mut shift = || random.between(-0.04, 0.04) * cell;
            let [x, y, z] = [k % side, k / side % side, k / (side * side)].map(|i| i as f64);
            let place = [cell * (x - middle) + shift(), cell * (y - middle) + shift(), cell * (z + 0.6) + shift()];
            objects::add(&mut text, &mut random, k, shapes, radius, place);
        }
        Ok(text.finish(friction))
    }
}

/// Four walls around a square of half-length `half`, m, as high as half of it.
fn walls(text: &mut Text, half: f64, radius: f64) {
    let (thick, high) = (0.5 * radius, (0.5 * half).max(2.0 * radius));
    let out = half + thick;
    for (k, (place, size)) in [
        ([out, 0.0, high], [thick, out + thick, high]),
        ([-out, 0.0, high], [thick, out + thick, high]),
        ([0.0, out, high], [half, thick, high]),
        ([0.0, -out, high], [half, thick, high]),
    ]
    .iter()
    .enumerate()
    {
        let (place, size) = (list(place), list(size));
        let geom =
            format!("<geom name=\"wall{k}\" type=\"box\" pos=\"{place}\" size=\"{size}\" rgba=\"0.7 0.75 0.8 0.25\"/>");
        text.line(&geom);
    }
}
