//! Every step of a recording, certified again.

use std::sync::Arc;

use signorini_contact::Certificate;
use signorini_multibody::Model;
use signorini_recording::{Frame, StepStatus};
use signorini_simulation::{CertifiedLaw, FrictionLaw, Recertifier, StepCheck, StepFault};

use crate::{FrameSource, ReplayError};

/// Violations that are listed; the others are counted.
const LISTED: usize = 20;

/// What checking a recording found.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RecordingCheck {
    /// Frames read.
    pub frames: usize,
    /// Steps certified.
    pub certified: usize,
    /// Steps that violate a law or say something that does not follow.
    pub violated: usize,
    /// The first of them.
    pub violations: Vec<Violation>,
    /// The friction law of the certificates.
    pub law: CertifiedLaw,
    /// Largest residual of each law.
    pub worst: Certificate,
    /// The same of the circular cone's laws, where directions were refined or the law is that.
    pub worst_cone: Option<Certificate>,
    /// The step with the largest residual.
    pub worst_step: u64,
    /// Steps that were permitted to remove a part θ of overlaps and violations only.
    pub limited: usize,
    /// Steps in which negative gaps were taken as zero.
    pub clipped: usize,
    /// Steps that do not begin where the one before ended: the state was set from outside, or frames were left out.
    pub restarts: Vec<u64>,
}

impl RecordingCheck {
    /// Whether there are steps and all of them hold.
    pub fn holds(&self) -> bool {
        self.certified > 0 && self.violated == 0
    }
}

/// A step that does not hold.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Violation {
    /// Number of the step.
    pub step: u64,
    /// Time at its beginning, s.
    pub time: f64,
    /// Its largest residual; none where it could not be certified.
    pub residual: Option<f64>,
    /// What in it does not follow.
    pub fault: Option<StepFault>,
}

/// Certifies every step again.
///
/// - `model`: the recorded one; see [`rebuild`](crate::rebuild)
/// - `tolerance`: largest residual of a step that holds; of the circular cone's laws under refined directions, the tolerance of
///   the run where that is larger
///
/// # Errors
/// [`ReplayError::Simulation`] if the model is another one or the recording has no solutions, [`ReplayError::Recording`] if a
/// frame cannot be read.
pub fn check(
    frames: &mut impl FrameSource,
    model: impl Into<Arc<Model>>,
    tolerance: f64,
) -> Result<RecordingCheck, ReplayError> {
    let mut recertifier = Recertifier::new(model, frames.header())?;
    let cone_tolerance = match recertifier.settings().friction_law {
        FrictionLaw::Refined { tolerance } => tolerance,
        _ => 0.0,
    };
    let count = frames.count();
    let mut result = RecordingCheck { frames: count, ..RecordingCheck::default() };
    let mut largest = -1.0;
    let mut follows = false;
    let mut stopped: Option<Frame> = None;
    frames.visit(&mut |i, frame| {
        if follows && !recertifier.leads_to(frame) {
            result.restarts.push(frame.step);
        }
        follows = false;
        if let Some(denied) = stopped.take().filter(|denied| !is_same_state(denied, frame)) {
            result.violate(&denied, None, Some(StepFault::NoSolution));
        }
        let last = i + 1 == count;
        if frame.solution.phases == 0 && last && (frame.status != StepStatus::Solved || frame.contacts.is_empty()) {
            return Ok(()); // The state that a run ended in, or the step that it could not make.
        }
        if frame.solution.phases == 0 && matches!(frame.status, StepStatus::Ray | StepStatus::Infeasible) {
            stopped = Some(frame.clone()); // A step that could not be made leaves the state as it was.
            return Ok(());
        }
        match recertifier.check(frame) {
            Ok(step) => {
                follows = true;
                result.certified += 1;
                result.limited += usize::from(frame.solution.theta.is_some());
                result.clipped += usize::from(frame.solution.clipped_gaps);
                if residual(&step) > largest {
                    (largest, result.worst_step) = (residual(&step), frame.step);
                }
                result.add(&step);
                if !step.holds(tolerance, cone_tolerance) {
                    result.violate(frame, Some(residual(&step)), step.fault);
                }
            }
            Err(fault) => result.violate(frame, None, Some(fault)),
        }
        Ok(())
    })?;
    Ok(result)
}

/// Whether two frames are of one state.
fn is_same_state(a: &Frame, b: &Frame) -> bool {
    a.time == b.time && a.q == b.q && a.v == b.v && a.activation == b.activation
}

/// The largest residual of a step by the law of its run.
fn residual(step: &StepCheck) -> f64 {
    step.certificate.worst()
}

impl RecordingCheck {
    fn add(&mut self, step: &StepCheck) {
        self.law = step.law;
        self.worst.merge(&step.certificate);
        if let Some(cone) = &step.cone_certificate {
            self.worst_cone.get_or_insert_default().merge(cone);
        }
    }

    fn violate(&mut self, frame: &Frame, residual: Option<f64>, fault: Option<StepFault>) {
        self.violated += 1;
        if self.violations.len() < LISTED {
            self.violations.push(Violation { step: frame.step, time: frame.time, residual, fault });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use signorini_recording::{Header, Reader, Recording, Writer};
    use signorini_simulation::{InfeasiblePolicy, RunRecorder, Settings, Simulation, recording_header};

    use super::*;

    /// A cart between a stop and the end of its rail, which leave it no room: two steps, and that it cannot be made.
    fn stopped() -> (Model, Header, Vec<Frame>) {
        let text = r#"<mujoco><compiler angle="radian" autolimits="true"/><worldbody>
            <geom type="box" size=".1 .1 .1" pos="-.19 0 0"/>
            <body><joint type="slide" axis="1 0 0" range="-1 -.05"/><geom size=".1" mass="1"/></body></worldbody></mujoco>"#;
        let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
        let settings = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        // Away from the limit two steps can be made.
        let start = simulation.state().clone();
        let mut clear = start.clone();
        clear.q[0] = -0.5;
        clear.v[0] = 0.01;
        simulation.set_state(&clear).unwrap();
        let header = recording_header(simulation.model(), simulation.settings(), simulation.workspace());
        let mut recorder = RunRecorder::new(Writer::new(Vec::new(), header.clone()).unwrap());
        for _ in 0..2 {
            assert!(simulation.step().unwrap().advanced());
            recorder.add(&simulation).unwrap();
        }
        simulation.set_state(&start).unwrap();
        assert!(!simulation.step().unwrap().advanced());
        recorder.add(&simulation).unwrap();
        let bytes = recorder.finish(&simulation, "no solution").unwrap();
        let mut reader = Reader::new("in memory", Cursor::new(bytes)).unwrap();
        let frames = (0..reader.len()).map(|i| reader.frame(i).unwrap()).collect();
        (model, header, frames)
    }

    fn recording(header: &Header, frames: &[Frame]) -> Recording {
        let mut recording = Recording::new(header.clone()).unwrap();
        frames.iter().for_each(|frame| recording.push(frame.clone()).unwrap());
        recording
    }

    /// The step that could not be made leaves the state as it was, which a final frame tells; a state that has moved there does not follow.
    #[test]
    fn a_run_that_stopped_holds_up_to_where_it_stopped() {
        let (model, header, frames) = stopped();
        assert_eq!(frames.len(), 4);
        let found = check(&mut &recording(&header, &frames), model.clone(), 1e-9).unwrap();
        assert!(found.holds() && found.certified == 2, "{found:?}");
        let mut moved = frames.clone();
        moved[3].q[0] += 0.01;
        let found = check(&mut &recording(&header, &moved), model, 1e-9).unwrap();
        assert_eq!((found.violated, found.violations[0].step), (1, 2), "{found:?}");
    }
}
