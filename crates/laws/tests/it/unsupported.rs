//! Friction that a model does not have is refused by name, and nothing certifies what leaves it out.

use signorini_contact::{
    ConeSolution, ConeStatus, ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, ProblemError,
    SolveStatus, UnsupportedFriction, certify_cone, cone_gaps,
};
use signorini_laws::{
    CircularConeSolver, ConvexRelaxation, DirectionRefiner, LeastNorm, LeastNormOutcome, RelaxationStatus,
    certify_relaxation, force_distributions,
};
use signorini_lcp::{Enumeration, EnumerationSettings, Psor, Refusal};
use signorini_multibody::BlockDiagonal;
use signorini_solver::{ContactSolver, solve_as_lcp};

/// A point of 2 kg on a plane that slides along x.
fn sliding_point(polygon: &FrictionPolygon) -> ContactProblem {
    let mass = BlockDiagonal::from_dense(3, &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![0.1, 0.0, -0.02], 0.01).expect("valid data");
    let columns = [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.5, polygon);
    problem
}

fn with_group() -> ContactProblem {
    let mut problem = sliding_point(&FrictionPolygon::regular(8, 0.0).expect("even"));
    problem.push_friction_row([(0, 1.0)], 0.0, FrictionBound::Impulse(1e-3));
    problem
}

/// What the circular cone says without the refused part would be a solution of another problem.
#[test]
fn the_circular_cone_refuses_anisotropy() {
    let anisotropic = sliding_point(&FrictionPolygon::ellipse(8, [1.0, 0.5], 0.0).expect("positive"));
    let (mut problem, reason) = (anisotropic, UnsupportedFriction::Anisotropic { contact: 0 });
    assert_eq!(problem.check_circular(), Err(reason));
    let solution = CircularConeSolver::default().solve(&problem, None);
    assert_eq!(solution.status, ConeStatus::Unsupported(reason));
    assert_eq!((&solution.velocity, solution.impulse.len()), (&problem.free_velocity, 1));
    assert_eq!(certify_cone(&problem, &solution).worst(), f64::INFINITY);

    let mut refined = ContactSolution::default();
    let before = problem.directions.clone();
    let report =
        DirectionRefiner::default().refine(&mut ContactSolver::default(), &mut problem, None, 1e-6, 8, &mut refined);
    assert_eq!((report.unsupported, report.solves, report.converged), (Some(reason), 0, false));
    assert_ne!(refined.status, SolveStatus::Solved);
    let again = CircularConeSolver::default().refine_into(&mut problem, None, 1e-6, &mut refined);
    assert_eq!((again.unsupported, again.converged), (Some(reason), false));
    assert_eq!(problem.directions, before);
}

/// The polygon's own solution of these problems is one; as a solution of the circular cone it must not pass.
#[test]
fn no_cone_certificate_passes_what_it_leaves_out() {
    let problem = with_group();
    let exact = ContactSolver::default().solve(&problem, None);
    assert_eq!(exact.status, SolveStatus::Solved);
    let mut claimed = ConeSolution::default();
    (claimed.velocity, claimed.impulse) = (exact.velocity.clone(), exact.impulse);
    assert_eq!(certify_cone(&problem, &claimed).worst(), f64::INFINITY);

    // An anisotropic contact whose friction is not opposite to its slip has no gap to Coulomb's law, which is not its own.
    let mut skate = sliding_point(&FrictionPolygon::ellipse(16, [1.0, 0.2], 0.3).expect("positive"));
    skate.free_velocity[1] = 0.05;
    let solution = ContactSolver::default().solve(&skate, None);
    assert_eq!(solution.status, SolveStatus::Solved);
    assert_eq!(cone_gaps(&skate, &solution)[0].missing_impulse, 0.0);
}

#[test]
fn relaxation_and_distributions_refuse_groups() {
    let (problem, reason) = (with_group(), UnsupportedFriction::Groups { count: 1 });
    let relaxed = ConvexRelaxation::default().solve(&problem, 1e-9);
    assert_eq!(relaxed.status, RelaxationStatus::Unsupported(reason));
    assert_eq!(certify_relaxation(&problem, &relaxed).worst(), f64::INFINITY);
    assert_eq!(relaxed.contact_laws(&problem).worst(), f64::INFINITY);

    let mut solution = ContactSolver::default().solve(&problem, None);
    assert!(
        matches!(force_distributions(&problem, &solution), Err(ProblemError::Unsupported(found)) if found == reason)
    );
    let before = solution.impulse.clone();
    let report = LeastNorm::default().apply(&problem, &mut solution, 1e-9);
    assert_eq!(report.outcome, LeastNormOutcome::Unsupported(reason));
    assert_eq!(solution.impulse, before);
}

/// A method's refusal keeps its reason on the way through the contact problem.
#[test]
fn refusals_of_lcp_methods_keep_their_reason() {
    let problem = sliding_point(&FrictionPolygon::regular(4, 0.0).expect("even"));
    // The row of β, after λ_N and four α, has no diagonal entry.
    let refused = solve_as_lcp(&problem, &mut Psor::default(), 1e-9).expect("finite");
    assert_eq!(refused.status, SolveStatus::Refused(Refusal::Diagonal { row: 5, value: 0.0 }));
    let mut tiny = Enumeration::new(EnumerationSettings::default().with_max_pairs(3)).expect("valid");
    let refused = solve_as_lcp(&problem, &mut tiny, 1e-9).expect("finite");
    assert_eq!(refused.status, SolveStatus::TooLarge { limit: 3 });
}
