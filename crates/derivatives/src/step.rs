//! The derivative of a step at its solution.

use signorini_contact::{ContactSolution, SolveStatus};
use signorini_multibody::derivatives::{BalanceAt, BalanceDerivatives, MotionDerivatives, balance_derivatives_into};
use signorini_multibody::{Input, Model, State};
use signorini_simulation::{FrictionLaw, Settings, StepReport, Workspace};

use crate::integration::Integration;
use crate::interior::Interior;
use crate::matrix::{Rows, dot, largest};
use crate::mode::{Scales, is_tie};
use crate::parameter::{Direction, add_smooth};
use crate::rows::{Modes, Step, TieRows, balances, build};
use crate::system::{Gain, ModeSystem};
use crate::tie::TieUnit;
use crate::validity::{InequalityKind, InequalitySource, Margin, Validity};

/// Redundant contacts hold the same motion where the derivatives of their rows agree to this part of their size.
const CONSISTENT: f64 = 1e-7;

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
    pub(crate) system: ModeSystem,
    pub(crate) gain: Gain,
    pub(crate) integration: Integration,
    /// `v⁺`.
    pub(crate) velocity: Vec<f64>,
}

impl StepDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            nv: model.nv,
            nu: model.actuators.len(),
            dt: model.timestep,
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
            system: ModeSystem::default(),
            gain: Gain::default(),
            integration: Integration::default(),
            velocity: Vec::new(),
        }
    }

    /// The same with columns for numbers of the model, a column for each direction ([`parameter_matrix`](Self::parameter_matrix)).
    pub fn with_parameters(model: &Model, directions: Vec<Direction>) -> Self {
        Self { directions, ..Self::new(model) }
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
        self.has_matrices = false;
        self.validity = match self.differentiate(model, (state, input), settings, report, workspace) {
            Err(reason) => Validity::Refused { reason },
            Ok(()) => {
                self.has_matrices = true;
                self.judge()
            }
        };
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
        let velocity = workspace.solution().velocity.clone();
        self.end.set(model, workspace.kinematics(), &velocity);
        self.balance.dynamics.motion.set(model, workspace.kinematics(), &state.v);
        let scales = Scales::of(workspace.problem(), [&state.v, &velocity]);
        let begin = &self.balance.dynamics.motion;
        self.chosen.clone_from(workspace.solution());
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
        let rows = (&mut self.system.rows, &mut self.tie_rows);
        build(&mut step, &self.modes, &mut self.margins, rows, &mut self.turning)?;
        let problem = workspace.problem();
        let unit = |&i: &usize| TieUnit::new(problem, &self.chosen, i, scales);
        self.ties.clear();
        self.ties.extend(self.tie_rows.contacts.iter().map(unit));
        self.smooth.clear(self.nv);
        for _ in &self.directions {
            self.smooth.push();
        }
        let kinematics = workspace.kinematics();
        let free = workspace.free_motion();
        let wrenches = &self.system.rows.wrenches;
        let (given, solved) = ((state, input), (&velocity[..], &wrenches[..]));
        balance_derivatives_into(model, kinematics, given, self.dt, free, solved, &mut self.balance)
            .map_err(|error| error.to_string())?;
        for (source, value) in self.balance.margins.drain(..) {
            let source = InequalitySource::Smooth(source);
            self.margins.push(Margin { source, kind: InequalityKind::Range, value });
        }
        if !balances(&self.balance, &self.system.rows, momentum_scale(state, workspace)) {
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
            velocity: &velocity,
            impulses: &self.system.rows.wrenches,
            balance: &self.balance,
        };
        for (j, direction) in self.directions.iter().enumerate() {
            add_smooth(&at, direction, self.smooth.row_mut(j));
        }
        for (column, smooth) in self.system.rows.balance_by_parameter.data.iter_mut().zip(&self.smooth.data) {
            *column += smooth;
        }
        self.integration.set(model, &velocity, self.dt);
        self.velocity = velocity;
        self.system.reduce(self.nv, &workspace.problem().mass_factor)
    }

    /// The verdict on the margins at hand.
    fn judge(&mut self) -> Validity {
        self.note_redundancy();
        let jumps = |margin: &&Margin| margin.kind == InequalityKind::Threshold;
        if let Some(margin) = self.margins.iter().filter(|margin| is_tie(margin)).find(jumps) {
            let reason = format!("{:?} is at the threshold of another law of correction or impact", margin.source);
            self.has_matrices = false;
            return Validity::Refused { reason };
        }
        let deciding: Vec<Margin> = self.margins.iter().filter(|margin| is_tie(margin)).copied().collect();
        if deciding.is_empty() { Validity::Exact } else { Validity::OneSided { deciding } }
    }

    /// Redundant rows whose derivatives do not follow from the others: their contacts part as soon as anything changes.
    fn note_redundancy(&mut self) {
        if self.system.dropped().is_empty() {
            return;
        }
        let dropped: Vec<usize> = self.system.dropped().to_vec();
        let (mut off, mut size) = (vec![0.0; dropped.len()], vec![0.0; dropped.len()]);
        let smooth = 2 * self.nv + self.nu;
        let (mut velocity, mut scratch) = (vec![0.0; self.nv], Vec::new());
        for column in (0..smooth).chain(smooth + self.nv..smooth + self.nv + self.directions.len()) {
            let slopes = self.velocity_column(column, &mut velocity, &mut scratch);
            for (at, &i) in dropped.iter().enumerate() {
                let held = self.system.rows.held.row(i);
                let own_off = (dot(held, &velocity) + slopes[i]).abs();
                let own_size = slopes[i].abs().max(largest(&velocity) * largest(held));
                if column < smooth {
                    (off[at], size[at]) = (own_off.max(off[at]), own_size.max(size[at]));
                } else if own_off > CONSISTENT * own_size.max(f64::EPSILON * largest(&velocity)) {
                    let reason = "redundant contacts part as soon as it changes".to_owned();
                    self.system.rows.without_slope[column - smooth - self.nv] = Some(reason);
                }
            }
        }
        for (at, &i) in dropped.iter().enumerate() {
            if off[at] <= CONSISTENT * size[at] {
                continue;
            }
            let (source, kind) = (self.system.rows.source[i], InequalityKind::Redundancy);
            self.margins.push(Margin { source, kind, value: 0.0 });
        }
    }

    /// `∂v⁺` by one number of `(q, v, u, τ)` and the directions of parameters, `[nv]`; returns what the rows change by.
    fn velocity_column(&self, column: usize, out: &mut [f64], scratch: &mut Vec<f64>) -> Vec<f64> {
        let (nv, nu, rows) = (self.nv, self.nu, &self.system.rows);
        let force = 2 * nv + nu;
        for (r, x) in out.iter_mut().enumerate() {
            *x = match column {
                k if k < nv => -self.balance.by_configuration[r * nv + k],
                k if k < 2 * nv => -self.balance.by_velocity[r * nv + k - nv],
                k if k < force => -self.balance.by_control[r * nu + k - 2 * nv],
                k if k < force + nv => f64::from(u8::from(k - force == r)) * self.dt,
                k => -rows.balance_by_parameter.row(k - force - nv)[r],
            };
        }
        let slope = |i: usize| match column {
            k if k < nv => rows.by_configuration.row(i)[k],
            k if k < 2 * nv => rows.by_velocity.row(i)[k - nv],
            k if k < force => rows.by_control.row(i)[k - 2 * nv],
            k if k < force + nv => 0.0,
            k => rows.by_parameter.row(i)[k - force - nv],
        };
        let slopes: Vec<f64> = (0..rows.len()).map(slope).collect();
        self.system.solve(out, &slopes, scratch);
        slopes
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

/// The size of the momenta of a step, N·s and N·m·s.
fn momentum_scale(state: &State, workspace: &Workspace) -> f64 {
    let problem = workspace.problem();
    let mut momentum = vec![0.0; problem.nv()];
    let velocities = [&state.v, &problem.free_velocity, &workspace.solution().velocity];
    let sizes = velocities.map(|v| {
        problem.mass.multiply_into(v, &mut momentum);
        largest(&momentum)
    });
    sizes.into_iter().fold(0.0, f64::max)
}
