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
//! ```
//! use signorini_recording::{Frame, Header, Reader, Writer};
//!
//! let bodies = vec!["world".to_owned(), "cart".to_owned()];
//! let header = Header { nq: 1, nv: 1, timestep: 0.01, bodies, ..Header::default() };
//! let mut writer = Writer::new(Vec::new(), header)?;
//! for step in 0..3 {
//!     let x = 0.02 * step as f64;
//!     let body_poses = vec![[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]];
//!     writer.append(&Frame { step, q: vec![x], v: vec![2.0], body_poses, ..Frame::default() })?;
//! }
//! let bytes = writer.finish("reached the end")?;
//!
//! let mut reader = Reader::new("in memory", std::io::Cursor::new(bytes))?;
//! assert_eq!((reader.len(), reader.frame(2)?.q[0]), (3, 0.04));
//! # Ok::<(), signorini_recording::RecordingError>(())
//! ```
//!
//! # File format, schema version 6
//!
//! All numbers are little-endian; there is no padding but what is listed.
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
//! byte is 1 for a frame and 2 for the end of the run. The end holds after that byte the number of
//! frames (u64) and the reason as UTF-8 text. A frame holds n_q, n_v, n_b (bodies), n_c (contacts) and
//! n_d (listed directions) as it says at byte 80:
//!
//! | byte | type | content |
//! |---|---|---|
//! | 0 | u8 | 1 |
//! | 1 | u8 | status: 0 solved, 1 inaccurate, 2 ray, 3 infeasible, 4 iteration limit, 5 numerical failure |
//! | 2 | u8 | whether it missed the tolerance, 0 or 1 |
//! | 3 | u8 | what follows the contacts, a sum: 1 a solution, 2 activations, 4 stages |
//! | 4 | u32 | solver iterations |
//! | 8 | u64 | step |
//! | 16 | f64 | time, s |
//! | 24 | f64 × 5 | residuals: momentum, natural map (bilateral rows included), Signorini, friction, dissipation |
//! | 64 | f64 × 2 | kinetic, potential energy, J |
//! | 80 | u32 × 5 | n_q, n_v, n_b, n_c, n_d |
//! | 100 | f64 × n_q | q |
//! | … | f64 × n_v | v |
//! | … | f64 × 7 n_b | poses of the bodies |
//! | … | f64 × 2 n_d | listed directions |
//! | … | 200 bytes × n_c | contacts |
//! | … | u32, f64 … | number of activations, and these |
//! | … | u32, 12 bytes … | number of stages, and of each: index into the header's `stages`, asked, ended, u32 × 3 |
//! | … | … | the solution |
//!
//! | byte of a contact | type | content |
//! |---|---|---|
//! | 0 | u32 × 4 | body A, body B, geom A, geom B |
//! | 16 | u32 × 3 | mode: 0 open, 1 sticking, 2 sliding, 3 sliding between; its two directions |
//! | 28 | u32 × 3 | polygon: 0 regular, 1 listed; number of directions; first listed direction |
//! | 40 | f64 × 3 | point, m |
//! | 64 | f64 × 9 | normal, tangent 1, tangent 2 |
//! | 136 | f64 | gap, m |
//! | 144 | f64 | friction coefficient |
//! | 152 | f64 × 3 | λ_N, λ_T, N·s |
//! | 176 | f64 × 2 | c_T, m/s |
//! | 192 | f64 | angle of the first direction of a regular polygon, rad |
//!
//! | byte of a solution | type | content |
//! |---|---|---|
//! | 0 | u32 | sum of 1 where negative gaps were taken as zero, 2 where there is a θ, 4 where it applies to some rows only, and 8 where directions of friction groups are turned |
//! | 4 | u32 | phases: 1, or 2 with a decompression |
//! | 8 | u32 × 4 | numbers of controls, generalized forces, reaches, limits |
//! | 24 | f64 | θ, where there is one: the part of overlaps and violations that the step was permitted to remove |
//! | | u32 count, u32 each | contacts and limits, then rows of equality constraints, that θ applies to, where these are some only |
//! | | u32 count, u32 each, f64 × 2 each | numbers of directions of the friction groups, those of the decompression after those of the first phase, then these, where they are turned |
//! | … | f64 … | controls; generalized forces; reaches (2 per body: m, rad) |
//! | … | 32 or 56 bytes per limit | u32: 0 joint, 1 tendon; u32: its index; u32: 1 for the upper limit; u32: 1 where there is an axis; f64 × 2: gap, impulse; f64 × 3: the axis, where there is one |
//! | … | per phase | u32 × 7: lengths of v⁺, λ_N, α, β, λ_B, α_F, β_F; then these arrays as f64 |
//!
//! Directions of α are those of the contacts in order, limits have none. Schema version 1 had no solutions (byte 3 was
//! always 0), and no `laws` and `source` in the header; version 2 had no θ,
//! version 3 no stages, version 4 no directions of friction groups, version 5 no axes of limits and no directions of the groups of a
//! decompression. All can still be read.

mod error;
mod fields;
mod frame;
mod header;
mod layout;
mod looks;
mod provenance;
mod reader;
mod recording;
pub mod report;
mod solution;
mod solution_layout;
mod writer;

pub use error::RecordingError;
pub use frame::{
    ContactModeCode, Energy, Frame, PolygonCode, PoseArray, RecordedContact, Residuals, StageFrame, StepStatus,
};
pub use header::{GeomVisual, Header, JointLabel, SCHEMA_VERSION, ShapeVisual};
pub use looks::{CameraVisual, CheckerVisual, ImageFile, LightVisual, LookVisual, SpreadVisual, TextureVisual};
pub use provenance::{FrictionCode, ModelSource, RecordedChange, RestitutionCode, StepLaws};
pub use reader::{Ending, Reader, is_recording};
pub use recording::Recording;
pub use solution::{Impulses, LimitFrame, StepSolution};
pub use writer::Writer;
