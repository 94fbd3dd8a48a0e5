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
    /// Two triangle meshes or height fields that could meet.
    #[error(
        "geoms '{geom_a}' and '{geom_b}' are both triangle meshes or height fields and can meet: make the moving one a \
         convex mesh, or keep the two apart by their masks"
    )]
    TwoMeshes {
        /// One geom.
        geom_a: String,
        /// The other.
        geom_b: String,
    },
}
