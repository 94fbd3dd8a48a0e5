//! Does it stand? Verdicts on configurations at rest, each with a proof that others can check.
//!
//! [`stability`] asks a model in a state; [`judge`] asks a [`ContactProblem`](signorini_contact::ContactProblem) at rest. The verdicts, what
//! proves them and the judges of the proofs are in [`signorini_contact::statics`], below which nothing is solved.
//!
//! ```
//! use signorini_multibody::{Geometry, Input, ModelBuilder, State};
//! use signorini_statics::{StabilitySettings, Verdict, stability};
//!
//! let mut world = ModelBuilder::new("a ball on a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.1]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let model = world.build()?;
//! let found = stability(&model, &State::new(&model), &Input::default(), &StabilitySettings::default())?;
//! assert_eq!(found.stability.verdict(), Verdict::Stays);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attraction;
mod balance;
mod batch;
mod blocks;
mod circular;
mod configuration;
mod conic;
mod enumeration;
mod family;
mod impulses;
mod interior;
mod mechanism;
mod model;
mod motion_limit;
mod motors;
mod normal_system;
mod outline;
mod question;
mod ranges;
mod report;
mod safety;
mod search;
mod settings;
mod verdict;
mod worst;

pub use attraction::Attraction;
pub use batch::{Placement, placements};
pub use blocks::{Assembly, Block};
pub use circular::CircularSafety;
pub use configuration::{Configuration, stability};
pub use model::ModelStability;
pub use motion_limit::MotionLimit;
pub use motors::held_by_motors;
pub use question::SafetyQuestion;
pub use ranges::ForceRange;
pub use report::{BodyMotion, ContactForce};
pub use safety::{Safety, safety};
pub use search::SearchRun;
pub use settings::StabilitySettings;
pub use signorini_contact::statics::{StabilityProof, StaysProof, Verdict};
pub use verdict::{Stability, judge};
pub use worst::{CriticalBody, Sideload, WorstDirection};
