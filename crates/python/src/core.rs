//! What a `Data` holds on the Rust side: a state and everything needed to step it, free of Python.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use signorini::collision::Queries;
use signorini::derivatives::{Direction, StepDerivatives};
use signorini::multibody::{Input, Kinematics, Model, ParameterChange, SpatialVector, State};
use signorini::recording::{Frame, Header, ModelSource, RecordingError};
use signorini::{
    Settings, SettleProgress, SettleReport, SettleSettings, Simulation, SimulationError, StepReport, Workspace,
    frame_into, last_frame_into, recording_header, sensors_into, step, step_solution_into,
};

use crate::recording::Sink;

/// How long steps are made before Python is asked whether the user wants to stop.
const SLICE: Duration = Duration::from_millis(50);

/// Steps between two looks at the clock, at most: the first looks come sooner, since a step may take seconds.
const STEPS_PER_LOOK: u64 = 16;

/// A state and everything needed to step it.
pub struct Core {
    pub model: Arc<Model>,
    pub settings: Settings,
    pub workspace: Workspace,
    pub state: State,
    /// The state before the last step; after [`preview`](Self::preview), the one the step would lead to.
    pub other: State,
    pub input: Input,
    pub report: StepReport,
    /// Whether the workspace holds a step of this run.
    pub stepped: bool,
    /// Where the step in the workspace began, if it was only previewed; otherwise that is `other`.
    previewed: Option<State>,
    /// What acted during the step in the workspace.
    given: Input,
    /// What somebody should be told about the start of the run, until somebody is.
    pub start_note: Option<String>,
    /// Steps made.
    pub steps: u64,
    /// Steps that missed the tolerance.
    pub missed_steps: u64,
    /// Steps that were permitted to remove a part of their overlaps and violations only.
    pub limited_steps: u64,
    /// Work of the impulses along the corrections of all steps, J.
    pub correction_energy: f64,
    /// Steps in which negative gaps were taken as zero.
    pub clipped_steps: u64,
    /// The geoms, once somebody asked about them.
    pub queries: Option<Queries>,
    sink: Option<Sink>,
    frame: Frame,
}

/// How a number of steps ended early.
pub enum Stop {
    /// The time slice is over.
    Slice,
    /// The contact problem has no solution; the report says why.
    NoSolution,
    /// The state, input or problem is malformed.
    Simulation(SimulationError),
    /// The recording cannot be written.
    Recording(RecordingError),
}

impl Core {
    /// At the model's reference configuration, at rest.
    pub fn new(model: Arc<Model>, settings: Settings) -> Result<Self, SimulationError> {
        let workspace = Workspace::new(&model, &settings)?;
        let state = State::new(&model);
        let input = Input::default()
            .with_control(vec![0.0; model.actuators.len()])
            .with_generalized_force(vec![0.0; model.nv])
            .with_wrench(vec![SpatialVector::ZERO; model.bodies.len()])
            .with_mocap(model.mocap_placements());
        let mut core = Self {
            workspace,
            other: state.clone(),
            state,
            input,
            report: StepReport::default(),
            stepped: false,
            previewed: None,
            given: Input::default(),
            start_note: None,
            steps: 0,
            missed_steps: 0,
            limited_steps: 0,
            correction_energy: 0.0,
            clipped_steps: 0,
            queries: None,
            sink: None,
            frame: Frame::default(),
            model,
            settings,
        };
        core.update_kinematics();
        Ok(core)
    }

    /// Time step, s.
    pub fn timestep(&self) -> f64 {
        self.settings.timestep.unwrap_or(self.model.timestep)
    }

    /// Finds poses and velocities of the present state.
    pub fn update_kinematics(&mut self) {
        self.workspace.look_ahead(&self.model, &self.state, &self.input);
    }

    /// Poses and velocities as they were [found](Self::update_kinematics) last.
    pub fn kinematics(&self) -> &Kinematics {
        self.workspace.ahead()
    }

    /// Makes up to `count` steps and counts it down; ends early where a step fails or the time slice is over.
    pub fn run(&mut self, count: &mut u64) -> Result<(), Stop> {
        let start = Instant::now();
        let (mut made, mut look) = (0, 1);
        while *count > 0 {
            self.step_once()?;
            *count -= 1;
            made += 1;
            if made == look {
                if *count > 0 && start.elapsed() > SLICE {
                    return Err(Stop::Slice);
                }
                look += made.min(STEPS_PER_LOOK);
            }
        }
        Ok(())
    }

    fn step_once(&mut self) -> Result<(), Stop> {
        let Self { model, settings, workspace, state, other, input, given, .. } = self;
        self.report = step(model, state, input, settings, workspace, other).map_err(Stop::Simulation)?;
        given.clone_from(input);
        if (!self.stepped || self.previewed.is_some()) && self.report.advanced() {
            self.start_note = workspace.start_note(model, settings);
        }
        self.stepped = true;
        self.previewed = None;
        if let Some(sink) = &mut self.sink {
            frame_into(model, self.steps, state, workspace, &self.report, &mut self.frame);
            step_solution_into(input, workspace, &self.report, &mut self.frame);
            sink.push(&self.frame).map_err(Stop::Recording)?;
        }
        if !self.report.advanced() {
            self.previewed = Some(state.clone());
            return Err(Stop::NoSolution);
        }
        std::mem::swap(state, other);
        self.steps += 1;
        self.missed_steps += u64::from(self.report.missed_tolerance);
        self.limited_steps += u64::from(self.report.theta < 1.0);
        self.correction_energy += self.report.correction_energy;
        self.clipped_steps += u64::from(self.report.clipped_gaps);
        Ok(())
    }

    /// Solves the step from the present state without making it: `other` is where it would lead.
    pub fn preview(&mut self) -> Result<(), SimulationError> {
        let warm = self.workspace.warm_start();
        let Self { model, settings, workspace, state, other, input, .. } = self;
        self.report = step(model, state, input, settings, workspace, other)?;
        self.given.clone_from(input);
        self.stepped = true;
        self.previewed = Some(state.clone());
        // The step took over the kinematics.
        workspace.look_ahead(model, state, input);
        workspace.set_warm_start(&warm)
    }

    /// Brings the state to rest and solves the step from there. Where it does not come to rest, the state is the one reached; after
    /// another error nothing has changed.
    pub fn settle(
        &mut self,
        settings: &SettleSettings,
        goes_on: impl FnMut(&SettleProgress) -> ControlFlow<()>,
    ) -> Result<SettleReport, SimulationError> {
        let mut simulation = Simulation::new(self.model.clone(), self.settings.clone())?;
        simulation.set_state(&self.state)?;
        simulation.input.clone_from(&self.input);
        let settled = simulation.settle_while(settings, goes_on);
        if matches!(settled, Ok(_) | Err(SimulationError::NotSettled { .. })) {
            self.state.clone_from(simulation.state());
            self.forget();
            self.update_kinematics();
        }
        let report = settled?;
        self.workspace.set_warm_start(&simulation.workspace().warm_start())?;
        self.preview()?;
        Ok(report)
    }

    /// Numbers of all sensors at the beginning of the step in the workspace, `[sensor_size]`; zeros where there is none.
    pub fn sensors(&mut self) -> Vec<f64> {
        let mut numbers = vec![0.0; self.model.sensor_size];
        if self.stepped {
            let begin = self.previewed.as_ref().unwrap_or(&self.other);
            sensors_into(&self.model, begin, &mut self.workspace, &mut numbers);
        }
        numbers
    }

    /// The derivative of the step in the workspace, with columns for parameters, and with a second look for another solution where `twice`.
    pub fn derivatives(&mut self, parameters: Vec<Direction>, twice: bool) -> StepDerivatives {
        let mut derivatives = StepDerivatives::with_parameters(&self.model, parameters);
        if twice {
            derivatives = derivatives.asking_twice();
        }
        let begin = self.previewed.as_ref().unwrap_or(&self.other);
        let given = (begin, &self.given);
        derivatives.compute(&self.model, given, &self.settings, &self.report, &mut self.workspace);
        derivatives
    }

    /// Goes on with other numbers of the model: nothing of the last step is left but its warm start.
    pub fn change(&mut self, changes: &[ParameterChange<'_>]) -> Result<(), SimulationError> {
        self.workspace.change(&mut self.model, &self.settings, changes)?;
        self.queries = None;
        self.report = StepReport::default();
        self.stepped = false;
        self.other.v.clone_from(&self.state.v);
        self.update_kinematics();
        Ok(())
    }

    /// Forgets what came before the present state.
    pub fn forget(&mut self) {
        self.workspace.clear_warm_start();
        self.report = StepReport::default();
        self.stepped = false;
        self.other.v.clone_from(&self.state.v);
    }

    /// Begins to record every step, to memory or to a file.
    pub fn start_recording(
        &mut self,
        path: Option<&std::path::Path>,
        source: Option<ModelSource>,
    ) -> Result<(), RecordingError> {
        let header = Header { source, ..recording_header(&self.model, &self.settings, &self.workspace) };
        self.sink = Some(Sink::new(header, path)?);
        Ok(())
    }

    /// Whether steps are recorded.
    pub fn is_recording(&self) -> bool {
        self.sink.is_some()
    }

    /// Ends the recording with the present state.
    pub fn stop_recording(&mut self, reason: &str) -> Result<Option<signorini::recording::Recording>, RecordingError> {
        let Some(mut sink) = self.sink.take() else {
            return Ok(None);
        };
        last_frame_into(&self.model, self.steps, &self.state, &self.input, &mut self.frame);
        sink.push(&self.frame)?;
        sink.finish(reason)
    }
}
