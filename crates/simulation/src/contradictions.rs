//! Corrections that contradict each other: what is asked for between bodies that are jammed.

use signorini_contact::ContactProblem;
use signorini_lcp::Alternative;

use crate::corrections::Corrections;
use crate::report::KeptRow;

/// More degrees of freedom than this are not looked at: the cost grows with their third power (the jams of robots that this was made for have up to 32;
/// no other value was tried).
const MOST: usize = 64;
/// Where multipliers leave this part of what they are to prove, rows contradict each other but for velocities a million times as fast as what is asked for,
/// which no step has (no other value was tried).
const PROVEN: f64 = 1e-6;
/// A row with less than this part of what the largest has in a contradiction is there by rounding: last digits of a row of the alternative are 1e-13 of it.
const SHARE: f64 = 1e-9;

/// Memory of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contradictions {
    alternative: Alternative,
    /// Its columns.
    rows: Vec<Row>,
    is_taken: Vec<bool>,
    /// The degrees of freedom that the rows move, and the place of each among them.
    moved: Vec<u32>,
    place: Vec<Option<u32>>,
}

/// A row of the problem, with a sign.
#[derive(Clone, Copy, Debug)]
struct Row {
    row: KeptRow,
    sign: f64,
    /// What is asked for of it, m or rad, in proportion to θ and beside that.
    limited: f64,
    other: f64,
    /// What it has in the last contradiction that was found, of the unit of `limited`.
    share: f64,
    /// Whether a contradiction needs its limit.
    is_needed: bool,
}

impl Contradictions {
    /// Forgets the contradiction that was found last.
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    /// The largest part θ of the limited corrections for which no contradiction is found: rows of which no velocity satisfies all, whatever friction does, by
    /// Farkas' lemma ([`GapContradiction`](signorini_contact::GapContradiction)). Of such rows, times their multipliers, those with an open gap leave what they
    /// have, and 0 where there are none.
    pub fn largest_part(&mut self, problem: &ContactProblem, corrections: &Corrections) -> f64 {
        self.gather(problem, corrections);
        let mut largest = 1.0;
        if self.moved.len() > MOST {
            return largest;
        }
        for _ in 0..self.rows.len() {
            self.ask(largest, problem);
            self.alternative.find();
            if self.alternative.missed() > PROVEN {
                break;
            }
            let part = self.part_left();
            if part >= largest {
                break;
            }
            largest = part;
        }
        largest
    }

    /// Limits no more of the limited rows than contradictions need that all rows would have in full: one contradiction after the other, until none is
    /// found. Whether that releases any row.
    pub fn release_all_but_needed(&mut self, problem: &ContactProblem, corrections: &mut Corrections) -> bool {
        self.gather(problem, corrections);
        if self.moved.len() > MOST {
            return false;
        }
        self.rows.iter_mut().for_each(|row| row.other += row.limited);
        loop {
            self.ask(0.0, problem);
            self.alternative.find();
            if self.alternative.missed() > PROVEN {
                break;
            }
            self.find_shares();
            let is_new = |row: &&mut Row| !row.is_needed && row.share > SHARE;
            let mut any = false;
            for row in self.rows.iter_mut().filter(is_new) {
                (row.is_needed, any) = (true, true);
                row.other -= (1.0 - corrections.theta) * row.limited;
            }
            if !any {
                return false;
            }
        }
        self.released().for_each(|row| corrections.release(row, true));
        self.released().next().is_some()
    }

    /// Limits what was released.
    pub fn limit_again(&self, corrections: &mut Corrections) {
        self.released().for_each(|row| corrections.release(row, false));
    }

    /// The limited rows that no contradiction needs. A constraint is there with both signs.
    fn released(&self) -> impl Iterator<Item = KeptRow> + '_ {
        let is_needed = |row: KeptRow| self.rows.iter().any(|own| own.row == row && own.is_needed);
        self.rows.iter().filter(|own| own.limited != 0.0).map(|own| own.row).filter(move |row| !is_needed(*row))
    }

    /// Collects the limited rows, those that hang together with them, and the degrees of freedom that they move.
    fn gather(&mut self, problem: &ContactProblem, corrections: &Corrections) {
        self.rows.clear();
        self.moved.clear();
        self.place.clear();
        self.place.resize(problem.nv(), None);
        let (contacts, count) = (problem.contact_count(), problem.bilateral_violation.len());
        self.is_taken.clear();
        self.is_taken.resize(contacts + count, false);
        // A row that moves what is moved already may bring in more of them.
        let mut before = usize::MAX;
        while before != self.rows.len() && self.moved.len() <= MOST {
            before = self.rows.len();
            let all = (0..contacts).map(KeptRow::Contact).chain((0..count).map(KeptRow::Bilateral));
            for (at, row) in all.enumerate() {
                let indices = moved_by(problem, row);
                let is_tied = || indices.iter().any(|&k| self.place[k as usize].is_some());
                if !self.is_taken[at] && !indices.is_empty() && (corrections.limits(row) || is_tied()) {
                    self.is_taken[at] = true;
                    self.take(row, 1.0, corrections, indices);
                    if matches!(row, KeptRow::Bilateral(_)) {
                        self.take(row, -1.0, corrections, indices);
                    }
                }
            }
        }
    }

    fn take(&mut self, row: KeptRow, sign: f64, corrections: &Corrections, indices: &[u32]) {
        let asked = corrections.asked(row);
        let is_correction = asked < 0.0 || matches!(row, KeptRow::Bilateral(_));
        let (limited, other) = if is_correction && corrections.limits(row) { (asked, 0.0) } else { (0.0, asked) };
        self.rows.push(Row { row, sign, limited, other, share: 0.0, is_needed: false });
        for &k in indices {
            let place = &mut self.place[k as usize];
            if place.is_none() {
                *place = Some(self.moved.len() as u32);
                self.moved.push(k);
            }
        }
    }

    /// Asks for the multipliers of a contradiction of the rows, with this part of what is limited.
    fn ask(&mut self, part: f64, problem: &ContactProblem) {
        let Self { alternative, rows, moved, place, .. } = self;
        alternative.begin(moved.len() + 1);
        for &Row { row, sign, limited, other, .. } in &*rows {
            let column = alternative.push();
            column[moved.len()] = sign * (part * limited + other) / problem.timestep;
            match row {
                KeptRow::Contact(i) => write_row(problem.jacobian.group(i), sign, place, column),
                KeptRow::Bilateral(k) => write_row(problem.bilateral_jacobian.group(k), sign, place, column),
            }
        }
    }

    /// The part of the limited corrections that the contradiction that was found leaves.
    fn part_left(&mut self) -> f64 {
        self.find_shares();
        let (mut limited, mut other) = (0.0, 0.0);
        for (row, multiplier) in self.rows.iter().zip(self.alternative.coefficients()) {
            limited -= multiplier * row.sign * row.limited;
            other += multiplier * row.sign * row.other;
        }
        if other > SHARE * limited { other / limited } else { 0.0 }
    }

    /// Writes what every row has in the contradiction that was found, relative to the largest.
    fn find_shares(&mut self) {
        let mut most = f64::MIN_POSITIVE;
        for (row, multiplier) in self.rows.iter_mut().zip(self.alternative.coefficients()) {
            row.share = multiplier * row.limited.abs();
            most = most.max(row.share);
        }
        self.rows.iter_mut().for_each(|row| row.share /= most);
    }
}

/// Writes the first row of a group of a Jacobian, times a sign, to the places of the degrees of freedom.
fn write_row<const R: usize>(
    (indices, entries): (&[u32], &[[f64; R]]),
    sign: f64,
    place: &[Option<u32>],
    column: &mut [f64],
) {
    for (&k, entry) in indices.iter().zip(entries) {
        if let Some(place) = place[k as usize] {
            column[place as usize] = sign * entry[0];
        }
    }
}

/// The degrees of freedom that a row moves.
fn moved_by(problem: &ContactProblem, row: KeptRow) -> &[u32] {
    match row {
        KeptRow::Contact(i) => problem.jacobian.group(i).0,
        KeptRow::Bilateral(k) => problem.bilateral_jacobian.group(k).0,
    }
}

#[cfg(test)]
mod tests {
    use signorini_contact::{ContactProblem, FrictionPolygon};
    use signorini_multibody::BlockDiagonal;

    use super::*;

    /// Gap rows in a plane, with normals and gaps.
    fn limited(rows: &[([f64; 2], f64)]) -> (ContactProblem, Corrections) {
        let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).unwrap();
        let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).unwrap();
        let polygon = FrictionPolygon::regular(4, 0.0).unwrap();
        for (normal, gap) in rows {
            problem.push_contact([(0, [normal[0], 0.0, 0.0]), (1, [normal[1], 0.0, 0.0])], *gap, 0.5, &polygon);
        }
        let mut corrections = Corrections::default();
        corrections.ask(&problem, problem.bilateral_violation.len());
        corrections.limit(|_| true, |_| true);
        (problem, corrections)
    }

    /// The same by the lines of every two rows and every three rows of the plane: multipliers that add normals up to zero.
    fn largest_of_triples(rows: &[([f64; 2], f64)]) -> f64 {
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let mut largest = 1.0f64;
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows[..i].iter().enumerate() {
                for c in &rows[..j] {
                    let multipliers = [cross(b.0, c.0), cross(c.0, a.0), cross(a.0, b.0)];
                    let sign = multipliers[0].signum();
                    if multipliers.iter().all(|y| y * sign > 0.0) {
                        let work = |keep: fn(f64) -> f64| -> f64 {
                            multipliers.iter().zip([a, b, c]).map(|(y, row)| y.abs() * keep(row.1)).sum()
                        };
                        let (asked, left) = (work(|gap| (-gap).max(0.0)), work(|gap| gap.max(0.0)));
                        largest = largest.min(if asked > left { left / asked } else { 1.0 });
                    }
                }
            }
        }
        largest
    }

    #[test]
    fn what_presses_from_both_sides_is_permitted_what_there_is_room_for() {
        let pair = |left: f64, right: f64| {
            let (problem, mut corrections) = limited(&[([1.0, 0.0], left), ([-1.0, 0.0], right), ([0.0, 1.0], -0.3)]);
            let mut contradictions = Contradictions::default();
            let largest = contradictions.largest_part(&problem, &corrections);
            corrections.theta = largest;
            contradictions.release_all_but_needed(&problem, &mut corrections);
            (largest, corrections.limited_rows().collect::<Vec<_>>())
        };
        let [first, second] = [0, 1].map(KeptRow::Contact);
        assert_eq!(pair(-0.1, -0.2), (0.0, vec![first, second]));
        let (largest, limited) = pair(-0.1, 0.025);
        assert!((largest - 0.25).abs() < 1e-12 && limited == [first], "{largest} {limited:?}");
        assert_eq!(pair(-0.1, 0.2), (1.0, vec![]));
    }

    #[test]
    fn the_largest_part_is_that_of_all_triples() {
        let number = |k: usize| (k as f64 * 12.9898).sin() * 43_758.545 % 1.0;
        let mut count = [0; 3];
        for k in 0..600 {
            let row = |i: usize| {
                let at = 40 * k + 3 * i;
                ([number(at), number(at + 1)], number(at + 2) - 0.8 + 0.4 * (k % 5) as f64)
            };
            let rows: Vec<_> = (0..3 + k % 7).map(row).collect();
            let (problem, corrections) = limited(&rows);
            let largest = Contradictions::default().largest_part(&problem, &corrections);
            let expected = largest_of_triples(&rows);
            assert!((largest - expected).abs() < 1e-9, "{rows:?}: {largest}, not {expected}");
            count[if expected == 0.0 { 0 } else { 1 + usize::from(expected == 1.0) }] += 1;
        }
        assert!(count.iter().all(|count| *count > 50), "{count:?}");
    }

    #[test]
    fn a_constraint_that_holds_a_velocity_leaves_so_much() {
        for (held, expected) in [(0.1, 0.5), (0.3, 1.0), (-0.1, 0.0)] {
            let (mut problem, mut corrections) = limited(&[([1.0, 0.0], -0.2)]);
            problem.push_bilateral([(0, [-1.0]), (1, [0.0])], held);
            corrections.ask(&problem, 1);
            corrections.limit(|_| true, |_| false);
            let largest = Contradictions::default().largest_part(&problem, &corrections);
            assert!((largest - expected).abs() < 1e-12, "{held}: {largest}");
        }
    }

    #[test]
    fn what_has_nothing_to_do_with_it_is_asked_for_in_full() {
        let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).unwrap();
        let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).unwrap();
        let polygon = FrictionPolygon::regular(4, 0.0).unwrap();
        for (column, normal) in [(0, 1.0), (0, -1.0), (1, 1.0)] {
            problem.push_contact([(column, [normal, 0.0, 0.0])], -0.1, 0.5, &polygon);
        }
        let mut corrections = Corrections::default();
        corrections.ask(&problem, 0);
        corrections.limit(|_| true, |_| true);
        let mut contradictions = Contradictions::default();
        assert_eq!(contradictions.largest_part(&problem, &corrections), 0.0);
        corrections.theta = 0.0;
        contradictions.release_all_but_needed(&problem, &mut corrections);
        let limited: Vec<KeptRow> = corrections.limited_rows().collect();
        assert_eq!(limited, [KeptRow::Contact(0), KeptRow::Contact(1)]);
    }
}
