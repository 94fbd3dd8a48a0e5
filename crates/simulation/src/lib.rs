//! The step and the run: from a model with its state to the next state, with the certificate of the contact problem that was solved.
//!
//! [`step`] is one step on one screen; [`Simulation`] owns what a run needs and repeats it.
//!
//! # What leaves every bit as it is
//!
//! With one build on one machine the same model, settings, state, input and warm start give the same bits: from run to run,
//! for any number of threads ([`SolverSettings::threads`](signorini_solver::SolverSettings::threads), [`Batch`]), alone or in a batch,
//! and in a run that goes on from a [`Snapshot`]. The order in which bodies and geoms are declared is part of the model, for
//! sums are rounded in it: bodies that nothing ties together do not feel it, within an island it changes the motion by rounding where the
//! velocity is unique. Where contacts leave the velocity open (a wedged box can slide either way), the order can choose. Other machines
//! and builds may round `sin` and sums differently.
//!
//! ```
//! use signorini_multibody::{Geometry, ModelBuilder};
//! use signorini_simulation::{Settings, Simulation};
//!
//! let mut world = ModelBuilder::new("ball on a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.1]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let mut simulation = Simulation::new(world.build()?, Settings::default())?;
//! for _ in 0..100 {
//!     let report = simulation.step()?;
//!     assert!(report.certificate.holds(1e-9));
//! }
//! assert!((simulation.state().q[2] - 0.1).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Numbers of the model can be others in a run, without compiling it anew:
//!
//! ```
//! # use signorini_multibody::{Geometry, ModelBuilder, Parameter};
//! # use signorini_simulation::{Settings, Simulation};
//! # let mut world = ModelBuilder::new("ball on a floor");
//! # world.floor();
//! # world.body("ball").at([0.0, 0.0, 0.1]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let mut simulation = Simulation::new(world.build()?, Settings::default())?;
//! simulation.change(&[(Parameter::BodyMass, &[0.0, 2.5]), (Parameter::Gravity, &[0.0, 0.0, -1.62])])?;
//! assert_eq!(simulation.model().bodies[1].inertia.mass, 2.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adhesion;
mod ahead;
mod along_lengths;
mod asleep;
mod assembly;
mod attempt;
mod batch;
mod build;
mod candidates;
mod contact_forces;
mod contact_sensors;
mod contradictions;
mod corrections;
mod divergence;
mod energy_bound;
mod error;
mod forces;
mod going_on;
mod held;
mod inverse;
mod last_step;
mod linear_system;
mod moving;
mod nearby;
mod overlaps;
mod parameters;
mod patches;
mod permitted;
mod phases;
mod put_in;
mod reach;
mod recertify;
mod recorder;
mod report;
mod rest;
mod restitution;
mod sensors;
mod settings;
mod settle;
mod simulation;
mod sleepers;
mod smallest_change;
mod snapshot;
mod solver;
mod source;
mod stabilization;
mod standing;
mod start_note;
mod step;
mod variation;
mod warm;
mod withheld;
mod workspace;

pub use batch::{Batch, LaneStop};
pub use build::Level;
pub use error::SimulationError;
pub use inverse::{InverseMotion, inverse_step};
pub use last_step::LastStep;
pub use linear_system::{
    LinearComplementaritySystem, LinearizedContacts, linear_complementarity_system, linear_complementarity_system_with,
};
pub use nearby::{support_polygon, zero_moment_point};
pub use overlaps::OverlapPolicy;
pub use recertify::{Recertifier, StepCheck, StepFault};
pub use recorder::{RunRecorder, frame_into, last_frame_into, recorded_model, recording_header, step_solution_into};
pub use report::{Kept, KeptRow, StepReport};
pub use sensors::{actuator_forces_into, contact_wrenches_into, sensors_into};
pub use settings::{ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, RestitutionLaw, Settings};
pub use settle::{SettleProgress, SettleReport, SettleSettings};
pub use simulation::{RunEnd, Simulation, Summary};
pub use snapshot::Snapshot;
pub use solver::CertifiedLaw;
pub use source::{ContactSource, FrictionSource};
pub use stabilization::StabilizedStep;
pub use standing::{RestProblem, rest_problem, rest_problem_at};
pub use step::{DrivenVelocity, step};
pub use variation::Variation;
pub use workspace::Workspace;
