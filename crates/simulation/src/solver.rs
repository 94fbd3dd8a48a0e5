//! The solver of a step's contact problem: law of friction, method, and choice among the impulses.

use signorini_contact::scales::VelocityScale;
use signorini_contact::{
    Certificate, ConeSolution, ConeStatus, ConeWarmStart, ContactProblem, ContactSolution, ProblemError, SolveReport,
    SolveStatus, WarmStart,
};
use signorini_laws::{CircularConeSolver, ConeSettings, LeastNorm, LeastNormOutcome};
use signorini_lcp::Method;
use signorini_solver::{ContactSolver, Patience, SolverSettings, solve_as_lcp};

use crate::SimulationError;
use crate::settings::{ContactMethod, FrictionLaw, ImpulseChoice, Settings};

/// The friction law that a [`Certificate`] of a step speaks of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CertifiedLaw {
    /// Maximum dissipation over the polygon of the step's problem: [`certify`](signorini_contact::certify).
    #[default]
    Polygon,
    /// Coulomb's law with the circular cone: [`certify_cone`](signorini_contact::certify_cone).
    CircularCone,
}

/// How well the laws hold that the settings ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Verdict {
    pub law: CertifiedLaw,
    /// Residuals of that law.
    pub certificate: Certificate,
    /// Residuals of the circular cone's laws, where the settings ask for them.
    pub cone: Option<Certificate>,
    /// Whether every residual is within its tolerance.
    pub holds: bool,
    /// What became of the impulses of least norm, where the settings ask for them.
    pub least_norm: Option<LeastNormOutcome>,
}

/// Solves contact problems as the settings say.
pub(crate) struct StepSolver {
    route: Route,
    /// Residuals are within their tolerance up to this.
    tolerance: f64,
    /// Sweeps of a step, where they are counted, and what is left of them.
    budget: Option<(u32, u32)>,
    least_norm: Option<Box<LeastNorm>>,
}

/// Further solves of a step, which start close to their solution, have at least one in so many of its sweeps.
const FURTHER_SOLVE: u32 = 4;

enum Route {
    Structured(Box<ContactSolver>),
    Lcp(Box<dyn Method>),
    Circular(Box<Circular>),
    Refined { solver: Box<CircularConeSolver>, tolerance: f64 },
}

/// The solver for the circular cone with what it starts from and ends with.
#[derive(Default)]
struct Circular {
    solver: CircularConeSolver,
    start: ConeWarmStart,
    solution: ConeSolution,
}

impl StepSolver {
    /// The solver for these settings.
    ///
    /// - `sleeping`: whether islands at rest are left alone, as the settings or the model say
    ///
    /// # Errors
    /// [`SimulationError::Problem`] for a solver setting out of its range.
    pub fn new(settings: &Settings, sleeping: bool) -> Result<Self, SimulationError> {
        let mut budget = None;
        let route = match (&settings.friction_law, &settings.method) {
            (FrictionLaw::Polygon, ContactMethod::Structured(solver)) => {
                let solver = solver.clone().with_sleeping(solver.sleeping || sleeping);
                let solver = solver.for_tolerance(settings.tolerance);
                budget = settings.budget.or(solver.budget);
                let solver = solver.with_budget(budget);
                Route::Structured(Box::new(ContactSolver::new(solver)?))
            }
            (FrictionLaw::Polygon, ContactMethod::Lcp(kind)) => Route::Lcp(kind.build().map_err(ProblemError::from)?),
            (FrictionLaw::Circular, _) => Route::Circular(Box::new(Circular {
                solver: cone_solver(settings, settings.tolerance)?,
                ..Circular::default()
            })),
            (&FrictionLaw::Refined { tolerance }, _) => {
                let solver = Box::new(cone_solver(settings, settings.tolerance.min(tolerance))?);
                Route::Refined { solver, tolerance }
            }
        };
        let least_norm = (settings.impulses == ImpulseChoice::LeastNorm).then(Box::default);
        let budget = budget.map(|sweeps| (sweeps, sweeps));
        Ok(Self { route, tolerance: settings.tolerance, budget, least_norm })
    }

    /// Begins a step: its budget is whole.
    pub fn begin_step(&mut self) {
        self.budget = self.budget.map(|(sweeps, _)| (sweeps, sweeps));
    }

    /// Whether sweeps are counted.
    pub fn is_counted(&self) -> bool {
        self.budget.is_some()
    }

    /// The structured solver, where islands are solved apart from each other and to their end.
    pub fn islands_apart(&self) -> Option<&ContactSolver> {
        match &self.route {
            Route::Structured(solver) if self.budget.is_none() && self.least_norm.is_none() => Some(solver),
            _ => None,
        }
    }

    /// Takes scales for those of what is beside the problems to come: see [`ContactSolver::set_beside`].
    pub fn set_beside(&mut self, delassus: f64, velocity: VelocityScale) {
        if let Route::Structured(solver) = &mut self.route {
            solver.set_beside(delassus, velocity);
        }
    }

    /// Whether contacts keep the directions that they were given.
    pub fn keeps_directions(&self) -> bool {
        matches!(self.route, Route::Structured(_) | Route::Lcp(_))
    }

    /// Whether the last solve missed the tolerance by rounding alone, where that is told.
    pub fn is_out_of_digits(&self) -> bool {
        matches!(&self.route, Route::Structured(solver) if solver.is_out_of_digits())
    }

    /// Whether the last solve left contact `i` among others with laws that do not hold, where islands are told apart.
    pub fn contact_lacks(&self, i: usize) -> bool {
        if let Route::Structured(solver) = &self.route { solver.unit_lacks(i) } else { true }
    }

    /// The same of a bilateral row.
    pub fn bilateral_lacks(&self, k: usize) -> bool {
        if let Route::Structured(solver) = &self.route { solver.bilateral_lacks(k) } else { true }
    }

    /// Solves a problem. With the circular cone its contacts get directions with which `solution` is the polygon's solution.
    ///
    /// # Errors
    /// [`ProblemError::Unsupported`] for friction that the law or the choice among impulses does not know.
    pub fn solve_into(
        &mut self,
        problem: &mut ContactProblem,
        start: Option<&WarmStart>,
        patience: Patience,
        solution: &mut ContactSolution,
    ) -> Result<Verdict, SimulationError> {
        match &mut self.route {
            Route::Structured(solver) => {
                if let Some((sweeps, left)) = &mut self.budget {
                    solver.set_budget((*left).max(sweeps.div_ceil(FURTHER_SOLVE)));
                    solver.solve_patiently_into(problem, start, patience, solution);
                    *left = left.saturating_sub(solution.report.sweeps);
                } else {
                    solver.solve_patiently_into(problem, start, patience, solution);
                }
            }
            Route::Lcp(method) => *solution = solve_as_lcp(problem, method.as_mut(), self.tolerance)?,
            Route::Circular(circular) => circular.solve_into(problem, start, solution)?,
            Route::Refined { solver, tolerance } => {
                let report = solver.refine_into(problem, start, *tolerance, solution);
                report.unsupported.map_or(Ok(()), |unsupported| Err(ProblemError::from(unsupported)))?;
                solution.report.stages = report.stages;
            }
        }
        if self.least_norm.is_some() {
            self.choose_impulses(problem, solution)
        } else {
            Ok(self.judge(problem, solution))
        }
    }

    /// Takes the impulses of least norm, unless the law that was asked for does not hold with them as it does without.
    fn choose_impulses(
        &mut self,
        problem: &ContactProblem,
        solution: &mut ContactSolution,
    ) -> Result<Verdict, SimulationError> {
        let before = self.judge(problem, solution);
        let Some(mut least_norm) = self.least_norm.take() else { return Ok(before) };
        let mut outcome = least_norm.apply(problem, solution, self.tolerance).outcome;
        let mut verdict = self.judge(problem, solution);
        if before.holds && !verdict.holds {
            least_norm.undo(problem, solution);
            (verdict, outcome) = (before, LeastNormOutcome::Kept);
        }
        self.least_norm = Some(least_norm);
        if let LeastNormOutcome::Unsupported(unsupported) = outcome {
            return Err(ProblemError::from(unsupported).into());
        }
        Ok(Verdict { least_norm: Some(outcome), ..verdict })
    }

    /// Certifies a solution by the law that was asked for.
    fn judge(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Verdict {
        let polygon = solution.certificate;
        let verdict = Verdict { certificate: polygon, holds: polygon.holds(self.tolerance), ..Verdict::default() };
        match &mut self.route {
            Route::Structured(_) | Route::Lcp(_) => verdict,
            Route::Circular(circular) => {
                let cone = circular.solver.certify(problem, solution);
                let law = CertifiedLaw::CircularCone;
                let holds = cone.holds(self.tolerance);
                Verdict { law, certificate: cone, cone: Some(cone), holds, least_norm: None }
            }
            Route::Refined { solver, tolerance } => {
                let cone = solver.certify(problem, solution);
                Verdict { cone: Some(cone), holds: verdict.holds && cone.holds(*tolerance), ..verdict }
            }
        }
    }
}

impl Circular {
    fn solve_into(
        &mut self,
        problem: &mut ContactProblem,
        start: Option<&WarmStart>,
        out: &mut ContactSolution,
    ) -> Result<(), ProblemError> {
        let Self { solver, start: cone_start, solution } = self;
        let start = start.map(|start| {
            cone_start.take(start);
            &*cone_start
        });
        solver.solve_into(problem, start, solution);
        if let ConeStatus::Unsupported(unsupported) = solution.status {
            return Err(unsupported.into());
        }
        solver.express_into(problem, solution, out);
        out.status = match &solution.status {
            ConeStatus::Solved => SolveStatus::Solved,
            ConeStatus::Denied(status) => status.clone(),
            _ => SolveStatus::Inaccurate,
        };
        let report = &solution.report;
        let done = &mut out.report;
        *done = SolveReport::default();
        (done.factorizations, done.mode_changes) = (report.factorizations, report.newton_iterations);
        done.proximal_iterations = report.proximal_iterations;
        (done.restarts, done.stages) = (report.starts.saturating_sub(1), report.stages);
        Ok(())
    }
}

/// The circular cone's solver for a tolerance; the structured solver of the settings is for the polygons that it starts from.
fn cone_solver(settings: &Settings, tolerance: f64) -> Result<CircularConeSolver, ProblemError> {
    let polygon = match &settings.method {
        ContactMethod::Structured(settings) => settings.clone(),
        ContactMethod::Lcp(_) => SolverSettings::default(),
    };
    let polygon = polygon.for_tolerance(settings.tolerance);
    CircularConeSolver::new(ConeSettings::default().for_tolerance(tolerance), ContactSolver::new(polygon)?)
}
