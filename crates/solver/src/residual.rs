//! How far impulses and a velocity are from the laws.

use signorini_contact::projection::Cones;
use signorini_contact::scales::raise;

/// The velocity is refined where its error, relative to the data, exceeds this: bodies at rest must not creep ...
const REFINE: f64 = 2e-13;
/// ... or where that times the largest impulse, also relative, exceeds this.
pub(crate) const REFINE_LARGE: f64 = 1e-10;

/// Distance from the laws of one contact in velocity units: `g |λ − P(λ − u/g)|` for the projection of the cone, and the
/// natural map of the normal pair.
pub(crate) fn law_residual(cones: &Cones, i: usize, p: [f64; 3], u: [f64; 3], g: f64) -> f64 {
    let mut residual = (g * p[0]).min(u[0]).abs();
    let q = if p[0] <= 0.0 {
        [0.0; 3]
    } else {
        let y = [p[0], p[1] - u[1] / g, p[2] - u[2] / g];
        cones.project(i, cones.mode_at(i, y), y)
    };
    raise(&mut residual, g * (p[1] - q[1]).abs());
    raise(&mut residual, g * (p[2] - q[2]).abs());
    residual
}

/// Whether the velocity that impulses give needs no refinement: the residual of the laws is rounding, and the dissipation law, which
/// multiplies an error of the velocity by the impulse, does not see it.
pub(crate) fn is_exact(residual: f64, largest_impulse: f64) -> bool {
    residual <= REFINE && residual * largest_impulse <= REFINE_LARGE
}
