//! A guess of the modes of a small island by projected Gauss–Seidel sweeps.
//!
//! Contact after contact gets the impulse that its own law asks for with the others as they are, forwards and backwards in turn
//! (Jourdan, Alart, Jean 1998). The sweeps converge slowly, where they converge at all, but which contacts close and which of
//! them slide is mostly settled soon. Only these modes are kept: impulses and the exact iterations know nothing of the sweeps.

use signorini_contact::{ContactProblem, SparseRows, StageOutcome};

use super::shared::{Outcome, Shared};
use crate::islands::Island;
use crate::iterate::Iterate;
use crate::task::Task;

/// What is tuned in this stage.
struct Tuning {
    /// Sweeps at most.
    sweeps: usize,
}

/// Chosen by: `contact_lcp --directions 8 --no-growth`, 21 November 2026.
const TUNING: Tuning = Tuning { sweeps: 20 };

/// Memory of the sweeps. With `M = Lᵀ L` velocities are `v^f + L⁻¹ s`, `s = Σ Z_cᵀ λ_c` and `Z_c = J_c L⁻¹`, so that
/// `u_c = u_c(v^f) + Z_c s`.
#[derive(Clone, Debug, Default)]
pub(super) struct Sweeps {
    /// `Z` of the units, over local degrees of freedom; zero in rows that push nothing.
    rows: SparseRows<3>,
    bilateral_rows: SparseRows<1>,
    /// Reciprocals of the diagonal of `Z Zᵀ`, one for both tangents.
    step: Vec<[f64; 2]>,
    bilateral_step: Vec<f64>,
    /// `s`.
    sum: Vec<f64>,
    impulse: Vec<[f64; 3]>,
    columns: Vec<u32>,
    entries: Vec<[f64; 3]>,
    bilateral_entries: Vec<[f64; 1]>,
}

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    iterate.modes.is_empty() && !task.is_large()
}

/// Sets the modes to those of the trial impulses without impulses, and where these do not hold, to those that sweeps find.
pub(super) fn run(sweeps: &mut Sweeps, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let map = &mut shared.map;
    map.set_weights(task.island, task.settings.proximal_weight);
    let residual = map.evaluate_centre(task, iterate);
    map.guess_modes(task, &mut iterate.modes);
    if residual <= task.settings.polish {
        iterate.residual = residual;
        return StageOutcome::Solved.into();
    }
    map.prepare(task);
    if !map.solve_modes(task, iterate) || map.violations(task, iterate) > 0 {
        sweeps.sweep(task, iterate);
        map.change_modes();
    }
    StageOutcome::Prepared.into()
}

impl Sweeps {
    /// Sets the modes to those that the sweeps find from a start without impulses.
    fn sweep(&mut self, task: &Task, iterate: &mut Iterate) {
        let units = task.island.units.len();
        self.begin(task.problem, task.island, iterate);
        let mut settled = 0;
        for sweep in 0..TUNING.sweeps {
            let mut changed = false;
            for k in 0..units {
                changed |= self.visit(task, iterate, if sweep % 2 == 0 { k } else { units - 1 - k });
            }
            self.visit_bilateral(task.island);
            settled = if changed { 0 } else { settled + 1 };
            // Forwards and backwards.
            if settled == 2 {
                break;
            }
        }
    }

    fn begin(&mut self, problem: &ContactProblem, island: &Island, iterate: &Iterate) {
        self.impulse.clone_from(&iterate.impulse);
        self.sum.clear();
        self.sum.resize(island.nv(), 0.0);
        self.rows.clear();
        self.step.clear();
        let entries = &mut self.entries;
        for c in 0..island.units.len() {
            let (columns, jacobian) = island.jacobian.group(c);
            half_solve(problem, island, columns, jacobian, &mut self.columns, entries);
            if c >= island.contact_count {
                entries.iter_mut().for_each(|e| e[0] = 0.0);
            }
            let mut diagonal = [0.0; 3];
            entries.iter().for_each(|e| (0..3).for_each(|r| diagonal[r] += e[r] * e[r]));
            self.step.push([diagonal[0], diagonal[1].max(diagonal[2])].map(reciprocal));
            self.rows.push_renumbered(self.columns.iter().copied(), entries);
        }
        self.bilateral_rows.clear();
        self.bilateral_step.clear();
        for k in 0..island.bilateral.len() {
            let (columns, jacobian) = island.bilateral_jacobian.group(k);
            half_solve(problem, island, columns, jacobian, &mut self.columns, &mut self.bilateral_entries);
            self.bilateral_step.push(reciprocal(self.bilateral_entries.iter().map(|[e]| e * e).sum()));
            self.bilateral_rows.push_renumbered(self.columns.iter().copied(), &self.bilateral_entries);
        }
    }

    /// Gives unit `c` the impulse of its law; whether its mode changed.
    fn visit(&mut self, task: &Task, iterate: &mut Iterate, c: usize) -> bool {
        let (cones, island) = (task.cones, task.island);
        let (i, free, [normal, tangential]) = (island.units[c] as usize, island.free_slack[c], self.step[c]);
        let moved = self.rows.multiply(c, &self.sum);
        let u: [f64; 3] = std::array::from_fn(|r| free[r] + moved[r]);
        let p = self.impulse[c];
        let bound = match c.checked_sub(island.contact_count) {
            None => p[0] - normal * u[0],
            Some(group) => self.impulse[island.bounded_by[group] as usize][0],
        };
        let y = [bound, p[1] - tangential * u[1], p[2] - tangential * u[2]];
        let mode = cones.mode_at(i, y);
        let next = cones.project(i, mode, y);
        let change: [f64; 3] = std::array::from_fn(|r| next[r] - p[r]);
        if change != [0.0; 3] {
            self.rows.add_transposed(c, change, &mut self.sum);
            self.impulse[c] = next;
        }
        std::mem::replace(&mut iterate.modes[c], mode) != mode
    }

    fn visit_bilateral(&mut self, island: &Island) {
        for (k, (free, step)) in island.bilateral_free_slack.iter().zip(&self.bilateral_step).enumerate() {
            let [moved] = self.bilateral_rows.multiply(k, &self.sum);
            self.bilateral_rows.add_transposed(k, [-step * (free + moved)], &mut self.sum);
        }
    }
}

fn reciprocal(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// `J L⁻¹` for a group of rows: its columns, all those of the blocks that the group touches, and the entries in them.
fn half_solve<const R: usize>(
    problem: &ContactProblem,
    island: &Island,
    columns: &[u32],
    jacobian: &[[f64; R]],
    all_columns: &mut Vec<u32>,
    entries: &mut Vec<[f64; R]>,
) {
    all_columns.clear();
    entries.clear();
    let mut first = 0;
    while first < columns.len() {
        let block = island.block_of(columns[first] as usize);
        let (start, end) = (island.starts[block], island.starts[block + 1]);
        let begin = entries.len();
        all_columns.extend(start as u32..end as u32);
        entries.resize(begin + end - start, [0.0; R]);
        while first < columns.len() && (columns[first] as usize) < end {
            entries[begin + columns[first] as usize - start] = jacobian[first];
            first += 1;
        }
        problem.mass_factor.half_solve_block(island.blocks[block] as usize, &mut entries[begin..]);
    }
}
