//! Levenberg and Marquardt's method over trajectories.

use std::sync::atomic::{AtomicU64, Ordering};

use signorini_multibody::Model;
use signorini_simulation::SimulationError;

use super::rollout::{Rollouts, Sums};
use super::{Identification, IdentificationProgress, Recording, Task, Unknown};
use crate::matrix::{cholesky, cholesky_solve};

/// Damping at the beginning, as a part of the curvature; it goes down and up by these factors, and the method ends beyond the last.
const DAMPING: f64 = 1e-3;
const LESS: f64 = 0.2;
const MORE: f64 = 5.0;
const MOST: f64 = 1e8;
/// Neighbours of each unknown, as parts of its size, that are looked at where the method can go no further: contact makes the objective rough,
/// and its slopes are those of the roughness.
const NEIGHBOURS: [f64; 6] = [0.2, -0.2, 0.05, -0.05, 0.01, -0.01];
/// The least size of an unknown, as a part of its bounds.
const ROOM: f64 = 0.1;
/// What is left of an unknown's curvature when the others answer, as a part of it: below, they undo what it does.
const UNDETERMINED: f64 = 1e-8;
/// By which part of a bound an objective has to exceed it to be left early.
const ROUNDING: f64 = 1e-12;
/// Recordings per unknown from which on their spread is a covariance.
const ENOUGH: usize = 3;

/// The method at some values.
#[derive(Clone)]
pub(super) struct Fit<'a> {
    pub task: Task<'a>,
    pub recordings: &'a [Recording],
    pub model: Model,
    pub values: Vec<f64>,
    /// How often each recording counts.
    pub counts: Vec<usize>,
    pub tried: usize,
}

/// Where the method ended: the sums there, those of each recording, and whether nothing more was to be gained.
pub(super) struct End {
    whole: Sums,
    per_recording: Vec<Sums>,
    converged: bool,
}

impl Fit<'_> {
    /// Follows the slopes, and the neighbours where these lead no further.
    pub fn search(
        &mut self,
        progress: &mut dyn FnMut(&IdentificationProgress) -> bool,
    ) -> Result<End, SimulationError> {
        let asked = self.task.asked;
        let mut per_recording = self.evaluate(&self.values, true, f64::INFINITY)?;
        let mut whole = self.sum(&per_recording);
        let (mut damping, mut converged) = (DAMPING, false);
        while self.tried < asked.iterations {
            self.tried += 1;
            let next = if damping <= MOST { self.propose(&whole, damping) } else { None };
            let is_stuck = next.is_none();
            let is_near = next.as_ref().is_some_and(|next| self.is_near(next));
            let better = match next {
                Some(next) => self.objective_below(whole.objective, &next)?.map(|found| (found, next)),
                None => self.best_neighbour(whole.objective)?,
            };
            if let Some((objective, next)) = better {
                converged = !is_stuck && whole.objective - objective <= asked.tolerance * whole.objective;
                self.values = next;
                damping = if is_stuck { DAMPING } else { damping * LESS };
                per_recording = self.evaluate(&self.values, true, f64::INFINITY)?;
                whole = self.sum(&per_recording);
            } else {
                // A step within the nearest neighbours that leads nowhere: the slopes are those of the roughness.
                damping = if is_near { 2.0 * MOST } else { damping * MORE };
                converged = is_stuck;
            }
            // What gains no more by slopes may gain by its neighbours.
            if converged && !is_stuck {
                (converged, damping) = (false, 2.0 * MOST);
            }
            let objective = whole.objective / whole.count;
            let news = IdentificationProgress { iteration: self.tried, objective, values: self.values.clone() };
            if !progress(&news) || converged {
                break;
            }
        }
        Ok(End { whole, per_recording, converged })
    }

    /// Sets of recordings to be drawn.
    pub fn draws(&self) -> usize {
        self.task.asked.draws
    }

    fn model_at(&self, values: &[f64]) -> Model {
        let mut model = self.model.clone();
        for (unknown, value) in self.task.unknowns.iter().zip(values) {
            unknown.set(&mut model, *value);
        }
        model
    }

    /// The sums of every recording, on all cores. What has no slopes ends where its objective is seen to be above `bound`.
    fn evaluate(&self, values: &[f64], with_slopes: bool, bound: f64) -> Result<Vec<Sums>, SimulationError> {
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(self.recordings.len().max(1));
        let model = self.model_at(values);
        // All objectives so far, of all cores. Sums in another order, as those that decide are, differ by rounding.
        let spent = AtomicU64::new(0.0_f64.to_bits());
        let bound = bound * (1.0 + ROUNDING);
        let part = |first: usize| -> Result<Vec<(usize, Sums)>, SimulationError> {
            let mut rollouts = Rollouts::new(self.task, model.clone(), values, with_slopes)?;
            let mut own = Vec::new();
            for i in (first..self.recordings.len()).step_by(threads).filter(|&i| self.counts[i] > 0) {
                let sums = rollouts.run(&self.recordings[i])?;
                let more = self.counts[i] as f64 * sums.objective;
                own.push((i, sums));
                let add = |sum: u64| Some((f64::from_bits(sum) + more).to_bits());
                let before = spent.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add).unwrap_or_default();
                if !with_slopes && f64::from_bits(before) + more > bound {
                    break;
                }
            }
            Ok(own)
        };
        let parts = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
            let joined = workers.into_iter().map(|worker| worker.join());
            joined.map(|end| end.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect::<Vec<_>>()
        });
        let mut sums = vec![Sums::default(); self.recordings.len()];
        for part in parts {
            for (i, own) in part? {
                sums[i] = own;
            }
        }
        Ok(sums)
    }

    /// The objective with other values where it is below a bound; values with which there is no such model are not.
    fn objective_below(&self, bound: f64, values: &[f64]) -> Result<Option<f64>, SimulationError> {
        if self.model_at(values).check_numbers().is_err() {
            return Ok(None);
        }
        // Every recording adds to it: a part that is above the bound decides, and one that is not, is the whole.
        let objective = self.sum_at(values, &self.evaluate(values, false, bound)?).objective;
        Ok((objective < bound).then_some(objective))
    }

    /// Goes to the best of some places within the bounds; returns the objective at the values of the model.
    pub fn start(&mut self) -> Result<f64, SimulationError> {
        let own = self.sum_at(&self.values, &self.evaluate(&self.values, false, f64::INFINITY)?).objective;
        let mut least = if own.is_finite() { own } else { f64::INFINITY };
        for k in 1..=self.task.asked.starts {
            let within = |(i, unknown): (usize, &Unknown)| {
                let [lower, upper] = unknown.bounds;
                lower + (upper - lower) * radical_inverse(k, i)
            };
            let values: Vec<f64> = self.task.unknowns.iter().enumerate().map(within).collect();
            if let Some(found) = self.objective_below(least, &values)? {
                (least, self.values) = (found, values);
            }
        }
        Ok(own)
    }

    /// Whether values are nearer than the nearest neighbours.
    fn is_near(&self, values: &[f64]) -> bool {
        let least = NEIGHBOURS.iter().fold(f64::INFINITY, |least, part| least.min(part.abs()));
        values.iter().zip(&self.values).enumerate().all(|(i, (next, own))| (next - own).abs() <= least * self.size(i))
    }

    /// What an unknown is changed in parts of: itself, or what its bounds leave it where that is more.
    fn size(&self, i: usize) -> f64 {
        let [lower, upper] = self.task.unknowns[i].bounds;
        let room = if upper - lower < f64::INFINITY { ROOM * (upper - lower) } else { 0.0 };
        self.values[i].abs().max(room)
    }

    /// The best of the values nearby that lower the objective.
    fn best_neighbour(&self, objective: f64) -> Result<Option<(f64, Vec<f64>)>, SimulationError> {
        let mut best: Option<(f64, Vec<f64>)> = None;
        for (i, unknown) in self.task.unknowns.iter().enumerate() {
            for part in NEIGHBOURS {
                let mut values = self.values.clone();
                let [lower, upper] = unknown.bounds;
                values[i] = (values[i] + part * self.size(i)).clamp(lower, upper);
                let least = best.as_ref().map_or(objective, |(least, _)| *least);
                if values != self.values
                    && let Some(found) = self.objective_below(least, &values)?
                {
                    best = Some((found, values));
                }
            }
        }
        Ok(best)
    }

    /// The sum over recordings, with the priors.
    fn sum(&self, per_recording: &[Sums]) -> Sums {
        self.sum_at(&self.values, per_recording)
    }

    fn sum_at(&self, values: &[f64], per_recording: &[Sums]) -> Sums {
        let n = per_recording.iter().map(|sums| sums.gradient.len()).max().unwrap_or(0);
        let mut whole = Sums::new(n);
        per_recording.iter().zip(&self.counts).for_each(|(sums, &times)| whole.add(sums, times));
        for (i, unknown) in self.task.unknowns.iter().enumerate() {
            let Some([mean, deviation]) = unknown.prior else { continue };
            let off = (values[i] - mean) / deviation;
            whole.objective += 0.5 * off * off;
            if n > 0 {
                whole.gradient[i] += off / deviation;
                whole.curvature[i * n + i] += 1.0 / (deviation * deviation);
            }
        }
        whole
    }

    /// A damped step within the bounds; nothing where none leads anywhere.
    fn propose(&self, whole: &Sums, damping: f64) -> Option<Vec<f64>> {
        let n = self.values.len();
        let held: Vec<bool> = (0..n).map(|i| self.pushes_out(i, -whole.gradient[i])).collect();
        let free: Vec<usize> = (0..n).filter(|&i| !held[i] && whole.curvature[i * n + i] > 0.0).collect();
        let m = free.len();
        let mut system: Vec<f64> = free
            .iter()
            .flat_map(|&i| free.iter().map(move |&j| (i, j)))
            .map(|(i, j)| whole.curvature[i * n + j] * if i == j { 1.0 + damping } else { 1.0 })
            .collect();
        let mut step: Vec<f64> = free.iter().map(|&i| -whole.gradient[i]).collect();
        if m == 0 || !cholesky(&mut system, m) {
            return None;
        }
        cholesky_solve(&system, m, &mut step);
        let mut next = self.values.clone();
        for (&i, step) in free.iter().zip(&step) {
            let [lower, upper] = self.task.unknowns[i].bounds;
            next[i] = (next[i] + step).clamp(lower, upper);
        }
        (next != self.values).then_some(next)
    }

    /// Whether an unknown is at a bound and a step of this sign would leave it.
    fn pushes_out(&self, i: usize, step: f64) -> bool {
        let [lower, upper] = self.task.unknowns[i].bounds;
        (self.values[i] <= lower && step < 0.0) || (self.values[i] >= upper && step > 0.0)
    }

    pub fn result(&self, first: f64, end: &End) -> Identification {
        let End { whole, per_recording, converged } = end;
        let n = self.values.len();
        let at_bound: Vec<bool> = (0..n).map(|i| self.pushes_out(i, -whole.gradient[i])).collect();
        let determined = determined(&whole.curvature, n);
        let count = whole.count.max(1.0);
        Identification {
            covariance: self.covariance(whole, per_recording, &determined),
            at_bound,
            determined,
            objective: [first / count, whole.objective / count],
            deviation: (whole.squares / count).sqrt(),
            iterations: self.tried,
            converged: *converged,
            steps: whole.steps,
            model: self.model_at(&self.values),
            values: self.values.clone(),
        }
    }

    fn covariance(&self, whole: &Sums, per_recording: &[Sums], determined: &[bool]) -> Vec<f64> {
        let n = self.values.len();
        let known: Vec<usize> = (0..n).filter(|&i| determined[i]).collect();
        let m = known.len();
        let mut factor: Vec<f64> =
            known.iter().flat_map(|&i| known.iter().map(move |&j| whole.curvature[i * n + j])).collect();
        let mut covariance = vec![0.0; n * n];
        (0..n).filter(|&i| !determined[i]).for_each(|i| covariance[i * n + i] = f64::INFINITY);
        if !cholesky(&mut factor, m) {
            return covariance;
        }
        let solved = |mut x: Vec<f64>| {
            cholesky_solve(&factor, m, &mut x);
            x
        };
        let mut add = |x: &[f64], y: &[f64], scale: f64| {
            for (a, &i) in known.iter().enumerate() {
                known.iter().enumerate().for_each(|(b, &j)| covariance[i * n + j] += scale * x[a] * y[b]);
            }
        };
        if per_recording.len() >= ENOUGH * n.max(1) {
            // A recording is one draw, however its samples hang together.
            let draws = per_recording.len() as f64;
            for own in per_recording {
                let influence = solved(known.iter().map(|&i| own.gradient[i]).collect());
                add(&influence, &influence, draws / (draws - 1.0));
            }
        } else {
            let freedom = (whole.samples * self.model.nv).saturating_sub(m).max(1) as f64;
            for a in 0..m {
                let unit = (0..m).map(|b| f64::from(u8::from(a == b))).collect::<Vec<_>>();
                let column = solved(unit.clone());
                add(&unit, &column, whole.squares / freedom);
            }
        }
        covariance
    }
}

/// Coordinate `i` of point `k ≥ 1` of a sequence that fills a cube evenly.
///
/// # Source
/// J. Halton, *On the efficiency of certain quasi-random sequences of points*, Numerische Mathematik 2 (1960).
fn radical_inverse(k: usize, i: usize) -> f64 {
    const PRIMES: [usize; 10] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29];
    let base = PRIMES[i % PRIMES.len()];
    let (mut k, mut digit, mut sum) = (k + i / PRIMES.len(), 1.0, 0.0);
    while k > 0 {
        digit /= base as f64;
        sum += digit * (k % base) as f64;
        k /= base;
    }
    sum
}

/// Which unknowns the curvature determines: what is left of each one's own when all others answer.
fn determined(curvature: &[f64], n: usize) -> Vec<bool> {
    let size = |i: usize| curvature[i * n + i].max(0.0).sqrt();
    let left = |i: usize| {
        // The last pivot of the factor with unknown i at the end, scaled; nothing before it may vanish for its sake.
        let others = (0..n).filter(|&j| j != i && size(j) > 0.0);
        let order: Vec<usize> = others.chain([i]).collect();
        let m = order.len();
        let entry = |a: usize, b: usize| curvature[order[a] * n + order[b]] / (size(order[a]) * size(order[b]));
        let mut matrix: Vec<f64> = (0..m * m).map(|k| entry(k / m, k % m)).collect();
        (0..m - 1).for_each(|k| matrix[k * m + k] += f64::EPSILON * m as f64);
        if cholesky(&mut matrix, m) { matrix[m * m - 1].powi(2) } else { 0.0 }
    };
    (0..n).map(|i| size(i) > 0.0 && left(i) > UNDETERMINED).collect()
}
