//! What is kept of each problem.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A problem counts as solved up to this natural-map residual in one unit (formulation §8).
pub const SOLVED: f64 = 1e-8;

/// How a solve ended, for our solver and the peers alike.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// The solver's own word: `Solved`, `Ray`, `Infeasible`, …, `done`, `time-out`, `crash`.
    pub status: String,
    /// Whether the solver claims a solution.
    pub claims: bool,
    /// Natural-map residual of its point, computed by the benchmark; absent without a point.
    pub residual: Option<f64>,
    /// Median time, s; absent where it did not end.
    pub seconds: Option<f64>,
    /// Number of solves.
    pub repetitions: usize,
}

impl Outcome {
    /// Whether its point solves the problem, whatever the solver says.
    pub fn solves(&self) -> bool {
        self.residual.is_some_and(|r| r <= SOLVED)
    }

    /// Whether it claims a solution that is none.
    pub fn is_wrong(&self) -> bool {
        self.claims && !self.solves()
    }
}

/// How a peer's solve ended.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PeerRecord {
    /// The outcome of the attempt that counts.
    pub outcome: Outcome,
    /// Whether that was the second attempt, on the problem in one unit.
    pub scaled: bool,
}

/// One problem with everybody's outcome.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Record {
    /// The problem's [label](super::Spec::label).
    pub name: String,
    /// Family that results are gathered by.
    pub family: String,
    /// Whether it belongs to a series of growing size.
    pub growth: bool,
    /// Number of contacts; 0 for plain LCPs.
    pub contacts: usize,
    /// Degrees of freedom; 0 for plain LCPs.
    pub nv: usize,
    /// Friction directions of each contact.
    pub directions: usize,
    /// Size of the standard LCP.
    pub size: usize,
    /// Whether theory promises a solution (no gap is negative).
    pub promised: bool,
    /// Whether it is made so that it has none.
    pub contradicts_itself: bool,
    /// Our solver without a start.
    pub cold: Outcome,
    /// Our solver from its own solution.
    pub warm: Outcome,
    /// Worst residual of our certificate.
    pub certificate: Option<f64>,
    /// Our solver on the same problem with negative gaps set to 0, where it denies this one.
    pub opened: Option<Outcome>,
    /// Rows of the active block of a solution.
    pub active: Option<usize>,
    /// Median time of one dense LU of the active block with `signorini_lcp::linalg::Lu`, s.
    pub lu_seconds: Option<f64>,
    /// The peers by name.
    pub peers: BTreeMap<String, PeerRecord>,
    /// Why something was left out, if anything.
    pub left_out: Option<String>,
}

impl Record {
    /// Whether somebody's point solves it.
    pub fn is_solved_by_anyone(&self) -> bool {
        self.cold.solves() || self.warm.solves() || self.peers.values().any(|peer| peer.outcome.solves())
    }

    /// Whether it has a solution, by theory or because somebody found one.
    pub fn is_solvable(&self) -> bool {
        !self.contradicts_itself && (self.promised || self.is_solved_by_anyone())
    }

    /// Whether our solver says that there is no solution.
    pub fn is_denied(&self) -> bool {
        ["Ray", "Infeasible"].contains(&self.cold.status.as_str())
    }
}
