//! What can be wrong with a model.

/// A model that cannot be built, with the part that is to blame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Two parts of the same sort have the same name.
    #[error("two {sort}s are called '{name}': give each its own name")]
    DuplicateName {
        /// Sort of part.
        sort: &'static str,
        /// The name.
        name: String,
    },
    /// A part refers to another one that is not there.
    #[error("{part} refers to {sort} {index}, but there are only {count}")]
    UnknownPart {
        /// Who refers.
        part: String,
        /// Sort of the missing part.
        sort: &'static str,
        /// Index it was called by.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A number is out of its range.
    #[error("{part}: {quantity} must be {expected}, found {found}")]
    InvalidNumber {
        /// The part.
        part: String,
        /// The quantity.
        quantity: &'static str,
        /// What it has to be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// A shape is malformed.
    #[error("geom '{geom}' ({kind}): {reason}")]
    InvalidGeometry {
        /// The geom.
        geom: String,
        /// Its kind.
        kind: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A rotational inertia that no rigid body has.
    #[error(
        "body '{body}': rotational inertia with principal moments {moments:?} kg·m² is not that of a rigid body; \
         each must be ≥ 0 and none larger than the sum of the other two"
    )]
    InvalidInertia {
        /// The body.
        body: String,
        /// Its principal moments, ascending.
        moments: [f64; 3],
    },
    /// A moving body and all that is welded to it have no mass, so that the mass matrix is singular.
    #[error("body '{body}' can move but has no {missing}: give it an inertia, or its joint an armature")]
    Massless {
        /// The body.
        body: String,
        /// What is missing.
        missing: &'static str,
    },
    /// A joint in a place where it cannot be.
    #[error("joint '{joint}' of body '{body}': {reason}")]
    InvalidJoint {
        /// The joint.
        joint: String,
        /// Its body.
        body: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A body whose pose is given from outside where that cannot be.
    #[error("mocap body '{body}' must be a child of the world without joints")]
    InvalidMocap {
        /// The body.
        body: String,
    },
    /// A path that no tendon can have, or a law that what an actuator acts on cannot have.
    #[error("{part}: {reason}")]
    InvalidPath {
        /// The tendon.
        part: String,
        /// What is wrong.
        reason: String,
    },
    /// What is between two parts has the same one twice.
    #[error("{part} is between {sort} '{name}' and itself: it takes two")]
    SamePart {
        /// What is between them.
        part: String,
        /// Sort of the parts.
        sort: &'static str,
        /// The name of the part.
        name: String,
    },
    /// A keyframe or another list with the wrong number of entries.
    #[error("{part} has {found} entries in {list}, the model needs {expected}")]
    WrongLength {
        /// The part.
        part: String,
        /// Which list.
        list: &'static str,
        /// How many it needs.
        expected: usize,
        /// How many it has.
        found: usize,
    },
    /// A number that a part has not, or that comes with the model.
    #[error("{part}: {parameter} cannot be changed: {reason}")]
    FixedParameter {
        /// The part.
        part: String,
        /// The parameter.
        parameter: &'static str,
        /// Why.
        reason: &'static str,
    },
}
