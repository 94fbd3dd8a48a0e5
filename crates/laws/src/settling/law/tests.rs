//! The projections against what makes a point the nearest one, and the slopes against differences.

use super::*;
use signorini_contact::vector::dot;
use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use std::f64::consts::PI;

const FRICTION: f64 = 0.6;
const TURNED: f64 = 0.3;
/// Of the differences; where a point's neighbours are on other pieces it is left out.
const STEP: f64 = 1e-6;

/// A contact whose polygon has so many corners, 0 for none.
fn cones(corners: usize) -> (Cones, ImpulseCones) {
    let mass = BlockDiagonal::from_dense(1, &[1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![0.0], 0.01).expect("valid");
    let polygon = match corners {
        0 => FrictionPolygon::frictionless(),
        corners => FrictionPolygon::regular(corners, TURNED).expect("even"),
    };
    problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, FRICTION, &polygon);
    let (mut cones, mut associated) = (Cones::default(), ImpulseCones::default());
    cones.prepare(&problem);
    associated.prepare(&problem, |_| Some(|_| true));
    (cones, associated)
}

/// The corners of a polygon of radius 1.
fn corners(count: usize) -> Vec<[f64; 2]> {
    (0..count).map(|k| TURNED + 2.0 * PI * k as f64 / count as f64).map(|a| [a.cos(), a.sin()]).collect()
}

/// How far outside the polygon of this radius a point is, along the normals of its sides.
fn outside(count: usize, radius: f64, t: [f64; 2]) -> f64 {
    let normals = (0..count).map(|k| TURNED + PI * (2 * k + 1) as f64 / count as f64);
    let inner = radius * (PI / count as f64).cos();
    normals.map(|a| t[0] * a.cos() + t[1] * a.sin() - inner).fold(t[0].hypot(t[1]) - radius, f64::max)
}

fn points() -> impl Iterator<Item = [f64; 3]> {
    let noise = |k: i32, r: usize| (1.7 * f64::from(k) * [1.0, 2.3, 3.1][r] + 0.4 * f64::from(k * k % 97)).sin();
    (0..300).map(move |k| std::array::from_fn(|r| noise(k, r) * [2.0, 1.2, 1.2][r]))
}

#[test]
fn bounded_friction_is_nearest_within_the_polygon_of_the_known_impulse() {
    for (count, normal) in [(4, 0.8), (8, 1.3), (6, 0.0)] {
        let (cones, associated) = cones(count);
        let (law, radius) = (Law::Bounded { normal }, FRICTION * normal);
        for y in points() {
            let (p, piece) = law.project((&cones, &associated), 0, y);
            assert_eq!(p[0], if y[0] > 0.0 { y[0] } else { 0.0 });
            assert!(matches!(piece, LawPiece::Bounded { closed, .. } if closed == (y[0] > 0.0)), "{piece:?}");
            assert!(outside(count, radius, [p[1], p[2]]) < 1e-14, "{p:?}");
            for corner in corners(count) {
                let toward = (y[1] - p[1]) * (radius * corner[0] - p[1]) + (y[2] - p[2]) * (radius * corner[1] - p[2]);
                assert!(toward < 1e-13, "a corner is nearer to {y:?} than {p:?}");
            }
        }
    }
}

/// Moreau's conditions: `p` in the cone, the rest in its polar cone, and the two perpendicular.
#[test]
fn associated_impulses_are_nearest_within_the_cone() {
    let (mut apex, mut inside, mut face) = (0, 0, 0);
    for count in [4, 8] {
        let (cones, associated) = cones(count);
        for y in points() {
            let (p, piece) = Law::Associated.project((&cones, &associated), 0, y);
            let rest: [f64; 3] = std::array::from_fn(|r| y[r] - p[r]);
            assert!(outside(count, FRICTION * p[0], [p[1], p[2]]) < 1e-13, "{p:?}");
            for d in corners(count) {
                assert!(dot([1.0, FRICTION * d[0], FRICTION * d[1]], rest) < 1e-13, "{y:?}: {p:?}");
            }
            assert!(dot(p, rest).abs() < 1e-13, "{y:?}: {p:?}");
            *match piece {
                LawPiece::Associated(Piece::Apex) => &mut apex,
                LawPiece::Associated(Piece::Interior) => &mut inside,
                _ => &mut face,
            } += 1;
        }
    }
    assert!(apex > 100 && inside > 30 && face > 100, "{apex} {inside} {face}");
}

#[test]
fn slopes_are_those_of_the_projections() {
    let mut compared = 0;
    for (count, law) in [
        (4, Law::Bounded { normal: 0.8 }),
        (8, Law::Bounded { normal: 1.3 }),
        (0, Law::Bounded { normal: 1.3 }),
        (4, Law::Associated),
        (8, Law::Associated),
        (0, Law::Associated),
    ] {
        let (cones, associated) = cones(count);
        let both = (&cones, &associated);
        for y in points() {
            let piece = law.project(both, 0, y).1;
            let slope = piece.slope(both, 0).unwrap_or_default();
            let moved =
                |c: usize, by: f64| law.project(both, 0, std::array::from_fn(|r| y[r] + if r == c { by } else { 0.0 }));
            let ends: [_; 3] = std::array::from_fn(|c| [moved(c, STEP), moved(c, -STEP)]);
            if ends.iter().flatten().any(|(_, other)| *other != piece) {
                continue;
            }
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let difference = (ends[c][0].0[r] - ends[c][1].0[r]) / (2.0 * STEP);
                assert!((slope[r][c] - difference).abs() < 1e-8, "{law:?} of {count} at {y:?}: {slope:?}");
            }
            compared += 1;
        }
    }
    assert!(compared > 1700, "{compared}");
}
