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

mod balance;
mod batch;
mod blocks;
mod conic;
mod enumeration;
mod impulses;
mod interior;
mod mechanism;
mod model;
mod motors;
mod normal_system;
mod report;
mod safety;
mod search;
mod settings;
mod verdict;

pub use batch::{Placement, placements};
pub use blocks::{Assembly, Block};
pub use model::{ModelStability, stability};
pub use motors::held_by_motors;
pub use report::{BodyMotion, ContactForce};
pub use safety::{Safety, SafetyQuestion, safety};
pub use search::SearchRun;
pub use settings::StabilitySettings;
pub use signorini_contact::statics::{StabilityProof, StaysProof, Verdict};
pub use verdict::{Stability, judge};
