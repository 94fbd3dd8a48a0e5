//! Seeded random contact problems, shared test data and dense linear algebra, for tests and benchmarks only.
//!
//! - [`families`]: contact problems from geometry (box, stack, pyramid, cluster, articulated tree, Painlevé rod, wedge,
//!   squeeze), each a function of a seeded [`Random`] and of [`Parameters`]
//! - [`suite`]: the list of problems that solvers are compared on, seed for seed the same as in other programs
//! - [`Parts`]: a problem taken apart, to be changed
//! - [`Scene`]: free rigid bodies with point contacts, for problems made by hand
//! - [`start_of`]: the state and the controls that a model begins with
//! - [`shared_data`]: where the data live that several projects share, with a message when they are absent
//! - [`mod@reference`]: the formulation in dense matrices, and a judge of solutions that shares no code with the certificate
//! - [`CountingAllocator`]: for tests of what must not allocate
//! - [`Dense`]: plain matrices that share no code with the crates under test

mod allocations;
mod articulated;
mod dense;
pub mod families;
mod parameters;
mod particle;
mod parts;
mod random;
pub mod reference;
mod scene;
mod shared;
mod start;
pub mod suite;

pub use allocations::{CountingAllocator, allocations, allocations_of_all_threads};
pub use articulated::articulated;
pub use dense::{Dense, largest_difference};
pub use families::Family;
pub use parameters::{Gap, Motion, Parameters};
pub use particle::particle;
pub use parts::{BilateralPart, ContactPart, GroupPart, Parts};
pub use random::Random;
pub use scene::{PointContact, RigidBody, Scene, tangents};
pub use shared::{files_in, shared_data};
pub use start::start_of;
