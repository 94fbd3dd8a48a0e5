//! Problems in impulse space against the same problems with velocities: `u = W r + q` with `W = J M⁻¹ Jᵀ`.

use signorini_complementarity::Matrix;
use signorini_contact::problem_file::FrictionalProblem;
use signorini_contact::{
    Certificate, ConeSolution, ContactProblem, ContactSolution, FrictionPolygon, certify, certify_cone,
};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::Random;

use crate::written::{Kind, NV, Pushed, Rows, dot, numbers, problem};

/// The contacts of a random problem with four directions along the tangents, or two along the first.
fn contacts_alone(random: &mut Random, dimension: usize) -> ContactProblem {
    let whole = problem(random, Kind::Plain);
    let mass = BlockDiagonal::from_dense(NV, &whole.mass.to_dense()).expect("symmetric");
    let mut out = ContactProblem::new(mass, whole.free_velocity.clone(), whole.timestep).expect("positive definite");
    let polygon = FrictionPolygon::regular(2 * (dimension - 1), 0.0).expect("even");
    for i in 0..whole.contact_count() {
        let (columns, entries) = whole.jacobian.group(i);
        let own =
            columns.iter().copied().zip(entries.iter().map(|e| if dimension == 2 { [e[0], e[1], 0.0] } else { *e }));
        out.push_contact(own, whole.gap[i], whole.friction[i], &polygon);
    }
    out
}

fn in_impulse_space(rows: &Rows, dimension: usize) -> FrictionalProblem {
    let tangents = |i: usize| rows.tangents[i].into_iter().take(dimension - 1);
    let all: Vec<[f64; NV]> =
        (0..rows.normals.len()).flat_map(|i| std::iter::once(rows.normals[i]).chain(tangents(i))).collect();
    let free = &rows.problem.free_velocity;
    let velocity =
        |r: usize| if r.is_multiple_of(dimension) { rows.opening(r / dimension, free) } else { dot(&all[r], free) };
    FrictionalProblem {
        delassus: Matrix::from_fn(all.len(), all.len(), |r, c| dot(&all[r], &rows.inverse.apply(&all[c]))),
        free_velocity: (0..all.len()).map(velocity).collect(),
        friction: rows.problem.friction.clone(),
        dimension,
    }
}

fn assert_same(found: &Certificate, wanted: &Certificate, name: &str) {
    for ((residual, found), (_, wanted)) in found.list().into_iter().zip(wanted.list()) {
        let near = (found - wanted).abs() <= 1e-9 * wanted.max(0.01);
        assert!(near, "{name}, {residual}: {found:e}, with velocities {wanted:e}");
    }
}

#[test]
fn polygons_are_judged_in_impulse_space_as_with_velocities() {
    for seed in 0..200 {
        let (mut random, dimension) = (Random::new(seed), 2 + seed as usize % 2);
        let problem = contacts_alone(&mut random, dimension);
        let (rows, nc, m) = (Rows::of(&problem), problem.contact_count(), problem.direction_count());
        let size = random.choice(&[0.1, 3.0, 1e4]);
        let mut some = |count: usize| (0..count).map(|_| random.between(-0.1 * size, size)).collect::<Vec<f64>>();
        let mut claimed = ContactSolution::default();
        (claimed.lambda_n, claimed.alpha, claimed.beta) = (some(nc), some(m), some(nc));
        let tangential = |i: usize| {
            let own = rows.directions[i].iter().zip(&claimed.alpha[problem.direction_offsets[i]..]);
            own.fold([0.0; 2], |t, (d, a)| [t[0] + d[0] * a, t[1] + d[1] * a])
        };
        let tangential: Vec<[f64; 2]> = (0..nc).map(tangential).collect();
        claimed.velocity = Pushed::by(&rows, &claimed.lambda_n, &[], &tangential).velocity;
        let other = in_impulse_space(&rows, dimension);
        let lcp = other.polygonal_lcp(4).expect("valid data");
        let z = [&claimed.lambda_n[..], &claimed.alpha, &claimed.beta].concat();
        let name = format!("seed {seed}, {dimension} dimensions");
        assert_same(&other.certify(&lcp, &z), &certify(&problem, &claimed), &name);
    }
}

#[test]
fn cones_are_judged_in_impulse_space_as_with_velocities() {
    for seed in 0..200 {
        let (mut random, dimension) = (Random::new(seed), 2 + seed as usize % 2);
        let problem = contacts_alone(&mut random, dimension);
        let rows = Rows::of(&problem);
        let size = random.choice(&[0.1, 3.0, 1e4]);
        let mut claimed = ConeSolution::default();
        for _ in 0..problem.contact_count() {
            let [t_1, t_2] = numbers(&mut random, size);
            let in_plane = if dimension == 2 { 0.0 } else { t_2 };
            claimed.impulse.push([random.between(-0.1 * size, size), t_1, in_plane]);
        }
        let normal: Vec<f64> = claimed.impulse.iter().map(|p| p[0]).collect();
        let tangential: Vec<[f64; 2]> = claimed.impulse.iter().map(|p| [p[1], p[2]]).collect();
        claimed.velocity = Pushed::by(&rows, &normal, &[], &tangential).velocity;
        let found = in_impulse_space(&rows, dimension).certify_cone(&claimed.impulse);
        assert_same(&found, &certify_cone(&problem, &claimed), &format!("seed {seed}, {dimension} dimensions"));
    }
}

/// Without velocities only rest is a solution; without the right number of numbers there is none.
#[test]
fn still_problems_and_wrong_sizes_are_told_apart() {
    let mut random = Random::new(3);
    let problem = contacts_alone(&mut random, 3);
    let mut still = in_impulse_space(&Rows::of(&problem), 3);
    still.free_velocity.fill(0.0);
    let lcp = still.polygonal_lcp(4).expect("valid data");
    let mut z = vec![0.0; lcp.len()];
    assert_eq!(still.certify(&lcp, &z).worst(), 0.0);
    assert_eq!(still.certify(&lcp, &z[1..]), Certificate::everything_violated());
    z[1] = f64::NAN;
    assert_eq!(still.certify(&lcp, &z), Certificate::everything_violated());
    let mut impulse = vec![[0.0; 3]; 3];
    assert_eq!(still.certify_cone(&impulse).worst(), 0.0);
    impulse[2][0] = 1e-9;
    assert_eq!(still.certify_cone(&impulse).worst(), f64::INFINITY);
    let moving = in_impulse_space(&Rows::of(&problem), 3);
    assert!(moving.certify_cone(&impulse).worst().is_finite());
    assert_eq!(moving.certify_cone(&impulse[1..]), Certificate::everything_violated());
    impulse[2][0] = f64::NAN;
    assert_eq!(moving.certify_cone(&impulse), Certificate::everything_violated());
}
