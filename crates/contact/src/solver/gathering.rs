//! Gathering the blocks of a mass matrix into those of the proximal system.

use super::island::Island;

/// Degrees of freedom up to which blocks are gathered: those of a free body.
const LARGEST: usize = 6;

/// Neighbouring blocks of the mass matrix that (nearly) the same rows move: a free body whose mass matrix is diagonal has six
/// blocks of one degree of freedom, and is one block of the system.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gathering {
    /// Rows that move each block of the mass matrix, and those that move it and its predecessor.
    rows: Vec<u32>,
    shared: Vec<u32>,
}

impl Gathering {
    /// Writes the first degree of freedom of each block of the system, and the total.
    pub fn find_blocks(&mut self, island: &Island, starts: &mut Vec<usize>) {
        starts.clear();
        let count = island.blocks.len();
        if island.starts.windows(3).all(|s| s[2] - s[0] > LARGEST) {
            starts.extend_from_slice(&island.starts);
            return;
        }
        self.count_rows(island, count);
        let mut begin = 0;
        starts.push(0);
        for k in 1..count {
            let alike = 4 * self.shared[k] >= 3 * self.rows[k - 1].max(self.rows[k]);
            if !alike || island.starts[k + 1] - begin > LARGEST {
                begin = island.starts[k];
                starts.push(begin);
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
