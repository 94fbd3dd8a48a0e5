//! Complete enumeration of the modes of a small problem: either a moving solution, or the proof that there is none.
//!
//! A tree over the complementary pairs of the mixed LCP. At a node the undecided pairs are relaxed to `z ≥ 0`, `w ≥ 0`, and a linear program
//! finds the largest power `pᵀv` there. A solution has `pᵀv ≥ vᵀMv`, so that a node whose largest power is zero has no moving solution; else
//! the pair that its point violates most is decided both ways.

use signorini_contact::statics::{ModeBounds, ModeTree, certify_modes};
use signorini_contact::{ContactProblem, ContactSolution, Layout, WarmStart};
use signorini_lcp::MixedLcp;

use crate::conic::ConicProgram;
use crate::impulses::solution_from;
use crate::search::Search;
use crate::settings::StabilitySettings;

/// A node whose largest power is not above this part of the free motion's ends.
const NO_POWER: f64 = 1e-10;
/// A point whose pairs are violated by no more than this is tried as a solution.
const NO_VIOLATION: f64 = 1e-7;

/// What an enumeration ended with.
pub(crate) enum Enumerated {
    /// There is no moving solution.
    None(ModeTree),
    /// The search has one now.
    Moving,
    /// Too many programs, or one that could not be solved well enough.
    Unknown,
}

/// Enumerates; the number of linear programs solved.
pub(crate) fn enumerate(
    problem: &ContactProblem,
    search: &mut Search,
    settings: &StabilitySettings,
) -> (Enumerated, usize) {
    let driven = problem.friction_groups.target.iter().any(|u| *u != [0.0; 2]);
    let at = problem.mixed_layout();
    if driven || at.size - at.normal > settings.enumeration_rows {
        return (Enumerated::Unknown, 0);
    }
    let Ok(lcp) = problem.mixed_lcp() else { return (Enumerated::Unknown, 0) };
    let bounds = ModeBounds::of(problem);
    let mut walk =
        Walk { problem, lcp: &lcp, at, bounds: &bounds, search, settings, tree: ModeTree::default(), programs: 0 };
    let ended = walk.descend(&mut vec![None; at.size]);
    let (tree, programs) = (walk.tree, walk.programs);
    let proved = |tree: &ModeTree| certify_modes(problem, tree).is_ok_and(|r| r <= settings.tolerance);
    match ended {
        Some(true) => (Enumerated::Moving, programs),
        Some(false) if proved(&tree) => (Enumerated::None(tree), programs),
        _ => (Enumerated::Unknown, programs),
    }
}

struct Walk<'a> {
    problem: &'a ContactProblem,
    lcp: &'a MixedLcp,
    at: Layout,
    bounds: &'a ModeBounds,
    search: &'a mut Search,
    settings: &'a StabilitySettings,
    tree: ModeTree,
    programs: usize,
}

impl Walk<'_> {
    /// Whether a moving solution was found below this node; nothing where that stays open.
    fn descend(&mut self, fixed: &mut [Option<bool>]) -> Option<bool> {
        if self.programs == self.settings.enumeration_programs {
            return None;
        }
        self.programs += 1;
        let (x, multipliers) = self.largest_power(fixed)?;
        let load = self.lcp.b();
        let power: f64 = -(0..self.at.bilateral).map(|k| load[k] * x[k]).sum::<f64>();
        if power <= NO_POWER * self.bounds.energy {
            self.tree.branches.push(-1);
            self.tree.multipliers.extend(multipliers);
            return Some(false);
        }
        let (violation, pair) = self.most_violated(&x, fixed);
        if violation < NO_VIOLATION && self.is_solution(&x) {
            return Some(true);
        }
        let pair = pair?;
        self.tree.branches.push(pair as i32);
        for is_w_zero in [false, true] {
            fixed[pair] = Some(is_w_zero);
            if self.descend(fixed)? {
                return Some(true);
            }
        }
        fixed[pair] = None;
        Some(false)
    }

    /// The unit of every unknown: velocities of the free motion's energy; impulses of its momentum.
    fn units(&self) -> Vec<f64> {
        let impulse = self.problem.mass.largest_diagonal() * self.problem.velocity_scale();
        let of = |k: usize| if k < self.at.bilateral || k >= self.at.bounds { self.bounds.largest[k] } else { impulse };
        (0..self.at.size).map(|k| if of(k) > 0.0 { of(k) } else { 1.0 }).collect()
    }

    /// The point of largest power at a node, and the multipliers of the rows.
    fn largest_power(&self, fixed: &[Option<bool>]) -> Option<(Vec<f64>, Vec<f64>)> {
        let (n, units) = (self.at.size, self.units());
        let (matrix, b) = (self.lcp.A(), self.lcp.b());
        let mut program = ConicProgram::new(n);
        (0..self.at.bilateral).for_each(|k| program.set_cost(k, b[k] * units[k] / self.bounds.energy));
        let mut rows = Vec::with_capacity(n);
        for row in 0..n {
            let entries: Vec<(usize, f64)> = (0..n).map(|k| (k, matrix[(row, k)] * units[k])).collect();
            let size = entries.iter().fold(0.0, |a: f64, (_, e)| a.max(e.abs()));
            let size = if size > 0.0 { size } else { 1.0 };
            let entries: Vec<_> = entries.into_iter().map(|(k, e)| (k, e / size)).collect();
            let place = match row < self.at.normal || fixed[row] == Some(true) {
                true => program.equal(entries, -b[row] / size),
                false => program.at_least(entries, -b[row] / size),
            };
            rows.push((place, size));
        }
        for k in self.at.normal..n {
            match fixed[k] {
                Some(false) => program.equal([(k, 1.0)], 0.0),
                _ => program.at_least([(k, 1.0)], 0.0),
            };
        }
        for k in 0..self.at.bilateral {
            program.at_least([(k, 1.0)], -1.0);
            program.at_least([(k, -1.0)], -1.0);
        }
        let point = program.solve()?;
        let x = point.x.iter().zip(&units).map(|(x, unit)| x * unit).collect();
        let energy = self.bounds.energy;
        Some((x, rows.iter().map(|&(row, size)| point.z[row] * energy / size).collect()))
    }

    /// The undecided pair of which neither is zero, and by how much in the units of the unknowns.
    fn most_violated(&self, x: &[f64], fixed: &[Option<bool>]) -> (f64, Option<usize>) {
        let units = self.units();
        let matrix = self.lcp.A();
        let speed = self.problem.velocity_scale();
        let mut most = (0.0, None);
        for k in (self.at.normal..self.at.size).filter(|&k| fixed[k].is_none()) {
            let w: f64 = matrix.row(k).iter().zip(x).map(|(a, x)| a * x).sum::<f64>() + self.lcp.b()[k];
            let unit = if k < self.at.bounds { speed } else { units[self.at.normal] };
            let violation = (x[k] / units[k]).min(w / unit);
            if violation > most.0 || most.1.is_none() {
                most = (violation, Some(k));
            }
        }
        most
    }

    /// Whether the solver makes a moving solution of a point.
    fn is_solution(&mut self, x: &[f64]) -> bool {
        let at = self.at;
        let part = |range: std::ops::Range<usize>| x[range].iter().map(|z| z.max(0.0)).collect::<Vec<f64>>();
        let near: ContactSolution = solution_from(
            self.problem,
            &part(at.normal..at.tangential),
            &part(at.tangential..at.group_tangential),
            &x[at.bilateral..at.normal],
            &part(at.group_tangential..at.bounds),
        );
        let solved = self.search.solver().solve(self.problem, Some(&WarmStart::from_solution(&near)));
        [near, solved].into_iter().any(|s| self.search.take(self.problem, s, self.settings) == "moves")
    }
}
