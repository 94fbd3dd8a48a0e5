//! The weight ε of the proximal term from iteration to iteration.
//!
//! A small ε leaves little between one centre and the solution, and gives proximal problems that are as hard as the contact
//! problem: their modes are found from a centre that is near. A large ε gives easy problems and many of them. So an island that
//! is far from its solution begins with a large one, which falls with every problem that is solved and rises with every one
//! that is not. Below the usual ε, the iterations go on with smaller ones where the impulses have a long way to go in
//! directions of small Delassus eigenvalues, and end with larger ones: the rounding of `u` enters the impulses divided by ε.

use crate::residual::RESIDUALS;
use crate::settings::SolverSettings;

/// What is tuned in the changes of ε.
struct Tuning {
    /// The largest ε.
    largest: f64,
    /// Its factor after a proximal problem that was solved, four times where its modes were those of the one before; the reciprocal
    /// after one that was not.
    fall: f64,
    /// Its factor where the iterations are slow.
    slow_step: f64,
    /// A residual that rounding can leave with a small ε.
    rounding: f64,
    /// ε of the last iterations, and of the first ones after sweeps.
    last: f64,
}

/// Chosen by: `contact_lcp --seeds 73..77 --no-growth`, 22 November 2026; without `rounding` `sim S4_pile300 --tolerance 1e-8` takes twice
/// its time (23 November 2026); `last` after sweeps by recorded steps of piles of 1000, 1e-4 to 1.
const TUNING: Tuning = Tuning { largest: 10.0, fall: 0.3, slow_step: 10.0, rounding: 1e-8, last: 1e-3 };

/// ε and what it does next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProximalWeight {
    pub epsilon: f64,
    /// Whether a stride goes on until as many contacts have left their modes as a path brings back.
    pub strides_far: bool,
    /// How often it may still rise.
    rises: u32,
    usual: f64,
    smallest: f64,
    accept: f64,
    is_large: bool,
    /// The best residual at the last slow iterations.
    earlier_best: f64,
    ascending: bool,
}

impl ProximalWeight {
    /// The usual ε.
    pub fn new(settings: &SolverSettings, is_large: bool) -> Self {
        let (usual, smallest) = (settings.proximal_weight, settings.smallest_proximal_weight);
        Self {
            epsilon: usual,
            strides_far: false,
            rises: u32::MAX,
            usual,
            smallest,
            accept: settings.accept(),
            is_large,
            earlier_best: f64::INFINITY,
            ascending: false,
        }
    }

    /// ε = 1, as much as the Delassus diagonal, which falls to the usual one: what is far from its modes, or lacks a few of them.
    pub fn falling(settings: &SolverSettings) -> Self {
        Self { epsilon: 1.0, ..Self::new(settings, true) }
    }

    /// The same with strides beyond the first facet: for impulses that are far from the solution's, though the velocity is not.
    pub fn far(settings: &SolverSettings) -> Self {
        Self { strides_far: true, ..Self::falling(settings) }
    }

    /// One that falls from where sweeps left an island, and rises once.
    pub fn after_sweeps(settings: &SolverSettings) -> Self {
        Self { epsilon: TUNING.last, rises: 1, ..Self::new(settings, true) }
    }

    /// The ε of many equality constraints that no contact and no friction touches, where that of contacts is `epsilon`: they have no modes that have to be found
    /// from near, and are a step further where iterations are slow. (Nets of 49 and 144 bodies and chains of 100 take 0.35 to 0.75 of their time; with two
    /// steps ladders of 200 loops have no digits left.)
    pub fn of_constraints_alone(epsilon: f64) -> f64 {
        epsilon / TUNING.slow_step
    }

    /// Whether ε is still coming down to the usual one.
    pub fn is_falling(&self) -> bool {
        self.epsilon > self.usual && !self.ascending
    }

    /// After a proximal problem that was solved, with or without a change of its modes.
    pub fn fall(&mut self, unchanged: bool) {
        if self.is_falling() {
            let factor = if unchanged { TUNING.fall.powi(4) } else { TUNING.fall };
            self.epsilon = (factor * self.epsilon).max(self.usual);
        }
    }

    /// After a proximal problem that was not solved, with the best residual so far; `false` if there is nothing left to try.
    pub fn rise(&mut self, best: f64) -> bool {
        if best <= self.accept || self.ascending || self.epsilon >= TUNING.largest || self.rises == 0 {
            return false;
        }
        self.rises -= 1;
        self.epsilon = (self.epsilon / TUNING.fall).min(TUNING.largest);
        true
    }

    /// After slow iterations, with the best residual ever and that of the last one; `false` if they are the last ones.
    pub fn change(&mut self, best: f64, last: f64) -> bool {
        // What is accepted and does not get better is paid for with many mode changes in a large island; below the noise another ε is not
        // worth its factorisation.
        let is_enough = self.is_large && best <= self.accept && best > RESIDUALS.less * self.earlier_best;
        if best <= RESIDUALS.noise || is_enough {
            return false;
        }
        // In a large island a small residual that grows with a smaller ε is mostly rounding.
        let is_rounding = best < RESIDUALS.slow * last && last < TUNING.rounding;
        let fruitless = self.is_large && best >= self.earlier_best && is_rounding;
        self.ascending |= self.epsilon <= self.smallest || fruitless;
        self.earlier_best = best;
        if self.ascending && self.epsilon >= TUNING.last {
            return false;
        }
        self.epsilon = if self.ascending {
            (self.epsilon * TUNING.slow_step).min(TUNING.last)
        } else {
            (self.epsilon / TUNING.slow_step).max(self.smallest)
        };
        true
    }
}
