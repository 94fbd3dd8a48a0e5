//! What the derivative of a contact point is.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Model};

/// Derivatives of a contact point by the motion of body B relative to A, while A stands: three rotations about the world's axes through the
/// point, then three translations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointMotion {
    pub gap: [f64; 6],
    pub normal: [DVec3; 6],
    pub position: [DVec3; 6],
    /// Whether the parts that touch are about to change.
    pub is_tie: bool,
    /// Whether the place may slide and the normal may turn otherwise than told here: faces lie on each other, corners on edges.
    pub is_loose: bool,
}

impl PointMotion {
    /// A point that does not move.
    pub fn of_rest() -> Self {
        let still = [DVec3::ZERO; 6];
        Self { gap: [0.0; 6], normal: still, position: still, is_tie: false, is_loose: false }
    }
}

/// Why a contact point has no derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NoMotion {
    /// Its features change within the smallest differences.
    Changes,
    /// The search for it is not smooth enough for differences.
    Rough,
}

/// Distance of the two surfaces, without the margin of the pair.
pub(super) fn true_gap(model: &Model, point: &ContactPoint) -> f64 {
    point.gap + model.pair_margin(point.geom_a, point.geom_b)
}
