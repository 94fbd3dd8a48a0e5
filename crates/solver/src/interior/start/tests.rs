use signorini_multibody::BlockDiagonal;

use super::*;
use crate::testing::on_ground_of;
use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_sparse::Random;

const BOXES: usize = 40;

/// Boxes of unit mass on each other, each on the four corners of the face below it, that fall, slide and turn.
fn pile(seed: u32) -> Box<ContactProblem> {
    let mut random = Random::new(seed);
    let n = 6 * BOXES;
    let entry = |k: usize| if k / n != k % n { 0.0 } else { [1.0, 1.0 / 6.0][k % 6 / 3] };
    let mass = BlockDiagonal::from_dense(n, &(0..n * n).map(entry).collect::<Vec<_>>()).expect("definite");
    let free_velocity = (0..n).map(|k| random.between(-0.1, 0.1) - 0.1 * f64::from(u8::from(k % 6 == 2))).collect();
    let mut problem = Box::new(ContactProblem::new(mass, free_velocity, 1e-2).expect("numbers"));
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    for upper in 0..BOXES {
        for (a, b) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let (x, y) = (a + random.between(-0.1, 0.1), b + random.between(-0.1, 0.1));
            let columns = |body: usize, sign: f64, z: f64| {
                // The normal is z, the tangents are x and y; columns are those of the velocity, then of the rotation.
                let rows =
                    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [y, 0.0, -z], [-x, z, 0.0], [0.0, -y, x]];
                rows.into_iter().enumerate().map(move |(k, row)| ((6 * body + k) as u32, row.map(|entry| sign * entry)))
            };
            let lower = upper.checked_sub(1).into_iter().flat_map(|lower| columns(lower, -1.0, 0.5));
            problem.push_contact(lower.chain(columns(upper, 1.0, -0.5)), 0.0, 0.5, &polygon);
        }
    }
    problem
}

/// At the end of the path all equations hold almost to rounding, although contacts slide and others are redundant.
#[test]
fn piles_end_with_accurate_equations() {
    for seed in 0..6 {
        on_ground_of(&pile(seed), |ground| {
            let mut interior = InteriorPoint::default();
            assert!(interior.come_along_path(ground, &mut PathSteps::default()));
            let (product, missing) = interior.find_residuals(ground);
            let scale = ground.map.velocity_scale;
            let momentum = interior.momentum_residual.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            assert!(product < 1e-10 * scale * scale, "{seed}: {product:e}");
            assert!(missing < 1e-8 * scale, "{seed}: {missing:e} of {scale:e}");
            assert!(momentum < 1e-8 * scale, "{seed}: {momentum:e} of {scale:e}");
        });
    }
}

/// A start has the same bits whatever the memory was used for before.
#[test]
fn a_start_knows_nothing_of_the_one_before_it() {
    let problem = pile(1);
    let point = InteriorPoint { share: 0.5, ..InteriorPoint::default() };
    let between = InteriorStart { point, ..InteriorStart::default() };
    let [fresh, used] = [InteriorStart::default(), between].map(|mut interior| {
        on_ground_of(&problem, |ground| {
            assert!(interior.run(ground));
            ground.iterate.impulse.clone()
        })
    });
    assert_eq!(fresh.as_flattened(), used.as_flattened());
}
