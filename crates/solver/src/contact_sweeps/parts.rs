//! Parts of an island in which rows lag behind, as islands of their own.
//!
//! A part is made of bodies that rows join; its unknowns are all rows that move one of them. Bodies outside that these rows touch take part
//! as free bodies, and the impulses of all other rows are held. With `s` the sum of all impulses and `s_P` that of the unknowns the part's
//! velocities are `u = J v^f + J M⁻¹ J_Pᵀ λ_P + offset + Z (s − s_P)`: those of an island with other offsets.

use crate::islands::Island;

use super::system::{Lacking, Point, System};

/// No part, or no place.
const NONE: u32 = u32::MAX;
/// A body of a row that lags behind, in no part yet.
const SEED: u32 = NONE - 1;

/// The bodies and rows of parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// First of its rows of each body, and the total; units, then bilateral rows.
    starts: Vec<u32>,
    rows: Vec<u32>,
    is_known: bool,
    /// Bodies of rows that lag behind, ascending, and the part of each body.
    seeds: Vec<u32>,
    part_of: Vec<u32>,
    /// The part at hand: its number, its bodies, its rows, and the bodies that these touch.
    part: u32,
    bodies: Vec<u32>,
    unknown: Vec<u32>,
    touched: Vec<u32>,
    /// The part that a row, and a body, was last seen in.
    row_seen: Vec<u32>,
    body_seen: Vec<u32>,
    /// First degree of freedom in the part of each body, and the unit in it of each unit.
    local_start: Vec<u32>,
    place: Vec<u32>,
    /// `s_P`, then `s − s_P`.
    held: Vec<f64>,
    pub island: Island,
}

impl Parts {
    /// Forgets another island.
    pub fn begin(&mut self) {
        self.is_known = false;
    }

    /// Finds the bodies of rows that lack more than `least`; how many there are.
    pub fn seed(&mut self, system: &System, island: &Island, lacking: &Lacking, least: f64) -> usize {
        if !self.is_known {
            self.list_rows(system, island);
        }
        self.part_of.fill(NONE);
        self.seeds.clear();
        for row in (0..lacking.rows.len()).filter(|&row| lacking.rows[row] > least) {
            for_each_body(system, island, row, |body| {
                if self.part_of[body] == NONE {
                    self.part_of[body] = 0;
                    self.seeds.push(body as u32);
                }
            });
        }
        self.seeds.sort_unstable();
        self.seeds.iter().for_each(|&body| self.part_of[body as usize] = NONE - 1);
        self.row_seen.fill(NONE);
        self.body_seen.fill(NONE);
        self.seeds.len()
    }

    /// Takes the part of the seed at a place as the one at hand, if it is not in an earlier one; the number of its rows.
    pub fn take(&mut self, system: &System, island: &Island, seed: usize) -> Option<usize> {
        let (first, part) = (self.seeds[seed], seed as u32);
        if self.part_of[first as usize] != SEED {
            return None;
        }
        self.part = part;
        self.part_of[first as usize] = part;
        self.bodies.clear();
        self.bodies.push(first);
        self.unknown.clear();
        let mut next = 0;
        while next < self.bodies.len() {
            let body = self.bodies[next] as usize;
            next += 1;
            for at in self.starts[body]..self.starts[body + 1] {
                let row = self.rows[at as usize] as usize;
                if std::mem::replace(&mut self.row_seen[row], part) == part {
                    continue;
                }
                self.unknown.push(row as u32);
                for_each_body(system, island, row, |other| {
                    if self.part_of[other] == SEED {
                        self.part_of[other] = part;
                        self.bodies.push(other as u32);
                    }
                });
            }
        }
        self.add_bounding(island, part);
        self.unknown.sort_unstable();
        Some(self.unknown.len())
    }

    /// The rows of the part at hand that are units, and those that are bilateral, both ascending.
    pub fn unknown(&self, island: &Island) -> (&[u32], &[u32]) {
        let units = self.unknown.partition_point(|&row| (row as usize) < island.units.len());
        self.unknown.split_at(units)
    }

    /// Assembles the [`island`](Self::island) of the part at hand.
    pub fn assemble(&mut self, system: &System, whole: &Island, point: &Point) {
        self.hold_others(system, whole, point);
        self.place_bodies(system, whole);
        let units = self.unknown.partition_point(|&row| (row as usize) < whole.units.len());
        for at in 0..units {
            self.add_unit(system, whole, self.unknown[at] as usize);
        }
        for at in units..self.unknown.len() {
            self.add_bilateral(system, whole, self.unknown[at] as usize - whole.units.len());
        }
    }

    /// The rows of each body.
    fn list_rows(&mut self, system: &System, island: &Island) {
        let count = system.bodies.count();
        let rows = island.units.len() + island.bilateral.len();
        self.starts.clear();
        self.starts.resize(count + 2, 0);
        (0..rows).for_each(|row| for_each_body(system, island, row, |body| self.starts[body + 2] += 1));
        (2..count + 2).for_each(|body| self.starts[body] += self.starts[body - 1]);
        self.rows.clear();
        self.rows.resize(self.starts[count + 1] as usize, 0);
        for row in 0..rows {
            for_each_body(system, island, row, |body| {
                self.rows[self.starts[body + 1] as usize] = row as u32;
                self.starts[body + 1] += 1;
            });
        }
        self.starts.truncate(count + 1);
        self.is_known = true;
        for (list, length) in [
            (&mut self.part_of, count),
            (&mut self.body_seen, count),
            (&mut self.local_start, count),
            (&mut self.row_seen, rows),
            (&mut self.place, island.units.len()),
        ] {
            list.clear();
            list.resize(length, NONE);
        }
    }

    /// Contacts that bound friction groups of the part are unknowns, too.
    fn add_bounding(&mut self, island: &Island, part: u32) {
        for at in 0..self.unknown.len() {
            let group = (self.unknown[at] as usize).checked_sub(island.contact_count);
            let Some(by) = group.and_then(|j| island.bounded_by.get(j)) else { continue };
            if std::mem::replace(&mut self.row_seen[*by as usize], part) != part {
                self.unknown.push(*by);
            }
        }
    }

    /// `s − s_P` of the bodies that the unknowns touch, which are listed.
    fn hold_others(&mut self, system: &System, whole: &Island, point: &Point) {
        self.held.resize(point.sum.len(), 0.0);
        self.touched.clear();
        for at in 0..self.unknown.len() {
            for_each_body(system, whole, self.unknown[at] as usize, |body| {
                if std::mem::replace(&mut self.body_seen[body], self.part) != self.part {
                    self.touched.push(body as u32);
                }
            });
        }
        self.touched.sort_unstable();
        for &body in &self.touched {
            let own = system.bodies.starts[body as usize] as usize..system.bodies.starts[body as usize + 1] as usize;
            self.held[own.clone()].copy_from_slice(&point.sum[own]);
        }
        for &row in &self.unknown {
            match (row as usize).checked_sub(whole.units.len()) {
                None => {
                    let impulse = point.impulse[row as usize].map(|p| -p);
                    system.rows.add_transposed(row as usize, impulse, &mut self.held);
                }
                Some(k) => system.bilateral_rows.add_transposed(k, [-point.bilateral[k]], &mut self.held),
            }
        }
    }

    /// Gives the part's island its bodies.
    fn place_bodies(&mut self, system: &System, whole: &Island) {
        let island = &mut self.island;
        island.clear();
        island.velocity_scale = whole.velocity_scale;
        island.residual_scale = whole.residual_scale;
        island.starts.push(0);
        for &body in &self.touched {
            let body = body as usize;
            self.local_start[body] = island.nv() as u32;
            for block in system.bodies.blocks[body] as usize..system.bodies.blocks[body + 1] as usize {
                island.blocks.push(whole.blocks[block]);
                island.global_starts.push(whole.global_starts[block]);
                island.starts.push(island.nv() + whole.starts[block + 1] - whole.starts[block]);
            }
        }
    }

    fn add_unit(&mut self, system: &System, whole: &Island, c: usize) {
        let (columns, entries) = whole.jacobian.group(c);
        let renumbered = columns.iter().map(|&column| renumber(system, &self.local_start, column));
        let island = &mut self.island;
        island.jacobian.push_renumbered(renumbered, entries);
        let place = island.units.len() as u32;
        self.place[c] = place;
        let mut shift = system.rows.multiply(c, &self.held);
        if let Some(j) = c.checked_sub(whole.contact_count) {
            let by = whole.bounded_by[j] as usize;
            island.bounded_by.push(if by == c { place } else { self.place[by] });
            if by != c {
                // The first row is that of the contact in another unit.
                let normal = system.rows.multiply(by, &self.held)[0];
                shift[0] = whole.scale[c] / whole.scale[by] * normal;
            }
        } else {
            island.contact_count += 1;
        }
        island.units.push(whole.units[c]);
        island.scale.push(whole.scale[c]);
        island.offset.push(std::array::from_fn(|r| whole.offset[c][r] + shift[r]));
        island.free_slack.push(std::array::from_fn(|r| whole.free_slack[c][r] + shift[r]));
    }

    fn add_bilateral(&mut self, system: &System, whole: &Island, k: usize) {
        let (columns, entries) = whole.bilateral_jacobian.group(k);
        let renumbered = columns.iter().map(|&column| renumber(system, &self.local_start, column));
        let island = &mut self.island;
        island.bilateral_jacobian.push_renumbered(renumbered, entries);
        let [shift] = system.bilateral_rows.multiply(k, &self.held);
        island.bilateral.push(whole.bilateral[k]);
        island.bilateral_scale.push(whole.bilateral_scale[k]);
        island.bilateral_offset.push(whole.bilateral_offset[k] + shift);
        island.bilateral_free_slack.push(whole.bilateral_free_slack[k] + shift);
    }
}

/// The degree of freedom in a part.
fn renumber(system: &System, local_start: &[u32], column: u32) -> u32 {
    let body = system.bodies.of(column);
    local_start[body] + column - system.bodies.starts[body]
}

/// The bodies that a row moves.
fn for_each_body(system: &System, island: &Island, row: usize, mut visit: impl FnMut(usize)) {
    match row.checked_sub(island.units.len()) {
        None => system.rows.runs(row).iter().for_each(|run| visit(run.body as usize)),
        Some(k) => system.bilateral_rows.runs(k).iter().for_each(|run| visit(run.body as usize)),
    }
}
