//! Groups of kinematic trees that contacts with a cone and bilateral rows tie together.

use super::ImpulseCones;
use signorini_contact::ContactProblem;

/// The groups of a problem. Contacts without a cone tie nothing, so that a group can be smaller than an island.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    root: Vec<u32>,
    group_of_root: Vec<u32>,
    members: Vec<Members>,
    count: usize,
    /// Place of each degree of freedom in its group.
    local: Vec<u32>,
}

#[derive(Clone, Debug, Default)]
struct Members {
    blocks: Vec<u32>,
    dofs: Vec<u32>,
    contacts: Vec<u32>,
    rows: Vec<u32>,
}

/// One group. Vectors over degrees of freedom, contacts and rows stay global; only the matrix is local.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group<'a> {
    /// Blocks of the mass matrix, ascending.
    pub blocks: &'a [u32],
    /// Their degrees of freedom, ascending.
    pub dofs: &'a [u32],
    /// Contacts with a cone, ascending.
    pub contacts: &'a [u32],
    /// Bilateral rows, ascending.
    pub rows: &'a [u32],
    local: &'a [u32],
}

impl Group<'_> {
    /// Place of a degree of freedom in the group.
    pub fn local(&self, dof: u32) -> usize {
        self.local[dof as usize] as usize
    }
}

const NONE: u32 = u32::MAX;

impl Groups {
    /// Finds the groups; memory is reused.
    pub fn find(&mut self, problem: &ContactProblem, cones: &ImpulseCones) {
        let blocks = problem.mass.blocks();
        self.root.clear();
        self.root.extend(0..blocks.len() as u32);
        let touched = |i: &usize| !cones.rays(*i).is_empty() && !problem.jacobian.group(*i).0.is_empty();
        for i in (0..problem.contact_count()).filter(touched) {
            self.join(problem, problem.jacobian.group(i).0);
        }
        for k in 0..problem.bilateral_violation.len() {
            self.join(problem, problem.bilateral_jacobian.group(k).0);
        }
        self.count = 0;
        self.group_of_root.clear();
        self.group_of_root.resize(blocks.len(), NONE);
        for i in (0..problem.contact_count()).filter(touched) {
            let group = self.group_of(problem, problem.jacobian.group(i).0[0]);
            self.members[group].contacts.push(i as u32);
        }
        for k in 0..problem.bilateral_violation.len() {
            if let Some(&column) = problem.bilateral_jacobian.group(k).0.first() {
                let group = self.group_of(problem, column);
                self.members[group].rows.push(k as u32);
            }
        }
        self.place_blocks(problem);
    }

    /// Gives every block of a group, and its degrees of freedom, their place.
    fn place_blocks(&mut self, problem: &ContactProblem) {
        self.local.clear();
        self.local.resize(problem.nv(), NONE);
        for (k, block) in problem.mass.blocks().iter().enumerate() {
            let group = self.group_of_root[find_root(&mut self.root, k as u32) as usize];
            if group == NONE {
                continue;
            }
            let members = &mut self.members[group as usize];
            members.blocks.push(k as u32);
            for dof in block.range() {
                self.local[dof] = members.dofs.len() as u32;
                members.dofs.push(dof as u32);
            }
        }
    }

    /// The groups, in the order of their first contact or row.
    pub fn all(&self) -> impl Iterator<Item = Group<'_>> {
        self.members[..self.count].iter().map(|m| Group {
            blocks: &m.blocks,
            dofs: &m.dofs,
            contacts: &m.contacts,
            rows: &m.rows,
            local: &self.local,
        })
    }

    fn join(&mut self, problem: &ContactProblem, columns: &[u32]) {
        let Some((&first, rest)) = columns.split_first() else { return };
        let a = find_root(&mut self.root, problem.mass.block_of(first as usize) as u32);
        for &column in rest {
            let b = find_root(&mut self.root, problem.mass.block_of(column as usize) as u32);
            self.root[b as usize] = a;
        }
    }

    /// The group of a degree of freedom, made where there is none yet.
    fn group_of(&mut self, problem: &ContactProblem, column: u32) -> usize {
        let root = find_root(&mut self.root, problem.mass.block_of(column as usize) as u32) as usize;
        if self.group_of_root[root] == NONE {
            self.group_of_root[root] = self.count as u32;
            if self.members.len() == self.count {
                self.members.push(Members::default());
            }
            let Members { blocks, dofs, contacts, rows } = &mut self.members[self.count];
            [blocks, dofs, contacts, rows].into_iter().for_each(Vec::clear);
            self.count += 1;
        }
        self.group_of_root[root] as usize
    }
}

fn find_root(root: &mut [u32], mut k: u32) -> u32 {
    while root[k as usize] != k {
        root[k as usize] = root[root[k as usize] as usize];
        k = root[k as usize];
    }
    k
}
