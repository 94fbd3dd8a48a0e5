//! The laws of a frictional problem in impulse space, from its polygonal LCP alone.

use signorini_complementarity::Lcp;

use crate::Certificate;
use crate::problem_file::FrictionalProblem;

impl FrictionalProblem {
    /// Certifies a claimed `z = (λ_N, α, β)` (formulation §8). The problem has no velocity of its own: the velocity is
    /// computed from the impulses, and the momentum balance holds by definition.
    ///
    /// - `lcp`: of [`polygonal_lcp`](Self::polygonal_lcp)
    /// - `z`: `[lcp.len()]`; of another length every residual is infinite
    pub fn certify(&self, lcp: &Lcp, z: &[f64]) -> Certificate {
        let nc = self.friction.len();
        if z.len() != lcp.len() || z.len() < 2 * nc || z.iter().any(|x| !x.is_finite()) {
            return Certificate::everything_violated();
        }
        let natural_map = lcp.residual(z).value;
        let scale = lcp.b().iter().fold(0.0, |s: f64, b| s.max(b.abs()));
        if nc == 0 || scale == 0.0 {
            return Certificate { natural_map, ..Certificate::default() };
        }
        let (w, g, m) = (lcp.w(z), lcp.scaling().z()[0], z.len() / nc - 2);
        let mut raw = Certificate::default();
        for i in 0..nc {
            let (lambda, beta) = (z[i], z[nc + m * nc + i]);
            let rows = nc + m * i..nc + m * (i + 1);
            let alpha = &z[rows.clone()];
            let bound = self.friction[i] * lambda;
            raw.signorini = raw.signorini.max((g * lambda).min(w[i]).abs());
            raw.friction = raw.friction.max(alpha.iter().sum::<f64>() - bound);
            raw.friction = alpha.iter().fold(raw.friction, |worst, a| worst.max(-a));
            // The speeds along the directions are the rows of α without β.
            let speeds = w[rows].iter().map(|w| w - beta);
            let power: f64 = alpha.iter().zip(speeds.clone()).map(|(a, c)| a * c).sum();
            let fastest = speeds.fold(f64::MIN, |worst, c| worst.max(-c));
            // As in the certificate of a problem with velocities: one factor of the scale is `max(s_v, g r)`.
            raw.dissipation = raw.dissipation.max((power + bound * fastest) * scale / scale.max(g * bound));
        }
        raw = raw.relative_to(scale, g);
        Certificate { natural_map, ..raw }
    }
}
