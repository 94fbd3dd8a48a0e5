//! What is done with a recording after the run.
//!
//! - [`model_source`] and [`rebuild`]: the model's file goes into the header of a recording, and the model comes out again.
//! - [`check`]: every step is certified again, without any solver.
//! - [`export`]: NumPy arrays, a table, or an MCAP file for Foxglove.
//!
//! All of them read frame by frame from a [`FrameSource`]: a file, or a recording in memory.
//!
//! ```
//! use signorini_multibody::{Geometry, ModelBuilder};
//! use signorini_recording::{Reader, Writer};
//! use signorini_simulation::{RunRecorder, Settings, Simulation, recording_header};
//!
//! let mut world = ModelBuilder::new("ball on a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.1]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let model = world.build()?;
//! let mut simulation = Simulation::new(model.clone(), Settings::default())?;
//! let mut recorder = RunRecorder::new(Writer::new(Vec::new(), recording_header(&model, simulation.settings(), simulation.workspace()))?);
//! for _ in 0..20 {
//!     simulation.step()?;
//!     recorder.add(&simulation)?;
//! }
//! let bytes = recorder.finish(&simulation, "made 20 steps")?;
//!
//! let mut reader = Reader::new("in memory", std::io::Cursor::new(bytes))?;
//! let found = signorini_replay::check(&mut reader, model, 1e-9)?;
//! assert!(found.holds() && found.certified == 20);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod error;
pub mod export;
mod frames;
mod source;

pub use check::{RecordingCheck, Violation, check};
pub use error::ReplayError;
pub use frames::FrameSource;
pub use source::{model_source, read_model_source, rebuild};
