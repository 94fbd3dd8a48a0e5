//! Contact points against closed forms, support functions and brute force.

mod allocation;
mod cross_check;
mod history;
mod invariance;
mod moving;
mod pairs;
mod queries;
mod random;
mod rays;
mod scene;
mod stacking;
mod step;
mod support;
mod surfaces;
mod triangles;
