//! Which limited rows are asked for in full on trial: all at once, then the halves of what cannot be.

use std::ops::Range;

use crate::report::KeptRow;

/// Each trial is one more problem of a search, of which there are six without them: so many find two rows among twenty.
const MOST: u32 = 16;

/// The rows of a search; memory is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReleaseTrials {
    rows: Vec<KeptRow>,
    /// What is not tried yet, and what is on trial.
    open: Vec<Range<usize>>,
    on_trial: Range<usize>,
    made: u32,
}

impl ReleaseTrials {
    /// Begins with all limited rows but those that are needed.
    pub fn begin(&mut self, limited: impl Iterator<Item = KeptRow>, is_needed: impl Fn(KeptRow) -> bool) {
        let Self { rows, open, made, .. } = self;
        rows.clear();
        open.clear();
        let mut count = 0;
        rows.extend(limited.inspect(|_| count += 1).filter(|row| !is_needed(*row)));
        // A row that is limited alone was found to lack a solution in full.
        if count > 1 && !rows.is_empty() {
            open.push(0..rows.len());
        }
        *made = 0;
    }

    /// The next rows to try; none where all are tried, or too many trials were made.
    pub fn next(&mut self) -> Option<&[KeptRow]> {
        if self.made == MOST {
            return None;
        }
        self.made += 1;
        self.on_trial = self.open.pop()?;
        Some(&self.rows[self.on_trial.clone()])
    }

    /// The rows on trial cannot all be asked for in full: their halves are tried.
    pub fn split(&mut self) {
        let Range { start, end } = self.on_trial;
        if end - start > 1 {
            let middle = start.midpoint(end);
            self.open.extend([middle..end, start..middle]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows that are released where some cannot be, and how many trials that took.
    fn released(count: usize, stuck: &[usize]) -> (Vec<usize>, u32) {
        let (mut trials, mut released) = (ReleaseTrials::default(), Vec::new());
        trials.begin((0..count).map(KeptRow::Contact), |row| row == KeptRow::Contact(0));
        while let Some(rows) = trials.next() {
            let numbers: Vec<usize> =
                rows.iter().map(|row| if let KeptRow::Contact(i) = row { *i } else { 0 }).collect();
            if numbers.iter().any(|i| stuck.contains(i)) {
                trials.split();
            } else {
                released.extend(numbers);
            }
        }
        (released, trials.made)
    }

    #[test]
    fn all_but_those_that_are_stuck_are_released() {
        assert_eq!(released(20, &[]).0, (1..20).collect::<Vec<_>>());
        for (count, stuck) in [(19, vec![5, 17]), (3, vec![1]), (40, vec![39]), (8, vec![1, 2, 3])] {
            let expected: Vec<usize> = (1..count).filter(|i| !stuck.contains(i)).collect();
            let (found, made) = released(count, &stuck);
            assert_eq!(found, expected, "{stuck:?}");
            assert!(made <= MOST);
        }
    }

    #[test]
    fn a_row_alone_is_not_tried_again_and_trials_come_to_an_end() {
        assert_eq!(released(1, &[]), (vec![], 1));
        let stuck: Vec<usize> = (0..100).collect();
        assert_eq!(released(100, &stuck).1, MOST);
    }
}
