//! Runs the built command on models and problems that the tests write.

mod input;
mod inspect;
mod problems;
mod runs;
mod stops;
mod support;
mod view;
