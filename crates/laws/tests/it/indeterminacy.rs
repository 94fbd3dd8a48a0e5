//! Indeterminate impulses: closed forms, an independent linear program, and the properties of the least norm.

use microlp::{ComparisonOp, OptimizationDirection};
use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus, certify};
use signorini_laws::{
    ForceDistributions, ImpulseRange, LeastNorm, LeastNormOutcome, force_distributions, least_norm_impulses,
};
use signorini_lcp::Lemke;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::{ContactSolver, solve_as_lcp};
use signorini_testkit::{Dense, Family, Gap, Parameters, Random, RigidBody, Scene, families};

use signorini_testkit::reference::{keep, random_problem, worst_violation};

const WEIGHT: f64 = 20.0 * 9.81 * 0.01; // impulse of gravity in a step on 20 kg, N·s

/// A box of 20 kg at rest on these feet, its centre of mass 0.25 m above the origin.
fn table(feet: &[[f64; 2]], friction: f64) -> ContactProblem {
    let mut scene = Scene::default();
    let body = RigidBody::cuboid(DVec3::new(1.0, 1.0, 0.5), 20.0, DVec3::Z * 0.25, DMat3::IDENTITY);
    let body = scene.body(body);
    for [x, y] in feet {
        scene.contact(None, Some(body), DVec3::new(*x, *y, 0.0), DVec3::Z, 0.0);
    }
    scene.problem(|_| (friction, FrictionPolygon::regular(4, 0.0).expect("even")))
}

const SQUARE: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];

fn solve(problem: &ContactProblem) -> ContactSolution {
    let solution = ContactSolver::default().solve(problem, None);
    assert_eq!(solution.status, SolveStatus::Solved, "{:?}", solution.certificate);
    solution
}

fn distributions(problem: &ContactProblem) -> ForceDistributions {
    let result = force_distributions(problem, &solve(problem)).expect("a solution");
    assert!(result.residual.worst() < 1e-9 && result.discrepancy < 1e-9, "{result:?}");
    result
}

fn assert_range(range: &ImpulseRange, min: f64, max: f64) {
    assert!((range.min - min).abs() < 1e-9 && (range.max - max).abs() < 1e-9, "{range:?}, not [{min}, {max}]");
}

#[test]
fn three_legs_are_determinate() {
    let set = distributions(&table(&[[0.5, 0.0], [-0.25, 0.4], [-0.25, -0.4]], 0.0));
    assert!(set.is_unique() && set.linear_programs == 0);
    set.normal.iter().for_each(|range| assert_range(range, WEIGHT / 3.0, WEIGHT / 3.0));
}

/// Three equations for four normal impulses: `λ = W/4 (1 + s, 1 − s, 1 + s, 1 − s)`, |s| ≤ 1.
#[test]
fn four_frictionless_legs_leave_one_dimension() {
    let problem = table(&SQUARE, 0.0);
    let set = distributions(&problem);
    assert_eq!(set.dimension, 1);
    set.normal.iter().for_each(|range| assert_range(range, 0.0, WEIGHT / 2.0));
    set.tangential.iter().flatten().for_each(|range| assert_range(range, 0.0, 0.0));
    let mut solution = solve(&problem);
    least_norm_impulses(&problem, &mut solution, 1e-9);
    solution.lambda_n.iter().for_each(|p| assert!((p - WEIGHT / 4.0).abs() < 1e-14, "{:?}", solution.lambda_n));
}

/// Twelve impulses, a balance of rank 6, cones with interior: six dimensions. A foot can still carry half the weight at most: tangential
/// impulses in the ground plane have no moment about its horizontal axes.
#[test]
fn friction_on_four_legs_leaves_six_dimensions() {
    let mu = 0.5;
    let problem = table(&SQUARE, mu);
    let set = distributions(&problem);
    assert_eq!(set.dimension, 6);
    set.normal.iter().for_each(|range| assert_range(range, 0.0, WEIGHT / 2.0));
    for [t_1, t_2] in &set.tangential {
        for range in [t_1, t_2] {
            assert!((range.max + range.min).abs() < 1e-9 && range.max > 0.2 * mu * WEIGHT, "{range:?}");
        }
    }
    let mut solution = solve(&problem);
    let report = least_norm_impulses(&problem, &mut solution, 1e-9);
    assert_eq!(report.outcome, LeastNormOutcome::Chosen);
    for p in &solution.impulse {
        assert!((p[0] - WEIGHT / 4.0).abs() < 1e-13 && p[1].abs() < 1e-13 && p[2].abs() < 1e-13, "{p:?}");
    }
}

/// On the edge of tipping only two feet can carry: the weight above them fixes the others at 0 in every solution, which a rank
/// alone does not see.
#[test]
fn feet_that_cannot_carry_do_not_count() {
    let set = distributions(&table(&[[0.0, -0.5], [0.0, 0.5], [0.7, 0.5], [0.7, -0.5]], 0.0));
    assert_eq!(set.dimension, 0, "{set:?}");
    for (k, range) in set.normal.iter().enumerate() {
        let wanted = if k < 2 { WEIGHT / 2.0 } else { 0.0 };
        assert_range(range, wanted, wanted);
    }
}

/// A beam on n supports in a row, symmetric about its centre: two equations. Least norm: `λ_k = a + b x_k`, here equal.
#[test]
fn a_beam_on_many_supports() {
    for n in [2, 3, 5, 8] {
        let feet: Vec<[f64; 2]> = (0..n).map(|k| [k as f64 / (n - 1) as f64 - 0.5, 0.0]).collect();
        let problem = table(&feet, 0.0);
        let set = distributions(&problem);
        assert_eq!(set.dimension, n - 2);
        // The outer supports carry at most half each; an inner one, with the farthest on its other side, all but their share.
        for (k, range) in set.normal.iter().enumerate().filter(|_| n > 2) {
            let x = feet[k][0];
            assert_range(range, 0.0, WEIGHT * 0.5 / (0.5 + x.abs()));
        }
        let mut solution = solve(&problem);
        least_norm_impulses(&problem, &mut solution, 1e-9);
        solution.lambda_n.iter().for_each(|p| assert!((p - WEIGHT / n as f64).abs() < 1e-13));
    }
}

/// A box of 20 kg between two walls, and the solution in which their friction holds it (that it falls is another one).
fn held_box() -> (ContactProblem, ContactSolution) {
    let mut scene = Scene::default();
    let body = scene.body(RigidBody::cuboid(DVec3::splat(0.4), 20.0, DVec3::ZERO, DMat3::IDENTITY));
    scene.contact(None, Some(body), DVec3::X * -0.2, DVec3::X, 0.0);
    scene.contact(None, Some(body), DVec3::X * 0.2, DVec3::NEG_X, 0.0);
    let problem = scene.problem(|_| (0.5, FrictionPolygon::regular(4, 0.0).expect("even")));
    let mut solution = solve(&problem);
    solution.velocity.fill(0.0);
    solution.beta.fill(0.0);
    solution.alpha.fill(0.0);
    for i in 0..2 {
        let (columns, entries) = problem.jacobian.group(i);
        let vertical = entries[columns.iter().position(|&c| c == 2).expect("moves with the box")];
        let upwards = |d: &[f64; 2]| d[0] * vertical[1] + d[1] * vertical[2] > 0.9;
        let k = problem.directions_of(i).iter().position(upwards).expect("the directions include the vertical");
        solution.alpha[problem.direction_offsets[i] + k] = WEIGHT / 2.0;
        solution.lambda_n[i] = 3.0 * WEIGHT;
        solution.impulse[i] = [3.0 * WEIGHT, WEIGHT / 2.0 * vertical[1], WEIGHT / 2.0 * vertical[2]];
    }
    solution.certificate = certify(&problem, &solution);
    assert!(solution.certificate.holds(1e-12), "{:?}", solution.certificate);
    (problem, solution)
}

/// The squeeze has no upper bound, and a lower one: `2 μ λ ≥ W`.
#[test]
fn a_wedge_between_walls_is_unbounded() {
    let (problem, mut solution) = held_box();
    let set = force_distributions(&problem, &solution).expect("a solution");
    for range in &set.normal {
        assert!((range.min - WEIGHT).abs() < 1e-9 && range.max == f64::INFINITY, "{range:?}");
        let stress = &set.self_stresses[range.grows_along.expect("a reason")];
        let mut effect = vec![0.0; 6];
        stress.impulse.iter().enumerate().for_each(|(i, p)| problem.jacobian.add_transposed(i, *p, &mut effect));
        assert!(effect.iter().all(|x| x.abs() < 1e-12) && stress.impulse[0][0] > 0.1, "{stress:?}");
    }
    let report = least_norm_impulses(&problem, &mut solution, 1e-9);
    assert!(report.norm < report.norm_before);
    solution.lambda_n.iter().for_each(|p| assert!((p - WEIGHT).abs() < 1e-12, "{:?}", solution.lambda_n));
}

/// A sliding box: friction is μ λ_N against the motion at every foot, so that only the normal impulses have freedom, and a foot
/// loses it to the moment of friction about the centre of mass.
#[test]
fn a_sliding_box_keeps_the_bound() {
    let mut problem = table(&SQUARE, 0.2);
    problem.free_velocity[0] = 2.0;
    let set = distributions(&problem);
    assert_eq!(set.dimension, 1);
    let mut solution = solve(&problem);
    least_norm_impulses(&problem, &mut solution, 1e-9);
    for (i, p) in solution.impulse.iter().enumerate() {
        assert!((p[1].hypot(p[2]) - 0.2 * p[0]).abs() < 1e-13, "contact {i}: {p:?}");
        let [slow, fast] = [set.normal[i].min, set.normal[i].max];
        assert!(slow < p[0] && p[0] < fast && (set.tangential[i][0].max - set.tangential[i][0].min).abs() < fast);
    }
}

/// A bar welded to the world twice: every load is shared equally, no load has a bound.
#[test]
fn a_box_welded_twice_shares_its_load() {
    let mut problem = table(&[], 0.0);
    for _ in 0..2 {
        (0..6).for_each(|k| problem.push_bilateral([(k, [1.0])], 0.0));
    }
    let set = distributions(&problem);
    assert_eq!(set.dimension, 6);
    assert!(set.bilateral.iter().all(|r| r.min == f64::NEG_INFINITY && r.max == f64::INFINITY), "{set:?}");
    let mut solution = solve(&problem);
    solution.bilateral[2] += 5.0;
    solution.bilateral[8] -= 5.0;
    let report = least_norm_impulses(&problem, &mut solution, 1e-9);
    assert_eq!(report.outcome, LeastNormOutcome::Chosen);
    for (k, p) in solution.bilateral.iter().enumerate() {
        let wanted = if k % 6 == 2 { WEIGHT / 2.0 } else { 0.0 };
        assert!((p - wanted).abs() < 1e-12, "{:?}", solution.bilateral);
    }
}

/// Contacts and rows over one table: two legs and a weld that also carries.
#[test]
fn rows_and_contacts_share() {
    let mut problem = table(&[[0.0, -0.5], [0.0, 0.5]], 0.0);
    problem.push_bilateral([(2, [1.0])], 0.0);
    let set = distributions(&problem);
    assert_eq!(set.dimension, 1);
    assert!(set.normal[0].min.abs() < 1e-9 && set.normal[0].max == f64::INFINITY, "{set:?}");
    assert!(set.bilateral[0].min == f64::NEG_INFINITY && (set.bilateral[0].max - WEIGHT).abs() < 1e-9, "{set:?}");
    let mut solution = solve(&problem);
    least_norm_impulses(&problem, &mut solution, 1e-9);
    assert!(
        (solution.bilateral[0] - WEIGHT / 3.0).abs() < 1e-13 && (solution.lambda_n[0] - WEIGHT / 3.0).abs() < 1e-13
    );
}

#[test]
fn what_is_no_solution_is_refused() {
    let problem = table(&SQUARE, 0.5);
    let mut solution = solve(&problem);
    solution.velocity[2] += 0.1;
    assert!(force_distributions(&problem, &solution).is_err());
    let unsolved = &mut solution;
    unsolved.status = SolveStatus::Inaccurate;
    let before = unsolved.impulse.clone();
    assert_eq!(least_norm_impulses(&problem, unsolved, 1e-9).outcome, LeastNormOutcome::NotSolved);
    assert_eq!(before, unsolved.impulse);
}

/// A linear program over the same set by another solver: variables `λ_N ≥ 0`, `α ≥ 0` of the LCP itself, complementarity decided
/// here from `w`, the balance in all degrees of freedom.
fn independent_range(
    problem: &ContactProblem,
    solution: &ContactSolution,
    contact: usize,
    r: usize,
) -> Option<[f64; 2]> {
    let tolerance = 1e-8 * problem.velocity_scale();
    let mut ends = [0.0; 2];
    for (end, direction) in ends.iter_mut().zip([OptimizationDirection::Minimize, OptimizationDirection::Maximize]) {
        let mut program = microlp::Problem::new(direction);
        let mut balance = vec![Vec::new(); problem.nv()];
        let mut right = vec![0.0; problem.nv()];
        for i in 0..problem.contact_count() {
            let c = problem.contact_velocity(i, &solution.velocity);
            let along: Vec<f64> = problem.directions_of(i).iter().map(|d| d[0] * c[1] + d[1] * c[2]).collect();
            let beta = along.iter().map(|x| -x).fold(0.0, f64::max);
            let bound = |zero: bool| if zero { (0.0, 0.0) } else { (0.0, f64::INFINITY) };
            let wanted = |component: usize, value: f64| if i == contact && component == r { value } else { 0.0 };
            let open = c[0] + problem.gap[i] / problem.timestep > tolerance;
            let normal = program.add_var(wanted(0, 1.0), bound(open));
            let mut share = microlp::LinearExpr::empty();
            share.add(normal, problem.friction[i]);
            let (columns, entries) = problem.jacobian.group(i);
            columns.iter().zip(entries).for_each(|(&k, e)| balance[k as usize].push((normal, e[0])));
            let own = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
            columns.iter().zip(entries).for_each(|(&k, e)| right[k as usize] += e[0] * solution.lambda_n[i]);
            for ((d, along), alpha) in problem.directions_of(i).iter().zip(&along).zip(&solution.alpha[own]) {
                let cost = wanted(1, d[0]) + wanted(2, d[1]);
                let variable = program.add_var(cost, bound(along + beta > tolerance));
                share.add(variable, -1.0);
                for (&k, e) in columns.iter().zip(entries) {
                    let entry = d[0] * e[1] + d[1] * e[2];
                    balance[k as usize].push((variable, entry));
                    right[k as usize] += entry * alpha;
                }
            }
            let relation = if beta > tolerance { ComparisonOp::Eq } else { ComparisonOp::Ge };
            program.add_constraint(share, relation, 0.0);
        }
        for (terms, right) in balance.into_iter().zip(right) {
            if !terms.is_empty() {
                // Its rounding must not make the program infeasible.
                program.add_constraint(terms.clone(), ComparisonOp::Le, right + 1e-9);
                program.add_constraint(terms, ComparisonOp::Ge, right - 1e-9);
            }
        }
        *end = match program.solve() {
            Ok(microlp::SolveOutcome::Solution(optimum)) => optimum.objective(),
            Err(microlp::Error::Unbounded) if direction == OptimizationDirection::Minimize => f64::NEG_INFINITY,
            Err(microlp::Error::Unbounded) => f64::INFINITY,
            _ => return None,
        };
    }
    Some(ends)
}

fn redundant(seed: u64) -> ContactProblem {
    let mut random = Random::new(110_000 + seed);
    if seed % 4 == 3 {
        let nc = 2 + random.below(3);
        return random_problem(&mut random, nc, 0);
    }
    let gap = random.choice(&[Gap::Zero, Gap::Positive]);
    let parameters = Parameters { gap, mass_ratio: 1.0, directions: 4, ..Parameters::random(&mut random) };
    let parameters = Parameters { own_polygons: false, ..parameters };
    random.choice(&[Family::Box, Family::Wedge, Family::Squeeze, Family::Pyramid]).small(&mut random, &parameters)
}

#[test]
fn ranges_agree_with_an_independent_linear_program() {
    let (mut compared, mut varying, mut infinite) = (0, 0, 0);
    for seed in 0..60 {
        let problem = redundant(seed);
        let solution = ContactSolver::default().solve(&problem, None);
        if solution.status != SolveStatus::Solved {
            continue;
        }
        let set = force_distributions(&problem, &solution).expect("a solution");
        assert!(set.residual.worst() < 1e-8 && set.discrepancy < 1e-7, "seed {seed}: {set:?}");
        let scale = solution.lambda_n.iter().fold(1e-9, |a: f64, p| a.max(*p));
        for i in 0..problem.contact_count().min(3) {
            let [t_1, t_2] = set.tangential[i];
            for (r, range) in [set.normal[i], t_1, t_2].into_iter().enumerate() {
                let Some(wanted) = independent_range(&problem, &solution, i, r) else { continue };
                for (own, wanted) in [(range.min, wanted[0]), (range.max, wanted[1])] {
                    // The reference is relaxed by 1e-9 and feasible to 1e-7, which its own vertices magnify.
                    let same = own == wanted || (own - wanted).abs() < 1e-5 * scale.max(0.1);
                    assert!(same, "seed {seed}, contact {i}, component {r}: {own} is not {wanted} of {scale}");
                    infinite += usize::from(own.is_infinite());
                }
                compared += 1;
                varying += usize::from(range.max > range.min + 1e-6);
            }
        }
    }
    println!("{compared} ranges, {varying} of them not points, {infinite} ends infinite");
    assert!(compared > 300 && varying > 100 && infinite >= 10, "{compared} {varying} {infinite}");
}

/// The variational inequality of the least norm, `λᵀ(λ' − λ) ≥ 0`, against other solutions λ' of the same set.
#[test]
fn the_least_norm_is_least_and_solves_the_problem() {
    let (mut chosen, mut shorter) = (0, 0);
    for seed in 0..240 {
        let mut random = Random::new(120_000 + seed);
        let parameters = Parameters::random(&mut random);
        let family = Family::ALL[(seed as usize / 2) % Family::ALL.len()];
        let problem = family.small(&mut random, &parameters);
        // Lemke's impulses are a vertex of the set, far from the least norm; the structured solver's are close to it.
        let mut solution = if seed % 2 == 0 {
            ContactSolver::default().solve(&problem, None)
        } else {
            solve_as_lcp(&problem, &mut Lemke::default(), 1e-9).expect("finite data")
        };
        if solution.status != SolveStatus::Solved {
            continue;
        }
        let (before, velocity) = (solution.impulse.clone(), solution.velocity.clone());
        let report = LeastNorm::default().apply(&problem, &mut solution, 1e-9);
        if report.outcome != LeastNormOutcome::Chosen {
            keep(&problem, &format!("least_norm_{seed}"));
        }
        assert_eq!(report.outcome, LeastNormOutcome::Chosen, "seed {seed} {family:?} {parameters:?}: {report:?}");
        assert_eq!(velocity, solution.velocity);
        assert!(worst_violation(&problem, &solution) < 1e-8, "seed {seed}");
        let product = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| x * y).sum::<f64>()
        };
        let own = product(&solution.impulse, &solution.impulse);
        let other = product(&solution.impulse, &before);
        assert!(other >= own * (1.0 - 1e-7), "seed {seed} {family:?}: {other} < {own}");
        chosen += 1;
        shorter += usize::from(report.norm < 0.999 * report.norm_before);
    }
    println!("{chosen} chosen, {shorter} of them shorter than before");
    assert!(chosen > 150 && shorter > 20, "{chosen} {shorter}");
}

/// From any starting impulses, in any order of contacts, in any tangent frame, the choice is the same; copies share equally.
#[test]
fn the_choice_depends_on_nothing_but_the_set() {
    for seed in 0..40 {
        let mut random = Random::new(130_000 + seed);
        let parameters = Parameters { friction: 0.6, directions: 6, ..Parameters::default() };
        let problem = match seed % 3 {
            0 => families::box_on_plane(&mut random, &parameters, 0.2),
            1 => families::pyramid(&mut random, &parameters, 2),
            _ => families::squeeze(&mut random, &parameters, 2),
        };
        let mut solution = solve(&problem);
        least_norm_impulses(&problem, &mut solution, 1e-9);
        let nc = problem.contact_count();
        let order = random.permutation(nc);
        let angle = random.between(0.0, 6.0);
        let (sin, cos) = angle.sin_cos();
        let turn = |x: f64, y: f64| [cos * x + sin * y, cos * y - sin * x];
        let mut other =
            ContactProblem::new(problem.mass.clone(), problem.free_velocity.clone(), problem.timestep).expect("valid");
        for &i in &order {
            let (columns, entries) = problem.jacobian.group(i);
            let group: Vec<(u32, [f64; 3])> = columns
                .iter()
                .zip(entries)
                .map(|(&c, e)| (c, turn(e[1], e[2])))
                .zip(entries)
                .map(|((c, t), e)| (c, [e[0], t[0], t[1]]))
                .collect();
            let directions = problem.directions_of(i).iter().map(|d| turn(d[0], d[1])).collect();
            let polygon = FrictionPolygon::from_directions(directions).expect("balanced");
            for _ in 0..1 + seed % 2 {
                other.push_contact(group.clone(), problem.gap[i], problem.friction[i], &polygon);
            }
        }
        let copies = 1 + (seed % 2) as usize;
        let mut turned = solve(&other);
        let report = least_norm_impulses(&other, &mut turned, 1e-9);
        assert_eq!(report.outcome, LeastNormOutcome::Chosen);
        for (place, p) in turned.impulse.iter().enumerate() {
            let q = turned.impulse[place - place % copies];
            (0..3).for_each(|r| assert!((p[r] - q[r]).abs() <= 1e-10 * report.norm, "copies share"));
            // With copies the norm counts every one of them, so that the choice is that of the single contacts at equal copies.
            let own = solution.impulse[order[place / copies]];
            let wanted = turn(own[1], own[2]);
            for (a, b) in p.iter().zip([own[0], wanted[0], wanted[1]]) {
                assert!((a * copies as f64 - b).abs() <= 1e-9 * report.norm, "seed {seed}: {p:?} is not {own:?}");
            }
        }
    }
}

/// Where every contact is loaded inside its cone and the rows of the balance are independent, the dimension is the number of
/// unknowns less that of equations.
#[test]
fn dimensions_count_unknowns_less_equations() {
    for height in 1..4 {
        let parameters = Parameters { friction: 1.0, directions: 8, ..Parameters::default() };
        let problem = families::stack(&mut Random::new(5), &parameters, height);
        let jacobian = Dense::from_fn(problem.nv(), 3 * problem.contact_count(), |dof, k| {
            let (columns, entries) = problem.jacobian.group(k / 3);
            columns.iter().position(|&c| c as usize == dof).map_or(0.0, |at| entries[at][k % 3])
        });
        let gram = jacobian.times(&jacobian.transposed());
        let identity = gram.inverse().times(&gram);
        assert!((0..problem.nv()).all(|i| (identity[(i, i)] - 1.0).abs() < 1e-6), "the rows are independent");
        assert_eq!(distributions(&problem).dimension, 3 * problem.contact_count() - problem.nv());
    }
}
