//! Friction that some models and methods do not have, and that they refuse by name.

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
