//! Derivatives of the smooth dynamics: of the motion of bodies, of inverse dynamics, and of a step's momentum balance without contact.
//!
//! Configurations are varied in the tangent coordinates of [`integrate_into`](crate::integrate_into): `q ⊕ δ`, where rotations are multiplied
//! from the right, so that `δ` has the axes of `v`. A unit of `δ_k` then displaces all bodies that degree of freedom `k` carries by the
//! twist `S_k`, column `k` of their Jacobian, and everything follows from how twists move with twists.

mod balance;
mod coriolis;
mod curvature;
mod drive;
mod free_motion;
mod inverse_dynamics;
mod lengths;
mod parameters;

pub use balance::{BalanceDerivatives, Unsupported};
pub use curvature::LengthCurvature;
pub use drive::MarginSource;
pub use free_motion::balance_derivatives_into;
pub use inverse_dynamics::{InverseDynamicsDerivatives, inverse_dynamics_derivatives_into};
pub use parameters::{BalanceAt, BalanceChange, InertiaChange, JointChange};

pub use crate::motion::MotionDerivatives;
