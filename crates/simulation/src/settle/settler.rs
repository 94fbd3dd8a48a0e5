//! The steps towards rest, and the question whether a state rests.

use std::ops::ControlFlow;
use std::sync::Arc;

use signorini_contact::ProblemError;
use signorini_laws::{SettlingEffort, SettlingSolver, SettlingStep};
use signorini_multibody::{Model, State, integrate_into};

use super::pace::{CALM, MOVING, SLOW};
use super::report::{SettleProgress, SettleSettings};
use crate::report::StepReport;
use crate::settings::Settings;
use crate::step::step;
use crate::workspace::Workspace;
use crate::{Simulation, SimulationError};

/// Δt of the steps over that of the simulation, where none is given.
const LONGER: f64 = 4.0;
/// Newton steps for an island, and those at the start, where no impulses are known.
const NEWTON_STEPS: u32 = 20;
const FIRST_NEWTON_STEPS: u32 = 60;
/// Problems that are solved at a start without velocity to see whether it rests: their first ε, its fall from one to the next and its
/// least value, and that of the last ones, which take away what rounding leaves with a small one.
const LOOKS: u32 = 16;
const FIRST_EPSILON: f64 = 1e-3;
const FALL: f64 = 0.1;
const LEAST_EPSILON: f64 = 1e-8;
const LAST_EPSILON: f64 = 1e-4;
/// Limits of ε; a motion begins with the largest. With a large one what gives way has to be pushed back by many steps, with a small one bounds
/// of friction jump, because the normal impulses of redundant contacts do.
const LARGEST_EPSILON: f64 = 1e-2;
const SMALLEST_EPSILON: f64 = 1e-6;
/// ε above which it falls while anything moves by more than as small a part of the velocity scale.
const USUAL_EPSILON: f64 = 1e-4;
/// Up to so many factorisations of an island ε falls, from so many on it rises, by a factor of two.
const FEW: u32 = 10;
const MANY: u32 = 14;
/// Ordinary steps until two in a row end where they began; each takes up the rounding of the one before (of 120 heaps of 32 boxes six steps leave rounding in one or two,
/// and so many in none).
const LAST_STEPS: u32 = 24;
/// Part of the velocity scale that is rounding. Forces that depend on the configuration, of springs and servos, cancel others up to
/// that.
const ROUNDING: f64 = 1e-12;

/// The steps towards rest.
pub(super) struct Settler {
    model: Arc<Model>,
    workspace: Workspace,
    solver: SettlingSolver,
    step: SettlingStep,
    pub state: State,
    /// Δt of the last step, and the usual one, s.
    dt: f64,
    usual_dt: f64,
    epsilon: f64,
    pub factorizations: u64,
    /// Whether Coulomb's laws were asked and have not found rest.
    refused: bool,
    /// Whether it was ended from outside.
    pub is_ended: bool,
}

impl Settler {
    pub fn new(simulation: &Simulation, settings: &SettleSettings) -> Result<Self, SimulationError> {
        let dt = settings.timestep.unwrap_or(LONGER * simulation.timestep());
        let model = simulation.model.clone();
        let workspace = Workspace::new(&model, &Settings { timestep: Some(dt), ..simulation.settings.clone() })?;
        Ok(Self {
            model,
            workspace,
            solver: SettlingSolver::default(),
            step: SettlingStep::default(),
            state: simulation.state.clone(),
            dt,
            usual_dt: dt,
            epsilon: LARGEST_EPSILON,
            factorizations: 0,
            refused: false,
            is_ended: false,
        })
    }

    /// Whether impulses are found that hold the start, without going anywhere.
    pub fn seems_to_rest(
        &mut self,
        simulation: &Simulation,
        goes_on: &mut impl FnMut(&SettleProgress) -> ControlFlow<()>,
    ) -> Result<bool, SimulationError> {
        let (mut last, mut is_near) = (f64::INFINITY, false);
        for look in 0..LOOKS {
            let falling = (FIRST_EPSILON * FALL.powi(look as i32)).max(LEAST_EPSILON);
            let epsilon = if is_near { LAST_EPSILON } else { falling };
            self.solve(simulation, SettlingEffort { epsilon, newton_steps: FIRST_NEWTON_STEPS, associated: true })?;
            let [speed, slack] = self.unrest();
            if look > 0 && speed > SLOW * last {
                break;
            }
            is_near |= speed.max(slack) <= CALM;
            last = speed;
            self.tell(0, goes_on);
            if self.is_ended {
                return Ok(false);
            }
        }
        Ok(is_near)
    }

    /// Finds the next step; returns the largest velocity and by how much contacts give way, relative to the velocity scale.
    pub fn find_step(&mut self, simulation: &Simulation) -> Result<[f64; 2], SimulationError> {
        let epsilon = self.epsilon;
        self.solve(simulation, SettlingEffort { epsilon, newton_steps: NEWTON_STEPS, associated: false })?;
        let unrest = self.unrest();
        self.adapt(unrest[0].max(unrest[1]));
        Ok(unrest)
    }

    /// Solves the problem of a step from the present state, around the impulses of the last one.
    fn solve(&mut self, simulation: &Simulation, effort: SettlingEffort) -> Result<(), SimulationError> {
        let Self { model, workspace: ws, state, .. } = self;
        state.check(model)?;
        ws.begin(model, state, &simulation.input, self.dt)?;
        ws.find_points(model);
        ws.candidates.choose_all();
        ws.build_problem(model, state, &simulation.input);
        let earlier = ws.warm.start_for(&ws.builder.keys, &ws.builder.group_keys);
        let solved = self.solver.step_into(&ws.builder.problem, earlier, &state.v, effort, &mut self.step);
        solved.map_err(ProblemError::from)?;
        ws.warm.keep(&ws.builder.keys, &ws.builder.group_keys, &self.step.impulses);
        self.factorizations += u64::from(self.step.factorizations);
        Ok(())
    }

    pub fn tell(&mut self, steps: u32, goes_on: &mut impl FnMut(&SettleProgress) -> ControlFlow<()>) {
        let [speed, slack] = self.unrest();
        let progress = SettleProgress { steps, factorizations: self.factorizations, speed, slack };
        self.is_ended = goes_on(&progress).is_break();
    }

    /// The largest velocity, and by how much contacts give way, relative to the velocity scale.
    fn unrest(&self) -> [f64; 2] {
        let scale = self.scale(&self.workspace, self.dt);
        [largest(&self.step.velocity), self.step.slack].map(|most| if most == 0.0 { 0.0 } else { most / scale })
    }

    /// The velocity scale of a workspace's problem. Where gravity is held without contacts, what it would do in a step of Δt is no part of
    /// the problem, but still what others are compared with.
    fn scale(&self, workspace: &Workspace, dt: f64) -> f64 {
        let problem = &workspace.builder.problem;
        let falling = self.model.gravity.length() * dt;
        problem.velocity_scale().max(largest(&problem.free_velocity)).max(falling)
    }

    /// Goes where the step leads, with a part of its velocity.
    pub fn advance(&mut self, momentum: f64) {
        let Self { model, state, step, .. } = self;
        let q = state.q.clone();
        integrate_into(model, &q, &step.velocity, self.dt, &mut state.q);
        state.v.iter_mut().zip(&step.velocity).for_each(|(v, next)| *v = momentum * next);
    }

    /// The most factorisations that an island took in the last step.
    pub fn most_factorizations(&self) -> u32 {
        self.step.most_factorizations
    }

    /// Makes the next steps so many times as long as the usual ones.
    pub fn set_stride(&mut self, stride: f64) {
        let (before, ws) = (self.dt, &mut self.workspace);
        self.dt = stride * self.usual_dt;
        if self.dt != before {
            self.step.impulses.scale_warm_part(self.dt / before);
            ws.warm.keep(&ws.builder.keys, &ws.builder.group_keys, &self.step.impulses);
        }
    }

    /// ε of the next step.
    fn adapt(&mut self, unrest: f64) {
        let most = self.step.most_factorizations;
        if most <= FEW {
            let aim = unrest.clamp(SMALLEST_EPSILON, USUAL_EPSILON);
            let epsilon = self.epsilon;
            self.epsilon = if epsilon > aim { (0.5 * epsilon).max(aim) } else { (2.0 * epsilon).min(aim) };
        } else if most > MANY {
            self.epsilon = (2.0 * self.epsilon).min(LARGEST_EPSILON);
        }
    }

    /// Asks Coulomb's laws: gives the simulation the present configuration without velocity, and makes ordinary steps from there
    /// until two in a row end where they began; not for the first time, the last one's velocity may be rounding. Returns the last
    /// one's report and the largest velocity before and after it. Otherwise the simulation is as it was.
    pub fn certify(&mut self, simulation: &mut Simulation) -> Result<Option<(StepReport, f64)>, SimulationError> {
        let before = simulation.state.clone();
        let mut state = self.state.clone().with_time(before.time).with_activation(before.activation.clone());
        state.v.fill(0.0);
        simulation.begin_at(&state);
        let (dt, mut impulses) = (simulation.timestep(), self.step.impulses.clone());
        impulses.scale_warm_part(dt / self.dt);
        let builder = &self.workspace.builder;
        simulation.workspace.warm.keep(&builder.keys, &builder.group_keys, &impulses);
        let mut still = false;
        for last in (0..LAST_STEPS).rev() {
            let Simulation { model, settings, workspace, state, next, input, .. } = &mut *simulation;
            let report = step(model, state, input, settings, workspace, next)?;
            if !report.advanced() || report.missed_tolerance {
                break;
            }
            let speed = largest(&next.v).max(largest(&state.v));
            let scale = self.scale(workspace, dt);
            if speed > MOVING * scale {
                break;
            }
            let was_still = std::mem::replace(&mut still, speed == 0.0 && next.q == state.q);
            let is_rounding = speed <= ROUNDING * scale;
            if still && was_still || last == 0 && self.refused && is_rounding {
                return Ok(Some((report, speed)));
            }
            next.time = state.time;
            next.activation.clone_from(&state.activation);
            std::mem::swap(state, next);
        }
        self.refused = true;
        simulation.begin_at(&before);
        Ok(None)
    }
}

fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |most: f64, v| most.max(v.abs()))
}
