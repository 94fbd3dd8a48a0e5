//! The part of a step's impulses that corrects penetrations and violated constraints (formulation §5).

use signorini_contact::{ContactProblem, ContactSolution, WarmStart};
use signorini_solver::Patience;

use crate::SimulationError;
use crate::build::is_impact;
use crate::settings::Settings;
use crate::solver::StepSolver;
use crate::source::FrictionSource;
use crate::workspace::Workspace;

/// Corrections slower than this part of the velocity scale are rounding.
const ROUNDING: f64 = 1e-9;

/// A solved step and the same step without its stabilization, from which the part follows when somebody asks.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StabilizedStep {
    without: ContactProblem,
    solution: ContactSolution,
    /// The friction group of each contact that stands on a moving surface.
    belts: Vec<Option<usize>>,
}

impl Workspace {
    /// The last step, if it corrects anything that is more than rounding: a penetration φ < 0 of a contact that is no impact, or
    /// a violation Θ of an equality constraint.
    pub fn stabilized_step(&self) -> Option<StabilizedStep> {
        let problem = self.problem();
        let negligible = ROUNDING * problem.timestep * problem.velocity_scale();
        let impact = |i: usize| is_impact(&self.builder.impacts, i);
        let penetrates = |i: &usize| problem.gap[*i] < 0.0 && !impact(*i);
        let constraints = self.builder.bilateral_source.len();
        let corrected = (0..problem.contact_count()).filter(penetrates).any(|i| -problem.gap[i] > negligible)
            || problem.bilateral_violation[..constraints].iter().any(|theta| theta.abs() > negligible);
        if !corrected {
            return None;
        }
        let mut without = problem.clone();
        (0..problem.contact_count()).filter(penetrates).for_each(|i| without.gap[i] = 0.0);
        without.bilateral_violation[..constraints].fill(0.0);
        let belt = |contact| self.rows().friction_source.iter().position(|s| *s == FrictionSource::Belt { contact });
        let belts = (0..problem.contact_count()).map(belt).collect();
        Some(StabilizedStep { without, solution: self.solution().clone(), belts })
    }
}

impl StabilizedStep {
    /// The impulses (normal, tangent 1, tangent 2) of all contacts, limits included, less those of the same step with
    /// penetrations and violations taken as zero, N·s. One more problem is solved for it.
    ///
    /// With Poisson's law of restitution it is that of the compression. Where impulses are indeterminate, only sums of it over
    /// contacts mean something, as of the impulses themselves.
    ///
    /// # Errors
    /// [`SimulationError::Problem`] as for the step itself.
    pub fn impulses(&self, settings: &Settings) -> Result<Vec<[f64; 3]>, SimulationError> {
        let (mut problem, mut other) = (self.without.clone(), ContactSolution::default());
        let start = WarmStart::from_solution(&self.solution);
        StepSolver::new(settings, false)?.solve_into(&mut problem, Some(&start), Patience::Full, &mut other)?;
        let count = self.solution.impulse.len();
        let sum = |solution: &ContactSolution, i: usize| {
            let [n, t_1, t_2] = solution.impulse[i];
            let [belt_1, belt_2] = self.belts[i].map_or([0.0; 2], |j| solution.group_impulse[j]);
            [n, t_1 + belt_1, t_2 + belt_2]
        };
        let parts = (0..count).map(|i| {
            let (with, without) = (sum(&self.solution, i), sum(&other, i));
            [0, 1, 2].map(|k| with[k] - without[k])
        });
        Ok(parts.collect())
    }
}
