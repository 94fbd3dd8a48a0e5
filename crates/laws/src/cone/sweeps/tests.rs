//! One contact's exact solution against Coulomb's laws themselves.

use super::*;

/// A symmetric positive definite Delassus block, and a velocity without the contact's impulse.
fn random_contact(seed: i32) -> (Block, Triple) {
    let noise = |k: i32| (1.7 * f64::from(31 * seed + k) + 0.3).sin() * (0.9 * f64::from(7 * seed + 5 * k)).cos();
    let factor: Block = std::array::from_fn(|r| std::array::from_fn(|c| noise((3 * r + c) as i32)));
    let block = std::array::from_fn(|r| {
        std::array::from_fn(|c| multiply(&factor, factor[c])[r] + if r == c { 0.3 } else { 0.0 })
    });
    (block, std::array::from_fn(|r| 2.0 * noise(9 + r as i32)))
}

/// How far an impulse is from the laws: `0 ≤ λ_N ⟂ u_N ≥ 0`, `‖λ_T‖ ≤ μ λ_N`, and where it slips friction of that size against
/// the slip. `along`: the directions in which there is friction, orthonormal.
fn violation(mu: f64, along: &[[f64; 2]], w: &Block, q: Triple, p: Triple) -> f64 {
    let u: Triple = std::array::from_fn(|r| q[r] + w[r][0] * p[0] + w[r][1] * p[1] + w[r][2] * p[2]);
    let part = |x: Triple, d: &[f64; 2]| x[1] * d[0] + x[2] * d[1];
    let slip: Vec<f64> = along.iter().map(|d| part(u, d)).collect();
    let friction: Vec<f64> = along.iter().map(|d| part(p, d)).collect();
    let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (speed, size) = (length(&slip), length(&friction));
    let outside = (length(&[p[1], p[2]]) - size).abs();
    let work: f64 = slip.iter().zip(&friction).map(|(s, f)| s * f).sum();
    let dissipation = (mu * p[0] * speed + work).abs();
    [p[0].min(u[0]).abs(), (size - mu * p[0]).max(0.0), dissipation, outside].into_iter().fold(0.0, f64::max)
}

#[test]
fn one_contact_alone_obeys_coulombs_laws() {
    let (mut open, mut stick, mut slip) = (0, 0, 0);
    for seed in 0..600 {
        let (w, q) = random_contact(seed);
        let mu = [0.0, 0.3, 0.9][seed as usize % 3];
        let law = CoulombLaw::in_dimension(mu, 3);
        let p = solve_contact(&law, &w, q, [1.0, 0.3 * mu, -0.1 * mu]);
        let directions: &[[f64; 2]] = if mu == 0.0 { &[] } else { &[[1.0, 0.0], [0.0, 1.0]] };
        let residual = violation(mu, directions, &w, q, p);
        assert!(residual < 1e-11, "seed {seed}, μ {mu}: {residual:e} of {p:?}");
        let edge = mu * p[0] - p[1].hypot(p[2]);
        *if p[0] == 0.0 {
            &mut open
        } else if edge > 1e-9 {
            &mut stick
        } else {
            &mut slip
        } += 1;
    }
    assert!(open > 100 && stick > 20 && slip > 100, "{open} open, {stick} stick, {slip} slip");
}

/// The line of a contact in the plane is any of its tangent directions.
#[test]
fn a_contact_in_the_plane_obeys_coulombs_laws_along_its_line() {
    let (mut stick, mut forward, mut backward) = (0, 0, 0);
    for seed in 0..400 {
        let (w, q) = random_contact(seed);
        let (sin, cos) = (0.37 * f64::from(seed)).sin_cos();
        let mut p = None;
        if q[0] < 0.0 {
            p = solve_in_plane(0.4, [cos, sin], &w, q);
        }
        let Some(p) = p else { continue };
        let residual = violation(0.4, &[[cos, sin]], &w, q, p);
        assert!(residual < 1e-11, "seed {seed}: {residual:e} of {p:?}");
        let friction = p[1] * cos + p[2] * sin;
        let edge = 0.4 * p[0] - friction.abs();
        *if edge > 1e-9 {
            &mut stick
        } else if friction > 0.0 {
            &mut forward
        } else {
            &mut backward
        } += 1;
    }
    assert!(stick > 10 && forward > 40 && backward > 40, "{stick} stick, {forward} and {backward} slide");
}
