//! What the growth of the impulses from one proximal iteration to the next proves.
//!
//! Where contacts demand what no velocity can give, every iteration adds the same self-balanced impulses. If the normal and bilateral
//! parts `d ≥ 0` of the change balance alone, they are a Farkas vector: with `J_Nᵀ d_N + ∇Θᵀ d_B = 0` the sum
//! `d_N · (J_N v + φ/Δt) + d_B · (∇Θ v + Θ/Δt)` is the same for every `v`, and where it is negative no `v` satisfies the rows
//! (formulation §4).

use super::map::ProximalMap;
use crate::islands::Island;
use crate::iterate::Iterate;
use crate::residual::RESIDUALS;
use crate::task::Task;

/// What the last proximal iteration added to the impulses.
#[derive(Clone, Debug, Default)]
pub(super) struct Growth {
    change: Vec<[f64; 3]>,
    bilateral_change: Vec<f64>,
    momentum: Vec<f64>,
    magnitude: Vec<f64>,
}

/// A sum, and that of the sizes of its terms.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: f64,
    terms: f64,
}

impl Sum {
    fn add(&mut self, term: f64) {
        self.value += term;
        self.terms += term.abs();
    }

    fn is_negative(&self) -> bool {
        self.value < -RESIDUALS.cancelled * self.terms
    }
}

impl Growth {
    /// Forgets another run.
    pub fn begin(&mut self, island: &Island) {
        self.change.clear();
        self.bilateral_change.clear();
        self.bilateral_change.resize(island.bilateral.len(), 0.0);
    }

    /// Moves the impulses to the solution of the proximal problem.
    pub fn take_solution(&mut self, map: &ProximalMap, task: &Task, iterate: &mut Iterate) {
        for (k, p) in iterate.bilateral.iter_mut().enumerate() {
            self.bilateral_change[k] = map.bilateral_change(task.island, k);
            *p += self.bilateral_change[k];
        }
        self.change.clear();
        for (c, &i) in task.island.units.iter().enumerate() {
            let (y, before) = (map.y[c], iterate.impulse[c]);
            let p = task.cones.project(i as usize, task.cones.mode_at(i as usize, y), y);
            self.change.push(std::array::from_fn(|r| p[r] - before[r]));
            iterate.impulse[c] = p;
        }
    }

    /// The last change of every unit's impulse, if there was one.
    pub fn change(&self, island: &Island) -> Option<&[[f64; 3]]> {
        (self.change.len() == island.units.len()).then_some(&*self.change)
    }

    /// Makes the last change so many times more.
    pub fn go_on(&self, island: &Island, iterate: &mut Iterate, times: f64) {
        for (p, change) in iterate.impulse.iter_mut().zip(&self.change) {
            p.iter_mut().zip(change).for_each(|(p, d)| *p += times * d);
        }
        iterate.bilateral.iter_mut().zip(&self.bilateral_change).for_each(|(p, d)| *p += times * d);
        island.bind(&mut iterate.impulse);
        iterate.velocity.clear();
    }

    /// Whether the last change proves that the rows contradict each other by more than `most` (m/s): rows that contradict each other
    /// by less have points that count as solutions.
    pub fn is_contradiction(&mut self, island: &Island, most: f64) -> bool {
        self.size(island).is_some() && self.is_self_balanced(island, most)
    }

    /// The contacts of the problem whose rows do.
    pub fn contradicting<'a>(&'a self, island: &'a Island) -> impl Iterator<Item = u32> + 'a {
        let size = self.size(island).unwrap_or(f64::INFINITY);
        let grows = move |c: &usize| self.change.get(*c).is_some_and(|p| p[0] > RESIDUALS.cancelled * size);
        (0..island.contact_count).filter(grows).map(|c| island.units[c])
    }

    /// The largest growth of a normal impulse, if none shrinks.
    fn size(&self, island: &Island) -> Option<f64> {
        let normals = || self.change.iter().take(island.contact_count).map(|p| p[0]);
        let size = normals().fold(0.0, f64::max);
        (size > 0.0 && normals().all(|d| d >= -RESIDUALS.cancelled * size)).then_some(size)
    }

    /// Whether the changes of the normal impulses and of the bilateral rows balance each other while they work against the
    /// gaps: for every velocity some row is then violated by at least their mean, the gain by the sum of the changes, which
    /// has to exceed `least`.
    fn is_self_balanced(&mut self, island: &Island, least: f64) -> bool {
        let (mut gain, mut weights) = (Sum::default(), 0.0);
        for sums in [&mut self.momentum, &mut self.magnitude] {
            sums.clear();
            sums.resize(island.nv(), 0.0);
        }
        let mut push = |k: u32, p: f64| {
            self.momentum[k as usize] += p;
            self.magnitude[k as usize] += p.abs();
        };
        for c in 0..island.contact_count {
            let d = self.change[c][0].max(0.0);
            gain.add(d * island.offset[c][0]);
            weights += d;
            let (columns, entries) = island.jacobian.group(c);
            columns.iter().zip(entries).for_each(|(&k, e)| push(k, d * e[0]));
        }
        for (k, (&d, offset)) in self.bilateral_change.iter().zip(&island.bilateral_offset).enumerate() {
            gain.add(d * offset);
            weights += d.abs();
            let (columns, entries) = island.bilateral_jacobian.group(k);
            columns.iter().zip(entries).for_each(|(&k, e)| push(k, d * e[0]));
        }
        gain.is_negative()
            && gain.value < -least * weights
            && self.momentum.iter().zip(&self.magnitude).all(|(sum, size)| sum.abs() <= RESIDUALS.cancelled * size)
    }
}
