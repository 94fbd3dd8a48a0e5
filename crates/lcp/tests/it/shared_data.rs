//! Every public contact and complementarity problem of moderate size.

use signorini_lcp::{
    Lemke, LemkeSettings, Method, NewtonMap, PrincipalPivoting, PrincipalPivotingSettings, Psor, Refusal,
    SemismoothNewton, SemismoothNewtonSettings, Solution, Status, infeasibility, solve_mixed,
};

use crate::contact_data::{files, folder, lcps, mixed};
use crate::support::{assert_honest, assert_proof};

/// Larger ones are for the example that prints the whole table.
const MAX_PAIRS: usize = 700;

/// A bimatrix game has A ≥ 0: every positive covering vector ends on a ray at once.
const NOT_FOR_LEMKE: &[&str] = &["lcp_CPS_3"];

fn expect(name: &str, expected: &str, solution: &Solution) {
    let ray = matches!(solution.status, Status::Ray(_) | Status::Infeasible(_));
    let as_expected = match expected {
        "solvable" => solution.status.is_solved(),
        "infeasible" => ray,
        _ => solution.status.is_solved() || ray,
    };
    let excused = NOT_FOR_LEMKE.contains(&name) && ray;
    assert!(
        as_expected || excused,
        "{name} ({expected}): {:?}, residual {:e}",
        solution.status,
        solution.residual.value
    );
}

#[test]
fn all_problems_with_a_solution_are_solved() {
    let Some(folder) = folder() else { return };
    let mut lemke = Lemke::new(LemkeSettings::default().with_tolerance(1e-8)).unwrap();
    let mut count = 0;
    for path in files(&folder).iter().chain(&files(&folder.join("synthetic"))) {
        for named in lcps(path, MAX_PAIRS) {
            let solution = lemke.solve(&named.problem, None);
            assert_honest(&named.problem, &solution, lemke.tolerance(), &named.name);
            expect(&named.name, &named.expected, &solution);
            if matches!(solution.status, Status::Ray(_)) {
                // Squeezed: provably infeasible. Jammed, or a game: only complementarity cannot be met.
                let proof = infeasibility(&named.problem.clone().into());
                assert_eq!(proof.is_some(), named.expected == "infeasible", "{}", named.name);
                proof.iter().for_each(|proof| assert_proof(&named.problem, proof, &named.name));
            }
            count += 1;
        }
        if let Some(named) = mixed(path) {
            let solution = solve_mixed(&named.problem, &mut lemke, None);
            expect(&named.name, &named.expected, &solution);
            assert!(named.problem.residual(&solution.z).within(lemke.tolerance()), "{}", named.name);
            count += 1;
        }
    }
    assert!(count > 150, "only {count} problems read");
}

/// Larger ones take the other methods too long for a test.
const MAX_PAIRS_OF_OTHERS: usize = 120;

#[test]
fn relaxation_refuses_every_contact_problem_with_friction() {
    let Some(folder) = folder() else { return };
    let mut count = 0;
    for path in files(&folder).iter().chain(&files(&folder.join("synthetic"))) {
        for named in lcps(path, MAX_PAIRS_OF_OTHERS) {
            // Contact problems come with units of their own; the others are general LCPs.
            let contact = named.problem.scaling().w().iter().any(|w| *w != 1.0);
            let solution = Psor::default().solve(&named.problem, None);
            assert_honest(&named.problem, &solution, 1e-10, &named.name);
            if contact && !solution.status.is_solved() {
                assert!(matches!(solution.status, Status::Refused(Refusal::Diagonal { .. })), "{}", named.name);
                count += 1;
            }
        }
    }
    assert!(count > 80, "only {count} refused");
}

#[test]
fn the_other_methods_are_honest_on_all_problems() {
    let Some(folder) = folder() else { return };
    let newton = |map| {
        let settings = SemismoothNewtonSettings::default().with_tolerance(1e-8).with_map(map);
        Box::new(SemismoothNewton::new(settings).unwrap()) as Box<dyn Method>
    };
    let settings = PrincipalPivotingSettings::default().with_tolerance(1e-8);
    let principal = Box::new(PrincipalPivoting::new(settings).unwrap()) as Box<dyn Method>;
    let methods =
        [("principal", principal), ("φ", newton(NewtonMap::FischerBurmeister)), ("min", newton(NewtonMap::Minimum))];
    for (label, mut method) in methods {
        let (mut solved, mut count) = (0, 0);
        for path in files(&folder).iter().chain(&files(&folder.join("synthetic"))) {
            for named in lcps(path, MAX_PAIRS_OF_OTHERS) {
                let solution = method.solve(&named.problem, None);
                let name = format!("{label} on {}", named.name);
                assert_honest(&named.problem, &solution, method.tolerance(), &name);
                let impossible = matches!(solution.status, Status::Infeasible(_)) && named.expected == "solvable";
                assert!(!impossible, "{name}");
                assert!(!(solution.status.is_solved() && named.expected == "infeasible"), "{name}");
                solved += usize::from(solution.status.is_solved());
                count += 1;
            }
        }
        println!("{label}: {solved} of {count}");
        assert!(solved * 5 > count, "{label}: {solved} of {count}");
    }
}
