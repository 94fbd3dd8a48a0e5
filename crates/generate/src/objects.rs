//! Random objects.

use crate::random::Random;
use crate::text::{Text, color, list};

/// What random objects are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shapes {
    /// Boxes of random proportions.
    #[default]
    Boxes,
    /// Balls.
    Spheres,
    /// Convex polyhedra over random points of an ellipsoid.
    Stones,
    /// Boxes, balls, capsules, cylinders, ellipsoids and stones.
    Mixed,
}

/// Adds a random object of about this radius (m) at a place.
pub(crate) fn add(text: &mut Text, random: &mut Random, k: usize, shapes: Shapes, radius: f64, position: [f64; 3]) {
    let sort = match shapes {
        Shapes::Boxes => 0,
        Shapes::Spheres => 1,
        Shapes::Stones => 5,
        Shapes::Mixed => random.below(6),
    };
    let mut part = |low: f64| radius * random.between(low, 1.0);
    let shape = match sort {
        // The corner of a box of these halves is within the radius.
        0 => format!("type=\"box\" size=\"{}\"", list(&[0.5 * part(0.5), 0.5 * part(0.5), 0.5 * part(0.5)])),
        1 => format!("type=\"sphere\" size=\"{}\"", part(0.6)),
        2 => {
            let r = 0.5 * part(0.5);
            format!("type=\"capsule\" size=\"{}\"", list(&[r, 0.95 * radius - r]))
        }
        3 => format!("type=\"cylinder\" size=\"{}\"", list(&[0.65 * part(0.5), 0.65 * part(0.5)])),
        4 => format!("type=\"ellipsoid\" size=\"{}\"", list(&[part(0.4), part(0.4), part(0.4)])),
        _ => {
            let axes = [part(0.6), part(0.6), part(0.6)];
            let points = stone(random, axes);
            text.asset(&format!("<mesh name=\"stone{k}\" vertex=\"{}\"/>", list(&points)));
            format!("type=\"mesh\" mesh=\"stone{k}\"")
        }
    };
    let geom = format!("{shape} density=\"1000\" rgba=\"{}\"", color(random.below(8)));
    let turn = random.rotation();
    text.body(&format!("object{k}"), position, Some(turn), &geom);
}

/// Fourteen points of an ellipsoid, no two close to each other: their hull has faces that a stone can lie on.
fn stone(random: &mut Random, axes: [f64; 3]) -> Vec<f64> {
    const POINTS: usize = 14;
    /// Of 14 points that are spread evenly on the unit sphere the nearest are about 0.93 apart.
    const APART: f64 = 0.5;
    let mut points: Vec<[f64; 3]> = Vec::with_capacity(POINTS);
    while points.len() < POINTS {
        let p = random.direction();
        let near = |q: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>() < APART * APART;
        if !points.iter().any(near) {
            points.push(p);
        }
    }
    points.iter().flat_map(|p| [p[0] * axes[0], p[1] * axes[1], p[2] * axes[2]]).collect()
}
