//! Figures over a whole run.

use serde::Serialize;

use crate::frame::{Energy, Frame, StageFrame, StepStatus};

/// What the report's summary says; covers every frame, kept or not.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Run {
    pub frames: usize,
    pub first_time: f64,
    pub last_time: f64,
    pub missed_steps: usize,
    pub first_missed_step: Option<u64>,
    /// Frames whose status is not `Solved`.
    pub unsolved_steps: usize,
    pub last_status: &'static str,
    pub worst: [Worst; 5],
    pub contacts_max: usize,
    pub iterations_max: u32,
    /// Sums of what the solver's stages did, by their index; those asked at least once.
    pub stages: Vec<StageSum>,
    pub energy_start: [f64; 2],
    pub energy_end: [f64; 2],
}

/// The largest value of one residual, and the step that has it.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct Worst {
    /// `None` (null in JSON) when not finite.
    pub value: Option<f64>,
    pub step: u64,
}

/// What a stage of the solver did in all steps.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(super) struct StageSum {
    pub stage: u32,
    pub asked: u64,
    pub ended: u64,
    /// 0 where times were not measured.
    pub nanoseconds: u64,
}

impl Run {
    pub fn add(&mut self, frame: &Frame) {
        if self.frames == 0 {
            self.first_time = frame.time;
            self.energy_start = pair(&frame.energy);
            self.worst = [Worst { value: Some(0.0), step: frame.step }; 5];
        }
        self.frames += 1;
        self.last_time = frame.time;
        self.energy_end = pair(&frame.energy);
        self.last_status = status_name(frame.status);
        self.unsolved_steps += usize::from(frame.status != StepStatus::Solved);
        self.contacts_max = self.contacts_max.max(frame.contacts.len());
        self.iterations_max = self.iterations_max.max(frame.iterations);
        for stage in &frame.stages {
            self.add_stage(stage);
        }
        if frame.missed_tolerance {
            self.missed_steps += 1;
            self.first_missed_step.get_or_insert(frame.step);
        }
        for (worst, value) in self.worst.iter_mut().zip(residuals(frame)) {
            let exceeds = worst.value.is_some_and(|so_far| value > so_far || value.is_nan());
            if exceeds {
                *worst = Worst { value: value.is_finite().then_some(value), step: frame.step };
            }
        }
    }

    fn add_stage(&mut self, count: &StageFrame) {
        let place = self.stages.binary_search_by_key(&count.stage, |sum| sum.stage).unwrap_or_else(|place| {
            self.stages.insert(place, StageSum { stage: count.stage, ..StageSum::default() });
            place
        });
        let sum = &mut self.stages[place];
        sum.asked += u64::from(count.asked);
        sum.ended += u64::from(count.ended);
        sum.nanoseconds += count.nanoseconds;
    }
}

/// The five residuals in the order of [`Residuals`](crate::Residuals).
pub(super) fn residuals(frame: &Frame) -> [f64; 5] {
    let r = &frame.residuals;
    [r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation]
}

fn pair(energy: &Energy) -> [f64; 2] {
    [energy.kinetic, energy.potential]
}

fn status_name(status: StepStatus) -> &'static str {
    match status {
        StepStatus::Solved => "solved",
        StepStatus::Inaccurate => "inaccurate",
        StepStatus::Ray => "ray",
        StepStatus::Infeasible => "infeasible",
        StepStatus::IterationLimit => "iteration limit",
        StepStatus::NumericalFailure => "numerical failure",
    }
}
