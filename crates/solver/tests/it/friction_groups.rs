//! Friction groups: closed forms, the certificate, and random groups beside contacts and bilateral rows.

use signorini_contact::projection::Mode;
use signorini_contact::{
    Certificate, ContactMode, ContactProblem, FrictionBound, FrictionPolygon, SolveStatus, WarmStart, certify,
};
use signorini_lcp::{Enumeration, Lemke, solve_mixed};
use signorini_multibody::BlockDiagonal;
use signorini_solver::{ContactSolver, solve_as_lcp};
use signorini_testkit::{Dense, Random, largest_difference};

use signorini_testkit::reference::{keep, push_random_groups, random_problem, worst_violation};

fn diagonal(masses: &[f64]) -> BlockDiagonal {
    let n = masses.len();
    let dense = Dense::from_fn(n, n, |i, j| if i == j { masses[i] } else { 0.0 });
    BlockDiagonal::from_dense(n, &dense.data).expect("symmetric")
}

/// One wheel of 2 kg·m² with dry friction `r` that is pulled towards a speed: the impulse is what is missing, or the bound.
#[test]
fn a_servo_holds_its_speed_until_its_limit() {
    for (free, target, bound, wanted, mode) in [
        (1.0, 0.0, 3.0, 0.0, ContactMode::Sticking),
        (2.0, 0.0, 3.0, 0.5, ContactMode::Sliding { k: 1 }),
        (-2.0, 0.0, 3.0, -0.5, ContactMode::Sliding { k: 0 }),
        (1.0, 1.5, 3.0, 1.5, ContactMode::Sticking),
        (1.0, 5.0, 3.0, 2.5, ContactMode::Sliding { k: 0 }),
        (1.0, 5.0, 0.0, 1.0, ContactMode::Open),
    ] {
        let mut problem = ContactProblem::new(diagonal(&[2.0]), vec![free], 0.01).expect("valid data");
        problem.push_friction_row([(0, 1.0)], target, FrictionBound::Impulse(bound));
        let solution = ContactSolver::default().solve(&problem, None);
        assert_eq!(solution.status, SolveStatus::Solved);
        assert!((solution.velocity[0] - wanted).abs() < 1e-14, "{free} {target}: {:?}", solution.velocity);
        assert!((solution.group_impulse[0][0] - 2.0 * (wanted - free)).abs() < 1e-14);
        assert_eq!(solution.group_modes, [mode], "{free} {target}");
    }
}

/// A particle pressed down with 1 N·s whose friction along x is bounded by half of that, in whatever form the bound is written: 0.4 N·s
/// stick and 0.8 N·s slide, for every method.
#[test]
fn modes_of_groups_are_those_of_their_bounds() {
    let (contact, coefficient) = (0, 0.5);
    let of_contact = FrictionBound::Normal { contact, coefficient };
    let shifted = FrictionBound::Shifted { impulse: 0.25, contact, coefficient: 0.25 };
    for (free, sticks) in [(0.4, true), (-0.4, true), (0.8, false), (-0.8, false)] {
        for bound in [FrictionBound::Impulse(0.5), of_contact, shifted] {
            let mut problem = ContactProblem::new(diagonal(&[1.0; 2]), vec![free, -1.0], 0.01).expect("valid data");
            problem.push_contact([(1, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
            problem.push_friction_row([(0, 1.0)], 0.0, bound);
            let structured = ContactSolver::default().solve(&problem, None);
            let by_lcp = solve_as_lcp(&problem, &mut Lemke::default(), 1e-12).expect("finite data");
            for solution in [structured, by_lcp] {
                assert_eq!(solution.status, SolveStatus::Solved);
                let wanted = if sticks { 0.0 } else { free - free.signum() * 0.5 };
                assert!((solution.velocity[0] - wanted).abs() < 1e-12, "{free} {bound:?}: {:?}", solution.velocity);
                let mode = solution.solver_modes[1];
                // The two directions are the ends of a line: between them sticks what has friction to spare.
                assert!(!sticks || matches!(mode, Mode::Edge(_)), "{free} {bound:?}: {mode:?}");
            }
        }
    }
}

/// Two wheels in series behind one motor whose friction exceeds what the other's allows: each law by hand.
#[test]
fn coupled_joints_slip_one_after_the_other() {
    // M = [[2, 1], [1, 1]], v_free = (1, 3): with the second joint sticking the first gets M₁₁ᵉᶠᶠ.
    let mass = BlockDiagonal::from_dense(2, &[2.0, 1.0, 1.0, 1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![1.0, 3.0], 0.01).expect("valid data");
    problem.push_friction_row([(0, 1.0)], 0.0, FrictionBound::Impulse(0.25));
    problem.push_friction_row([(1, 1.0)], 0.0, FrictionBound::Impulse(100.0));
    let solution = ContactSolver::default().solve(&problem, None);
    // momentum p = M v = (5, 4); v₂ = 0 and the first slides: 2 v₁ = 5 − 0.25
    assert!(largest_difference(&solution.velocity, &[4.75 / 2.0, 0.0]) < 1e-14, "{:?}", solution.velocity);
    assert!((solution.group_impulse[1][0] - (4.75 / 2.0 - 4.0)).abs() < 1e-14);
}

/// A disc of 1 kg and 0.5 kg·m² that spins on a floor; its spin is braked by `c λ_N`.
#[test]
fn friction_against_spinning_is_bounded_by_the_normal_impulse() {
    let mut problem = ContactProblem::new(diagonal(&[1.0, 0.5]), vec![-2.0, 3.0], 0.01).expect("valid data");
    problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
    for (coefficient, wanted) in [(0.0, 3.0), (0.1, 3.0 - 0.2 / 0.5), (10.0, 0.0)] {
        let mut problem = problem.clone();
        let bound = FrictionBound::Normal { contact: 0, coefficient };
        problem.push_friction_row([(1, 1.0)], 0.0, bound);
        let solution = ContactSolver::default().solve(&problem, None);
        assert_eq!(solution.status, SolveStatus::Solved);
        assert!(largest_difference(&solution.velocity, &[0.0, wanted]) < 1e-11, "{:?}", solution.velocity);
    }
    // An open contact bounds nothing.
    problem.gap[0] = 1.0;
    problem.push_friction_row([(1, 1.0)], 0.0, FrictionBound::Normal { contact: 0, coefficient: 10.0 });
    let solution = ContactSolver::default().solve(&problem, None);
    assert_eq!((solution.velocity[1], solution.group_modes[0]), (3.0, ContactMode::Open));
}

/// A group in two directions is the friction of a contact: the same solution, with the normal impulse as its bound.
#[test]
fn a_group_bounded_by_a_contact_is_the_friction_of_that_contact() {
    let mut compared = 0;
    for seed in 0..40 {
        let mut random = Random::new(400 + seed);
        let with_tangents = random_problem(&mut random, 1, 0);
        let (columns, entries) = with_tangents.jacobian.group(0);
        let normal: Vec<_> = columns.iter().zip(entries).map(|(&c, e)| (c, [e[0], 0.0, 0.0])).collect();
        let tangents: Vec<_> = columns.iter().zip(entries).map(|(&c, e)| (c, [e[1], e[2]])).collect();
        let polygon = FrictionPolygon::from_directions(with_tangents.directions_of(0).to_vec()).expect("balanced");
        let mut with_group = with_tangents.clone();
        with_group.clear_contacts();
        with_group.push_contact(normal, with_tangents.gap[0], 0.0, &FrictionPolygon::frictionless());
        let bound = FrictionBound::Normal { contact: 0, coefficient: with_tangents.friction[0] };
        with_group.push_friction(tangents, [0.0; 2], bound, &polygon);
        let (a, b) =
            (ContactSolver::default().solve(&with_tangents, None), ContactSolver::default().solve(&with_group, None));
        assert_eq!((&a.status, &b.status), (&SolveStatus::Solved, &SolveStatus::Solved), "seed {seed}");
        assert!(largest_difference(&a.velocity, &b.velocity) < 1e-9, "seed {seed}");
        compared += usize::from(a.lambda_n[0] > 0.0);
    }
    assert!(compared >= 10, "{compared}");
}

/// Random contacts, rows and groups: certified by the crate and by dense matrices; groups with constant bounds alone, a convex
/// problem, have the velocity that enumeration finds.
#[test]
fn random_groups_are_solved_and_certified() {
    let (mut lemke, mut enumeration) = (Lemke::default(), Enumeration::default());
    let (mut solved, mut small) = (0, 0);
    for seed in 0..150 {
        let mut random = Random::new(7000 + seed);
        let (nc, nb) = (random.below(3), random.below(2));
        let mut problem = random_problem(&mut random, nc, nb);
        let nf = 1 + random.below(3);
        push_random_groups(&mut problem, &mut random, nf);
        let solution = ContactSolver::default().solve(&problem, None);
        if solution.status != SolveStatus::Solved {
            keep(&problem, &format!("groups_{seed}"));
        }
        // Bilateral rows may demand what gaps forbid, and moving groups may jam; all else has a solution.
        let promised = nb == 0 && problem.friction_groups.target.iter().all(|u| *u == [0.0; 2]);
        assert!(!promised || solution.status == SolveStatus::Solved, "seed {seed}: {:?}", solution.status);
        if solution.status == SolveStatus::Solved {
            solved += 1;
            assert!(certify(&problem, &solution).holds(1e-9), "seed {seed}");
            let worst = worst_violation(&problem, &solution);
            assert!(worst <= 1e-8, "seed {seed}: {worst:e}");
        }
        let mixed = solve_mixed(&problem.mixed_lcp().expect("finite data"), &mut lemke, None);
        if mixed.status.is_solved() {
            assert_eq!(solution.status, SolveStatus::Solved, "seed {seed}: only the mixed form is solved");
        }
        if nc == 0 && nb == 0 && problem.standard_layout().size <= 12 {
            // Constant bounds alone: a convex problem, one velocity.
            let other = solve_as_lcp(&problem, &mut enumeration, 1e-9).expect("finite data");
            assert_eq!(other.status, SolveStatus::Solved);
            assert!(largest_difference(&other.velocity, &solution.velocity) < 1e-8, "seed {seed}");
            small += 1;
        }
    }
    assert!(solved == 150 && small >= 10, "{solved} solved, {small} enumerated");
}

/// A servo at its limit: v_free = 3, target 1, mass 1, bound 0.5. v⁺ = 2.5, β = 1.5; s_v = 2, g = 1.
#[test]
fn each_law_of_a_group_has_its_residual() {
    let mut problem = ContactProblem::new(diagonal(&[1.0]), vec![3.0], 0.1).expect("valid data");
    problem.push_friction_row([(0, 1.0)], 1.0, FrictionBound::Impulse(0.5));
    let exact = ContactSolver::default().solve(&problem, None);
    assert_eq!((exact.velocity[0], &exact.group_alpha[..], exact.group_beta[0]), (2.5, &[0.0, 0.5][..], 1.5));
    assert_eq!(certify(&problem, &exact), Certificate::default());
    let d = 1e-3;
    let mut beyond = exact.clone();
    beyond.group_alpha[1] += d;
    beyond.velocity[0] -= d;
    let found = certify(&problem, &beyond);
    assert!((found.friction - d / 2.0).abs() < 1e-15 && found.momentum < 1e-15, "{found:?}");
    let mut lazy = exact.clone();
    lazy.group_alpha[1] -= d;
    lazy.velocity[0] += d;
    lazy.group_beta[0] += d;
    let found = certify(&problem, &lazy);
    // It dissipates too little: d of the bound at a slip of 1.5 + d.
    assert!((found.dissipation - d * (1.5 + d) / 4.0).abs() < 1e-15 && found.friction == 0.0, "{found:?}");
    assert!((found.natural_map - d / 2.0).abs() < 1e-15, "{found:?}");
    let mut wrong = exact;
    wrong.group_beta.clear();
    assert_eq!(certify(&problem, &wrong).worst(), f64::INFINITY);
}

#[test]
fn wrong_groups_are_named() {
    let problem = ContactProblem::new(diagonal(&[1.0]), vec![3.0], 0.1).expect("valid data");
    let message = |push: fn(&mut ContactProblem)| {
        let mut problem = problem.clone();
        push(&mut problem);
        problem.check().expect_err("wrong data").to_string()
    };
    let constant = FrictionBound::Impulse(1.0);
    let negative = message(|p| p.push_friction_row([(0, 1.0)], 0.0, FrictionBound::Impulse(-1.0)));
    assert!(negative.contains("bound of a friction group[0] = -1"), "{negative}");
    let contact =
        message(|p| p.push_friction_row([(0, 1.0)], 0.0, FrictionBound::Normal { contact: 0, coefficient: 1.0 }));
    assert!(contact.contains("contact of a friction group[0] = 0"), "{contact}");
    let target = message(|p| p.push_friction_row([(0, 1.0)], f64::NAN, FrictionBound::Impulse(1.0)));
    assert!(target.contains("u_F[0] = NaN"), "{target}");
    let column = message(|p| p.push_friction_row([(4, 1.0)], 0.0, FrictionBound::Impulse(1.0)));
    assert!(column.contains("column 4"), "{column}");
    let mut problem = problem.clone();
    problem.push_friction_row([(0, 1.0)], 0.0, constant);
    problem.friction_groups.directions[1] = [0.0, 1.0];
    let directions = problem.check().expect_err("not balanced").to_string();
    assert!(directions.contains("directions of friction group 0"), "{directions}");
}

/// A joint with dry friction that has stopped, and that no force moves on, beside one that is loaded: the friction of the step before would start it again,
/// by a velocity that is nothing only relative to its own data, which are all zero.
#[test]
fn a_joint_that_nothing_moves_keeps_no_impulse_of_the_step_before() {
    let bound = 2e-4;
    let problem = |free: f64| {
        let mass = BlockDiagonal::from_dense(2, &[0.0135, 0.0, 0.0, 1.0]).unwrap();
        let mut problem = ContactProblem::new(mass, vec![free, -0.04], 0.004).unwrap();
        problem.push_contact([(1, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
        problem.push_friction_row([(0, 1.0)], 0.0, FrictionBound::Impulse(bound));
        problem
    };
    let sliding = ContactSolver::default().solve(&problem(-0.1), None);
    assert!((sliding.group_impulse[0][0] - bound).abs() < 1e-15, "it slides: {:?}", sliding.group_impulse);
    let start = WarmStart::from_solution(&sliding);
    let stopped = ContactSolver::default().solve(&problem(0.0), Some(&start));
    assert_eq!(stopped.status, SolveStatus::Solved);
    assert_eq!((stopped.velocity[0], stopped.group_impulse[0], stopped.report.restarts), (0.0, [0.0; 2], 0));
}
