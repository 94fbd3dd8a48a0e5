//! The weight ε of the proximal term from iteration to iteration.
//!
//! A small ε leaves little between one centre and the solution, and gives proximal problems that are as hard as the contact
//! problem: their modes are found from a centre that is near. A large ε gives easy problems and many of them. So an island that
//! is far from its solution begins with a large one, which falls with every problem that is solved and rises with every one
//! that is not. Below the usual ε, the iterations go on with smaller ones where the impulses have a long way to go in
//! directions of small Delassus eigenvalues, and end with larger ones: the rounding of `u` enters the impulses divided by ε.

use crate::settings::SolverSettings;

/// The factor between one ε and the next where the iterations are slow.
const SLOW_STEP: f64 = 1e2;
const LARGE_SLOW_STEP: f64 = 10.0;
/// Below this residual a slow iteration is a matter of rounding.
const ROUNDING_FLOOR: f64 = 2e-11;
/// Below this one, another ε is not worth its factorisation.
const NEARLY_POLISHED: f64 = 3e-12;
/// A residual that rounding can leave.
const SMALL: f64 = 1e-8;
/// How many times the best residual it is then.
const ROUNDED: f64 = 10.0;
/// Part of the best residual at the last slow iterations that counts as the same.
const STUCK: f64 = 0.5;
/// ε of the last iterations.
const LARGEST_LAST: f64 = 1e-3;
/// ε of the first problem after an interior start, and the largest one.
const FIRST: f64 = 1.0;
const LARGEST: f64 = 10.0;
/// Its factor after a proximal problem that was solved, after one whose modes were those of the one before, and after one that was not solved.
const FALL: f64 = 0.3;
const QUICK_FALL: f64 = 0.01;
const RISE: f64 = 3.0;
/// Problems that may stay unsolved.
const FAILURES: u32 = 60;

/// ε and what it does next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProximalWeight {
    pub epsilon: f64,
    usual: f64,
    smallest: f64,
    accept: f64,
    is_large: bool,
    /// The best residual at the last slow iterations.
    earlier_best: f64,
    ascending: bool,
    failures: u32,
}

impl ProximalWeight {
    /// The usual ε.
    pub fn new(settings: &SolverSettings, is_large: bool) -> Self {
        let (usual, smallest) = (settings.proximal_weight, settings.smallest_proximal_weight);
        Self {
            epsilon: usual,
            usual,
            smallest,
            accept: settings.accept,
            is_large,
            earlier_best: f64::INFINITY,
            ascending: false,
            failures: 0,
        }
    }

    /// A large ε, which falls to the usual one: what is far from its modes, or lacks a few of them.
    pub fn falling(settings: &SolverSettings) -> Self {
        Self { epsilon: FIRST, ..Self::new(settings, true) }
    }

    /// Whether ε is still coming down to the usual one.
    pub fn is_falling(&self) -> bool {
        self.epsilon > self.usual && !self.ascending
    }

    /// After a proximal problem that was solved, with or without a change of its modes.
    pub fn fall(&mut self, unchanged: bool) {
        if self.is_falling() {
            let factor = if unchanged { QUICK_FALL } else { FALL };
            self.epsilon = (factor * self.epsilon).max(self.usual);
        }
    }

    /// After a proximal problem that was not solved, with the best residual so far; `false` if there is nothing left to try.
    pub fn rise(&mut self, best: f64) -> bool {
        self.failures += 1;
        if best <= self.accept || self.ascending || self.failures > FAILURES || self.epsilon >= LARGEST {
            return false;
        }
        self.epsilon = (RISE * self.epsilon).min(LARGEST);
        true
    }

    /// After slow iterations, with the best residual ever and that of the last one; `false` if they are the last ones.
    pub fn change(&mut self, best: f64, last: f64) -> bool {
        // What is accepted and does not get better is paid for with many mode changes in a large island.
        if self.is_large && best <= self.accept && best > STUCK * self.earlier_best {
            return false;
        }
        // In a large island a small residual that grows with a smaller ε is mostly rounding, while it is small.
        let rounded = best < SMALL && last > ROUNDED * best && last < SMALL;
        let fruitless = self.is_large && best >= self.earlier_best && rounded;
        self.ascending |= best <= ROUNDING_FLOOR || self.epsilon <= self.smallest || fruitless;
        self.earlier_best = best;
        if self.ascending && (self.epsilon >= LARGEST_LAST || best <= NEARLY_POLISHED) {
            return false;
        }
        self.epsilon = if self.ascending {
            (self.epsilon * SLOW_STEP).min(LARGEST_LAST)
        } else {
            (self.epsilon / if self.is_large { LARGE_SLOW_STEP } else { SLOW_STEP }).max(self.smallest)
        };
        true
    }
}
