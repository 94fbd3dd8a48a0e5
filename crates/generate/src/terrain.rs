//! Ground that is not flat: stairs, rough ground, terrain from a picture; with objects that fall on it where asked for.

use std::io::{BufRead, Seek};

use derive_setters::Setters;

use crate::error::{GenerateError, count, extent, not_negative};
use crate::objects::{self, Shapes};
use crate::random::Random;
use crate::text::{Text, list};

/// Objects that fall on the ground in a line of columns: a cell for each, five in a layer.
fn scatter(text: &mut Text, random: &mut Random, count: usize, reach: f64, top: f64) {
    let radius = 0.05;
    for k in 0..count {
        let at = |random: &mut Random| random.between(-reach, reach);
        let place = [at(random), at(random), top + 2.2 * radius * (k as f64 + 1.0)];
        objects::add(text, random, k, Shapes::Mixed, radius, place);
    }
}

/// Steps that lead up along x, solid below.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Stairs {
    /// Number of steps.
    pub steps: usize,
    /// Height of a step, m.
    pub rise: f64,
    /// Length of a step, m.
    pub run: f64,
    /// Width, m.
    pub width: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Objects that fall onto the stairs.
    pub objects: usize,
    /// Which objects.
    pub seed: u64,
}

impl Stairs {
    /// Steps of 17 × 29 cm, 1 m wide, with friction 0.8 and nothing on them.
    pub fn new(steps: usize) -> Self {
        Self { steps, rise: 0.17, run: 0.29, width: 1.0, friction: 0.8, objects: 0, seed: 0 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { steps, rise, run, width, friction, objects, seed } = *self;
        count("steps", steps, 1)?;
        count("objects", objects, 0)?;
        [("rise", rise), ("run", run), ("width", width)].iter().try_for_each(|(name, x)| extent(name, *x))?;
        not_negative("friction", friction)?;
        let how = format!("{steps} steps of {rise} m by {run} m; made by signorini-generate");
        let mut text = Text::new("stairs", how);
        text.floor();
        for k in 0..steps {
            // Every step reaches down to the floor and forward to the end: no seam lies where something can stand.
            let height = rise * (k + 1) as f64;
            let length = run * (steps - k) as f64;
            let place = [run * k as f64 + 0.5 * length, 0.0, height - 0.5 * rise];
            let size = list(&[0.5 * length, 0.5 * width, 0.5 * rise]);
            let (place, gray) = (list(&place), ["0.72 0.72 0.70 1", "0.66 0.66 0.64 1"][k % 2]);
            text.line(&format!(
                "<geom name=\"step{k}\" type=\"box\" pos=\"{place}\" size=\"{size}\" rgba=\"{gray}\"/>"
            ));
        }
        let mut random = Random::new(seed);
        let radius = 0.05;
        for k in 0..objects {
            let x = random.between(0.0, run * steps as f64);
            let y = random.between(-0.4, 0.4) * width;
            let place = [x, y, rise * steps as f64 + 2.2 * radius * (k as f64 + 1.0)];
            objects::add(&mut text, &mut random, k, Shapes::Mixed, radius, place);
        }
        Ok(text.finish(friction))
    }
}

/// A height field of octaves of value noise: hills with smaller ones on them.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Rough {
    /// Number of grid points along either side.
    pub points: usize,
    /// Length of a side, m.
    pub size: f64,
    /// Height between the lowest and the highest point, m.
    pub height: f64,
    /// Share of its height that every octave has of the one before, 0 to 1: 0 gives smooth hills.
    pub roughness: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Objects that fall onto it.
    pub objects: usize,
    /// Which ground and which objects.
    pub seed: u64,
}

impl Rough {
    /// 64 × 64 points over 6 × 6 m, 40 cm high, roughness 0.45, friction 0.9, with nothing on it.
    pub fn new() -> Self {
        Self { points: 64, size: 6.0, height: 0.4, roughness: 0.45, friction: 0.9, objects: 0, seed: 0 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { points, size, height, roughness, friction, objects, seed } = *self;
        count("points", points, 2)?;
        count("points times points", points.saturating_mul(points), 4)?;
        not_negative("roughness", roughness)?;
        if roughness > 1.0 {
            return Err(GenerateError::Number { name: "roughness", expected: "0 to 1", found: roughness });
        }
        let mut random = Random::new(seed);
        let mut heights = vec![0.0; points * points];
        let (mut cells, mut strength) = (4, 1.0);
        while cells < 2 * points && strength > 1e-3 {
            let n = cells + 2;
            let lattice: Vec<f64> = (0..n * n).map(|_| random.between(-1.0, 1.0)).collect();
            for (i, h) in heights.iter_mut().enumerate() {
                let place = |k: usize| cells as f64 * k as f64 / (points - 1) as f64;
                *h += strength * noise(&lattice, n, place(i % points), place(i / points));
            }
            (cells, strength) = (2 * cells, strength * roughness);
        }
        let how = format!(
            "rough ground, {points} x {points} points, roughness {roughness}, seed {seed}; made by signorini-generate"
        );
        Terrain::new([points, points], heights)
            .with_size([size, size])
            .with_height(height)
            .with_friction(friction)
            .with_objects(objects)
            .with_seed(seed)
            .written("rough", how)
    }
}

impl Default for Rough {
    fn default() -> Self {
        Self::new()
    }
}

/// Numbers on a lattice, joined smoothly (the fifth-order polynomial of Perlin 2002).
fn noise(lattice: &[f64], n: usize, x: f64, y: f64) -> f64 {
    let (i, j) = (x.floor() as usize, y.floor() as usize);
    let smooth = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (s, t) = (smooth(x - i as f64), smooth(y - j as f64));
    let at = |i: usize, j: usize| lattice[j.min(n - 1) * n + i.min(n - 1)];
    let row = |j: usize| at(i, j) + s * (at(i + 1, j) - at(i, j));
    row(j) + t * (row(j + 1) - row(j))
}

/// A height field of given heights, as of a picture.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Terrain {
    /// Number of grid points along x and y.
    #[setters(skip)]
    pub points: [usize; 2],
    /// Heights in any unit, row after row from the lowest y on.
    #[setters(skip)]
    pub heights: Vec<f64>,
    /// Length along x and y, m.
    pub size: [f64; 2],
    /// Height between the lowest and the highest point, m.
    pub height: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Objects that fall onto it.
    pub objects: usize,
    /// Which objects.
    pub seed: u64,
}

impl Terrain {
    /// Heights over 10 cm for every grid point, 1 m high, with friction 0.9 and nothing on it.
    pub fn new(points: [usize; 2], heights: Vec<f64>) -> Self {
        let size = points.map(|n| 0.1 * n.saturating_sub(1).max(1) as f64);
        Self { points, heights, size, height: 1.0, friction: 0.9, objects: 0, seed: 0 }
    }

    /// Heights by the brightness of a PNG, white highest; its upper row is at the largest y.
    ///
    /// # Errors
    /// [`GenerateError::Picture`].
    pub fn of_picture(png: impl BufRead + Seek) -> Result<Self, GenerateError> {
        let cannot = |e: png::DecodingError| GenerateError::Picture(e.to_string());
        let mut decoder = png::Decoder::new(png);
        decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
        let mut reader = decoder.read_info().map_err(cannot)?;
        let size = reader.output_buffer_size().ok_or_else(|| GenerateError::Picture("it is too large".into()))?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes).map_err(cannot)?;
        let channels = info.color_type.samples();
        let (width, height) = (info.width as usize, info.height as usize);
        // Of gray and transparent pictures the gray, of others the mean of the colours.
        let colors = if channels < 3 { 1 } else { 3 };
        let brightness = |pixel: &[u8]| pixel[..colors].iter().map(|x| f64::from(*x)).sum::<f64>() / colors as f64;
        let rows = bytes[..info.buffer_size()].chunks_exact(info.line_size).rev();
        let heights = rows.flat_map(|row| row.chunks_exact(channels).map(brightness)).collect();
        Ok(Self::new([width, height], heights))
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let [nx, ny] = self.points;
        self.written("terrain", format!("terrain of {nx} x {ny} points; made by signorini-generate"))
    }

    fn written(&self, name: &str, how: String) -> Result<String, GenerateError> {
        let Self { points: [nx, ny], heights, size: [x, y], height, friction, objects, seed } = self;
        count("points", (*nx).min(*ny), 2)?;
        count("points", nx.saturating_mul(*ny), 4)?;
        count("objects", *objects, 0)?;
        if heights.len() != nx * ny || heights.iter().any(|h| !h.is_finite()) {
            let expected = "finite, as many as points";
            return Err(GenerateError::Number { name: "heights", expected, found: heights.len() as f64 });
        }
        [("size", *x), ("size", *y), ("height", *height)].iter().try_for_each(|(name, x)| extent(name, *x))?;
        not_negative("friction", *friction)?;
        let mut text = Text::new(name, how);
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let span = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low;
        // MJCF scales elevations to [0, 1] and has the upper row first. Six digits of the height are finer than any ground.
        let share = |h: &f64| if span > 0.0 { ((h - low) / span * 1e6).round() / 1e6 } else { 0.0 };
        let rows = heights.chunks_exact(*nx).rev().map(|row| list(&row.iter().map(share).collect::<Vec<_>>()));
        let rows = rows.collect::<Vec<_>>().join("\n      ");
        let field = list(&[0.5 * x, 0.5 * y, *height, 0.1]);
        text.asset(&format!(
            "<hfield name=\"ground\" nrow=\"{ny}\" ncol=\"{nx}\" size=\"{field}\" elevation=\"{rows}\"/>"
        ));
        text.line("<geom name=\"ground\" type=\"hfield\" hfield=\"ground\" rgba=\"0.60 0.64 0.52 1\"/>");
        scatter(&mut text, &mut Random::new(*seed), *objects, 0.35 * x.min(*y), *height);
        Ok(text.finish(*friction))
    }
}
