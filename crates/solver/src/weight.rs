//! The weight ε of the proximal term from iteration to iteration.
//!
//! A small ε leaves little between one centre and the solution, and gives proximal problems that are as hard as the contact
//! problem: their modes are found from a centre that is near. A large ε gives easy problems and many of them. So an island that
//! is far from its solution begins with a large one, which falls with every problem that is solved and rises with every one
//! that is not. Below the usual ε, the iterations go on with smaller ones where the impulses have a long way to go in
//! directions of small Delassus eigenvalues, and end with larger ones: the rounding of `u` enters the impulses divided by ε.

use super::SolverSettings;

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
/// The same of a patient attempt: just above the ε at which paths turn back, the iterations leave the place where they do so
/// in the fewest steps.
const PATIENT_FALL: f64 = 0.5;
const PATIENT_RISE: f64 = 2.0;
/// Problems that may stay unsolved, also in a patient attempt.
const FAILURES: u32 = 60;
const PATIENT_FAILURES: u32 = 150;

/// ε and what it does next.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProximalWeight {
    pub epsilon: f64,
    usual: f64,
    smallest: f64,
    accept: f64,
    is_large: bool,
    is_patient: bool,
    /// The best residual at the last slow iterations.
    earlier_best: f64,
    ascending: bool,
    failures: u32,
}

impl ProximalWeight {
    pub fn new(settings: &SolverSettings, is_large: bool, is_patient: bool) -> Self {
        let (usual, smallest) = (settings.proximal_weight, settings.smallest_proximal_weight);
        Self {
            epsilon: usual,
            usual,
            smallest,
            accept: settings.accept,
            is_large,
            is_patient,
            earlier_best: f64::INFINITY,
            ascending: false,
            failures: 0,
        }
    }

    /// After an interior start or block sweeps.
    pub fn begin_large(&mut self) {
        self.epsilon = FIRST;
    }

    /// Whether the attempt is a patient one.
    pub fn is_patient(&self) -> bool {
        self.is_patient
    }

    /// Whether ε is still coming down to the usual one.
    pub fn is_falling(&self) -> bool {
        self.epsilon > self.usual && !self.ascending
    }

    /// After a proximal problem that was solved, with or without a change of its modes; whether ε is another one.
    pub fn fall(&mut self, unchanged: bool) -> bool {
        let falling = self.is_falling();
        if falling {
            let factor = match (self.is_patient, unchanged) {
                (true, _) => PATIENT_FALL,
                (false, true) => QUICK_FALL,
                (false, false) => FALL,
            };
            self.epsilon = (factor * self.epsilon).max(self.usual);
        }
        falling
    }

    /// After a proximal problem that was not solved, with the best residual so far; `false` if there is nothing left to try.
    pub fn rise(&mut self, best: f64) -> bool {
        self.failures += 1;
        let (factor, failures) = if self.is_patient { (PATIENT_RISE, PATIENT_FAILURES) } else { (RISE, FAILURES) };
        if best <= self.accept || self.ascending || self.failures > failures || self.epsilon >= LARGEST {
            return false;
        }
        self.epsilon = (factor * self.epsilon).min(LARGEST);
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
