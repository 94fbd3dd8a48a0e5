//! One time step (formulation §6), on one screen.

use signorini_collision::Collider;
use signorini_contact::{
    Certificate, ContactFrame, ContactProblem, ContactSolution, ContactSolver, SolveReport, SolveStatus, solve_as_lcp,
};
use signorini_lcp::Method;
use signorini_multibody::{
    BlockDiagonal, ContactPoint, FreeMotion, Input, JointId, Kinematics, Model, State, TendonId,
    forward_kinematics_into, free_motion_into, integrate_into,
};

use crate::SimulationError;
use crate::build::ProblemBuilder;
use crate::reach::BodyReach;
use crate::sensors::SensorWork;
use crate::settings::{ContactMethod, InfeasiblePolicy, Settings};
use crate::warm::{WarmCache, limit_of};

/// How often a step is found and solved again because a body moved farther than its reach.
const MAX_ENLARGEMENTS: u32 = 8;

/// How a step went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// How the contact problem ended. The state was advanced unless this is a ray or infeasible.
    pub status: SolveStatus,
    /// Residuals of the laws of this step.
    pub certificate: Certificate,
    /// What the solver did, summed over the solves of the step.
    pub solver: SolveReport,
    /// Contacts in the problem, joint limits included.
    pub contacts: usize,
    /// Whether the worst residual exceeds the tolerance.
    pub missed_tolerance: bool,
    /// Whether negative gaps were taken as zero ([`InfeasiblePolicy::ClipGaps`]).
    pub clipped_gaps: bool,
    /// How often contacts were found anew because a body moved farther than expected.
    pub enlargements: u32,
}

impl StepReport {
    /// Whether the state was advanced.
    pub fn advanced(&self) -> bool {
        !matches!(self.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. })
    }
}

/// What a contact of a step's problem comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactSource {
    /// Two geoms that touch or could touch.
    Point(ContactPoint),
    /// A limit of a joint.
    Limit {
        /// The joint.
        joint: JointId,
        /// Whether it is the upper limit.
        upper: bool,
    },
    /// A limit of a tendon.
    TendonLimit {
        /// The tendon.
        tendon: TendonId,
        /// Whether it is the upper limit.
        upper: bool,
    },
}

/// Everything a step needs besides model and state; made once, so that a step allocates nothing.
pub struct Workspace {
    pub(crate) kinematics: Kinematics,
    pub(crate) points: Vec<ContactPoint>,
    pub(crate) solution: ContactSolution,
    pub(crate) builder: ProblemBuilder,
    pub(crate) smooth: FreeMotion,
    pub(crate) sensors: SensorWork,
    collider: Collider,
    reach: BodyReach,
    solver: Solver,
    warm: WarmCache,
}

enum Solver {
    Structured(Box<ContactSolver>),
    Lcp { method: Box<dyn Method>, tolerance: f64 },
}

impl Workspace {
    /// Prepares a model for stepping.
    ///
    /// # Errors
    /// [`SimulationError`] if a setting is out of its range or a shape cannot be prepared.
    pub fn new(model: &Model, settings: &Settings) -> Result<Self, SimulationError> {
        let polygon = settings.validate()?;
        // The problem starts with the identity in the model's blocks; every step exchanges it for the step's own matrix.
        let mut mass = BlockDiagonal::new(model);
        (0..model.nv).for_each(|k| mass.add_to_diagonal(k, 1.0));
        let problem = ContactProblem::new(mass, vec![0.0; model.nv], settings.timestep.unwrap_or(model.timestep))?;
        let solver = match &settings.method {
            ContactMethod::Structured(solver) => Solver::Structured(Box::new(ContactSolver::new(solver.clone())?)),
            ContactMethod::Lcp(kind) => {
                let method = kind.build().map_err(signorini_contact::ProblemError::from)?;
                Solver::Lcp { method, tolerance: settings.tolerance }
            }
        };
        Ok(Self {
            kinematics: Kinematics::new(model),
            points: Vec::new(),
            solution: ContactSolution::default(),
            builder: ProblemBuilder::new(model, problem, polygon, settings.stabilization),
            smooth: FreeMotion::new(model),
            sensors: SensorWork::new(model),
            collider: Collider::new(model)?,
            reach: BodyReach::default(),
            solver,
            warm: WarmCache::default(),
        })
    }

    /// Contact points of the last step; joint limits are not among them.
    pub fn contact_points(&self) -> &[ContactPoint] {
        &self.points
    }

    /// Frames of the contact points.
    pub fn contact_frames(&self) -> &[ContactFrame] {
        &self.builder.frames
    }

    /// The contact problem of the last step: first the contact points in their order, then limits of
    /// joints and tendons.
    pub fn problem(&self) -> &ContactProblem {
        &self.builder.problem
    }

    /// What contact `i` of the [problem](Self::problem) comes from.
    pub fn contact_source(&self, i: usize) -> Option<ContactSource> {
        if let Some(point) = self.points.get(i) {
            return Some(ContactSource::Point(*point));
        }
        self.builder.keys.get(i).map(limit_of)
    }

    /// The solution of the last step.
    pub fn solution(&self) -> &ContactSolution {
        &self.solution
    }

    /// Forgets the last solution, so that the next step starts cold.
    pub fn clear_warm_start(&mut self) {
        self.warm.clear();
    }
}

/// Advances a state by Δt: kinematics → contacts → free motion → contact problem → solution → next state.
///
/// - `state`: `(t, q, v)`; `next`: out, same sizes
/// - `input`: what acts during the step
///
/// Where the contact problem has no solution, `next` is the unchanged state and the report says so.
///
/// # Errors
/// [`SimulationError::FreeMotion`] if the state or input does not fit the model, is not finite, or the mass matrix is
/// singular there; [`SimulationError::Problem`] if the contact problem is malformed.
pub fn step(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    workspace: &mut Workspace,
    next: &mut State,
) -> Result<StepReport, SimulationError> {
    let dt = settings.timestep.unwrap_or(model.timestep);
    let ws = workspace;
    state.check(model)?;
    forward_kinematics_into(model, &state.q, &state.v, &mut ws.kinematics);
    free_motion_into(model, &ws.kinematics, state, input, dt, &mut ws.smooth)?;
    ws.builder.take_smooth(&mut ws.smooth, dt);
    ws.reach.start(model, &ws.kinematics, [&state.v, &ws.builder.problem.free_velocity], dt);
    let mut report = StepReport::default();
    loop {
        ws.collider.find(model, &ws.kinematics.pose, &ws.reach.reach, &mut ws.points);
        ws.builder.build(model, state, &ws.kinematics, &ws.points);
        if report.enlargements > 0 && !report.clipped_gaps && ws.warm.holds(&ws.builder.keys) {
            break; // The larger reach has no new contacts: the solution at hand is that of the step.
        }
        ws.solve(settings, &mut report)?;
        while report.advanced() && ws.builder.add_crossed_limits(model, state, &ws.solution.velocity) {
            ws.solve(settings, &mut report)?;
        }
        if report.advanced() {
            ws.warm.keep(&ws.builder.keys, &ws.solution);
        }
        let last = report.enlargements == MAX_ENLARGEMENTS || !report.advanced();
        if last || !ws.reach.enlarge(model, &ws.kinematics, &ws.solution.velocity, dt) {
            break;
        }
        report.enlargements += 1;
    }
    next.time = state.time;
    next.q.clone_from(&state.q);
    next.v.clone_from(&state.v);
    if report.advanced() {
        next.time = state.time + dt;
        next.v.copy_from_slice(&ws.solution.velocity);
        integrate_into(model, &state.q, &next.v, dt, &mut next.q);
    }
    Ok(report)
}

impl Workspace {
    /// Solves the problem at hand and writes how it went to the report.
    fn solve(&mut self, settings: &Settings, report: &mut StepReport) -> Result<(), SimulationError> {
        self.solve_once()?;
        let unsolvable = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if unsolvable && settings.infeasible == InfeasiblePolicy::ClipGaps && self.builder.clip_gaps() {
            report.clipped_gaps = true;
            self.solve_once()?;
        }
        report.status.clone_from(&self.solution.status);
        report.certificate = self.solution.certificate;
        report.solver.accumulate(&self.solution.report);
        report.contacts = self.builder.problem.contact_count();
        report.missed_tolerance = !self.solution.certificate.holds(settings.tolerance);
        Ok(())
    }

    fn solve_once(&mut self) -> Result<(), SimulationError> {
        let problem = &self.builder.problem;
        match &mut self.solver {
            Solver::Structured(solver) => {
                let start = self.warm.start_for(&self.builder.keys);
                solver.solve_into(problem, Some(start), &mut self.solution);
            }
            Solver::Lcp { method, tolerance } => self.solution = solve_as_lcp(problem, method.as_mut(), *tolerance)?,
        }
        Ok(())
    }
}
