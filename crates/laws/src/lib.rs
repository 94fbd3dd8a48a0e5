//! Laws of contact beside the polygon's, and what a solution leaves open: clients of the structured solver.
//!
//! - [`CircularConeSolver`], [`DirectionRefiner`]: Coulomb's law with the circular cone (formulation §9)
//! - [`ConvexRelaxation`]: Anitescu's relaxation, another model with a result type of its own
//! - [`SettlingSolver`]: convex steps to rest
//! - [`gap_contradiction`]: the proof that gaps contradict each other
//! - [`force_distributions`], [`LeastNorm`]: all impulses that give the same velocity, and those of least norm
//!
//! ```
//! use signorini_contact::{ContactProblem, FrictionPolygon};
//! use signorini_multibody::BlockDiagonal;
//! use signorini_laws::CircularConeSolver;
//!
//! // A particle of 1 kg with coordinates (height, x, y) that would fall with 2 m/s and slide with 3 m/s, μ = 1/4, on a plane.
//! let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
//! let mut problem = ContactProblem::new(mass, vec![-2.0, 3.0, 0.0], 0.01)?;
//! let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
//! problem.push_contact(columns, 0.0, 0.25, &FrictionPolygon::regular(4, 0.0)?);
//!
//! // Along (2, 1) no direction of the square points: the cone's friction opposes the slip, the polygon's does not.
//! problem.free_velocity[2] = 1.5;
//! let solution = CircularConeSolver::default().solve(&problem, None);
//! let (vx, vy) = (solution.velocity[1], solution.velocity[2]);
//! assert!((vx - 2.0 * vy).abs() < 1e-9 && (3.0_f64.hypot(1.5) - vx.hypot(vy) - 0.5).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cone;
mod contradiction;
mod indeterminacy;
mod polyhedral;
mod relaxation;
mod settling;

pub use cone::{CircularConeSolver, ConeSettings, DirectionRefiner, RefinementReport, align_directions};
pub use contradiction::gap_contradiction;
pub use indeterminacy::{
    ForceDistributions, ImpulseRange, LeastNorm, LeastNormOutcome, LeastNormReport, LinearProgramResidual, SelfStress,
    force_distributions, least_norm_impulses,
};
pub use relaxation::{
    ConvexRelaxation, RelaxationCertificate, RelaxationReport, RelaxationStatus, RelaxedSolution, certify_relaxation,
};
pub use settling::{SettlingEffort, SettlingSolver, SettlingStep};
