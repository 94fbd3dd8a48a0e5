//! What can be wrong with an edit.

use signorini_multibody::ModelError;

/// An edit that cannot be made, or a spec that is no mechanism, with the part to blame.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpecError {
    /// No part has this name.
    #[error("there is no {sort} '{name}'{}", similar.as_ref().map(|name| format!("; did you mean '{name}'?")).unwrap_or_default())]
    UnknownName {
        /// Sort of part.
        sort: &'static str,
        /// The name.
        name: String,
        /// The name that is most like it.
        similar: Option<String>,
    },
    /// Another part of the sort has the name already.
    #[error("there is a {sort} '{name}' already: give it another name, or attach with a prefix")]
    DuplicateName {
        /// Sort of part.
        sort: &'static str,
        /// The name.
        name: String,
    },
    /// The world cannot be changed like a body.
    #[error("the world cannot be {what}")]
    World {
        /// What was asked for.
        what: &'static str,
    },
    /// A part refers to one that was removed or never there.
    #[error("{part} refers to a {sort} that is not there")]
    DanglingReference {
        /// Who refers.
        part: String,
        /// Sort of the missing part.
        sort: &'static str,
    },
    /// Bodies whose parents are each other's descendants.
    #[error("body '{body}' hangs on itself")]
    Circle {
        /// One of the bodies.
        body: String,
    },
    /// A body with a free joint attached to something other than the world.
    #[error(
        "body '{body}' has a free joint, which only a child of the world can have: remove the joint, or attach to the world"
    )]
    FreeJoint {
        /// The body.
        body: String,
    },
    /// A solid without volume.
    #[error("geom '{geom}' is a {kind}, which has no volume to be filled with mass")]
    NoVolume {
        /// The geom.
        geom: String,
        /// Its shape.
        kind: &'static str,
    },
    /// What the compiled model says.
    #[error(transparent)]
    Model(#[from] ModelError),
}
