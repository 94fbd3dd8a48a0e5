//! The search for contact points of a whole model.

mod touching;

use std::collections::BTreeSet;
use std::ops::Range;

use glamx::glam::DVec3;
use signorini_multibody::{BodyId, GeomId, Geometry, Model, Pose};

use crate::CollisionError;
use crate::apart::Apart;
use crate::bvh::Aabb;
use crate::fixed::{FixedGeoms, is_fixed};
use crate::laws::Laws;
use crate::manifold::Touch;
use crate::narrow::Narrow;
use crate::neighbours::Neighbours;
use crate::partners::{Partners, pair_of, that_can_meet};
use crate::placing::GeomPose;
use crate::reach::{PairReaches, Reach};
use crate::shape::{KnownHulls, Prepared};
use crate::still::Still;
use crate::surface::Surface;

/// Squares of distances are compared with this factor, which is more than rounding.
const BEYOND_DOUBT: f64 = 1.0 + 1e-9;

/// Finds the contact points of one model; holds its prepared shapes and all buffers.
#[derive(Clone, Debug)]
pub struct Collider {
    geoms: Vec<Prepared>,
    /// Geoms that can meet another one, half-spaces included; the others have no place.
    active: Vec<u32>,
    half_spaces: Vec<u32>,
    /// Bounded geoms that can meet another bounded geom and that can move; the others need not be swept.
    swept: Vec<u32>,
    /// ... and those that cannot move.
    fixed: FixedGeoms,
    /// Of the swept geoms those whose bodies stand ([`let_stand`](Collider::let_stand)), and the others.
    standing: FixedGeoms,
    moving: Vec<u32>,
    /// For each geom whether it cannot move, and whether that is so or it stands.
    is_fixed: Vec<bool>,
    stands: Vec<bool>,
    /// Bounded geoms that can meet a half-space.
    over_half_spaces: Vec<u32>,
    /// The active geoms of one body after another, as they were placed last.
    runs: Vec<Run>,
    partners: Partners,
    laws: Laws,
    placed: Vec<GeomPose>,
    boxes: Vec<Aabb>,
    /// By how much the box of every geom is smaller on all sides for what shares a common motion, m; empty where nothing is known of one.
    less: Vec<f64>,
    /// How far every geom's contacts reach: its travel and its margin, m.
    travel: Vec<f64>,
    /// Largest angle every geom can turn within the step, rad.
    turn: Vec<f64>,
    /// Both geoms of each pair in one number, so that these sort as pairs do.
    pairs: Vec<u64>,
    /// Pairs whose bodies can move against each other by less than both can travel.
    closer: PairReaches,
    neighbours: Neighbours,
    apart: Apart,
    still: Still,
    narrow: Narrow,
    surface: Surface,
    touches: Vec<Touch>,
}

impl Collider {
    /// From now on flat contacts keep all corners of their outlines, and discs have 96 points of their rims instead of 8: for questions of
    /// statics, in which a corner that is left out is support that is not there.
    pub fn keep_outlines_whole(&mut self) {
        self.narrow.keep_outlines_whole();
        self.still.forget();
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
        self.still.forget();
        self.place_all_anew();
    }

    /// - `known`: geoms of a model with the same parts, or none
    fn prepare(model: &Model, known: &[Prepared]) -> Result<Self, CollisionError> {
        let is_half_space = |i: &u32| matches!(model.geoms[*i as usize].geometry, Geometry::Plane);
        let (half_spaces, bounded): (Vec<u32>, Vec<u32>) = (0..model.geoms.len() as u32).partition(is_half_space);
        let moves = |i: &u32| !is_fixed(model, *i);
        let (mut swept, mut fixed): (Vec<u32>, Vec<u32>) =
            that_can_meet(model, &bounded, &bounded).into_iter().partition(moves);
        if swept.is_empty() || swept.len() == 1 && fixed.is_empty() {
            (swept, fixed) = (Vec::new(), Vec::new());
        }
        let mut over_half_spaces = that_can_meet(model, &bounded, &half_spaces);
        if !half_spaces.iter().any(moves) {
            over_half_spaces.retain(moves);
        }
        let mut half_spaces = that_can_meet(model, &half_spaces, &bounded);
        let mut active = [&half_spaces[..], &swept, &fixed, &over_half_spaces].concat();
        active.sort_unstable();
        active.dedup();
        let partners = Partners::new(model, &active);
        for list in [&mut half_spaces, &mut swept, &mut fixed, &mut over_half_spaces, &mut active] {
            list.retain(|&i| partners.has_any(i));
        }
        let mut hulls = KnownHulls::default();
        let geoms = (0..).zip(&model.geoms).map(|(i, geom)| match (active.binary_search(&i), known.get(i as usize)) {
            (Ok(_), Some(before)) if before.is_of_mesh() => Ok(before.moved(geom)),
            (Ok(_), _) => Prepared::new(geom, &mut hulls),
            (Err(_), _) => Ok(Prepared::absent(geom)),
        });
        let geoms = geoms.collect::<Result<Vec<_>, _>>()?;
        let is_fixed: Vec<bool> = (0..geoms.len() as u32).map(|i| is_fixed(model, i)).collect();
        Ok(Self {
            runs: runs(&geoms, &active),
            standing: FixedGeoms::default(),
            moving: swept.clone(),
            stands: is_fixed.clone(),
            is_fixed,
            placed: vec![GeomPose::default(); geoms.len()],
            boxes: vec![Aabb { low: DVec3::ZERO, high: DVec3::ZERO }; geoms.len()],
            less: Vec::with_capacity(geoms.len()),
            travel: vec![0.0; geoms.len()],
            turn: vec![0.0; geoms.len()],
            still: Still::new(geoms.len()),
            geoms,
            active,
            half_spaces,
            swept,
            fixed: FixedGeoms::new(fixed),
            over_half_spaces,
            partners,
            laws: Laws::new(model),
            pairs: Vec::new(),
            closer: PairReaches::default(),
            neighbours: Neighbours::default(),
            apart: Apart::default(),
            narrow: Narrow::default(),
            surface: Surface::default(),
            touches: Vec::new(),
        })
    }

    /// Lets these pairs of geoms touch no more.
    pub fn exclude(&mut self, pairs: impl IntoIterator<Item = [GeomId; 2]>) {
        pairs.into_iter().for_each(|[a, b]| self.partners.exclude(a.0, b.0));
        let partners = &self.partners;
        for list in [&mut self.half_spaces, &mut self.swept, &mut self.over_half_spaces, &mut self.active] {
            list.retain(|&i| partners.has_any(i));
        }
        self.fixed.retain(|i| partners.has_any(i));
        self.neighbours.forget();
        self.runs = runs(&self.geoms, &self.active);
        self.let_stand(|_| false);
    }

    /// Takes bodies for standing until it is told otherwise: they stay where the next search has them, and geoms of theirs are searched against those of bodies that
    /// move alone.
    pub fn let_stand(&mut self, stands: impl Fn(BodyId) -> bool) {
        let stands = |run: &Run| stands(BodyId(run.body as u32));
        for run in &mut self.runs {
            run.stands = stands(run);
            if run.stands {
                run.placed = None;
            }
            for &i in &self.active[run.geoms.clone()] {
                self.stands[i as usize] = run.stands || self.is_fixed[i as usize];
            }
        }
        let is_standing = |i: &u32| self.stands[*i as usize];
        self.moving.clear();
        self.moving.extend(self.swept.iter().copied().filter(|i| !is_standing(i)));
        self.standing.hold(self.swept.iter().copied().filter(is_standing));
        self.neighbours.forget();
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
        self.still.begin();
        for k in 0..self.runs.len() {
            let (body, run) = (self.runs[k].body, &mut self.runs[k]);
            if run.stands && run.placed.is_some() {
                continue;
            }
            let now = (body_pose[body], reach[body]);
            if run.placed != Some(now) {
                run.placed = Some(now);
                run.geoms.clone().for_each(|at| self.place_one(self.active[at] as usize, body_pose, reach));
            }
        }
        self.fixed.refresh(&self.boxes);
        self.standing.refresh(&self.boxes);
    }

    /// Takes no geom for placed.
    fn place_all_anew(&mut self) {
        self.runs.iter_mut().for_each(|run| run.placed = None);
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
            self.fixed.note_moved(k as u32);
            self.standing.note_moved(k as u32);
            let half = rotation.abs() * geom.half + DVec3::splat(travel);
            self.boxes[k] = Aabb { low: center - half, high: center + half };
        }
        let placed = GeomPose { rotation, position: pose.position, center };
        if placed != self.placed[k] || travel != self.travel[k] || reach.angular != self.turn[k] {
            self.still.note_moved(k);
        }
        self.placed[k] = placed;
        self.travel[k] = travel;
        self.turn[k] = reach.angular;
    }

    /// Pairs that can touch, in order.
    fn collect_pairs(&mut self, model: &Model, wanted: impl Fn(GeomId, GeomId) -> bool) {
        self.pairs.clear();
        let (geoms, pairs) = (&self.geoms, &mut self.pairs);
        let partners = &self.partners;
        let is_wanted = |i: u32, j: u32| wanted(GeomId(i.min(j)), GeomId(i.max(j)));
        for &h in &self.half_spaces {
            let plane = &self.placed[h as usize];
            let normal = plane.rotation.z_axis;
            for &i in &self.over_half_spaces {
                let k = i as usize;
                if self.stands[k] && self.stands[h as usize] {
                    continue;
                }
                let margin = self.travel[k] + self.travel[h as usize];
                let height = normal.dot(self.placed[k].center - plane.position) - geoms[k].size;
                if height <= margin && partners.allow(model, h, i) && is_wanted(h, i) {
                    pairs.push(pair_of(h, i));
                }
            }
        }
        let (placed, travel) = (&self.placed, &self.travel);
        let mut meet = |i: u32, j: u32| {
            if is_wanted(i, j) && !are_far(geoms, placed, travel, [i, j].map(|k| k as usize)) {
                pairs.push(pair_of(i, j));
            }
        };
        let boxes = (&self.boxes[..], &self.less[..]);
        let size = |i: u32| geoms[i as usize].size;
        self.neighbours.overlapping(boxes, &self.moving, size, |i, j| partners.allow(model, i, j), &mut meet);
        for &i in &self.moving {
            for others in [&self.fixed, &self.standing] {
                others.overlapping(&self.boxes, &self.boxes[i as usize], |j| {
                    if partners.allow(model, i, j) {
                        meet(i, j);
                    }
                });
            }
        }
        pairs.sort_unstable();
    }
}

/// Whether the balls around two geoms are farther apart than these can travel: the boxes of balls overlap twice as often.
fn are_far(geoms: &[Prepared], placed: &[GeomPose], travel: &[f64], [i, j]: [usize; 2]) -> bool {
    let reach = geoms[i].size + geoms[j].size + travel[i] + travel[j];
    (placed[i].center - placed[j].center).length_squared() > BEYOND_DOUBT * reach * reach
}

/// Active geoms in a row that belong to one body.
#[derive(Clone, Debug)]
struct Run {
    body: usize,
    /// Places in the list of active geoms.
    geoms: Range<usize>,
    /// Pose and reach of the body with which they were placed last.
    placed: Option<(Pose, Reach)>,
    /// Whether the body stands.
    stands: bool,
}

/// The runs of bodies among active geoms.
fn runs(geoms: &[Prepared], active: &[u32]) -> Vec<Run> {
    let body = |at: usize| geoms[active[at] as usize].body;
    let mut runs: Vec<Run> = Vec::new();
    for at in 0..active.len() {
        match runs.last_mut().filter(|run| run.body == body(at)) {
            Some(run) => run.geoms.end = at + 1,
            None => runs.push(Run { body: body(at), geoms: at..at + 1, placed: None, stands: false }),
        }
    }
    runs
}
