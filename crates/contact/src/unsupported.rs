//! Friction that some models and methods do not have, and that they refuse by name.

use crate::ContactProblem;

/// A direction of another length than 1 by more than this makes friction anisotropic.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Friction of a problem that the model or method asked for does not have. The polygon's laws have all of it: the structured solver
/// and every method for LCPs solve them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnsupportedFriction {
    /// [Friction groups](crate::FrictionGroups): friction in joints, at servos, of moving surfaces, against spinning and rolling.
    #[error(
        "the problem has {count} friction groups (joints, servos, moving surfaces, spinning, rolling), which the convex relaxation and \
         the choice among impulses do not have: use the structured solver, the circular cone or a method for LCPs"
    )]
    Groups {
        /// How many.
        count: usize,
    },
    /// Directions of unequal length, for which the circular cone has no law.
    #[error(
        "the friction of contact {contact} is anisotropic, which only the polygon's laws have: use the structured solver or a \
         method for LCPs"
    )]
    Anisotropic {
        /// The contact.
        contact: usize,
    },
    /// The same of a friction group.
    #[error(
        "the friction of friction group {group} is anisotropic, which only the polygon's laws have: use the structured solver or a \
         method for LCPs"
    )]
    AnisotropicGroup {
        /// The group.
        group: usize,
    },
}

impl ContactProblem {
    /// Whether the circular friction cone has a law for every friction of the problem: none depends on the direction.
    ///
    /// # Errors
    /// [`UnsupportedFriction`] with the first reason.
    pub fn check_circular(&self) -> Result<(), UnsupportedFriction> {
        if let Some(contact) = (0..self.contact_count()).find(|&i| self.is_anisotropic(i)) {
            return Err(UnsupportedFriction::Anisotropic { contact });
        }
        let groups = &self.friction_groups;
        match (0..groups.len()).find(|&j| !all_of_length_one(groups.directions_of(j))) {
            Some(group) => Err(UnsupportedFriction::AnisotropicGroup { group }),
            None => Ok(()),
        }
    }

    /// Whether friction acts at contacts alone.
    pub fn check_without_groups(&self) -> Result<(), UnsupportedFriction> {
        match self.friction_groups.len() {
            0 => Ok(()),
            count => Err(UnsupportedFriction::Groups { count }),
        }
    }

    /// Whether a direction of contact `i` has another length than 1.
    pub fn is_anisotropic(&self, i: usize) -> bool {
        !all_of_length_one(self.directions_of(i))
    }
}

fn all_of_length_one(directions: &[[f64; 2]]) -> bool {
    directions.iter().all(|d| (d[0].hypot(d[1]) - 1.0).abs() <= UNIT_TOLERANCE)
}
