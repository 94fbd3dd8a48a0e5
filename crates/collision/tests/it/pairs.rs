//! Closed forms for pairs of shapes.
