//! The certificate of the circular cone, written down a second time from section 9 of the formulation, and what polygons miss of the cone.

use std::f64::consts::TAU;

use signorini_contact::{Certificate, ConeSolution, ContactProblem, certify_cone};
use signorini_testkit::Random;

use crate::written::{Kind, NV, Pushed, Rows, numbers, problem};

/// Where friction acts: along no tangent, along a line, or in the plane.
fn acting(directions: &[[f64; 2]], t: [f64; 2]) -> [f64; 2] {
    match directions {
        [] => [0.0; 2],
        [d, _] => d.map(|x| x * (d[0] * t[0] + d[1] * t[1])),
        _ => t,
    }
}

fn size(t: [f64; 2]) -> f64 {
    t[0].hypot(t[1])
}

/// The point of the cone `‖y_T‖ ≤ μ y_N` that is nearest to a point: in the half-plane of the point, itself or on the ray of the rim.
fn nearest_in_cone([n, t_1, t_2]: [f64; 3], mu: f64) -> [f64; 3] {
    let t = size([t_1, t_2]);
    if n >= 0.0 && t <= mu * n {
        return [n, t_1, t_2];
    }
    let ray = [1.0, mu].map(|x| x / 1.0_f64.hypot(mu));
    let along = (n * ray[0] + t * ray[1]).max(0.0);
    let outwards = if t > 0.0 { along * ray[1] / t } else { 0.0 };
    [along * ray[0], outwards * t_1, outwards * t_2]
}

fn distance<const N: usize>(z: [f64; N], p: [f64; N]) -> f64 {
    z.iter().zip(p).map(|(z, p)| (z - p) * (z - p)).sum::<f64>().sqrt()
}

/// The residuals as section 9 has them.
fn section_9(p: &ContactProblem, s: &ConeSolution) -> Certificate {
    let (rows, nc) = (Rows::of(p), p.contact_count());
    let lambda_n: Vec<f64> = s.impulse.iter().map(|lambda| lambda[0]).collect();
    let of_contacts = s.impulse.iter().map(|lambda| [lambda[1], lambda[2]]);
    let tangential: Vec<[f64; 2]> = of_contacts.chain(s.group_impulse.iter().copied()).collect();
    let pushed = Pushed::by(&rows, &lambda_n, &s.bilateral, &tangential);
    let (g, bounds) = (rows.delassus(), rows.bounds(&lambda_n));
    let s_v = rows.fastest(|unit, c| size(acting(rows.directions[unit], c)));
    let directions = |unit: usize| if unit < nc && p.friction[unit] == 0.0 { &[] } else { rows.directions[unit] };
    let mut c = Certificate::default();
    c.momentum = pushed.momentum(&rows, &s.velocity, s_v);
    for (i, n) in lambda_n.iter().enumerate() {
        let directions = directions(i);
        let mu = if directions.is_empty() { 0.0 } else { p.friction[i] };
        let (t, slip) = (tangential[i], acting(directions, rows.slip(i, &pushed.velocity)));
        let z = [g * n, g * t[0], g * t[1]];
        let u_n = rows.opening(i, &pushed.velocity) + mu * size(slip);
        let moved = acting(directions, [z[1] - slip[0], z[2] - slip[1]]);
        let nearest = nearest_in_cone([z[0] - u_n, moved[0], moved[1]], mu);
        c.natural_map = c.natural_map.max(distance(z, nearest) / s_v);
        c.signorini = c.signorini.max((g * n).min(rows.opening(i, &s.velocity)).abs() / s_v);
    }
    for unit in nc..tangential.len() {
        let z = tangential[unit].map(|x| g * x);
        let slip = acting(rows.directions[unit], rows.slip(unit, &pushed.velocity));
        let moved = acting(rows.directions[unit], [z[0] - slip[0], z[1] - slip[1]]);
        let within = (g * bounds[unit].max(0.0) / size(moved)).min(1.0);
        c.natural_map = c.natural_map.max(distance(z, moved.map(|x| x * within)) / s_v);
    }
    for (unit, t) in tangential.iter().enumerate() {
        let directions = directions(unit);
        let (own, slip) = (acting(directions, *t), acting(directions, rows.slip(unit, &s.velocity)));
        let bound = if directions.is_empty() { 0.0 } else { bounds[unit] };
        let outside = size([t[0] - own[0], t[1] - own[1]]);
        c.friction = c.friction.max((size(own) - bound).max(outside) * g / s_v);
        let lost = (own[0] * slip[0] + own[1] * slip[1] + bound * size(slip)).abs();
        let factor = if unit < nc { s_v } else { s_v.max(g * bound) };
        c.dissipation = c.dissipation.max(lost * g / (s_v * factor));
    }
    for k in 0..rows.bilateral.len() {
        c.natural_map = c.natural_map.max(rows.drift(k, &pushed.velocity).abs() / s_v);
        c.bilateral = c.bilateral.max(rows.drift(k, &s.velocity).abs() / s_v);
    }
    c
}

/// Numbers that solve nothing; most normal impulses press, and friction is of any size beside its bound.
fn claim(random: &mut Random, problem: &ContactProblem, size: f64) -> ConeSolution {
    let mut claimed = ConeSolution::default();
    let change = numbers::<NV>(random, size);
    claimed.velocity = change.iter().zip(&problem.free_velocity).map(|(d, v)| d + v).collect();
    for _ in 0..problem.contact_count() {
        let friction = random.between(0.0, size);
        let [t_1, t_2] = numbers(random, friction);
        claimed.impulse.push([random.between(-0.2 * size, size), t_1, t_2]);
    }
    claimed.bilateral = numbers::<2>(random, size).to_vec();
    claimed.group_impulse = (0..problem.friction_groups.len()).map(|_| numbers(random, size)).collect();
    claimed
}

/// Makes some sorts of impulses small, so that each sort has a turn at lacking most.
fn keep_some(random: &mut Random, claimed: &mut ConeSolution) {
    let little = 1e-3;
    let factors: [f64; 3] = std::array::from_fn(|_| random.choice(&[1.0, little]));
    claimed.impulse.iter_mut().flatten().for_each(|x| *x *= factors[0]);
    claimed.group_impulse.iter_mut().flatten().for_each(|x| *x *= factors[1]);
    claimed.bilateral.iter_mut().for_each(|x| *x *= factors[2]);
}

#[test]
fn the_certificate_is_that_of_section_9() {
    for seed in 0..1000 {
        let mut random = Random::new(7000 + seed);
        let kind = random.choice(&[Kind::Plain, Kind::Strong, Kind::Bystander, Kind::Light]);
        let mut problem = problem(&mut random, kind);
        if seed % 5 == 0 {
            problem.friction[0] = 0.0;
        }
        let size = if kind == Kind::Strong { 1e8 } else { random.choice(&[0.1, 3.0]) };
        let mut claimed = claim(&mut random, &problem, size);
        keep_some(&mut random, &mut claimed);
        let (found, wanted) = (certify_cone(&problem, &claimed), section_9(&problem, &claimed));
        for ((name, found), (_, wanted)) in found.list().into_iter().zip(wanted.list()) {
            assert!(
                (found - wanted).abs() <= 1e-9 * wanted.max(1e-3),
                "{kind:?}, seed {seed}, {name}: {found:e}, section 9 says {wanted:e}"
            );
        }
    }
}

/// A claim with a number missing or none in any array.
#[test]
fn what_is_no_claim_at_all_violates_everything() {
    let mut random = Random::new(1);
    let problem = problem(&mut random, Kind::Plain);
    let claimed = claim(&mut random, &problem, 1.0);
    assert!(certify_cone(&problem, &claimed).worst().is_finite());
    let changes: [fn(&mut ConeSolution); 8] = [
        |s| s.velocity.truncate(NV - 1),
        |s| s.impulse.truncate(2),
        |s| s.bilateral.push(0.0),
        |s| s.group_impulse.truncate(1),
        |s| s.velocity[1] = f64::NAN,
        |s| s.impulse[2][1] = f64::INFINITY,
        |s| s.bilateral[0] = f64::NAN,
        |s| s.group_impulse[3][0] = f64::NAN,
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut other = claimed.clone();
        change(&mut other);
        let all = certify_cone(&problem, &other).list();
        assert!(all.iter().all(|(_, r)| *r == f64::INFINITY), "change {k}: {all:?}");
    }
}

/// The nearest point written here against points all over the cone.
#[test]
fn no_point_of_the_cone_is_nearer() {
    let mut random = Random::new(2);
    for _ in 0..200 {
        let (mu, y) = (random.between(0.0, 1.5), numbers::<3>(&mut random, 2.0));
        let nearest = nearest_in_cone(y, mu);
        assert!(size([nearest[1], nearest[2]]) <= mu * nearest[0] + 1e-14);
        for _ in 0..100 {
            let (n, r, angle) = (random.between(0.0, 4.0), random.between(0.0, 1.0), random.between(0.0, TAU));
            let other = [n, mu * n * r * angle.cos(), mu * n * r * angle.sin()];
            assert!(distance(y, nearest) <= distance(y, other) + 1e-14);
        }
    }
}
