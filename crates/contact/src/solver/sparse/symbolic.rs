//! What the factors of a block-sparse matrix look like: computed once for a graph of blocks.

use super::ordering::Ordering;

/// Structure of the block LU factors of a matrix with a symmetric pattern.
///
/// "Position" is a block's place in the elimination order. Block column `k` of `L` and block row `k` of `U` have the same
/// pattern, the `rows` of position `k`; both are kept as panels of `height(k)` rows (one for each degree of freedom of those
/// blocks) and `size(k)` columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symbolic {
    ordering: Ordering,
    /// What the present structure was computed for.
    starts: Vec<usize>,
    edges: Vec<(u32, u32)>,
    /// Position of each block.
    pub position: Vec<u32>,
    /// First degree of freedom of each position's block, and its size.
    pub first_dof: Vec<usize>,
    pub size: Vec<usize>,
    /// Where each position's rows begin in `rows`.
    pub offsets: Vec<usize>,
    /// Positions of the blocks below the diagonal, ascending.
    pub rows: Vec<u32>,
    /// First panel row of each entry of `rows`.
    pub row_start: Vec<usize>,
    /// Where each position's panel begins, in both `L` and `U`, and the total.
    pub panel: Vec<usize>,
    /// Where each position's diagonal block begins, and the total.
    pub diagonal: Vec<usize>,
    /// Where each position's updates begin in `updates`.
    pub update_offsets: Vec<usize>,
    /// For position `j`: the entries of `rows` that are `j`, with the position whose rows they belong to.
    pub updates: Vec<(u32, usize)>,
    cursor: Vec<usize>,
}

impl Symbolic {
    /// Analyses the graph of blocks, unless it is the one analysed last. `starts`: first degree of freedom of each block, and
    /// the total; `edges`: pairs of coupled blocks, each with the smaller index first.
    pub fn analyse(&mut self, starts: &[usize], edges: &[(u32, u32)]) {
        if self.starts == starts && self.edges == edges {
            return;
        }
        self.starts.clear();
        self.starts.extend_from_slice(starts);
        self.edges.clear();
        self.edges.extend_from_slice(edges);
        let count = starts.len() - 1;
        self.ordering.find(count, edges);
        self.place_blocks(count);
        self.place_panels(count);
        self.find_updates(count);
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.size.len()
    }

    fn place_blocks(&mut self, count: usize) {
        self.position.clear();
        self.position.resize(count, 0);
        self.first_dof.clear();
        self.size.clear();
        for (position, &node) in self.ordering.order.iter().enumerate() {
            let node = node as usize;
            self.position[node] = position as u32;
            self.first_dof.push(self.starts[node]);
            self.size.push(self.starts[node + 1] - self.starts[node]);
        }
        self.offsets.clone_from(&self.ordering.offsets);
        self.rows.clear();
        self.rows.extend(self.ordering.neighbours.iter().map(|&node| self.position[node as usize]));
        for k in 0..count {
            self.rows[self.offsets[k]..self.offsets[k + 1]].sort_unstable();
        }
    }

    fn place_panels(&mut self, count: usize) {
        let Self { offsets, rows, row_start, panel, diagonal, size, .. } = self;
        row_start.clear();
        panel.clear();
        diagonal.clear();
        let (mut panel_end, mut diagonal_end) = (0, 0);
        for k in 0..count {
            panel.push(panel_end);
            diagonal.push(diagonal_end);
            let mut height = 0;
            for &row in &rows[offsets[k]..offsets[k + 1]] {
                row_start.push(height);
                height += size[row as usize];
            }
            panel_end += height * size[k];
            diagonal_end += size[k] * size[k];
        }
        panel.push(panel_end);
        diagonal.push(diagonal_end);
    }

    fn find_updates(&mut self, count: usize) {
        let Self { offsets, rows, update_offsets, updates, cursor, .. } = self;
        update_offsets.clear();
        update_offsets.resize(count + 1, 0);
        rows.iter().for_each(|&row| update_offsets[row as usize + 1] += 1);
        for k in 0..count {
            update_offsets[k + 1] += update_offsets[k];
        }
        cursor.clone_from(update_offsets);
        updates.clear();
        updates.resize(rows.len(), (0, 0));
        for k in 0..count {
            for entry in offsets[k]..offsets[k + 1] {
                let row = rows[entry] as usize;
                updates[cursor[row]] = (k as u32, entry);
                cursor[row] += 1;
            }
        }
    }

    /// Where the panel row of the first degree of freedom of block `b` begins in the panel of block `a`, `a` being
    /// eliminated first and the two being coupled.
    pub fn block_in_panel(&self, a: usize, b: usize) -> usize {
        let (k, row) = (self.position[a] as usize, self.position[b]);
        let range = self.offsets[k]..self.offsets[k + 1];
        let entry = range.start + self.rows[range].partition_point(|&r| r < row);
        self.panel[k] + self.row_start[entry] * self.size[k]
    }
}
