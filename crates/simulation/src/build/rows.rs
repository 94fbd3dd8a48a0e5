//! Rows of equality constraints without what is rounding in them.

use signorini_multibody::EqualityBlock;

/// More rows than this are not looked at together as one dense system: what that takes grows with their square.
pub(crate) const MOST_DENSE_ROWS: usize = 128;

/// Entries of a block below this, relative to its largest one, are rounding, and so are all entries of a block, in m for a metre or a radian, where none is
/// above it: of the places that it ties, as of a point of a hinge's axis and what the hinge turns on, which for places of metres are told to 1e-16.
const ROUNDING: f64 = 1e-13;

/// Calls `push(row, columns, Θ)` for the rows of a block.
///
/// Entries that are rounding are zero. A row without entries, which no degree of freedom moves (the direction out of the plane
/// of a planar loop), is left out where its violation is within `tolerance`; else it has no columns and the problem no solution.
pub(crate) fn push_rows(block: &EqualityBlock, tolerance: f64, mut push: impl FnMut(usize, &mut Columns<'_>, f64)) {
    let largest = block.rows.columns.iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    let counts = |x: f64| largest > ROUNDING && x.abs() > ROUNDING * largest;
    for r in 0..block.count {
        let entries = block.rows.dofs.iter().zip(&block.rows.columns);
        let mut columns = entries.filter(|(_, c)| counts(c[r])).map(|(&k, c)| (k as u32, [c[r]])).peekable();
        if columns.peek().is_some() || block.violation[r].abs() > tolerance {
            push(r, &mut columns, block.violation[r]);
        }
    }
}

/// The columns of a row with their entries.
pub(crate) type Columns<'a> = dyn Iterator<Item = (u32, [f64; 1])> + 'a;
