//! Rows of equality constraints that follow from others: a planar loop that is closed in space, by hinges that are parallel to the digits of
//! the file.
//!
//! Such a row differs from a combination of others by so little that it would lock the mechanism, or move it, with impulses of a
//! million times the usual ones; in a file of seven digits the difference is none. It is left out where it asks for what the others
//! leave, and stays where it contradicts them.

use std::collections::BTreeMap;

use signorini_contact::{ContactProblem, SparseRows};
use signorini_multibody::{
    BlockCholesky, BlockDiagonal, EqualityBlock, Kinematics, MassMatrix, Model, equality_block_into,
    forward_kinematics_into, integrate_into, mass_matrix_into,
};
use signorini_solver::BilateralBasis;

use super::rows::{MOST_DENSE_ROWS, push_rows};
use crate::assembly::Assembler;
use crate::source::BilateralSource;

/// A row that asks for something else than the others leave by less than this, m or rad, follows from them: loops are open by what steps leave.
const OFF: f64 = 1e-6;

/// How far each degree of freedom of the other configuration is from the reference, at least, rad or m, and Newton steps that close loops there.
const NEARBY: f64 = 0.05;
const ROUNDS: u32 = 50;

/// Multiples of it, modulo 1, are like no other numbers.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The search for rows that follow from others.
#[derive(Clone, Debug, Default)]
pub(super) struct DependentRows {
    /// Sets of equality constraints with rows that depend on each other, ascending: one constraint, as of a planar loop, or all that share trees.
    groups: Vec<Vec<usize>>,
    basis: BilateralBasis,
    /// The rows of a group, their places among all, and what they ask for, m/s or rad/s.
    rows: SparseRows<1>,
    places: Vec<usize>,
    rates: Vec<f64>,
    is_left_out: Vec<bool>,
    /// The rows that stay.
    staying: (SparseRows<1>, Vec<f64>),
}

impl DependentRows {
    /// Finds the constraints that have to be looked at in every step: those that depend on each other in the reference configuration, or in one
    /// nearby that is like no other, with closed loops.
    pub fn new(model: &Model, assembly_tolerance: f64) -> Self {
        let mut search = Self::default();
        if !model.equalities.is_empty() {
            let reference = model.reference_configuration();
            let way: Vec<f64> = (0..model.nv).map(|k| NEARBY * (1.0 + (k as f64 * GOLDEN).fract())).collect();
            let mut elsewhere = reference.clone();
            integrate_into(model, &reference, &way, 1.0, &mut elsewhere);
            // What cannot be closed there has no more dependent rows than it has in the reference configuration.
            let _ = Assembler::new(model, assembly_tolerance).assemble(model, &mut elsewhere, ROUNDS);
            for q in [reference, elsewhere] {
                search.look_at(model, &q, assembly_tolerance);
            }
        }
        search
    }

    /// Adds the sets of constraints whose rows depend on each other in a configuration.
    fn look_at(&mut self, model: &Model, q: &[f64], assembly_tolerance: f64) {
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
        let mut mass = MassMatrix::new(model);
        mass_matrix_into(model, &kinematics, &mut mass);
        let Ok(factor) = mass.matrix.factor() else { return };
        let mut block = EqualityBlock::new(model);
        let (mut all, mut equality_of) = (SparseRows::default(), Vec::new());
        for (e, equality) in model.equalities.iter().enumerate() {
            for b in 0..equality.kind.block_count() {
                equality_block_into(model, &kinematics, q, &equality.kind, b, &mut block);
                push_rows(&block, assembly_tolerance, |_, columns, _| all.push(columns));
            }
            equality_of.resize(all.len(), e);
        }
        for rows in rows_that_share_trees(&all, &equality_of, &mass.matrix) {
            let mut rank_of_each = 0;
            let mut dependent = Vec::new();
            for own in rows.chunk_by(|a, b| equality_of[*a] == equality_of[*b]) {
                let rank = self.rank(&all, own, &factor);
                rank_of_each += rank;
                if rank < own.len() {
                    dependent.push(vec![equality_of[own[0]]]);
                }
            }
            if rows.len() <= MOST_DENSE_ROWS && self.rank(&all, &rows, &factor) < rank_of_each {
                let mut equalities: Vec<usize> = rows.iter().map(|&k| equality_of[k]).collect();
                equalities.dedup();
                dependent = vec![equalities];
            }
            dependent.into_iter().for_each(|equalities| self.add_group(equalities));
        }
    }

    /// How many of some rows are independent.
    fn rank(&mut self, all: &SparseRows<1>, rows: &[usize], mass: &BlockCholesky) -> usize {
        self.rows.clear();
        rows.iter().for_each(|&k| copy_row(all, k, &mut self.rows));
        self.basis.factor(&self.rows, mass);
        self.basis.rank()
    }

    /// Adds a set of constraints in place of those that it contains, unless another one contains it.
    fn add_group(&mut self, equalities: Vec<usize>) {
        let contains = |a: &[usize], b: &[usize]| b.iter().all(|e| a.binary_search(e).is_ok());
        if !self.groups.iter().any(|other| contains(other, &equalities)) {
            self.groups.retain(|other| !contains(&equalities, other));
            self.groups.push(equalities);
        }
    }

    /// Leaves out the rows of a problem that follow from others, where all of a group ask for what the others leave.
    pub fn leave_out(&mut self, problem: &mut ContactProblem, source: &mut Vec<BilateralSource>) {
        if self.groups.is_empty() {
            return;
        }
        self.is_left_out.clear();
        self.is_left_out.resize(source.len(), false);
        for group in 0..self.groups.len() {
            self.find_in_group(group, problem, source);
        }
        if !self.is_left_out.contains(&true) {
            return;
        }
        let (jacobian, violation) = &mut self.staying;
        jacobian.clear();
        violation.clear();
        for k in (0..source.len()).filter(|k| !self.is_left_out[*k]) {
            copy_row(&problem.bilateral_jacobian, k, jacobian);
            violation.push(problem.bilateral_violation[k]);
        }
        std::mem::swap(&mut problem.bilateral_jacobian, jacobian);
        std::mem::swap(&mut problem.bilateral_violation, violation);
        let mut row = 0..;
        source.retain(|_| row.next().is_some_and(|k: usize| !self.is_left_out[k]));
    }

    fn find_in_group(&mut self, group: usize, problem: &ContactProblem, source: &[BilateralSource]) {
        let Self { groups, basis, rows, places, rates, is_left_out, .. } = self;
        let (all, dt) = (&problem.bilateral_jacobian, problem.timestep);
        rows.clear();
        places.clear();
        rates.clear();
        let equalities = &groups[group];
        let (Some(first), Some(last)) = (equalities.first(), equalities.last()) else { return };
        let begin = source.partition_point(|row| row.equality < *first);
        for (k, row) in source.iter().enumerate().skip(begin).take_while(|(_, row)| row.equality <= *last) {
            if equalities.binary_search(&row.equality).is_ok() {
                copy_row(all, k, rows);
                places.push(k);
                let [rate] = all.multiply(k, &problem.free_velocity);
                rates.push(rate + problem.bilateral_violation[k] / dt);
            }
        }
        basis.factor_preferring_large(rows, &problem.mass_factor);
        if basis.rank() < places.len() && basis.contradiction(rates, OFF / dt).is_empty() {
            places.iter().for_each(|&k| is_left_out[k] = true);
            basis.independent().iter().for_each(|&row| is_left_out[places[row]] = false);
        }
    }
}

fn copy_row(from: &SparseRows<1>, k: usize, to: &mut SparseRows<1>) {
    let (columns, entries) = from.group(k);
    to.push_renumbered(columns.iter().copied(), entries);
}

/// Sets of rows that are tied together by trees and by their constraints, each ascending.
fn rows_that_share_trees(
    rows: &SparseRows<1>,
    equality_of: &[usize],
    mass: &BlockDiagonal,
) -> impl Iterator<Item = Vec<usize>> {
    let mut parent: Vec<usize> = (0..mass.blocks().len()).collect();
    fn root(parent: &mut [usize], mut tree: usize) -> usize {
        while parent[tree] != tree {
            parent[tree] = parent[parent[tree]];
            tree = parent[tree];
        }
        tree
    }
    let trees = |k: usize| rows.group(k).0.iter().map(|dof| mass.block_of(*dof as usize));
    let mut last = None;
    for (k, equality) in equality_of.iter().enumerate() {
        for tree in trees(k) {
            if let Some((_, first)) = last.filter(|(of, _)| of == equality) {
                let (a, b) = (root(&mut parent, first), root(&mut parent, tree));
                parent[a] = b;
            }
            last = Some((*equality, tree));
        }
    }
    let mut sets = BTreeMap::<usize, Vec<usize>>::new();
    for k in 0..equality_of.len() {
        if let Some(tree) = trees(k).next() {
            sets.entry(root(&mut parent, tree)).or_default().push(k);
        }
    }
    sets.into_values()
}
