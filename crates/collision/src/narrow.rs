//! Contact points of one pair of shapes.

use crate::capsule;
use crate::convex::{Convex, Placed};
use crate::feature::Feature;
use crate::manifold::{Manifold, Touch};
use crate::reduce::Reducer;
use crate::separation::{self, Search, Separation};

/// Patches that miss each other by less than this share of the size still touch.
const LATERAL: f64 = 1e-9;
/// A patch contact deeper than the separation by no more than this share of the size realises it.
const REALISED: f64 = 1e-8;

/// Buffers of the narrow phase.
#[derive(Clone, Debug, Default)]
pub(crate) struct Narrow {
    pub manifold: Manifold,
    pub search: Search,
    pub reducer: Reducer,
}

impl Narrow {
    /// Appends the contact points of two convex shapes within `margin` (m), the normal from A to B.
    pub fn convex(&mut self, a: &Placed, b: &Placed, margin: f64, out: &mut Vec<Touch>) {
        let from = out.len();
        if let (
            &Convex::Capsule { radius: ra, half_length: ha },
            &Convex::Capsule { radius: rb, half_length: hb },
        ) = (a.shape, b.shape)
        {
            capsule::capsules((a, ra, ha), (b, rb, hb), margin, out);
            return capsule::drop_redundant(out, from, LATERAL * (a.size + b.size));
        }
        if let Some(found) = self.separation(a, b, margin) {
            self.realise(a, b, found, margin, out);
        }
    }

    /// The direction in which the shapes are farthest apart, or `None` if that is more than `margin`.
    pub fn separation(&mut self, a: &Placed, b: &Placed, margin: f64) -> Option<Separation> {
        match (a.shape, b.shape) {
            (_, Convex::Sphere { radius }) => separation::sphere(a, b, *radius, margin),
            (Convex::Sphere { radius }, _) => separation::sphere(b, a, *radius, margin).map(Separation::swapped),
            (Convex::Box { half: half_a }, Convex::Box { half: half_b }) => {
                separation::boxes(a, b, *half_a, *half_b, margin)
            }
            _ => self.search.general(a, b, margin),
        }
    }

    /// Appends the points at which the separation is attained: the overlap of the facing patches if it attains it, else
    /// the closest points.
    pub fn realise(&mut self, a: &Placed, b: &Placed, first: Separation, margin: f64, out: &mut Vec<Touch>) {
        let is_sphere = |p: &Placed| matches!(p.shape, Convex::Sphere { .. });
        if is_sphere(a) || is_sphere(b) {
            return push_closest(Some(first), out);
        }
        let size = a.size + b.size;
        let from = out.len();
        let mut found = first;
        let mut smallest = self.patches(a, b, &found, size, out);
        if smallest > found.gap + REALISED * size && found.midpoint.is_none() {
            out.truncate(from);
            let Some(exact) = self.search.general(a, b, margin) else { return };
            found = exact;
            smallest = self.patches(a, b, &found, size, out);
        }
        if smallest > found.gap + REALISED * size {
            push_closest(Some(found), out);
        }
        self.reducer.outline(out, from, margin, size);
    }

    /// Clips the patches of A and B that face each other along the normal.
    pub fn patches(&mut self, a: &Placed, b: &Placed, s: &Separation, size: f64, out: &mut Vec<Touch>) -> f64 {
        self.manifold.patch_a.fill(a, s.normal);
        self.manifold.patch_b.fill(b, -s.normal);
        self.manifold.clip(s.normal, LATERAL * size, out)
    }
}

fn push_closest(separation: Option<Separation>, out: &mut Vec<Touch>) {
    if let Some(Separation { normal, gap, midpoint: Some(position) }) = separation {
        out.push(Touch { position, normal, gap, feature: Feature::Closest });
    }
}
