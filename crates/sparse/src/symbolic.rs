//! What the factors of a block-sparse matrix look like: computed once for a graph of blocks.

use super::ordering::Ordering;

/// Structure of the block LU factors of a matrix with a symmetric pattern.
///
/// "Position" is a block's place in the elimination order. Block column `k` of `L` and block row `k` of `U` have the same
/// pattern, the `rows` of position `k`. The transposed column and the row are row-major panels of `size(k)` rows and `height(k)`
/// columns, one for each degree of freedom of those blocks; the panel of the row begins with the diagonal block.
#[derive(Clone, Debug, Default)]
pub struct Symbolic {
    ordering: Ordering,
    /// What the present structure was computed for.
    starts: Vec<usize>,
    edges: Vec<(u32, u32)>,
    /// Position of each block.
    pub position: Vec<u32>,
    /// First degree of freedom of each position's block.
    pub first_dof: Vec<usize>,
    /// Its size.
    pub size: Vec<usize>,
    /// Where each position's rows begin in `rows`.
    pub offsets: Vec<usize>,
    /// Positions of the blocks below the diagonal, ascending.
    pub rows: Vec<u32>,
    /// First column of each entry of `rows` in the panel of `L`.
    pub row_start: Vec<usize>,
    /// Columns of each position's panel of `L`.
    pub height: Vec<usize>,
    /// Where each position's panel of `L` begins, and the total.
    pub panel: Vec<usize>,
    /// Where each position's block begins among the diagonal blocks, and the total.
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
        for (position, &node) in self.ordering.elimination.order.iter().enumerate() {
            let node = node as usize;
            self.position[node] = position as u32;
            self.first_dof.push(self.starts[node]);
            self.size.push(self.starts[node + 1] - self.starts[node]);
        }
        self.offsets.clone_from(&self.ordering.elimination.offsets);
        self.rows.clear();
        self.rows.extend(self.ordering.elimination.neighbours.iter().map(|&node| self.position[node as usize]));
        for k in 0..count {
            self.rows[self.offsets[k]..self.offsets[k + 1]].sort_unstable();
        }
    }

    fn place_panels(&mut self, count: usize) {
        let Self { offsets, rows, row_start, height, panel, diagonal, size, .. } = self;
        row_start.clear();
        height.clear();
        panel.clear();
        diagonal.clear();
        let (mut panel_end, mut diagonal_end) = (0, 0);
        for k in 0..count {
            panel.push(panel_end);
            diagonal.push(diagonal_end);
            let mut columns = 0;
            for &row in &rows[offsets[k]..offsets[k + 1]] {
                row_start.push(columns);
                columns += size[row as usize];
            }
            height.push(columns);
            panel_end += columns * size[k];
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

    /// Where the panel of position `k` begins in `U`; that of the number of positions is the total.
    pub fn upper_panel(&self, k: usize) -> usize {
        self.panel[k] + self.diagonal[k]
    }

    /// Columns of the panel of position `k` in `U`.
    pub fn width(&self, k: usize) -> usize {
        self.size[k] + self.height[k]
    }

    /// Where the blocks `a` and `b` meet in the panels of block `a`, which is eliminated first.
    pub fn place(&self, a: usize, b: usize) -> Place {
        let (k, row) = (self.position[a] as usize, self.position[b]);
        let range = self.offsets[k]..self.offsets[k + 1];
        let start = self.row_start[range.start + self.rows[range].partition_point(|&r| r < row)];
        Place {
            lower: self.panel[k] + start,
            lower_stride: self.height[k],
            upper: self.upper_panel(k) + self.size[k] + start,
            upper_stride: self.width(k),
        }
    }
}

/// A pair of blocks in the panels of `L` and `U`: where their first entry is, and the distance between the rows.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Place of the first entry in [`BlockLu::lower`](crate::BlockLu::lower).
    pub lower: usize,
    /// From one row there to the next.
    pub lower_stride: usize,
    /// Place of the first entry in [`BlockLu::upper`](crate::BlockLu::upper).
    pub upper: usize,
    /// From one row there to the next.
    pub upper_stride: usize,
}
