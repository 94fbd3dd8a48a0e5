//! Whether lists are the same, and the largest of their numbers.

use std::ops::{BitOr, BitXor};

/// Whether two lists have the same numbers. Without a branch for each, and without `memcmp`: lists are short and mostly the same.
#[inline]
pub fn same<T>(a: &[T], b: &[T]) -> bool
where
    T: Copy + Default + PartialEq + BitXor<Output = T> + BitOr<Output = T>,
{
    a.len() == b.len() && a.iter().zip(b).fold(T::default(), |bits, (a, b)| bits | (*a ^ *b)) == T::default()
}

/// Whether two lists have the same numbers to the bit.
#[inline]
pub fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |bits, (a, b)| bits | (a.to_bits() ^ b.to_bits())) == 0
}

/// Keeps the larger value in one instruction, unlike `f64::max`; what is no number is left out.
#[inline]
pub fn raise(largest: &mut f64, value: f64) {
    *largest = if value > *largest { value } else { *largest };
}
