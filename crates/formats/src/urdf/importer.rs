//! What the readers of links and joints share.

use std::collections::HashMap;

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{BodyId, GeomId, Pose};

use super::materials::Materials;
use crate::error::FormatError;
use crate::mesh_store::MeshStore;
use crate::parts::Parts;
use crate::report::Reporter;
use crate::visuals::Visuals;
use crate::xml::Element;

/// What the readers of links and joints share.
pub(super) struct Importer {
    pub parts: Parts,
    pub report: Reporter,
    pub materials: Materials,
    pub meshes: MeshStore,
    pub visuals: Visuals,
    /// What touches, with the link that it belongs to.
    pub touching: Vec<(usize, GeomId)>,
    /// Links that are part of the body of another one.
    pub merged: HashMap<String, BodyId>,
}

/// A link that has become a body.
pub(super) struct Placed {
    pub body: BodyId,
    /// The link in its body: another frame than the body's where links are merged.
    pub offset: Pose,
    /// The link in world, at the reference configuration.
    pub pose: Pose,
    /// The link this one is welded to, nearest the root; none for the world.
    pub weld: Option<usize>,
}

impl Importer {
    /// The body of a link, merged or not.
    pub fn link_body(&self, link: &str) -> Option<BodyId> {
        self.parts.body(link).or_else(|| self.merged.get(link).copied())
    }
}

/// `<origin xyz="…" rpy="…">` of an element: roll about x, then pitch about y, then yaw about z, all fixed axes.
pub(super) fn origin(element: Element) -> Result<Pose, FormatError> {
    let Some(origin) = element.child("origin") else { return Ok(Pose::IDENTITY) };
    let a = origin.attributes();
    let position = a.vec3_or_more("xyz")?.unwrap_or(DVec3::ZERO);
    let [roll, pitch, yaw] = a.vec3_or_more("rpy")?.unwrap_or_default().to_array();
    let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    Ok(Pose::new(position, rotation.normalize()))
}
