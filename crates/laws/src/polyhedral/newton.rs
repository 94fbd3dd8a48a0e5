//! Newton's method with a line search for a convex piecewise quadratic function of the velocities of one group.

use signorini_lcp::linalg::Lu;

use super::cones::Piece;
use super::line_search::step_length;
use super::{Group, ImpulseCones};
use signorini_contact::ContactProblem;
use signorini_contact::vector::dot;

/// Newton steps at most.
const MAX_STEPS: u32 = 200;
/// Steps without a smaller decrement before rounding is blamed: whole ones, or any near the smallest decrement.
const PATIENCE: u32 = 4;
/// How many times the smallest decrement is near it.
const NEAR: f64 = 1e8;

/// The function
///
/// ```text
/// F(x) = δ/2 ‖x − x̄‖²_M + qᵀx + Σ_i 1/(2ρ_i) ‖P_i(λ̄_i − ρ_i (J_i x + c_i))‖² + Σ_k 1/(2ρ_k) (λ̄_k − ρ_k (∇Θ_k x + c_k))²
/// ```
///
/// of the velocities `x` of one group, with `P_i` the projection onto the cone of contact i. It is convex and continuously
/// differentiable: `∇F = δM(x − x̄) + q − Jᵀλ(x)` with the impulses `λ_i(x) = P_i(λ̄_i − ρ_i(J_i x + c_i))`.
/// All arrays are over the whole problem.
pub(crate) struct Objective<'a> {
    pub problem: &'a ContactProblem,
    pub cones: &'a ImpulseCones,
    pub group: Group<'a>,
    /// δ.
    pub inertia: f64,
    /// x̄, `[nv]`.
    pub center: &'a [f64],
    /// q, `[nv]`, or empty for zero.
    pub linear: &'a [f64],
    /// λ̄ of contacts, `[nc]`.
    pub multiplier: &'a [[f64; 3]],
    /// λ̄ of bilateral rows, `[nb]`.
    pub row_multiplier: &'a [f64],
    /// ρ of contacts, `[nc]`.
    pub weight: &'a [f64],
    /// ρ of bilateral rows, `[nb]`.
    pub row_weight: &'a [f64],
    /// Whether `c` is the stabilization `(φ/Δt, 0, 0)`, `Θ/Δt`; otherwise it is 0.
    pub stabilized: bool,
    /// A decrement `sᵀHs` below this is rounding: its step is the last.
    pub smallest_decrement: f64,
}

/// The method with its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConeNewton {
    lu: Lu,
    gradient: Vec<f64>,
    product: Vec<f64>,
    direction: Vec<f64>,
    step: Vec<f64>,
    /// Trial impulses and their change along the step, contacts of the group.
    trial: Vec<[f64; 3]>,
    change: Vec<[f64; 3]>,
    pieces: Vec<Piece>,
    /// The pieces of the factorisation at hand, where there is one: a group without contacts has none.
    factored: Vec<Piece>,
    is_factored: bool,
    row_trial: Vec<f64>,
    row_change: Vec<f64>,
    /// Factorisations so far.
    pub factorizations: u32,
}

impl ConeNewton {
    /// Forgets the factorisation: to be called when anything but `x̄`, `q` and `λ̄` changes.
    pub fn forget(&mut self) {
        self.is_factored = false;
    }

    /// Minimises `F` over the group's entries of `x`, from where they are, and writes the impulses there.
    pub fn minimize(&mut self, f: &Objective, x: &mut [f64], impulse: &mut [[f64; 3]], row_impulse: &mut [f64]) {
        for scratch in [&mut self.gradient, &mut self.product, &mut self.direction] {
            scratch.clear();
            scratch.resize(x.len(), 0.0);
        }
        let (mut best, mut waited, mut t) = (f64::INFINITY, 0, 1.0);
        for _ in 0..MAX_STEPS {
            self.evaluate(f, x);
            self.find_gradient(f, x);
            if !self.factor(f) {
                break;
            }
            let decrement = self.find_direction(f);
            let far = t < 1.0 && decrement > NEAR * f.smallest_decrement;
            waited = if decrement < 0.25 * best || far { 0 } else { waited + 1 };
            best = best.min(decrement);
            if decrement.is_nan() || waited > PATIENCE {
                break;
            }
            let last = decrement <= f.smallest_decrement;
            t = if last { 1.0 } else { self.step_length(f, x) };
            for &dof in f.group.dofs {
                x[dof as usize] += t * self.direction[dof as usize];
            }
            if last {
                break;
            }
        }
        self.evaluate(f, x);
        for (c, &i) in f.group.contacts.iter().enumerate() {
            impulse[i as usize] = f.cones.project(i as usize, self.trial[c]).0;
        }
        for (c, &k) in f.group.rows.iter().enumerate() {
            row_impulse[k as usize] = self.row_trial[c];
        }
    }

    /// Trial impulses and their pieces at `x`.
    fn evaluate(&mut self, f: &Objective, x: &[f64]) {
        self.trial.clear();
        self.pieces.clear();
        for &i in f.group.contacts {
            let i = i as usize;
            let mut u = f.problem.jacobian.multiply(i, x);
            if f.stabilized {
                u[0] += f.problem.gap[i] / f.problem.timestep;
            }
            let y: [f64; 3] = std::array::from_fn(|r| f.multiplier[i][r] - f.weight[i] * u[r]);
            self.trial.push(y);
            self.pieces.push(f.cones.project(i, y).1);
        }
        self.row_trial.clear();
        for &k in f.group.rows {
            let k = k as usize;
            let [mut u] = f.problem.bilateral_jacobian.multiply(k, x);
            if f.stabilized {
                u += f.problem.bilateral_violation[k] / f.problem.timestep;
            }
            self.row_trial.push(f.row_multiplier[k] - f.row_weight[k] * u);
        }
    }

    /// `∇F` at the point last evaluated.
    fn find_gradient(&mut self, f: &Objective, x: &[f64]) {
        for &dof in f.group.dofs {
            self.direction[dof as usize] = x[dof as usize] - f.center[dof as usize];
        }
        multiply_mass(f, &self.direction, &mut self.product);
        for &dof in f.group.dofs {
            let dof = dof as usize;
            self.gradient[dof] = f.linear.get(dof).copied().unwrap_or(0.0) + f.inertia * self.product[dof];
        }
        for (c, &i) in f.group.contacts.iter().enumerate() {
            let lambda = f.cones.project(i as usize, self.trial[c]).0;
            f.problem.jacobian.add_transposed(i as usize, lambda.map(|p| -p), &mut self.gradient);
        }
        for (c, &k) in f.group.rows.iter().enumerate() {
            f.problem.bilateral_jacobian.add_transposed(k as usize, [-self.row_trial[c]], &mut self.gradient);
        }
    }

    /// Factorises `H = δM + Σ ρ JᵀBJ` for the current pieces, where that is not the factorisation at hand; whether there is one.
    fn factor(&mut self, f: &Objective) -> bool {
        if self.is_factored && self.pieces == self.factored {
            return true;
        }
        let (group, n) = (&f.group, f.group.dofs.len());
        let h = self.lu.start(n);
        let mut first = 0;
        for &block in group.blocks {
            let size = f.problem.mass.blocks()[block as usize].size;
            for (r, row) in f.problem.mass.block_data(block as usize).chunks_exact(size).enumerate() {
                let start = (first + r) * n + first;
                h[start..start + size].iter_mut().zip(row).for_each(|(h, m)| *h += f.inertia * m);
            }
            first += size;
        }
        for (c, &i) in group.contacts.iter().enumerate() {
            if self.pieces[c] == Piece::Apex {
                continue;
            }
            let slope = f.cones.projector(i as usize, self.pieces[c]);
            let (columns, entries) = f.problem.jacobian.group(i as usize);
            for (&a, e) in columns.iter().zip(entries) {
                let row = slope.map(|b| f.weight[i as usize] * dot(b, *e));
                let start = group.local(a) * n;
                for (&b, e) in columns.iter().zip(entries) {
                    h[start + group.local(b)] += dot(row, *e);
                }
            }
        }
        for &k in group.rows {
            let (columns, entries) = f.problem.bilateral_jacobian.group(k as usize);
            for (&a, e) in columns.iter().zip(entries) {
                for (&b, d) in columns.iter().zip(entries) {
                    h[group.local(a) * n + group.local(b)] += f.row_weight[k as usize] * e[0] * d[0];
                }
            }
        }
        self.factorizations += 1;
        self.factored.clone_from(&self.pieces);
        self.is_factored = self.lu.factorize() > 0.0;
        self.is_factored
    }

    /// The Newton direction `s = −H⁻¹∇F`; returns `−∇Fᵀs`.
    fn find_direction(&mut self, f: &Objective) -> f64 {
        self.step.clear();
        self.step.extend(f.group.dofs.iter().map(|&dof| -self.gradient[dof as usize]));
        self.lu.solve(&mut self.step);
        let mut decrement = 0.0;
        for (&dof, s) in f.group.dofs.iter().zip(&self.step) {
            self.direction[dof as usize] = *s;
            decrement -= s * self.gradient[dof as usize];
        }
        decrement
    }

    /// The part of the step along the direction after which the slope of `F` has nearly vanished.
    fn step_length(&mut self, f: &Objective, x: &[f64]) -> f64 {
        self.change.clear();
        self.change.extend(f.group.contacts.iter().map(|&i| f.problem.jacobian.multiply(i as usize, &self.direction)));
        self.row_change.clear();
        let rows = f.group.rows.iter();
        self.row_change.extend(rows.map(|&k| f.problem.bilateral_jacobian.multiply(k as usize, &self.direction)[0]));
        multiply_mass(f, &self.direction, &mut self.product);
        let (mut constant, mut rising) = (0.0, 0.0);
        for &dof in f.group.dofs {
            let dof = dof as usize;
            let at_start = f.linear.get(dof).copied().unwrap_or(0.0) * self.direction[dof];
            constant += at_start + f.inertia * self.product[dof] * (x[dof] - f.center[dof]);
            rising += f.inertia * self.product[dof] * self.direction[dof];
        }
        let slope = |t: f64| {
            let mut sum = constant + t * rising;
            for (c, &i) in f.group.contacts.iter().enumerate() {
                let (y, u, rho) = (self.trial[c], self.change[c], f.weight[i as usize]);
                let moved = std::array::from_fn(|r| y[r] - t * rho * u[r]);
                sum -= dot(f.cones.project(i as usize, moved).0, u);
            }
            for (c, &k) in f.group.rows.iter().enumerate() {
                let u = self.row_change[c];
                sum -= (self.row_trial[c] - t * f.row_weight[k as usize] * u) * u;
            }
            sum
        };
        step_length(slope)
    }
}

/// `product = M x` on the degrees of freedom of the group.
fn multiply_mass(f: &Objective, x: &[f64], product: &mut [f64]) {
    for &block in f.group.blocks {
        let range = f.problem.mass.blocks()[block as usize].range();
        let rows = f.problem.mass.block_data(block as usize).chunks_exact(range.len());
        for (out, row) in product[range.clone()].iter_mut().zip(rows) {
            *out = row.iter().zip(&x[range.clone()]).map(|(m, x)| m * x).sum();
        }
    }
}
