//! Many simulations of one model at once, on threads.

use std::sync::{Arc, Mutex, PoisonError};

use signorini_multibody::{Input, Model, State};

use crate::step::{StepReport, Workspace, step};
use crate::{Settings, SimulationError};

/// One of the simulations.
struct Lane {
    workspace: Workspace,
    state: State,
    next: State,
    input: Input,
    report: StepReport,
    /// Why the last call ended early, if it did.
    stop: Option<LaneStop>,
}

/// Why a simulation of a batch did not make all its steps.
#[derive(Debug)]
pub enum LaneStop {
    /// A step has no solution; the state is the one before it and the report tells which contacts contradict each other.
    NoSolution,
    /// The state or input is malformed.
    Error(SimulationError),
}

/// Independent simulations of one model, each with its state and input.
///
/// Every simulation makes the same steps with the same bits as alone, however many threads there are.
pub struct Batch {
    model: Arc<Model>,
    settings: Settings,
    lanes: Vec<Lane>,
    threads: usize,
}

impl Batch {
    /// `count` simulations at the model's reference configuration, at rest.
    ///
    /// - `threads`: at most so many work at once; 0 for as many as the machine runs at once
    ///
    /// # Errors
    /// [`SimulationError`] if a setting is out of its range or a shape cannot be prepared.
    pub fn new(
        model: impl Into<Arc<Model>>,
        settings: Settings,
        count: usize,
        threads: usize,
    ) -> Result<Self, SimulationError> {
        let model = model.into();
        let available = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { available } else { threads };
        let lane = |_| {
            let (workspace, state) = (Workspace::new(&model, &settings)?, State::new(&model));
            let (next, input, report) = (state.clone(), Input::default(), StepReport::default());
            Ok(Lane { workspace, state, next, input, report, stop: None })
        };
        let lanes = (0..count).map(lane).collect::<Result<_, SimulationError>>()?;
        Ok(Self { model, settings, lanes, threads })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Number of simulations.
    pub fn len(&self) -> usize {
        self.lanes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.lanes.is_empty()
    }

    /// Time step, s.
    pub fn timestep(&self) -> f64 {
        self.settings.timestep.unwrap_or(self.model.timestep)
    }

    /// State of simulation `i`.
    pub fn state(&self, i: usize) -> &State {
        &self.lanes[i].state
    }

    /// State of simulation `i`, to be changed; it is checked at the next step.
    pub fn state_mut(&mut self, i: usize) -> &mut State {
        &mut self.lanes[i].state
    }

    /// What acts on simulation `i` in the next steps.
    pub fn input_mut(&mut self, i: usize) -> &mut Input {
        &mut self.lanes[i].input
    }

    /// How the last step of simulation `i` went.
    pub fn report(&self, i: usize) -> &StepReport {
        &self.lanes[i].report
    }

    /// Why simulation `i` did not make all steps of the last call, if it did not.
    pub fn stop(&self, i: usize) -> Option<&LaneStop> {
        self.lanes[i].stop.as_ref()
    }

    /// Forgets the last solution of simulation `i`, so that its next step starts cold.
    pub fn clear_warm_start(&mut self, i: usize) {
        self.lanes[i].workspace.clear_warm_start();
    }

    /// Makes `steps` steps of every simulation. One that stops early leaves the others going; whether none did.
    pub fn step(&mut self, steps: u64) -> bool {
        let nothing = vec![(); self.len()];
        self.for_each(nothing, |lane, (), model, settings| {
            (0..steps).all(|_| lane.step(model, settings));
        })
    }

    /// Makes `steps` steps of every simulation with given controls, and records the states after each. One that stops early
    /// leaves the others going, and the rest of its record is NaN; whether none did.
    ///
    /// - `controls`: `[n, steps, nu]`; empty leaves every input as it is
    /// - `q`, `v`: out, `[n, steps, nq]` and `[n, steps, nv]`
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn rollout(&mut self, steps: usize, controls: &[f64], q: &mut [f64], v: &mut [f64]) -> bool {
        let (count, nq, nv, nu) = (self.len(), self.model.nq, self.model.nv, self.model.actuators.len());
        assert!(controls.is_empty() || controls.len() == count * steps * nu, "controls must be [n, steps, nu]");
        assert!(q.len() == count * steps * nq && v.len() == count * steps * nv, "q and v must be [n, steps, nq or nv]");
        q.fill(f64::NAN);
        v.fill(f64::NAN);
        let records = parts_mut(q, count).into_iter().zip(parts_mut(v, count)).enumerate().collect();
        self.for_each(records, |lane, (i, (q, v)), model, settings| {
            for k in 0..steps {
                if !controls.is_empty() {
                    let start = (i * steps + k) * nu;
                    lane.input.control.clear();
                    lane.input.control.extend_from_slice(&controls[start..start + nu]);
                }
                if !lane.step(model, settings) {
                    break;
                }
                q[k * nq..(k + 1) * nq].copy_from_slice(&lane.state.q);
                v[k * nv..(k + 1) * nv].copy_from_slice(&lane.state.v);
            }
        })
    }

    /// Hands the simulations to the threads one by one, each with its item; whether none of them stopped.
    fn for_each<T: Send>(&mut self, items: Vec<T>, work: impl Fn(&mut Lane, T, &Model, &Settings) + Sync) -> bool {
        let threads = self.threads.min(self.lanes.len());
        let (model, settings) = (&*self.model, &self.settings);
        let queue = Mutex::new(self.lanes.iter_mut().zip(items));
        let run = || {
            loop {
                let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((lane, item)) = next else { break };
                lane.stop = None;
                work(lane, item, model, settings);
            }
        };
        if threads <= 1 {
            run();
        } else {
            std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(run))));
        }
        self.lanes.iter().all(|lane| lane.stop.is_none())
    }
}

/// A slice in `count` parts of equal length, which may be 0.
fn parts_mut(mut slice: &mut [f64], count: usize) -> Vec<&mut [f64]> {
    let size = slice.len() / count.max(1);
    let mut parts = Vec::with_capacity(count);
    for _ in 0..count {
        let (part, rest) = slice.split_at_mut(size);
        parts.push(part);
        slice = rest;
    }
    parts
}

impl Lane {
    /// Makes one step; whether the state was advanced.
    fn step(&mut self, model: &Model, settings: &Settings) -> bool {
        match step(model, &self.state, &self.input, settings, &mut self.workspace, &mut self.next) {
            Ok(report) => {
                self.report = report;
                if self.report.advanced() {
                    std::mem::swap(&mut self.state, &mut self.next);
                } else {
                    self.stop = Some(LaneStop::NoSolution);
                }
            }
            Err(error) => self.stop = Some(LaneStop::Error(error)),
        }
        self.stop.is_none()
    }
}
