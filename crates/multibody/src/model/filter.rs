//! Which geoms can touch.

use std::collections::BTreeSet;

use super::{Body, BodyId, Geom, GeomId, GeomPair};

/// Decides which pairs of geoms are looked at (MuJoCo's rules: explicit pairs always; otherwise the masks must meet, the
/// bodies must not be welded together, must not be parent and child unless the parent is the world, and must not be excluded).
#[derive(Clone, Debug, Default)]
pub struct ContactFilter {
    pairs: BTreeSet<(GeomId, GeomId)>,
    excluded: BTreeSet<(BodyId, BodyId)>,
    weld: Vec<BodyId>,
    /// For every body the root of its weld group, or the mocap body that carries it.
    carrier: Vec<BodyId>,
    /// For every body the carrier of what its weld group hangs on by joints.
    carrier_parent: Vec<BodyId>,
}

impl ContactFilter {
    /// - `bodies`: parents before children;
    /// - `weld`: for every body the root of its weld group.
    pub(super) fn new(pairs: &[GeomPair], excluded: &[(BodyId, BodyId)], bodies: &[Body], weld: Vec<BodyId>) -> Self {
        let mut carrier = weld.clone();
        for (i, body) in bodies.iter().enumerate().filter(|(i, _)| weld[*i] == BodyId::WORLD) {
            carrier[i] = if body.mocap.is_some() { BodyId(i as u32) } else { carrier[body.parent.index()] };
        }
        let carrier_parent = weld.iter().map(|root| carrier[bodies[root.index()].parent.index()]).collect();
        Self {
            pairs: pairs.iter().map(|p| ordered(p.geom_a, p.geom_b)).collect(),
            excluded: excluded.iter().map(|&(a, b)| ordered(a, b)).collect(),
            weld,
            carrier,
            carrier_parent,
        }
    }

    /// Whether geoms `ids.0` and `ids.1` (with their data in `geoms`) can touch.
    pub fn allows(&self, ids: (GeomId, GeomId), geoms: (&Geom, &Geom)) -> bool {
        let (a, b) = geoms;
        let (weld_a, weld_b) = (self.weld[a.body.index()], self.weld[b.body.index()]);
        if weld_a == weld_b {
            return false;
        }
        if self.pairs.contains(&ordered(ids.0, ids.1)) {
            return true;
        }
        let masks = a.contact_type & b.contact_affinity != 0 || b.contact_type & a.contact_affinity != 0;
        masks && !self.are_neighbours(a.body, b.body) && !self.excluded.contains(&ordered(a.body, b.body))
    }

    /// Pairs of bodies that are kept from touching, ordered.
    pub fn excluded_bodies(&self) -> impl Iterator<Item = &(BodyId, BodyId)> {
        self.excluded.iter()
    }

    /// Parent and child across a joint, the world not counted as a parent, a mocap body as one.
    fn are_neighbours(&self, a: BodyId, b: BodyId) -> bool {
        let is_parent = |p: BodyId, c: BodyId| {
            self.carrier[p.index()] != BodyId::WORLD && self.carrier_parent[c.index()] == self.carrier[p.index()]
        };
        is_parent(a, b) || is_parent(b, a)
    }
}

fn ordered<T: Ord>(a: T, b: T) -> (T, T) {
    if a <= b { (a, b) } else { (b, a) }
}
