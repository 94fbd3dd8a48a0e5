//! What can keep a model from being searched for contacts.

/// A model whose shapes cannot be prepared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// A convex mesh that has no volume.
    #[error("geom '{geom}': the vertices of its convex mesh span no volume ({reason}); give it thickness or use a box")]
    FlatHull {
        /// The geom.
        geom: String,
        /// What the hull computation says.
        reason: String,
    },
}
