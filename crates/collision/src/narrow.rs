//! Contact points of one pair of shapes.

use glamx::glam::DVec3;

use crate::capsule;
use crate::convex::{Convex, Placed, scale};
use crate::ellipsoids;
use crate::feature::Feature;
use crate::hull::Visited;
use crate::manifold::{Manifold, Touch};
use crate::reduce::Reducer;
use crate::search::{Search, TOUCHING};
use crate::separation::{self, Separation};

/// Patches that miss each other by less than this share of the size still touch.
const LATERAL: f64 = 1e-9;
/// A patch contact deeper than the separation by no more than this share of the size realises it.
pub(crate) const REALISED: f64 = 1e-8;

/// An overlap of no more than this share of the size is shallow.
const SHALLOW: f64 = 1e-5;

/// Buffers of the narrow phase.
#[derive(Clone, Debug, Default)]
pub(crate) struct Narrow {
    pub manifold: Manifold,
    pub search: Search,
    pub reducer: Reducer,
    pub visited: Visited,
}

impl Narrow {
    /// Keeps all corners of flat contacts, and takes discs by many points.
    pub fn keep_outlines_whole(&mut self) {
        self.reducer.is_whole = true;
        (self.manifold.patch_a.is_fine, self.manifold.patch_b.is_fine) = (true, true);
    }

    /// Appends the contact points of two convex shapes within `margin` (m), the normal from A to B.
    pub fn convex(&mut self, a: &Placed, b: &Placed, margin: f64, out: &mut Vec<Touch>) {
        let from = out.len();
        if let (&Convex::Capsule { radius: ra, half_length: ha }, &Convex::Capsule { radius: rb, half_length: hb }) =
            (a.shape, b.shape)
        {
            capsule::capsules((a, ra, ha), (b, rb, hb), margin, out);
            return capsule::drop_redundant(out, from, LATERAL * scale(a, b));
        }
        self.touch(a, b, margin, out);
    }

    /// Appends the contact points along the direction in which the shapes are farthest apart and returns that
    /// direction, or `None` if they are more than `margin` apart.
    ///
    /// Closed-form directions come first. Where the facing patches attain the gap of the best of them, it is the
    /// distance (for shapes apart) or a least overlap (for shallow overlaps), and no search is needed.
    pub fn touch(&mut self, a: &Placed, b: &Placed, margin: f64, out: &mut Vec<Touch>) -> Option<Separation> {
        let (size, from) = (scale(a, b), out.len());
        let first = match (a.shape, b.shape) {
            (_, Convex::Sphere { radius }) => {
                return push_closest(separation::sphere(a, b, *radius, margin), out);
            }
            (Convex::Sphere { radius }, _) => {
                return push_closest(separation::sphere(b, a, *radius, margin).map(Separation::swapped), out);
            }
            (Convex::Box { half: half_a }, Convex::Box { half: half_b }) => {
                let first = separation::boxes(a, b, *half_a, *half_b, margin)?;
                if self.search.excludes(first.normal, first.gap) {
                    return None;
                }
                first
            }
            (Convex::Ellipsoid { .. }, Convex::Ellipsoid { .. }) => match ellipsoids::separation(a, b) {
                Some(found) => return push_closest(self.search.keep_within(found, margin), out),
                None => self.search.axis(a, b, margin)?,
            },
            _ => self.search.axis(a, b, margin)?,
        };
        let closed_form = matches!((a.shape, b.shape), (Convex::Box { .. }, Convex::Box { .. }));
        if closed_form || first.gap >= -SHALLOW * size {
            let smallest = self.patches(a, b, &first, size, out);
            if smallest <= first.gap + REALISED * size {
                self.reducer.outline(out, from, margin, size);
                return Some(first);
            }
            out.truncate(from);
        }
        let axis = if closed_form { self.search.axis(a, b, margin)? } else { first };
        let exact = self.search.general(a, b, axis, margin)?;
        let smallest = self.patches(a, b, &exact, size, out);
        if smallest > exact.gap + REALISED * size {
            let closest = self.closest(a, b, exact, size, out);
            push_closest(Some(closest), out);
        }
        self.reducer.outline(out, from, margin, size);
        Some(exact)
    }

    /// Clips the patches of A and B that face each other along the normal. No point of theirs is closer than the shapes are along it: what is below
    /// that is how far a face of a hull is from its plane, which a steep face makes many times larger along the normal.
    pub fn patches(&mut self, a: &Placed, b: &Placed, s: &Separation, size: f64, out: &mut Vec<Touch>) -> f64 {
        self.manifold.patch_a.fill(a, s.normal);
        self.manifold.patch_b.fill(b, -s.normal);
        let from = out.len();
        let smallest = self.manifold.clip(s.normal, LATERAL * size, out);
        for touch in out[from..].iter_mut().filter(|touch| touch.gap < s.gap - REALISED * size) {
            touch.gap = s.gap;
        }
        smallest
    }

    /// A separation with a point midway between what touches there. The closest points of shapes that are apart are sure; where they touch or overlap,
    /// what reaches farthest along the normal says more, if it faces each other. `buffer` is as before afterwards.
    pub fn closest(
        &mut self,
        a: &Placed,
        b: &Placed,
        found: Separation,
        size: f64,
        buffer: &mut Vec<Touch>,
    ) -> Separation {
        if found.gap > TOUCHING * size && found.midpoint.is_some() {
            return found;
        }
        self.manifold.patch_a.fill_farthest(a, found.normal, REALISED * size);
        self.manifold.patch_b.fill_farthest(b, -found.normal, REALISED * size);
        let from = buffer.len();
        self.manifold.clip(found.normal, LATERAL * size, buffer);
        let middle = middle_of(&buffer[from..]);
        buffer.truncate(from);
        match middle {
            Some(middle) => Separation { midpoint: Some(middle), ..found },
            None => self.search.with_point(found, a, b),
        }
    }
}

/// The mean of the places of some contacts.
fn middle_of(touches: &[Touch]) -> Option<DVec3> {
    (!touches.is_empty()).then(|| touches.iter().map(|touch| touch.position).sum::<DVec3>() / touches.len() as f64)
}

fn push_closest(separation: Option<Separation>, out: &mut Vec<Touch>) -> Option<Separation> {
    if let Some(Separation { normal, gap, midpoint: Some(position) }) = separation {
        out.push(Touch { position, normal, gap, feature: Feature::Closest });
    }
    separation
}
