//! signorini: multibody dynamics with hard contact and dry friction, in which every time step is a linear complementarity
//! problem that is solved exactly and comes with a certificate.
//!
//! ```
//! use signorini::prelude::*;
//!
//! let mut world = ModelBuilder::new("ball on a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.1]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//!
//! let mut simulation = Simulation::new(world.build()?, Settings::default())?;
//! simulation.run(0.2, |_, report| {
//!     assert!(report.certificate.holds(1e-9));
//!     true
//! })?;
//!
//! let force: f64 = simulation.contact_forces().map(|(_, force)| force.z).sum();
//! assert!((force - 9.81).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! This crate is a façade: it has no code but [`prelude`], and shows those below it under one name. The way through the engine, one
//! module or crate for each arrow:
//! model file → [`Model`](multibody::Model) → [`State`](multibody::State) → contact points → [`ContactProblem`](contact::ContactProblem)
//! → solution and [`Certificate`](contact::Certificate) → next state → [`recording`].
//!
//! # Features
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `formats` | yes | `formats`: models from URDF, MJCF and SDF files, with a report of what was not taken over |
//! | `viewer` | no | `viewer`: a simulation in the browser while it runs |
//!
//! Programs for all that a robotics person asks for first are in
//! [`examples/`](https://github.com/signorini/signorini/tree/main/crates/signorini/examples); each is run in CI.

pub mod prelude;

pub use signorini_collision as collision;
pub use signorini_derivatives as derivatives;
#[cfg(feature = "formats")]
pub use signorini_formats as formats;
pub use signorini_lcp as lcp;
pub use signorini_multibody as multibody;
pub use signorini_recording as recording;
#[cfg(feature = "render")]
pub use signorini_render as render;
pub use signorini_simulation::*;
pub use signorini_spec as spec;
pub use signorini_statics as statics;
#[cfg(feature = "viewer")]
pub use signorini_viewer as viewer;

/// Contact problems: the formulation, its certificates, the structured solver and the other laws of friction, in one place.
pub mod contact {
    pub use signorini_contact::*;
    pub use signorini_laws::*;
    pub use signorini_solver::*;
}
