//! The assembled complementarity problems against the block formulas, entry by entry.

use signorini_contact::{ContactProblem, ProblemError};
use signorini_lcp::{Lemke, solve_mixed};
use signorini_testkit::{Dense, Family, Parameters, Random, articulated, largest_difference};

use signorini_testkit::reference::{Matrices, push_random_groups, random_problem};

fn problems() -> impl Iterator<Item = ContactProblem> {
    (0..60).map(|seed| {
        let mut random = Random::new(seed);
        if seed % 2 == 0 {
            let (nc, nb, nf) = (random.below(6), random.below(4), random.below(4));
            let mut problem = random_problem(&mut random, nc, nb);
            push_random_groups(&mut problem, &mut random, nf);
            return problem;
        }
        let parameters = Parameters { own_polygons: true, ..Parameters::random(&mut random) };
        Family::ALL[(seed / 2) as usize % Family::ALL.len()].small(&mut random, &parameters)
    })
}

/// Every entry to rounding of the products it is made of.
fn assert_same(found: &[f64], wanted: &Dense, name: &str) {
    let scale = wanted.data.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let difference = largest_difference(found, &wanted.data);
    assert!(difference <= 1e-12 * scale, "{name}: differs by {difference:e} of {scale:e}");
}

fn assert_vector(found: &[f64], wanted: &[f64], name: &str) {
    assert_same(found, &Dense { rows: wanted.len(), columns: 1, data: wanted.to_vec() }, name);
}

#[test]
fn mixed_form_has_the_blocks_of_the_formulation() {
    for problem in problems() {
        let (A, b) = Matrices::of(&problem).mixed();
        let mixed = problem.mixed_lcp().expect("finite data");
        assert_same(mixed.A().data(), &A, "A");
        assert_vector(mixed.b(), &b, "b");
        let free = problem.nv() + problem.bilateral_violation.len();
        assert!(mixed.free().iter().enumerate().all(|(i, &f)| f == (i < free)));
    }
}

#[test]
fn condensed_form_has_the_blocks_of_the_formulation() {
    for problem in problems() {
        let (A, b) = Matrices::of(&problem).condensed();
        let condensed = problem.condensed_lcp().expect("finite data");
        assert_same(condensed.A().data(), &A, "A");
        assert_vector(condensed.b(), &b, "b");
        let nb = problem.bilateral_violation.len();
        assert!(condensed.free().iter().enumerate().all(|(i, &f)| f == (i < nb)));
        match problem.standard_lcp() {
            Ok(standard) => {
                assert_eq!(nb, 0);
                assert_same(standard.A().data(), &A, "standard A");
                assert_vector(standard.b(), &b, "standard b");
            }
            Err(error) => assert!(nb > 0 && matches!(error, ProblemError::Length { expected: 0, .. }), "{error}"),
        }
    }
}

#[test]
fn layouts_name_the_rows_in_order() {
    let mut random = Random::new(7);
    let mut problem = random_problem(&mut random, 3, 2);
    push_random_groups(&mut problem, &mut random, 2);
    let (nv, m, m_f) = (problem.nv(), problem.direction_count(), problem.friction_groups.direction_count());
    let at = problem.mixed_layout();
    assert_eq!((at.velocity, at.bilateral, at.normal), (nv, nv, nv + 2));
    assert_eq!((at.tangential, at.group_tangential, at.bounds), (nv + 5, nv + 5 + m, nv + 5 + m + m_f));
    assert_eq!((at.group_bounds, at.size), (nv + 8 + m + m_f, nv + 10 + m + m_f));
    let at = problem.standard_layout();
    assert_eq!((at.velocity, at.bilateral, at.normal, at.tangential), (0, 0, 2, 5));
    assert_eq!((at.bounds, at.group_bounds, at.size), (5 + m + m_f, 8 + m + m_f, 10 + m + m_f));
}

/// One contact in the plane of the page, unit mass at 2 m/s down and 3 m/s along, gap 0.1 m, Δt 0.5 s: every sign by hand.
#[test]
fn signs_of_a_problem_computed_by_hand() {
    let problem = signorini_testkit::particle(-2.0, [3.0, 0.0], 0.5, 0.1, 0.25);
    let lcp = problem.standard_lcp().expect("finite data");
    // rows λ_N, α (directions +x, +y, −x, −y), β
    assert_eq!(lcp.b(), [-1.8, 3.0, 0.0, -3.0, 0.0, 0.0]);
    assert_eq!(lcp.A().row(0), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(lcp.A().row(1), [0.0, 1.0, 0.0, -1.0, 0.0, 1.0]);
    assert_eq!(lcp.A().row(5), [0.25, -1.0, -1.0, -1.0, -1.0, 0.0]);
}

/// `(v⁺, z)` with `v⁺` from `z` solves the mixed form to the accuracy to which `z` solves the condensed one, and back.
#[test]
fn a_solution_of_one_form_solves_the_other() {
    let mut lemke = Lemke::default();
    let mut solved = 0;
    for problem in problems() {
        let (condensed, mixed) = (problem.condensed_lcp().expect("finite"), problem.mixed_lcp().expect("finite"));
        let (at, nv) = (problem.standard_layout(), problem.nv());
        let solution = solve_mixed(&condensed, &mut lemke, None);
        if solution.status.is_solved() {
            let velocity = Matrices::of(&problem).velocity(&solution.z[..at.bounds]);
            let both = [&velocity[..], &solution.z].concat();
            let residual = mixed.residual(&both).value;
            assert!(residual <= 1e-9, "mixed form of a condensed solution: {residual:e}");
            solved += 1;
        }
        let solution = solve_mixed(&mixed, &mut lemke, None);
        if solution.status.is_solved() {
            let residual = condensed.residual(&solution.z[nv..]).value;
            assert!(residual <= 1e-9, "condensed form of a mixed solution: {residual:e}");
            solved += 1;
        }
    }
    assert!(solved >= 90, "only {solved} of 120 solved");
}

#[test]
fn delassus_entries_are_those_of_the_dense_product() {
    // 50 degrees of freedom in one block take the way of large blocks.
    for (seed, nv) in [7, 20, 32, 33, 50].into_iter().enumerate() {
        let problem = articulated(&mut Random::new(seed as u64), &Parameters::default(), nv, 5);
        let inverse = Dense { rows: nv, columns: nv, data: problem.mass.to_dense() }.inverse();
        let (mut scratch, mut largest) = (vec![0.0; nv], 0.0_f64);
        for i in 0..problem.contact_count() {
            let (columns, entries) = problem.jacobian.group(i);
            let found = problem.delassus_diagonal(i, &mut scratch);
            for r in 0..3 {
                let mut row = vec![0.0; nv];
                columns.iter().zip(entries).for_each(|(&column, entry)| row[column as usize] = entry[r]);
                let expected: f64 = inverse.apply(&row).iter().zip(&row).map(|(x, y)| x * y).sum();
                assert!((found[r] - expected).abs() <= 1e-10 * expected, "{nv}: {found:?} {expected}");
                largest = largest.max(expected);
            }
        }
        assert!((problem.delassus_scale() - largest).abs() <= 1e-10 * largest, "{nv}");
        assert!(scratch.iter().all(|&x| x == 0.0));
    }
}
