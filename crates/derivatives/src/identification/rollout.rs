//! Recordings simulated, with the slopes of their trajectories.

use std::ops::Range;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Input, JointKind, Model, State, difference_into, integrate_into, right_jacobian};
use signorini_simulation::{Settings, SimulationError, Workspace, step};

use super::{Recording, Task};
use crate::StepDerivatives;
use crate::matrix::add_scaled;

/// Differences of steps that have no derivative, as a part of an unknown's size, and the least size: rounding of a step, 1e-12, over it.
const DIFFERENCE: f64 = 1e-6;
const LEAST_SIZE: f64 = 0.1;

/// Sums over the samples of a recording.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pub objective: f64,
    pub squares: f64,
    pub samples: usize,
    /// Samples, or recordings where these count the same.
    pub count: f64,
    /// `Σ Jᵀ r` and `Σ Jᵀ J`, weighted; empty without slopes.
    pub gradient: Vec<f64>,
    pub curvature: Vec<f64>,
    /// Steps, and those without a derivative.
    pub steps: [usize; 2],
}

impl Sums {
    pub fn new(unknowns: usize) -> Self {
        Self { gradient: vec![0.0; unknowns], curvature: vec![0.0; unknowns * unknowns], ..Self::default() }
    }

    /// Adds the sums of a recording that counts so many times.
    pub fn add(&mut self, other: &Self, times: usize) {
        let weight = times as f64;
        self.objective += weight * other.objective;
        self.squares += weight * other.squares;
        self.samples += times * other.samples;
        self.count += weight * other.count;
        add_scaled(&mut self.gradient, weight, &other.gradient);
        add_scaled(&mut self.curvature, weight, &other.curvature);
        (0..2).for_each(|k| self.steps[k] += times * other.steps[k]);
    }
}

/// A model with the values of the unknowns, and what its rollouts need.
pub(super) struct Rollouts<'a> {
    task: Task<'a>,
    model: Model,
    settings: Settings,
    workspace: Workspace,
    /// For slopes: of each unknown the sizes of its differences.
    slopes: Option<Slopes>,
}

struct Slopes {
    derivatives: StepDerivatives,
    /// Models with an unknown moved ahead and behind by its differences.
    moved: Vec<[Moved; 2]>,
    /// `∂(q, v)` by each unknown, a row of `[2 nv]` each.
    rows: Vec<Vec<f64>>,
}

/// A model with an unknown moved by a difference, which is 0 where there is no such model on that side.
struct Moved {
    by: f64,
    model: Model,
    workspace: Workspace,
}

impl<'a> Rollouts<'a> {
    pub fn new(task: Task<'a>, model: Model, values: &[f64], with_slopes: bool) -> Result<Self, SimulationError> {
        let settings = task.settings.clone().with_timestep(Some(task.asked.interval / task.asked.substeps as f64));
        let workspace = Workspace::new(&model, &settings)?;
        let slopes = with_slopes.then(|| -> Result<Slopes, SimulationError> {
            let directions = task.unknowns.iter().map(super::Unknown::unit).collect();
            let mut moved = Vec::new();
            for (unknown, value) in task.unknowns.iter().zip(values) {
                let h = DIFFERENCE * value.abs().max(LEAST_SIZE);
                let side = |by: f64| -> Result<Moved, SimulationError> {
                    let [lower, upper] = unknown.bounds;
                    let mut own = model.clone();
                    let end = (value + by).clamp(lower, upper);
                    unknown.set(&mut own, end);
                    let (by, model) =
                        if own.check_numbers().is_ok() { (end - value, own) } else { (0.0, model.clone()) };
                    let workspace = Workspace::new(&model, &settings)?;
                    Ok(Moved { by, model, workspace })
                };
                moved.push([side(h)?, side(-h)?]);
            }
            let rows = vec![vec![0.0; 2 * model.nv]; task.unknowns.len()];
            Ok(Slopes { derivatives: StepDerivatives::with_parameters(&model, directions), moved, rows })
        });
        let slopes = slopes.transpose()?;
        Ok(Self { task, model, settings, workspace, slopes })
    }

    /// Simulates all windows of a recording.
    pub fn run(&mut self, recording: &Recording) -> Result<Sums, SimulationError> {
        let count = if self.slopes.is_some() { self.task.unknowns.len() } else { 0 };
        let mut sums = Sums::new(count);
        let window = if self.task.asked.window == 0 { usize::MAX } else { self.task.asked.window };
        let still = Input::default();
        let mut state = State::new(&self.model);
        for k in 0..recording.states.len().saturating_sub(1) {
            if k % window == 0 {
                state = recording.states[k].clone();
                self.workspace.clear_warm_start();
                if let Some(slopes) = &mut self.slopes {
                    slopes.rows.iter_mut().for_each(|row| row.fill(0.0));
                }
            }
            let input = recording.inputs.get(k).unwrap_or(&still);
            for _ in 0..self.task.asked.substeps {
                if !self.step(&mut state, input, &mut sums)? {
                    // Without a solution nothing is known of the rest: it stays where it is.
                    break;
                }
            }
            self.compare(&state, &recording.states[k + 1], &mut sums);
        }
        sums.count = sums.samples as f64;
        if self.task.asked.equal_recordings && sums.samples > 0 {
            let share = 1.0 / sums.count;
            sums.objective *= share;
            sums.squares *= share;
            sums.gradient.iter_mut().chain(&mut sums.curvature).for_each(|x| *x *= share);
            sums.count = 1.0;
        }
        Ok(sums)
    }

    /// One step with its slopes; `false` where it has no solution.
    fn step(&mut self, state: &mut State, input: &Input, sums: &mut Sums) -> Result<bool, SimulationError> {
        let mut next = state.clone();
        let report = step(&self.model, state, input, &self.settings, &mut self.workspace, &mut next)?;
        if !report.advanced() {
            return Ok(false);
        }
        if let Some(slopes) = &mut self.slopes {
            sums.steps[0] += 1;
            let derivatives = &mut slopes.derivatives;
            derivatives.compute(&self.model, (state, input), &self.settings, &report, &mut self.workspace);
            match (derivatives.parameter_matrix(), self.model.nv) {
                (Ok(by_parameter), nv) => {
                    let mut change = vec![0.0; 3 * nv + self.model.actuators.len()];
                    for (j, row) in slopes.rows.iter_mut().enumerate() {
                        change[..2 * nv].copy_from_slice(row);
                        let Some(moved) = derivatives.product(&change) else { continue };
                        for (r, (row, moved)) in row.iter_mut().zip(moved).enumerate() {
                            *row = moved + by_parameter[(r, j)];
                        }
                    }
                }
                (Err(_), _) => {
                    sums.steps[1] += 1;
                    slopes.differences(&self.settings, (state, input), &next)?;
                }
            }
        }
        *state = next;
        Ok(true)
    }

    /// Adds the difference of a sample.
    fn compare(&self, state: &State, recorded: &State, sums: &mut Sums) {
        let (nv, asked) = (self.model.nv, self.task.asked);
        let mut off = vec![0.0; nv];
        difference_into(&self.model, &state.q, &recorded.q, &mut off);
        let weight = |k: usize| asked.weights.get(k).copied().unwrap_or(1.0);
        sums.samples += 1;
        let slopes = self.slopes.as_ref().map(|slopes| &slopes.rows[..]).unwrap_or_default();
        let columns: Vec<Vec<f64>> = slopes.iter().map(|row| slope_of(&self.model, &off, &row[..nv])).collect();
        let n = columns.len();
        for part in parts(&self.model) {
            let square: f64 = part.clone().map(|k| (weight(k) * off[k]).powi(2)).sum();
            sums.squares += square;
            // ρ = d² (√(1 + r²/d²) − 1): half the square where it is small, the size where it is large.
            let share = if asked.outlier > 0.0 {
                let root = (1.0 + square / asked.outlier.powi(2)).sqrt();
                sums.objective += asked.outlier.powi(2) * (root - 1.0);
                1.0 / root
            } else {
                sums.objective += 0.5 * square;
                1.0
            };
            let product = |a: &[f64], b: &[f64]| part.clone().map(|k| weight(k).powi(2) * a[k] * b[k]).sum::<f64>();
            for (i, column) in columns.iter().enumerate() {
                sums.gradient[i] += share * product(column, &off);
                for (j, other) in columns.iter().enumerate() {
                    sums.curvature[i * n + j] += share * product(column, other);
                }
            }
        }
    }
}

/// Translations and rotations of joints: what counts by its length.
fn parts(model: &Model) -> impl Iterator<Item = Range<usize>> {
    model.joints.iter().flat_map(|joint| {
        let (first, end) = (joint.v_index, joint.v_index + joint.kind.nv());
        let middle = if joint.kind == JointKind::Free { first + 3 } else { end };
        [first..middle, middle..end].into_iter().filter(|part| !part.is_empty())
    })
}

impl Slopes {
    /// Slopes by differences of a step, where it has no derivative.
    fn differences(
        &mut self,
        settings: &Settings,
        (state, input): (&State, &Input),
        next: &State,
    ) -> Result<(), SimulationError> {
        for (sides, row) in self.moved.iter_mut().zip(&mut self.rows) {
            let way = sides[0].by - sides[1].by;
            if way == 0.0 {
                continue;
            }
            let mut ends = [Vec::new(), Vec::new()];
            for (Moved { by, model, workspace }, end) in sides.iter_mut().zip(&mut ends) {
                let nv = model.nv;
                let mut begin = state.clone();
                integrate_into(model, &state.q, &row[..nv], *by, &mut begin.q);
                add_scaled(&mut begin.v, *by, &row[nv..]);
                let mut after = begin.clone();
                workspace.clear_warm_start();
                step(model, &begin, input, settings, workspace, &mut after)?;
                end.resize(nv, 0.0);
                difference_into(model, &after.q, &next.q, end);
                end.extend(&after.v);
            }
            let [ahead, behind] = &ends;
            row.iter_mut().zip(ahead.iter().zip(behind)).for_each(|(x, (a, b))| *x = (a - b) / way);
        }
        Ok(())
    }
}

/// How a difference of configurations changes with that of the first one.
fn slope_of(model: &Model, off: &[f64], change: &[f64]) -> Vec<f64> {
    let mut out = change.to_vec();
    for joint in &model.joints {
        let first = match joint.kind {
            JointKind::Free => joint.v_index + 3,
            JointKind::Ball => joint.v_index,
            JointKind::Hinge { .. } | JointKind::Slide { .. } => continue,
        };
        let turn = right_jacobian(DVec3::from_slice(&off[first..])).inverse() * DVec3::from_slice(&change[first..]);
        out[first..first + 3].copy_from_slice(&turn.to_array());
    }
    out
}
