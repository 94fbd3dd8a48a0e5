//! Section 8 of the formulation, written down a second time: every residual of arbitrary claims, from dense matrices, with its denominator.

use signorini_contact::certificate::{Scratch, certify_afresh};
use signorini_contact::{Certificate, ContactProblem, ContactSolution, LackingRow, certify, residual_spread};
use signorini_testkit::{Random, particle};

use crate::written::{Kind, Pushed, Rows, along, claim, problem};

/// A problem, what is claimed of it, and what both make.
struct Claimed<'a> {
    rows: Rows<'a>,
    solution: &'a ContactSolution,
    pushed: Pushed,
    /// Multipliers of the directions, and β of each friction, of contacts first.
    alpha: Vec<&'a [f64]>,
    beta: Vec<f64>,
    bounds: Vec<f64>,
    g: f64,
    s_v: f64,
}

impl<'a> Claimed<'a> {
    fn of(p: &'a ContactProblem, s: &'a ContactSolution) -> Self {
        let rows = Rows::of(p);
        let slices =
            |all: &'a [f64], offsets: &[usize]| offsets.windows(2).map(|w| &all[w[0]..w[1]]).collect::<Vec<_>>();
        let of_groups = slices(&s.group_alpha, &p.friction_groups.direction_offsets);
        let alpha = [slices(&s.alpha, &p.direction_offsets), of_groups].concat();
        let sum = |unit: usize, r: usize| rows.directions[unit].iter().zip(alpha[unit]).map(|(d, a)| d[r] * a).sum();
        let tangential: Vec<[f64; 2]> = (0..alpha.len()).map(|unit| [sum(unit, 0), sum(unit, 1)]).collect();
        let pushed = Pushed::by(&rows, &s.lambda_n, &s.bilateral, &tangential);
        let fastest = |unit: usize, c| rows.directions[unit].iter().map(|d| along(d, c).abs()).fold(0.0, f64::max);
        let s_v = rows.fastest(fastest).max(1e-6 * rows.terms());
        let (g, bounds) = (rows.delassus(), rows.bounds(&s.lambda_n));
        let beta = [&s.beta[..], &s.group_beta].concat();
        Self { rows, solution: s, pushed, alpha, beta, bounds, g, s_v }
    }

    /// What friction `unit` lacks of the natural map, m/s.
    fn friction_lacks(&self, unit: usize) -> f64 {
        let (computed, alpha) = (self.rows.slip(unit, &self.pushed.velocity), self.alpha[unit]);
        let of_direction = |(d, a): (&[f64; 2], &f64)| (self.g * a).min(along(d, computed) + self.beta[unit]).abs();
        let left = self.g * (self.bounds[unit] - alpha.iter().sum::<f64>());
        let of_bound = self.beta[unit].min(left).abs();
        self.rows.directions[unit].iter().zip(alpha).map(of_direction).fold(of_bound, f64::max)
    }

    /// What every row lacks of the natural map, relative to the velocity scale.
    fn natural_map(&self) -> Vec<(LackingRow, f64)> {
        let nc = self.rows.normals.len();
        let of_contact = |i: usize| {
            let normal = (self.g * self.solution.lambda_n[i]).min(self.rows.opening(i, &self.pushed.velocity)).abs();
            (LackingRow::Contact(i), normal.max(self.friction_lacks(i)) / self.s_v)
        };
        let of_group = |j: usize| (LackingRow::FrictionGroup(j), self.friction_lacks(nc + j) / self.s_v);
        let of_row = |k: usize| (LackingRow::Bilateral(k), self.rows.drift(k, &self.pushed.velocity).abs() / self.s_v);
        let groups = 0..self.rows.tangents.len() - nc;
        let contacts_and_groups = (0..nc).map(of_contact).chain(groups.map(of_group));
        contacts_and_groups.chain((0..self.rows.bilateral.len()).map(of_row)).collect()
    }

    /// The residuals as section 8 has them.
    fn certificate(&self) -> Certificate {
        let (g, s_v, v) = (self.g, self.s_v, &self.solution.velocity[..]);
        let mut c = Certificate::default();
        c.momentum = self.pushed.momentum(&self.rows, v, s_v);
        c.natural_map = self.natural_map().iter().fold(0.0, |worst, (_, lacks)| worst.max(*lacks));
        let signorini = |i: usize| (g * self.solution.lambda_n[i]).min(self.rows.opening(i, v)).abs() / s_v;
        c.signorini = (0..self.rows.normals.len()).map(signorini).fold(0.0, f64::max);
        c.bilateral = (0..self.rows.bilateral.len()).map(|k| self.rows.drift(k, v).abs() / s_v).fold(0.0, f64::max);
        for (unit, alpha) in self.alpha.iter().enumerate() {
            let (claimed, bound) = (self.rows.slip(unit, v), self.bounds[unit]);
            let rates: Vec<f64> = self.rows.directions[unit].iter().map(|d| along(d, claimed)).collect();
            let beyond = alpha.iter().sum::<f64>() - bound;
            c.friction = alpha.iter().fold(beyond, |worst, a| worst.max(-a)).max(c.friction * s_v / g) * g / s_v;
            if !rates.is_empty() {
                let power: f64 = alpha.iter().zip(&rates).map(|(a, rate)| a * rate).sum();
                let most = rates.iter().fold(f64::NEG_INFINITY, |most, rate| most.max(-rate));
                c.dissipation = c.dissipation.max((power + bound * most) * g / (s_v * s_v.max(g * bound)));
            }
        }
        c
    }

    /// The largest distance of the claimed velocity from that of the impulses along a normal, a bilateral row, or any tangent along which
    /// there is friction.
    fn farthest(&self) -> f64 {
        let apart: Vec<f64> = self.solution.velocity.iter().zip(&self.pushed.velocity).map(|(a, b)| a - b).collect();
        let along_row = |row: &[f64; 6]| crate::written::dot(row, &apart).abs();
        let frictional = (0..self.alpha.len()).filter(|&unit| !self.rows.directions[unit].is_empty());
        let tangential = frictional.map(|unit| {
            let [a, b] = self.rows.tangents[unit].map(|row| along_row(&row));
            a.hypot(b)
        });
        let straight = self.rows.normals.iter().chain(&self.rows.bilateral).map(along_row);
        straight.chain(tangential).fold(0.0, f64::max) / self.s_v
    }
}

const KINDS: [Kind; 5] = [Kind::Plain, Kind::Strong, Kind::Together, Kind::Bystander, Kind::Light];

/// A problem of the kind whose turn it is, and a claim about it.
fn drawn(seed: u64) -> (Kind, f64, ContactProblem, ContactSolution) {
    let mut random = Random::new(seed);
    let kind = KINDS[seed as usize % KINDS.len()];
    let problem = problem(&mut random, kind);
    let size = if kind == Kind::Strong { 1e6 } else { 3.0 };
    let claimed = claim(&mut random, &problem, size);
    (kind, size, problem, claimed)
}

/// Differences of numbers of the size 1e9 have seven digits left.
fn rounding(kind: Kind, wanted: f64) -> f64 {
    (if kind == Kind::Together { 1e-5 } else { 1e-9 }) * wanted.max(1e-3)
}

#[test]
fn the_certificate_is_that_of_section_8() {
    let (mut strong, mut floors) = (0, [0; 2]);
    for seed in 0..500 {
        let (kind, size, problem, claimed) = drawn(seed);
        let (found, wanted) = (certify(&problem, &claimed), Claimed::of(&problem, &claimed).certificate());
        let pairs = [
            (found.momentum, wanted.momentum),
            (found.natural_map, wanted.natural_map),
            (found.signorini, wanted.signorini),
            (found.friction, wanted.friction),
            (found.dissipation, wanted.dissipation),
            (found.bilateral, wanted.bilateral),
        ];
        for (k, (found, wanted)) in pairs.into_iter().enumerate() {
            assert!(
                (found - wanted).abs() <= rounding(kind, wanted),
                "{kind:?}, seed {seed}, residual {k}: {found:e}, section 8 says {wanted:e}"
            );
        }
        strong += usize::from(problem.delassus_scale() * size > problem.velocity_scale());
        floors[0] += usize::from(kind == Kind::Together && problem.velocity_scale() > 30.0);
        floors[1] += usize::from(kind == Kind::Bystander && problem.velocity_scale() < 100.0);
    }
    assert!(strong >= 100 && floors == [100, 100], "the scales' special cases were not met: {strong}, {floors:?}");
}

#[test]
fn what_every_row_lacks_is_in_the_spread() {
    let mut worst_rows = [0; 3];
    for seed in 0..500 {
        let (kind, _, problem, mut claimed) = drawn(seed);
        if seed % 4 == 0 {
            // Little of all but the impulses of bilateral rows, so that these lack most.
            let ContactSolution { lambda_n, alpha, beta, group_alpha, group_beta, .. } = &mut claimed;
            [lambda_n, alpha, beta, group_alpha, group_beta].into_iter().flatten().for_each(|x| *x *= 1e-3);
        }
        let lacking = Claimed::of(&problem, &claimed).natural_map();
        let found = residual_spread(&problem, &claimed).expect("rows and numbers");
        let (worst_row, worst) = *lacking.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("rows");
        let rms = (lacking.iter().map(|(_, x)| x * x).sum::<f64>() / lacking.len() as f64).sqrt();
        assert_eq!(found.worst_row, worst_row, "{kind:?}, seed {seed}");
        assert!((found.worst - worst).abs() <= rounding(kind, worst), "{kind:?}, seed {seed}");
        assert!((found.rms - rms).abs() <= rounding(kind, rms), "{kind:?}, seed {seed}: {} and {rms}", found.rms);
        worst_rows[match worst_row {
            LackingRow::Contact(_) => 0,
            LackingRow::FrictionGroup(_) => 1,
            LackingRow::Bilateral(_) => 2,
        }] += 1;
    }
    assert!(worst_rows.iter().all(|count| *count >= 20), "{worst_rows:?}");
}

/// What a momentum residual means to the rows: at least the distance along any of them, and by the sum of two tangents not far above.
#[test]
fn the_claimed_velocity_is_as_far_from_that_of_the_impulses_as_the_rows_see() {
    for seed in 0..500 {
        let (kind, _, problem, claimed) = drawn(seed);
        let mut scratch = Scratch::default();
        certify_afresh(&problem, &claimed, &mut scratch);
        let (found, least) = (scratch.carried, Claimed::of(&problem, &claimed).farthest());
        let rounding = rounding(kind, least);
        assert!(
            found >= least - rounding && found <= 2.0_f64.sqrt() * least + rounding,
            "{kind:?}, seed {seed}: {found:e}, farthest {least:e}"
        );
    }
}

/// Without rows, without velocities, or with a claim that is none, nothing is spread.
#[test]
fn what_cannot_be_judged_has_no_spread() {
    let (_, _, problem, claimed) = drawn(0);
    let mut short = claimed.clone();
    short.velocity.pop();
    let mut none = claimed.clone();
    none.beta[0] = f64::NAN;
    assert_eq!([residual_spread(&problem, &short), residual_spread(&problem, &none)], [None, None]);
    let still = particle(0.0, [0.0; 2], 0.5, 0.0, 0.25);
    let mut rests = ContactSolution::default();
    (rests.velocity, rests.lambda_n, rests.alpha, rests.beta) = (vec![0.0; 3], vec![0.0], vec![0.0; 4], vec![0.0]);
    assert_eq!(residual_spread(&still, &rests), None);
    let mut free = particle(1.0, [0.0; 2], 0.5, 0.0, 0.25);
    free.clear_contacts();
    let mut flies = ContactSolution::default();
    flies.velocity.clone_from(&free.free_velocity);
    assert_eq!(residual_spread(&free, &flies), None);
}
