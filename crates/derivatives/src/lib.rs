//! Derivatives of a time step through contact, with a flag that says whether they exist.
//!
//! A step solves its laws exactly, so it has exact derivatives. At its solution each contact is open, sticks, or slides at a corner or along an
//! edge of its friction polygon; each limit holds or not; each dry friction holds or gives. While these modes stay, the velocity at the end
//! is the solution of a linear system,
//!
//! ```text
//! M̂ (v⁺ − v) − Δt (…) − N z = 0,      C v⁺ + c = 0,
//! ```
//!
//! whose rows `C` are the motions that the modes hold and whose columns `N` the impulses that hold them. Differentiated implicitly,
//!
//! ```text
//! ⎡ M̂  −N ⎤ ⎡ δv⁺ ⎤     ⎡ ∂E δx              ⎤
//! ⎣ C   0 ⎦ ⎣ δz  ⎦ = − ⎣ ∂(C v⁺ + c) δx     ⎦ ,
//! ```
//!
//! where `E` is the momentum balance with the impulses at hand. `∂E` comes from the derivatives of inverse dynamics
//! ([`signorini_multibody::derivatives`]), `∂(C v⁺ + c)` and the turning of the impulses from how contact points, normals and gaps move with the
//! bodies. Contacts may be redundant: then the impulses are not unique and `v⁺` is, and what is needed of the impulses is the same for all of
//! them.
//!
//! [`StepDerivatives::with_parameters`] adds columns for numbers of the model, such as masses and coefficients of friction ([`ScalarParameter`]).
//!
//! [`StepDerivatives::validity`] says what the result is worth. [`Validity::Exact`]: every inequality of the step holds by a margin, and the
//! margins are there as numbers. [`Validity::OneSided`]: some are about to turn, and say which. [`Validity::Refused`]: the velocity is not
//! unique, the step missed its tolerance, or something in it has no derivative; then there are no matrices.
//!
//! ```
//! use signorini_derivatives::{StepDerivatives, Validity};
//! use signorini_multibody::{Geometry, Input, ModelBuilder, State};
//! use signorini_simulation::{Settings, Workspace, step};
//!
//! let mut world = ModelBuilder::new("ball above a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 1.0]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let model = world.build()?;
//! let (state, input, settings) = (State::new(&model), Input::default(), Settings::default());
//!
//! let mut workspace = Workspace::new(&model, &settings)?;
//! let mut next = state.clone();
//! let report = step(&model, &state, &input, &settings, &mut workspace, &mut next)?;
//! let mut derivatives = StepDerivatives::new(&model);
//! derivatives.compute(&model, (&state, &input), &settings, &report, &mut workspace);
//!
//! assert_eq!(*derivatives.validity(), Validity::Exact);
//! let a = derivatives.state_matrix().expect("an exact derivative");
//! // Height by height, and height by velocity.
//! assert_eq!((a[(2, 2)], a[(2, 6 + 2)]), (1.0, model.timestep));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod columns;
mod directional;
mod geometry;
pub mod identification;
mod integration;
mod interior;
mod matrix;
mod mode;
mod parameter;
mod products;
mod reduced;
mod redundancy;
mod rows;
mod simulated;
mod step;
mod system;
mod tie;
mod validity;

pub use parameter::{Direction, ScalarParameter};
pub use step::StepDerivatives;
pub use validity::{InequalityKind, InequalitySource, Margin, Validity};
