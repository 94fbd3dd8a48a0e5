//! Contact frames.

use signorini_contact::ContactFrame;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_testkit::Random;

/// Right-handed and orthonormal; the first tangent is the most along X that is square to the normal, or along Y near X.
#[test]
fn the_first_tangent_is_the_projection_of_x_or_near_x_of_y() {
    let mut random = Random::new(1);
    let drawn = (0..500).map(|_| random.unit_vector()).collect::<Vec<DVec3>>();
    for normal in drawn.into_iter().chain([DVec3::X, -DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z]) {
        let frame = ContactFrame::from_normal(normal);
        let axes = DMat3::from_cols(frame.normal, frame.tangent_1, frame.tangent_2);
        assert!(
            (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-14),
            "{normal}"
        );
        assert!(axes.determinant() > 0.0 && frame.normal == normal);
        let near_x = normal.angle_between(DVec3::X).min(normal.angle_between(-DVec3::X)) < 0.9_f64.acos();
        let reference = if near_x { DVec3::Y } else { DVec3::X };
        assert!(frame.tangent_2.dot(reference).abs() < 1e-14 && frame.tangent_1.dot(reference) > 0.0, "{normal}");
        assert!((frame.to_world([0.5, -2.0, 3.0]) - axes * DVec3::new(0.5, -2.0, 3.0)).length() < 1e-14);
    }
}
