//! What the last steps could not correct, and when more of it is tried again.
//!
//! Where a step was permitted a part of its corrections, the next one is mostly permitted the same. Looking for more in every step costs
//! several problems, of which those that have no solution are the dearest; so the step after it asks for the same part of the same rows, and more
//! is looked for at intervals that double while that goes well, and become the longer the longer nothing changes. After a single such step all is asked
//! for again.

use crate::warm::{ContactKey, read_keys, write_keys};

/// The longest interval, in steps: a search solves up to six problems, which then cost less than a half of the steps between, and as much as
/// they do where a few limited rows are looked at one by one.
const LONGEST: u32 = 15;
/// The longest where the last searches found the same part of the same rows without a proof that there is no more, which takes no problem. A search takes up to some forty steps of what stands, which are then a quarter of the time; what comes
/// free meanwhile waits at most that long (100 files with limited steps take 0.86 of the time in the mean, 28 November 2026; no other value was tried).
const LONGEST_STUCK: u32 = 127;

/// Memory of limited corrections.
#[derive(Clone, Debug, Default)]
pub(crate) struct Withheld {
    /// The part that was not permitted, `1 − θ`.
    part: f64,
    /// What it was withheld from: contacts, and rows of the model's constraints; ascending.
    contacts: Vec<ContactKey>,
    rows: Vec<[u32; 1]>,
    /// What it was withheld from before.
    earlier: (Vec<ContactKey>, Vec<[u32; 1]>),
    /// Whether it was withheld from all there were, as where the energy of corrections is bounded.
    all: bool,
    /// Steps left that ask for the same, of an interval of so many.
    left: u32,
    interval: u32,
    /// Whether it is proven that this step is permitted no more.
    proven: bool,
    /// Whether this step asks for the same; the interval that it began with, where the step before it was limited.
    repeats: bool,
    before: Option<u32>,
}

impl Withheld {
    /// Begins a step.
    pub fn begin_step(&mut self) {
        self.repeats = self.left > 0;
        self.proven = false;
        self.left = self.left.saturating_sub(1);
        self.before = (self.part > 0.0).then_some(self.interval);
    }

    /// The part θ of its corrections that the last step was permitted.
    pub fn theta(&self) -> f64 {
        1.0 - self.part
    }

    /// Whether this step asks for what the last one was permitted.
    pub fn repeats(&self) -> bool {
        self.repeats
    }

    /// Whether that was by the energy of corrections: the laws permit more, and have a solution for every part.
    pub fn is_by_energy(&self) -> bool {
        self.all
    }

    /// It is proven that this step is permitted no more.
    pub fn take_proof(&mut self) {
        self.proven = true;
    }

    /// It did not go well.
    pub fn search_again(&mut self) {
        (self.repeats, self.before) = (false, None);
    }

    /// Whether the corrections of a contact, or of a row of constraints, were limited.
    pub fn has_contact(&self, key: &ContactKey) -> bool {
        self.all || self.contacts.binary_search(key).is_ok()
    }

    pub fn has_row(&self, row: usize) -> bool {
        self.all || self.rows.binary_search(&[row as u32]).is_ok()
    }

    /// Takes note of the step.
    ///
    /// - `theta`: the part that it was permitted
    /// - `contacts`, `rows`: what the part applies to; `all`: whether that is all
    pub fn remember(
        &mut self,
        theta: f64,
        all: bool,
        contacts: impl Iterator<Item = ContactKey>,
        rows: impl Iterator<Item = usize>,
    ) {
        let earlier_part = self.part;
        (self.part, self.all) = (1.0 - theta, all);
        std::mem::swap(&mut self.contacts, &mut self.earlier.0);
        std::mem::swap(&mut self.rows, &mut self.earlier.1);
        self.contacts.clear();
        self.rows.clear();
        if theta == 1.0 {
            (self.left, self.interval) = (0, 0);
            return;
        }
        self.contacts.extend(contacts);
        self.contacts.sort_unstable();
        self.rows.extend(rows.map(|row| [row as u32]));
        if !self.repeats {
            let is_same =
                self.part == earlier_part && (&self.contacts, &self.rows) == (&self.earlier.0, &self.earlier.1);
            let is_stuck = is_same && !self.proven;
            let longest = if is_stuck { LONGEST_STUCK } else { LONGEST };
            self.interval = self.before.map_or(0, |before| (2 * before + 1).min(longest));
            self.left = self.interval;
            // Where contacts are found anew the step goes on from what it was permitted before.
            self.repeats = true;
        }
    }

    /// As plain numbers.
    pub fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend([self.part, f64::from(self.all), f64::from(self.left), f64::from(self.interval)]);
        write_keys(&self.contacts, numbers);
        write_keys(&self.rows, numbers);
    }

    /// What [`write`](Self::write) wrote, and what follows it.
    pub fn read(numbers: &[f64]) -> Option<(Self, &[f64])> {
        let (&[part, all, left, interval], rest) = numbers.split_first_chunk::<4>()?;
        let is_count = |x: f64| (0.0..=f64::from(LONGEST_STUCK)).contains(&x) && x.fract() == 0.0;
        if !(0.0..=1.0).contains(&part) || ![0.0, 1.0].contains(&all) || !is_count(left) || !is_count(interval) {
            return None;
        }
        let (contacts, rest) = read_keys(rest)?;
        let (rows, rest) = read_keys(rest)?;
        let (left, interval) = (left as u32, interval as u32);
        Some((Self { part, contacts, rows, all: all == 1.0, left, interval, ..Self::default() }, rest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The intervals between searches of a jam that stays as it is.
    fn intervals(is_proven: bool) -> Vec<u32> {
        let (mut withheld, mut intervals, mut last) = (Withheld::default(), Vec::new(), None::<u32>);
        for step in 0..1000u32 {
            withheld.begin_step();
            if !withheld.repeats() {
                intervals.extend(last.map(|last| step - last));
                last = Some(step);
                if is_proven {
                    withheld.take_proof();
                }
            }
            withheld.remember(0.0, false, std::iter::empty(), [3].into_iter());
        }
        intervals
    }

    #[test]
    fn more_of_what_is_stuck_is_asked_for_at_intervals_that_double() {
        for (is_proven, longest) in [(false, LONGEST_STUCK), (true, LONGEST)] {
            let found = intervals(is_proven);
            assert_eq!(found[..4], [1, 2, 4, 8], "{found:?}");
            assert_eq!(found.iter().max(), Some(&(longest + 1)), "{found:?}");
            assert!(found.is_sorted(), "{found:?}");
        }
    }
}
