//! What the friction cones of a problem follow from.

use crate::lists::{same, same_bits};
use crate::{ContactProblem, FrictionBound};

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
