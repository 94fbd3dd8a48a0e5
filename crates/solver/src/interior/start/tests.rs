use super::*;
use crate::testing::{on_ground_of, pile};

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
