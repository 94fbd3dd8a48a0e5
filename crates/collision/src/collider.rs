//! The search for contact points of a whole model.

use std::collections::BTreeSet;

use glamx::glam::DVec3;
use signorini_multibody::{BodyId, ContactPoint, GeomId, Geometry, Model, Pose};

use crate::CollisionError;
use crate::apart::{Apart, Two};
use crate::bvh::Aabb;
use crate::feature::order_features;
use crate::laws::Laws;
use crate::manifold::Touch;
use crate::narrow::Narrow;
use crate::partners::{Partners, geoms_of, pair_of, that_can_meet};
use crate::placing::{GeomPose, half_space, place, place_set, rank};
use crate::reach::{PairReach, PairReaches, Reach, RelativeMotion, Within};
use crate::shape::{KnownHulls, Prepared, Shape};
use crate::surface::Surface;
use crate::sweep::Sweep;

/// Finds the contact points of one model; holds its prepared shapes and all buffers.
#[derive(Clone, Debug)]
pub struct Collider {
    geoms: Vec<Prepared>,
    /// Geoms that can meet another one, half-spaces included; the others have no place.
    active: Vec<u32>,
    half_spaces: Vec<u32>,
    /// Bounded geoms that can meet another bounded geom; the others need not be swept.
    swept: Vec<u32>,
    /// Bounded geoms that can meet a half-space.
    over_half_spaces: Vec<u32>,
    partners: Partners,
    laws: Laws,
    placed: Vec<GeomPose>,
    boxes: Vec<Aabb>,
    /// How far every geom's contacts reach: its travel and its margin, m.
    travel: Vec<f64>,
    /// Largest angle every geom can turn within the step, rad.
    turn: Vec<f64>,
    /// Both geoms of each pair in one number, so that these sort as pairs do.
    pairs: Vec<u64>,
    /// Pairs whose bodies can move against each other by less than both can travel.
    closer: PairReaches,
    sweep: Sweep,
    apart: Apart,
    narrow: Narrow,
    surface: Surface,
    touches: Vec<Touch>,
}

impl Collider {
    /// From now on flat contacts keep all corners of their outlines, and discs have 96 points of their rims instead of 8: for questions of
    /// statics, in which a corner that is left out is support that is not there.
    pub fn keep_outlines_whole(&mut self) {
        self.narrow.keep_outlines_whole();
    }

    /// Prepares the shapes of a model.
    ///
    /// # Errors
    /// [`CollisionError::FlatHull`] for a convex mesh without volume.
    pub fn new(model: &Model) -> Result<Self, CollisionError> {
        Self::prepare(model, &[])
    }

    /// For a model with the same parts as this one's and other numbers: what was made of meshes and height fields stays. No pair is
    /// [excluded](Self::exclude).
    ///
    /// # Errors
    /// See [`new`](Self::new).
    pub fn renewed(&self, model: &Model) -> Result<Self, CollisionError> {
        Self::prepare(model, &self.geoms)
    }

    /// Takes over friction and margins of a model with the same parts, sizes and poses.
    pub fn take_laws(&mut self, model: &Model) {
        self.laws = Laws::new(model);
    }

    /// - `known`: geoms of a model with the same parts, or none
    fn prepare(model: &Model, known: &[Prepared]) -> Result<Self, CollisionError> {
        let is_half_space = |i: &u32| matches!(model.geoms[*i as usize].geometry, Geometry::Plane);
        let (half_spaces, bounded): (Vec<u32>, Vec<u32>) = (0..model.geoms.len() as u32).partition(is_half_space);
        let mut swept = that_can_meet(model, &bounded, &bounded);
        if swept.len() == 1 {
            swept.clear();
        }
        let mut over_half_spaces = that_can_meet(model, &bounded, &half_spaces);
        let mut half_spaces = that_can_meet(model, &half_spaces, &bounded);
        let mut active = [&half_spaces[..], &swept, &over_half_spaces].concat();
        active.sort_unstable();
        active.dedup();
        let partners = Partners::new(model, &active);
        for list in [&mut half_spaces, &mut swept, &mut over_half_spaces, &mut active] {
            list.retain(|&i| partners.has_any(i));
        }
        let mut hulls = KnownHulls::default();
        let geoms = (0..).zip(&model.geoms).map(|(i, geom)| match (active.binary_search(&i), known.get(i as usize)) {
            (Ok(_), Some(before)) if before.is_of_mesh() => Ok(before.moved(geom)),
            (Ok(_), _) => Prepared::new(geom, &mut hulls),
            (Err(_), _) => Ok(Prepared::absent(geom)),
        });
        let geoms = geoms.collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            placed: vec![GeomPose::default(); geoms.len()],
            boxes: vec![Aabb { low: DVec3::ZERO, high: DVec3::ZERO }; geoms.len()],
            travel: vec![0.0; geoms.len()],
            turn: vec![0.0; geoms.len()],
            geoms,
            active,
            half_spaces,
            swept,
            over_half_spaces,
            partners,
            laws: Laws::new(model),
            pairs: Vec::new(),
            closer: PairReaches::default(),
            sweep: Sweep::default(),
            apart: Apart::default(),
            narrow: Narrow::default(),
            surface: Surface::default(),
            touches: Vec::new(),
        })
    }

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
        self.place(body_pose, reach);
        self.collect_pairs(model, wanted);
        self.apart.leave_out(&mut self.pairs, (&self.geoms, &self.placed), &self.travel);
        self.closer.known.clear();
        self.touch_pairs(model, out);
    }

    /// As [`find`](Self::find), where of bodies that travel together is known how they can move against each other: what these motions cannot
    /// bring together is left out.
    ///
    /// - `relative`: told two bodies and a place in world (m), how the second one can move against the first one, and its point there; not
    ///   asked for pairs that travel next to nothing
    ///
    /// # Panics
    /// As [`find`](Self::find).
    pub fn find_moving(
        &mut self,
        model: &Model,
        body_pose: &[Pose],
        reach: &[Reach],
        relative: impl Fn([BodyId; 2], DVec3) -> RelativeMotion,
        out: &mut Vec<ContactPoint>,
    ) {
        out.clear();
        self.place(body_pose, reach);
        self.collect_pairs(model, |_, _| true);
        self.apart.leave_out(&mut self.pairs, (&self.geoms, &self.placed), &self.travel);
        self.bound_pairs(relative);
        self.touch_pairs(model, out);
    }

    /// The pairs of the last [`find_moving`](Self::find_moving) that were searched within less than both can travel.
    pub fn pair_reaches(&self) -> &[PairReach] {
        &self.closer.known
    }

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
        for k in 0..self.pairs.len() {
            let (i, j) = geoms_of(self.pairs[k]);
            self.touches.clear();
            let origin = self.touch(i, j);
            let (i, j) = (i as u32, j as u32);
            let start = out.len();
            let [friction, margin] = self.laws.of_pair(model, i, j);
            let (a, b) = (&model.geoms[i as usize], &model.geoms[j as usize]);
            let (geoms, bodies) = ([GeomId(i), GeomId(j)], [a.body, b.body]);
            out.extend(self.touches.iter().map(|t| {
                ContactPoint::new(geoms, bodies, t.position + origin, t.normal)
                    .with_gap(t.gap - margin)
                    .with_friction(friction)
                    .with_feature(t.feature.code())
            }));
            order_features(&mut out[start..]);
        }
    }

    /// The contact points of one pair of geoms, as [`find`](Self::find) has them.
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
        self.place_one(pair[0].index(), body_pose, reach);
        self.place_one(pair[1].index(), body_pose, reach);
        self.pairs.clear();
        self.pairs.push(pair_of(pair[0].0, pair[1].0));
        self.closer.is_directed = false;
        self.apart.begin();
        self.touch_pairs(model, out);
    }

    /// Lets these pairs of geoms touch no more.
    pub fn exclude(&mut self, pairs: impl IntoIterator<Item = [GeomId; 2]>) {
        pairs.into_iter().for_each(|[a, b]| self.partners.exclude(a.0, b.0));
        let partners = &self.partners;
        for list in [&mut self.half_spaces, &mut self.swept, &mut self.over_half_spaces, &mut self.active] {
            list.retain(|&i| partners.has_any(i));
        }
    }

    /// The bodies of geoms that can touch another one, ascending; the reach of the others is not looked at.
    pub fn touching_bodies(&self) -> impl Iterator<Item = BodyId> {
        let bodies: BTreeSet<u32> = self.active.iter().map(|&k| self.geoms[k as usize].body as u32).collect();
        bodies.into_iter().map(BodyId)
    }

    /// `X_WG` of a geom, m.
    pub fn geom_pose(&self, geom: GeomId, body_pose: &[Pose]) -> Pose {
        let prepared = &self.geoms[geom.index()];
        body_pose[prepared.body] * prepared.placement
    }

    /// World poses, travels and the boxes around all that the geoms can reach.
    fn place(&mut self, body_pose: &[Pose], reach: &[Reach]) {
        for at in 0..self.active.len() {
            self.place_one(self.active[at] as usize, body_pose, reach);
        }
    }

    fn place_one(&mut self, k: usize, body_pose: &[Pose], reach: &[Reach]) {
        let geom = &self.geoms[k];
        let body = body_pose[geom.body];
        let pose = if geom.placement == Pose::IDENTITY { body } else { body * geom.placement };
        let rotation = pose.rotation_matrix();
        let center = rotation * geom.center + pose.position;
        let reach = reach[geom.body];
        let travel = reach.linear + reach.angular * geom.arm + self.laws.reach(k);
        if !self.swept.is_empty() {
            let half = rotation.abs() * geom.half + DVec3::splat(travel);
            self.boxes[k] = Aabb { low: center - half, high: center + half };
        }
        self.placed[k] = GeomPose { rotation, position: pose.position, center };
        self.travel[k] = travel;
        self.turn[k] = reach.angular;
    }

    /// Pairs that can touch, in order.
    fn collect_pairs(&mut self, model: &Model, wanted: impl Fn(GeomId, GeomId) -> bool) {
        self.pairs.clear();
        let (geoms, pairs) = (&self.geoms, &mut self.pairs);
        let partners = &self.partners;
        let allowed = |i: u32, j: u32| partners.allow(model, i, j) && wanted(GeomId(i.min(j)), GeomId(i.max(j)));
        for &h in &self.half_spaces {
            let plane = &self.placed[h as usize];
            let normal = plane.rotation.z_axis;
            for &i in &self.over_half_spaces {
                let k = i as usize;
                let margin = self.travel[k] + self.travel[h as usize];
                let height = normal.dot(self.placed[k].center - plane.position) - geoms[k].size;
                if height <= margin && allowed(h, i) {
                    pairs.push(pair_of(h, i));
                }
            }
        }
        self.sweep.overlapping(&self.boxes, &self.swept, |i, j| {
            if allowed(i.min(j), i.max(j)) {
                pairs.push(pair_of(i, j));
            }
        });
        pairs.sort_unstable();
    }

    /// Contact points of geoms `i < j` relative to the returned origin, normals from `i` to `j`.
    fn touch(&mut self, i: usize, j: usize) -> DVec3 {
        let (within, turn) = self.within(i, j);
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
