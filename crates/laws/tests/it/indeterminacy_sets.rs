//! Sets of impulses in closed form: bilateral rows beside contacts, what nothing moves, units, and what a self-stress is.

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus};
use signorini_laws::{ForceDistributions, ImpulseRange, LeastNormOutcome, force_distributions, least_norm_impulses};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, families};

fn solve(problem: &ContactProblem) -> ContactSolution {
    let solution = ContactSolver::default().solve(problem, None);
    assert_eq!(solution.status, SolveStatus::Solved, "{:?}", solution.certificate);
    solution
}

fn is(range: &ImpulseRange, min: f64, max: f64, size: f64) -> bool {
    let same = |a: f64, b: f64| a == b || (a - b).abs() < 1e-9 * size;
    same(range.min, min) && same(range.max, max)
}

/// Self-stresses have no effect, admitted impulses and a largest entry of 1, and move what is said to have no bound along them.
fn assert_self_stresses(problem: &ContactProblem, set: &ForceDistributions) {
    for stress in &set.self_stresses {
        let mut effect = vec![0.0; problem.nv()];
        stress.impulse.iter().enumerate().for_each(|(i, p)| problem.jacobian.add_transposed(i, *p, &mut effect));
        stress.bilateral.iter().enumerate().for_each(|(k, p)| {
            problem.bilateral_jacobian.add_transposed(k, [*p], &mut effect);
        });
        let entries = stress.impulse.iter().flatten().chain(&stress.bilateral);
        let largest = entries.fold(0.0, |l: f64, x| l.max(x.abs()));
        assert!((largest - 1.0).abs() < 1e-12 && effect.iter().all(|x| x.abs() < 1e-9), "{stress:?}");
        for (i, p) in stress.impulse.iter().enumerate() {
            let along = problem.directions_of(i).iter().map(|d| d[0] * p[1] + d[1] * p[2]).fold(0.0, f64::max);
            assert!(along <= problem.friction[i] * p[0] + 1e-12, "{stress:?}");
        }
    }
    let contacts = set.normal.iter().zip(&set.tangential).enumerate();
    let of_contacts = contacts.flat_map(|(i, (n, [a, b]))| [(n, i, 0), (a, i, 1), (b, i, 2)]);
    let rows = set.bilateral.iter().enumerate().map(|(k, range)| (range, k, 3));
    for (range, i, r) in of_contacts.chain(rows) {
        let part = |at: usize| {
            let stress = &set.self_stresses[at];
            if r == 3 { stress.bilateral[i] } else { stress.impulse[i][r] }
        };
        assert_eq!(range.max == f64::INFINITY, range.grows_along.is_some_and(|at| part(at) > 1e-9), "{range:?}");
        assert_eq!(range.min == f64::NEG_INFINITY, range.falls_along.is_some_and(|at| part(at) < -1e-9), "{range:?}");
    }
}

/// Particles that rest on a plane and are held sideways by two rows each: friction may take up to `μ λ_N` off the rows, or put as
/// much on them. `pulls`: the impulses that would move each along the plane.
fn held_particles(mass: f64, velocity: f64, pulls: &[[f64; 2]]) -> ContactProblem {
    let nv = 3 * pulls.len();
    let dense: Vec<f64> = (0..nv * nv).map(|k| if k % (nv + 1) == 0 { mass } else { 0.0 }).collect();
    let free = pulls.iter().flat_map(|[x, y]| [x * velocity, y * velocity, -velocity]).collect();
    let blocks = BlockDiagonal::from_dense(nv, &dense).expect("symmetric");
    let mut problem = ContactProblem::new(blocks, free, 0.01).expect("valid data");
    for k in (0..nv as u32).step_by(3) {
        let columns = [(k, [0.0, 1.0, 0.0]), (k + 1, [0.0, 0.0, 1.0]), (k + 2, [1.0, 0.0, 0.0])];
        problem.push_contact(columns, 0.0, 0.5, &FrictionPolygon::regular(4, 0.0).expect("even"));
    }
    for k in (0..nv as u32).step_by(3) {
        // Rows of other lengths: an impulse of 1 along the second is worth 2 of the first.
        problem.push_bilateral([(k, [1.0])], 0.0);
        problem.push_bilateral([(k + 1, [2.0])], 0.0);
    }
    problem
}

#[test]
fn rows_share_with_the_friction_of_contacts() {
    for (mass, velocity) in [(2.0, 0.1), (3e-7, 0.1), (4e6, 0.1), (2.0, 1e-7)] {
        let pulls = [[3.0, -0.25], [-1.0, 0.125], [0.0, 2.0]];
        let problem = held_particles(mass, velocity, &pulls);
        let set = force_distributions(&problem, &solve(&problem)).expect("a solution");
        let weight = mass * velocity;
        assert_eq!((set.dimension, set.self_stresses.len()), (6, 0), "{mass}");
        for (k, [x, y]) in pulls.iter().enumerate() {
            assert!(is(&set.normal[k], weight, weight, weight), "{mass}: {:?}", set.normal[k]);
            for range in &set.tangential[k] {
                assert!(is(range, -0.5 * weight, 0.5 * weight, weight), "{mass}: {range:?}");
            }
            let rows = [(&set.bilateral[2 * k], -x, 1.0), (&set.bilateral[2 * k + 1], -y, 2.0)];
            for (range, p, length) in rows {
                let ends = [(p - 0.5) * weight / length, (p + 0.5) * weight / length];
                assert!(is(range, ends[0], ends[1], weight), "{mass}: {range:?} is not {ends:?}");
            }
        }
        assert!(set.residual.worst() < 1e-12 && set.discrepancy < 1e-12, "{set:?}");
        assert!(set.linear_programs >= 24 && set.pivots > 0, "two for every range that is no point: {set:?}");
    }
}

/// A row that stands on the plane's side: what the contact presses more, the row pulls.
#[test]
fn rows_against_contacts_have_no_bound() {
    let mut problem = held_particles(2.0, 0.1, &[[0.0, 0.0], [0.0, 0.0]]);
    problem.push_bilateral([(2, [0.5])], 0.0);
    problem.push_bilateral([(5, [-0.25])], 0.0);
    let set = force_distributions(&problem, &solve(&problem)).expect("a solution");
    assert_self_stresses(&problem, &set);
    for i in 0..2 {
        assert!(set.normal[i].min.abs() < 1e-12 && set.normal[i].max == f64::INFINITY, "{set:?}");
        assert!(set.tangential[i].iter().all(|t| t.min == f64::NEG_INFINITY && t.max == f64::INFINITY), "{set:?}");
    }
    assert!(is(&set.bilateral[4], f64::NEG_INFINITY, 0.4, 0.2), "{set:?}");
    assert!(is(&set.bilateral[5], -0.8, f64::INFINITY, 0.2), "{set:?}");
    assert_eq!(set.dimension, 2 * 3);
}

/// What no degree of freedom moves balances itself.
#[test]
fn what_nothing_moves_may_carry_anything() {
    let mut problem = held_particles(2.0, 0.1, &[[1.0, 0.0]]);
    let none: [(u32, [f64; 3]); 0] = [];
    problem.push_contact(none, 0.0, 0.3, &FrictionPolygon::regular(6, 0.2).expect("even"));
    problem.push_contact(none, 0.0, 0.3, &FrictionPolygon::frictionless());
    let none: [(u32, [f64; 1]); 0] = [];
    problem.push_bilateral(none, 0.0);
    problem.push_bilateral(none, 0.0);
    let set = force_distributions(&problem, &solve(&problem)).expect("a solution");
    assert_self_stresses(&problem, &set);
    // Two of the particle's friction, three of one contact and one of the other, one of each row.
    assert_eq!(set.dimension, 2 + 3 + 1 + 2);
    for range in [&set.normal[1], &set.normal[2]] {
        assert_eq!((range.min, range.max), (0.0, f64::INFINITY), "{set:?}");
    }
    for range in set.tangential[1].iter().chain(&set.bilateral[2..4]) {
        assert_eq!((range.min, range.max), (f64::NEG_INFINITY, f64::INFINITY), "{set:?}");
    }
    for range in &set.tangential[2] {
        assert_eq!((range.min, range.max), (0.0, 0.0), "{set:?}");
    }
    assert!(is(&set.normal[0], 0.2, 0.2, 0.2) && set.normal[0].grows_along.is_none(), "{set:?}");
}

/// Kilograms and metres per second in other units: the same set in these units.
#[test]
fn sets_do_not_depend_on_units() {
    let (mut varying, mut infinite) = (0, 0);
    for seed in 0..40 {
        let mut random = Random::new(150_000 + seed);
        let motion = random.choice(&[Motion::Rest, Motion::Slide]);
        let parameters = Parameters { gap: Gap::Zero, motion, friction: 0.4, directions: 4, ..Parameters::default() };
        let problem = match seed % 4 {
            0 => families::squeeze(&mut random, &parameters, 2),
            k => [Family::Box, Family::Wedge, Family::Pyramid][k as usize - 1].small(&mut random, &parameters),
        };
        let set = force_distributions(&problem, &solve(&problem)).expect("a solution");
        assert_self_stresses(&problem, &set);
        for (mass, speed) in [(2.0_f64.powi(-30), 1.0), (2.0_f64.powi(20), 1.0), (1.0, 2.0_f64.powi(-30))] {
            let nv = problem.nv();
            let dense: Vec<f64> = (0..nv * nv).map(|k| mass * problem.mass.get(k / nv, k % nv)).collect();
            let free = problem.free_velocity.iter().map(|v| speed * v).collect();
            let blocks = BlockDiagonal::from_dense(nv, &dense).expect("symmetric");
            let scaled = ContactProblem::new(blocks, free, problem.timestep).expect("valid data");
            let mut other = problem.clone();
            (other.mass, other.mass_factor, other.free_velocity) =
                (scaled.mass, scaled.mass_factor, scaled.free_velocity);
            other.gap.iter_mut().for_each(|gap| *gap *= speed);
            let own = force_distributions(&other, &solve(&other)).expect("a solution");
            assert_eq!(own.dimension, set.dimension, "seed {seed}");
            let unit = mass * speed;
            let pairs = own.normal.iter().zip(&set.normal);
            let pairs = pairs.chain(own.tangential.iter().flatten().zip(set.tangential.iter().flatten()));
            let largest = set.normal.iter().flat_map(|range| [range.min, range.max]);
            let largest = largest.filter(|x| x.is_finite()).fold(0.0, f64::max);
            for (own, before) in pairs {
                let wanted = [before.min * unit, before.max * unit];
                assert!(is(own, wanted[0], wanted[1], 1e2 * largest * unit), "seed {seed}: {own:?} is not {wanted:?}");
                varying += usize::from(before.max > before.min && before.max.is_finite());
                infinite += usize::from(before.max.is_infinite());
            }
            assert!(own.discrepancy < 1e-6, "seed {seed}: {own:?}");
        }
    }
    assert!(varying > 100 && infinite > 20, "{varying} {infinite}");
}

/// A solution of other sizes is none of the problem, whatever it says of itself.
#[test]
fn solutions_of_other_sizes_are_left_as_they_are() {
    let problem = held_particles(2.0, 0.1, &[[1.0, 0.0], [0.0, 1.0]]);
    let solution = solve(&problem);
    let changes: [fn(&mut ContactSolution); 7] = [
        |s| s.lambda_n.truncate(1),
        |s| s.beta.truncate(1),
        |s| s.impulse.truncate(1),
        |s| s.modes.truncate(1),
        |s| s.velocity.truncate(3),
        |s| s.alpha.truncate(4),
        |s| s.bilateral.truncate(2),
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut other = solution.clone();
        change(&mut other);
        let before = other.clone();
        assert_eq!(least_norm_impulses(&problem, &mut other, 1e-9).outcome, LeastNormOutcome::NotSolved, "{k}");
        assert_eq!((before.impulse, before.bilateral), (other.impulse, other.bilateral), "{k}");
    }
    let mut own = solution;
    assert_eq!(least_norm_impulses(&problem, &mut own, 1e-9).outcome, LeastNormOutcome::Chosen);
}
