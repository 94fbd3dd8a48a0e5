//! The derivative of a step at its solution.

use signorini_contact::{ContactSolution, SolveStatus};
use signorini_multibody::derivatives::{BalanceAt, BalanceDerivatives, MotionDerivatives, balance_derivatives_into};
use signorini_multibody::{Input, Model, State};
use signorini_simulation::{FrictionLaw, Settings, StepReport, Workspace};

use crate::columns::VelocityColumns;
use crate::integration::Integration;
use crate::interior::Interior;
use crate::matrix::{Rows, largest};
use crate::mode::{Scales, TIE, is_tie};
use crate::parameter::{Direction, add_smooth};
use crate::redundancy::{departing_constraint, note_parameters, note_redundancy};
use crate::rows::{LeftOut, Modes, Scratch, Step, TieRows, balances, build};
use crate::system::ModeSystem;
use crate::tie::TieUnit;
use crate::validity::{InequalityKind, InequalitySource, Margin, Validity};

/// The derivative of one step, `(q⁺, v⁺)` by `(q, v)`, by the control `u` and by the applied generalized force `τ`, and the storage to compute
/// it.
///
/// Configurations are in tangent coordinates at both ends: `q ⊕ δq` with rotations multiplied from the right, so that `δq` has the axes of
/// `v` ([`integrate_into`](signorini_multibody::integrate_into), `NOTATION.md`).
#[derive(Clone, Debug)]
pub struct StepDerivatives {
    pub(crate) nv: usize,
    pub(crate) nu: usize,
    pub(crate) dt: f64,
    pub(crate) directions: Vec<Direction>,
    asks_twice: bool,
    validity: Validity,
    margins: Vec<Margin>,
    pub(crate) has_matrices: bool,
    pub(crate) balance: BalanceDerivatives,
    end: MotionDerivatives,
    modes: Modes,
    interior: Interior,
    chosen: ContactSolution,
    turning: Vec<f64>,
    /// `∂E` by each direction of parameters.
    smooth: Rows,
    /// Contacts at ties.
    pub(crate) ties: Vec<TieUnit>,
    pub(crate) tie_rows: TieRows,
    left_out: LeftOut,
    pub(crate) system: ModeSystem,
    pub(crate) columns: VelocityColumns,
    pub(crate) integration: Integration,
    /// `v⁺`.
    pub(crate) velocity: Vec<f64>,
    /// Inequalities of the last verdict, for their memory.
    deciding: Vec<Margin>,
    scratch: Scratch,
    work: Vec<f64>,
}

impl StepDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            nv: model.nv,
            nu: model.actuators.len(),
            dt: model.timestep,
            asks_twice: false,
            validity: Validity::Refused { reason: "no step was given".into() },
            margins: Vec::new(),
            has_matrices: false,
            balance: BalanceDerivatives::new(model),
            end: MotionDerivatives::new(model),
            modes: Modes::default(),
            interior: Interior::default(),
            chosen: ContactSolution::default(),
            directions: Vec::new(),
            turning: Vec::new(),
            smooth: Rows::default(),
            ties: Vec::new(),
            tie_rows: TieRows::default(),
            left_out: LeftOut::default(),
            system: ModeSystem::default(),
            columns: VelocityColumns::default(),
            integration: Integration::default(),
            velocity: Vec::new(),
            deciding: Vec::new(),
            scratch: Scratch::default(),
            work: Vec::new(),
        }
    }

    /// The same with columns for numbers of the model, a column for each direction ([`parameter_matrix`](Self::parameter_matrix)).
    pub fn with_parameters(model: &Model, directions: Vec<Direction>) -> Self {
        Self { directions, ..Self::new(model) }
    }

    /// The same with a second look, which costs another solution of the step's problem: it is solved without the start that the step had from the one
    /// before, and where that leads to another velocity the derivative is refused, as `v⁺` is not unique. Friction admits several solutions now and
    /// then, each with a derivative of its own; that a second one is not found this way does not mean that there is none.
    pub fn asking_twice(mut self) -> Self {
        self.asks_twice = true;
        self
    }

    /// Takes the step that `workspace` has just made.
    ///
    /// - `state`, `input`: of the step, at its beginning
    /// - `settings`, `report`: of the step
    pub fn compute(
        &mut self,
        model: &Model,
        (state, input): (&State, &Input),
        settings: &Settings,
        report: &StepReport,
        workspace: &mut Workspace,
    ) {
        self.margins.clear();
        (self.has_matrices, self.columns.is_current) = (false, false);
        if let Validity::OneSided { deciding } = &mut self.validity {
            self.deciding = std::mem::take(deciding);
        }
        self.validity = match self.differentiate(model, (state, input), settings, report, workspace) {
            Err(reason) => Validity::Refused { reason },
            Ok(()) => {
                self.has_matrices = true;
                self.judge(model)
            }
        };
    }

    /// Has no derivative.
    pub(crate) fn refuse(&mut self, reason: String) {
        self.margins.clear();
        (self.has_matrices, self.columns.is_current) = (false, false);
        self.validity = Validity::Refused { reason };
    }

    fn differentiate(
        &mut self,
        model: &Model,
        (state, input): (&State, &Input),
        settings: &Settings,
        report: &StepReport,
        workspace: &mut Workspace,
    ) -> Result<(), String> {
        refuse(model, settings, report, workspace)?;
        self.dt = workspace.problem().timestep;
        let mut velocity = std::mem::take(&mut self.velocity);
        velocity.clone_from(&workspace.solution().velocity);
        let result = self.at(&velocity, model, (state, input), settings, workspace);
        self.velocity = velocity;
        result
    }

    /// The same at `v⁺`.
    fn at(
        &mut self,
        velocity: &[f64],
        model: &Model,
        (state, input): (&State, &Input),
        settings: &Settings,
        workspace: &mut Workspace,
    ) -> Result<(), String> {
        self.end.set(model, workspace.kinematics(), velocity);
        self.balance.dynamics.motion.set(model, workspace.kinematics(), &state.v);
        let at_rest = rest_speed(model, self.dt);
        let scales = Scales::of(workspace.problem(), [&state.v, velocity], at_rest, &mut self.work);
        if self.asks_twice && ends_elsewhere(workspace, velocity, scales) {
            return Err(
                "the velocity is not unique: without the start of the step its problem has another solution".into()
            );
        }
        let begin = &self.balance.dynamics.motion;
        copy_solution(workspace.solution(), &mut self.chosen);
        self.modes.set(workspace.problem(), &self.chosen, scales, &mut self.margins);
        if self.interior.choose(workspace.problem(), scales, &self.modes.ties, &mut self.chosen) {
            self.margins.clear();
            self.modes.set(workspace.problem(), &self.chosen, scales, &mut self.margins);
        }
        let (end, solution) = (&self.end, &self.chosen);
        let mut step = Step {
            model,
            state,
            input,
            settings,
            workspace,
            solution,
            end,
            begin,
            scales,
            directions: &self.directions,
        };
        let rows = (&mut self.system.rows, &mut self.tie_rows, &mut self.left_out);
        build(&mut step, &self.modes, &mut self.margins, rows, &mut self.turning, &mut self.scratch)?;
        let problem = workspace.problem();
        self.ties.resize_with(self.tie_rows.contacts.len(), TieUnit::default);
        for (unit, &i) in self.ties.iter_mut().zip(&self.tie_rows.contacts) {
            unit.set(problem, &self.chosen, i, scales);
        }
        self.balance_at(velocity, model, (state, input), workspace)?;
        self.integration.set(model, velocity, self.dt);
        self.system.reduce(self.nv, &workspace.problem().mass_factor)
    }

    /// Derivatives of the balance of momentum at `v⁺` with the impulses of the rows, which are there already.
    fn balance_at(
        &mut self,
        velocity: &[f64],
        model: &Model,
        (state, input): (&State, &Input),
        workspace: &Workspace,
    ) -> Result<(), String> {
        let kinematics = workspace.kinematics();
        let free = workspace.free_motion();
        let wrenches = &self.system.rows.wrenches;
        let (given, solved) = ((state, input), (velocity, &wrenches[..]));
        balance_derivatives_into(model, kinematics, given, self.dt, free, solved, &mut self.balance)
            .map_err(|error| error.to_string())?;
        for (source, value) in self.balance.margins.drain(..) {
            let source = InequalitySource::Smooth(source);
            self.margins.push(Margin { source, kind: InequalityKind::Range, value });
        }
        if !balances(&self.balance, &self.system.rows, momentum_scale(state, workspace, &mut self.work)) {
            return Err("a force of this step has no derivative here".into());
        }
        self.balance.by_configuration.iter_mut().zip(&self.turning).for_each(|(e, g)| *e -= g);
        let at = BalanceAt {
            model,
            kinematics,
            state,
            input,
            dt: self.dt,
            free,
            velocity,
            impulses: &self.system.rows.wrenches,
            balance: &self.balance,
        };
        self.smooth.clear(self.nv);
        for direction in &self.directions {
            add_smooth(&at, direction, self.smooth.push());
        }
        for (column, smooth) in self.system.rows.balance_by_parameter.data.iter_mut().zip(&self.smooth.data) {
            *column += smooth;
        }
        Ok(())
    }

    /// The verdict on the margins at hand.
    fn judge(&mut self, model: &Model) -> Validity {
        let solved = (&self.balance, &self.system);
        note_redundancy(solved, &mut self.columns, &mut self.margins, &mut self.work);
        let departing = departing_constraint(&self.left_out, solved, &mut self.columns, &mut self.work);
        note_parameters(self.nv, self.directions.len(), &mut self.system);
        if let Some(equality) = departing {
            let name = &model.equalities[equality].name;
            let reason = format!("constraint '{name}': rows of it follow from others here, and not beside");
            self.has_matrices = false;
            return Validity::Refused { reason };
        }
        let jumps = |margin: &&Margin| margin.kind == InequalityKind::Threshold;
        if let Some(margin) = self.margins.iter().filter(|margin| is_tie(margin)).find(jumps) {
            let reason = format!("{:?} is at the threshold of another law of correction or impact", margin.source);
            self.has_matrices = false;
            return Validity::Refused { reason };
        }
        self.deciding.clear();
        self.deciding.extend(self.margins.iter().filter(|margin| is_tie(margin)).copied());
        match self.deciding.is_empty() {
            true => Validity::Exact,
            false => Validity::OneSided { deciding: std::mem::take(&mut self.deciding) },
        }
    }

    /// What the derivative is worth.
    pub fn validity(&self) -> &Validity {
        &self.validity
    }

    /// How far each inequality of the step is from turning; those that decide are in the [validity](Self::validity), too.
    pub fn margins(&self) -> &[Margin] {
        &self.margins
    }
}

/// What in a step as a whole has no derivative.
fn refuse(model: &Model, settings: &Settings, report: &StepReport, workspace: &Workspace) -> Result<(), String> {
    let reason = if report.status != SolveStatus::Solved || report.missed_tolerance {
        "the step missed its tolerance"
    } else if report.theta < 1.0 || report.clipped_gaps {
        "the laws permit only a part of the corrections that the step asks for"
    } else if settings.friction_law != FrictionLaw::Polygon {
        "the friction law is not the polygon's"
    } else if workspace.decompression().is_some() {
        "an impact has a decompression of its own (Poisson's law)"
    } else if settings.position_iterations > 0 && !model.equalities.is_empty() {
        "the configuration is brought onto the constraints after the step"
    } else if report.unresolved_rotations > 0 {
        "a body turns too fast for the time step"
    } else {
        return Ok(());
    };
    Err(reason.into())
}

/// Whether the step's problem has a solution, found without a start, that moves the contacts otherwise than `velocity`.
fn ends_elsewhere(workspace: &mut Workspace, velocity: &[f64], scales: Scales) -> bool {
    let Some(other) = workspace.solve_without_start().map(|other| other.velocity.clone()) else { return false };
    let problem = workspace.problem();
    (0..problem.contact_count()).any(|i| {
        let [own, found] = [velocity, &other].map(|v| problem.contact_velocity(i, v));
        own.iter().zip(found).any(|(x, y)| scales.velocity((x - y).abs()) > TIE)
    })
}

/// The speed that gravity gives in a step, or 1 m/s where there is none.
fn rest_speed(model: &Model, dt: f64) -> f64 {
    let speed = model.gravity.length() * dt;
    if speed > 0.0 { speed } else { 1.0 }
}

/// The size of the momenta of a step, N·s and N·m·s.
fn momentum_scale(state: &State, workspace: &Workspace, momentum: &mut Vec<f64>) -> f64 {
    let problem = workspace.problem();
    momentum.clear();
    momentum.resize(problem.nv(), 0.0);
    let velocities = [&state.v, &problem.free_velocity, &workspace.solution().velocity];
    let sizes = velocities.map(|v| {
        problem.mass.multiply_into(v, momentum);
        largest(momentum)
    });
    sizes.into_iter().fold(0.0, f64::max)
}

/// What of a solution is differentiated, into memory that is kept.
fn copy_solution(from: &ContactSolution, to: &mut ContactSolution) {
    to.velocity.clone_from(&from.velocity);
    to.lambda_n.clone_from(&from.lambda_n);
    to.alpha.clone_from(&from.alpha);
    to.beta.clone_from(&from.beta);
    to.bilateral.clone_from(&from.bilateral);
    to.group_alpha.clone_from(&from.group_alpha);
    to.group_beta.clone_from(&from.group_beta);
    to.impulse.clone_from(&from.impulse);
    to.modes.clone_from(&from.modes);
    to.group_impulse.clone_from(&from.group_impulse);
    to.group_modes.clone_from(&from.group_modes);
    to.certificate = from.certificate;
}
