//! Bringing a state to rest: on the way by steps that are easy to solve, at the end by Coulomb's laws.
//!
//! The steps of a pile that settles are the hardest there are, and what they are wanted for is often only where they end. Here the
//! way is one of convex problems ([`SettlingSolver`]) with a large Δt, in which velocity is taken away after every step. Their state
//! of rest is one of Coulomb's law, too, and an ordinary step with its certificate says so.

use std::ops::ControlFlow;
use std::sync::Arc;

use signorini_contact::{ProblemError, SettlingEffort, SettlingSolver, SettlingStep};
use signorini_multibody::{Joint, Model, State, integrate_into};

use crate::step::step;
use crate::{FrictionLaw, Settings, Simulation, SimulationError, StepReport, Workspace};

/// Δt of the steps over that of the simulation, where none is given.
const LONGER: f64 = 4.0;
/// Newton steps for an island, and those at the start, where no impulses are known.
const NEWTON_STEPS: u32 = 20;
const FIRST_NEWTON_STEPS: u32 = 60;
/// Problems that are solved at a start without velocity to see whether it rests: their first ε, its fall from one to the next and its
/// least value, that of the last ones, which take away what rounding leaves with a small one, and the part of the velocity that each of them may leave.
const LOOKS: u32 = 16;
const FIRST_EPSILON: f64 = 1e-3;
const FALL: f64 = 0.1;
const LEAST_EPSILON: f64 = 1e-8;
const LAST_EPSILON: f64 = 1e-4;
const SLOW: f64 = 0.5;
/// Limits of ε; a motion begins with the largest. With a large one what gives way has to be pushed back by many steps, with a small one bounds
/// of friction jump, because the normal impulses of redundant contacts do.
const LARGEST_EPSILON: f64 = 1e-2;
const SMALLEST_EPSILON: f64 = 1e-6;
/// ε above which it falls while anything moves by more than as small a part of the velocity scale.
const USUAL_EPSILON: f64 = 1e-4;
/// Up to so many factorisations of an island ε falls, from so many on it rises, by a factor of two.
const FEW: u32 = 7;
const MANY: u32 = 12;
/// Part of the velocity scale below which the laws are asked whether a state rests, and the steps until they are asked again; above the
/// first part and below the second one only when so many steps have not brought less.
const STILL: f64 = 1e-13;
const SHORT_PAUSE: u32 = 8;
const CALM: f64 = 1e-10;
const PAUSE: u32 = 30;
/// Steps after which speeds are compared, and the part of what is usual that is taken away in so many steps where they have not fallen to
/// the part [`SLOW`], squared where they have not for the second time; below that part of the velocity scale nothing slides far.
const WHILE: u32 = 30;
const FREER: f64 = 0.2;
const MOVING: f64 = 1e-6;
const FREEST: i32 = 2;
/// Ordinary steps until two in a row end where they began; each takes up the rounding of the one before.
const LAST_STEPS: u32 = 6;
/// Part of the velocity scale that is rounding. Forces that depend on the configuration, of springs and servos, cancel others up to
/// that.
const ROUNDING: f64 = 1e-12;

/// How a state is brought to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SettleSettings {
    /// Steps at most. Default 2000.
    pub max_steps: u32,
    /// Δt of these steps, s, or `None` for four times that of the simulation. What falls freely falls by `g Δt²` in a step; that
    /// should be some percent of a body's size.
    pub timestep: Option<f64>,
    /// Part of its velocity that a step takes over from the one before, in [0, 1). With 0 bodies fall and slide as through honey,
    /// with 0.9 and more they bounce and swing for long. Default 0.5.
    pub momentum: f64,
}

impl Default for SettleSettings {
    fn default() -> Self {
        Self { max_steps: 2000, timestep: None, momentum: 0.5 }
    }
}

impl SettleSettings {
    fn validate(&self) -> Result<(), SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        if let Some(dt) = self.timestep {
            check("settle.timestep", dt, "positive and finite", dt > 0.0 && dt.is_finite())?;
        }
        check("settle.momentum", self.momentum, "in [0, 1)", (0.0..1.0).contains(&self.momentum))
    }
}

/// How a state was brought to rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettleReport {
    /// Steps towards rest; 0 where the state rested.
    pub steps: u32,
    /// Factorisations in them, and in the look whether the state rested; 0 where it did.
    pub factorizations: u64,
    /// The ordinary step that ended where it began.
    pub at_rest: StepReport,
    /// The largest entry of the velocity after it, m/s or rad/s: zero, or rounding of at most 1e-12 of the velocity scale where springs
    /// or servos hold a load.
    pub speed: f64,
}

/// How far a state is from rest; see [`Simulation::settle_while`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettleProgress {
    /// Steps made; 0 while it is looked whether the start rests.
    pub steps: u32,
    /// Factorisations made.
    pub factorizations: u64,
    /// The largest entry of the last step's velocity, relative to the velocity scale.
    pub speed: f64,
    /// By how much contacts gave way in it, relative to the velocity scale.
    pub slack: f64,
}

impl Simulation {
    /// Brings the state to rest: to a configuration, near the present one, from which the next step ends with velocity zero.
    ///
    /// The way there is no simulation. Friction is that of the step before, contacts give way a little, and velocity is taken
    /// away ([`SettleSettings`]): bodies fall, slide and tumble until they lie. The end is exact: all velocities are zero (where springs or
    /// servos hold a load, [rounding](SettleReport::speed)), an ordinary step from there ends where it began, and its
    /// [certificate](StepReport::certificate) holds within the tolerance of the settings. The impulses of that step are the warm start of the next one. Time and input stay; the summary counts none of these steps. A
    /// state that rests stays where it is, to rounding.
    ///
    /// # Errors
    /// [`SimulationError::NotSettled`] if the steps are used up: something slides, rolls or falls for ever, or settles slowly. The
    /// state is then the one reached, with the velocity it has there. [`SimulationError::Setting`] for a setting out of its range,
    /// [`SimulationError::Incompatible`] with the circular cone;
    /// [`SimulationError::Problem`] for friction that is no contact's sliding (joints, servos, spinning, rolling), which
    /// these steps do not have; otherwise as for [`step`](Self::step).
    pub fn settle(&mut self, settings: &SettleSettings) -> Result<SettleReport, SimulationError> {
        self.settle_while(settings, |_| ControlFlow::Continue(()))
    }

    /// [`settle`](Self::settle), which for large piles takes minutes, with a function that is told after each step how far it is, and
    /// that may end it.
    ///
    /// # Errors
    /// As for [`settle`](Self::settle); [`SimulationError::NotSettled`] where the function ended it.
    pub fn settle_while(
        &mut self,
        settings: &SettleSettings,
        mut goes_on: impl FnMut(&SettleProgress) -> ControlFlow<()>,
    ) -> Result<SettleReport, SimulationError> {
        settings.validate()?;
        if self.settings.friction_law == FrictionLaw::Circular {
            let reason = "steps with the circular cone end with velocities of rounding, never at rest";
            return Err(SimulationError::Incompatible { settings: ["friction_law", "settle"], reason });
        }
        self.check_assembly()?;
        let mut settler = Settler::new(self, settings)?;
        let mut report = SettleReport::default();
        if self.state.v.iter().all(|v| *v == 0.0)
            && settler.seems_to_rest(self, &mut goes_on)?
            && let Some((at_rest, speed)) = settler.certify(self)?
        {
            return Ok(SettleReport { at_rest, speed, ..report });
        }
        let (mut calm, mut patience) = (Calm::default(), Patience::default());
        while report.steps < settings.max_steps && !settler.is_ended {
            let epsilon = settler.epsilon;
            settler.solve(self, SettlingEffort { epsilon, newton_steps: NEWTON_STEPS, associated: false })?;
            report.steps += 1;
            let [speed, slack] = settler.unrest();
            let unrest = speed.max(slack);
            settler.adapt(unrest);
            settler.advance(patience.momentum(speed, report.steps, settings.momentum));
            if calm.asks(unrest, report.steps)
                && let Some((at_rest, speed)) = settler.certify(self)?
            {
                return Ok(SettleReport { factorizations: settler.factorizations, at_rest, speed, ..report });
            }
            settler.tell(report.steps, &mut goes_on);
        }
        let time = self.state.time;
        self.begin_at(&State { time, ..settler.state.clone() });
        Err(self.not_settled(report.steps))
    }

    fn not_settled(&self, steps: u32) -> SimulationError {
        let v = &self.state.v;
        let fastest = (0..v.len()).fold(0, |a, b| if v[b].abs() > v[a].abs() { b } else { a });
        let moves = |joint: &&Joint| joint.v_index <= fastest;
        let body = self.model.joints.iter().filter(moves).max_by_key(|joint| joint.v_index).map(|joint| joint.body);
        SimulationError::NotSettled {
            steps,
            kinetic_energy: self.energy().0,
            body: body.map_or_else(String::new, |body| self.model.bodies[body.index()].name.clone()),
            speed: v.get(fastest).map_or(0.0, |v| v.abs()),
        }
    }
}

/// When the laws are asked whether a state rests.
struct Calm {
    /// The least unrest so far, but for the last factor of two, and the step it was met in.
    least: f64,
    met_at: u32,
    asked_at: u32,
}

impl Default for Calm {
    fn default() -> Self {
        Self { least: f64::INFINITY, met_at: 0, asked_at: 0 }
    }
}

impl Calm {
    /// Where nothing moves beyond rounding, or where unrest is small and falls no longer.
    fn asks(&mut self, unrest: f64, steps: u32) -> bool {
        if unrest < 0.5 * self.least {
            (self.least, self.met_at) = (unrest, steps);
        }
        let is_lasting = unrest <= CALM && steps >= self.met_at.max(self.asked_at) + PAUSE;
        let asks = is_lasting || (unrest <= STILL && steps >= self.asked_at + SHORT_PAUSE);
        if asks {
            self.asked_at = steps;
        }
        asks
    }
}

/// How much velocity is taken away: less for a while where nothing has become slower, so that what slides far does it sooner.
#[derive(Default)]
struct Patience {
    /// The least speed of the last [`WHILE`] steps and of those before them.
    least: f64,
    earlier: f64,
    /// How many times in a row it was more than a part of the latter.
    slow: i32,
}

impl Patience {
    fn momentum(&mut self, speed: f64, steps: u32, usual: f64) -> f64 {
        if steps % WHILE == 1 {
            let is_slow = steps > WHILE && self.least > (SLOW * self.earlier).max(MOVING);
            self.slow = if is_slow { (self.slow + 1).min(FREEST) } else { 0 };
            self.earlier = if steps == 1 { f64::INFINITY } else { self.least };
            self.least = f64::INFINITY;
        }
        self.least = self.least.min(speed);
        1.0 - (1.0 - usual) * FREER.powi(self.slow)
    }
}

/// The steps towards rest.
struct Settler {
    model: Arc<Model>,
    workspace: Workspace,
    solver: SettlingSolver,
    step: SettlingStep,
    state: State,
    dt: f64,
    epsilon: f64,
    factorizations: u64,
    /// Whether Coulomb's laws were asked and have not found rest.
    refused: bool,
    /// Whether it was ended from outside.
    is_ended: bool,
}

impl Settler {
    fn new(simulation: &Simulation, settings: &SettleSettings) -> Result<Self, SimulationError> {
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
            epsilon: LARGEST_EPSILON,
            factorizations: 0,
            refused: false,
            is_ended: false,
        })
    }

    /// Whether impulses are found that hold the start, without going anywhere.
    fn seems_to_rest(
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

    /// Solves the problem of a step from the present state, around the impulses of the last one.
    fn solve(&mut self, simulation: &Simulation, effort: SettlingEffort) -> Result<(), SimulationError> {
        let Self { model, workspace: ws, state, .. } = self;
        state.check(model)?;
        ws.begin(model, state, &simulation.input, self.dt)?;
        ws.build_problem(model, state, &simulation.input);
        let earlier = ws.warm.start_for(&ws.builder.keys, &ws.builder.group_keys);
        let solved = self.solver.step_into(&ws.builder.problem, earlier, &state.v, effort, &mut self.step);
        solved.map_err(ProblemError::from)?;
        ws.warm.keep(&ws.builder.keys, &ws.builder.group_keys, &self.step.impulses);
        self.factorizations += u64::from(self.step.factorizations);
        Ok(())
    }

    fn tell(&mut self, steps: u32, goes_on: &mut impl FnMut(&SettleProgress) -> ControlFlow<()>) {
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
    fn advance(&mut self, momentum: f64) {
        let Self { model, state, step, .. } = self;
        let q = state.q.clone();
        integrate_into(model, &q, &step.velocity, self.dt, &mut state.q);
        state.v.iter_mut().zip(&step.velocity).for_each(|(v, next)| *v = momentum * next);
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
    /// one's report and its largest velocity. Otherwise the simulation is as it was.
    fn certify(&mut self, simulation: &mut Simulation) -> Result<Option<(StepReport, f64)>, SimulationError> {
        let before = simulation.state.clone();
        let mut state = State { time: before.time, activation: before.activation.clone(), ..self.state.clone() };
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
            let speed = largest(&next.v);
            let was_still = std::mem::replace(&mut still, speed == 0.0 && next.q == state.q);
            let is_rounding = || speed <= ROUNDING * self.scale(workspace, dt);
            if still && was_still || last == 0 && self.refused && is_rounding() {
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
