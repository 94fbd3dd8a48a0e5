//! Delassus diagonals of contacts and friction groups on robots, many rows at a time.
//!
//! A row on a robot has its half solve with the factor of the robot's block. One by one these wait for themselves; side by side they are
//! columns of few numbers each, in the processor's widest vectors, and have the same bits.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use signorini_contact::ContactProblem;
use signorini_contact::scales::{FREE_ROWS, largest};
use signorini_lcp::linalg::SHORT;
use signorini_multibody::{Block, BlockCholesky, FEW_ROWS, LANES};

/// Columns that are solved at a time, as many as a robot may have rows: both fit into the nearest cache.
const COLUMNS: usize = FEW_ROWS;

/// The contacts and groups that touch blocks of robots; memory is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct RobotRows {
    units: Vec<RobotUnit>,
    /// Their parts, block by block.
    parts: Vec<Part>,
    columns: Columns,
}

/// A contact or group with rows on a robot.
#[derive(Clone, Copy, Debug)]
struct RobotUnit {
    /// Its number in the problem.
    unit: u32,
    /// Whether its diagonal is asked for.
    is_wanted: bool,
    diagonal: [f64; 3],
}

/// What a unit has in one block.
#[derive(Clone, Copy, Debug)]
struct Part {
    block: u32,
    /// Its place in the list of units.
    unit: u32,
    /// The first of its entries there, and the one after the last.
    entries: [u32; 2],
}

/// Columns of one block that are solved together.
#[derive(Clone, Debug, Default)]
struct Columns {
    /// The unit and the component of each column.
    owners: Vec<(u32, u32)>,
    /// `[size, COLUMNS]`.
    half: Vec<f64>,
    squares: Vec<f64>,
}

/// Whether a block of the mass matrix is a robot's, of a size that this is for.
fn is_robot(block: &Block) -> bool {
    (FREE_ROWS + 1..=FEW_ROWS).contains(&block.size)
}

impl RobotRows {
    /// Finds the parts of a problem; `mark` is told every unit that has one.
    pub fn find(&mut self, problem: &ContactProblem, mut mark: impl FnMut(usize)) {
        self.units.clear();
        self.parts.clear();
        if !problem.mass.blocks().iter().any(is_robot) {
            return;
        }
        let contacts = problem.contact_count();
        for unit in 0..contacts + problem.friction_groups.len() {
            let columns = columns_of(problem, unit);
            let before = self.parts.len();
            let mut first = 0;
            while first < columns.len() {
                let block = problem.mass.block_of(columns[first] as usize);
                let end = problem.mass.blocks()[block].range().end;
                let last = first + columns[first..].partition_point(|&column| (column as usize) < end);
                if is_robot(&problem.mass.blocks()[block]) {
                    let entries = [first as u32, last as u32];
                    self.parts.push(Part { block: block as u32, unit: self.units.len() as u32, entries });
                }
                first = last;
            }
            if self.parts.len() > before {
                let unit = unit as u32;
                self.units.push(RobotUnit { unit, is_wanted: true, diagonal: [0.0; 3] });
                mark(unit as usize);
            }
        }
        // No two are equal, and a stable sort would allocate.
        self.parts.sort_unstable_by_key(|part| (part.block, part.unit));
    }

    /// Every unit, and the largest diagonal entry of its Delassus block if it was measured last.
    pub fn all(&self) -> impl Iterator<Item = (usize, Option<f64>)> {
        self.units.iter().map(|one| (one.unit as usize, one.is_wanted.then(|| largest(one.diagonal))))
    }

    /// Measures every unit that is `wanted`.
    /// - `scratch`: as for [`ContactProblem::delassus_diagonal`]
    pub fn measure(&mut self, problem: &ContactProblem, scratch: &mut [f64], mut wanted: impl FnMut(usize) -> bool) {
        let contacts = problem.contact_count();
        let others = |block: usize| !is_robot(&problem.mass.blocks()[block]);
        for one in &mut self.units {
            one.is_wanted = wanted(one.unit as usize);
            if !one.is_wanted {
                continue;
            }
            one.diagonal = match (one.unit as usize).checked_sub(contacts) {
                None => {
                    let (columns, entries) = problem.jacobian.group(one.unit as usize);
                    problem.delassus_in_blocks(columns, entries, scratch, others)
                }
                Some(j) => {
                    let (columns, entries) = problem.friction_groups.jacobian.group(j);
                    let [a, b] = problem.delassus_in_blocks(columns, entries, scratch, others);
                    [a, b, 0.0]
                }
            };
        }
        self.add_robots(problem);
    }

    fn add_robots(&mut self, problem: &ContactProblem) {
        let Self { units, parts, columns, .. } = self;
        let mut block = usize::MAX;
        for part in &*parts {
            let owner = units[part.unit as usize];
            if !owner.is_wanted {
                continue;
            }
            if part.block as usize != block || columns.owners.len() + 3 > COLUMNS {
                columns.finish(&problem.mass_factor, block, units);
                block = part.block as usize;
                columns.begin(&problem.mass.blocks()[block]);
            }
            let start = problem.mass.blocks()[block].start;
            let entries = part.entries[0] as usize..part.entries[1] as usize;
            match (owner.unit as usize).checked_sub(problem.contact_count()) {
                None => columns.push(part.unit, start, problem.jacobian.group(owner.unit as usize), entries),
                Some(j) => columns.push(part.unit, start, problem.friction_groups.jacobian.group(j), entries),
            }
        }
        columns.finish(&problem.mass_factor, block, units);
    }
}

impl Columns {
    fn begin(&mut self, block: &Block) {
        self.half.clear();
        self.half.resize(block.size * COLUMNS, 0.0);
    }

    /// Takes in the rows of a part; those beyond the first that are zero, as of the limit of a joint, have no column.
    fn push<const N: usize>(
        &mut self,
        unit: u32,
        start: usize,
        (columns, entries): (&[u32], &[[f64; N]]),
        own: Range<usize>,
    ) {
        let (columns, entries) = (&columns[own.clone()], &entries[own]);
        for component in 0..N {
            if component > 0 && entries.iter().all(|entry| entry[component] == 0.0) {
                continue;
            }
            let place = self.owners.len();
            for (&column, entry) in columns.iter().zip(entries) {
                self.half[(column as usize - start) * COLUMNS + place] = entry[component];
            }
            self.owners.push((unit, component as u32));
        }
    }

    /// Solves with the columns that were taken in, and adds their squares to the diagonals.
    fn finish(&mut self, factor: &BlockCholesky, block: usize, units: &mut [RobotUnit]) {
        if self.owners.is_empty() {
            return;
        }
        let size = factor.blocks()[block].size;
        let work = Squares { factor, block, columns: self };
        // Short rows are done before wide vectors have begun.
        if size <= SHORT {
            work.find()
        } else {
            Arch::new().dispatch(work)
        }
        for ((unit, component), square) in self.owners.drain(..).zip(&self.squares) {
            units[unit as usize].diagonal[component as usize] += square;
        }
    }
}

struct Squares<'a> {
    factor: &'a BlockCholesky,
    block: usize,
    columns: &'a mut Columns,
}

impl Squares<'_> {
    #[inline(always)]
    fn find(self) {
        let Columns { owners, half, squares } = self.columns;
        let width = owners.len().next_multiple_of(LANES);
        self.factor.half_solve_rows(self.block, half, COLUMNS, width);
        squares.clear();
        squares.resize(width, 0.0);
        for row in half.chunks_exact(COLUMNS).rev() {
            squares.iter_mut().zip(&row[..width]).for_each(|(square, y)| *square += y * y);
        }
    }
}

impl WithSimd for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.find();
    }
}

/// The columns of a contact, or of a friction group counted after the contacts.
fn columns_of(problem: &ContactProblem, unit: usize) -> &[u32] {
    match unit.checked_sub(problem.contact_count()) {
        None => problem.jacobian.group(unit).0,
        Some(j) => problem.friction_groups.jacobian.group(j).0,
    }
}
