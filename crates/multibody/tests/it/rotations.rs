//! Exponential, logarithm and right Jacobian of rotations, on both sides of where their series begin.

use signorini_multibody::glam::{DMat3, DQuat};
use signorini_multibody::{right_jacobian, rotation_exp, rotation_log, unit_rotation, unit_vector};

use crate::random_model::Random;

/// The exponential's series ends at an angle of 1e-4, the logarithm's at 2e-5: between them one is the inverse of the other's closed form.
#[test]
fn the_logarithm_undoes_the_exponential_at_every_angle() {
    let mut random = Random(31);
    for angle in [1e-9, 1e-6, 1.9e-5, 2.1e-5, 5e-5, 9.9e-5, 1.01e-4, 1e-3, 0.4, 2.0, 3.1] {
        for _ in 0..10 {
            let w = random.direction() * angle;
            let turn = rotation_exp(w);
            for turn in [turn, -turn] {
                assert!(
                    (rotation_log(turn) - w).length() < 4e-15 * angle,
                    "{angle}: {} instead of {w}",
                    rotation_log(turn)
                );
            }
        }
    }
}

/// `J_r(x) = ∫₀¹ exp(−s x) ds`, by Gauss's rule of five points on each of ten parts.
#[test]
fn the_right_jacobian_is_the_mean_of_the_turns_back() {
    let [near, far] =
        [(10.0_f64 / 7.0).sqrt() * 2.0, -(10.0_f64 / 7.0).sqrt() * 2.0].map(|root| (5.0 + root).sqrt() / 3.0);
    let [of_near, of_far] = [-13.0, 13.0].map(|part: f64| (322.0 + part * 70.0_f64.sqrt()) / 900.0);
    let rule = [(0.0, 128.0 / 225.0), (near, of_near), (-near, of_near), (far, of_far), (-far, of_far)];
    let mut random = Random(32);
    for angle in [0.0, 0.02, 0.05, 0.0999, 0.1001, 0.3, 1.0, 3.0] {
        let x = random.direction() * angle;
        let mut mean = DMat3::ZERO;
        for part in 0..10 {
            for (node, weight) in rule {
                let s = (part as f64 + 0.5 + 0.5 * node) / 10.0;
                mean += DMat3::from_quat(DQuat::from_scaled_axis(x * -s)) * (0.5 * weight / 10.0);
            }
        }
        let apart = (right_jacobian(x) - mean).to_cols_array().into_iter().fold(0.0_f64, |most, e| most.max(e.abs()));
        assert!(apart < 2e-15 * (1.0 + angle), "{angle}: {apart:e}");
    }
}

/// What is unit to rounding keeps its bits, though making it unit once more would change them; what is not becomes unit.
#[test]
fn unit_vectors_and_rotations_keep_their_bits() {
    let mut random = Random(33);
    let mut changed = [0; 2];
    for _ in 0..100 {
        let (v, r) = (random.direction(), random.rotation().normalize());
        assert!(unit_vector(v) == v && unit_rotation(r) == r);
        changed[0] += usize::from(v.normalize() != v);
        changed[1] += usize::from(r.normalize() != r);
        let [long, short] = [1.0 + 1e-9, 0.5].map(|by| [unit_vector(v * by).length(), unit_rotation(r * by).length()]);
        assert!(long.into_iter().chain(short).all(|length| (length - 1.0).abs() < 1e-15));
    }
    assert!(changed[0] > 0 && changed[1] > 0, "{changed:?}");
}
