//! Friction that some models and methods do not have, and that they refuse by name.

use crate::ContactProblem;

/// A direction of another length than 1 by more than this makes friction anisotropic.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Friction of a problem that the model or method asked for does not have. The polygon's laws have both: the structured solver
/// and every method for LCPs solve them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnsupportedFriction {
    /// [Friction groups](crate::FrictionGroups): friction in joints, at servos, of moving surfaces, against spinning and rolling.
    #[error(
        "the problem has {count} friction groups (joints, servos, moving surfaces, spinning, rolling), which only the polygon's \
         laws have: use the structured solver or a method for LCPs"
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
}

impl ContactProblem {
    /// Whether the circular friction cone has a law for every friction of the problem: no friction groups, and no friction that
    /// depends on the direction.
    ///
    /// # Errors
    /// [`UnsupportedFriction`] with the first reason.
    pub fn check_circular(&self) -> Result<(), UnsupportedFriction> {
        self.check_without_groups()?;
        match (0..self.contact_count()).find(|&i| self.is_anisotropic(i)) {
            Some(contact) => Err(UnsupportedFriction::Anisotropic { contact }),
            None => Ok(()),
        }
    }

    /// Whether friction acts at contacts alone.
    pub(crate) fn check_without_groups(&self) -> Result<(), UnsupportedFriction> {
        match self.friction_groups.len() {
            0 => Ok(()),
            count => Err(UnsupportedFriction::Groups { count }),
        }
    }

    /// Whether a direction of contact `i` has another length than 1.
    pub(crate) fn is_anisotropic(&self, i: usize) -> bool {
        self.directions_of(i).iter().any(|d| (d[0].hypot(d[1]) - 1.0).abs() > UNIT_TOLERANCE)
    }
}
