//! Which blocks of the mass matrix rows join.

use signorini_contact::ContactProblem;

/// Union–find over the blocks of the mass matrix.
#[derive(Clone, Debug, Default)]
pub(super) struct JoinedBlocks {
    /// For every block the first one that it is joined with.
    pub root: Vec<u32>,
    /// Whether a row's first column is in the block.
    pub touched: Vec<bool>,
}

impl JoinedBlocks {
    /// Joins the blocks that the rows of a problem move together.
    pub fn join(&mut self, problem: &ContactProblem) {
        let blocks = problem.mass.blocks().len();
        self.root.clear();
        self.root.extend(0..blocks as u32);
        self.touched.clear();
        self.touched.resize(blocks, false);
        let mut last: &[u32] = &[];
        for i in 0..problem.contact_count() {
            // Neighbours mostly belong to the same two bodies.
            let columns = problem.jacobian.group(i).0;
            if columns != last {
                self.join_columns(problem, columns);
                last = columns;
            }
        }
        let groups = &problem.friction_groups;
        for j in 0..groups.len() {
            let columns = groups.jacobian.group(j).0;
            self.join_columns(problem, columns);
            if let Some((contact, _)) = groups.bound[j].normal()
                && let (Some(&a), Some(&b)) = (columns.first(), problem.jacobian.group(contact).0.first())
            {
                self.join_pair(problem.mass.block_of(a as usize), problem.mass.block_of(b as usize));
            }
        }
        for i in 0..problem.bilateral_violation.len() {
            self.join_columns(problem, problem.bilateral_jacobian.group(i).0);
        }
        for k in 0..blocks {
            // Roots come first: that of block k's root is known.
            self.root[k] = self.root[self.root[k] as usize];
        }
    }

    /// Joins the blocks that ascending columns lie in.
    fn join_columns(&mut self, problem: &ContactProblem, columns: &[u32]) {
        let (Some(&first), Some(&last)) = (columns.first(), columns.last()) else { return };
        let blocks = problem.mass.blocks();
        let mut block = problem.mass.block_of(first as usize);
        self.touched[block] = true;
        let mut end = blocks[block].range().end;
        if (last as usize) < end {
            return;
        }
        for &column in columns {
            if column as usize >= end {
                let next = problem.mass.block_of(column as usize);
                self.join_pair(block, next);
                (block, end) = (next, blocks[next].range().end);
            }
        }
    }

    fn join_pair(&mut self, first: usize, second: usize) {
        if self.root[first] == self.root[second] {
            return;
        }
        let (a, b) = (self.find_root(first as u32), self.find_root(second as u32));
        self.root[a.max(b) as usize] = a.min(b);
    }

    fn find_root(&mut self, mut k: u32) -> u32 {
        while self.root[k as usize] != k {
            self.root[k as usize] = self.root[self.root[k as usize] as usize];
            k = self.root[k as usize];
        }
        k
    }
}
