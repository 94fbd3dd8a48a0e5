//! Pairs that were apart when they were looked at last, with a direction that showed it.
//!
//! What separated two shapes a step ago mostly does so again (Baraff 1992, §3). How far they are apart along a direction of one of them
//! changes by no more than what the other one has moved against it: as long as that leaves more than the margin nothing else is looked at.
//! Otherwise two supports along the direction mostly tell as much as a search. All this is a hint and no more. It is asked for somewhat more
//! than the margin, so that whatever it lets skip a search would not have found.

use glamx::glam::{DMat3, DVec3};

use crate::convex::{Convex, Placed, separation_along};
use crate::partners::geoms_of;
use crate::placing::GeomPose;
use crate::shape::Prepared;

/// Beyond the margin by this share of the sizes, no search takes the shapes for nearer.
const DOUBT: f64 = 1e-6;

/// How far two geoms were apart.
#[derive(Clone, Copy, Debug)]
struct Known {
    pair: u64,
    /// A unit vector from the larger geom to the smaller one, in the frame of the larger one.
    direction: DVec3,
    /// Their separation along it, m.
    gap: f64,
    /// The smaller one's rotation and centre in the frame of the larger one, whose centre is the origin.
    rotation: DMat3,
    center: DVec3,
    /// Whether that is of the search at hand.
    is_kept: bool,
}

/// The geoms of a pair in world.
#[derive(Clone, Copy)]
pub(crate) struct Two<'a> {
    pair: u64,
    geoms: [&'a Prepared; 2],
    poses: [&'a GeomPose; 2],
}

impl<'a> Two<'a> {
    /// - `geoms`, `poses`: of the whole model
    pub fn new(geoms: &'a [Prepared], poses: &'a [GeomPose], pair: u64) -> Self {
        let (i, j) = geoms_of(pair);
        Self { pair, geoms: [&geoms[i], &geoms[j]], poses: [&poses[i], &poses[j]] }
    }

    /// Whether the second one is larger.
    fn is_turned(&self) -> bool {
        self.geoms[1].size > self.geoms[0].size
    }

    /// Rotation and centre of the smaller one in the frame of the larger one.
    fn relative(&self) -> (DMat3, DVec3) {
        let [a, b] = self.poses;
        let (large, small) = if self.is_turned() { (b, a) } else { (a, b) };
        let frame = large.rotation.transpose();
        (frame * small.rotation, frame * (small.center - large.center))
    }

    /// A direction from the first to the second one in world as one from the larger to the smaller one in the frame of the larger one.
    fn seen(&self, direction: DVec3) -> DVec3 {
        let [a, b] = self.poses;
        if self.is_turned() { b.rotation.transpose() * -direction } else { a.rotation.transpose() * direction }
    }

    /// The reverse of [`seen`](Self::seen).
    fn in_world(&self, direction: DVec3) -> DVec3 {
        let [a, b] = self.poses;
        if self.is_turned() { b.rotation * -direction } else { a.rotation * direction }
    }

    fn smaller(&self) -> f64 {
        self.geoms[0].size.min(self.geoms[1].size)
    }

    fn doubt(&self) -> f64 {
        DOUBT * (self.geoms[0].size + self.geoms[1].size)
    }
}

impl Known {
    /// How far the geoms are apart at least, m.
    fn least(&self, two: &Two) -> f64 {
        let (rotation, center) = two.relative();
        let turned = rotation - self.rotation;
        // Two of the singular values of a difference of rotations are equal, the third one is zero.
        let norm = turned.x_axis.length_squared() + turned.y_axis.length_squared() + turned.z_axis.length_squared();
        self.gap + self.direction.dot(center - self.center) - (0.5 * norm).sqrt() * two.smaller()
    }
}

/// Directions of pairs, looked up in the order of the pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Apart {
    known: Vec<Known>,
    /// Pairs that were not known at the beginning of the search.
    new: Vec<Known>,
    next: usize,
}

impl Apart {
    /// Begins a search: leaves out the pairs that have moved so little since they were looked at that they are farther apart than both can
    /// travel.
    ///
    /// - `travel`: of every geom, m
    pub fn leave_out(&mut self, pairs: &mut Vec<u64>, (geoms, poses): (&[Prepared], &[GeomPose]), travel: &[f64]) {
        self.begin();
        pairs.retain(|&pair| {
            let (i, j) = geoms_of(pair);
            self.of(pair).is_none() || !self.is_still(&Two::new(geoms, poses, pair), travel[i] + travel[j])
        });
        self.next = 0;
    }

    /// Begins a search.
    pub fn begin(&mut self) {
        self.known.retain(|known| known.is_kept);
        if !self.new.is_empty() {
            self.known.append(&mut self.new);
            self.known.sort_unstable_by_key(|known| known.pair);
        }
        self.known.iter_mut().for_each(|known| known.is_kept = false);
        self.next = 0;
    }

    /// What is known of a pair that comes after those asked for.
    fn of(&mut self, pair: u64) -> Option<&mut Known> {
        while self.known.get(self.next).is_some_and(|known| known.pair < pair) {
            self.next += 1;
        }
        self.known.get_mut(self.next).filter(|known| known.pair == pair)
    }

    /// Whether a pair has moved so little that it is farther apart than `margin` (m).
    pub fn is_still(&mut self, two: &Two, margin: f64) -> bool {
        let Some(known) = self.of(two.pair) else { return false };
        known.is_kept = known.least(two) > margin + two.doubt();
        known.is_kept
    }

    /// Whether the direction known of a pair shows that it is farther apart than `margin` (m).
    ///
    /// - `a`, `b`: the shapes of the geoms in a common frame with the axes of world
    pub fn shows_apart(&mut self, two: &Two, (a, b): (&Placed, &Placed), margin: f64) -> bool {
        let Some(known) = self.of(two.pair) else { return false };
        let gap = separation_along(a, b, two.in_world(known.direction));
        if gap <= margin + two.doubt() {
            return false;
        }
        let (rotation, center) = two.relative();
        *known = Known { gap, rotation, center, is_kept: true, ..*known };
        true
    }

    /// Keeps a direction along which a pair is farther apart than `margin` (m) for the next search: what a search found, or that of the centres.
    /// Two spheres are searched as quickly as that is looked up.
    pub fn keep(&mut self, two: &Two, (a, b): (&Placed, &Placed), margin: f64, found: Option<DVec3>) {
        if let (Convex::Sphere { .. }, Convex::Sphere { .. }) = (a.shape, b.shape) {
            return;
        }
        let Some(direction) = found.or_else(|| (b.center - a.center).try_normalize()) else { return };
        let (pair, gap) = (two.pair, separation_along(a, b, direction));
        if gap > margin + two.doubt() {
            let (rotation, center) = two.relative();
            let found = Known { pair, direction: two.seen(direction), gap, rotation, center, is_kept: true };
            match self.of(pair) {
                Some(known) => *known = found,
                None => self.new.push(found),
            }
        }
    }
}
