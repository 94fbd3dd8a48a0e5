//! Gathering the blocks of a mass matrix into those of the proximal system, and cutting trees into branches.

use signorini_multibody::BlockDiagonal;
use signorini_sparse::FREE;

use crate::islands::{Island, block_of};

/// Neighbouring blocks of the mass matrix that (nearly) the same rows move: a free body whose mass matrix is diagonal has six
/// blocks of one degree of freedom, and is one block of the system.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gathering {
    /// Rows that move each block of the mass matrix, and those that move it and its predecessor.
    rows: Vec<u32>,
    shared: Vec<u32>,
}

impl Gathering {
    /// Writes the first degree of freedom of each block of the system, and the total; and the pairs of `branches` of one tree
    /// that the mass matrix couples, the one nearer to the root first.
    pub fn find_blocks(
        &mut self,
        mass: &BlockDiagonal,
        island: &Island,
        starts: &mut Vec<usize>,
        branches: &mut Vec<(u32, u32)>,
    ) {
        starts.clear();
        branches.clear();
        let count = island.blocks.len();
        let gathers = island.starts.windows(3).any(|s| s[2] - s[0] <= FREE);
        if gathers {
            self.count_rows(island, count);
        }
        let mut begin = 0;
        for k in 0..count {
            let (start, end) = (island.starts[k], island.starts[k + 1]);
            let joins = k > 0 && gathers && end - begin <= FREE && {
                // Most of them.
                2 * self.shared[k] > self.rows[k - 1].max(self.rows[k])
            };
            if !joins {
                begin = start;
                starts.push(start);
            }
            if end - start > FREE {
                cut_tree(mass, island, k, starts, branches);
            }
        }
        starts.push(island.nv());
    }

    fn count_rows(&mut self, island: &Island, count: usize) {
        for list in [&mut self.rows, &mut self.shared] {
            list.clear();
            list.resize(count, 0);
        }
        let contacts = (0..island.units.len()).map(|c| island.jacobian.group(c).0);
        let bilateral = (0..island.bilateral.len()).map(|k| island.bilateral_jacobian.group(k).0);
        for columns in contacts.chain(bilateral) {
            // Columns ascend; blocks are mostly followed by the next one.
            let (mut block, mut end, mut follows) = (0, 0, false);
            for &column in columns {
                let column = column as usize;
                if column < end {
                    continue;
                }
                let next =
                    if follows && column < island.starts[block + 2] { block + 1 } else { island.block_of(column) };
                self.shared[next] += u32::from(follows && next == block + 1);
                self.rows[next] += 1;
                (block, end) = (next, island.starts[next + 1]);
                follows = next + 1 < island.blocks.len();
            }
        }
    }
}

/// Begins a block wherever a branch of a tree begins or forks, after the block that begins with the tree; and finds which of them
/// are on each other's way to the root.
fn cut_tree(
    mass: &BlockDiagonal,
    island: &Island,
    tree: usize,
    starts: &mut Vec<usize>,
    branches: &mut Vec<(u32, u32)>,
) {
    let (start, global) = (island.starts[tree], island.global_starts[tree]);
    let previous = |dof: usize| mass.previous(dof - start + global).map(|before| before - global + start);
    let first = starts.len() - 1;
    for dof in start + 1..island.starts[tree + 1] {
        let before = previous(dof);
        if before != Some(dof - 1) {
            starts.push(dof);
            starts.extend(before.map(|before| before + 1));
        }
    }
    if starts.len() == first + 1 {
        return;
    }
    starts[first..].sort_unstable();
    starts.dedup();
    join_short(starts, first, island.starts[tree + 1]);
    for block in first..starts.len() {
        let mut on_way = previous(starts[block]);
        while let Some(dof) = on_way {
            let nearer = block_of(starts, dof);
            branches.push((nearer as u32, block as u32));
            on_way = previous(starts[nearer]);
        }
    }
}

/// Joins neighbouring branches from the `first` one on that are short beside their tree, which ends at `end`. Where it has many of them, a row that
/// moves it has a pair for each two on its way: branches of the root of its length are as many as they are long.
fn join_short(starts: &mut Vec<usize>, first: usize, end: usize) {
    let most = (end - starts[first]).isqrt();
    let mut kept = first + 1;
    for k in first + 1..starts.len() {
        let next = starts.get(k + 1).copied().unwrap_or(end);
        if next - starts[kept - 1] > most {
            starts[kept] = starts[k];
            kept += 1;
        }
    }
    starts.truncate(kept);
}
