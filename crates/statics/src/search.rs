//! The search for solutions of both kinds: those that rest and those that move.

use signorini_contact::projection::Mode;
use signorini_contact::statics::{beside_motion, energy_part, without_contact_friction};
use signorini_contact::{ContactProblem, ContactSolution, WarmStart};
use signorini_lcp::Lemke;
use signorini_solver::{ContactSolver, SolverSettings, solve_as_lcp};

use crate::balance::{as_balance, polished};
use crate::interior::{ForceSearch, Forces};
use crate::mechanism::BalanceProgram;
use crate::settings::StabilitySettings;

/// A solution with less than this part of the free motion's energy counts as one at rest that is not known exactly.
const MOVES: f64 = 1e-12;
/// Accuracy of the solves that say whether a start leads to rest, where a balance is known already. Chosen by: 3,000 random worlds, whose verdicts and
/// starts are those of solves to the last digits, 25 November 2026.
const ROUGH: f64 = 1e-6;
/// Such a solve rests with less than this part of the free motion's energy: velocities are ten times those that it leaves open.
const RESTS: f64 = 1e-10;
/// Perturbations of loads, relative to the free velocity.
const PERTURBATION: f64 = 1e-2;
/// Parts of the friction on the way from none to all of it.
const FRICTION_STEPS: u32 = 8;
/// Problems with more contacts are perturbed once: a solve of them takes seconds.
const LARGE: usize = 1000;
/// Rows of LCPs at most that Lemke's method is asked for.
const LEMKE_ROWS: usize = 400;

/// One attempt to find a moving solution.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SearchRun {
    /// Where it started: `cold`, `open`, `more_friction`, `lemke`, `perturbed`; `near` where a moving solution of other loads is known.
    pub start: &'static str,
    /// What it ended with: `rests`, `moves`, or `nothing` where no solution was found.
    pub end: &'static str,
}

/// Solutions of a problem at rest, as far as they are known.
#[derive(Default)]
pub(crate) struct Search {
    solver: ContactSolver,
    /// Asks what a start leads to, to a few digits.
    rough: ContactSolver,
    forces: ForceSearch,
    pub runs: Vec<SearchRun>,
    pub balance: Option<ContactSolution>,
    pub moving: Option<ContactSolution>,
}

impl Search {
    pub fn new() -> Self {
        let settings = SolverSettings::default().for_tolerance(1e-11);
        let solver = ContactSolver::new(settings).unwrap_or_default();
        let rough = ContactSolver::new(SolverSettings::default().for_tolerance(ROUGH)).unwrap_or_default();
        Self { solver, rough, ..Self::default() }
    }

    pub fn solver(&mut self) -> &mut ContactSolver {
        &mut self.solver
    }

    /// Forces or a mechanism by the interior-point method.
    pub fn forces(&mut self, problem: &ContactProblem, settings: &StabilitySettings) -> Forces {
        self.forces.find(problem, settings)
    }

    /// Takes note of what an attempt ended with.
    fn note(
        &mut self,
        problem: &ContactProblem,
        start: &'static str,
        solution: ContactSolution,
        settings: &StabilitySettings,
    ) {
        let end = self.take(problem, solution, settings);
        self.runs.push(SearchRun { start, end });
    }

    /// Keeps a solution of a kind that is not known yet; the kind.
    pub fn take(
        &mut self,
        problem: &ContactProblem,
        solution: ContactSolution,
        settings: &StabilitySettings,
    ) -> &'static str {
        if let Some(balance) = as_balance(problem, &solution, settings) {
            self.balance.get_or_insert(balance);
            return "rests";
        }
        let part = energy_part(problem, &solution.velocity);
        if part > MOVES && beside_motion(solution.certificate.worst(), part) <= settings.tolerance {
            self.moving.get_or_insert(solution);
            return "moves";
        }
        "nothing"
    }

    /// Solves from a start, and takes note of what that ended with. Where a balance is known, a start that leads to rest to a few digits is not followed to the last ones.
    fn try_from(
        &mut self,
        problem: &ContactProblem,
        name: &'static str,
        near: Option<&ContactSolution>,
        settings: &StabilitySettings,
    ) {
        let mut near = near.map(WarmStart::from_solution);
        if self.balance.is_some() {
            let rough = self.rough.solve(problem, near.as_ref());
            if rests(problem, &rough) {
                self.runs.push(SearchRun { start: name, end: "rests" });
                return;
            }
            if rough.certificate.holds(ROUGH) {
                near = Some(WarmStart::from_solution(&rough));
            }
        }
        let solution = self.solver.solve(problem, near.as_ref());
        self.note(problem, name, solution, settings);
    }

    /// What the solver finds from nothing, unless that is known.
    pub fn cold(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        if self.runs.iter().any(|run| run.start == "cold") {
            return;
        }
        self.try_from(problem, "cold", None, settings);
    }

    /// Looks for a moving solution until one is found or every start was tried.
    pub fn for_motion(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        if problem.contact_count() > settings.search_contacts {
            return;
        }
        let starts = [Self::cold, Self::begin_open, Self::with_more_friction, Self::by_lemke, Self::perturb_loads];
        for start in starts {
            if self.moving.is_some() {
                return;
            }
            start(self, problem, settings);
        }
    }

    /// From a moving solution of a nearby problem.
    pub fn start_near(&mut self, problem: &ContactProblem, near: &ContactSolution, settings: &StabilitySettings) {
        self.try_from(problem, "near", Some(near), settings);
    }

    /// The path from all contacts open.
    fn begin_open(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        let mut open = ContactSolution::default();
        open.prepare(problem);
        open.solver_modes.fill(Mode::Open);
        self.try_from(problem, "open", Some(&open), settings);
    }

    /// From the motion without friction, with more and more of it, as far as that moves: what rests with less friction rests with more.
    fn with_more_friction(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        let mut weaker = problem.clone();
        let mut solution: Option<ContactSolution> = None;
        for step in 0..FRICTION_STEPS {
            let part = f64::from(step) / f64::from(FRICTION_STEPS);
            weaker.friction.iter_mut().zip(&problem.friction).for_each(|(mu, full)| *mu = part * full);
            let start = solution.as_ref().map(WarmStart::from_solution);
            let found = self.rough.solve(&weaker, start.as_ref());
            if self.balance.is_some() && rests(&weaker, &found) {
                self.runs.push(SearchRun { start: "more_friction", end: "rests" });
                return;
            }
            solution = Some(found);
        }
        self.try_from(problem, "more_friction", solution.as_ref(), settings);
    }

    /// Lemke's method on the LCP, which follows another path.
    fn by_lemke(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        if problem.standard_layout().size > LEMKE_ROWS {
            return;
        }
        if let Ok(solution) = solve_as_lcp(problem, &mut Lemke::default(), settings.tolerance) {
            self.note(problem, "lemke", solution, settings);
        }
    }

    /// From the solutions of nearby loads, by either method.
    fn perturb_loads(&mut self, problem: &ContactProblem, settings: &StabilitySettings) {
        let mut perturbed = problem.clone();
        let size = problem.free_velocity.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
        let small = problem.standard_layout().size <= LEMKE_ROWS;
        let rounds =
            if problem.contact_count() > LARGE { settings.perturbations.min(1) } else { settings.perturbations };
        for round in 0..rounds {
            for (v, full) in perturbed.free_velocity.iter_mut().zip(&problem.free_velocity) {
                *v = full + PERTURBATION * size * noise.next();
            }
            let by_lemke = (small && round % 2 == 1)
                .then(|| solve_as_lcp(&perturbed, &mut Lemke::default(), settings.tolerance).ok())
                .flatten();
            let near = by_lemke.unwrap_or_else(|| self.rough.solve(&perturbed, None));
            self.try_from(problem, "perturbed", Some(&near), settings);
            if self.moving.is_some() {
                return;
            }
        }
    }

    /// A balance of the problem without the friction of contacts, if there is one: its law is associated, so that its solutions all rest
    /// or none does.
    pub fn balance_without_friction(
        &mut self,
        problem: &ContactProblem,
        settings: &StabilitySettings,
    ) -> Option<ContactSolution> {
        let reduced = without_contact_friction(problem);
        match self.forces.find_proof(&reduced, settings) {
            Forces::Balance(balance) => return Some(*balance),
            Forces::Mechanism(_) => return None,
            Forces::Unknown => {}
        }
        let solution = self.solver.solve(&reduced, None);
        as_balance(&reduced, &solution, settings).or_else(|| {
            // Where a body's weight is right above an edge the solver's last digits are velocities; the program's are forces.
            let answer = BalanceProgram::new(&reduced).solve()?;
            polished(&reduced, &answer.impulses, &mut self.solver, settings)
        })
    }
}

/// Whether a solution to a few digits is one at rest.
fn rests(problem: &ContactProblem, rough: &ContactSolution) -> bool {
    rough.certificate.holds(ROUGH) && energy_part(problem, &rough.velocity) <= RESTS
}

/// Numbers between −1 and 1, the same ones every time (xorshift; G. Marsaglia 2003).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
