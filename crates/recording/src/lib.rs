//! Recordings: what a simulation did, step by step, as plain data.
//!
//! A recording is a [`Header`] (what was simulated and how it looks) and a sequence of [`Frame`]s
//! (where everything was, every contact with its impulse, and how well the step was solved). All
//! quantities are in SI units and world coordinates, z up; poses are
//! `[x, y, z, qw, qx, qy, qz]`, body frame to world.
//!
//! A run appends to a [`Writer`]; every frame reaches the file at once and carries its length and
//! checksum, so that a run that is killed leaves a readable prefix. [`Reader`] gives every complete
//! frame and says in [`Ending`] how the file ends. [`Recording`] holds the same in memory, and
//! [`report`] turns it into one HTML file that opens in any browser.
//!
//! # File format, schema version 1
//!
//! All numbers are little-endian.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `89 53 49 47 52 45 43 0A` (`\x89SIGREC\n`) |
//! | 4 | schema version, u32 |
//! | 4 | length of the header, u32 |
//! | 4 | CRC-32 of the header, u32 |
//! | … | the header: [`Header`] as JSON |
//! | … | records until the end of the file |
//!
//! A record is its payload's length (u32), the payload's CRC-32 (u32), and the payload, whose first
//! byte is 1 for a frame and 2 for the end of the run. The end holds the number of frames (u64) and
//! the reason as UTF-8 text. A frame holds, in this order:
//!
//! | type | content |
//! |---|---|
//! | u8 × 3 | status, missed tolerance (0 or 1), 0 |
//! | u32 | solver iterations |
//! | u64, f64 | step, time |
//! | f64 × 5 | residuals: momentum, natural map, Signorini, friction, dissipation |
//! | f64 × 2 | kinetic, potential energy |
//! | u32 × 5 | numbers of q, v, bodies, contacts, listed directions |
//! | f64 … | q, v, 7 per body pose, 2 per listed direction |
//! | 200 bytes per contact | u32 × 4: body A, body B, geom A, geom B; u32 × 3: mode (0 open, 1 sticking, 2 sliding, 3 between) and its directions; u32 × 3: polygon (0 regular, 1 listed), number of directions, first listed direction; f64 × 20: point, normal, tangent 1, tangent 2, gap, friction, λ_N, λ_T (2), c_T (2), angle of the first direction |

mod error;
mod frame;
mod header;
mod layout;
mod reader;
mod recording;
pub mod report;
mod writer;

pub use error::RecordingError;
pub use frame::{ContactFrame, ContactModeCode, Energy, Frame, FrictionPolygon, Pose, Residuals, StepStatus};
pub use header::{GeomVisual, Header, JointLabel, SCHEMA_VERSION, ShapeVisual};
pub use reader::{Ending, Reader};
pub use recording::Recording;
pub use writer::Writer;
