//! Geoms that stand where they are: a terrain of thousands, or bodies at rest, cost a step what the moving geoms near them cost.

use signorini_multibody::Model;

use crate::bvh::{Aabb, Bvh};

/// Bounded geoms that are not looked at against each other, in a tree that stays while they do: those of bodies that are welded to the world, or those of
/// bodies at rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct FixedGeoms {
    geoms: Vec<u32>,
    tree: Bvh,
    is_stale: bool,
}

/// Whether a geom's body is welded to the world, and to nothing that is moved from outside.
pub(crate) fn is_fixed(model: &Model, geom: u32) -> bool {
    model.is_fixed(model.geoms[geom as usize].body)
}

impl FixedGeoms {
    /// - `geoms`: those that are fixed, ascending
    pub fn new(geoms: Vec<u32>) -> Self {
        Self { geoms, tree: Bvh::default(), is_stale: true }
    }

    /// Has these geoms from now on, ascending.
    pub fn hold(&mut self, geoms: impl Iterator<Item = u32>) {
        self.geoms.clear();
        self.geoms.extend(geoms);
        self.is_stale = true;
    }

    pub fn retain(&mut self, keep: impl Fn(u32) -> bool) {
        self.geoms.retain(|&i| keep(i));
        self.is_stale = true;
    }

    /// Takes note of a box that is not what it was.
    pub fn note_moved(&mut self, geom: u32) {
        self.is_stale |= self.geoms.binary_search(&geom).is_ok();
    }

    /// Makes the tree anew where a box is another one.
    pub fn refresh(&mut self, boxes: &[Aabb]) {
        if std::mem::take(&mut self.is_stale) {
            let known = self.geoms.iter().copied().filter(|&i| !boxes[i as usize].is_nan());
            self.tree.build(boxes, known);
        }
    }

    /// Calls `visit` for every fixed geom whose box overlaps `query`.
    pub fn overlapping(&self, boxes: &[Aabb], query: &Aabb, mut visit: impl FnMut(u32)) {
        self.tree.overlapping(query, |i| {
            if boxes[i as usize].overlaps(query) {
                visit(i);
            }
        });
    }
}
