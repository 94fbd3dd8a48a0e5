//! The parametric path: from modes that were guessed to the modes of the solution, one facet at a time.
//!
//! Where the guessed modes do not hold, the data are shifted so that they do: contact `c` gets the trial impulse
//! `y_c + (1 − t) s_c`, and the momentum balance the term `−(1 − t) Σ J_cᵀ B⁰_c s_c` that keeps the velocity unchanged. At `t = 0`
//! the guess is the solution; at `t = 1` the problem is the true one. Between breakpoints everything is linear in `t`; at a
//! breakpoint one contact crosses one facet, the system changes by rank one, and the path goes on in the direction that
//! enters the new piece. Where the determinant changes its sign the path turns back in `t`, as Lemke's does.

use signorini_contact::projection::{Cones, Facet, Mode};
use signorini_contact::vector::dot;
use signorini_sparse::Random;

use super::breakpoint::first_crossing;
use super::map::ProximalMap;
use super::motion::Motion;
use crate::iterate::Iterate;
use crate::task::{Look, Task};

/// Which contacts' data a path shifts at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shift {
    /// Those whose modes do not hold.
    Violated,
    /// All; their modes are open.
    All,
}

/// The memory of a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// `s_c`.
    shift: Vec<[f64; 3]>,
    /// `B⁰_c s_c`.
    offset: Vec<[f64; 3]>,
    motion: Motion,
    work: Vec<f64>,
}

impl Path {
    /// Follows the path from the modes of the iterate, whose solution is in `map.y` and whose system is factorised, to those of the
    /// true problem. `false` if it ran back for ever, beyond its start in a large island or a short look, or met a singular system or its limit.
    pub fn follow(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &mut Iterate,
        which: Shift,
        seed: u32,
    ) -> bool {
        map.change_modes();
        self.begin(map, task, iterate, which, seed);
        // Most paths of a large island that come back past their start go to and fro until their limit, and longer ones of a problem without a solution.
        let may_return_after = match (task.is_large(), task.look) {
            (true, _) => 0,
            (false, Look::Short) => task.settings.path_changes_base as usize,
            _ => usize::MAX,
        };
        let (mut t, mut direction) = (0.0, 1.0);
        for change in 0..self.most_changes(task, which) as usize {
            let Some((step, crossing)) = self.next_breakpoint(map, task, iterate, direction, t) else { return false };
            t += direction * step;
            if t < 0.0 && change >= may_return_after {
                return false;
            }
            self.motion.advance(&mut map.y, direction * step);
            let Some((c, facet)) = crossing else {
                map.arrive();
                return true;
            };
            let Some(ratio) = self.cross(map, task, iterate, c, &facet) else { return false };
            if ratio < 0.0 {
                direction = -direction;
            }
            if map.system.is_worn() && !self.refresh(map, task, iterate, t) {
                return false;
            }
        }
        false
    }

    /// How many modes a path may change.
    fn most_changes(&self, task: &Task, which: Shift) -> u32 {
        let settings = task.settings;
        let shifted = self.shift.iter().filter(|s| **s != [0.0; 3]).count() as u32;
        settings.path_changes_base
            + match which {
                Shift::Violated => settings.path_changes_per_violation * shifted,
                Shift::All => settings.path_changes_per_contact * shifted,
            }
    }

    /// Shifts the contacts into their modes' cones.
    fn begin(&mut self, map: &mut ProximalMap, task: &Task, iterate: &Iterate, which: Shift, seed: u32) {
        let mut random = Random::new(seed);
        self.shift.clear();
        self.offset.clear();
        self.motion.rate.clear();
        for c in 0..iterate.modes.len() {
            let (i, mode, y) = (task.island.units[c] as usize, iterate.modes[c], map.y[c]);
            let size = map.typical_impulse(task.island, c) * random.between(1.0, 2.0);
            let shift = if which == Shift::All {
                [-y[0].max(0.0) - size, 0.0, 0.0]
            } else if map.is_violated(task, iterate, c) {
                let target = task.cones.interior_point(i, mode, size);
                std::array::from_fn(|r| target[r] - y[r])
            } else {
                [0.0; 3]
            };
            self.offset.push(task.cones.project(i, mode, shift));
            self.motion.rate.push(shift.map(|s| -s));
            map.y[c] = std::array::from_fn(|r| y[r] + shift[r]);
            self.shift.push(shift);
        }
        self.motion.begin();
    }

    /// The step to the next breakpoint and what crosses there; nothing crosses when `t = 1` comes first; none if the path
    /// runs back for ever.
    fn next_breakpoint(
        &mut self,
        map: &ProximalMap,
        task: &Task,
        iterate: &Iterate,
        direction: f64,
        t: f64,
    ) -> Option<(f64, Option<(usize, Facet)>)> {
        let most = if direction > 0.0 { 1.0 - t } else { f64::INFINITY };
        let (cones, units, motion) = (task.cones, &task.island.units, &mut self.motion);
        let (step, crossing) = first_crossing(cones, units, &iterate.modes, &map.y, motion, direction, most);
        let landing = |(c, facet)| self.landing(map, iterate, (cones, units), (c, facet), direction * step);
        step.is_finite().then(|| (step, crossing.map(landing)))
    }

    /// An opening facet's far side depends on where the contact is when it crosses, not on where it is now.
    fn landing(
        &self,
        map: &ProximalMap,
        iterate: &Iterate,
        (cones, units): (&Cones, &[u32]),
        (c, facet): (usize, Facet),
        step: f64,
    ) -> (usize, Facet) {
        if iterate.modes[c] != Mode::Open {
            return (c, facet);
        }
        let y = std::array::from_fn(|r| map.y[c][r] + step * self.motion.rate[c][r]);
        (c, cones.closing(units[c] as usize, y))
    }

    /// Lets contact `c` cross and corrects the rates; returns the ratio of the determinants.
    fn cross(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &mut Iterate,
        c: usize,
        facet: &Facet,
    ) -> Option<f64> {
        let weight = map.weight[c];
        let (column, ratio) = map.system.cross(task.island, c, facet, weight)?;
        let factor = dot(facet.normal, self.motion.rate[c]) / ratio;
        self.motion.correct(&task.island.jacobian, &map.weight, column, factor);
        self.motion.clearance[c] = 0.0;
        iterate.modes[c] = facet.next;
        map.effort.mode_changes += 1;
        Some(ratio)
    }

    /// Factorises afresh and recomputes `y` and its rate at `t` from the data.
    fn refresh(&mut self, map: &mut ProximalMap, task: &Task, iterate: &Iterate, t: f64) -> bool {
        if !map.refactor(task, iterate) {
            return false;
        }
        let island = task.island;
        self.work.clear();
        self.work.resize(island.nv(), 0.0);
        for (c, &i) in island.units.iter().enumerate() {
            let drive = task.cones.project(i as usize, iterate.modes[c], self.shift[c]);
            let d = std::array::from_fn(|r| self.offset[c][r] - drive[r]);
            island.add_impulse(c, d, &mut self.work);
        }
        map.system.solve(island, &mut self.work);
        for (c, rate) in self.motion.rate.iter_mut().enumerate() {
            let u = island.jacobian.multiply(c, &self.work);
            *rate = std::array::from_fn(|r| -map.weight[c] * u[r] - self.shift[c][r]);
        }
        self.motion.begin();
        let remaining = 1.0 - t;
        let part = |c: usize| (self.shift[c].map(|s| remaining * s), self.offset[c].map(|o| remaining * o));
        map.solve_shifted(task, iterate, part);
        true
    }
}
