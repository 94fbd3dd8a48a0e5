use signorini_multibody::BlockDiagonal;

use super::super::series::Ahead;
use super::*;
use crate::testing::on_ground_of;
use signorini_contact::vector::inner;
use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_sparse::Random;

const BODIES: usize = 4;
const CONTACTS: usize = 12;

/// Bodies of unit inertia, every contact with random rows on two of them and a friction of 4: far from any convex problem.
fn tangle(seed: u32) -> ContactProblem {
    let mut random = Random::new(seed);
    let n = 6 * BODIES;
    let identity: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
    let mass = BlockDiagonal::from_dense(n, &identity).expect("definite");
    let free_velocity = (0..n).map(|_| random.between(-1.0, 1.0)).collect();
    let mut problem = ContactProblem::new(mass, free_velocity, 1e-2).expect("numbers");
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    for c in 0..CONTACTS {
        let (one, other) = (c % BODIES, (c + 1 + c / BODIES) % BODIES);
        let columns = [one.min(other), one.max(other)].into_iter().flat_map(|body| 6 * body..6 * body + 6);
        let entry = |k: usize| (k as u32, std::array::from_fn(|_| random.between(-1.0, 1.0)));
        let row: Vec<(u32, [f64; 3])> = columns.map(entry).collect();
        problem.push_contact(row, 0.0, 4.0, &polygon);
    }
    problem
}

/// Where Newton's steps to smaller products come to an end because the path turns back, a path around its folds still arrives as often as not
/// although the associated law that it begins with may have no solution here, and all laws hold there.
#[test]
fn paths_arrive_around_their_folds() {
    let (mut folded, mut arrived) = (0, 0);
    for seed in 0..300 {
        on_ground_of(&tangle(seed), |ground| {
            let mut interior = InteriorPoint::default();
            interior.begin(ground);
            let fold = interior.go_on(ground).expect("regular systems");
            if fold <= 1e-6 {
                return;
            }
            folded += 1;
            let scale = ground.map.velocity_scale;
            interior.come_along_path(ground, &mut PathSteps::default());
            let (product, missing) = interior.find_residuals(ground);
            let holds = interior.share == 1.0 && product < 2e-9 * scale * scale && missing < 1e-8 * scale;
            arrived += u32::from(holds);
        });
    }
    assert!(folded >= 20 && 2 * arrived >= folded, "{arrived} of {folded}");
}

/// The products of all pairs are the same along a series, with an error that falls with the ninth power of the length.
#[test]
fn series_continue_the_path() {
    let compared = (0..20).filter(|seed| on_ground_of(&tangle(*seed), |ground| continues_path(ground, *seed))).count();
    assert!(compared >= 5, "{compared}");
}

/// Compares the products at two lengths of a series; `false` where the iterations to the path did not arrive.
fn continues_path(ground: &mut Ground, seed: u32) -> bool {
    let (mut interior, mut path) = (InteriorPoint::default(), PathSteps::default());
    interior.begin(ground);
    let square = ground.map.velocity_scale.powi(2);
    // To a point of Coulomb's path with the first product, from where every step is as small as it is asked to be.
    let parameter = Parameter::Product { target: 0.0, most: square };
    for _ in 0..60 {
        interior.look_around(ground, parameter, square, &mut path).expect("a regular system");
        let part = interior_part(&path.correction);
        path.step.set(part, &path.correction);
        interior.take_step(ground, &path, part, (parameter, square));
    }
    let mut errors = Vec::new();
    interior.look_around(ground, parameter, square, &mut path).expect("a regular system");
    if path.correction.relative.iter().any(|x| x.abs() > 1e-9) {
        return false;
    }
    let size = inner(&path.tangent.relative, &path.tangent.relative).sqrt();
    let largest = path.tangent.relative.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    path.direction = path.tangent.relative.iter().map(|t| -t / size).collect();
    let ahead = Ahead { along: -1.0 / size, length: size / largest, correction: 0.0 };
    let PathSteps { correction, tangent, direction, series, step, .. } = &mut path;
    series.find(&mut interior, ground, parameter, (direction, tangent, correction), ahead);
    for part in [0.2, 0.1] {
        series.sum(part * ahead.length, step);
        step.give(&mut interior);
        let product = square * (1.0 + step.parameter);
        let lack = |x: f64, y: f64, g: f64| (x * y * g / product - 1.0).abs();
        let mut worst = 0.0_f64;
        for (unit, g) in interior.units.iter().zip(&ground.task.island.scale) {
            let [impulse, slack] = [unit.impulse[0] + unit.impulse_rate[0], unit.slack + unit.slack_rate];
            worst = worst.max(lack(impulse, slack, *g));
            for edge in &interior.edges[unit.edges.0..unit.edges.1] {
                let distance = edge.distance + edge.distance_rate;
                worst = worst.max(lack(distance, edge.multiplier + edge.multiplier_rate, *g));
            }
        }
        errors.push(worst);
    }
    assert!(errors[0] < 1e-3, "{seed}: {errors:?}");
    // Of the ninth order, but for rounding.
    assert!(errors[1] < errors[0] / 100.0 + 1e-10, "{seed}: {errors:?}");
    true
}

/// The part of a step that halves no number.
fn interior_part(step: &Rates) -> f64 {
    let most = step.relative.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    (0.5 / most).min(1.0)
}
