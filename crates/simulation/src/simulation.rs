//! A run: a model, its state, and the same step again and again.

use std::sync::{Arc, OnceLock};

use signorini_contact::{Certificate, StageCounts};
use signorini_multibody::{
    Input, Keyframe, Kinematics, Model, State, equality_violations, forward_kinematics_into, kinetic_energy,
    potential_energy,
};

use crate::report::StepReport;
use crate::sensors::sensors_into;
use crate::settings::{InfeasiblePolicy, Settings};
use crate::solver::CertifiedLaw;
use crate::step::step;
use crate::workspace::Workspace;
use crate::{SimulationError, Snapshot};

/// What a run adds up to.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Steps made.
    pub steps: u64,
    /// Steps whose residuals exceed the tolerance.
    pub missed_steps: u64,
    /// Steps whose [budget](Settings::budget) was used up.
    pub unfinished_steps: u64,
    /// The largest root mean square of the residuals of such a step ([`StepReport::spread`]).
    pub largest_rms: f64,
    /// Steps that were permitted to remove a part of their overlaps and violations only (θ < 1).
    pub limited_steps: u64,
    /// The smallest θ of a step; 1 where none was limited.
    pub smallest_theta: f64,
    /// The largest overlap or violation that a limited step kept, m or rad.
    pub deepest_kept: f64,
    /// Work of the impulses along the corrections of all steps, J.
    pub correction_energy: f64,
    /// The most contact points of a step that no degree of freedom moves along their normal, and that are in no problem.
    pub left_out_max: usize,
    /// Steps in which negative gaps were taken as zero.
    pub clipped_steps: u64,
    /// Largest number of contacts in a step.
    pub contacts_max: usize,
    /// The friction law that `worst` speaks of.
    pub law: CertifiedLaw,
    /// Largest residual of each law over the run.
    pub worst: Certificate,
    /// The same of the circular cone's laws, where the settings ask for them.
    pub worst_cone: Option<Certificate>,
    /// Deepest penetration of a contact point at the beginning of a step, m (≥ 0).
    pub deepest_penetration: f64,
    /// Largest violation of an equality constraint at the beginning of a step, m or rad.
    pub constraint_error: f64,
    /// Solver iterations of all steps.
    pub iterations: u64,
    /// What the structured solver's stages did in all steps.
    pub stages: StageCounts,
}

impl Default for Summary {
    fn default() -> Self {
        Self {
            steps: 0,
            missed_steps: 0,
            unfinished_steps: 0,
            largest_rms: 0.0,
            limited_steps: 0,
            smallest_theta: 1.0,
            deepest_kept: 0.0,
            correction_energy: 0.0,
            left_out_max: 0,
            clipped_steps: 0,
            contacts_max: 0,
            law: CertifiedLaw::default(),
            worst: Certificate::default(),
            worst_cone: None,
            deepest_penetration: 0.0,
            constraint_error: 0.0,
            iterations: 0,
            stages: StageCounts::default(),
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEnd {
    /// The time is over.
    Finished,
    /// A step has no solution; the state is the one before it. The report tells which contacts contradict each other.
    NoSolution(Box<StepReport>),
    /// The observer asked for it.
    Stopped,
}

/// A model with its state, input and everything needed to step.
pub struct Simulation {
    pub(crate) model: Arc<Model>,
    pub(crate) settings: Settings,
    pub(crate) workspace: Workspace,
    pub(crate) state: State,
    pub(crate) next: State,
    /// What acts on the model in the next step.
    pub input: Input,
    pub(crate) report: StepReport,
    summary: Summary,
    /// Whether the equality constraints of the state have been checked.
    pub(crate) assembled: bool,
    /// Energy before the first step, J.
    first_energy: f64,
    /// Content hash of the model, once it was asked for.
    pub(crate) model_hash: OnceLock<u64>,
    sensors: Vec<f64>,
    /// Whether the sensors' numbers are those of the last step, which can no longer be asked.
    pub(crate) measured: bool,
}

impl Simulation {
    /// A simulation at the model's reference configuration, at rest.
    ///
    /// # Errors
    /// [`SimulationError`] if a setting is out of its range or a shape cannot be prepared.
    pub fn new(model: impl Into<Arc<Model>>, settings: Settings) -> Result<Self, SimulationError> {
        let model = model.into();
        let workspace = Workspace::new(&model, &settings)?;
        let state = State::new(&model);
        let next = state.clone();
        let (input, report, summary) = (Input::default(), StepReport::default(), Summary::default());
        let sensors = vec![0.0; model.sensor_size];
        Ok(Self {
            model,
            settings,
            workspace,
            state,
            next,
            input,
            report,
            summary,
            assembled: false,
            first_energy: 0.0,
            model_hash: OnceLock::new(),
            sensors,
            measured: false,
        })
    }

    /// The model, with the numbers it has now.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Time step Δt, s.
    pub fn timestep(&self) -> f64 {
        self.settings.timestep.unwrap_or(self.model.timestep)
    }

    /// The present state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// How the last step went.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// Contact points, problem and solution of the last step.
    pub fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    /// Sums over the steps made so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Sets the state and forgets the warm start.
    ///
    /// # Errors
    /// [`SimulationError::State`] if a length is wrong or a number not finite.
    pub fn set_state(&mut self, state: &State) -> Result<(), SimulationError> {
        state.check(&self.model)?;
        self.begin_at(state);
        Ok(())
    }

    /// Takes a state, unchecked, and forgets the warm start.
    pub(crate) fn begin_at(&mut self, state: &State) {
        self.state.clone_from(state);
        self.workspace.clear_warm_start();
        self.assembled = false;
    }

    /// Everything that decides how the simulation goes on: state, input and warm start.
    pub fn save(&self) -> Snapshot {
        Snapshot {
            model_hash: *self.model_hash.get_or_init(|| self.model.content_hash()),
            assembled: self.assembled,
            time: self.state.time,
            q: self.state.q.clone(),
            v: self.state.v.clone(),
            activation: self.state.activation.clone(),
            input: self.input.clone(),
            warm_start: self.workspace.warm_start(),
        }
    }

    /// Goes on from a snapshot of a simulation of the same model: with the same settings the steps that follow have the bits
    /// of those that followed there. The [`summary`](Self::summary) stays.
    ///
    /// # Errors
    /// [`SimulationError::Snapshot`] if it belongs to another model, [`SimulationError::State`] and
    /// [`SimulationError::WarmStart`] if its numbers are none of this model's; nothing has changed then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SimulationError> {
        if snapshot.model_hash != *self.model_hash.get_or_init(|| self.model.content_hash()) {
            return Err(SimulationError::Snapshot {
                reason: "it belongs to another model, or to one with other parameters",
            });
        }
        let state = snapshot.state();
        state.check(&self.model)?;
        snapshot.input.check(&self.model)?;
        self.workspace.set_warm_start(&snapshot.warm_start)?;
        self.state = state;
        self.input.clone_from(&snapshot.input);
        self.assembled = snapshot.assembled;
        Ok(())
    }

    /// Takes over the [`Workspace::warm_start`] of another simulation. It is kept by body and geom, so that one of a model with
    /// the same bodies and geoms in the same order will do, such as the model that begins where the other has come to.
    ///
    /// # Errors
    /// [`SimulationError::WarmStart`] if the numbers are not those of a warm start; nothing has changed then.
    pub fn set_warm_start(&mut self, numbers: &[f64]) -> Result<(), SimulationError> {
        self.workspace.set_warm_start(numbers)
    }

    /// Moves the configuration onto the equality constraints by the smallest change in the metric of the mass matrix, and
    /// gives back the largest violation that is left, m or rad. The velocity stays.
    ///
    /// # Errors
    /// [`SimulationError::FreeMotion`] if the mass matrix is singular.
    pub fn assemble(&mut self) -> Result<f64, SimulationError> {
        const NEWTON_STEPS: u32 = 50;
        if self.model.equalities.is_empty() {
            return Ok(0.0);
        }
        let Self { model, workspace, state, .. } = self;
        workspace.clear_warm_start();
        workspace.assembler.place_mocap(model, &self.input);
        workspace.assembler.assemble(model, &mut state.q, NEWTON_STEPS)
    }

    /// The largest violation of an equality constraint in the present state, m or rad.
    pub fn constraint_violation(&mut self) -> f64 {
        self.workspace.assembler.place_mocap(&self.model, &self.input);
        self.workspace.assembler.violation(&self.model, &self.state.q)
    }

    /// Refuses a start that violates the equality constraints (mocap bodies take part in them), unless steps go on from what they
    /// cannot remove. A wrong input is named first.
    pub(crate) fn check_assembly(&mut self) -> Result<(), SimulationError> {
        if self.assembled {
            return Ok(());
        }
        self.input.check(&self.model)?;
        let tolerance = self.settings.assembly_tolerance;
        let goes_on = self.settings.infeasible == InfeasiblePolicy::GoOn;
        if !goes_on && self.constraint_violation() > tolerance {
            let mut kinematics = Kinematics::new(&self.model);
            kinematics.place_mocap(&self.model, &self.input);
            forward_kinematics_into(&self.model, &self.state.q, &self.state.v, &mut kinematics);
            let sizes = equality_violations(&self.model, &kinematics, &self.state.q);
            let names = self.model.equalities.iter().map(|e| e.name.clone());
            let violations = names.zip(sizes).filter(|(_, size)| *size > tolerance).collect();
            return Err(SimulationError::NotAssembled { tolerance, violations });
        }
        self.assembled = true;
        Ok(())
    }

    /// Sets state and control from a keyframe of the model.
    ///
    /// # Errors
    /// [`SimulationError::UnknownName`] if the model has no such keyframe.
    pub fn reset_to(&mut self, keyframe: &str) -> Result<(), SimulationError> {
        let Some(Keyframe { time, q, v, activation, control, mocap, .. }) = self.model.keyframe_named(keyframe) else {
            let known = self.model.keyframes.iter().map(|k| k.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(SimulationError::UnknownName { sort: "keyframe", name: keyframe.into(), known });
        };
        let state = State::at(q.clone(), v.clone()).with_time(*time).with_activation(activation.clone());
        self.input.control = control.clone();
        self.input.mocap = mocap.clone();
        self.set_state(&state)
    }

    /// Makes one step.
    ///
    /// # Errors
    /// See [`step`](crate::step()), and [`SimulationError::NotAssembled`] in the first step from a state that violates equality
    /// constraints.
    pub fn step(&mut self) -> Result<&StepReport, SimulationError> {
        self.check_assembly()?;
        if self.summary.steps == 0 {
            let (kinetic, potential) = self.energy();
            self.first_energy = kinetic + potential;
        }
        self.measured = false;
        let Self { model, settings, workspace, state, next, input, .. } = self;
        self.report = step(model, state, input, settings, workspace, next)?;
        if self.report.advanced() {
            std::mem::swap(&mut self.state, &mut self.next);
            self.summary.add(&self.report, &self.workspace);
        }
        Ok(&self.report)
    }

    /// Numbers of all sensors at the beginning of the last step, in the order of the model's sensors: its state, and the
    /// accelerations and forces with which it went on; see [`sensors_into`]. Before the first step they are zero.
    pub fn sensors(&mut self) -> &[f64] {
        if self.summary.steps > 0 && !self.measured {
            // After a step `next` holds the state it was made from.
            sensors_into(&self.model, &self.next, &mut self.workspace, &mut self.sensors);
        }
        &self.sensors
    }

    /// Steps until `duration` (s) has passed. `observe` is called after each step with the simulation, whose
    /// [`workspace`](Self::workspace) holds the step's contacts; it returns whether to go on.
    ///
    /// # Errors
    /// See [`step`](crate::step()).
    pub fn run(
        &mut self,
        duration: f64,
        mut observe: impl FnMut(&Self, &StepReport) -> bool,
    ) -> Result<RunEnd, SimulationError> {
        let steps = (duration / self.timestep()).round() as u64;
        for _ in 0..steps {
            self.step()?;
            let go_on = observe(self, &self.report);
            if !self.report.advanced() {
                return Ok(RunEnd::NoSolution(Box::new(self.report.clone())));
            }
            if !go_on {
                return Ok(RunEnd::Stopped);
            }
        }
        Ok(RunEnd::Finished)
    }

    /// By how much the energy has risen since the first step, where corrections of overlaps and violations put in at least as much, J: a
    /// run that nothing else drives owes its motion to them. `None` where it has not risen, or corrections put in less.
    pub fn energy_from_corrections(&self) -> Option<f64> {
        let (kinetic, potential) = self.energy();
        let rise = kinetic + potential - self.first_energy;
        (self.summary.steps > 0 && rise > 0.0 && self.summary.correction_energy >= rise).then_some(rise)
    }

    /// Kinetic and potential energy of the present state, J.
    pub fn energy(&self) -> (f64, f64) {
        let mut kinematics = Kinematics::new(&self.model);
        kinematics.place_mocap(&self.model, &self.input);
        forward_kinematics_into(&self.model, &self.state.q, &self.state.v, &mut kinematics);
        let kinetic = kinetic_energy(&self.model, &kinematics, &self.state.v);
        (kinetic, potential_energy(&self.model, &kinematics, &self.state.q))
    }
}

impl Summary {
    fn add(&mut self, report: &StepReport, workspace: &Workspace) {
        self.steps += 1;
        self.missed_steps += u64::from(report.missed_tolerance);
        if let Some(spread) = &report.spread {
            self.unfinished_steps += 1;
            self.largest_rms = self.largest_rms.max(spread.rms);
        }
        self.limited_steps += u64::from(report.theta < 1.0);
        self.smallest_theta = self.smallest_theta.min(report.theta);
        self.deepest_kept = report.kept.iter().fold(self.deepest_kept, |deepest, kept| deepest.max(kept.size));
        self.correction_energy += report.correction_energy;
        self.left_out_max = self.left_out_max.max(report.left_out);
        self.clipped_steps += u64::from(report.clipped_gaps);
        self.contacts_max = self.contacts_max.max(report.contacts);
        self.law = report.law;
        self.worst.merge(&report.certificate);
        if let Some(cone) = &report.cone_certificate {
            self.worst_cone.get_or_insert_default().merge(cone);
        }
        self.constraint_error = self.constraint_error.max(report.constraint_error);
        self.iterations += u64::from(report.solver.iterations());
        self.stages.add(&report.solver.stages);
        self.deepest_penetration = self.deepest_penetration.max(workspace.deepest_penetration());
    }
}
