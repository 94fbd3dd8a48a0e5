//! Models that can be edited.
//!
//! A [`Model`](signorini_multibody::Model) never changes. A [`Spec`] does: parts are found by name, added, changed, removed, and whole models
//! are attached; [`Spec::compile`] gives the model and where every part is in it ([`Compiled`]).
//!
//! Parts are those of `signorini_multibody`. Their identifiers (`BodyId`, …) are those of the spec: they stay what they are while other
//! parts come and go, and in a spec that was made from a model they are the model's.
//!
//! ```
//! use signorini_multibody::{Geometry, Joint, ModelBuilder, Pose};
//! use signorini_spec::Spec;
//!
//! let mut world = ModelBuilder::new("arm");
//! world.body("arm").joint(Joint::hinge("shoulder", [0.0, 1.0, 0.0])).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let arm = Spec::from_model(&world.build()?);
//!
//! let mut spec = Spec::new("two arms");
//! spec.attach(&arm, "world", Pose::IDENTITY, "left ")?;
//! spec.attach(&arm, "world", [0.0, 1.0, 0.0].into(), "right ")?;
//! spec.joint_mut("left shoulder")?.damping = 0.5;
//! let compiled = spec.compile()?;
//! assert_eq!((compiled.model.nv, compiled.model.joints[0].damping), (2, 0.5));
//!
//! spec.remove_body("left arm")?;
//! let again = spec.compile()?;
//! assert_eq!((again.model.nv, again.joints[0], again.joints[1].map(|id| id.0)), (1, None, Some(0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adopt;
mod attach;
mod compile;
mod error;
mod keyframe;
mod parts;
mod references;
mod remove;
mod spec;
mod state;

pub use compile::Compiled;
pub use error::SpecError;
pub use keyframe::KeyframeSpec;
pub use spec::Spec;
pub use state::carry_state;
