//! What stands by weight and friction: stacks, pallets, walls, arches.

use std::f64::consts::PI;

use derive_setters::Setters;

use crate::error::{GenerateError, count, extent, not_negative};
use crate::random::Random;
use crate::text::{Text, color, list};

/// Stone and brick, kg/m³.
const DENSITY: f64 = 2000.0;

/// Boxes on top of each other.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Stack {
    /// Number of boxes.
    pub count: usize,
    /// Length of an edge, m.
    pub size: f64,
    /// Most that a box is off the one below, as a share of its length; above 0.5 stacks begin to fall.
    pub offset: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Which of all such stacks.
    pub seed: u64,
}

impl Stack {
    /// A straight stack of cubes of 20 cm with friction 0.6.
    pub fn new(count: usize) -> Self {
        Self { count, size: 0.2, offset: 0.0, friction: 0.6, seed: 0 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { count: n, size, offset, friction, seed } = *self;
        count("count", n, 1)?;
        extent("size", size)?;
        not_negative("offset", offset)?;
        not_negative("friction", friction)?;
        let mut random = Random::new(seed);
        let how = format!(
            "{n} cubes of {size} m, each up to {offset} of its length off, seed {seed}; made by signorini-generate"
        );
        let mut text = Text::new("stack", how);
        text.floor();
        let half = 0.5 * size;
        for k in 0..n {
            let mut off = || offset * size * random.between(-1.0, 1.0);
            let place = [off(), off(), half + size * k as f64];
            let geom =
                format!("type=\"box\" size=\"{}\" density=\"{DENSITY}\" rgba=\"{}\"", list(&[half; 3]), color(k));
            text.body(&format!("box{k}"), place, None, &geom);
        }
        Ok(text.finish(friction))
    }
}

/// Boxes in layers on a pallet, every second layer turned, as they are shipped.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Pallet {
    /// Number of layers of nine boxes.
    pub layers: usize,
    /// Coefficient of friction.
    pub friction: f64,
    /// Whether the pallet can move; else it is part of the floor.
    pub free: bool,
}

impl Pallet {
    /// A pallet of 1.2 by 1.2 m that can move, with friction 0.5.
    pub fn new(layers: usize) -> Self {
        Self { layers, friction: 0.5, free: true }
    }

    /// The file. Boxes of 0.4 × 0.4 × 0.3 m become 0.4 × 0.6 in turned layers, so that joints do not lie above each other.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { layers, friction, free } = *self;
        count("layers", layers, 1)?;
        not_negative("friction", friction)?;
        let how = format!("a pallet with {layers} layers of boxes; made by signorini-generate");
        let mut text = Text::new("pallet", how);
        text.floor();
        let (base, high) = (0.144, 0.3);
        let wood = format!(
            "type=\"box\" size=\"{}\" density=\"120\" rgba=\"0.72 0.57 0.38 1\"",
            list(&[0.6, 0.6, 0.5 * base])
        );
        let place = [0.0, 0.0, 0.5 * base];
        if free {
            text.body("pallet", place, None, &wood);
        } else {
            text.line(&format!("<geom name=\"pallet\" pos=\"{}\" {wood}/>", list(&place)));
        }
        let mut k = 0;
        for layer in 0..layers {
            // Even layers are 3 × 3, odd ones 3 × 2.
            let (columns, rows) = (3, if layer % 2 == 0 { 3 } else { 2 });
            let half = [0.6 / columns as f64, 0.6 / rows as f64, 0.5 * high];
            let half = if layer % 4 == 3 { [half[1], half[0], half[2]] } else { half };
            let (columns, rows) = if layer % 4 == 3 { (rows, columns) } else { (columns, rows) };
            for i in 0..columns * rows {
                let at = |j: usize, half: f64| -0.6 + half * (2 * j + 1) as f64;
                let z = base + high * (layer as f64 + 0.5);
                let place = [at(i % columns, half[0]), at(i / columns, half[1]), z];
                let geom =
                    format!("type=\"box\" size=\"{}\" density=\"300\" rgba=\"{}\"", list(&half), CARDBOARD[i % 3]);
                text.body(&format!("box{k}"), place, None, &geom);
                k += 1;
            }
        }
        Ok(text.finish(friction))
    }
}

const CARDBOARD: [&str; 3] = ["0.78 0.64 0.46 1", "0.74 0.60 0.43 1", "0.81 0.68 0.50 1"];
const BRICK: [&str; 3] = ["0.70 0.36 0.28 1", "0.66 0.33 0.26 1", "0.74 0.40 0.31 1"];

/// A wall of bricks in running bond: every second course begins with half a brick.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Wall {
    /// Bricks in a course.
    pub columns: usize,
    /// Number of courses.
    pub courses: usize,
    /// Length, width and height of a brick, m.
    pub brick: [f64; 3],
    /// Coefficient of friction.
    pub friction: f64,
}

impl Wall {
    /// A wall of bricks of 24 × 11.5 × 7.1 cm with friction 0.7.
    pub fn new(columns: usize, courses: usize) -> Self {
        Self { columns, courses, brick: [0.24, 0.115, 0.071], friction: 0.7 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { columns, courses, brick: [length, width, height], friction } = *self;
        count("columns", columns, 1)?;
        count("courses", courses, 1)?;
        count("columns times courses", columns.saturating_mul(courses), 1)?;
        [length, width, height].iter().try_for_each(|x| extent("brick", *x))?;
        not_negative("friction", friction)?;
        let how = format!("a wall of {courses} courses of {columns} bricks; made by signorini-generate");
        let mut text = Text::new("wall", how);
        text.floor();
        let whole = length * columns as f64;
        let mut k = 0;
        for course in 0..courses {
            let mut x = -0.5 * whole;
            let halves = course % 2 == 1;
            for i in 0..columns + usize::from(halves) {
                let own = if halves && (i == 0 || i == columns) { 0.5 * length } else { length };
                let place = [x + 0.5 * own, 0.0, height * (course as f64 + 0.5)];
                let size = list(&[0.5 * own, 0.5 * width, 0.5 * height]);
                let geom =
                    format!("type=\"box\" size=\"{size}\" density=\"{DENSITY}\" rgba=\"{}\"", BRICK[(7 * k) % 3]);
                text.body(&format!("brick{k}"), place, None, &geom);
                x += own;
                k += 1;
            }
        }
        Ok(text.finish(friction))
    }
}

/// A half-circle of wedges that stands on the floor by pressure and friction.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Arch {
    /// Number of wedges.
    pub count: usize,
    /// Inner radius, m.
    pub radius: f64,
    /// Thickness as a share of the mean radius: below 0.108 no such arch stands (Milankovitch 1907).
    pub thickness: f64,
    /// Depth, m.
    pub depth: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

impl Arch {
    /// An arch with an inner radius of 1 m, 26 % thick and 30 cm deep, with friction 0.7.
    pub fn new(count: usize) -> Self {
        Self { count, radius: 1.0, thickness: 0.26, depth: 0.3, friction: 0.7 }
    }

    /// The file.
    ///
    /// # Errors
    /// [`GenerateError::Number`].
    pub fn mjcf(&self) -> Result<String, GenerateError> {
        let Self { count: n, radius, thickness, depth, friction } = *self;
        count("count", n, 3)?;
        [("radius", radius), ("thickness", thickness), ("depth", depth)]
            .iter()
            .try_for_each(|(name, x)| extent(name, *x))?;
        not_negative("friction", friction)?;
        if thickness >= 2.0 {
            return Err(GenerateError::Number { name: "thickness", expected: "below 2", found: thickness });
        }
        let how = format!("an arch of {n} wedges, thickness {thickness} of its radius; made by signorini-generate");
        let mut text = Text::new("arch", how);
        text.floor();
        let outer = radius * (2.0 + thickness) / (2.0 - thickness);
        let middle = 0.5 * (radius + outer);
        // One wedge about its middle, z outwards: corners at both radii and both sides.
        let slope = 0.5 * PI / n as f64;
        let corner = |r: f64, side: f64, y: f64| [side * r * slope.sin(), y, r * slope.cos() - middle];
        let y = 0.5 * depth;
        let corners =
            [radius, outer].map(|r| [corner(r, -1.0, -y), corner(r, -1.0, y), corner(r, 1.0, -y), corner(r, 1.0, y)]);
        let points: Vec<f64> = corners.as_flattened().as_flattened().to_vec();
        let faces = "0 1 3 0 3 2 4 6 7 4 7 5 0 4 5 0 5 1 2 3 7 2 7 6 0 2 6 0 6 4 1 5 7 1 7 3";
        text.asset(&format!("<mesh name=\"wedge\" inertia=\"exact\" vertex=\"{}\" face=\"{faces}\"/>", list(&points)));
        for k in 0..n {
            // From one foot to the other; the wedge's z axis is turned about y.
            let angle = PI * (k as f64 + 0.5) / n as f64 - 0.5 * PI;
            let place = [middle * angle.sin(), 0.0, middle * angle.cos()];
            let turn = [(0.5 * angle).cos(), 0.0, (0.5 * angle).sin(), 0.0];
            let shade = ["0.80 0.76 0.68 1", "0.75 0.71 0.63 1"][k % 2];
            let geom = format!("type=\"mesh\" mesh=\"wedge\" density=\"2400\" rgba=\"{shade}\"");
            text.body(&format!("wedge{k}"), place, Some(turn), &geom);
        }
        Ok(text.finish(friction))
    }
}
