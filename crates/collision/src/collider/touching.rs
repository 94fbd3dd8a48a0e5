//! The searches: pairs that could touch, and their contact points.

use glamx::glam::DVec3;
use signorini_multibody::{BodyId, ContactPoint, GeomId, Model, Pose};

use super::Collider;
use crate::apart::Two;
use crate::feature::order_features;
use crate::partners::{geoms_of, pair_of};
use crate::placing::{half_space, place, place_set, rank};
use crate::reach::{PairReach, PairReaches, Reach, RelativeMotion, Within};
use crate::shape::Shape;

impl Collider {
    /// Every point at which two geoms could touch within the step.
    ///
    /// A geom of a body with [`Reach`] `r` travels at most `r.linear + r.angular · (distance of its farthest point from
    /// the body's origin)`; a point is returned when its gap is at most the sum of both geoms' travels (somewhat more where a pair's own
    /// margin is not the sum of its geoms'). Points are
    /// ordered by `(geom_a, geom_b, feature)`, `geom_a < geom_b`; the result depends on nothing but the arguments.
    /// Geoms whose pose is not a number touch nothing. A body at rest still needs the reach of a step of free fall: with
    /// no reach at all a gap of one rounding error is too far.
    /// - `model`: the model this collider was made for;
    /// - `body_pose`: `X_WB`, `[bodies]`; `reach`: `[bodies]`;
    /// - `out`: cleared, then filled.
    ///
    /// # Cost
    /// No allocation once the buffers have grown to the scene.
    ///
    /// # Panics
    /// If `body_pose` or `reach` is shorter than the model's list of bodies.
    pub fn find(&mut self, model: &Model, body_pose: &[Pose], reach: &[Reach], out: &mut Vec<ContactPoint>) {
        self.find_among(model, body_pose, reach, |_, _| true, out);
    }

    /// As [`find`](Self::find), of the pairs that are wanted.
    pub(crate) fn find_among(
        &mut self,
        model: &Model,
        body_pose: &[Pose],
        reach: &[Reach],
        wanted: impl Fn(GeomId, GeomId) -> bool,
        out: &mut Vec<ContactPoint>,
    ) {
        out.clear();
        self.find_pairs(model, body_pose, (reach, &[]), wanted);
        self.closer.known.clear();
        self.touch_pairs(model, out);
    }

    /// As [`find`](Self::find), where of bodies that travel together is known how they can move against each other: what these motions cannot
    /// bring together is left out.
    ///
    /// - `reach`: `[bodies]`, and how far the origin of every body can move beside a common motion, m, `[bodies]`, where less than that can bring
    ///   two of them together, else empty;
    /// - `relative`: told two bodies and a place in world (m), how the second one can move against the first one, and its point there; not
    ///   asked for pairs that travel next to nothing
    ///
    /// # Panics
    /// As [`find`](Self::find).
    pub fn find_moving(
        &mut self,
        model: &Model,
        body_pose: &[Pose],
        (reach, beside): (&[Reach], &[f64]),
        relative: impl Fn([BodyId; 2], DVec3) -> RelativeMotion,
        out: &mut Vec<ContactPoint>,
    ) {
        out.clear();
        self.find_pairs(model, body_pose, (reach, beside), |_, _| true);
        self.bound_pairs(relative);
        self.touch_pairs(model, out);
    }

    /// The pairs of the last [`find_moving`](Self::find_moving) that were searched within less than both can travel.
    pub fn pair_reaches(&self) -> &[PairReach] {
        &self.closer.known
    }

    /// The contact points of one pair of geoms, as [`find`](Self::find) has them; after [`find_moving`](Self::find_moving) within the relative motion that
    /// this was told for the pair.
    ///
    /// - `pair`: two geoms that can touch, in any order
    ///
    /// # Panics
    /// If `body_pose` or `reach` is shorter than the model's list of bodies.
    pub fn find_pair(
        &mut self,
        model: &Model,
        body_pose: &[Pose],
        reach: &[Reach],
        pair: [GeomId; 2],
        out: &mut Vec<ContactPoint>,
    ) {
        out.clear();
        self.still.begin();
        self.place_all_anew();
        self.place_one(pair[0].index(), body_pose, reach);
        self.place_one(pair[1].index(), body_pose, reach);
        self.pairs.clear();
        self.pairs.push(pair_of(pair[0].0, pair[1].0));
        self.closer.is_directed = false;
        self.apart.begin();
        self.touch_pairs(model, out);
    }

    /// Places the geoms and finds the pairs that could touch.
    fn find_pairs(
        &mut self,
        model: &Model,
        body_pose: &[Pose],
        (reach, beside): (&[Reach], &[f64]),
        wanted: impl Fn(GeomId, GeomId) -> bool,
    ) {
        self.place(body_pose, reach);
        self.shrink_boxes(reach, beside);
        self.collect_pairs(model, wanted);
        self.apart.leave_out(&mut self.pairs, (&self.geoms, &self.placed), &self.travel);
    }

    /// Finds by how much smaller the boxes of geoms are beside a common motion.
    fn shrink_boxes(&mut self, reach: &[Reach], beside: &[f64]) {
        self.less.clear();
        if !beside.is_empty() && !self.swept.is_empty() {
            self.less.extend(self.geoms.iter().map(|geom| reach[geom.body].linear - beside[geom.body]));
        }
    }

    /// Finds the bounds of pairs that have one of their own.
    fn bound_pairs(&mut self, relative: impl Fn([BodyId; 2], DVec3) -> RelativeMotion) {
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
    fn touch_pairs(&mut self, model: &Model, out: &mut Vec<ContactPoint>) {
        self.closer.begin();
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
            // A further search of the same step mostly finds them where they are.
            self.still.keep(pair, within, &out[start..]);
        }
        self.still.reserve(self.pairs.len(), out.len());
    }

    /// Appends the contact points of geoms `i < j`.
    fn touch_pair(&mut self, model: &Model, [i, j]: [usize; 2], within: (Within, f64), out: &mut Vec<ContactPoint>) {
        self.touches.clear();
        let origin = self.touch(i, j, within);
        if self.touches.is_empty() {
            return;
        }
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
