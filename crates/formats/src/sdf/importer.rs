//! What the readers of the parts share.

use crate::mesh_store::MeshStore;
use crate::parts::Parts;
use crate::report::Reporter;

/// What the readers of the parts share.
pub(super) struct Importer {
    pub parts: Parts,
    pub report: Reporter,
    pub meshes: MeshStore,
    /// Pairs of links kept apart so far.
    pub pairs: usize,
    /// SDF's version times 10: 17 for 1.7.
    pub version: u32,
}
