//! The parametric path: from modes that were guessed to the modes of the solution, one facet at a time.
//!
//! Where the guessed modes do not hold, the data are shifted so that they do: contact `c` gets the trial impulse
//! `y_c + (1 − t) s_c`, and the momentum balance the term `−(1 − t) Σ J_cᵀ B⁰_c s_c` that keeps the velocity unchanged. At `t = 0`
//! the guess is the solution; at `t = 1` the problem is the true one. Between breakpoints everything is linear in `t`; at a
//! breakpoint one contact crosses one facet, the system changes by rank one, and the path goes on in the direction that
//! enters the new piece. Where the determinant changes its sign the path turns back in `t`, as Lemke's does.

use super::SolverSettings;
use super::breakpoint::first_crossing;
use super::island::Island;
use super::island_solver::IslandSolver;
use super::motion::Motion;
use signorini_contact::projection::{Cones, Facet, Mode};
use signorini_contact::vector::dot;
use signorini_sparse::Random;

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PathOutcome {
    /// The modes are those of the true problem.
    Reached,
    /// The path ran back beyond its start, or met a singular system or its limit.
    Lost,
}

/// Which contacts' data a path shifts at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shift {
    /// Those whose modes do not hold.
    Violated,
    /// The same, few of many: a path that ends does so after hardly more changes than there are of them.
    Few,
    /// All; their modes are open.
    All,
    /// Those whose laws do not hold at the centre, which is then the solution at the start of the path.
    Centre,
}

/// How far back `t` may run before the path counts as lost.
const FARTHEST_BACK: f64 = -1e4;
/// The same for a path from the centre: behind its start lies nothing that is nearer to the solution.
const BACK_FROM_CENTRE: f64 = -0.2;
/// Of a contact's typical impulse: how far inside its mode a path from the centre begins, so that no two contacts cross at once.
const INSIDE: f64 = 1e-2;
/// Mode changes that a path from the modes of few contacts may use, and more of them for each contact.
const FEW_CHANGES: u32 = 60;
const CHANGES_PER_VIOLATION: u32 = 2;
/// Mode changes that a path from the centre may use, and more of them for so many contacts each.
const CENTRE_CHANGES: u32 = 200;
const CONTACTS_PER_CHANGE: u32 = 4;

/// The memory of a path.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    /// `s_c`.
    shift: Vec<[f64; 3]>,
    /// `B⁰_c s_c`.
    offset: Vec<[f64; 3]>,
    motion: Motion,
    work: Vec<f64>,
    /// Whether the bilateral rows are shifted as well, as they are where the path starts at the centre.
    from_centre: bool,
}

impl Path {
    /// Follows the path from `solver.modes`, whose fixed-mode solution is in `solver.y` and whose system is factorised.
    /// Leaves the modes found in `solver.modes`.
    pub fn follow(
        &mut self,
        solver: &mut IslandSolver,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        shift: Shift,
        seed: u32,
    ) -> PathOutcome {
        self.from_centre = shift == Shift::Centre;
        if self.from_centre {
            self.begin_at_centre(solver, cones, island, seed);
            if !self.refresh(solver, cones, island, 0.0) {
                return PathOutcome::Lost;
            }
        } else {
            self.begin(solver, cones, island, settings, shift, seed);
        }
        let (mut t, mut direction) = (0.0, 1.0);
        let shifted = self.shift.iter().filter(|s| **s != [0.0; 3]).count() as u32;
        let contacts = solver.modes.len() as u32;
        let limit = match shift {
            Shift::Violated => settings.path_changes_base + settings.path_changes_per_violation * shifted,
            Shift::Few => FEW_CHANGES + CHANGES_PER_VIOLATION * shifted,
            Shift::All => settings.path_changes_base + settings.path_changes_per_contact * contacts,
            Shift::Centre => CENTRE_CHANGES + contacts / CONTACTS_PER_CHANGE,
        };
        let farthest_back = if self.from_centre { BACK_FROM_CENTRE } else { FARTHEST_BACK };
        for _ in 0..limit {
            let Some((step, crossing)) = self.next_breakpoint(solver, cones, island, direction, t) else {
                return PathOutcome::Lost;
            };
            t += direction * step;
            self.motion.advance(&mut solver.y, direction * step);
            let Some((c, facet)) = crossing else { return PathOutcome::Reached };
            if t < farthest_back {
                return PathOutcome::Lost;
            }
            let Some(ratio) = self.cross(solver, island, c, &facet) else { return PathOutcome::Lost };
            if ratio < 0.0 {
                direction = -direction;
            }
            if solver.system.is_worn() && !self.refresh(solver, cones, island, t) {
                return PathOutcome::Lost;
            }
        }
        PathOutcome::Lost
    }

    /// Shifts the contacts whose modes do not hold into their modes' cones.
    fn begin(
        &mut self,
        solver: &mut IslandSolver,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        which: Shift,
        seed: u32,
    ) {
        let mut random = Random::new(seed);
        self.shift.clear();
        self.offset.clear();
        self.motion.rate.clear();
        for c in 0..solver.modes.len() {
            let (i, mode) = (island.units[c] as usize, solver.modes[c]);
            let y = solver.y[c];
            let factor = random.between(0.5, 1.5);
            let violated = solver.is_violated(cones, island, settings, c);
            let shift = if which == Shift::All {
                [-y[0].max(0.0) - solver.typical_impulse(island, c) * factor, 0.0, 0.0]
            } else if violated {
                let target = cones.interior_point(i, mode, solver.typical_impulse(island, c) * factor);
                std::array::from_fn(|r| target[r] - y[r])
            } else {
                [0.0; 3]
            };
            self.offset.push(cones.project(i, mode, shift));
            self.motion.rate.push(shift.map(|s| -s));
            solver.y[c] = std::array::from_fn(|r| y[r] + shift[r]);
            self.shift.push(shift);
        }
        self.motion.begin();
    }

    /// Gives every contact modes and a shift with which the centre is the solution.
    fn begin_at_centre(&mut self, solver: &mut IslandSolver, cones: &Cones, island: &Island, seed: u32) {
        let mut random = Random::new(seed);
        self.shift.clear();
        self.offset.clear();
        self.motion.rate.clear();
        self.motion.rate.resize(island.units.len(), [0.0; 3]);
        for (c, &i) in island.units.iter().enumerate() {
            let (i, trial) = (i as usize, solver.trial[c]);
            let source = cones.source(i, solver.impulse[c], trial);
            let mode = cones.mode_at(i, source);
            let size = INSIDE * solver.typical_impulse(island, c) * random.between(0.5, 1.5);
            let inwards = cones.interior_point(i, mode, size);
            self.shift.push(std::array::from_fn(|r| source[r] + inwards[r] - trial[r]));
            self.offset.push(cones.project(i, mode, inwards));
            solver.modes[c] = mode;
        }
    }

    /// The step to the next breakpoint and what crosses there; nothing crosses when `t = 1` comes first; none if the path
    /// runs back for ever.
    fn next_breakpoint(
        &mut self,
        solver: &IslandSolver,
        cones: &Cones,
        island: &Island,
        direction: f64,
        t: f64,
    ) -> Option<(f64, Option<(usize, Facet)>)> {
        let most = if direction > 0.0 { 1.0 - t } else { f64::INFINITY };
        let motion = &mut self.motion;
        let (step, crossing) = first_crossing(cones, &island.units, &solver.modes, &solver.y, motion, direction, most);
        step.is_finite().then(|| (step, self.landing(solver, cones, island, crossing, direction * step)))
    }

    /// An opening facet's far side depends on where the contact is when it crosses, not on where it is now.
    fn landing(
        &self,
        solver: &IslandSolver,
        cones: &Cones,
        island: &Island,
        crossing: Option<(usize, Facet)>,
        step: f64,
    ) -> Option<(usize, Facet)> {
        let (c, mut facet) = crossing?;
        if solver.modes[c] == Mode::Open {
            let y = std::array::from_fn(|r| solver.y[c][r] + step * self.motion.rate[c][r]);
            facet = cones.closing(island.units[c] as usize, y);
        }
        Some((c, facet))
    }

    /// Lets contact `c` cross and corrects the rates; returns the ratio of the determinants.
    fn cross(&mut self, solver: &mut IslandSolver, island: &Island, c: usize, facet: &Facet) -> Option<f64> {
        let weight = solver.weight[c];
        let (column, ratio) = solver.system.cross(island, c, facet, weight)?;
        let factor = dot(facet.normal, self.motion.rate[c]) / ratio;
        self.motion.correct(&island.jacobian, &solver.weight, column, factor);
        self.motion.clearance[c] = 0.0;
        solver.modes[c] = facet.next;
        solver.effort.mode_changes += 1;
        Some(ratio)
    }

    /// Factorises afresh and recomputes `y` and its rate at `t` from the data.
    fn refresh(&mut self, solver: &mut IslandSolver, cones: &Cones, island: &Island, t: f64) -> bool {
        solver.effort.factorizations += 1;
        if !solver.system.factor(island, cones, &solver.modes, &solver.weight) {
            return false;
        }
        self.work.clear();
        self.work.resize(island.nv(), 0.0);
        for (c, &i) in island.units.iter().enumerate() {
            let drive = cones.project(i as usize, solver.modes[c], self.shift[c]);
            let d = std::array::from_fn(|r| self.offset[c][r] - drive[r]);
            island.add_impulse(c, d, &mut self.work);
        }
        if self.from_centre {
            solver.add_bilateral_pull(island, 1.0, &mut self.work);
        }
        solver.system.solve(island, &mut self.work);
        for (c, rate) in self.motion.rate.iter_mut().enumerate() {
            let u = island.jacobian.multiply(c, &self.work);
            *rate = std::array::from_fn(|r| -solver.weight[c] * u[r] - self.shift[c][r]);
        }
        self.motion.begin();
        let bilateral_part = if self.from_centre { t } else { 1.0 };
        solver.place_on_path(cones, island, (&self.shift, &self.offset), 1.0 - t, bilateral_part);
        true
    }
}
