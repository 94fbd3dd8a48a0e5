//! Scenes that all engines run with the same numbers, and how ours runs them.

mod batch;
mod motors;
mod run;
mod scenes;
mod settle;

pub use batch::{BatchTask, hash_of};
pub use motors::Motors;
pub use run::{Contact, Run, Snapshot, drive};
pub use scenes::{Scene, build, field};
pub use settle::{Settled, settle};
