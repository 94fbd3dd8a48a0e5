//! Proofs that a problem has no solution.

use signorini::contact::GapContradiction;
use signorini::lcp::Exclusion;

/// A proof that there is no solution.
pub enum Denial {
    /// Gaps and bilateral rows contradict each other.
    Gaps(GapContradiction),
    /// No case of the complementarity problem has a solution.
    Cases(Exclusion),
}
