//! Linear and conic programs, in the words of this crate.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// What an interior-point method is asked for. It may end earlier: what it found is judged by those who asked.
const ASKED: f64 = 1e-13;
/// Steps of the method at most.
const STEPS: u32 = 150;

/// Minimise `cᵀx` where linear expressions are zero, at least some number, or in second-order cones.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConicProgram {
    cost: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    right: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

/// A point of a program with its multipliers.
#[derive(Clone, Debug)]
pub(crate) struct ConicPoint {
    /// The variables.
    pub x: Vec<f64>,
    /// The multipliers of the rows: `c = Σ z_i ∇(expression i)`.
    pub z: Vec<f64>,
    /// Whether the method ended at an optimum, and not at a proof that there is none or out of steps.
    pub is_optimal: bool,
}

impl ConicProgram {
    /// A program with so many variables that cost nothing.
    pub fn new(variables: usize) -> Self {
        Self { cost: vec![0.0; variables], ..Self::default() }
    }

    /// Sets what a variable costs.
    pub fn set_cost(&mut self, variable: usize, cost: f64) {
        self.cost[variable] = cost;
    }

    /// Number of rows so far.
    pub fn row_count(&self) -> usize {
        self.right.len()
    }

    fn push(&mut self, expression: impl IntoIterator<Item = (usize, f64)>, least: f64) -> usize {
        let row = self.right.len();
        for (column, value) in expression {
            if value != 0.0 {
                self.rows.push(row);
                self.columns.push(column);
                self.values.push(-value);
            }
        }
        self.right.push(-least);
        row
    }

    /// `expression ≥ least`; the row.
    pub fn at_least(&mut self, expression: impl IntoIterator<Item = (usize, f64)>, least: f64) -> usize {
        match self.cones.last_mut() {
            Some(SupportedConeT::NonnegativeConeT(count)) => *count += 1,
            _ => self.cones.push(SupportedConeT::NonnegativeConeT(1)),
        }
        self.push(expression, least)
    }

    /// `expression = value`; the row.
    pub fn equal(&mut self, expression: impl IntoIterator<Item = (usize, f64)>, value: f64) -> usize {
        match self.cones.last_mut() {
            Some(SupportedConeT::ZeroConeT(count)) => *count += 1,
            _ => self.cones.push(SupportedConeT::ZeroConeT(1)),
        }
        self.push(expression, value)
    }

    /// `‖(e₁, e₂)‖ ≤ e₀` of three expressions; the first of three rows.
    pub fn in_cone(&mut self, expressions: [Vec<(usize, f64)>; 3]) -> usize {
        self.cones.push(SupportedConeT::SecondOrderConeT(3));
        let first = self.row_count();
        expressions.into_iter().for_each(|expression| {
            self.push(expression, 0.0);
        });
        first
    }

    /// The best point found; nothing where the method broke down.
    pub fn solve(&self) -> Option<ConicPoint> {
        let n = self.cost.len();
        let quadratic = CscMatrix::zeros((n, n));
        let (rows, columns, values) = (self.rows.clone(), self.columns.clone(), self.values.clone());
        let matrix = CscMatrix::new_from_triplets(self.right.len(), n, rows, columns, values);
        let settings = DefaultSettings {
            verbose: false,
            max_iter: STEPS,
            tol_gap_abs: ASKED,
            tol_gap_rel: ASKED,
            tol_feas: ASKED,
            ..DefaultSettings::default()
        };
        let mut solver =
            DefaultSolver::new(&quadratic, &self.cost, &matrix, &self.right, &self.cones, settings).ok()?;
        solver.solve();
        let is_optimal = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        let (x, z) = (solver.solution.x, solver.solution.z);
        let finite = x.iter().chain(&z).all(|value| value.is_finite());
        finite.then_some(ConicPoint { x, z, is_optimal })
    }
}
