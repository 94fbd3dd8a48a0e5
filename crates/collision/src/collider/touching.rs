//! The contact points of the pairs at hand.

use glamx::glam::DVec3;
use signorini_multibody::{BodyId, ContactPoint, GeomId, Model};

use super::Collider;
use crate::apart::Two;
use crate::feature::order_features;
use crate::partners::{geoms_of, pair_of};
use crate::placing::{half_space, place, place_set, rank};
use crate::reach::{PairReach, PairReaches, RelativeMotion, Within};
use crate::shape::Shape;

impl Collider {
    /// Finds the bounds of pairs that have one of their own.
    pub(super) fn bound_pairs(&mut self, relative: impl Fn([BodyId; 2], DVec3) -> RelativeMotion) {
        self.closer.known.clear();
        self.closer.is_directed = true;
        for &pair in &self.pairs {
            let (i, j) = geoms_of(pair);
            // A half-space has no size.
            let size = |k: usize| if self.geoms[k].size > 0.0 { self.geoms[k].size } else { f64::INFINITY };
            let smaller = if size(i) < size(j) { i } else { j };
            let (place, radius) = (self.placed[smaller].center, self.geoms[smaller].size);
            if PairReaches::is_worth_it(self.travel[i] + self.travel[j], radius) {
                let bodies = [i, j].map(|k| BodyId(self.geoms[k].body as u32));
                let motion = relative(bodies, place);
                self.closer.known.push(PairReach::new(pair, bodies, (place, radius), motion));
            }
        }
    }

    /// Up to which gap a pair is looked at, and the largest angle by which its geoms can turn against each other, rad.
    fn within(&mut self, i: usize, j: usize) -> (Within, f64) {
        let (margin, turn) = (self.travel[i] + self.travel[j], self.turn[i] + self.turn[j]);
        let own = self.laws.reach(i) + self.laws.reach(j);
        let is_directed = self.closer.is_directed;
        match self.closer.of(pair_of(i as u32, j as u32)) {
            Some(closer) => {
                let margin = margin.min(closer.travel() + own);
                let moving = is_directed.then_some((closer.motion, closer.radius, own));
                (Within { margin, moving }, turn.min(closer.reach.angular))
            }
            None => (Within { margin, moving: None }, turn),
        }
    }

    /// Appends the contact points of the pairs at hand.
    pub(super) fn touch_pairs(&mut self, model: &Model, out: &mut Vec<ContactPoint>) {
        for k in 0..self.pairs.len() {
            let pair = self.pairs[k];
            let (i, j) = geoms_of(pair);
            let within = self.within(i, j);
            let stands = self.still.stand([i, j]);
            if stands && self.still.take(pair, [i, j], &within, out) {
                continue;
            }
            let start = out.len();
            self.touch_pair(model, [i, j], within, out);
            if stands {
                self.still.keep(pair, within, &out[start..]);
            }
        }
        self.still.reserve(self.pairs.len(), out.len());
    }

    /// Appends the contact points of geoms `i < j`.
    fn touch_pair(&mut self, model: &Model, [i, j]: [usize; 2], within: (Within, f64), out: &mut Vec<ContactPoint>) {
        self.touches.clear();
        let origin = self.touch(i, j, within);
        let start = out.len();
        let [friction, margin] = self.laws.of_pair(model, i as u32, j as u32);
        let geoms = [GeomId(i as u32), GeomId(j as u32)];
        let bodies = [i, j].map(|k| model.geoms[k].body);
        out.extend(self.touches.iter().map(|t| {
            ContactPoint::new(geoms, bodies, t.position + origin, t.normal)
                .with_gap(t.gap - margin)
                .with_friction(friction)
                .with_feature(t.feature.code())
        }));
        order_features(&mut out[start..]);
    }

    /// Contact points of geoms `i < j` relative to the returned origin, normals from `i` to `j`.
    fn touch(&mut self, i: usize, j: usize, (within, turn): (Within, f64)) -> DVec3 {
        let margin = within.margin;
        let flip = rank(&self.geoms[i].shape) > rank(&self.geoms[j].shape);
        let (a, b) = if flip { (j, i) } else { (i, j) };
        let origin = self.placed[b].center;
        let (narrow, touches) = (&mut self.narrow, &mut self.touches);
        narrow.search.within = Within::default();
        narrow.reducer.turn = turn;
        match (&self.geoms[a].shape, &self.geoms[b].shape) {
            (Shape::HalfSpace, Shape::Convex(shape)) => {
                let placed = place(&self.geoms[b], shape, &self.placed[b], origin);
                let half_space = half_space(&self.placed[a], origin);
                half_space.touch(&placed, margin, narrow, touches);
                narrow.reducer.limit(touches, self.geoms[b].size);
            }
            (Shape::Convex(shape_a), Shape::Convex(shape_b)) => {
                let placed_a = place(&self.geoms[a], shape_a, &self.placed[a], origin);
                let placed_b = place(&self.geoms[b], shape_b, &self.placed[b], origin);
                let (pair, shapes) = (pair_of(i as u32, j as u32), (&placed_a, &placed_b));
                let two = Two::new(&self.geoms, &self.placed, pair);
                if self.apart.is_still(&two, margin) || self.apart.shows_apart(&two, shapes, margin) {
                    return origin;
                }
                narrow.search.within = within;
                (narrow.search.apart, narrow.search.excluded) = (None, None);
                narrow.convex(&placed_a, &placed_b, margin, touches);
                if let (Some(closer), Some(excluded)) = (self.closer.of(pair), narrow.search.excluded) {
                    closer.apart = Some(excluded);
                }
                if touches.is_empty() {
                    self.apart.keep(&two, shapes, margin, narrow.search.apart);
                }
            }
            (Shape::HalfSpace, Shape::Triangles(set)) => {
                let placed = place_set(set, &self.placed[b], origin);
                let half_space = half_space(&self.placed[a], origin);
                self.surface.half_space(&half_space, &placed, self.geoms[b].size, margin, narrow, touches);
            }
            (Shape::Triangles(set), Shape::Convex(shape)) => {
                let placed_a = place_set(set, &self.placed[a], origin);
                let placed_b = place(&self.geoms[b], shape, &self.placed[b], origin);
                self.surface.convex(&placed_a, &placed_b, self.geoms[b].half, margin, narrow, touches);
            }
            (Shape::Triangles(set_a), Shape::Triangles(set_b)) => {
                let placed_a = place_set(set_a, &self.placed[a], origin);
                let placed_b = place_set(set_b, &self.placed[b], origin);
                let size = self.geoms[a].size.min(self.geoms[b].size);
                self.surface.surfaces(&placed_a, &placed_b, size, margin, narrow, touches);
            }
            // Two half-spaces never move against each other.
            _ => {}
        }
        if flip {
            for touch in touches {
                touch.normal = -touch.normal;
                touch.feature = touch.feature.swapped();
            }
        }
        origin
    }
}
