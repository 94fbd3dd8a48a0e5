//! Outcomes, counted.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use signorini::contact::Certificate;

use super::FAMILIES;
use crate::table::markdown;

/// Buckets of the histogram of times per doubling.
const PER_DOUBLING: f64 = 8.0;

/// What became of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Outcome {
    /// Claimed solved, and it is.
    Solved,
    /// Denied, and multipliers prove it.
    Infeasible,
    /// Denied, and every complementary choice was refuted.
    NoSolution,
    /// Denied; the linear rows have solutions, and whether the problem has one was not settled.
    Denied,
    /// Not solved, and there is nothing to be solved: proved as for the two above.
    InaccurateWithoutSolution,
    /// Not claimed: the point violates the assembled problem by no more than the solver's tolerance, but its certificate, which
    /// asks for more, does not hold.
    Unclaimed,
    /// Claimed solved, with a residual above 10⁻⁸ that is no more than the rounding of impulses which are this large: in other orders of
    /// summation it is another one.
    ClaimedRounded,
    /// Not claimed: the violations are those that the rounding of impulses makes which are this large. Double precision has no better
    /// point, or hardly one.
    Rounded,
    /// Not solved; not known whether there is a solution.
    Inaccurate,
    /// Not solved, although there is a solution.
    Missed,
    /// Denied, although there is a solution.
    WronglyDenied,
    /// Claimed solved, and it is not.
    FalselyClaimed,
    /// The solver panicked.
    Panicked,
    /// No answer within the limit.
    TimedOut,
}

impl Outcome {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 14] = [
        Self::Solved,
        Self::Infeasible,
        Self::NoSolution,
        Self::Denied,
        Self::InaccurateWithoutSolution,
        Self::Unclaimed,
        Self::ClaimedRounded,
        Self::Rounded,
        Self::Inaccurate,
        Self::Missed,
        Self::WronglyDenied,
        Self::FalselyClaimed,
        Self::Panicked,
        Self::TimedOut,
    ];

    /// Whether someone should look at it.
    pub fn is_failure(self) -> bool {
        self > Self::InaccurateWithoutSolution
    }
}

/// One problem.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Seed of its sequence.
    pub seed: u64,
    /// Place in the sequence.
    pub step: usize,
    /// Index in [`FAMILIES`].
    pub family: usize,
    /// Rows of its LCP.
    pub rows: usize,
    /// What became of it.
    pub outcome: Outcome,
    /// What the solver said.
    pub status: String,
    /// Its certificate.
    pub certificate: Certificate,
    /// The judge's residual.
    pub residual: f64,
    /// Whether Lemke's method was needed.
    pub lemke: bool,
    /// CPU time of the solver, s.
    pub seconds: f64,
}

/// Counts of one family.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Problems.
    pub problems: u64,
    /// Those that needed Lemke's method, and those of them that were solved.
    pub lemke: [u64; 2],
    /// Problems of each outcome.
    pub outcomes: BTreeMap<Outcome, u64>,
    /// The worst residual of a solved problem, with seed and step.
    pub worst: (f64, u64, usize),
    /// The longest time of a solve, s, with seed and step.
    pub slowest: (f64, u64, usize),
    /// How many solves took between 2^(k/8) and 2^((k+1)/8) ns.
    pub times: BTreeMap<u32, u64>,
}

impl Tally {
    /// Counts a problem.
    pub fn add(&mut self, trial: &Trial) {
        self.problems += 1;
        *self.outcomes.entry(trial.outcome).or_default() += 1;
        let solved = trial.outcome == Outcome::Solved;
        if trial.lemke {
            self.lemke[0] += 1;
            self.lemke[1] += u64::from(solved);
        }
        if solved && trial.residual > self.worst.0 {
            self.worst = (trial.residual, trial.seed, trial.step);
        }
        if trial.seconds > self.slowest.0 {
            self.slowest = (trial.seconds, trial.seed, trial.step);
        }
        let bucket = (1e9 * trial.seconds).max(1.0).log2() * PER_DOUBLING;
        *self.times.entry(bucket as u32).or_default() += 1;
    }

    /// Adds the counts of another tally.
    pub fn merge(&mut self, other: &Self) {
        self.problems += other.problems;
        (0..2).for_each(|k| self.lemke[k] += other.lemke[k]);
        for (outcome, count) in &other.outcomes {
            *self.outcomes.entry(*outcome).or_default() += count;
        }
        for (bucket, count) in &other.times {
            *self.times.entry(*bucket).or_default() += count;
        }
        for (mine, theirs) in [(&mut self.worst, other.worst), (&mut self.slowest, other.slowest)] {
            if theirs.0 > mine.0 {
                *mine = theirs;
            }
        }
    }

    /// Problems of an outcome.
    pub fn count(&self, outcome: Outcome) -> u64 {
        self.outcomes.get(&outcome).copied().unwrap_or(0)
    }

    /// The time, s, below which this share of the solves stays, to 9 %.
    pub fn time(&self, share: f64) -> f64 {
        let mut left = (share * self.problems as f64) as u64;
        for (&bucket, &count) in &self.times {
            if count > left {
                return 1e-9 * (f64::from(bucket + 1) / PER_DOUBLING).exp2();
            }
            left -= count;
        }
        self.slowest.0
    }
}

/// Prints outcomes, residuals and times by family, and of all together.
pub fn print_tables(tallies: &[Tally]) {
    let mut all = Tally::default();
    tallies.iter().for_each(|tally| all.merge(tally));
    let named: Vec<(&str, &Tally)> = FAMILIES.into_iter().zip(tallies).chain([("all", &all)]).collect();
    let met: Vec<Outcome> = Outcome::ALL.into_iter().filter(|&o| all.count(o) > 0).collect();
    let mut rows = vec![vec!["family".to_owned(), "problems".to_owned()]];
    rows[0].extend(met.iter().map(|o| format!("{o:?}")));
    let mut figures = vec![
        ["family", "worst residual", "Lemke", "solved by it", "median µs", "99.9 % µs", "worst µs", "seed, step"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (name, tally) in named {
        let mut row = vec![name.to_owned(), tally.problems.to_string()];
        row.extend(met.iter().map(|&o| tally.count(o).to_string()));
        rows.push(row);
        let micro = |seconds: f64| format!("{:.1}", 1e6 * seconds);
        figures.push(vec![
            name.to_owned(),
            format!("{:.1e}", tally.worst.0),
            tally.lemke[0].to_string(),
            tally.lemke[1].to_string(),
            micro(tally.time(0.5)),
            micro(tally.time(0.999)),
            micro(tally.slowest.0),
            format!("{}, {}", tally.slowest.1, tally.slowest.2),
        ]);
    }
    println!("{}\n{}", markdown(&rows), markdown(&figures));
}
