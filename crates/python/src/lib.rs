//! The native half of the Python package `signorini`.
//!
//! Conversions only: every class holds something of the engine, every function calls one. What is Python's own (named
//! access, pickling, reports in notebooks) is in `python/signorini`. The types as Python sees them are in
//! `python/signorini/_core.pyi`.

mod arrays;
mod batch;
mod blocks;
mod contacts;
mod core;
mod counts;
mod data;
mod derivatives;
mod directions;
mod dynamics;
mod error;
mod frames;
mod generate;
mod guard;
mod identify;
mod lcp;
mod limits;
mod linear_system;
mod live;
mod looks;
mod model;
mod names;
mod parameters;
mod parts;
mod placements;
mod problem;
mod quantity;
mod queries;
mod recording;
mod render;
mod report;
mod settings;
mod simulations;
mod solution;
mod spec;
mod statics;
mod stepping;
mod support;
mod viewer;

use pyo3::prelude::*;

/// The native half of the package signorini.
#[pymodule]
mod _core {
    #[pymodule_export]
    use crate::batch::Batch;
    #[pymodule_export]
    use crate::blocks::Assembly;
    #[pymodule_export]
    use crate::contacts::{ContactSum, Contacts, Limits};
    #[pymodule_export]
    use crate::data::Data;
    #[pymodule_export]
    use crate::derivatives::{Margin, StepDerivatives, derivatives};
    #[pymodule_export]
    use crate::directions::{parameter_values, with_parameters};
    #[pymodule_export]
    use crate::dynamics::{bias_force, difference, integrate, inverse, mass_matrix};
    #[pymodule_export]
    use crate::frames::{
        InverseKinematics, center_of_mass, center_of_mass_jacobian, frame_pose, inverse_kinematics, jacobian,
        jacobian_rate, operational_space_inertia,
    };
    #[pymodule_export]
    use crate::generate::{
        make_arch, make_heap, make_pallet, make_rough, make_stack, make_stairs, make_terrain, make_wall,
    };
    #[pymodule_export]
    use crate::identify::{IdentifiedValues, identify_parameters};
    #[pymodule_export]
    use crate::lcp::{LcpResult, lcp_methods, solve_lcp};
    #[pymodule_export]
    use crate::limits::{Safety, critical_bodies, safety};
    #[pymodule_export]
    use crate::linear_system::{LinearComplementaritySystem, linearize};
    #[pymodule_export]
    use crate::looks::with_images;
    #[pymodule_export]
    use crate::model::{ImportWarning, Model};
    #[pymodule_export]
    use crate::parameters::parameter_table;
    #[pymodule_export]
    use crate::parts::{Actuator, Body, Geom, Joint, Keyframe};
    #[pymodule_export]
    use crate::placements::{Placements, placements};
    #[pymodule_export]
    use crate::problem::ContactProblem;
    #[pymodule_export]
    use crate::queries::{ContactPoint, Nearest, RayHit, cast_ray, cast_rays, contacts_at, distance, overlaps};
    #[pymodule_export]
    use crate::recording::{Recording, RecordingCheck};
    #[pymodule_export]
    use crate::render::{Film, Renderer, View, save_png};
    #[pymodule_export]
    use crate::report::{Certificate, SettleReport, StageCount, StageRun, StepReport};
    #[pymodule_export]
    use crate::solution::ContactSolution;
    #[pymodule_export]
    use crate::spec::Spec;
    #[pymodule_export]
    use crate::statics::{Stability, stability};
    #[pymodule_export]
    use crate::stepping::{forward, kinematics, settle, step};
    #[pymodule_export]
    use crate::support::{support_polygon, zero_moment_point};
    #[pymodule_export]
    use crate::viewer::Viewer;
    #[allow(unused_imports)]
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::guard::loaded();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
