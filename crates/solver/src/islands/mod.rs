//! Splitting a problem into islands.

mod island;
mod joined_blocks;
mod known_rows;
mod robot_rows;
mod structure;

use signorini_contact::ContactProblem;
use signorini_contact::scales::{VelocityScale, largest, raise};

pub use island::Island;
pub(crate) use island::block_of;
use joined_blocks::JoinedBlocks;
use known_rows::KnownRows;
use robot_rows::RobotRows;
use structure::Structure;

/// The islands of a problem; memory is reused from problem to problem.
#[derive(Clone, Debug, Default)]
pub struct Islands {
    islands: Vec<Island>,
    count: usize,
    joined: JoinedBlocks,
    island_of_root: Vec<u32>,
    local_start: Vec<usize>,
    scratch: Vec<f64>,
    columns: Vec<(u32, [f64; 3])>,
    /// Unit of each contact in its island.
    place: Vec<u32>,
    units: Vec<Measured>,
    /// The island of each bilateral row, and `∇Θ v^f + Θ/Δt`.
    bilateral: Vec<(u32, f64)>,
    /// The largest Delassus entry of contacts and groups.
    delassus_scale: f64,
    velocity_scale: VelocityScale,
    /// Both of what is beside the problem.
    beside: (f64, VelocityScale),
    structure: Structure,
    known: KnownRows,
    robots: RobotRows,
}

/// What the data say of a contact or friction group.
#[derive(Clone, Copy, Debug)]
struct Measured {
    /// Its island, [`NONE`] if nothing moves it.
    island: u32,
    /// Whether a robot has a part in it.
    on_robot: bool,
    /// The largest entry on the diagonal of its Delassus block.
    delassus: f64,
    /// `u` of a contact at the free velocity.
    free_slack: [f64; 3],
}

const NONE: u32 = u32::MAX;

impl Islands {
    /// The islands that have at least one row, in the order of their first block.
    pub fn all(&self) -> &[Island] {
        &self.islands[..self.count]
    }

    /// `g` of the problem ([`ContactProblem::delassus_scale`]).
    pub fn delassus_scale(&self) -> f64 {
        self.delassus_scale
    }

    /// `s_v` of the problem ([`ContactProblem::velocity_scale`]).
    pub fn velocity_scale(&self) -> f64 {
        self.velocity_scale.value()
    }

    /// `s_v` of an island.
    pub fn scale_of(&self, island: usize) -> f64 {
        self.islands[island].velocity_scale.value()
    }

    /// The Delassus scale that residuals are measured with.
    pub fn residual_scale(&self) -> f64 {
        positive(self.delassus_scale)
    }

    /// The largest entry on the diagonal of a unit's Delassus block, 1 if that is 0.
    pub fn delassus_of(&self, unit: usize) -> f64 {
        positive(self.units[unit].delassus)
    }

    /// The island of a unit of the problem: a contact, or a friction group counted after the contacts.
    pub fn of_unit(&self, unit: usize) -> Option<usize> {
        self.units.get(unit).and_then(|unit| index(unit.island))
    }

    /// The island of a bilateral row.
    pub fn of_bilateral(&self, row: usize) -> Option<usize> {
        self.bilateral.get(row).and_then(|row| index(row.0))
    }

    /// The island of a block of the mass matrix.
    pub fn of_block(&self, block: usize) -> Option<usize> {
        index(self.island_of_root[*self.joined.root.get(block)? as usize])
    }

    /// Takes these for the scales `g` and `s_v` of what is beside the problems to come.
    pub(crate) fn set_beside(&mut self, delassus: f64, velocity: VelocityScale) {
        self.beside = (delassus, velocity);
    }

    /// Finds the islands of a problem and its scales. [`assemble`](Self::assemble) gives them their rows.
    pub fn find(&mut self, problem: &ContactProblem) {
        if self.structure.is_that_of(problem) {
            for island in &mut self.islands[..self.count] {
                island.velocity_scale = VelocityScale::default();
                if !(island.units.is_empty() && island.bilateral.is_empty()) {
                    island.clear_rows();
                }
            }
        } else {
            self.structure.read(problem);
            self.joined.join(problem);
            self.number_islands(problem);
            self.scratch.clear();
            self.scratch.resize(problem.nv(), 0.0);
            self.place_rows(problem);
            self.known.forget(problem);
        }
        self.known.begin(problem, &self.islands[..self.count]);
        (self.delassus_scale, self.velocity_scale) = self.beside;
        (0..problem.contact_count()).for_each(|i| self.measure_contact(problem, i));
        (0..problem.friction_groups.len()).for_each(|j| self.measure_group(problem, j));
        self.measure_robots(problem);
        (0..problem.bilateral_violation.len()).for_each(|k| self.measure_bilateral(problem, k));
    }

    /// The island of each unit and bilateral row.
    fn place_rows(&mut self, problem: &ContactProblem) {
        let (mut units, mut bilateral) = (std::mem::take(&mut self.units), std::mem::take(&mut self.bilateral));
        let island_of = |columns: &[u32]| self.island_of(problem, columns).map_or(NONE, |island| island as u32);
        let placed = |columns: &[u32]| Measured {
            island: island_of(columns),
            on_robot: false,
            delassus: 0.0,
            free_slack: [0.0; 3],
        };
        units.clear();
        units.extend((0..problem.contact_count()).map(|i| placed(problem.jacobian.group(i).0)));
        let groups = &problem.friction_groups;
        units.extend((0..groups.len()).map(|j| placed(groups.jacobian.group(j).0)));
        bilateral.clear();
        let rows = 0..problem.bilateral_violation.len();
        bilateral.extend(rows.map(|k| (island_of(problem.bilateral_jacobian.group(k).0), 0.0)));
        self.robots.find(problem, |unit| units[unit].on_robot = true);
        (self.units, self.bilateral) = (units, bilateral);
    }

    /// Gives the `wanted` islands their rows.
    pub fn assemble(&mut self, problem: &ContactProblem, wanted: impl Fn(usize) -> bool) {
        if !(0..self.count).any(&wanted) {
            return;
        }
        let scale = self.residual_scale();
        for (_, island) in self.islands[..self.count].iter_mut().enumerate().filter(|(k, _)| wanted(*k)) {
            island.clear_rows();
            island.residual_scale = scale;
        }
        self.place.clear();
        self.place.resize(problem.contact_count(), NONE);
        for unit in 0..self.units.len() {
            let Some(island) = self.of_unit(unit).filter(|&k| wanted(k)) else { continue };
            match unit.checked_sub(problem.contact_count()) {
                None => self.add_contact(problem, island, unit),
                Some(j) => self.add_group(problem, island, j),
            }
        }
        for row in 0..self.bilateral.len() {
            if let Some(island) = self.of_bilateral(row).filter(|&k| wanted(k)) {
                self.add_bilateral(problem, island, row);
            }
        }
    }

    fn measure_contact(&mut self, problem: &ContactProblem, i: usize) {
        let (free_slack, terms) = self.velocity_scale.add_contact(problem, i);
        let unit = &mut self.units[i];
        unit.free_slack = free_slack;
        let Some(island) = index(unit.island) else { return };
        if !unit.on_robot {
            if !self.known.has(problem, island, i) {
                unit.delassus = largest(problem.delassus_diagonal(i, &mut self.scratch));
            }
            raise(&mut self.delassus_scale, unit.delassus);
        }
        let own = &mut self.islands[island].velocity_scale;
        let seen = if problem.directions_of(i).is_empty() { 1 } else { 3 };
        free_slack[..seen].iter().for_each(|u| own.add(*u, terms));
    }

    fn measure_group(&mut self, problem: &ContactProblem, j: usize) {
        let (slip, terms) = self.velocity_scale.add_group(problem, j);
        let free_slack = [0.0, slip[0], slip[1]];
        let unit = &mut self.units[problem.contact_count() + j];
        unit.free_slack = free_slack;
        let Some(island) = index(unit.island) else { return };
        if !unit.on_robot {
            unit.delassus = largest(problem.group_delassus(j, &mut self.scratch));
            raise(&mut self.delassus_scale, unit.delassus);
        }
        let own = &mut self.islands[island].velocity_scale;
        slip.iter().for_each(|u| own.add(*u, terms));
    }

    fn measure_robots(&mut self, problem: &ContactProblem) {
        let Self { robots, known, units, scratch, delassus_scale, .. } = self;
        let contacts = problem.contact_count();
        let islands: &[Measured] = units;
        let wanted = |unit: usize| unit >= contacts || !known.has(problem, islands[unit].island as usize, unit);
        robots.measure(problem, scratch, wanted);
        for (unit, measured) in robots.all() {
            let delassus = &mut units[unit].delassus;
            *delassus = measured.unwrap_or(*delassus);
            raise(delassus_scale, *delassus);
        }
    }

    fn measure_bilateral(&mut self, problem: &ContactProblem, k: usize) {
        let (slack, terms) = self.velocity_scale.add_bilateral(problem, k);
        self.bilateral[k].1 = slack;
        if let Some(island) = self.of_bilateral(k) {
            self.islands[island].velocity_scale.add(slack, terms);
        }
    }

    fn add_contact(&mut self, problem: &ContactProblem, island: usize, i: usize) {
        let (columns, entries) = problem.jacobian.group(i);
        let island = &mut self.islands[island];
        self.place[i] = island.units.len() as u32;
        island.jacobian.push_renumbered(local_columns(problem, &self.local_start, columns), entries);
        island.units.push(i as u32);
        island.contact_count += 1;
        island.offset.push([problem.gap[i] / problem.timestep, 0.0, 0.0]);
        island.free_slack.push(self.units[i].free_slack);
        island.scale.push(positive(self.units[i].delassus));
    }

    /// A group's first row is that of its contact, scaled so that the proximal weight of the group turns it into the contact's
    /// own trial impulse.
    fn add_group(&mut self, problem: &ContactProblem, island: usize, j: usize) {
        let groups = &problem.friction_groups;
        let (columns, entries) = groups.jacobian.group(j);
        let Measured { delassus, mut free_slack, .. } = self.units[problem.contact_count() + j];
        let scale = positive(delassus);
        self.columns.clear();
        self.columns.extend(columns.iter().zip(entries).map(|(&c, e)| (c, [0.0, e[0], e[1]])));
        let target = groups.target[j];
        let mut offset = [0.0, -target[0], -target[1]];
        let contact = groups.bound[j].normal().map(|(contact, _)| contact).filter(|&i| self.place[i] != NONE);
        if let Some(i) = contact {
            let factor = scale / self.islands[island].scale[self.place[i] as usize];
            offset[0] = factor * problem.gap[i] / problem.timestep;
            let (columns, entries) = problem.jacobian.group(i);
            for (&c, e) in columns.iter().zip(entries) {
                match self.columns.binary_search_by_key(&c, |x| x.0) {
                    Ok(k) => self.columns[k].1[0] = factor * e[0],
                    Err(k) => self.columns.insert(k, (c, [factor * e[0], 0.0, 0.0])),
                }
            }
        }
        free_slack[0] = offset[0];
        for (c, e) in &self.columns {
            free_slack[0] += e[0] * problem.free_velocity[*c as usize];
        }
        let island = &mut self.islands[island];
        island.bounded_by.push(contact.map_or(island.units.len() as u32, |i| self.place[i]));
        let local = |c: u32| local_column(problem, &self.local_start, c);
        island.jacobian.push(self.columns.iter().map(|&(c, e)| (local(c), e)));
        island.units.push((problem.contact_count() + j) as u32);
        island.offset.push(offset);
        island.free_slack.push(free_slack);
        island.scale.push(scale);
    }

    fn add_bilateral(&mut self, problem: &ContactProblem, island: usize, k: usize) {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        let scale = positive(problem.bilateral_delassus(k, &mut self.scratch));
        let island = &mut self.islands[island];
        island.bilateral_jacobian.push_renumbered(local_columns(problem, &self.local_start, columns), entries);
        island.bilateral.push(k as u32);
        island.bilateral_offset.push(problem.bilateral_violation[k] / problem.timestep);
        island.bilateral_free_slack.push(self.bilateral[k].1);
        island.bilateral_scale.push(scale);
    }

    /// Gives every touched root an island and every block its local place.
    fn number_islands(&mut self, problem: &ContactProblem) {
        let blocks = problem.mass.blocks();
        self.island_of_root.clear();
        self.island_of_root.resize(blocks.len(), NONE);
        for k in (0..blocks.len()).filter(|&k| self.joined.touched[k]) {
            self.island_of_root[self.joined.root[k] as usize] = 0;
        }
        self.count = 0;
        self.local_start.clear();
        self.local_start.resize(blocks.len(), 0);
        for (k, block) in blocks.iter().enumerate() {
            let root = self.joined.root[k] as usize;
            if self.island_of_root[root] == NONE {
                continue;
            }
            if root == k {
                self.island_of_root[root] = self.count as u32;
                if self.islands.len() == self.count {
                    self.islands.push(Island::default());
                }
                self.islands[self.count].clear();
                self.islands[self.count].starts.push(0);
                self.count += 1;
            }
            let island = &mut self.islands[self.island_of_root[root] as usize];
            self.local_start[k] = island.nv();
            island.blocks.push(k as u32);
            island.global_starts.push(block.start);
            island.starts.push(self.local_start[k] + block.size);
        }
    }

    fn island_of(&self, problem: &ContactProblem, columns: &[u32]) -> Option<usize> {
        let block = problem.mass.block_of(*columns.first()? as usize);
        Some(self.island_of_root[self.joined.root[block] as usize] as usize)
    }
}

/// The number of an island, if it is one.
fn index(island: u32) -> Option<usize> {
    (island != NONE).then_some(island as usize)
}

/// A scale; 1 where there is nothing to scale by.
fn positive(g: f64) -> f64 {
    if g > 0.0 { g } else { 1.0 }
}

/// Place of a global degree of freedom in its island.
fn local_column(problem: &ContactProblem, local_start: &[usize], column: u32) -> u32 {
    let block = problem.mass.block_of(column as usize);
    (local_start[block] + column as usize - problem.mass.blocks()[block].start) as u32
}

/// The same for ascending columns.
fn local_columns(problem: &ContactProblem, local_start: &[usize], columns: &[u32]) -> impl Iterator<Item = u32> {
    let blocks = problem.mass.blocks();
    let (mut end, mut before) = (0, 0);
    columns.iter().map(move |&column| {
        if column as usize >= end {
            let block = problem.mass.block_of(column as usize);
            end = blocks[block].range().end;
            before = (blocks[block].start - local_start[block]) as u32;
        }
        column - before
    })
}
