//! The certificate of the relaxed model, computed from the data alone.

use super::{RelaxationCertificate, RelaxedSolution};
use signorini_contact::certificate::certify;
use signorini_contact::{ContactProblem, ContactSolution};

/// Certifies a claimed solution of the relaxed model; missing entries or ones that are not finite make every residual infinite,
/// and so do friction groups, which the relaxed model does not have.
pub fn certify_relaxation(problem: &ContactProblem, solution: &RelaxedSolution) -> RelaxationCertificate {
    if !is_complete(problem, solution) || problem.check_without_groups().is_err() {
        let r = f64::INFINITY;
        return RelaxationCertificate { momentum: r, natural_map: r, impulses: r, bilateral: r };
    }
    let g = match problem.delassus_scale() {
        0.0 => 1.0,
        g => g,
    };
    let mut change = vec![0.0; problem.nv()];
    let mut raw = RelaxationCertificate::default();
    for i in 0..problem.contact_count() {
        let impulse = impulse_of_multipliers(problem, solution, i);
        for r in 0..3 {
            raw.impulses = raw.impulses.max(g * (impulse[r] - solution.impulse[i][r]).abs());
        }
        problem.jacobian.add_transposed(i, impulse, &mut change);
    }
    for (k, &p) in solution.bilateral.iter().enumerate() {
        problem.bilateral_jacobian.add_transposed(k, [p], &mut change);
    }
    problem.mass_factor.solve_in_place(&mut change);
    change.iter_mut().zip(&problem.free_velocity).for_each(|(v, f)| *v += f);
    for i in 0..problem.contact_count() {
        let claimed = problem.contact_velocity(i, &solution.velocity);
        let computed = problem.contact_velocity(i, &change);
        for r in 0..3 {
            raw.momentum = raw.momentum.max((claimed[r] - computed[r]).abs());
        }
        let own = natural_map(problem, solution, i, g, claimed).max(natural_map(problem, solution, i, g, computed));
        raw.natural_map = raw.natural_map.max(own);
    }
    for (k, theta) in problem.bilateral_violation.iter().enumerate() {
        for v in [&solution.velocity, &change] {
            let [rate] = problem.bilateral_jacobian.multiply(k, v);
            raw.bilateral = raw.bilateral.max((rate + theta / problem.timestep).abs());
        }
    }
    let scale = problem.velocity_scale();
    let relative = |r: f64| match (r, scale) {
        (0.0, _) => 0.0,
        (_, 0.0) => f64::INFINITY,
        _ => r / scale,
    };
    RelaxationCertificate {
        momentum: relative(raw.momentum).max(momentum_balance(problem, solution)),
        natural_map: relative(raw.natural_map),
        impulses: relative(raw.impulses),
        bilateral: relative(raw.bilateral),
    }
}

/// The momentum residual of the contact laws, which no relaxation changes: `λ_N = Σ α_k` and `λ_T = D (μ α)`.
fn momentum_balance(problem: &ContactProblem, solution: &RelaxedSolution) -> f64 {
    let mut claimed = ContactSolution::default();
    claimed.prepare(problem);
    claimed.velocity.clone_from(&solution.velocity);
    claimed.bilateral.clone_from(&solution.bilateral);
    for i in 0..problem.contact_count() {
        claimed.lambda_n[i] = impulse_of_multipliers(problem, solution, i)[0];
        for k in problem.direction_offsets[i]..problem.direction_offsets[i + 1] {
            claimed.alpha[k] = problem.friction[i] * solution.alpha[k];
        }
    }
    certify(problem, &claimed).momentum
}

/// Whether a claimed solution has all entries, and all of them are finite.
fn is_complete(problem: &ContactProblem, solution: &RelaxedSolution) -> bool {
    let sizes_fit = solution.velocity.len() == problem.nv()
        && solution.impulse.len() == problem.contact_count()
        && solution.alpha.len() == problem.direction_count()
        && solution.bilateral.len() == problem.bilateral_violation.len();
    let mut numbers = [&solution.velocity, &solution.alpha, &solution.bilateral].into_iter().flatten();
    sizes_fit && numbers.all(|x| x.is_finite()) && solution.impulse.iter().flatten().all(|x| x.is_finite())
}

/// `Σ_k α_k (n + μ d_k)`, or the normal impulse of a contact without directions.
pub(super) fn impulse_of_multipliers(problem: &ContactProblem, solution: &RelaxedSolution, i: usize) -> [f64; 3] {
    let directions = problem.directions_of(i);
    if directions.is_empty() {
        return [solution.impulse[i][0], 0.0, 0.0];
    }
    let alpha = &solution.alpha[problem.direction_offsets[i]..];
    let mut sum = [0.0; 3];
    for (d, a) in directions.iter().zip(alpha) {
        let mu = problem.friction[i];
        sum = [sum[0] + a, sum[1] + mu * a * d[0], sum[2] + mu * a * d[1]];
    }
    sum
}

fn natural_map(problem: &ContactProblem, solution: &RelaxedSolution, i: usize, g: f64, c: [f64; 3]) -> f64 {
    let gap_rate = c[0] + problem.gap[i] / problem.timestep;
    let directions = problem.directions_of(i);
    if directions.is_empty() {
        return (g * solution.impulse[i][0]).min(gap_rate).abs();
    }
    let alpha = &solution.alpha[problem.direction_offsets[i]..];
    let rows = directions.iter().map(|d| gap_rate + problem.friction[i] * (d[0] * c[1] + d[1] * c[2]));
    rows.zip(alpha).map(|(w, a)| (g * a).min(w).abs()).fold(0.0, f64::max)
}
