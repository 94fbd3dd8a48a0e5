//! Where the entries of a block-diagonal matrix are, shared by the matrix and its factor.

use std::ops::Range;

/// A dense block on the diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// First degree of freedom.
    pub start: usize,
    /// Number of degrees of freedom.
    pub size: usize,
    /// Where its entries begin in the matrix's data.
    pub offset: usize,
}

impl Block {
    /// The degrees of freedom it covers.
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.size
    }

    pub(crate) fn data_range(&self) -> Range<usize> {
        self.offset..self.offset + self.size * self.size
    }
}

/// The blocks, and which rows a row is coupled with: those on its way to the root and those that have it on theirs.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub blocks: Vec<Block>,
    /// For every degree of freedom its block.
    pub block_of: Vec<usize>,
    /// The next row on the way to the root.
    previous: Vec<Option<usize>>,
    /// The first of the neighbouring rows that follow each other on the way to the root and end with this one.
    run_start: Vec<usize>,
    /// One after the last row that has this one on its way to the root, or after the row itself.
    pub end: Vec<usize>,
}

impl Layout {
    /// The smallest blocks of consecutive rows in which row `i` has entries from column `reach[i]` on, every row of a block
    /// coupled with every other.
    pub fn full(reach: &[usize]) -> Self {
        let n = reach.len();
        let (mut blocks, mut block_of) = (Vec::new(), vec![0; n]);
        // Going up from the last row, a block ends where no row below reaches further up.
        let (mut end, mut top) = (n, n);
        for i in (0..n).rev() {
            top = top.min(reach[i]).min(i);
            if top == i {
                blocks.push(Block { start: i, size: end - i, offset: 0 });
                end = i;
            }
        }
        blocks.reverse();
        let mut entries = 0;
        for (b, block) in blocks.iter_mut().enumerate() {
            block.offset = entries;
            entries += block.size * block.size;
            block_of[block.range()].fill(b);
        }
        let rows = || blocks.iter().flat_map(|block| block.range().map(move |k| (k, block)));
        let previous: Vec<_> = rows().map(|(k, block)| k.checked_sub(1).filter(|&p| p >= block.start)).collect();
        let end = rows().map(|(_, block)| block.start + block.size).collect();
        Self { run_start: run_starts(&previous), blocks, block_of, previous, end }
    }

    /// One block per tree, given for every degree of freedom the one before it on the way to the root. (Trees whose degrees
    /// of freedom interleave, which happens only if bodies are not added tree by tree, share a block.)
    pub fn of_tree(dof_parent: &[Option<usize>]) -> Self {
        let reach: Vec<usize> = dof_parent.iter().enumerate().map(|(k, parent)| parent.unwrap_or(k)).collect();
        let mut end: Vec<usize> = (1..=dof_parent.len()).collect();
        for k in (0..end.len()).rev() {
            if let Some(parent) = dof_parent[k] {
                end[parent] = end[parent].max(end[k]);
            }
        }
        Self { run_start: run_starts(dof_parent), previous: dof_parent.to_vec(), end, ..Self::full(&reach) }
    }

    /// Number of entries of all blocks.
    pub fn entries(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.data_range().end)
    }

    /// The blocks that ascending columns lie in: each by its index, with the places of its columns among all of these.
    pub fn blocks_touched<'a>(&'a self, columns: &'a [u32]) -> impl Iterator<Item = (usize, Range<usize>)> + 'a {
        let mut first = 0;
        std::iter::from_fn(move || {
            let index = self.block_of[*columns.get(first)? as usize];
            let end = self.blocks[index].range().end;
            let own = first..first + columns[first..].partition_point(|&column| (column as usize) < end);
            first = own.end;
            Some((index, own))
        })
    }

    /// The row before row `k` on its way to the root.
    pub fn previous(&self, k: usize) -> Option<usize> {
        self.previous[k]
    }

    /// The first of the neighbouring rows that follow each other on the way to the root and end with row `k`.
    pub fn run_start(&self, k: usize) -> usize {
        self.run_start[k]
    }

    /// One after the last row that is coupled with row `k`.
    pub fn end(&self, k: usize) -> usize {
        self.end[k]
    }
}

fn run_starts(previous: &[Option<usize>]) -> Vec<usize> {
    let mut starts = Vec::with_capacity(previous.len());
    for (k, &before) in previous.iter().enumerate() {
        let follows = before.is_some_and(|before| before + 1 == k);
        starts.push(if follows { starts[k - 1] } else { k });
    }
    starts
}
