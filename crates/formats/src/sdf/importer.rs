//! What the readers of the parts share.

use signorini_multibody::GeomId;

use super::include::{NEWEST, Versions};
use crate::mesh_store::MeshStore;
use crate::parts::Parts;
use crate::report::Reporter;
use crate::visuals::Visuals;
use crate::xml::Element;

/// What the readers of the parts share.
pub(super) struct Importer {
    pub parts: Parts,
    pub report: Reporter,
    pub meshes: MeshStore,
    pub visuals: Visuals,
    /// What only touches of links that are seen otherwise.
    pub hidden: Vec<GeomId>,
    pub versions: Versions,
    /// Which shapes a shape touches that does not say it: bits of which two that touch have one in common.
    pub common_mask: u32,
}

impl Importer {
    /// The minor version of SDF 1.x of the file that an element is from.
    pub fn version_at(&self, element: Element) -> u32 {
        self.versions.get(&element.at().file).copied().unwrap_or(NEWEST)
    }
}
