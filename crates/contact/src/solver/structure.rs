//! What the islands of a problem and its friction cones follow from.

use signorini_multibody::Block;

use super::lists::{same, same_bits};
use crate::{ContactProblem, FrictionBound};

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

/// What the cones were read from: mostly the next problem has the same.
#[derive(Clone, Debug, Default)]
pub(super) struct ConeData {
    friction: Vec<f64>,
    directions: Vec<[f64; 2]>,
    offsets: Vec<usize>,
    bounds: Vec<FrictionBound>,
    group_directions: Vec<[f64; 2]>,
    group_offsets: Vec<usize>,
}

impl ConeData {
    /// Whether a problem has the same, to the bit where directions are concerned.
    pub fn is_that_of(&self, problem: &ContactProblem) -> bool {
        let groups = &problem.friction_groups;
        same(&self.offsets, &problem.direction_offsets)
            && same_bits(&self.friction, &problem.friction)
            && same_bits(self.directions.as_flattened(), problem.directions.as_flattened())
            && same(&self.group_offsets, &groups.direction_offsets)
            && self.bounds == groups.bound
            && same_bits(self.group_directions.as_flattened(), groups.directions.as_flattened())
    }

    /// Takes over those of a problem.
    pub fn read(&mut self, problem: &ContactProblem) {
        let groups = &problem.friction_groups;
        self.friction.clone_from(&problem.friction);
        self.directions.clone_from(&problem.directions);
        self.offsets.clone_from(&problem.direction_offsets);
        self.bounds.clone_from(&groups.bound);
        self.group_directions.clone_from(&groups.directions);
        self.group_offsets.clone_from(&groups.direction_offsets);
    }
}
