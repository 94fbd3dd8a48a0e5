//! Tests of the public interface.

mod random_model;

mod identities;
