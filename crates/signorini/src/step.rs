//! One time step (formulation §6), on one screen.

use signorini_collision::Collider;
use signorini_contact::{
    BilateralBasis, Certificate, ConeCertificate, ContactFrame, ContactProblem, ContactSolution, LeastNormOutcome,
    SolveReport, SolveStatus,
};
use signorini_multibody::{
    BlockDiagonal, ContactPoint, FreeMotion, Input, JointId, Kinematics, Model, State, TendonId,
    advance_activations_into, forward_kinematics_into, free_motion_into, integrate_into,
};

use crate::SimulationError;
use crate::assembly::Assembler;
use crate::build::{FrictionSource, ProblemBuilder};
use crate::inverse::DrivenVelocity;
use crate::reach::BodyReach;
use crate::rest::FixedPoint;
use crate::restitution::decompression as decompression_problem;
use crate::sensors::SensorWork;
use crate::settings::{InfeasiblePolicy, RestitutionLaw, Settings};
use crate::solver::{CertifiedLaw, StepSolver, Verdict};
use crate::warm::{WarmCache, limit_of};

/// How often a step is found and solved again because a body moved farther than its reach.
const MAX_ENLARGEMENTS: u32 = 8;

/// A dependent row contradicts the others where it is off by this fraction of the velocity scale.
const CONTRADICTION: f64 = 1e-7;

/// How a step went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// How the contact problem ended. The state was advanced unless this is a ray or infeasible.
    pub status: SolveStatus,
    /// The friction law that the certificate speaks of.
    pub law: CertifiedLaw,
    /// Residuals of the laws of this step.
    pub certificate: Certificate,
    /// Residuals of the circular cone's laws, where the settings ask for them: with [`FrictionLaw::Circular`](crate::FrictionLaw)
    /// the same numbers, with `Refined` beside those of the polygon that the directions of the step's problem make.
    pub cone_certificate: Option<ConeCertificate>,
    /// What became of the impulses of least norm, where the settings ask for them.
    pub least_norm: Option<LeastNormOutcome>,
    /// What the solver did, summed over the solves of the step.
    pub solver: SolveReport,
    /// Contacts in the problem, joint limits included.
    pub contacts: usize,
    /// Whether the worst residual exceeds the tolerance, or that of the circular cone's laws exceeds its own.
    pub missed_tolerance: bool,
    /// Whether negative gaps were taken as zero ([`InfeasiblePolicy::ClipGaps`]).
    pub clipped_gaps: bool,
    /// Contacts that restore velocity in this step.
    pub impacts: usize,
    /// Largest |Θ| of the equality constraints at the beginning of the step, m or rad.
    pub constraint_error: f64,
    /// How often contacts were found anew because a body moved farther than expected.
    pub enlargements: u32,
    /// Bodies that turn too fast for Δt for their gyroscopic torque to be integrated; it was left out
    /// ([`FreeMotion::unresolved_rotations`]).
    pub unresolved_rotations: usize,
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
    pub(crate) assembler: Assembler,
    pub(crate) decompression: Decompression,
    pub(crate) smooth: FreeMotion,
    pub(crate) sensors: SensorWork,
    pub(crate) collider: Collider,
    pub(crate) reach: BodyReach,
    pub(crate) solver: StepSolver,
    pub(crate) fixed_point: FixedPoint,
    pub(crate) warm: WarmCache,
}

/// The second half of the impacts of a step.
pub(crate) struct Decompression {
    pub happened: bool,
    pub problem: ContactProblem,
    pub solution: ContactSolution,
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
        let collider = Collider::new(model)?;
        Ok(Self {
            kinematics: Kinematics::new(model),
            points: Vec::new(),
            solution: ContactSolution::default(),
            decompression: Decompression {
                happened: false,
                problem: problem.clone(),
                solution: ContactSolution::default(),
            },
            builder: ProblemBuilder::new(model, problem, polygon, settings),
            assembler: Assembler::new(model, settings.assembly_tolerance),
            smooth: FreeMotion::new(model),
            sensors: SensorWork::new(model),
            reach: BodyReach::new(model, &collider),
            collider,
            solver: StepSolver::new(settings)?,
            warm: WarmCache::default(),
            fixed_point: FixedPoint::default(),
        })
    }

    /// Contact points of the last step; joint limits are not among them.
    pub fn contact_points(&self) -> &[ContactPoint] {
        &self.points
    }

    /// The contact whose overlap the last step had to remove fastest, and how fast, m/s, where that is more than 1 m/s: what a start
    /// inside the floor looks like. Where negative gaps were taken as zero there is none.
    pub fn sudden_overlap(&self) -> Option<(&ContactPoint, f64)> {
        let problem = &self.builder.problem;
        // The problem's gap is less where an overlap goes in parts, and not the distance where contacts bounce.
        let overlap = |(point, gap): (&ContactPoint, &f64)| point.gap.max(*gap) / -problem.timestep;
        let speeds = self.points.iter().zip(&problem.gap).map(overlap);
        let fastest = self.points.iter().zip(speeds).max_by(|a, b| a.1.total_cmp(&b.1));
        fastest.filter(|(_, speed)| *speed > 1.0)
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

    /// What friction group `j` of the [problem](Self::problem) comes from.
    pub fn friction_source(&self, j: usize) -> Option<FrictionSource> {
        self.builder.friction_source.get(j).copied()
    }

    /// The index of the equality constraint that bilateral row `k` of the [problem](Self::problem) belongs to.
    pub fn bilateral_source(&self, k: usize) -> Option<usize> {
        self.builder.bilateral_source.get(k).map(|source| source.equality)
    }

    /// Problem and solution of the decompression, where the last step had one (Poisson's law of restitution): the
    /// [problem](Self::problem) is then that of the compression, and the impulses of the step are the sum of `e` times those of the
    /// compression, of the compression's, and of these ([`contact_impulse`](Self::contact_impulse)).
    pub fn decompression(&self) -> Option<(&ContactProblem, &ContactSolution)> {
        self.decompression.happened.then_some((&self.decompression.problem, &self.decompression.solution))
    }

    /// The solution of the last step.
    pub fn solution(&self) -> &ContactSolution {
        &self.solution
    }

    /// The impulse (normal, tangent 1, tangent 2) of contact `i` over the whole last step, N·s: its own, that of a belt, and
    /// both phases of an impact.
    pub fn contact_impulse(&self, i: usize) -> [f64; 3] {
        let mut sum = self.solution.impulse[i];
        let along = |problem: &ContactProblem, solution: &ContactSolution| {
            let belongs =
                |j: &usize| problem.friction_groups.bound[*j].normal().is_some_and(|(contact, _)| contact == i);
            // The tangents of a contact come before its spinning and rolling.
            let first = (0..problem.friction_groups.len()).find(belongs);
            first.map_or([0.0; 2], |j| solution.group_impulse[j])
        };
        let belt = self.builder.friction_source.contains(&FrictionSource::Belt { contact: i });
        let mut add = |[t_1, t_2]: [f64; 2]| {
            sum[1] += t_1;
            sum[2] += t_2;
        };
        if belt {
            add(along(&self.builder.problem, &self.solution));
        }
        if let Some((problem, solution)) = self.decompression() {
            if belt || !self.builder.problem.directions_of(i).is_empty() {
                add(along(problem, solution));
            }
            let impact = self.builder.impacts.iter().find(|impact| impact.contact == i);
            let restored = impact.map_or(0.0, |impact| impact.restitution * self.solution.lambda_n[i]);
            sum[0] += restored + solution.lambda_n[i];
        }
        sum
    }

    /// The impulse of friction group `j` over the whole last step: both phases of an impact.
    pub(crate) fn group_impulse(&self, j: usize) -> [f64; 2] {
        let [mut first, mut second] = self.solution.group_impulse[j];
        let of_contacts = &self.builder.problem.friction_groups.bound;
        let bounded = of_contacts.iter().take_while(|bound| bound.normal().is_some()).count();
        // The groups of the decompression are the tangents of contacts and then those groups that contacts bound, in their order.
        if let Some((problem, solution)) = self.decompression()
            && j < bounded
        {
            let [x, y] = solution.group_impulse[problem.friction_groups.len() - bounded + j];
            (first, second) = (first + x, second + y);
        }
        [first, second]
    }

    /// The impulse of bilateral row `k` over the whole last step: both phases of an impact.
    pub(crate) fn bilateral_impulse(&self, k: usize) -> f64 {
        self.solution.bilateral[k] + self.decompression().map_or(0.0, |(_, solution)| solution.bilateral[k])
    }

    /// The last solution in the form that the next step starts from, as plain numbers: stored with `(t, q, v)` and given
    /// back to [`set_warm_start`](Self::set_warm_start), a run goes on with the same bits.
    pub fn warm_start(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.warm.write(&mut numbers);
        numbers
    }

    /// Takes over a [`warm_start`](Self::warm_start) of the same model.
    ///
    /// # Errors
    /// [`SimulationError::WarmStart`] if the numbers are not those of a warm start; nothing has changed then.
    pub fn set_warm_start(&mut self, numbers: &[f64]) -> Result<(), SimulationError> {
        self.fixed_point.clear();
        self.warm.read(numbers).ok_or(SimulationError::WarmStart { found: numbers.len() })
    }

    /// Forgets the last solution, so that the next step starts cold.
    pub fn clear_warm_start(&mut self) {
        self.fixed_point.clear();
        self.warm.clear();
    }
}

/// Advances a state by Δt: kinematics → contacts → free motion → contact problem → solution → next state.
///
/// - `state`: `(t, q, v)` and activations; `next`: out, same sizes
/// - `input`: what acts during the step
///
/// Where the contact problem has no solution, `next` is the unchanged state and the report says so.
///
/// # Errors
/// [`SimulationError::FreeMotion`] if the state or input does not fit the model, is not finite, or the mass matrix is
/// singular there; [`SimulationError::Problem`] if the contact problem is malformed; [`SimulationError::ContradictingEqualities`] if
/// equality constraints exclude each other.
pub fn step(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    workspace: &mut Workspace,
    next: &mut State,
) -> Result<StepReport, SimulationError> {
    let dt = settings.timestep.unwrap_or(model.timestep);
    if settings.sleeping
        && let Some(report) = workspace.stay(state, input, settings, dt, next)
    {
        return Ok(report);
    }
    let report = step_driven(model, state, input, settings, &[], workspace, next)?;
    if settings.sleeping {
        workspace.fixed_point.observe(state, input, next, dt, &report);
    }
    Ok(report)
}

/// [`step`] in which some degrees of freedom end with a given velocity, whatever torque that takes: each is a bilateral row
/// `v⁺_k = target`, after those of the model.
pub(crate) fn step_driven(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    driven: &[DrivenVelocity],
    workspace: &mut Workspace,
    next: &mut State,
) -> Result<StepReport, SimulationError> {
    let dt = settings.timestep.unwrap_or(model.timestep);
    let ws = workspace;
    state.check(model)?;
    ws.begin(model, state, input, dt)?;
    let mut report = StepReport { unresolved_rotations: ws.smooth.unresolved_rotations, ..StepReport::default() };
    loop {
        ws.build_problem(model, state, input);
        for drive in driven {
            ws.builder.problem.push_bilateral([(drive.dof as u32, [1.0])], -dt * drive.velocity);
        }
        let unchanged = || !report.clipped_gaps && ws.solver.keeps_directions() && ws.warm.holds(&ws.builder.keys);
        if report.enlargements > 0 && unchanged() {
            break; // The larger reach has no new contacts: the solution at hand is that of the step.
        }
        ws.solve(settings, &mut report)?;
        ws.name_contradiction(model)?;
        while report.advanced() && ws.builder.add_crossed_limits(model, state, &ws.solution.velocity) {
            ws.solve(settings, &mut report)?;
        }
        if report.advanced() {
            ws.warm.keep(&ws.builder.keys, &ws.builder.group_keys, &ws.solution);
        }
        let last = report.enlargements == MAX_ENLARGEMENTS || !report.advanced();
        if last || !ws.reach.enlarge(model, &ws.kinematics, &ws.solution.velocity, dt) {
            break;
        }
        report.enlargements += 1;
    }
    ws.decompress(settings, &mut report)?;
    next.time = state.time;
    next.q.clone_from(&state.q);
    next.v.clone_from(&state.v);
    next.activation.clone_from(&state.activation);
    if report.advanced() {
        next.time = state.time + dt;
        advance_activations_into(model, state, input, dt, &mut next.activation);
        next.v.copy_from_slice(ws.end_velocity());
        integrate_into(model, &state.q, &next.v, dt, &mut next.q);
        if settings.position_iterations > 0 && !model.equalities.is_empty() {
            ws.assembler.project(model, &ws.builder.problem.mass_factor, &mut next.q, settings.position_iterations);
        }
    }
    Ok(report)
}

impl Workspace {
    /// What comes before the contacts of a step: kinematics, free motion, and how far bodies can move.
    pub(crate) fn begin(
        &mut self,
        model: &Model,
        state: &State,
        input: &Input,
        dt: f64,
    ) -> Result<(), SimulationError> {
        self.fixed_point.clear();
        forward_kinematics_into(model, &state.q, &state.v, &mut self.kinematics);
        free_motion_into(model, &self.kinematics, state, input, dt, &mut self.smooth)?;
        self.builder.take_smooth(&mut self.smooth, dt);
        self.reach.start(model, &self.kinematics, &self.builder.problem.free_velocity, dt);
        Ok(())
    }

    /// Finds the contacts within reach and builds the step's problem.
    pub(crate) fn build_problem(&mut self, model: &Model, state: &State, input: &Input) {
        self.collider.find(model, &self.kinematics.pose, &self.reach.reach, &mut self.points);
        self.builder.build(model, state, input, &self.kinematics, &self.points);
    }

    /// Solves the problem at hand and writes how it went to the report.
    fn solve(&mut self, settings: &Settings, report: &mut StepReport) -> Result<(), SimulationError> {
        let mut verdict = self.solve_once()?;
        let unsolvable = matches!(self.solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        if unsolvable && settings.infeasible == InfeasiblePolicy::ClipGaps && self.builder.clip_gaps() {
            report.clipped_gaps = true;
            verdict = self.solve_once()?;
        }
        report.status.clone_from(&self.solution.status);
        report.law = verdict.law;
        report.certificate = verdict.certificate;
        report.cone_certificate = verdict.cone;
        report.least_norm = verdict.least_norm;
        report.solver.accumulate(&self.solution.report);
        report.contacts = self.builder.problem.contact_count();
        report.missed_tolerance = !verdict.holds;
        Ok(())
    }

    fn solve_once(&mut self) -> Result<Verdict, SimulationError> {
        let start = self.warm.start_for(&self.builder.keys, &self.builder.group_keys);
        self.solver.solve_into(&mut self.builder.problem, Some(start), &mut self.solution)
    }

    /// The decompression after impacts, by Poisson's law.
    fn decompress(&mut self, settings: &Settings, report: &mut StepReport) -> Result<(), SimulationError> {
        report.impacts = self.builder.impacts.len();
        report.constraint_error = self.builder.constraint_error;
        let Self { builder, decompression, solver, solution, .. } = self;
        decompression.happened = settings.restitution == RestitutionLaw::Poisson
            && report.advanced()
            && builder.impacts.iter().any(|impact| solution.lambda_n[impact.contact] > 0.0);
        if !decompression.happened {
            return Ok(());
        }
        decompression_problem(&builder.problem, solution, &builder.impacts, &mut decompression.problem);
        let verdict = solver.solve_into(&mut decompression.problem, None, &mut decompression.solution)?;
        report.status.clone_from(&decompression.solution.status);
        report.certificate.merge(&verdict.certificate);
        if let (Some(first), Some(second)) = (&mut report.cone_certificate, &verdict.cone) {
            first.merge(second);
        }
        report.solver.accumulate(&decompression.solution.report);
        report.missed_tolerance |= !verdict.holds;
        Ok(())
    }

    /// The velocity at the end of the step.
    pub(crate) fn end_velocity(&self) -> &[f64] {
        if self.decompression.happened { &self.decompression.solution.velocity } else { &self.solution.velocity }
    }

    /// Where equality constraints alone have no solution, the error that names them.
    fn name_contradiction(&self, model: &Model) -> Result<(), SimulationError> {
        let problem = &self.builder.problem;
        if self.solution.status == SolveStatus::Solved || problem.bilateral_violation.is_empty() {
            return Ok(());
        }
        let rates = problem.bilateral_violation.iter().enumerate().map(|(k, theta)| {
            problem.bilateral_jacobian.multiply(k, &problem.free_velocity)[0] + theta / problem.timestep
        });
        let rates: Vec<f64> = rates.collect();
        let mut basis = BilateralBasis::default();
        basis.factor(&problem.bilateral_jacobian, &problem.mass_factor, problem.nv());
        let rows = basis.contradiction(&rates, CONTRADICTION * problem.velocity_scale());
        // Driven degrees of freedom come after the constraints and have no source.
        let mut constraints: Vec<usize> = rows.iter().filter_map(|&k| self.bilateral_source(k)).collect();
        constraints.dedup();
        if constraints.is_empty() {
            return Ok(());
        }
        let names = constraints.iter().map(|&e| model.equalities[e].name.clone()).collect();
        Err(SimulationError::ContradictingEqualities { names })
    }
}
