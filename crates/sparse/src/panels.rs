//! Row-major panels and the vectors they are read in.

use pulp::{Simd, bytemuck};

/// Sums in which the scalar product of a row is taken, for all widths of vectors: as many as the widest has.
pub const SUMS: usize = 8;

/// The columns of a panel from one on, and the distance between its rows.
#[derive(Clone, Copy)]
pub(super) struct Panel<'a> {
    pub data: &'a [f64],
    pub stride: usize,
}

impl<'a> Panel<'a> {
    /// The panel from a later column on.
    #[inline(always)]
    pub fn from(self, column: usize) -> Self {
        Self { data: &self.data[column.min(self.data.len())..], stride: self.stride }
    }

    /// `N` entries of a row.
    #[inline(always)]
    pub fn part<const N: usize>(&self, row: usize, first: usize) -> &'a [f64; N] {
        self.data[row * self.stride + first..].first_chunk().expect("the panel holds the block")
    }

    /// So many times [`SUMS`] entries of a row and what follows it.
    #[inline(always)]
    pub fn chunks(&self, row: usize, count: usize) -> &'a [[f64; SUMS]] {
        &self.data[row * self.stride..].as_chunks().0[..count]
    }

    /// The first entries of a row.
    #[inline(always)]
    pub fn row(&self, row: usize, length: usize) -> &'a [f64] {
        &self.data[row * self.stride..][..length]
    }
}

/// The same for a panel that is written.
pub(super) struct PanelMut<'a> {
    pub data: &'a mut [f64],
    pub stride: usize,
}

impl PanelMut<'_> {
    /// `N` entries of a row.
    #[inline(always)]
    pub fn part<const N: usize>(&mut self, row: usize, first: usize) -> &mut [f64; N] {
        self.data[row * self.stride + first..].first_chunk_mut().expect("the panel holds the block")
    }
}

/// The vector of a list that is as long.
#[inline(always)]
pub fn load<S: Simd>(_simd: S, data: &[f64]) -> S::f64s {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(data))
}

/// Writes a vector to a list that is as long.
#[inline(always)]
pub(super) fn store<S: Simd>(_simd: S, data: &mut [f64], x: S::f64s) {
    data.copy_from_slice(bytemuck::cast_slice(&[x]));
}

/// The vector of a list that may be shorter.
#[inline(always)]
pub(super) fn load_some<S: Simd>(simd: S, data: &[f64]) -> S::f64s {
    if data.len() == S::F64_LANES { load(simd, data) } else { simd.partial_load_f64s(data) }
}

/// Writes a vector as far as the list goes.
#[inline(always)]
pub(super) fn store_some<S: Simd>(simd: S, data: &mut [f64], x: S::f64s) {
    if data.len() == S::F64_LANES { store(simd, data, x) } else { simd.partial_store_f64s(data, x) }
}
