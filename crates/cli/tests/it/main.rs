//! Runs the built command on models and problems that the tests write.

mod compare;
mod documents;
mod full_disk;
mod input;
mod inspect;
mod interrupt;
mod overwriting;
mod problems;
mod recordings;
mod reference;
mod runs;
mod solvers;
mod stability;
mod stops;
mod support;
mod unicode;
mod view;
