//! Nonlinear block Gauss–Seidel: contact after contact solved exactly, with all other impulses held; friction groups by a projected
//! step each.

use super::system::{Block, ContactSystem, Triple};
use signorini_contact::circular::CoulombLaw;

/// Directions tried around the circle for a sliding contact.
const DIRECTIONS: usize = 32;
/// Bisections of a bracket of directions.
const BISECTIONS: usize = 60;

/// The method's memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Sweeps {
    blocks: Vec<Block>,
    u: Vec<Triple>,
}

impl Sweeps {
    /// Sweeps at most `most` times over all contacts, from and into `impulse`, until no velocity changes by more than
    /// `tolerance` times the velocity scale. Returns the number of sweeps.
    pub fn run(
        &mut self,
        system: &mut impl ContactSystem,
        laws: &[CoulombLaw],
        impulse: &mut [Triple],
        most: u32,
        tolerance: f64,
    ) -> u32 {
        self.blocks.clear();
        self.blocks.extend((0..laws.len()).map(|i| system.block(i)));
        system.evaluate(impulse, &mut self.u);
        let small = tolerance * system.velocity_scale();
        for sweep in 1..=most {
            let mut moved = system.sweep_bilateral();
            for i in 0..laws.len() {
                let (w, p, u) = (&self.blocks[i], impulse[i], system.velocity_of(i));
                let wp = multiply(w, p);
                let q = std::array::from_fn(|k| u[k] - wp[k]);
                let next = match laws[i].bound() {
                    None => solve_contact(&laws[i], w, q, p),
                    Some(bound) => {
                        let (r, g) = (bound.at(|contact| impulse[contact][0]), system.scale(i));
                        laws[i].project([r, p[1] - u[1] / g, p[2] - u[2] / g])
                    }
                };
                let change: Triple = std::array::from_fn(|k| next[k] - p[k]);
                if change != [0.0; 3] {
                    system.add_impulse(i, change);
                    impulse[i] = next;
                    moved = change.iter().fold(moved, |a, c| a.max(system.scale(i) * c.abs()));
                }
            }
            if moved <= small {
                return sweep;
            }
        }
        most
    }
}

/// The impulse of one contact with `u = W λ + q`: open, sticking, or sliding in the direction nearest to that of `near`.
/// Where the laws have no solution for this contact alone, one projected step from `near`.
pub(super) fn solve_contact(law: &CoulombLaw, w: &Block, q: Triple, near: Triple) -> Triple {
    if q[0] >= 0.0 {
        return [0.0; 3];
    }
    let mu = law.friction();
    if mu == 0.0 {
        return if w[0][0] > 0.0 { [-q[0] / w[0][0], 0.0, 0.0] } else { near };
    }
    if let Some(d) = law.line() {
        return solve_in_plane(mu, d, w, q).unwrap_or_else(|| projected_step(law, w, q, near));
    }
    if let Some(p) = stick(w, q).filter(|p| p[0] >= 0.0 && p[1].hypot(p[2]) <= mu * p[0]) {
        return p;
    }
    slide(mu, w, q, near).unwrap_or_else(|| projected_step(law, w, q, near))
}

fn multiply(w: &Block, p: Triple) -> Triple {
    std::array::from_fn(|r| w[r][0] * p[0] + w[r][1] * p[1] + w[r][2] * p[2])
}

/// `λ = −W⁻¹ q`, by Cramer's rule.
fn stick(w: &Block, q: Triple) -> Option<Triple> {
    let cross =
        |a: Triple, b: Triple| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: Triple, b: Triple| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let column = |k: usize| [w[0][k], w[1][k], w[2][k]];
    let (a, b, c) = (column(0), column(1), column(2));
    let determinant = dot(a, cross(b, c));
    if determinant.abs() <= 1e-14 * (w[0][0] * w[1][1] * w[2][2]).abs() {
        return None;
    }
    let r = q.map(|x| -x / determinant);
    Some([dot(r, cross(b, c)), dot(a, cross(r, c)), dot(a, cross(b, r))])
}

/// Friction along the line `d` alone: sticking, or sliding to one of two sides.
fn solve_in_plane(mu: f64, d: [f64; 2], w: &Block, q: Triple) -> Option<Triple> {
    let nt = w[0][1] * d[0] + w[0][2] * d[1];
    let tn = w[1][0] * d[0] + w[2][0] * d[1];
    let tt = d[0] * (w[1][1] * d[0] + w[1][2] * d[1]) + d[1] * (w[2][1] * d[0] + w[2][2] * d[1]);
    let qt = q[1] * d[0] + q[2] * d[1];
    let determinant = w[0][0] * tt - nt * tn;
    if determinant > 0.0 {
        let (n, s) = ((nt * qt - tt * q[0]) / determinant, (tn * q[0] - w[0][0] * qt) / determinant);
        if n >= 0.0 && s.abs() <= mu * n {
            return Some([n, s * d[0], s * d[1]]);
        }
    }
    [mu, -mu].into_iter().find_map(|f| {
        let pivot = w[0][0] + f * nt;
        let n = -q[0] / pivot;
        let slip = qt + tn * n + f * tt * n;
        (pivot > 0.0 && slip * f <= 0.0).then_some([n, f * n * d[0], f * n * d[1]])
    })
}

/// A sliding contact whose friction `μ λ_N e(θ)` opposes the slip: a root of `e(θ) × u_T(θ)` with `e · u_T ≤ 0`.
fn slide(mu: f64, w: &Block, q: Triple, near: Triple) -> Option<Triple> {
    // (cross product, scalar product, impulse) at a direction of friction
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let pivot = w[0][0] + mu * (w[0][1] * cos + w[0][2] * sin);
        let n = -q[0] / pivot;
        let p = [n, mu * n * cos, mu * n * sin];
        let u = multiply(w, p);
        let (x, y) = (u[1] + q[1], u[2] + q[2]);
        (pivot > 0.0).then_some((cos * y - sin * x, cos * x + sin * y, p))
    };
    let start = if near[1] == 0.0 && near[2] == 0.0 { (-q[2]).atan2(-q[1]) } else { near[2].atan2(near[1]) };
    let step = std::f64::consts::TAU / DIRECTIONS as f64;
    let mut best: Option<(f64, Triple)> = None;
    for k in 0..DIRECTIONS {
        let (low, high) = (start + step * (k as f64 - 0.5), start + step * (k as f64 + 0.5));
        let (Some(a), Some(b)) = (at(low), at(high)) else { continue };
        if a.0 * b.0 > 0.0 {
            continue;
        }
        let Some((angle, root)) = bisect(&at, low, high, a.0) else { continue };
        let distance = (angle - start).sin().hypot(1.0 - (angle - start).cos());
        if root.1 <= 0.0 && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, root.2));
        }
    }
    best.map(|(_, p)| p)
}

type AtAngle = (f64, f64, Triple);

fn bisect(at: &impl Fn(f64) -> Option<AtAngle>, mut low: f64, mut high: f64, sign: f64) -> Option<(f64, AtAngle)> {
    let mut middle = 0.5 * (low + high);
    let mut value = at(middle)?;
    for _ in 0..BISECTIONS {
        if (value.0 > 0.0) == (sign > 0.0) {
            low = middle;
        } else {
            high = middle;
        }
        middle = 0.5 * (low + high);
        value = at(middle)?;
        if middle <= low || middle >= high {
            break;
        }
    }
    Some((middle, value))
}

/// `P_K(λ − (u + μ‖u_T‖ n)/g)`.
fn projected_step(law: &CoulombLaw, w: &Block, q: Triple, near: Triple) -> Triple {
    let g = w[0][0].max(w[1][1]).max(w[2][2]);
    if g <= 0.0 {
        return near;
    }
    let wp = multiply(w, near);
    let u: Triple = std::array::from_fn(|k| q[k] + wp[k]);
    let t = law.tangential(u);
    let normal = u[0] + law.friction() * t[0].hypot(t[1]);
    law.project_onto_cone([near[0] - normal / g, near[1] - t[0] / g, near[2] - t[1] / g])
}

#[cfg(test)]
mod tests;
