//! Many short lists in one piece of memory.

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
