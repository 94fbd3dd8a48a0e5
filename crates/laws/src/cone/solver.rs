//! The solver for the circular cone: Newton's method from start after start.

use super::ConeSettings;
use super::impulse_system::ImpulseSystem;
use super::newton::Newton;
use super::refine::{DirectionRefiner, RefinementReport, align_directions};
use super::sweeps::Sweeps;
use super::velocity_system::{Memory, VelocitySystem};
use signorini_contact::certificate::{Scratch, certify_afresh};
use signorini_contact::circular::CoulombLaw;
use signorini_contact::circular::certify_cone_with;
use signorini_contact::problem_file::FrictionalProblem;
use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{Certificate, ConeReport, ConeSolution, ConeStart, ConeStatus, ConeWarmStart};
use signorini_contact::{ContactProblem, ContactSolution, ProblemError, SolveStatus, WarmStart};
use signorini_solver::{ContactSolver, SolverSettings};

/// Residual at which a start counts as successful, relative to the tolerance: the certificate judges the rest.
const ACCEPT: f64 = 0.1;

/// Solves contact problems with the circular cone (formulation §9) to the tolerance of a nonlinear complementarity problem.
///
/// Semismooth Newton steps on the proximal form, started from, in this order: the caller's impulses; the exact solution with the
/// problem's own polygons; polygons refined into the slip; block Gauss–Seidel sweeps in turns with Newton's method. The
/// status is decided by the [certificate](signorini_contact::certify_cone) of the result.
#[derive(Debug)]
pub struct CircularConeSolver {
    settings: ConeSettings,
    polygon: ContactSolver,
    polygon_solution: ContactSolution,
    refiner: DirectionRefiner,
    laws: Vec<CoulombLaw>,
    memory: Memory,
    newton: Newton,
    sweeps: Sweeps,
    candidate: ConeSolution,
    scratch: Scratch,
    cones: Cones,
}

/// What polygons are polished to, and the cone where its own polish is not enough for the certificate, in which the dissipation law
/// multiplies by impulses: where these are large against the masses they move, Newton's method ends as exactly as it begins.
const POLYGON_POLISH: f64 = 1e-13;

impl Default for CircularConeSolver {
    fn default() -> Self {
        let polygon = SolverSettings::default().with_polish(POLYGON_POLISH);
        Self {
            settings: ConeSettings::default(),
            polygon: ContactSolver::new(polygon).unwrap_or_default(),
            polygon_solution: ContactSolution::default(),
            refiner: DirectionRefiner::default(),
            laws: Vec::new(),
            memory: Memory::default(),
            newton: Newton::default(),
            sweeps: Sweeps::default(),
            candidate: ConeSolution::default(),
            scratch: Scratch::default(),
            cones: Cones::default(),
        }
    }
}

impl CircularConeSolver {
    /// A solver with these settings. `polygon`: solves the problems with polygons that Newton's method starts from.
    ///
    /// # Errors
    /// [`ProblemError::Number`] for a setting out of its range.
    pub fn new(settings: ConeSettings, polygon: ContactSolver) -> Result<Self, ProblemError> {
        settings.validate()?;
        Ok(Self { settings, polygon, ..Self::default() })
    }

    /// The settings.
    pub fn settings(&self) -> &ConeSettings {
        &self.settings
    }

    /// Solves a problem into `solution`, whose memory is reused. No allocation after warm-up where the warm start leads to
    /// the solution.
    ///
    /// Friction that the circular cone has no law for is refused ([`ConeStatus::Unsupported`]).
    ///
    /// - `warm`: the start, if it has one entry per contact
    pub fn solve_into(&mut self, problem: &ContactProblem, warm: Option<&ConeWarmStart>, solution: &mut ConeSolution) {
        if let Err(unsupported) = problem.check_circular() {
            solution.refuse(problem, unsupported);
            return;
        }
        self.laws.clear();
        self.laws.extend((0..problem.contact_count()).map(|i| CoulombLaw::of(problem, i)));
        self.laws.extend((0..problem.friction_groups.len()).map(|j| CoulombLaw::of_group(problem, j)));
        solution.report = ConeReport::default();
        solution.certificate.momentum = f64::INFINITY;
        if let Some(warm) = warm.filter(|warm| warm.fits(problem)) {
            self.newton.begin_at(&warm.impulse, &warm.group_impulse);
            if self.run_newton(problem, ConeStart::Warm, &warm.bilateral, solution) {
                return;
            }
        }
        let polygon_status = self.start_from_polygon(problem, solution);
        let Err(polygon_status) = polygon_status else { return };
        let denied = matches!(polygon_status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        // Where the polygon has no solution the circle, a little larger, rarely has one.
        let rounds = if denied { 1 } else { self.settings.sweep_rounds };
        if !denied && self.start_from_refinement(problem, solution) || self.start_from_sweeps(problem, rounds, solution)
        {
            return;
        }
        solution.status = if denied { ConeStatus::Denied(polygon_status) } else { ConeStatus::Inaccurate };
        if solution.certificate.worst() > 1.0 {
            self.drop_impulses(problem, solution);
        }
    }

    /// Solves a problem; see [`solve_into`](Self::solve_into).
    pub fn solve(&mut self, problem: &ContactProblem, warm: Option<&ConeWarmStart>) -> ConeSolution {
        let mut solution = ConeSolution::default();
        self.solve_into(problem, warm, &mut solution);
        solution
    }

    /// Newton's method from the polygon's solution; its status where that is not enough.
    fn start_from_polygon(&mut self, problem: &ContactProblem, solution: &mut ConeSolution) -> Result<(), SolveStatus> {
        self.polygon.solve_into(problem, None, &mut self.polygon_solution);
        solution.report.polygon_solves += 1;
        solution.report.stages.add(&self.polygon_solution.report.stages);
        self.newton.begin_at(&self.polygon_solution.impulse, &self.polygon_solution.group_impulse);
        let bilateral = std::mem::take(&mut self.polygon_solution.bilateral);
        let solved = self.run_newton(problem, ConeStart::Polygon, &bilateral, solution);
        self.polygon_solution.bilateral = bilateral;
        if solved { Ok(()) } else { Err(self.polygon_solution.status.clone()) }
    }

    /// Newton's method from the solution with refined directions.
    fn start_from_refinement(&mut self, problem: &ContactProblem, solution: &mut ConeSolution) -> bool {
        if self.settings.refinement_rounds == 0 {
            return false;
        }
        let mut refined = problem.clone();
        let report = self.refiner.refine(
            &mut self.polygon,
            &mut refined,
            None,
            ACCEPT * self.settings.tolerance,
            self.settings.refinement_rounds,
            &mut self.polygon_solution,
        );
        solution.report.polygon_solves += report.solves;
        solution.report.stages.add(&report.stages);
        self.newton.begin_at(&self.polygon_solution.impulse, &self.polygon_solution.group_impulse);
        let bilateral = std::mem::take(&mut self.polygon_solution.bilateral);
        let solved = self.run_newton(problem, ConeStart::Refinement, &bilateral, solution);
        self.polygon_solution.bilateral = bilateral;
        solved
    }

    /// Sweeps and Newton's method in turns, from the best point so far.
    fn start_from_sweeps(&mut self, problem: &ContactProblem, rounds: u32, solution: &mut ConeSolution) -> bool {
        for _ in 0..rounds {
            self.newton.begin_at(&solution.impulse, &solution.group_impulse);
            let bilateral = solution.bilateral.clone();
            let mut system = VelocitySystem::new(problem, &bilateral, &mut self.memory);
            let (most, tolerance) = (self.settings.sweeps, self.settings.polish);
            let sweeps = self.sweeps.run(&mut system, &self.laws, &mut self.newton.impulse, most, tolerance);
            solution.report.sweeps += sweeps;
            let bilateral = self.memory.bilateral.clone();
            if self.run_newton(problem, ConeStart::Sweeps, &bilateral, solution) {
                return true;
            }
        }
        false
    }

    /// No impulses at all have the residual 1: what is worse is of no use to anyone.
    fn drop_impulses(&mut self, problem: &ContactProblem, solution: &mut ConeSolution) {
        solution.velocity.clone_from(&problem.free_velocity);
        solution.impulse.fill([0.0; 3]);
        solution.group_impulse.fill([0.0; 2]);
        solution.bilateral.fill(0.0);
        solution.certificate = certify_cone_with(problem, solution, &mut self.scratch);
    }

    /// Runs Newton's method from `newton.impulse`, certifies what it finds and keeps it in `solution` if it is better.
    /// Whether the problem is solved.
    fn run_newton(
        &mut self,
        problem: &ContactProblem,
        start: ConeStart,
        bilateral: &[f64],
        solution: &mut ConeSolution,
    ) -> bool {
        let Self { settings, laws, memory, newton, candidate, scratch, .. } = self;
        newton.effort = Default::default();
        let mut system = VelocitySystem::new(problem, bilateral, memory);
        let polished = newton.run(&mut system, laws, settings) <= settings.polish;
        take_candidate(problem, &mut system, laws, newton, candidate, scratch);
        if polished && !candidate.certificate.holds(settings.tolerance) {
            newton.run(&mut system, laws, &settings.clone().with_polish(POLYGON_POLISH));
            take_candidate(problem, &mut system, laws, newton, candidate, scratch);
        }
        if !candidate.certificate.holds(settings.tolerance) && newton.correct(&mut system, laws, settings) {
            correct_velocity(problem, &system, candidate, scratch);
        }
        let report = &mut solution.report;
        report.starts += 1;
        report.proximal_iterations += newton.effort.proximal_iterations;
        report.newton_iterations += newton.effort.newton_iterations;
        report.factorizations += newton.effort.factorizations;
        report.start = Some(start);
        if candidate.certificate.worst() < solution.certificate.worst() || !solution.fits(problem) {
            solution.velocity.clone_from(&candidate.velocity);
            solution.impulse.clone_from(&candidate.impulse);
            solution.group_impulse.clone_from(&candidate.group_impulse);
            solution.bilateral.clone_from(&candidate.bilateral);
            solution.certificate = candidate.certificate;
        }
        let solved = solution.certificate.holds(settings.tolerance);
        solution.status = if solved { ConeStatus::Solved } else { ConeStatus::Inaccurate };
        solved
    }

    /// Solves a problem and refines its directions until the polygon's solution satisfies the circular cone's laws within
    /// `tolerance`: by [`DirectionRefiner`] and, where that takes too many LCPs, by [`align_directions`] with the solution of
    /// the nonlinear problem. `problem` is left with the directions of the last LCP, `solution` with its solution.
    ///
    /// - `warm`: start of the first LCP
    pub fn refine_into(
        &mut self,
        problem: &mut ContactProblem,
        warm: Option<&WarmStart>,
        tolerance: f64,
        solution: &mut ContactSolution,
    ) -> RefinementReport {
        let rounds = self.settings.refinement_rounds;
        let mut report = self.refiner.refine(&mut self.polygon, problem, warm, tolerance, rounds, solution);
        if report.converged || report.unsupported.is_some() {
            return report;
        }
        let mut start = ConeWarmStart::default();
        solution.impulse.iter().for_each(|p| start.push(*p));
        solution.group_impulse.iter().for_each(|p| start.push_group(*p));
        start.set_bilateral(&solution.bilateral);
        let cone = self.solve(problem, Some(&start));
        report.stages.add(&cone.report.stages);
        if cone.status != ConeStatus::Solved {
            return report;
        }
        align_directions(problem, &cone);
        solution.impulse.clone_from(&cone.impulse);
        solution.group_impulse.clone_from(&cone.group_impulse);
        solution.bilateral.clone_from(&cone.bilateral);
        let aligned = WarmStart::from_solution(solution);
        let last = self.refiner.refine(&mut self.polygon, problem, Some(&aligned), tolerance, 1, solution);
        report.solves += last.solves;
        report.stages.add(&last.stages);
        RefinementReport { solves: report.solves, stages: report.stages, ..last }
    }

    /// Writes a solution with the circular cone as the polygon's solution that it is once the directions are
    /// [aligned](align_directions) with its friction: `problem` gets these directions, `out` velocity, impulses, `α`, `β`, modes and the
    /// ordinary [certificate](signorini_contact::certify). Status and report stay for the caller to fill in. No allocation after warm-up.
    pub fn express_into(&mut self, problem: &mut ContactProblem, cone: &ConeSolution, out: &mut ContactSolution) {
        self.refiner.align(problem, cone);
        self.cones.prepare(problem);
        out.prepare(problem);
        out.velocity.clone_from(&cone.velocity);
        out.impulse.clone_from(&cone.impulse);
        out.bilateral.clone_from(&cone.bilateral);
        out.group_impulse.clone_from(&cone.group_impulse);
        let (contact_modes, group_modes) = out.solver_modes.split_at_mut(cone.impulse.len());
        for (i, mode) in contact_modes.iter_mut().enumerate() {
            *mode = self.cones.mode_at(i, cone.impulse[i]);
        }
        for (j, mode) in group_modes.iter_mut().enumerate() {
            let (i, [a, b]) = (cone.impulse.len() + j, cone.group_impulse[j]);
            // The first component times the group's coefficient is its bound.
            let bound = problem.friction_groups.bound[j].at(|contact| cone.impulse[contact][0]);
            let first = if self.cones.friction(i) > 0.0 { bound / self.cones.friction(i) } else { 0.0 };
            *mode = self.cones.mode_at(i, [first, a, b]);
        }
        recover_into(problem, &self.cones, problem.velocity_scale(), out);
        out.certificate = certify_afresh(problem, out, &mut self.scratch);
    }

    /// [`certify_cone`](signorini_contact::certify_cone) for the velocity and impulses of a polygon's solution, with memory that is kept.
    pub fn certify(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Certificate {
        self.refiner.certify(problem, solution)
    }

    /// Solves a problem in impulse space, `u = W λ + q`, to the same tolerance.
    ///
    /// Newton's method from zero impulses, then in turns with sweeps.
    pub fn solve_frictional(&mut self, problem: &FrictionalProblem) -> ConeSolution {
        let Self { settings, laws, newton, sweeps, .. } = self;
        laws.clear();
        laws.extend(problem.friction.iter().map(|mu| CoulombLaw::in_dimension(*mu, problem.dimension)));
        let mut solution = ConeSolution::default();
        let mut system = ImpulseSystem::new(problem);
        newton.effort = Default::default();
        newton.impulse.clear();
        newton.impulse.resize(laws.len(), [0.0; 3]);
        solution.impulse.clone_from(&newton.impulse);
        let mut best = f64::INFINITY;
        for round in 0..=settings.sweep_rounds {
            solution.report.starts += 1;
            solution.report.start = Some(if round == 0 { ConeStart::Zero } else { ConeStart::Sweeps });
            if round > 0 {
                solution.report.sweeps +=
                    sweeps.run(&mut system, laws, &mut newton.impulse, settings.sweeps, settings.polish);
            }
            let residual = newton.run(&mut system, laws, settings);
            if residual < best {
                best = residual;
                solution.impulse.clone_from(&newton.impulse);
            }
            if best <= ACCEPT * settings.tolerance {
                break;
            }
            newton.impulse.clone_from(&solution.impulse);
        }
        solution.report.proximal_iterations = newton.effort.proximal_iterations;
        solution.report.newton_iterations = newton.effort.newton_iterations;
        solution.report.factorizations = newton.effort.factorizations;
        solution.certificate = problem.certify_cone(&solution.impulse);
        let solved = solution.certificate.holds(settings.tolerance);
        solution.status = if solved { ConeStatus::Solved } else { ConeStatus::Inaccurate };
        solution
    }
}

/// Adds the last Newton step's change of the velocity where this certifies better: where impulses are large against the
/// masses they move, `v^f + M⁻¹Jᵀλ` cancels, while the step satisfies the contact rows to rounding.
fn correct_velocity(
    problem: &ContactProblem,
    system: &VelocitySystem,
    candidate: &mut ConeSolution,
    scratch: &mut Scratch,
) {
    let before = candidate.certificate;
    candidate.velocity.iter_mut().zip(system.change()).for_each(|(v, d)| *v += d);
    candidate.certificate = certify_cone_with(problem, candidate, scratch);
    if candidate.certificate.worst() >= before.worst() {
        candidate.velocity.iter_mut().zip(system.velocity()).for_each(|(v, x)| *v = *x);
        candidate.certificate = before;
    }
}

/// The best impulses of Newton's method with their velocities, and what is left of them to rounding.
fn take_candidate(
    problem: &ContactProblem,
    system: &mut VelocitySystem,
    laws: &[CoulombLaw],
    newton: &mut Newton,
    candidate: &mut ConeSolution,
    scratch: &mut Scratch,
) {
    let (contacts, groups) = newton.impulse.split_at(problem.contact_count());
    candidate.impulse.clear();
    candidate.impulse.extend_from_slice(contacts);
    candidate.group_impulse.clear();
    candidate.group_impulse.extend(groups.iter().map(|[_, a, b]| [*a, *b]));
    newton.residual(system, laws);
    candidate.velocity.clone_from(system.velocity());
    candidate.bilateral.clone_from(system.bilateral());
    candidate.certificate = certify_cone_with(problem, candidate, scratch);
}
