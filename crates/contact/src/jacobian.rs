//! Sparse Jacobian rows.

/// Groups of `R` Jacobian rows, each group over its own few columns.
///
/// A contact is a group of three rows (normal, first tangent, second tangent: `J_N` and the two rows of `J_T`); a
/// bilateral constraint is a group of one. Only the degrees of freedom that move the two bodies have columns.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseRows<const R: usize> {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    entries: Vec<[f64; R]>,
}

impl<const R: usize> Default for SparseRows<R> {
    fn default() -> Self {
        Self { offsets: vec![0], columns: Vec::new(), entries: Vec::new() }
    }
}

impl<const R: usize> SparseRows<R> {
    /// Number of groups.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no groups.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes all groups and keeps the memory.
    pub fn clear(&mut self) {
        self.offsets.truncate(1);
        self.columns.clear();
        self.entries.clear();
    }

    /// Adds a group from its columns (strictly ascending) and, for each column, its `R` entries.
    pub fn push(&mut self, group: impl IntoIterator<Item = (u32, [f64; R])>) {
        // Both lists grow in one go where the length is known.
        let mut both = (std::mem::take(&mut self.columns), std::mem::take(&mut self.entries));
        both.extend(group);
        (self.columns, self.entries) = both;
        self.offsets.push(self.columns.len());
    }

    /// The columns of group `i` and the entries in them.
    #[inline]
    pub fn group(&self, i: usize) -> (&[u32], &[[f64; R]]) {
        let (start, end) = (self.offsets[i], self.offsets[i + 1]);
        (&self.columns[start..end], &self.entries[start..end])
    }

    /// `J_i x` for a vector over all degrees of freedom.
    #[inline]
    pub fn multiply(&self, i: usize, x: &[f64]) -> [f64; R] {
        let (columns, entries) = self.group(i);
        let mut y = [0.0; R];
        for (&column, entry) in columns.iter().zip(entries) {
            let x = x[column as usize];
            for r in 0..R {
                y[r] += entry[r] * x;
            }
        }
        y
    }

    /// The largest sum of absolute products in `J_i x`: what its rounding is relative to.
    #[inline]
    pub(crate) fn largest_terms(&self, i: usize, x: &[f64]) -> f64 {
        let (columns, entries) = self.group(i);
        let mut sums = [0.0; R];
        for (&column, entry) in columns.iter().zip(entries) {
            let x = x[column as usize].abs();
            for r in 0..R {
                sums[r] += entry[r].abs() * x;
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// `y += J_iᵀ p`.
    #[inline]
    pub fn add_transposed(&self, i: usize, p: [f64; R], y: &mut [f64]) {
        let (columns, entries) = self.group(i);
        for (&column, entry) in columns.iter().zip(entries) {
            let mut sum = 0.0;
            for r in 0..R {
                sum += entry[r] * p[r];
            }
            y[column as usize] += sum;
        }
    }

    /// The first column index of any group that is not below `nv`, with its group.
    pub(crate) fn column_beyond(&self, nv: usize) -> Option<(usize, usize)> {
        let k = self.columns.iter().position(|&c| c as usize >= nv)?;
        Some((self.offsets.partition_point(|&o| o <= k) - 1, self.columns[k] as usize))
    }

    /// The first column that does not exceed the one before it in its group, with its group.
    pub(crate) fn column_out_of_order(&self) -> Option<(usize, usize)> {
        let descent = |i: usize| self.group(i).0.windows(2).find(|pair| pair[1] <= pair[0]).map(|pair| pair[1]);
        (0..self.len()).find_map(|i| descent(i).map(|column| (i, column as usize)))
    }

    /// The first entry that is not finite, with its group.
    pub(crate) fn not_finite(&self) -> Option<(usize, f64)> {
        let bad = |e: &[f64; R]| e.iter().copied().find(|x| !x.is_finite());
        let (k, x) = self.entries.iter().enumerate().find_map(|(k, e)| bad(e).map(|x| (k, x)))?;
        Some((self.offsets.partition_point(|&o| o <= k) - 1, x))
    }
}
