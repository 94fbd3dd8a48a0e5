//! The derivative of a step at its solution.

use signorini_contact::SolveStatus;
use signorini_lcp::Matrix;
use signorini_multibody::derivatives::{BalanceDerivatives, MotionDerivatives, balance_derivatives_into};
use signorini_multibody::{BlockCholesky, Input, Model, State};
use signorini_simulation::{FrictionLaw, Settings, StepReport, Workspace};

use crate::integration::Integration;
use crate::matrix::{Rows, add_scaled, dot, largest};
use crate::mode::Scales;
use crate::reduced::Reduced;
use crate::rows::{ModeRows, Modes, Step, balances, build};
use crate::validity::{InequalityKind, InequalitySource, Margin, Validity};

/// An inequality nearer than this is about to turn: the residuals of a step, 1e-9, times what the worst pivot that is let through makes of them.
const TIE: f64 = 1e-5;
/// Redundant contacts hold the same motion where the derivatives of their rows agree to this part of their size.
const CONSISTENT: f64 = 1e-7;
/// Impulses that cancel leave no more velocity than this part of what each of them gives.
const CANCELS: f64 = 1e-7;

/// The derivative of one step, `(q⁺, v⁺)` by `(q, v)`, by the control `u` and by the applied generalized force `τ`, and the storage to compute
/// it.
///
/// Configurations are in tangent coordinates at both ends: `q ⊕ δq` with rotations multiplied from the right, so that `δq` has the axes of
/// `v` ([`integrate_into`](signorini_multibody::integrate_into), `NOTATION.md`).
#[derive(Clone, Debug)]
pub struct StepDerivatives {
    nv: usize,
    nu: usize,
    dt: f64,
    validity: Validity,
    margins: Vec<Margin>,
    has_matrices: bool,
    balance: BalanceDerivatives,
    end: MotionDerivatives,
    modes: Modes,
    rows: ModeRows,
    turning: Vec<f64>,
    factor: Option<BlockCholesky>,
    /// `M̂⁻¹ N`, one row per column of `N`.
    responses: Rows,
    schur: Rows,
    reduced: Reduced,
    integration: Integration,
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
            rows: ModeRows::default(),
            turning: Vec::new(),
            factor: None,
            responses: Rows::default(),
            schur: Rows::default(),
            reduced: Reduced::default(),
            integration: Integration::default(),
        }
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
        let mut step = Step { model, state, input, settings, workspace, end: &self.end, begin, scales };
        self.modes.set(&step, &mut self.margins);
        build(&mut step, &self.modes, &mut self.margins, &mut self.rows, &mut self.turning)?;
        let kinematics = workspace.kinematics();
        let free = workspace.free_motion();
        let wrenches = &self.rows.wrenches;
        let (given, solved) = ((state, input), (&velocity[..], &wrenches[..]));
        balance_derivatives_into(model, kinematics, given, self.dt, free, solved, &mut self.balance)
            .map_err(|error| error.to_string())?;
        for (source, value) in self.balance.margins.drain(..) {
            let source = InequalitySource::Smooth(source);
            self.margins.push(Margin { source, kind: InequalityKind::Range, value });
        }
        if !balances(&self.balance, &self.rows, momentum_scale(state, workspace)) {
            return Err("a force of this step has no derivative here".into());
        }
        self.balance.by_configuration.iter_mut().zip(&self.turning).for_each(|(e, g)| *e -= g);
        self.factor = Some(workspace.problem().mass_factor.clone());
        self.integration.set(model, &velocity, self.dt);
        self.reduce()
    }

    /// Brings the system of the mode to its independent rows.
    fn reduce(&mut self) -> Result<(), String> {
        let Self { rows, responses, schur, reduced, factor, nv, .. } = self;
        let Some(factor) = factor else { return Ok(()) };
        responses.clear(*nv);
        for i in 0..rows.len() {
            let response = responses.push();
            response.copy_from_slice(rows.impulse.row(i));
            factor.solve_in_place(response);
            let size = dot(rows.impulse.row(i), response);
            if size > 0.0 {
                let scale = 1.0 / size.sqrt();
                response.iter_mut().for_each(|x| *x *= scale);
                let all = [
                    &mut rows.held,
                    &mut rows.impulse,
                    &mut rows.by_configuration,
                    &mut rows.by_velocity,
                    &mut rows.by_control,
                ];
                all.into_iter()
                    .filter(|rows| rows.width > 0)
                    .for_each(|rows| rows.row_mut(i).iter_mut().for_each(|x| *x *= scale));
            }
        }
        schur.clear(rows.len());
        for i in 0..rows.len() {
            let entries = schur.push();
            for (j, entry) in entries.iter_mut().enumerate() {
                *entry = dot(rows.held.row(i), responses.row(j));
            }
        }
        reduced.factor(schur).map_err(|pivot| {
            format!("the contacts hold a motion all but twice: a pivot is {:.1e} of the largest", pivot.0)
        })?;
        for k in reduced.rank..rows.len() {
            let impulses = reduced.null_vector(k);
            let (mut motion, mut size) = (vec![0.0; *nv], 0.0);
            for (i, x) in impulses.iter().enumerate() {
                add_scaled(&mut motion, *x, responses.row(i));
                size += x.abs() * largest(responses.row(i));
            }
            if largest(&motion) > CANCELS * size {
                return Err("the velocity is not unique: contacts that slide leave it open".into());
            }
        }
        Ok(())
    }

    /// The verdict on the margins at hand.
    fn judge(&mut self) -> Validity {
        self.note_redundancy();
        let is_tie = |margin: &&Margin| margin.value.is_nan() || margin.value <= TIE;
        let jumps = |margin: &&Margin| margin.kind == InequalityKind::Threshold;
        if let Some(margin) = self.margins.iter().filter(is_tie).find(jumps) {
            let reason = format!("{:?} is at the threshold of another law of correction or impact", margin.source);
            self.has_matrices = false;
            return Validity::Refused { reason };
        }
        let deciding: Vec<Margin> = self.margins.iter().filter(is_tie).copied().collect();
        if deciding.is_empty() { Validity::Exact } else { Validity::OneSided { deciding } }
    }

    /// Redundant rows whose derivatives do not follow from the others: their contacts part as soon as anything changes.
    fn note_redundancy(&mut self) {
        let dropped: Vec<usize> = self.reduced.rows[self.reduced.rank..].to_vec();
        if dropped.is_empty() {
            return;
        }
        let (mut scratch, mut off, mut size) = (Vec::new(), vec![0.0; dropped.len()], vec![0.0; dropped.len()]);
        let mut velocity = vec![0.0; self.nv];
        for column in 0..2 * self.nv + self.nu {
            self.velocity_column(column, &mut velocity, &mut scratch);
            for (at, &i) in dropped.iter().enumerate() {
                let moved = dot(self.rows.held.row(i), &velocity);
                let own = self.row_slope(i, column);
                off[at] = f64::max(off[at], (moved + own).abs());
                size[at] = f64::max(size[at], own.abs().max(largest(&velocity) * largest(self.rows.held.row(i))));
            }
        }
        for (at, &i) in dropped.iter().enumerate() {
            if off[at] > CONSISTENT * size[at] {
                let (source, kind) = (self.rows.source[i], InequalityKind::Redundancy);
                self.margins.push(Margin { source, kind, value: 0.0 });
            }
        }
    }

    fn row_slope(&self, i: usize, column: usize) -> f64 {
        let nv = self.nv;
        match column {
            k if k < nv => self.rows.by_configuration.row(i)[k],
            k if k < 2 * nv => self.rows.by_velocity.row(i)[k - nv],
            k if k < 2 * nv + self.nu => self.rows.by_control.row(i)[k - 2 * nv],
            _ => 0.0,
        }
    }

    /// `∂v⁺` by one number of `(q, v, u, τ)`, `[nv]`.
    fn velocity_column(&self, column: usize, out: &mut [f64], scratch: &mut Vec<f64>) {
        let (nv, nu) = (self.nv, self.nu);
        for (r, x) in out.iter_mut().enumerate() {
            *x = match column {
                k if k < nv => -self.balance.by_configuration[r * nv + k],
                k if k < 2 * nv => -self.balance.by_velocity[r * nv + k - nv],
                k if k < 2 * nv + nu => -self.balance.by_control[r * nu + k - 2 * nv],
                k => f64::from(u8::from(k - 2 * nv - nu == r)) * self.dt,
            };
        }
        let slopes: Vec<f64> = (0..self.rows.len()).map(|i| self.row_slope(i, column)).collect();
        self.solve(out, &slopes, scratch);
    }

    /// `v⁺` of the mode's system: `momentum` in, velocity out; `slopes`: what the rows change by.
    fn solve(&self, momentum: &mut [f64], slopes: &[f64], scratch: &mut Vec<f64>) {
        if let Some(factor) = &self.factor {
            factor.solve_in_place(momentum);
        }
        let mut impulses: Vec<f64> =
            slopes.iter().enumerate().map(|(i, slope)| -slope - dot(self.rows.held.row(i), momentum)).collect();
        self.reduced.solve_in_place(&mut impulses, scratch);
        for (i, x) in impulses.iter().enumerate() {
            add_scaled(momentum, *x, self.responses.row(i));
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

    /// `A = ∂(q⁺, v⁺)/∂(q, v)`, `[2 nv, 2 nv]`; none where the derivative is refused. Where it is one-sided it is that of the modes which
    /// the solution has.
    pub fn state_matrix(&self) -> Option<Matrix> {
        self.matrix(0..2 * self.nv)
    }

    /// `∂(q⁺, v⁺)/∂u`, `[2 nv, nu]`, as [`state_matrix`](Self::state_matrix).
    pub fn control_matrix(&self) -> Option<Matrix> {
        self.matrix(2 * self.nv..2 * self.nv + self.nu)
    }

    /// `∂(q⁺, v⁺)/∂τ` by the applied generalized force, `[2 nv, nv]`, as [`state_matrix`](Self::state_matrix).
    pub fn force_matrix(&self) -> Option<Matrix> {
        let first = 2 * self.nv + self.nu;
        self.matrix(first..first + self.nv)
    }

    fn matrix(&self, columns: std::ops::Range<usize>) -> Option<Matrix> {
        if !self.has_matrices {
            return None;
        }
        let nv = self.nv;
        let mut out = Matrix::zeros(2 * nv, columns.len());
        let (mut velocity, mut place, mut scratch) = (vec![0.0; nv], vec![0.0; nv], Vec::new());
        for (at, column) in columns.enumerate() {
            self.velocity_column(column, &mut velocity, &mut scratch);
            let mut begin = vec![0.0; nv];
            if column < nv {
                begin[column] = 1.0;
            }
            self.integration.forward(&begin, &velocity, &mut place);
            for r in 0..nv {
                (out[(r, at)], out[(nv + r, at)]) = (place[r], velocity[r]);
            }
        }
        Some(out)
    }

    /// The product with a change `(δq, δv, δu, δτ)`, `[3 nv + nu]`: `(δq⁺, δv⁺)`, `[2 nv]`, without forming matrices. Nothing where the derivative
    /// is refused.
    ///
    /// # Panics
    /// If the length is another one.
    pub fn product(&self, change: &[f64]) -> Option<Vec<f64>> {
        let (nv, nu) = (self.nv, self.nu);
        assert_eq!(change.len(), 3 * nv + nu, "a change has 3 nv + nu numbers");
        if !self.has_matrices {
            return None;
        }
        let (dq, rest) = change.split_at(nv);
        let (dv, rest) = rest.split_at(nv);
        let (du, force) = rest.split_at(nu);
        let mut velocity: Vec<f64> = force.iter().map(|f| self.dt * f).collect();
        for (r, x) in velocity.iter_mut().enumerate() {
            *x -= dot(&self.balance.by_configuration[r * nv..(r + 1) * nv], dq);
            *x -= dot(&self.balance.by_velocity[r * nv..(r + 1) * nv], dv);
            *x -= dot(&self.balance.by_control[r * nu..(r + 1) * nu], du);
        }
        let rows = &self.rows;
        let slope = |i: usize| {
            let by_control = if nu > 0 { dot(rows.by_control.row(i), du) } else { 0.0 };
            dot(rows.by_configuration.row(i), dq) + dot(rows.by_velocity.row(i), dv) + by_control
        };
        let slopes: Vec<f64> = (0..rows.len()).map(slope).collect();
        self.solve(&mut velocity, &slopes, &mut Vec::new());
        let mut place = vec![0.0; nv];
        self.integration.forward(dq, &velocity, &mut place);
        place.extend(velocity);
        Some(place)
    }

    /// The product of the transposed derivative with the gradient of a function by `(q⁺, v⁺)`, `[2 nv]`: its gradient by `(q, v, u, τ)`,
    /// `[3 nv + nu]`, without forming matrices. Nothing where the derivative is refused.
    ///
    /// # Panics
    /// If the length is another one.
    pub fn transposed_product(&self, gradient: &[f64]) -> Option<Vec<f64>> {
        let (nv, nu) = (self.nv, self.nu);
        assert_eq!(gradient.len(), 2 * nv, "a gradient has 2 nv numbers");
        if !self.has_matrices {
            return None;
        }
        let mut out = vec![0.0; 3 * nv + nu];
        let mut adjoint = gradient[nv..].to_vec();
        self.integration.backward(&gradient[..nv], &mut out[..nv], &mut adjoint);
        // [M̂ −N; C 0]ᵀ (a, b) = (adjoint, 0): S ᵀ b = Nᵀ M̂⁻¹ adjoint, a = M̂⁻¹ (adjoint − Cᵀ b).
        let mut multipliers: Vec<f64> = (0..self.rows.len()).map(|i| dot(self.responses.row(i), &adjoint)).collect();
        self.reduced.solve_transposed_in_place(&mut multipliers, &mut Vec::new());
        for (i, b) in multipliers.iter().enumerate() {
            add_scaled(&mut adjoint, -b, self.rows.held.row(i));
        }
        if let Some(factor) = &self.factor {
            factor.solve_in_place(&mut adjoint);
        }
        let (dq, rest) = out.split_at_mut(nv);
        let (dv, rest) = rest.split_at_mut(nv);
        let (du, force) = rest.split_at_mut(nu);
        for (r, a) in adjoint.iter().enumerate() {
            add_scaled(dq, -a, &self.balance.by_configuration[r * nv..(r + 1) * nv]);
            add_scaled(dv, -a, &self.balance.by_velocity[r * nv..(r + 1) * nv]);
            add_scaled(du, -a, &self.balance.by_control[r * nu..(r + 1) * nu]);
            force[r] = self.dt * a;
        }
        for (i, b) in multipliers.iter().enumerate() {
            add_scaled(dq, -b, self.rows.by_configuration.row(i));
            add_scaled(dv, -b, self.rows.by_velocity.row(i));
            if nu > 0 {
                add_scaled(du, -b, self.rows.by_control.row(i));
            }
        }
        Some(out)
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
