//! A contact problem from matrices of one's own, without a model:
//! `cargo run --release -p signorini --example own_contact_problem`.

use signorini::contact::{ContactProblem, ContactSolver, FrictionPolygon, SolverSettings, certify};
use signorini::multibody::BlockDiagonal;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A particle of 2 kg with the coordinates (height, x, y), 2 cm above a plane. Without contact it would have this velocity:
    let mass = BlockDiagonal::from_dense(3, &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0])?;
    let (free_velocity, timestep, gap, friction) = (vec![-2.0, 3.0, 0.0], 0.1, 0.02, 0.25);
    let mut problem = ContactProblem::new(mass, free_velocity, timestep)?;

    // Columns of the contact Jacobian: for each coordinate its part in the normal and in the two tangential velocities.
    let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
    problem.push_contact(columns, gap, friction, &FrictionPolygon::regular(16, 0.0)?);
    problem.check()?;

    let solution = ContactSolver::new(SolverSettings::default())?.solve(&problem, None);
    println!("{:?}: v = {:?}, impulse {:?} N·s", solution.status, solution.velocity, solution.impulse[0]);

    // By hand: the normal impulse lets the gap close and no more, v_N = −φ/Δt, and friction takes μ λ_N / m of the 3 m/s.
    let normal = 2.0 * (2.0 - gap / timestep);
    let sliding = 3.0 - friction * normal / 2.0;
    assert!((solution.impulse[0][0] - normal).abs() < 1e-12);
    assert!((solution.velocity[0] + gap / timestep).abs() < 1e-12 && (solution.velocity[1] - sliding).abs() < 1e-12);

    // The certificate knows the problem and the claimed solution, and nothing of how it was found.
    assert!(certify(&problem, &solution).holds(1e-12));
    Ok(())
}
