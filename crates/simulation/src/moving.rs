//! What can move, and how much of it corrections move.

use signorini_contact::{ContactProblem, ContactSolution};
use signorini_multibody::{BlockDiagonal, BodyId, JointKind, Model, MovingBodies};

use crate::build::{Impact, is_impact};

/// What corrections can set in motion, by blocks of the mass matrix, which are the model's trees.
pub(crate) struct Moving {
    pub bodies: MovingBodies,
    /// Of a tree's bodies, and what armatures add to it along slides, kg.
    mass: Vec<f64>,
    /// The armatures of its other joints, kg m²: some robots have no other inertia.
    inertia: Vec<f64>,
    /// The least mass of a tree, and the least sum of its armatures.
    least: (f64, f64),
    /// Which trees corrections move.
    is_reached: Vec<bool>,
}

impl Moving {
    pub fn of(model: &Model) -> Self {
        let matrix = BlockDiagonal::new(model);
        let trees = matrix.blocks().len();
        let (mut mass, mut inertia) = (vec![0.0; trees], vec![0.0; trees]);
        for (i, body) in model.bodies.iter().enumerate() {
            if let Some(dof) = model.dofs_moving(BodyId(i as u32)).next() {
                mass[matrix.block_of(dof)] += body.inertia.mass;
            }
        }
        for joint in &model.joints {
            let sum = if matches!(joint.kind, JointKind::Slide { .. }) { &mut mass } else { &mut inertia };
            sum[matrix.block_of(joint.v_index)] += joint.armature;
        }
        let least = |of: &[f64]| of.iter().copied().reduce(f64::min).unwrap_or(0.0);
        let least = (least(&mass), least(&inertia));
        Self { bodies: MovingBodies::of(model), mass, inertia, least, is_reached: vec![false; trees] }
    }

    /// Finds the trees that the corrections of a solution move: those that have some, and what is moved with them by constraints and by contacts that
    /// push.
    pub fn reach(&mut self, problem: &ContactProblem, solution: &ContactSolution, impacts: &[Impact]) {
        let Self { is_reached, .. } = self;
        is_reached.fill(false);
        let pushes = |i: &usize| solution.lambda_n[*i] > 0.0;
        let constraints = 0..problem.bilateral_violation.len();
        let contacts = (0..problem.contact_count()).filter(pushes);
        let of_constraint = |k: usize| problem.bilateral_jacobian.group(k).0;
        let of_contact = |i: usize| problem.jacobian.group(i).0;
        for k in constraints.clone().filter(|k| problem.bilateral_violation[*k] != 0.0) {
            problem.mass.blocks_touched(of_constraint(k)).for_each(|(tree, _)| is_reached[tree] = true);
        }
        for i in contacts.clone().filter(|i| problem.gap[*i] < 0.0 && !is_impact(impacts, *i)) {
            problem.mass.blocks_touched(of_contact(i)).for_each(|(tree, _)| is_reached[tree] = true);
        }
        let mut spreads = true;
        while spreads {
            spreads = false;
            for columns in constraints.clone().map(of_constraint).chain(contacts.clone().map(of_contact)) {
                let trees = || problem.mass.blocks_touched(columns).map(|(tree, _)| tree);
                if trees().any(|tree| is_reached[tree]) {
                    trees().for_each(|tree| spreads |= !std::mem::replace(&mut is_reached[tree], true));
                }
            }
        }
    }

    /// No more than any tree has: mass, kg, and armatures of joints that turn, kg m².
    pub fn least(&self) -> (f64, f64) {
        self.least
    }

    /// Mass, kg, and armatures of joints that turn, kg m², of the trees that are reached.
    pub fn reached(&self) -> (f64, f64) {
        let sum = |of: &[f64]| of.iter().zip(&self.is_reached).filter(|(_, is)| **is).map(|(x, _)| x).sum();
        (sum(&self.mass), sum(&self.inertia))
    }

    /// The velocities of the trees that are reached, and zero for others.
    pub fn of_reached(&self, problem: &ContactProblem, v: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(v);
        for (block, _) in problem.mass.blocks().iter().zip(&self.is_reached).filter(|(_, is)| !**is) {
            out[block.range()].fill(0.0);
        }
    }
}
