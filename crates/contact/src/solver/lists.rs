//! Many short lists in one piece of memory, and whether lists are the same.

use std::ops::{BitOr, BitXor};

/// Lists of numbers, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// Reads pairs of a list, one of `lists`, and an item, which `visit` gives twice in the same order.
    pub(super) fn fill(&mut self, lists: usize, visit: impl Fn(&mut dyn FnMut(usize, u32))) {
        self.starts.clear();
        self.starts.resize(lists + 1, 0);
        visit(&mut |list, _| self.starts[list + 1] += 1);
        for k in 0..lists {
            self.starts[k + 1] += self.starts[k];
        }
        self.items.clear();
        self.items.resize(self.starts[lists] as usize, 0);
        let (starts, items) = (&mut self.starts, &mut self.items);
        visit(&mut |list, item| {
            items[starts[list] as usize] = item;
            starts[list] += 1;
        });
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// The items of a list.
    pub(super) fn get(&self, list: usize) -> &[u32] {
        &self.items[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}

/// Whether two lists have the same numbers. Without a branch for each, and without `memcmp`: lists are short and mostly the same.
#[inline]
pub(super) fn same<T>(a: &[T], b: &[T]) -> bool
where
    T: Copy + Default + PartialEq + BitXor<Output = T> + BitOr<Output = T>,
{
    a.len() == b.len() && a.iter().zip(b).fold(T::default(), |bits, (a, b)| bits | (*a ^ *b)) == T::default()
}

/// Whether two lists have the same numbers to the bit.
#[inline]
pub(super) fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |bits, (a, b)| bits | (a.to_bits() ^ b.to_bits())) == 0
}
