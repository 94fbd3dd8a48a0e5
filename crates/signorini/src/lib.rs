//! signorini: multibody dynamics with hard contact and dry friction, in which every time step is a linear complementarity
//! problem that is solved exactly and comes with a certificate.
//!
//! The way through the engine, one module or crate for each arrow:
//! model file → [`Model`](multibody::Model) → [`State`](multibody::State) → contact points → [`ContactProblem`](contact::ContactProblem)
//! → solution and [`Certificate`](contact::Certificate) → next state → [`recording`].
//!
//! [`step`] is one step on one screen; [`Simulation`] owns what a run needs and repeats it.
//!
//! # What leaves every bit as it is
//!
//! With one build on one machine the same model, settings, state, input and warm start give the same bits: from run to run,
//! for any number of threads ([`SolverSettings::threads`](contact::SolverSettings::threads), [`Batch`]), alone or in a batch,
//! and in a run that goes on from a [`Snapshot`]. The order in which bodies and geoms are declared is part of the model, for
//! sums are rounded in it: bodies that nothing ties together do not feel it, within an island it changes the motion by rounding where the
//! velocity is unique. Where contacts leave the velocity open (a wedged box can slide either way), the order can choose. Other machines
//! and builds may round `sin` and sums differently.
//!
//! ```
//! use signorini::multibody::{Geom, Geometry, Inertia, Joint, JointKind, BodyId, ModelBuilder, Pose};
//! use signorini::multibody::glam::{DMat3, DVec3};
//! use signorini::{Settings, Simulation};
//!
//! let mut b = ModelBuilder::new("ball on a floor");
//! let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::from_diagonal(DVec3::splat(0.004)) };
//! let ball = b.add_body("ball", BodyId::WORLD, Pose::from_position(DVec3::new(0.0, 0.0, 0.1)), inertia)?;
//! b.add_joint(ball, Joint::new("free", JointKind::Free))?;
//! b.add_geom(ball, Geom::new("skin", Geometry::Sphere { radius: 0.1 }))?;
//! b.add_geom(BodyId::WORLD, Geom::new("floor", Geometry::Plane))?;
//! let mut simulation = Simulation::new(b.build()?, Settings::default())?;
//! for _ in 0..100 {
//!     let report = simulation.step()?;
//!     assert!(report.certificate.holds(1e-9));
//! }
//! assert!((simulation.state().q[2] - 0.1).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assembly;
mod batch;
mod build;
mod error;
mod inverse;
mod linear_system;
mod phases;
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
mod snapshot;
mod solver;
mod source;
mod stabilization;
mod step;
mod variation;
mod warm;
mod workspace;

pub use batch::{Batch, LaneStop};
pub use error::SimulationError;
pub use inverse::{InverseMotion, inverse_step};
pub use linear_system::{LinearComplementaritySystem, linear_complementarity_system};
pub use recertify::{Recertifier, StepCheck, StepFault};
pub use recorder::{frame_into, last_frame_into, recording_header, step_solution_into};
pub use report::StepReport;
pub use sensors::{contact_wrenches_into, sensors_into};
pub use settings::{ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, RestitutionLaw, Settings};
pub use settle::{SettleProgress, SettleReport, SettleSettings};
pub use simulation::{RunEnd, Simulation, Summary};
pub use snapshot::Snapshot;
pub use solver::CertifiedLaw;
pub use source::{ContactSource, FrictionSource};
pub use stabilization::StabilizedStep;
pub use step::{DrivenVelocity, step};
pub use variation::Variation;
pub use workspace::Workspace;

pub use signorini_collision as collision;
pub use signorini_contact as contact;
pub use signorini_lcp as lcp;
pub use signorini_multibody as multibody;
pub use signorini_recording as recording;
