//! What the sweeps know of an island, and one visit to each of its rows.

use signorini_contact::projection::Mode;
use signorini_contact::scales::raise;

use super::half_rows::{Bodies, HalfRows};
use super::single::{Polygons, Single, reciprocal};
use crate::islands::Island;
use crate::iterate::Iterate;
use crate::residual::law_residual;
use crate::task::Task;

/// Half-solved rows of an island with the Delassus blocks of its units.
#[derive(Clone, Debug, Default)]
pub(super) struct System {
    pub bodies: Bodies,
    pub rows: HalfRows<3>,
    pub bilateral_rows: HalfRows<1>,
    singles: Vec<Single>,
    polygons: Polygons,
    /// Reciprocals of `Z Zᵀ` of the bilateral rows.
    bilateral_step: Vec<f64>,
}

/// Impulses and modes of an island and the sum that they give.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    pub impulse: Vec<[f64; 3]>,
    pub bilateral: Vec<f64>,
    pub modes: Vec<Mode>,
    /// `s`, over the degrees of freedom.
    pub sum: Vec<f64>,
}

/// What the laws lack at a point, relative to the velocity scale.
#[derive(Clone, Debug, Default)]
pub(super) struct Lacking {
    /// Of each unit, then of each bilateral row.
    pub rows: Vec<f64>,
    pub worst: f64,
    /// Root mean square.
    pub rms: f64,
}

impl System {
    /// Takes the data of an island.
    pub fn begin(&mut self, task: &Task) {
        let (island, factor) = (task.island, &task.problem.mass_factor);
        self.bodies.find(island);
        self.rows.clear();
        self.singles.clear();
        self.polygons.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let (columns, entries) = island.jacobian.group(c);
            let entry = |k: usize| island.pushing(c, entries[k]);
            let delassus = self.rows.push(factor, island, &self.bodies, columns, entry);
            self.singles.push(self.polygons.single(task.problem, task.cones, i as usize, delassus));
        }
        self.bilateral_rows.clear();
        self.bilateral_step.clear();
        for k in 0..island.bilateral.len() {
            let (columns, entries) = island.bilateral_jacobian.group(k);
            let [[square]] = self.bilateral_rows.push(factor, island, &self.bodies, columns, |k| entries[k]);
            self.bilateral_step.push(reciprocal(square));
        }
    }

    /// Visits every row once; backward in the opposite order.
    pub fn sweep(&self, task: &Task, point: &mut Point, backward: bool) {
        let (units, rows) = (task.island.units.len(), task.island.bilateral.len());
        if backward {
            (0..rows).rev().for_each(|k| self.visit_bilateral(task.island, point, k));
            (0..units).rev().for_each(|c| self.visit(task, point, c));
        } else {
            (0..units).for_each(|c| self.visit(task, point, c));
            (0..rows).for_each(|k| self.visit_bilateral(task.island, point, k));
        }
    }

    #[inline]
    fn visit(&self, task: &Task, point: &mut Point, c: usize) {
        let p = point.impulse[c];
        let bound = c.checked_sub(task.island.contact_count).map(|j| bound_of(task.island, point, c, j));
        let unit = (task.island.units[c] as usize, &self.singles[c]);
        let u = self.velocity_of(task.island, point, c);
        let (next, mode) = self.polygons.solve(task.cones, unit, (u, p), bound, point.modes[c]);
        point.modes[c] = mode;
        let change = std::array::from_fn(|r| next[r] - p[r]);
        if change != [0.0; 3] {
            point.impulse[c] = next;
            self.rows.add_transposed(c, change, &mut point.sum);
        }
    }

    fn visit_bilateral(&self, island: &Island, point: &mut Point, k: usize) {
        let [moved] = self.bilateral_rows.multiply(k, &point.sum);
        let change = -self.bilateral_step[k] * (island.bilateral_free_slack[k] + moved);
        point.bilateral[k] += change;
        self.bilateral_rows.add_transposed(k, [change], &mut point.sum);
    }

    /// `u` of a unit.
    #[inline]
    fn velocity_of(&self, island: &Island, point: &Point, c: usize) -> [f64; 3] {
        let (moved, free) = (self.rows.multiply(c, &point.sum), island.free_slack[c]);
        std::array::from_fn(|r| free[r] + moved[r])
    }

    /// Brings the friction groups within their bounds, which may have changed after their visits, and sums `s` afresh.
    pub fn settle(&self, task: &Task, point: &mut Point) {
        let island = task.island;
        for (j, c) in (island.contact_count..island.units.len()).enumerate() {
            let [_, a, b] = point.impulse[c];
            let y = [bound_of(island, point, c, j), a, b];
            let mode = task.cones.mode_at(island.units[c] as usize, y);
            point.impulse[c] = task.cones.project(island.units[c] as usize, mode, y);
            // An open group has no bound, and keeps it.
            point.impulse[c][0] = y[0];
        }
        self.sum_up(point);
    }

    /// `s = Σ Zᵀ λ`.
    fn sum_up(&self, point: &mut Point) {
        let Point { impulse, bilateral, sum, .. } = point;
        let nv = sum.len();
        sum.clear();
        sum.resize(nv, 0.0);
        impulse.iter().enumerate().for_each(|(c, p)| self.rows.add_transposed(c, *p, sum));
        bilateral.iter().enumerate().for_each(|(k, p)| self.bilateral_rows.add_transposed(k, [*p], sum));
    }

    /// Takes the impulses and modes of an iterate.
    pub fn start(&self, task: &Task, iterate: &Iterate, point: &mut Point) {
        point.impulse.clone_from(&iterate.impulse);
        point.bilateral.clone_from(&iterate.bilateral);
        point.modes.clone_from(&iterate.modes);
        point.modes.resize(point.impulse.len(), Mode::Stick);
        point.sum.resize(task.island.nv(), 0.0);
        self.sum_up(point);
    }

    /// What the laws lack at a point.
    pub fn measure(&self, task: &Task, point: &Point, lacking: &mut Lacking) {
        let (island, scale) = (task.island, task.island.velocity_scale.value());
        let relative = if scale > 0.0 { 1.0 / scale } else { 0.0 };
        lacking.rows.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let u = island.pushing(c, self.velocity_of(island, point, c));
            let residual = law_residual(task.cones, i as usize, point.impulse[c], u, island.residual_scale);
            lacking.rows.push(relative * residual);
        }
        for (k, free) in island.bilateral_free_slack.iter().enumerate() {
            let [moved] = self.bilateral_rows.multiply(k, &point.sum);
            lacking.rows.push(relative * (free + moved).abs());
        }
        let mut squares = 0.0;
        lacking.worst = 0.0;
        for residual in &lacking.rows {
            raise(&mut lacking.worst, *residual);
            squares += residual * residual;
        }
        lacking.rms = (squares / lacking.rows.len().max(1) as f64).sqrt();
    }
}

/// What bounds friction group `j`, unit `c`: the normal impulse of its contact, or a constant that stays in the impulse.
fn bound_of(island: &Island, point: &Point, c: usize, j: usize) -> f64 {
    let by = island.bounded_by[j] as usize;
    if by == c { point.impulse[c][0] } else { point.impulse[by][0] }
}
