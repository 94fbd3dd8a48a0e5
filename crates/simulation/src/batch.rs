//! Many simulations of one model at once, on threads.

mod threads;

use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};
use signorini_multibody::{Input, Model, ParameterChange, State};

use self::threads::{Crew, for_each};
use crate::report::StepReport;
use crate::settings::ContactMethod;
use crate::{Settings, Simulation, SimulationError, Snapshot, Variation};

/// One of the simulations.
struct Lane {
    simulation: Simulation,
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

/// Independent simulations of one model, each with its state and input, and with parameters of its own where asked for.
///
/// Every simulation makes the same steps with the same bits as alone, however many threads there are. A step allocates
/// nothing after warm-up.
///
/// ```
/// # let mut b = signorini_multibody::ModelBuilder::new("ball on a floor");
/// # b.floor().body("ball").at([0.0, 0.0, 0.1]).free().solid(signorini_multibody::Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
/// # let model = b.build()?;
/// use signorini_simulation::{Batch, Settings, Variation};
///
/// let mut batch = Batch::new(model, Settings::default(), 64, 0)?;
/// for i in 0..batch.len() {
///     batch.vary(i, &Variation::default().with_mass(1.0 + 0.01 * i as f64))?;
///     batch.state_mut(i).v[0] = 0.1 * i as f64;
/// }
/// assert!(batch.step(100));
/// let (mut q, mut v) = (vec![0.0; 64 * 7], vec![0.0; 64 * 6]);
/// batch.states_into(&mut q, &mut v);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Batch {
    model: Arc<Model>,
    settings: Settings,
    lanes: Vec<Lane>,
    /// Threads of its own; without them the caller's thread works or, with `shared`, the pool that the caller is in.
    pool: Option<ThreadPool>,
    shared: bool,
}

impl Batch {
    /// `count` simulations at the model's reference configuration, at rest.
    ///
    /// - `threads`: at most so many work at once; 0 for those of the `rayon` pool that the caller is in (by default as many as
    ///   the machine runs at once), 1 for the caller's own
    ///
    /// With more than one simulation each solves its islands on the thread it is on
    /// ([`SolverSettings::threads`](signorini_solver::SolverSettings::threads)), which changes no bit.
    ///
    /// # Errors
    /// [`SimulationError`] if a setting is out of its range, a shape cannot be prepared, threads cannot be started or there is no memory for so many.
    pub fn new(
        model: impl Into<Arc<Model>>,
        settings: Settings,
        count: usize,
        threads: usize,
    ) -> Result<Self, SimulationError> {
        let (model, mut settings) = (model.into(), settings);
        if let (ContactMethod::Structured(solver), 2..) = (&mut settings.method, count) {
            solver.threads = 1;
        }
        let lane = |_| {
            Ok::<_, SimulationError>(Lane { simulation: Simulation::new(model.clone(), settings.clone())?, stop: None })
        };
        let mut lanes = Vec::new();
        lanes.try_reserve_exact(count).map_err(|_| SimulationError::Memory { simulations: count })?;
        for lane in (0..count).map(lane) {
            lanes.push(lane?);
        }
        let own = threads.min(count) > 1;
        let pool = own.then(|| ThreadPoolBuilder::new().num_threads(threads.min(count)).build()).transpose()?;
        Ok(Self { model, settings, lanes, pool, shared: threads == 0 && count > 1 })
    }

    /// The model that the simulations have in common, before any [`vary`](Self::vary).
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

    /// Simulation `i`, with its contacts, settings and sums.
    pub fn simulation(&self, i: usize) -> &Simulation {
        &self.lanes[i].simulation
    }

    /// Numbers of all sensors of simulation `i` at the beginning of its last step; see [`Simulation::sensors`].
    pub fn sensors(&mut self, i: usize) -> &[f64] {
        self.lanes[i].simulation.sensors()
    }

    /// State of simulation `i`.
    pub fn state(&self, i: usize) -> &State {
        &self.lanes[i].simulation.state
    }

    /// State of simulation `i`, to be changed; it is checked at the next step. The warm start stays.
    pub fn state_mut(&mut self, i: usize) -> &mut State {
        &mut self.lanes[i].simulation.state
    }

    /// What acts on simulation `i` in the next steps.
    pub fn input_mut(&mut self, i: usize) -> &mut Input {
        &mut self.lanes[i].simulation.input
    }

    /// How the last step of simulation `i` went.
    pub fn report(&self, i: usize) -> &StepReport {
        &self.lanes[i].simulation.report
    }

    /// Why simulation `i` did not make all steps of the last call, if it did not.
    pub fn stop(&self, i: usize) -> Option<&LaneStop> {
        self.lanes[i].stop.as_ref()
    }

    /// The simulations that did not make all steps of the last call, by index, and why.
    pub fn stops(&self) -> impl Iterator<Item = (usize, &LaneStop)> {
        self.lanes.iter().enumerate().filter_map(|(i, lane)| Some((i, lane.stop.as_ref()?)))
    }

    /// Forgets the last solution of simulation `i`, so that its next step starts cold.
    pub fn clear_warm_start(&mut self, i: usize) {
        self.lanes[i].simulation.workspace.clear_warm_start();
    }

    /// Puts simulation `i` back to the start: reference configuration, at rest, time 0, no input, cold. Its parameters stay.
    pub fn reset(&mut self, i: usize) {
        let simulation = &mut self.lanes[i].simulation;
        let start = State::new(simulation.model());
        simulation.input = Input::default();
        simulation.begin_at(&start);
    }

    /// Sets state and control of simulation `i` from a keyframe of the model.
    ///
    /// # Errors
    /// [`SimulationError::UnknownName`] if the model has no such keyframe.
    pub fn reset_to(&mut self, i: usize, keyframe: &str) -> Result<(), SimulationError> {
        self.lanes[i].simulation.reset_to(keyframe)
    }

    /// Gives simulation `i` parameters of its own, relative to those of [`model`](Self::model), in place of all that were changed before. State and input stay, the next
    /// step starts cold.
    ///
    /// # Errors
    /// [`SimulationError::Setting`] if a parameter is out of its range.
    pub fn vary(&mut self, i: usize, variation: &Variation) -> Result<(), SimulationError> {
        let lane = &mut self.lanes[i];
        let mut simulation = Simulation::new(self.model.clone(), self.settings.clone())?;
        let changes = variation.changes(&self.model)?;
        let changes: Vec<ParameterChange<'_>> = changes.iter().map(|(parameter, all)| (*parameter, &all[..])).collect();
        simulation.change(&changes)?;
        std::mem::swap(&mut simulation.input, &mut lane.simulation.input);
        simulation.begin_at(&lane.simulation.state);
        lane.simulation = simulation;
        Ok(())
    }

    /// Gives simulation `i` other numbers of its model: see [`Simulation::change`]. State, input and warm start stay.
    ///
    /// # Errors
    /// [`SimulationError`] naming what is wrong; nothing has changed then.
    pub fn change(&mut self, i: usize, changes: &[ParameterChange<'_>]) -> Result<(), SimulationError> {
        self.lanes[i].simulation.change(changes)
    }

    /// Everything that decides how simulation `i` goes on.
    pub fn save(&self, i: usize) -> Snapshot {
        self.lanes[i].simulation.save()
    }

    /// Lets simulation `i` go on from a snapshot of one with the same model and parameters.
    ///
    /// # Errors
    /// See [`Simulation::restore`].
    pub fn restore(&mut self, i: usize, snapshot: &Snapshot) -> Result<(), SimulationError> {
        self.lanes[i].simulation.restore(snapshot)
    }

    /// Copies the states of all simulations.
    ///
    /// - `q`, `v`: out, `[n, nq]` and `[n, nv]`
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn states_into(&self, q: &mut [f64], v: &mut [f64]) {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.check_lengths(q, v, 1);
        for (i, lane) in self.lanes.iter().enumerate() {
            q[i * nq..(i + 1) * nq].copy_from_slice(&lane.simulation.state.q);
            v[i * nv..(i + 1) * nv].copy_from_slice(&lane.simulation.state.v);
        }
    }

    /// Sets the states of all simulations, which are checked at the next step; times and warm starts stay.
    ///
    /// - `q`, `v`: `[n, nq]` and `[n, nv]`
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn set_states(&mut self, q: &[f64], v: &[f64]) {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.check_lengths(q, v, 1);
        for (i, lane) in self.lanes.iter_mut().enumerate() {
            lane.simulation.state.q.copy_from_slice(&q[i * nq..(i + 1) * nq]);
            lane.simulation.state.v.copy_from_slice(&v[i * nv..(i + 1) * nv]);
        }
    }

    fn check_lengths(&self, q: &[f64], v: &[f64], steps: usize) {
        let states = self.len() * steps;
        let fit = q.len() == states * self.model.nq && v.len() == states * self.model.nv;
        assert!(fit, "q and v must be [n, nq] and [n, nv], with the steps between them in a rollout");
    }

    /// Makes `steps` steps of every simulation. One that stops early leaves the others going; whether none did.
    pub fn step(&mut self, steps: u64) -> bool {
        let mut nothing = vec![(); self.len()];
        self.for_each(&mut nothing, None, |_, lane, (), goes_on| {
            (0..steps).all(|_| goes_on() && lane.step());
        })
    }

    /// Makes `steps` steps of the simulations that are `chosen`; the others stay as they are. Otherwise as [`step`](Self::step).
    ///
    /// # Panics
    /// If `chosen` has not one entry per simulation.
    pub fn step_chosen(&mut self, steps: u64, chosen: &[bool]) -> bool {
        self.step_lanes(steps, chosen, None)
    }

    /// As [`step_chosen`](Self::step_chosen), as long as `goes_on` says so. It is asked on the caller's thread every now and then, some twenty
    /// times a second (where the caller is a thread of the pool, between simulations); where it says no every simulation ends with the step that it
    /// is making.
    ///
    /// # Panics
    /// If `chosen` has not one entry per simulation.
    pub fn step_chosen_while(&mut self, steps: u64, chosen: &[bool], mut goes_on: impl FnMut() -> bool) -> bool {
        self.step_lanes(steps, chosen, Some(&mut goes_on))
    }

    fn step_lanes(&mut self, steps: u64, chosen: &[bool], goes_on: Option<&mut dyn FnMut() -> bool>) -> bool {
        assert_eq!(chosen.len(), self.len(), "chosen must have one entry per simulation");
        let mut chosen = chosen.to_vec();
        self.for_each(&mut chosen, goes_on, |_, lane, chosen, goes_on| {
            (0..if *chosen { steps } else { 0 }).all(|_| goes_on() && lane.step());
        })
    }

    /// Makes `steps` steps of every simulation with given controls, and records the states after each. One that stops early
    /// leaves the others going, and the rest of its record is NaN; whether none did.
    ///
    /// - `controls`: `[n, steps, nu]`; empty leaves every input as it is
    /// - `q`, `v`: out, `[n, steps, nq]` and `[n, steps, nv]`; both empty records nothing
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn rollout(&mut self, steps: usize, controls: &[f64], q: &mut [f64], v: &mut [f64]) -> bool {
        let (count, nq, nv) = (self.len(), self.model.nq, self.model.nv);
        let record = !(q.is_empty() && v.is_empty());
        if record {
            self.check_lengths(q, v, steps);
        }
        q.fill(f64::NAN);
        v.fill(f64::NAN);
        let mut records: Vec<_> = parts_mut(q, count).into_iter().zip(parts_mut(v, count)).collect();
        self.rollout_observed(steps, controls, &mut records, |k, simulation, (q, v)| {
            if record {
                q[k * nq..(k + 1) * nq].copy_from_slice(&simulation.state.q);
                v[k * nv..(k + 1) * nv].copy_from_slice(&simulation.state.v);
            }
        })
    }

    /// As [`rollout`](Self::rollout), with records of the caller's.
    ///
    /// - `records`: one per simulation
    /// - `observe`: called after every step with its index, the simulation and its record
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn rollout_observed<T: Send>(
        &mut self,
        steps: usize,
        controls: &[f64],
        records: &mut [T],
        observe: impl Fn(usize, &mut Simulation, &mut T) + Sync,
    ) -> bool {
        self.roll_lanes(steps, controls, records, None, observe)
    }

    /// As [`rollout_observed`](Self::rollout_observed), as long as `goes_on` says so; see [`step_chosen_while`](Self::step_chosen_while).
    ///
    /// # Panics
    /// If a length does not fit.
    pub fn rollout_while<T: Send>(
        &mut self,
        steps: usize,
        controls: &[f64],
        records: &mut [T],
        mut goes_on: impl FnMut() -> bool,
        observe: impl Fn(usize, &mut Simulation, &mut T) + Sync,
    ) -> bool {
        self.roll_lanes(steps, controls, records, Some(&mut goes_on), observe)
    }

    fn roll_lanes<T: Send>(
        &mut self,
        steps: usize,
        controls: &[f64],
        records: &mut [T],
        goes_on: Option<&mut dyn FnMut() -> bool>,
        observe: impl Fn(usize, &mut Simulation, &mut T) + Sync,
    ) -> bool {
        let (count, nu) = (self.len(), self.model.actuators.len());
        assert!(controls.is_empty() || controls.len() == count * steps * nu, "controls must be [n, steps, nu]");
        assert_eq!(records.len(), count, "records must have one entry per simulation");
        self.for_each(records, goes_on, |i, lane, record, goes_on| {
            for k in 0..steps {
                if !goes_on() {
                    break;
                }
                if !controls.is_empty() {
                    let start = (i * steps + k) * nu;
                    let control = &mut lane.simulation.input.control;
                    control.clear();
                    control.extend_from_slice(&controls[start..start + nu]);
                }
                if !lane.step() {
                    break;
                }
                observe(k, &mut lane.simulation, record);
            }
        })
    }

    /// Hands the simulations to the threads, each with its index, its item and whom to ask before every step whether to go on; whether none of
    /// them stopped, nor was stopped.
    fn for_each<T: Send>(
        &mut self,
        items: &mut [T],
        goes_on: Option<&mut dyn FnMut() -> bool>,
        work: impl Fn(usize, &mut Lane, &mut T, &mut dyn FnMut() -> bool) + Sync,
    ) -> bool {
        let Self { lanes, pool, shared, .. } = self;
        let crew = match pool {
            Some(pool) => Crew::Own(pool),
            None if *shared => Crew::Shared,
            None => Crew::Caller,
        };
        let nobody_ended = for_each(crew, (lanes, items), goes_on, |i, lane, item, goes_on| {
            lane.stop = None;
            work(i, lane, item, goes_on);
        });
        nobody_ended && self.lanes.iter().all(|lane| lane.stop.is_none())
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
    fn step(&mut self) -> bool {
        match self.simulation.step() {
            Ok(report) if report.advanced() => {}
            Ok(_) => self.stop = Some(LaneStop::NoSolution),
            Err(error) => self.stop = Some(LaneStop::Error(error)),
        }
        self.stop.is_none()
    }
}
