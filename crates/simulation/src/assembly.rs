//! Bringing a configuration onto the equality constraints.

use signorini_contact::SparseRows;
use signorini_multibody::{
    BlockCholesky, BlockDiagonal, EqualityBlock, Input, Kinematics, MassMatrix, Model, equality_block_into,
    forward_kinematics_into, integrate_into, mass_matrix_into,
};

use crate::SimulationError;
use crate::build::rows::push_rows;
use crate::smallest_change::SmallestChange;

/// Violations below this are rounding, m or rad.
const ASSEMBLED: f64 = 1e-13;

/// Newton's method on `Θ(q) = 0` with the smallest change in the metric of the mass matrix, on a largest set of independent
/// rows; the rows that follow from them are met with them.
#[derive(Clone, Debug)]
pub(crate) struct Assembler {
    kinematics: Kinematics,
    block: EqualityBlock,
    rows: SparseRows<1>,
    violation: Vec<f64>,
    smallest: SmallestChange,
    change: Vec<f64>,
    still: Vec<f64>,
    next: Vec<f64>,
    tolerance: f64,
}

impl Assembler {
    /// `tolerance`: violation up to which a row that nothing moves is left out, m or rad.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        Self {
            kinematics: Kinematics::new(model),
            block: EqualityBlock::new(model),
            rows: SparseRows::default(),
            violation: Vec::new(),
            smallest: SmallestChange::default(),
            change: vec![0.0; model.nv],
            still: vec![0.0; model.nv],
            next: vec![0.0; model.nq],
            tolerance,
        }
    }

    /// Takes over where the bodies stand that are moved from outside.
    pub fn place_mocap(&mut self, model: &Model, input: &Input) {
        self.kinematics.place_mocap(model, input);
    }

    /// Moves `q` onto the constraints in at most `iterations` Newton steps, with any mass matrix near, and its factor.
    pub fn project(&mut self, model: &Model, mass: (&BlockDiagonal, &BlockCholesky), q: &mut [f64], iterations: u32) {
        for _ in 0..iterations {
            if self.linearise(model, q) <= ASSEMBLED {
                return;
            }
            let Self { smallest, rows, violation, change, .. } = self;
            smallest.find((rows, violation), mass, change);
            integrate_into(model, q, &self.change, 1.0, &mut self.next);
            q.copy_from_slice(&self.next);
        }
    }

    /// Rows and violations at `q`; the largest violation.
    fn linearise(&mut self, model: &Model, q: &[f64]) -> f64 {
        forward_kinematics_into(model, q, &self.still, &mut self.kinematics);
        self.rows.clear();
        self.violation.clear();
        let mut largest = 0.0_f64;
        for equality in &model.equalities {
            for k in 0..equality.kind.block_count() {
                equality_block_into(model, &self.kinematics, q, &equality.kind, k, &mut self.block);
                largest = largest.max(self.block.size());
                let Self { block, rows, violation, tolerance, .. } = self;
                push_rows(block, *tolerance, |_, columns, theta| {
                    rows.push(columns);
                    violation.push(theta);
                });
            }
        }
        largest
    }

    /// The largest violation at `q`, m or rad.
    pub fn violation(&mut self, model: &Model, q: &[f64]) -> f64 {
        if model.equalities.is_empty() { 0.0 } else { self.linearise(model, q) }
    }

    /// [`project`](Self::project) with the mass matrix at `q`.
    ///
    /// # Errors
    /// [`SimulationError::FreeMotion`] if the mass matrix is singular there.
    pub fn assemble(&mut self, model: &Model, q: &mut [f64], iterations: u32) -> Result<f64, SimulationError> {
        let mut mass = MassMatrix::new(model);
        forward_kinematics_into(model, q, &self.still, &mut self.kinematics);
        mass_matrix_into(model, &self.kinematics, &mut mass);
        let mut factor = BlockCholesky::new(&mass.matrix);
        factor.refactor(&mass.matrix).map_err(signorini_multibody::FreeMotionError::from)?;
        self.project(model, (&mass.matrix, &factor), q, iterations);
        Ok(self.violation(model, q))
    }
}
