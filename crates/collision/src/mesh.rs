use glamx::glam::DVec3;
use signorini_multibody::model::{HeightField, Mesh};
#[derive(Clone, Debug)]
pub(crate) struct TriangleSet {}
impl TriangleSet {
    pub fn from_mesh(_mesh: &Mesh) -> Self { Self {} }
    pub fn from_height_field(_field: &HeightField) -> Self { Self {} }
    pub fn bounds(&self) -> (DVec3, DVec3) { (DVec3::ZERO, DVec3::ZERO) }
}
