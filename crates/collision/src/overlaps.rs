//! Parts of one mechanism that lie inside each other where the model says that it is at rest.
//!
//! Links are modelled with overlapping shapes where they meet: housings around axes, decomposed meshes, fingers in their palm. Such pairs
//! tell nothing about contact, whatever the joints do; planners leave out what collides in the default configuration (Coleman et al.
//! 2014, "Reducing the barrier to entry of complex robotic software", §III).

use signorini_multibody::{BodyId, EqualityKind, GeomId, Model, Pose};

use crate::collider::Collider;
use crate::partners::pair_of;
use crate::reach::Reach;

/// Two geoms of one mechanism that lie inside each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnOverlap {
    /// The geoms, ascending.
    pub geoms: [GeomId; 2],
    /// How deep, m.
    pub depth: f64,
}

impl Collider {
    /// The pairs of geoms of one mechanism that can meet and overlap at these poses, in order: of one kinematic tree, which is a child of the world
    /// with all that hangs on it, and of two bodies that a connection or a weld joins, as the links of a rope are. Pairs that the model names
    /// ([`Model::pairs`]) are wanted, and not among them.
    ///
    /// - `body_pose`: `X_WB`, `[bodies]`
    /// - `part`: overlaps up to this part of the smaller geom's radius do not count
    ///
    /// # Panics
    /// If `body_pose` is shorter than the model's list of bodies.
    pub fn own_overlaps(&mut self, model: &Model, body_pose: &[Pose], part: f64) -> Vec<OwnOverlap> {
        let trees = trees(model);
        let tree_of = |geom: GeomId| trees[model.geoms[geom.index()].body.index()];
        let named = |a: GeomId, b: GeomId| {
            let same = |pair: [GeomId; 2]| pair == [a, b] || pair == [b, a];
            model.pairs.iter().any(|pair| same([pair.geom_a, pair.geom_b]))
        };
        let reach = vec![Reach::default(); model.bodies.len()];
        let mut points = Vec::new();
        let joined = joined(model);
        let is_joined = |a: GeomId, b: GeomId| {
            let [a, b] = [a, b].map(|geom| model.body_weld[model.geoms[geom.index()].body.index()]);
            joined.binary_search(&pair_of(a.0, b.0)).is_ok()
        };
        let of_one = |a: GeomId, b: GeomId| {
            let of_world = [a, b].map(tree_of).contains(&BodyId::WORLD);
            !of_world && (tree_of(a) == tree_of(b) || is_joined(a, b)) && !named(a, b)
        };
        self.find_among(model, body_pose, &reach, of_one, &mut points);
        let mut found: Vec<OwnOverlap> = Vec::new();
        for point in &points {
            let geoms = [point.geom_a, point.geom_b];
            let size = geoms.map(|geom| model.geoms[geom.index()].geometry.bounding_radius());
            let depth = -point.gap;
            if depth <= part * size[0].min(size[1]) {
                continue;
            }
            match found.last_mut().filter(|last| last.geoms == geoms) {
                Some(last) => last.depth = last.depth.max(depth),
                None => found.push(OwnOverlap { geoms, depth }),
            }
        }
        found
    }
}

/// The pairs of bodies that a connection or a weld joins, each by the body that it is fixed to; in order.
fn joined(model: &Model) -> Vec<u64> {
    let mut joined = Vec::new();
    for equality in &model.equalities {
        if let EqualityKind::Connect { body_a, body_b, .. } | EqualityKind::Weld { body_a, body_b, .. } = equality.kind
        {
            let [a, b] = [body_a, body_b].map(|body| model.body_weld[body.index()]);
            joined.push(pair_of(a.0, b.0));
        }
    }
    joined.sort_unstable();
    joined
}

/// For every body the child of the world that it hangs on; the world for itself.
fn trees(model: &Model) -> Vec<BodyId> {
    let mut trees = vec![BodyId::WORLD; model.bodies.len()];
    // Parents come before their children.
    for (i, body) in model.bodies.iter().enumerate().skip(1) {
        trees[i] = if body.parent == BodyId::WORLD { BodyId(i as u32) } else { trees[body.parent.index()] };
    }
    trees
}
