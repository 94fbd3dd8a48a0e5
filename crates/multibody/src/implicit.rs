//! What forces along lengths add to the step without contact, taken implicitly (the scheme is derived in `free_motion.rs`).

use crate::length::LengthRow;
use crate::mass::BlockDiagonal;
use crate::model::Model;

/// Adds forces along lengths to a matrix and a right-hand side; memory is reused.
#[derive(Clone, Debug)]
pub(crate) struct ImplicitLengths {
    runs: Vec<Run>,
    /// Blocks of the matrix with entries below the diagonal that those above it lack.
    lower: Vec<usize>,
}

/// Neighbours in a row that are neighbours among the degrees of freedom, each on the way of the next one to the root.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: usize,
    end: usize,
    /// The next one in the row on their way to the root: its run, and its place in the row.
    above: Option<(usize, usize)>,
}

impl ImplicitLengths {
    /// Storage that never grows for the model.
    pub fn new(model: &Model) -> Self {
        Self { runs: Vec::with_capacity(model.nv), lower: Vec::with_capacity(model.nv) }
    }

    /// Adds a force along a length to the right-hand side and its implicit part to the matrix, in which entries above the diagonal wait for
    /// [`finish`](Self::finish).
    ///
    /// - `impulse`: of the force in the step, N·s; `weight`: its fall per unit of the length's rate at the end, kg
    pub fn add(
        &mut self,
        model: &Model,
        (impulse, weight): (f64, f64),
        row: &LengthRow,
        matrix: &mut BlockDiagonal,
        rhs: &mut [f64],
    ) {
        row.dofs.iter().zip(&row.gradient).for_each(|(&k, g)| rhs[k] += impulse * g);
        if weight == 0.0 {
            return;
        }
        row.dofs.iter().zip(&row.gradient).for_each(|(&k, g)| matrix.add_to_diagonal(k, weight * g * g));
        if row.dofs.len() > 1 {
            self.find_runs(model, &row.dofs);
            self.couple_ways(row, weight, matrix);
            self.bound_branches(row, weight, matrix);
        }
    }

    /// Completes the matrix.
    pub fn finish(&mut self, matrix: &mut BlockDiagonal) {
        self.lower.drain(..).for_each(|block| matrix.mirror_lower(block));
    }

    fn find_runs(&mut self, model: &Model, dofs: &[usize]) {
        self.runs.clear();
        for (i, &k) in dofs.iter().enumerate() {
            let follows = i > 0 && dofs[i - 1] + 1 == k && model.dof_parent[k] == Some(dofs[i - 1]);
            if let (true, Some(run)) = (follows, self.runs.last_mut()) {
                run.end = i + 1;
                continue;
            }
            let way = std::iter::successors(model.dof_parent[k], |&l| model.dof_parent[l]);
            let place = way.take_while(|&l| l >= dofs[0]).find_map(|l| dofs[..i].binary_search(&l).ok());
            let above = place.map(|place| (self.runs.partition_point(|run| run.end <= place), place));
            self.runs.push(Run { start: i, end: i + 1, above });
        }
    }

    /// Entries of two degrees of freedom on one way to the root, below the diagonal.
    fn couple_ways(&mut self, row: &LengthRow, weight: f64, matrix: &mut BlockDiagonal) {
        for run in &self.runs {
            for i in run.start..run.end {
                let (k, factor) = (row.dofs[i], weight * row.gradient[i]);
                let (mut first, mut last, mut above) = (run.start, i, run.above);
                loop {
                    if first < last {
                        matrix.add_to_row(k, row.dofs[first], factor, &row.gradient[first..last]);
                    }
                    let Some((next, place)) = above else { break };
                    (first, last, above) = (self.runs[next].start, place + 1, self.runs[next].above);
                }
            }
        }
        for run in self.runs.iter().filter(|run| run.end - run.start > 1 || run.above.is_some()) {
            let block = matrix.block_of(row.dofs[run.start]);
            if !self.lower.contains(&block) {
                self.lower.push(block);
            }
        }
    }

    /// What bounds the entries of degrees of freedom in different branches, which are left out: on the diagonal.
    fn bound_branches(&self, row: &LengthRow, weight: f64, matrix: &mut BlockDiagonal) {
        let size = |places: std::ops::Range<usize>| row.gradient[places].iter().map(|g| g.abs()).sum::<f64>();
        for (s, below) in self.runs.iter().enumerate() {
            for r in 0..s {
                let beside = self.end_of_way(r, s)..self.runs[r].end;
                if beside.is_empty() {
                    continue;
                }
                let others = below.start..below.end;
                for (places, by) in [(beside.clone(), size(others.clone())), (others, size(beside))] {
                    for i in places {
                        matrix.add_to_diagonal(row.dofs[i], (weight * row.gradient[i]).abs() * by);
                    }
                }
            }
        }
    }

    /// One after the last place of run `r` that is on the way of run `s` to the root.
    fn end_of_way(&self, r: usize, s: usize) -> usize {
        let way = std::iter::successors(self.runs[s].above, |&(run, _)| self.runs[run].above);
        way.take_while(|&(run, _)| run >= r)
            .find(|&(run, _)| run == r)
            .map_or(self.runs[r].start, |(_, place)| place + 1)
    }
}
