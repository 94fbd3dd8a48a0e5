//! Friction and margins of pairs of geoms.

use signorini_multibody::{GeomId, Model};

/// What the contact points of every pair get besides their place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Laws {
    /// Pairs with a law of their own, with friction and margin, in order.
    own: Vec<(u32, u32, [f64; 2])>,
    /// Largest part of a geom in the margin of a pair, m.
    reach: Vec<f64>,
}

impl Laws {
    pub fn new(model: &Model) -> Self {
        let mut reach: Vec<f64> = model.geoms.iter().map(|geom| geom.margin).collect();
        let mut own: Vec<(u32, u32, [f64; 2])> = Vec::new();
        for pair in &model.pairs {
            let (a, b) = (pair.geom_a.0.min(pair.geom_b.0), pair.geom_a.0.max(pair.geom_b.0));
            let margin = model.pair_margin(GeomId(a), GeomId(b));
            own.push((a, b, [model.pair_friction(GeomId(a), GeomId(b)), margin]));
            // Where a pair's margin is more than those of its geoms, the search must reach as far.
            let missing = (margin - reach[a as usize] - reach[b as usize]).max(0.0);
            reach[a as usize] += missing;
        }
        own.sort_by_key(|p| (p.0, p.1));
        own.dedup_by_key(|p| (p.0, p.1));
        Self { own, reach }
    }

    /// How far beyond its surface the search for contacts of geom `k` must go, m.
    pub fn reach(&self, k: usize) -> f64 {
        self.reach[k]
    }

    /// Friction and margin (m) of a pair, `i < j`.
    pub fn of_pair(&self, model: &Model, i: u32, j: u32) -> [f64; 2] {
        if let Ok(k) = self.own.binary_search_by_key(&(i, j), |p| (p.0, p.1)) {
            return self.own[k].2;
        }
        let (a, b) = (&model.geoms[i as usize], &model.geoms[j as usize]);
        [a.friction_with(b), a.margin + b.margin]
    }
}
