//! What checking or converting a recording found.

use std::path::Path;

use serde::Serialize;
use signorini::CertifiedLaw;
use signorini::recording::{Ending, Reader};
use signorini_replay::RecordingCheck;

use super::{FileName, Laws};
use crate::solving::ContactLaw;

/// The result of `check` on a recording.
#[derive(Debug, Serialize)]
pub struct RecordingResult {
    /// The recording.
    pub recording: FileName,
    /// The model's name.
    pub model: String,
    /// Whether every step holds.
    pub ok: bool,
    /// A law holds when its residual is at most this.
    pub tolerance: f64,
    /// Gaps of at most this counted as closed, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_resolution: Option<f64>,
    /// The law of friction.
    pub law: ContactLaw,
    /// Complete frames.
    pub frames: usize,
    /// Steps certified.
    pub steps: usize,
    /// Largest residual of each law.
    pub worst: Laws,
    /// The same of the circular cone's laws, where the run asked for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_circular: Option<Laws>,
    /// The step with the largest residual.
    pub worst_step: u64,
    /// Steps that do not hold.
    pub violated_steps: usize,
    /// The first of them.
    pub violations: Vec<ViolatedStep>,
    /// Steps that were permitted to remove a part of overlaps and violations only.
    pub limited_steps: usize,
    /// Steps with penetrations taken as zero.
    pub clipped_steps: usize,
    /// Steps that do not begin where the one before ended.
    pub restarts: Vec<u64>,
    /// How the recording ends.
    pub ending: String,
}

/// A step that does not hold.
#[derive(Debug, Serialize)]
pub struct ViolatedStep {
    /// Its number.
    pub step: u64,
    /// Time at its beginning, s.
    pub time: f64,
    /// Its largest residual.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<f64>,
    /// What in it does not follow from model, state and solution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
}

impl RecordingResult {
    /// From what the check found.
    pub fn new<R: std::io::Read + std::io::Seek>(
        path: &Path,
        reader: &Reader<R>,
        tolerance: f64,
        found: &RecordingCheck,
    ) -> Self {
        let violations = found.violations.iter().map(|violation| ViolatedStep {
            step: violation.step,
            time: violation.time,
            residual: violation.residual,
            fault: violation.fault.as_ref().map(ToString::to_string),
        });
        Self {
            recording: path.into(),
            model: reader.header().model_name.clone(),
            ok: found.holds(),
            tolerance,
            gap_resolution: reader.header().laws.as_ref().map(|laws| laws.gap_resolution).filter(|d| *d > 0.0),
            law: match found.law {
                CertifiedLaw::Polygon => ContactLaw::Polygon,
                CertifiedLaw::CircularCone => ContactLaw::Circular,
            },
            frames: found.frames,
            steps: found.certified,
            worst: Laws::of_contacts(&found.worst, true),
            worst_circular: found.worst_cone.map(|cone| Laws::of_contacts(&cone, true)),
            worst_step: found.worst_step,
            violated_steps: found.violated,
            violations: violations.collect(),
            limited_steps: found.limited,
            clipped_steps: found.clipped,
            restarts: found.restarts.clone(),
            ending: ending(reader.ending()),
        }
    }
}

/// How a recording ends, in words.
pub fn ending(ending: &Ending) -> String {
    match ending {
        Ending::Finished { reason } => reason.clone(),
        Ending::Interrupted { leftover: 0 } => "interrupted after a whole frame".into(),
        Ending::Interrupted { leftover } => format!("interrupted {leftover} bytes into a frame"),
        Ending::Damaged { offset } => format!("damaged at byte {offset}; what follows was left out"),
    }
}
