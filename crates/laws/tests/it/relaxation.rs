//! Anitescu's relaxation: its own laws in dense matrices, its energy, its agreement with the contact laws where nothing slides,
//! and its artefact where something does.

use std::collections::BTreeMap;

use signorini_contact::{ContactProblem, FrictionPolygon, SolveStatus};
use signorini_laws::{ConvexRelaxation, RelaxationStatus, RelaxedSolution};
use signorini_lcp::{Lcp, Lemke, Matrix, Method};
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::ContactSolver;
use signorini_testkit::{
    Dense, Family, Gap, Motion, Parameters, Random, RigidBody, Scene, families, largest_difference,
};

use signorini_testkit::reference::{keep, random_problem};

/// The relaxed rows `n + μ d_k` of all contacts over dense matrices, `[rows, nv]`, with `φ/Δt`.
fn relaxed_rows(problem: &ContactProblem) -> (Dense, Vec<f64>) {
    let (nv, mut data, mut rates) = (problem.nv(), Vec::new(), Vec::new());
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        let none = [[0.0, 0.0]];
        let directions = if problem.directions_of(i).is_empty() { &none[..] } else { problem.directions_of(i) };
        for d in directions {
            let mut row = vec![0.0; nv];
            for (&c, e) in columns.iter().zip(entries) {
                row[c as usize] = e[0] + problem.friction[i] * (d[0] * e[1] + d[1] * e[2]);
            }
            data.extend(row);
            rates.push(problem.gap[i] / problem.timestep);
        }
    }
    (Dense { rows: rates.len(), columns: nv, data }, rates)
}

fn inverse_mass(problem: &ContactProblem) -> Dense {
    Dense::from_fn(problem.nv(), problem.nv(), |i, j| problem.mass.get(i, j)).inverse()
}

/// Natural map of the relaxed LCP, from dense matrices and the multipliers alone, relative to `max|b|`.
fn violation(problem: &ContactProblem, solution: &RelaxedSolution) -> f64 {
    let (rows, rates) = relaxed_rows(problem);
    let mut multipliers = Vec::new();
    for i in 0..problem.contact_count() {
        match &solution.alpha[problem.direction_offsets[i]..problem.direction_offsets[i + 1]] {
            [] => multipliers.push(solution.impulse[i][0]),
            alpha => multipliers.extend_from_slice(alpha),
        }
    }
    let inverse = inverse_mass(problem);
    let change = inverse.apply(&rows.transposed().apply(&multipliers));
    let velocity: Vec<f64> = problem.free_velocity.iter().zip(&change).map(|(f, c)| f + c).collect();
    let delassus = rows.times(&inverse).times(&rows.transposed());
    let g = (0..rows.rows).map(|k| delassus[(k, k)]).fold(1e-300, f64::max);
    let w: Vec<f64> = rows.apply(&velocity).iter().zip(&rates).map(|(c, r)| c + r).collect();
    let natural = w.iter().zip(&multipliers).map(|(w, a)| w.min(g * a).abs());
    natural.chain([largest_difference(&rows.apply(&velocity), &rows.apply(&solution.velocity))]).fold(0.0, f64::max)
        / problem.velocity_scale()
}

fn energy(problem: &ContactProblem, v: &[f64]) -> f64 {
    let mut p = vec![0.0; v.len()];
    problem.mass.multiply_into(v, &mut p);
    0.5 * p.iter().zip(v).map(|(p, v)| p * v).sum::<f64>()
}

/// Farkas: impulses of the friction cones without any effect that do work against the gaps.
fn proves_contradiction(problem: &ContactProblem, status: &RelaxationStatus) -> bool {
    let RelaxationStatus::Inconsistent { proof } = status else { return false };
    let mut effect = vec![0.0; problem.nv()];
    let mut work = 0.0;
    for (i, &p) in proof.impulse.iter().enumerate() {
        problem.jacobian.add_transposed(i, p, &mut effect);
        work += p[0] * problem.gap[i];
        let reach = problem.directions_of(i).iter().map(|d| d[0] * p[1] + d[1] * p[2]).fold(0.0, f64::max);
        assert!(p[0] >= 0.0 && reach <= problem.friction[i] * p[0] * (1.0 + 1e-9) + 1e-12);
    }
    let largest = effect.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    work < 0.0 && largest < 1e-6
}

#[test]
fn every_family_is_solved_to_rounding_without_adding_energy() {
    let mut relaxation = ConvexRelaxation::default();
    let mut table: BTreeMap<String, (usize, usize, usize, f64, u32, u32)> = BTreeMap::new();
    let mut faults = Vec::new();
    for seed in 0..640 {
        let mut random = Random::new(70_000 + seed);
        let family = Family::ALL[seed as usize % Family::ALL.len()];
        let parameters = Parameters::random(&mut random);
        let problem = family.small(&mut random, &parameters);
        let solution = relaxation.solve(&problem, 1e-10);
        let row = table.entry(format!("{family:?}")).or_default();
        row.0 += 1;
        row.4 += solution.report.iterations;
        row.5 += solution.report.factorizations;
        let mut fault = |what: String| {
            keep(&problem, &format!("relaxation_{family:?}_{seed}"));
            faults.push(format!("seed {seed} {family:?} {parameters:?}: {what}"));
        };
        match &solution.status {
            RelaxationStatus::Solved => {
                row.1 += 1;
                let violation = violation(&problem, &solution);
                row.3 = row.3.max(violation);
                if violation > 1e-10 {
                    fault(format!("claims Solved, violates its laws by {violation:e}"));
                }
                let change: Vec<f64> =
                    solution.velocity.iter().zip(&problem.free_velocity).map(|(v, f)| v - f).collect();
                let before = energy(&problem, &problem.free_velocity);
                let after = energy(&problem, &solution.velocity) + energy(&problem, &change);
                if problem.gap.iter().all(|phi| *phi >= 0.0) && after > before * (1.0 + 1e-10) {
                    fault(format!("energy grows from {before} to {after}"));
                }
            }
            status if proves_contradiction(&problem, status) && problem.gap.iter().any(|phi| *phi < 0.0) => row.2 += 1,
            status => fault(format!("{status:?}, {:?}", solution.certificate)),
        }
    }
    println!(
        "{:12} {:>4} {:>6} {:>13} {:>9} {:>10} {:>14}",
        "family", "all", "solved", "contradictory", "residual", "iterations", "factorisations"
    );
    for (name, (all, solved, contradictory, residual, iterations, factorizations)) in table {
        println!("{name:12} {all:4} {solved:6} {contradictory:13} {residual:9.1e} {iterations:10} {factorizations:14}");
    }
    assert!(faults.is_empty(), "{}\n{}", faults.len(), faults.join("\n"));
}

/// The same velocity as lexicographic Lemke finds for the relaxed rows, a positive semidefinite LCP.
#[test]
fn velocities_agree_with_lemke_on_the_relaxed_rows() {
    let mut relaxation = ConvexRelaxation::default();
    let mut compared = 0;
    for seed in 0..150 {
        let mut random = Random::new(80_000 + seed);
        let problem = if seed % 2 == 0 {
            let nc = 1 + random.below(4);
            random_problem(&mut random, nc, 0)
        } else {
            let parameters = Parameters { gap: Gap::Positive, mass_ratio: 1.0, ..Parameters::random(&mut random) };
            random.choice(&[Family::Box, Family::Stack, Family::Wedge]).small(&mut random, &parameters)
        };
        let (rows, rates) = relaxed_rows(&problem);
        let delassus = rows.times(&inverse_mass(&problem)).times(&rows.transposed());
        let b = rows.apply(&problem.free_velocity).iter().zip(&rates).map(|(c, r)| c + r).collect();
        let A = Matrix::new(rows.rows, rows.rows, delassus.data).expect("square");
        let lemke = Lemke::default().solve(&Lcp::new(A, b).expect("finite"), None);
        if !lemke.status.is_solved() {
            continue;
        }
        let change = inverse_mass(&problem).apply(&rows.transposed().apply(&lemke.z));
        let wanted: Vec<f64> = problem.free_velocity.iter().zip(&change).map(|(f, c)| f + c).collect();
        let solution = relaxation.solve(&problem, 1e-10);
        assert_eq!(solution.status, RelaxationStatus::Solved, "seed {seed}: {:?}", solution.certificate);
        let scale = wanted.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()));
        let difference = largest_difference(&solution.velocity, &wanted) / scale;
        assert!(difference < 1e-7, "seed {seed}: {difference:e}");
        compared += 1;
    }
    assert!(compared > 130, "Lemke solved only {compared}");
}

/// A block of 2 kg that lies on a plane, one point at its centre of mass, and is pulled along x with 20 m/s²: height and speed
/// after each step of a model.
fn pulled(mu: f64, exact: bool) -> Vec<[f64; 2]> {
    let dt = 0.01;
    let mass = BlockDiagonal::from_dense(3, &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]).expect("symmetric");
    let (mut v, mut height, mut history) = (vec![0.0; 3], 0.0, Vec::new());
    for _ in 0..20 {
        let free = vec![v[0] + 20.0 * dt, v[1], v[2] - 9.81 * dt];
        let mut problem = ContactProblem::new(mass.clone(), free, dt).expect("valid data");
        let columns = [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])];
        problem.push_contact(columns, height, mu, &FrictionPolygon::regular(4, 0.0).expect("even"));
        v = if exact {
            ContactSolver::default().solve(&problem, None).velocity
        } else {
            let solution = ConvexRelaxation::default().solve(&problem, 1e-10);
            assert_eq!(solution.status, RelaxationStatus::Solved);
            // What the true laws miss is that an open contact, μ‖c_T‖ = c_N + φ/Δt, carries an impulse, and nothing else.
            let laws = solution.contact_laws(&problem);
            let opening = (mu * solution.velocity[0]).min(0.5 * solution.impulse[0][0]) / problem.velocity_scale();
            assert!((laws.signorini - opening).abs() < 1e-12 && opening > 0.02, "{laws:?}");
            assert!(laws.friction < 1e-12 && laws.dissipation < 1e-12 && laws.momentum < 1e-12, "{laws:?}");
            solution.velocity
        };
        height += dt * v[2];
        history.push([height, v[0]]);
    }
    history
}

/// The relaxed block floats at `φ = μ v Δt` above the plane; by the contact laws it stays on it.
#[test]
fn a_sliding_block_floats_at_mu_v_dt() {
    let (mu, dt) = (0.5, 0.01);
    let (relaxed, exact) = (pulled(mu, false), pulled(mu, true));
    for (k, ([height, speed], [no_height, wanted])) in relaxed.iter().zip(&exact).enumerate() {
        assert!((height - mu * speed * dt).abs() < 1e-14, "step {k}: {height} at {speed}");
        let law = (20.0 - mu * 9.81) * dt * (k + 1) as f64;
        assert!(no_height.abs() < 1e-14 && (wanted - law).abs() < 1e-12, "step {k}: {no_height} at {wanted}");
    }
    let [height, speed] = relaxed[19];
    assert!(speed > 2.0 && height > 0.01, "{height} at {speed}");
}

/// A block that is set sliding at once, at 1 m/s, is thrown up with `μ v`.
#[test]
fn a_block_struck_along_the_plane_is_thrown_up() {
    let mass = BlockDiagonal::from_dense(2, &[2.0, 0.0, 0.0, 2.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![1.0, -0.0981], 0.01).expect("valid data");
    problem.push_contact(
        [(0, [0.0, 1.0, 0.0]), (1, [1.0, 0.0, 0.0])],
        0.0,
        0.5,
        &FrictionPolygon::regular(2, 0.0).expect("even"),
    );
    let relaxed = ConvexRelaxation::default().solve(&problem, 1e-10);
    let impulse = (0.5 + 0.0981) / 1.25;
    assert!(largest_difference(&relaxed.velocity, &[1.0 - 0.5 * impulse, -0.0981 + impulse]) < 1e-14);
    let exact = ContactSolver::default().solve(&problem, None);
    assert!(largest_difference(&exact.velocity, &[1.0 - 0.5 * 0.0981, 0.0]) < 1e-14);
}

/// Where nothing slides the relaxed rows are the contact laws.
#[test]
fn where_nothing_slides_the_contact_laws_hold() {
    let (mut relaxation, mut solver) = (ConvexRelaxation::default(), ContactSolver::default());
    let mut loaded = 0;
    for seed in 0..80 {
        let mut random = Random::new(90_000 + seed);
        let parameters = Parameters { friction: 2.0, directions: 8, motion: Motion::Rest, ..Parameters::default() };
        let problem = match seed % 3 {
            0 => families::box_on_plane(&mut random, &parameters, 0.4),
            1 => families::stack(&mut random, &parameters, 3),
            _ => families::pyramid(&mut random, &parameters, 3),
        };
        let relaxed = relaxation.solve(&problem, 1e-10);
        let laws = relaxed.contact_laws(&problem);
        assert!(laws.holds(1e-9), "seed {seed}: {laws:?}");
        let exact = solver.solve(&problem, None);
        assert_eq!(exact.status, SolveStatus::Solved);
        assert!(largest_difference(&exact.velocity, &relaxed.velocity) < 1e-9, "seed {seed}");
        loaded += usize::from(relaxed.impulse.iter().any(|p| p[0] > 0.0));
    }
    assert_eq!(loaded, 80);
}

/// A wedge with negative gaps and `tan(half angle) < μ` jams. The relaxed rows have the same friction cones, which are not
/// pointed together: what wedges the contact laws contradicts itself here.
#[test]
fn a_jammed_wedge_contradicts_itself() {
    let parameters = Parameters { friction: 1.0, gap: Gap::Negative, ..Parameters::default() };
    let problem = families::wedge(&mut Random::new(3), &parameters, 0.3, 1);
    let exact = ContactSolver::default().solve(&problem, None);
    assert!(matches!(exact.status, SolveStatus::Ray { .. }), "{:?}", exact.status);
    let relaxed = ConvexRelaxation::default().solve(&problem, 1e-10);
    assert!(proves_contradiction(&problem, &relaxed.status), "{:?}", relaxed.status);
}

/// Bilateral rows hold beside relaxed contacts: a block on a guide along x slides and is lifted, its guide keeps y.
#[test]
fn bilateral_rows_are_kept() {
    let mass = BlockDiagonal::from_dense(3, &[3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![2.0, 0.7, -0.5], 0.01).expect("valid data");
    let columns = [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.4, &FrictionPolygon::regular(8, 0.0).expect("even"));
    problem.push_bilateral([(1, [1.0])], 1e-3);
    problem.push_bilateral([(1, [2.0])], 2e-3);
    let solution = ConvexRelaxation::default().solve(&problem, 1e-10);
    assert_eq!(solution.status, RelaxationStatus::Solved, "{:?}", solution.certificate);
    // With c_y = −0.1 prescribed, the least change of (v_x, v_z) from (2, −0.5) with v_z ≥ 0.4 v_x.
    let along = (0.5 + 0.4 * 2.0) / (1.0 + 0.4 * 0.4);
    let wanted = [2.0 - 0.4 * along, -0.1, -0.5 + along];
    assert!(largest_difference(&solution.velocity, &wanted) < 1e-13, "{:?}", solution.velocity);
}

#[test]
fn contradictory_rows_are_proved_to_be() {
    let mut scene = Scene::default();
    let body = RigidBody::cuboid(DVec3::splat(0.4), 5.0, DVec3::ZERO, DMat3::IDENTITY);
    let body = scene.body(body);
    scene.contact(None, Some(body), DVec3::X * -0.2, DVec3::X, -1e-3);
    scene.contact(None, Some(body), DVec3::X * 0.2, DVec3::NEG_X, -1e-3);
    let problem = scene.problem(|_| (0.5, FrictionPolygon::regular(6, 0.1).expect("even")));
    let solution = ConvexRelaxation::default().solve(&problem, 1e-10);
    assert!(proves_contradiction(&problem, &solution.status), "{:?}", solution.status);
}
