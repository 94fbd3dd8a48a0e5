//! How far impulses and a velocity are from the laws.

use signorini_contact::projection::Cones;
use signorini_contact::scales::raise;

/// What residuals mean, all relative to the velocity scale: every such number of the solver is here.
pub(crate) struct Tuning {
    /// The velocity is refined where its error exceeds this: bodies at rest must not creep ...
    pub exact: f64,
    /// ... or where that times the largest impulse, also relative, exceeds this: the dissipation law multiplies the two.
    pub exact_work: f64,
    /// Below this a change may be rounding.
    pub noise: f64,
    /// Above this an iterate is far from its modes: no choice among velocities mends it, and a large island has another start. Below it
    /// a large island lacks a few modes, and has a second look first.
    pub far: f64,
    /// An iteration that leaves more than this part of a residual is slow.
    pub slow: f64,
    /// What is tried again has to leave less than this part of what there was.
    pub less: f64,
    /// Rounding adds up to so many times what it usually is, or what is asked for, where islands are large or impulses are.
    pub rounded: f64,
    /// Terms that cancel to this part of their sizes have the sum zero.
    pub cancelled: f64,
}

/// Chosen by: `random_steps --seeds 0..6000`, `sim S4_pile100` and `contact_lcp --seeds 73..76 --directions 4,8 --no-growth --no-shared`,
/// 23 November 2026.
pub(crate) const RESIDUALS: Tuning = Tuning {
    exact: 2e-13,
    exact_work: 1e-10,
    noise: 1e-11,
    far: 1e-4,
    slow: 0.1,
    less: 0.5,
    rounded: 20.0,
    cancelled: 1e-9,
};

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
    residual <= RESIDUALS.exact && residual * largest_impulse <= RESIDUALS.exact_work
}
