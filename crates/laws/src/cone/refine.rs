//! Direction refinement: the circular cone reached by polygons whose vertices are turned into the slip.
//!
//! A contact that slides at a vertex `d` of its polygon has Coulomb's friction `μ λ_N d` for a slip along `−d`. Each round
//! solves the LCP, looks where every sliding contact slips, and gives it a vertex at the direction in which friction and slip
//! are expected to meet, with two neighbours that enclose it. The set stays balanced, the problem an LCP of formulation §3 that
//! the ordinary [`certify`](signorini_contact::certify) judges.

use signorini_contact::SolveStatus::{Inaccurate, Solved};
use signorini_contact::certificate::Scratch;
use signorini_contact::circular::{CoulombLaw, certify_cone_with, cone_velocity_scale, half_widest_angle};
use signorini_contact::{
    Certificate, ConeSolution, ContactProblem, ContactSolution, StageCounts, UnsupportedFriction, WarmStart,
};
use signorini_solver::ContactSolver;

/// Directions nearer than this to one another, rad, are one: below it a set of unit vectors could not be told from one with
/// a direction given twice.
const NEAREST: f64 = 1e-5;
/// A contact keeps its directions where its own residual is below this part of the tolerance.
const GOOD: f64 = 0.1;
/// The neighbours of a new vertex lie this part of the angle between friction and slip away from it.
const BRACKET: f64 = 0.5;

/// Contacts slower than this fraction of the data's velocity scale stick.
const STICKING: f64 = 1e-12;

/// How a refinement ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RefinementReport {
    /// LCPs that were solved.
    pub solves: u32,
    /// What the structured solver's stages did for them.
    pub stages: StageCounts,
    /// Residuals of the circular-cone laws at the end.
    pub certificate: Certificate,
    /// Whether they are all within the tolerance, with the last LCP solved.
    pub converged: bool,
    /// Friction of the problem that the circular cone has no law for; then no LCP was solved.
    pub unsupported: Option<UnsupportedFriction>,
}

/// Refines friction polygons; the memory is kept from problem to problem.
#[derive(Clone, Debug, Default)]
pub struct DirectionRefiner {
    base: Directions,
    group_base: Directions,
    turned: Directions,
    warm: WarmStart,
    cone: ConeSolution,
    scratch: Scratch,
    column: Vec<f64>,
}

impl DirectionRefiner {
    /// Solves a problem, and again with its directions turned into the slip, until the circular-cone laws hold within
    /// `tolerance` or `max_solves` LCPs are solved. `problem` is left with the directions of the last LCP, `solution` with its
    /// solution, so that anyone can certify the one against the other.
    ///
    /// - `tolerance`: bound on the worst residual of the [`Certificate`]
    /// - `warm`: start of the first LCP
    ///
    /// Contacts without directions or with two (contacts in the plane) keep them: their cone has no other. Friction that the
    /// circular cone has no law for is refused ([`RefinementReport::unsupported`]).
    pub fn refine(
        &mut self,
        solver: &mut ContactSolver,
        problem: &mut ContactProblem,
        warm: Option<&WarmStart>,
        tolerance: f64,
        max_solves: u32,
        solution: &mut ContactSolution,
    ) -> RefinementReport {
        if let Err(unsupported) = problem.check_circular() {
            solution.prepare(problem);
            (solution.status, solution.certificate) = (Inaccurate, Certificate::everything_violated());
            let certificate = Certificate::everything_violated();
            return RefinementReport { unsupported: Some(unsupported), certificate, ..RefinementReport::default() };
        }
        self.base.copy(&problem.directions, &problem.direction_offsets);
        let groups = &problem.friction_groups;
        self.group_base.copy(&groups.directions, &groups.direction_offsets);
        let mut report = RefinementReport::default();
        for solve in 1..=max_solves.max(1) {
            if solve == 1 {
                solver.solve_into(problem, warm, solution);
            } else {
                self.warm.clear();
                (0..problem.contact_count()).for_each(|i| self.warm.push(solution, Some(i)));
                (0..problem.friction_groups.len()).for_each(|j| self.warm.push_group(solution, Some(j)));
                self.warm.set_bilateral(&solution.bilateral);
                solver.solve_into(problem, Some(&self.warm), solution);
            }
            report.solves = solve;
            report.stages.add(&solution.report.stages);
            report.certificate = self.certify(problem, solution);
            report.converged = solution.status == Solved && report.certificate.holds(tolerance);
            if report.converged || solve == max_solves || !matches!(solution.status, Solved | Inaccurate) {
                break;
            }
            // Directions close together can cost the LCP its accuracy: then the next one does without the neighbours.
            let bracket = if solution.status == Solved { BRACKET } else { 0.0 };
            self.turn_directions(problem, solution, tolerance, bracket);
        }
        report
    }

    /// [`align_directions`] with memory that is kept.
    pub(super) fn align(&mut self, problem: &mut ContactProblem, solution: &ConeSolution) {
        if !solution.fits(problem) {
            return;
        }
        let slow = STICKING * cone_velocity_scale(problem);
        let turned = &mut self.turned;
        turned.clear();
        for i in 0..problem.contact_count() {
            let [_, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
            let [n, t_1, t_2] = solution.impulse[i];
            let law = CoulombLaw::of(problem, i);
            let slides = c_1.hypot(c_2) > slow;
            turned.push_aligned(problem.directions_of(i), law.is_circular(), law.friction() * n, [t_1, t_2], slides);
        }
        turned.swap(&mut problem.directions, &mut problem.direction_offsets);
        turned.clear();
        let groups = &mut problem.friction_groups;
        for (j, friction) in solution.group_impulse.iter().enumerate() {
            let [s_1, s_2] = groups.slip(j, &solution.velocity);
            let bound = groups.bound[j].at(|contact| solution.impulse[contact][0]);
            turned.push_aligned(
                groups.directions_of(j),
                groups.directions_of(j).len() > 2,
                bound,
                *friction,
                s_1.hypot(s_2) > slow,
            );
        }
        turned.swap(&mut groups.directions, &mut groups.direction_offsets);
    }

    /// The residuals of the circular cone's laws of a polygon's solution.
    pub(super) fn certify(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Certificate {
        self.cone.take_polygon(solution);
        certify_cone_with(problem, &self.cone, &mut self.scratch)
    }

    /// Writes new directions of the contacts and friction groups that slide across theirs.
    fn turn_directions(
        &mut self,
        problem: &mut ContactProblem,
        solution: &ContactSolution,
        tolerance: f64,
        bracket: f64,
    ) {
        self.column.clear();
        self.column.resize(problem.nv(), 0.0);
        let (g, s) = (problem.delassus_scale(), cone_velocity_scale(problem));
        let good = GOOD * tolerance * s;
        self.turned.clear();
        for i in 0..problem.contact_count() {
            let law = CoulombLaw::of(problem, i);
            let mut u = problem.contact_velocity(i, &solution.velocity);
            u[0] += problem.gap[i] / problem.timestep;
            let p = solution.impulse[i];
            if law.natural_map(p, u, g) <= good || at_rest(p, u) || !law.is_circular() {
                self.turned.push(problem.directions_of(i));
            } else {
                let [_, w_1, w_2] = problem.delassus_diagonal(i, &mut self.column);
                let stiffness = law.friction() * p[0] * w_1.max(w_2);
                self.turned.push_turned(self.base.of(i), p, u, stiffness, bracket);
            }
        }
        self.turned.swap(&mut problem.directions, &mut problem.direction_offsets);
        self.turned.clear();
        for j in 0..problem.friction_groups.len() {
            let (law, groups) = (CoulombLaw::of_group(problem, j), &problem.friction_groups);
            let ([s_1, s_2], [f_1, f_2]) = (groups.slip(j, &solution.velocity), solution.group_impulse[j]);
            let (u, p) = ([0.0, s_1, s_2], [0.0, f_1, f_2]);
            let bound = groups.bound_at(j, &solution.lambda_n);
            if law.group_natural_map(p, u, bound, g) <= good || at_rest(p, u) || !law.is_circular() {
                self.turned.push(groups.directions_of(j));
            } else {
                let [w_1, w_2] = problem.group_delassus(j, &mut self.column);
                self.turned.push_turned(self.group_base.of(j), p, u, bound * w_1.max(w_2), bracket);
            }
        }
        let groups = &mut problem.friction_groups;
        self.turned.swap(&mut groups.directions, &mut groups.direction_offsets);
    }
}

/// Without slip or without friction there is no angle between them.
fn at_rest(p: [f64; 3], u: [f64; 3]) -> bool {
    u[1] == 0.0 && u[2] == 0.0 || p[1] == 0.0 && p[2] == 0.0
}

/// The directions of many contacts or friction groups, one after another.
#[derive(Clone, Debug, Default)]
struct Directions {
    directions: Vec<[f64; 2]>,
    offsets: Vec<usize>,
}

impl Directions {
    fn clear(&mut self) {
        self.directions.clear();
        self.offsets.clear();
        self.offsets.push(0);
    }

    fn copy(&mut self, directions: &Vec<[f64; 2]>, offsets: &Vec<usize>) {
        self.directions.clone_from(directions);
        self.offsets.clone_from(offsets);
    }

    /// Exchanges them with those of a problem.
    fn swap(&mut self, directions: &mut Vec<[f64; 2]>, offsets: &mut Vec<usize>) {
        std::mem::swap(&mut self.directions, directions);
        std::mem::swap(&mut self.offsets, offsets);
    }

    fn of(&self, i: usize) -> &[[f64; 2]] {
        &self.directions[self.offsets[i]..self.offsets[i + 1]]
    }

    fn push(&mut self, own: &[[f64; 2]]) {
        self.directions.extend_from_slice(own);
        self.offsets.push(self.directions.len());
    }

    /// The base directions with one where friction and slip are expected to meet.
    fn push_turned(&mut self, base: &[[f64; 2]], p: [f64; 3], u: [f64; 3], stiffness: f64, bracket: f64) {
        let (angle, width) = expected_direction(p, u, stiffness);
        push_directions(base, angle, bracket * width, &mut self.directions);
        self.offsets.push(self.directions.len());
    }

    /// The own directions with one at the friction, where it slides or sticks outside their polygon of radius `bound`.
    fn push_aligned(&mut self, own: &[[f64; 2]], circular: bool, bound: f64, friction: [f64; 2], slides: bool) {
        let size = friction[0].hypot(friction[1]);
        let inside = || size <= bound * half_widest_angle(own).cos();
        if circular && size > 0.0 && (slides || !inside()) {
            push_directions(own, friction[1].atan2(friction[0]), 0.0, &mut self.directions);
            self.offsets.push(self.directions.len());
        } else {
            self.push(own);
        }
    }
}

/// Gives every contact, and every friction group, that slides in a solution with the circular cone, or sticks outside its polygon, a vertex at its
/// friction: the LCP with these directions has that solution among its own, and the ordinary [`certify`](signorini_contact::certify) can judge it. Start it from the
/// solution's impulses or from a [`WarmStart`].
///
/// - `problem`: gets the directions
/// - `solution`: of the same problem, with any directions; one of another size changes nothing
pub fn align_directions(problem: &mut ContactProblem, solution: &ConeSolution) {
    DirectionRefiner::default().align(problem, solution);
}

/// Where friction and slip are expected to meet, rad, and how far apart they are now.
///
/// Friction of size `μ λ_N` that turns by `δ` changes the slip by `μ λ_N w δ` across itself (`w`: the contact's tangential entry
/// of the Delassus operator), and so turns a slip of speed `s` back by `κ δ` with `κ = μ λ_N w / s`. From friction at `θ_f` and
/// slip at `θ_s`, `θ_f + (θ_s − θ_f)/(1 + κ)` is where they meet.
fn expected_direction(p: [f64; 3], u: [f64; 3], stiffness: f64) -> (f64, f64) {
    let friction = p[2].atan2(p[1]);
    // the angle from friction to the opposite of the slip
    let turn = (p[2] * u[1] - p[1] * u[2]).atan2(-(p[1] * u[1] + p[2] * u[2]));
    let kappa = stiffness / u[1].hypot(u[2]);
    (friction + turn / (1.0 + kappa), turn.abs())
}

/// The base directions and, with their opposites, one at `angle` and two `width` beside it. Base directions that nearly
/// coincide with a new one give way to it.
fn push_directions(base: &[[f64; 2]], angle: f64, width: f64, out: &mut Vec<[f64; 2]>) {
    let start = out.len();
    let beside = width >= NEAREST;
    for offset in [0.0, width, -width] {
        if offset == 0.0 || beside {
            let (sin, cos) = (angle + offset).sin_cos();
            out.extend([[cos, sin], [-cos, -sin]]);
        }
        if !beside {
            break;
        }
    }
    let new = start..out.len();
    for d in base {
        let near = |e: &[f64; 2]| (d[0] - e[0]).hypot(d[1] - e[1]) < NEAREST;
        if !out[new.clone()].iter().any(near) {
            out.push(*d);
        }
    }
}
