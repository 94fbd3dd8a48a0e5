//! What the islands of a problem follow from.

use signorini_multibody::Block;

use signorini_contact::lists::same;
use signorini_contact::{ContactProblem, FrictionBound};

/// Where groups of rows begin, and their columns.
type Pattern = (Vec<usize>, Vec<u32>);

/// What the islands follow from: the places of the numbers, not the numbers. From step to step it is mostly the same.
#[derive(Clone, Debug, Default)]
pub(super) struct Structure {
    blocks: Vec<Block>,
    contacts: Pattern,
    groups: Pattern,
    bilateral: Pattern,
    /// The contact that bounds each friction group, the largest number where none does.
    bounded_by: Vec<u32>,
}

impl Structure {
    /// Whether a problem has the same.
    pub fn is_that_of(&self, problem: &ContactProblem) -> bool {
        let has =
            |own: &Pattern, (offsets, columns): (&[usize], &[u32])| same(&own.0, offsets) && same(&own.1, columns);
        let groups = &problem.friction_groups;
        has(&self.contacts, problem.jacobian.pattern())
            && self.blocks == problem.mass.blocks()
            && has(&self.bilateral, problem.bilateral_jacobian.pattern())
            && has(&self.groups, groups.jacobian.pattern())
            && self.bounded_by.iter().copied().eq(groups.bound.iter().map(bounding_contact))
    }

    /// Takes over that of a problem.
    pub fn read(&mut self, problem: &ContactProblem) {
        let read = |own: &mut Pattern, (offsets, columns): (&[usize], &[u32])| {
            own.0.clear();
            own.0.extend_from_slice(offsets);
            own.1.clear();
            own.1.extend_from_slice(columns);
        };
        let groups = &problem.friction_groups;
        self.blocks.clear();
        self.blocks.extend_from_slice(problem.mass.blocks());
        read(&mut self.contacts, problem.jacobian.pattern());
        read(&mut self.groups, groups.jacobian.pattern());
        read(&mut self.bilateral, problem.bilateral_jacobian.pattern());
        self.bounded_by.clear();
        self.bounded_by.extend(groups.bound.iter().map(bounding_contact));
    }
}

fn bounding_contact(bound: &FrictionBound) -> u32 {
    bound.normal().map_or(u32::MAX, |(contact, _)| contact as u32)
}
