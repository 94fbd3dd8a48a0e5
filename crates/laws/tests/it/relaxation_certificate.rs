//! The certificate of the relaxed model: of claims at random against dense matrices, and of claims that are none.

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_laws::{ConvexRelaxation, RelaxationCertificate, RelaxationStatus, RelaxedSolution, certify_relaxation};
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_testkit::reference::random_problem;
use signorini_testkit::{Dense, Random, RigidBody, Scene};

/// Row `r` of every contact: its normal velocity, or one of its tangential ones.
fn contact_rows(problem: &ContactProblem, r: usize) -> Dense {
    let mut rows = Dense::zeros(problem.contact_count(), problem.nv());
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        columns.iter().zip(entries).for_each(|(&c, e)| rows[(i, c as usize)] += e[r]);
    }
    rows
}

fn bilateral_rows(problem: &ContactProblem) -> Dense {
    let mut rows = Dense::zeros(problem.bilateral_violation.len(), problem.nv());
    for k in 0..rows.rows {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        columns.iter().zip(entries).for_each(|(&c, e)| rows[(k, c as usize)] += e[0]);
    }
    rows
}

/// The residuals as their definitions have them, with dense matrices; the momentum balance without what impulses may round away.
fn dense_certificate(problem: &ContactProblem, claim: &RelaxedSolution) -> RelaxationCertificate {
    let (nv, nc, mu) = (problem.nv(), problem.contact_count(), &problem.friction);
    // Where no contact moves anything impulses have no measure but their own.
    let g = Some(problem.delassus_scale()).filter(|g| *g > 0.0).unwrap_or(1.0);
    let s = problem.velocity_scale();
    let rows = [0, 1, 2].map(|r| contact_rows(problem, r));
    let bilateral = bilateral_rows(problem);
    let of = |i: usize| problem.direction_offsets[i]..problem.direction_offsets[i + 1];
    let impulse: Vec<[f64; 3]> = (0..nc)
        .map(|i| match of(i).is_empty() {
            true => [claim.impulse[i][0], 0.0, 0.0],
            false => [0, 1, 2].map(|r| {
                let part = |k: usize| if r == 0 { 1.0 } else { mu[i] * problem.directions[k][r - 1] };
                of(i).map(|k| claim.alpha[k] * part(k)).sum()
            }),
        })
        .collect();
    let mut force = bilateral.transposed().apply(&claim.bilateral);
    for (r, row) in rows.iter().enumerate() {
        let own: Vec<f64> = impulse.iter().map(|p| p[r]).collect();
        force.iter_mut().zip(row.transposed().apply(&own)).for_each(|(f, p)| *f += p);
    }
    let mass = Dense::from_fn(nv, nv, |i, j| problem.mass.get(i, j));
    let change = mass.inverse().apply(&force);
    let given: Vec<f64> = (0..nv).map(|k| problem.free_velocity[k] + change[k]).collect();
    let claimed_change: Vec<f64> = (0..nv).map(|k| claim.velocity[k] - problem.free_velocity[k]).collect();
    let balance = mass.apply(&claimed_change);
    let mut expected = RelaxationCertificate::default();
    let raise = |x: &mut f64, by: f64| *x = x.max(by);
    for (index, own) in problem.mass.blocks().iter().map(|block| block.range()).enumerate() {
        let scale = problem.mass.largest_in_block(index) * s;
        own.for_each(|k| raise(&mut expected.momentum, (balance[k] - force[k]).abs() / scale));
    }
    for i in 0..nc {
        for r in 0..3 {
            let at = |v: &[f64]| rows[r].apply(v)[i];
            raise(&mut expected.momentum, (at(&claim.velocity) - at(&given)).abs() / s);
            raise(&mut expected.impulses, g * (impulse[i][r] - claim.impulse[i][r]).abs() / s);
        }
        for v in [&claim.velocity, &given] {
            let c = [0, 1, 2].map(|r| rows[r].apply(v)[i]);
            let rate = c[0] + problem.gap[i] / problem.timestep;
            let relaxed = |d: [f64; 2]| rate + mu[i] * (d[0] * c[1] + d[1] * c[2]);
            let pairs: Vec<(f64, f64)> = match of(i).is_empty() {
                true => vec![(claim.impulse[i][0], rate)],
                false => of(i).map(|k| (claim.alpha[k], relaxed(problem.directions[k]))).collect(),
            };
            pairs.iter().for_each(|(p, w)| raise(&mut expected.natural_map, w.min(g * p).abs() / s));
        }
    }
    for v in [&claim.velocity, &given] {
        for (rate, theta) in bilateral.apply(v).iter().zip(&problem.bilateral_violation) {
            raise(&mut expected.bilateral, (rate + theta / problem.timestep).abs() / s);
        }
    }
    expected
}

/// A claim at random, of sizes such that now one residual is large and now another.
fn random_claim(random: &mut Random, problem: &ContactProblem) -> RelaxedSolution {
    let mut claim = ConvexRelaxation::default().solve(problem, 1e-10);
    let mut spoil = |size: f64, x: &mut f64| *x += size * random.between(-1.0, 1.0);
    for size in [1.0, 0.1] {
        claim.velocity.iter_mut().for_each(|x| spoil(size, x));
        claim.alpha.iter_mut().for_each(|x| spoil(size, x));
        claim.impulse.iter_mut().flatten().for_each(|x| spoil(size, x));
        claim.bilateral.iter_mut().for_each(|x| spoil(size, x));
    }
    claim
}

#[test]
fn residuals_are_those_of_dense_matrices() {
    let mut without_directions = 0;
    for seed in 0..120 {
        let mut random = Random::new(140_000 + seed);
        let (nc, nb) = (1 + random.below(3), random.below(3));
        let mut problem = random_problem(&mut random, nc, nb);
        if seed % 3 == 0 {
            // A contact without directions, the last one.
            let first = problem.direction_offsets[nc - 1];
            problem.directions.truncate(first);
            problem.direction_offsets[nc] = first;
            without_directions += 1;
        }
        let claim = random_claim(&mut random, &problem);
        let (own, expected) = (certify_relaxation(&problem, &claim), dense_certificate(&problem, &claim));
        let agrees = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (1.0 + b);
        assert!(
            agrees(own.momentum, expected.momentum)
                && agrees(own.natural_map, expected.natural_map)
                && agrees(own.impulses, expected.impulses)
                && agrees(own.bilateral, expected.bilateral),
            "seed {seed}: {own:?}, {expected:?}"
        );
        let worst = [own.momentum, own.natural_map, own.impulses, own.bilateral].into_iter().fold(0.0, f64::max);
        assert!(own.worst() == worst && own.holds(worst) && !own.holds(0.999 * worst), "seed {seed}: {own:?}");
    }
    assert_eq!(without_directions, 40);
}

/// Missing and surplus entries, and each entry in turn no number.
#[test]
fn a_claim_that_is_not_complete_has_no_residuals() {
    let mut random = Random::new(7);
    let problem = random_problem(&mut random, 3, 2);
    let solution = ConvexRelaxation::default().solve(&problem, 1e-10);
    let refused = |claim: &RelaxedSolution| {
        let c = certify_relaxation(&problem, claim);
        [c.momentum, c.natural_map, c.impulses, c.bilateral] == [f64::INFINITY; 4] && c.worst() == f64::INFINITY
    };
    assert!(!refused(&solution), "{:?}", solution.certificate);
    let fields: [fn(&mut RelaxedSolution) -> &mut Vec<f64>; 3] =
        [|c| &mut c.velocity, |c| &mut c.alpha, |c| &mut c.bilateral];
    for field in fields {
        for change in [|x: &mut Vec<f64>| x.push(0.0), |x: &mut Vec<f64>| x.truncate(x.len() - 1)] {
            let mut claim = solution.clone();
            change(field(&mut claim));
            assert!(refused(&claim));
        }
        for k in 0..field(&mut solution.clone()).len() {
            let mut claim = solution.clone();
            field(&mut claim)[k] = f64::NAN;
            assert!(refused(&claim), "{k}");
        }
    }
    for change in [|x: &mut Vec<[f64; 3]>| x.push([0.0; 3]), |x: &mut Vec<[f64; 3]>| x.truncate(x.len() - 1)] {
        let mut claim = solution.clone();
        change(&mut claim.impulse);
        assert!(refused(&claim));
    }
    for (i, r) in (0..3).flat_map(|i| (0..3).map(move |r| (i, r))) {
        let mut claim = solution.clone();
        claim.impulse[i][r] = f64::INFINITY;
        assert!(refused(&claim), "{i} {r}");
    }
}

/// Without velocities in the data there is no scale: what rests is a solution, and what moves has no finite residual.
#[test]
fn data_without_velocities_have_one_solution() {
    let mass = BlockDiagonal::from_dense(2, &[2.0, 0.0, 0.0, 2.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).expect("valid data");
    let columns = [(0, [0.0, 1.0, 0.0]), (1, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.5, &FrictionPolygon::regular(2, 0.0).expect("even"));
    let solution = ConvexRelaxation::default().solve(&problem, 1e-10);
    assert_eq!(certify_relaxation(&problem, &solution), RelaxationCertificate::default());
    let mut moving = solution;
    moving.velocity[1] = 1e-3;
    assert_eq!(certify_relaxation(&problem, &moving).momentum, f64::INFINITY);
}

/// A velocity that the impulses do not give is refused also where no contact sees it: that of a body without contacts, and a
/// body's spin about the normal of its only contact.
#[test]
fn a_velocity_that_no_row_sees_is_judged() {
    let mut scene = Scene::default();
    let resting = scene.body(RigidBody::cuboid(DVec3::splat(0.4), 5.0, DVec3::ZERO, DMat3::IDENTITY));
    scene.body(RigidBody::cuboid(DVec3::splat(0.2), 3.0, DVec3::X * 2.0, DMat3::IDENTITY));
    scene.contact(None, Some(resting), DVec3::Z * -0.2, DVec3::Z, 0.0);
    let mut problem = scene.problem(|_| (0.5, FrictionPolygon::regular(6, 0.1).expect("even")));
    problem.free_velocity.iter_mut().enumerate().for_each(|(k, v)| *v = -0.3 + 0.05 * k as f64);
    let solution = ConvexRelaxation::default().solve(&problem, 1e-12);
    assert_eq!(solution.status, RelaxationStatus::Solved, "{:?}", solution.certificate);
    assert_eq!(problem.nv(), 12);
    for k in 0..problem.nv() {
        let mut claimed = solution.clone();
        claimed.velocity[k] += 0.1;
        let certificate = certify_relaxation(&problem, &claimed);
        // The change of momentum over that of the tree's largest inertia at the scale of the data.
        let block = problem.mass.blocks().iter().position(|b| b.range().contains(&k)).expect("in a block");
        let least = 0.1 * problem.mass.get(k, k) / (problem.mass.largest_in_block(block) * problem.velocity_scale());
        assert!(certificate.momentum >= 0.99 * least, "{k}: {certificate:?}");
    }
}
