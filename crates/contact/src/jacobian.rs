//! Sparse Jacobian rows.

use crate::lists::raise;

/// Degrees of freedom of a free body. Rows mostly have all of a body's columns or none: these are taken together.
const FREE: usize = 6;

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

    /// Adds a group from its columns and, for each column, its `R` entries. Columns in any order are put in ascending order; what comes
    /// twice for one column is added up.
    pub fn push(&mut self, group: impl IntoIterator<Item = (u32, [f64; R])>) {
        // Both lists grow in one go where the length is known.
        let mut both = (std::mem::take(&mut self.columns), std::mem::take(&mut self.entries));
        let start = both.0.len();
        both.extend(group);
        (self.columns, self.entries) = both;
        if !self.columns[start..].is_sorted_by(|a, b| a < b) {
            self.put_in_order(start);
        }
        self.offsets.push(self.columns.len());
    }

    /// Makes the columns from `start` on strictly ascending.
    #[cold]
    fn put_in_order(&mut self, start: usize) {
        let entries = self.entries.drain(start..);
        let mut group: Vec<(u32, [f64; R])> = self.columns.drain(start..).zip(entries).collect();
        group.sort_by_key(|(column, _)| *column);
        for (column, entry) in group {
            if self.columns[start..].last() == Some(&column) {
                let known = &mut self.entries[self.columns.len() - 1];
                known.iter_mut().zip(entry).for_each(|(sum, e)| *sum += e);
            } else {
                self.columns.push(column);
                self.entries.push(entry);
            }
        }
    }

    /// Adds a group with these entries in columns that are numbered otherwise, in the order in which they are given.
    pub fn push_renumbered(&mut self, columns: impl Iterator<Item = u32>, entries: &[[f64; R]]) {
        self.columns.extend(columns);
        self.entries.extend_from_slice(entries);
        self.offsets.push(self.columns.len());
    }

    /// Where each group begins among all columns, and the columns.
    pub fn pattern(&self) -> (&[usize], &[u32]) {
        (&self.offsets, &self.columns)
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
        if let Some((start, entries)) = one_body(columns, entries) {
            let x = &x[start..start + FREE];
            let mut y = [0.0; R];
            for k in 0..FREE {
                for r in 0..R {
                    y[r] += entries[k][r] * x[k];
                }
            }
            return y;
        }
        multiply(columns, entries, x)
    }

    /// The columns of group `i`, and the entries in them with all that follow.
    #[inline(always)]
    pub fn group_and_rest(&self, i: usize) -> (&[u32], &[f64]) {
        let (start, end) = (self.offsets[i], self.offsets[i + 1]);
        (&self.columns[start..end], self.entries[start..].as_flattened())
    }

    /// `J_i x` for two vectors at a time, given as pairs.
    #[inline]
    pub fn multiply_pairs(&self, i: usize, x: &[[f64; 2]]) -> [[f64; 2]; R] {
        let (columns, entries) = self.group(i);
        let mut y = [[0.0; 2]; R];
        let mut take = |entry: &[f64; R], x: [f64; 2]| {
            for r in 0..R {
                y[r] = [y[r][0] + entry[r] * x[0], y[r][1] + entry[r] * x[1]];
            }
        };
        if let Some((start, entries)) = one_body(columns, entries) {
            let x = &x[start..start + FREE];
            (0..FREE).for_each(|k| take(&entries[k], x[k]));
        } else {
            columns.iter().zip(entries).for_each(|(&column, entry)| take(entry, x[column as usize]));
        }
        y
    }

    /// `J_i x`, and the largest sum of absolute products in it: what its rounding is relative to.
    #[inline]
    pub fn multiply_with_terms(&self, i: usize, x: &[f64]) -> ([f64; R], f64) {
        let (columns, entries) = self.group(i);
        let (mut y, mut sums) = ([0.0; R], [0.0; R]);
        let mut take = |entry: &[f64; R], x: f64| {
            for r in 0..R {
                let term = entry[r] * x;
                y[r] += term;
                sums[r] += f64::abs(term);
            }
        };
        if let Some((start, entries)) = one_body(columns, entries) {
            let x = &x[start..start + FREE];
            (0..FREE).for_each(|k| take(&entries[k], x[k]));
        } else {
            columns.iter().zip(entries).for_each(|(&column, entry)| take(entry, x[column as usize]));
        }
        let mut largest = 0.0;
        sums.into_iter().for_each(|sum| raise(&mut largest, sum));
        (y, largest)
    }

    /// `y += J_iᵀ p`.
    #[inline]
    pub fn add_transposed(&self, i: usize, p: [f64; R], y: &mut [f64]) {
        let (columns, entries) = self.group(i);
        if let Some((start, entries)) = one_body(columns, entries) {
            let y = &mut y[start..start + FREE];
            for k in 0..FREE {
                let mut sum = 0.0;
                for r in 0..R {
                    sum += entries[k][r] * p[r];
                }
                y[k] += sum;
            }
            return;
        }
        add_transposed(columns, entries, p, y);
    }

    /// `y += |J_i|ᵀ |p|`: the magnitudes of what [`add_transposed`](Self::add_transposed) adds up.
    pub fn add_terms_transposed(&self, i: usize, p: [f64; R], y: &mut [f64]) {
        let (columns, entries) = self.group(i);
        for (&column, entry) in columns.iter().zip(entries) {
            y[column as usize] += entry.iter().zip(p).map(|(e, p)| (e * p).abs()).sum::<f64>();
        }
    }

    /// The first column index of any group that is not below `nv`, with its group.
    pub fn column_beyond(&self, nv: usize) -> Option<(usize, usize)> {
        let k = self.columns.iter().position(|&c| c as usize >= nv)?;
        Some((self.offsets.partition_point(|&o| o <= k) - 1, self.columns[k] as usize))
    }

    /// The first column that does not exceed the one before it in its group, with its group.
    pub fn column_out_of_order(&self) -> Option<(usize, usize)> {
        let descent = |i: usize| self.group(i).0.windows(2).find(|pair| pair[1] <= pair[0]).map(|pair| pair[1]);
        (0..self.len()).find_map(|i| descent(i).map(|column| (i, column as usize)))
    }

    /// The first entry that is not finite, with its group.
    pub fn not_finite(&self) -> Option<(usize, f64)> {
        let bad = |e: &[f64; R]| e.iter().copied().find(|x| !x.is_finite());
        let (k, x) = self.entries.iter().enumerate().find_map(|(k, e)| bad(e).map(|x| (k, x)))?;
        Some((self.offsets.partition_point(|&o| o <= k) - 1, x))
    }
}

/// The first column and the entries of rows that have all columns of one free body and no others. (Columns ascend, so that
/// six of them follow one another where the last is five after the first.)
#[inline]
fn one_body<'a, const R: usize>(columns: &[u32], entries: &'a [[f64; R]]) -> Option<(usize, &'a [[f64; R]; FREE])> {
    let columns: &[u32; FREE] = columns.try_into().ok()?;
    let entries: &[[f64; R]; FREE] = entries.try_into().ok()?;
    let first = columns[0] as usize;
    (columns[FREE - 1] as usize == first + FREE - 1).then_some((first, entries))
}

/// `J x` for one group of rows. Apart, so that the short way for one body saves no registers.
#[inline(never)]
fn multiply<const R: usize>(columns: &[u32], entries: &[[f64; R]], x: &[f64]) -> [f64; R] {
    let mut y = [0.0; R];
    let mut take = |entry: &[f64; R], x: f64| {
        for r in 0..R {
            y[r] += entry[r] * x;
        }
    };
    let ((bodies, rest), (body_entries, rest_entries)) = (columns.as_chunks::<FREE>(), entries.as_chunks::<FREE>());
    for (columns, entries) in bodies.iter().zip(body_entries) {
        if let Some((start, entries)) = one_body(columns, entries) {
            let x = &x[start..start + FREE];
            (0..FREE).for_each(|k| take(&entries[k], x[k]));
        } else {
            (0..FREE).for_each(|k| take(&entries[k], x[columns[k] as usize]));
        }
    }
    rest.iter().zip(rest_entries).for_each(|(&column, entry)| take(entry, x[column as usize]));
    y
}

/// `y += Jᵀ p` for one group of rows. Apart for the same reason.
#[inline(never)]
fn add_transposed<const R: usize>(columns: &[u32], entries: &[[f64; R]], p: [f64; R], y: &mut [f64]) {
    let along = |entry: &[f64; R]| {
        let mut sum = 0.0;
        for r in 0..R {
            sum += entry[r] * p[r];
        }
        sum
    };
    let ((bodies, rest), (body_entries, rest_entries)) = (columns.as_chunks::<FREE>(), entries.as_chunks::<FREE>());
    for (columns, entries) in bodies.iter().zip(body_entries) {
        if let Some((start, entries)) = one_body(columns, entries) {
            let y = &mut y[start..start + FREE];
            (0..FREE).for_each(|k| y[k] += along(&entries[k]));
        } else {
            (0..FREE).for_each(|k| y[columns[k] as usize] += along(&entries[k]));
        }
    }
    rest.iter().zip(rest_entries).for_each(|(&column, entry)| y[column as usize] += along(entry));
}
