//! Multipliers and modes from impulses and velocities, against the laws that they stand for.

use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactMode, ContactProblem, ContactSolution, FrictionBound};
use signorini_testkit::Random;
use signorini_testkit::reference::{push_random_groups, random_problem};

/// The smallest multiplier of the bound that keeps `d·c + β ≥ 0` for every direction.
fn least_beta(directions: &[[f64; 2]], c: [f64; 2]) -> f64 {
    directions.iter().map(|d| -(d[0] * c[0] + d[1] * c[1])).fold(0.0, f64::max)
}

/// Checks the multipliers of one friction. `at_bound`: whether its impulse was cut to the bound.
fn check(
    (directions, alpha, beta): (&[[f64; 2]], &[f64], f64),
    (impulse, slip): ([f64; 2], [f64; 2]),
    (bound, at_bound): (f64, bool),
) {
    let sum = directions.iter().zip(alpha).fold([0.0; 2], |t, (d, a)| [t[0] + d[0] * a, t[1] + d[1] * a]);
    let size = 1e-12 * bound.max(1e-3);
    assert!((sum[0] - impulse[0]).abs() <= size && (sum[1] - impulse[1]).abs() <= size, "{sum:?} {impulse:?}");
    assert!(alpha.iter().all(|a| *a >= 0.0));
    let used: f64 = alpha.iter().filter(|a| **a > 0.0).sum();
    assert!(used <= bound * (1.0 + 1e-12), "{used} of {bound}");
    if at_bound {
        assert_eq!(used, bound, "friction at its bound is all of it, to the last digit");
    }
    assert!((beta - least_beta(directions, slip)).abs() <= 1e-14 * (1.0 + beta), "{beta}");
}

/// The mode by its definition; a billionth of the friction is no share.
fn mode_of(bound: f64, alpha: &[f64], frictional: bool, slides: bool) -> ContactMode {
    let largest = alpha.iter().copied().fold(0.0, f64::max);
    let taking_part: Vec<u32> = (0..alpha.len()).filter(|&k| alpha[k] > 1e-9 * largest).map(|k| k as u32).collect();
    match taking_part[..] {
        _ if bound <= 0.0 => ContactMode::Open,
        _ if !frictional => ContactMode::Frictionless,
        _ if !slides => ContactMode::Sticking,
        [k] => ContactMode::Sliding { k },
        [j, k] => ContactMode::SlidingBetween { j, k },
        _ => panic!("{alpha:?}: one direction or two neighbours"),
    }
}

/// A problem with groups, one of which moves nothing, and impulses that its cones admit at some velocity.
fn drawn(random: &mut Random, rests: bool) -> (ContactProblem, Cones, ContactSolution, Vec<bool>) {
    let mut problem = random_problem(random, 4, 0);
    push_random_groups(&mut problem, random, 4);
    let polygon = signorini_testkit::reference::random_polygon(random, 3);
    let target = [random.normal(), random.normal()];
    problem.push_friction(Vec::<(u32, [f64; 2])>::new(), target, FrictionBound::Impulse(0.7), &polygon);
    let mut cones = Cones::default();
    cones.prepare(&problem);
    let mut solution = ContactSolution::default();
    solution.prepare(&problem);
    if rests {
        problem.friction_groups.target.fill([0.0; 2]);
    }
    solution.velocity.iter_mut().for_each(|v| *v = if rests { 0.0 } else { random.normal() });
    let mut cut = Vec::new();
    let mut admitted = |random: &mut Random, unit: usize, n: f64| {
        let y = [n, 2.0 * n.abs() * random.normal(), 2.0 * n.abs() * random.normal()];
        let p = cones.project(unit, cones.mode_at(unit, y), y);
        let acting = cones.admissible(unit, [y[1], y[2]]);
        cut.push((p[1] - acting[0]).hypot(p[2] - acting[1]) > 1e-6 * n.abs());
        p
    };
    for i in 0..4 {
        let n = random.between(-0.3, 1.0);
        solution.impulse[i] = admitted(random, i, n);
    }
    for j in 0..problem.friction_groups.len() {
        // The cone of a group is asked with what the coefficient multiplies.
        let bound = problem.friction_groups.bound[j].at(|i| solution.impulse[i][0]);
        let coefficient = problem.friction_groups.bound[j].normal().map_or(1.0, |(_, c)| c);
        let [_, f_1, f_2] = admitted(random, 4 + j, bound / coefficient);
        solution.group_impulse[j] = [f_1, f_2];
    }
    (problem, cones, solution, cut)
}

#[test]
fn multipliers_and_modes_follow_from_impulses_and_velocities() {
    let mut seen = [0; 5];
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let (problem, cones, mut solution, cut) = drawn(&mut random, seed % 4 == 0);
        let given = solution.clone();
        recover_into(&problem, &cones, 1.0, &mut solution);
        for i in 0..4 {
            let (directions, [n, t_1, t_2]) = (problem.directions_of(i), given.impulse[i]);
            let [_, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
            let alpha = &solution.alpha[problem.direction_offsets[i]..problem.direction_offsets[i + 1]];
            let (bound, frictional) = (problem.friction[i] * n, !directions.is_empty() && problem.friction[i] > 0.0);
            let own = (directions, alpha, solution.beta[i]);
            check(own, ([t_1, t_2], [c_1, c_2]), (bound, frictional && n > 0.0 && cut[i]));
            assert_eq!(solution.lambda_n[i], n);
            // Where it slides is friction at its bound: else no direction need take part.
            let slides = solution.beta[i] > 1e-9;
            if !slides || cut[i] || !frictional || n <= 0.0 {
                let wanted = mode_of(n, alpha, frictional, slides);
                assert_eq!(solution.modes[i], wanted, "seed {seed}, contact {i}: {alpha:?}");
            }
            seen[match solution.modes[i] {
                ContactMode::Open => 0,
                ContactMode::Frictionless => 1,
                ContactMode::Sticking => 2,
                ContactMode::Sliding { .. } => 3,
                _ => 4,
            }] += 1;
        }
        let groups = &problem.friction_groups;
        for j in 0..groups.len() {
            let (directions, slip) = (groups.directions_of(j), groups.slip(j, &solution.velocity));
            let (bound, alpha) =
                (groups.bound_at(j, &solution.lambda_n), &solution.group_alpha[groups.direction_range(j)]);
            let own = (directions, alpha, solution.group_beta[j]);
            let moves_nothing = groups.jacobian.group(j).0.is_empty();
            let slides = solution.group_beta[j] > 1e-9;
            if moves_nothing {
                // Whatever it does, its dissipation is the largest: its bound times its speed, and nothing at rest.
                let [f_1, f_2] = solution.group_impulse[j];
                let power = f_1 * slip[0] + f_2 * slip[1];
                assert!((power + bound * least_beta(directions, slip)).abs() < 1e-14, "{power}");
                assert!(slides || [f_1, f_2] == [0.0; 2]);
            } else {
                assert_eq!(solution.group_impulse[j], given.group_impulse[j]);
            }
            let at_bound = bound > 0.0 && (cut[4 + j] && !moves_nothing || moves_nothing && slides);
            check(own, (solution.group_impulse[j], slip), (bound, at_bound));
            if !slides || at_bound || bound <= 0.0 {
                assert_eq!(solution.group_modes[j], mode_of(bound, alpha, true, slides), "seed {seed}, group {j}");
            }
        }
    }
    assert!(seen.iter().all(|count| *count >= 20), "{seen:?}");
}
