//! How far bodies can move within a step, and how far those of a pair can move against each other.
//!
//! Bodies that travel together, such as neighbouring links of a robot that falls or the items on a belt, come near each other by their
//! relative motion alone. Where that is bounded by less than what both can travel, the search of the pair ends there; and shapes that are
//! farther apart along a direction than they can approach along it have no contact point that could close.

use glamx::glam::DVec3;
use signorini_multibody::BodyId;

/// Where both bodies travel less than this share of the smaller geom's size a closer bound finds next to no fewer points; it was chosen so
/// that piles at rest, whose bodies can fall by 1e-4 m in a step, do not ask for one.
const WORTH: f64 = 1e-3;

/// How far a body can travel within the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Largest distance the body's origin can move, m.
    pub linear: f64,
    /// Largest angle the body can turn, rad.
    pub angular: f64,
}

/// What is known of how body B can move against body A within the step: by one of several motions, and beside that by so much in any direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativeMotion {
    /// Displacements of B's point at the place against A, m, world axes.
    pub linear: [DVec3; 2],
    /// Rotation vectors of B against A, rad, world axes.
    pub angular: [DVec3; 2],
    /// Beside them, m and rad.
    pub besides: Reach,
}

impl RelativeMotion {
    /// How far B's point at the place can move, and by which angle B can turn.
    fn reach(&self) -> Reach {
        let longest = |[a, b]: [DVec3; 2]| a.length_squared().max(b.length_squared()).sqrt();
        Reach {
            linear: longest(self.linear) + self.besides.linear,
            angular: longest(self.angular) + self.besides.angular,
        }
    }

    /// How far any point within `radius` (m) of the place can come against the unit normal from A to B, m.
    pub(crate) fn approach(&self, normal: DVec3, radius: f64) -> f64 {
        let along = |k: usize| normal.cross(self.angular[k]).length() * radius - normal.dot(self.linear[k]);
        along(0).max(along(1)).max(0.0) + self.besides.linear + self.besides.angular * radius
    }
}

/// A pair of geoms that was searched within less than both can travel.
#[derive(Clone, Copy, Debug)]
pub struct PairReach {
    /// The bodies A and B.
    pub bodies: [BodyId; 2],
    /// A place in world, m: the centre of the smaller geom.
    pub place: DVec3,
    /// Radius of a ball about it that holds this geom, m.
    pub radius: f64,
    /// How far B's point at the place could move against A, and by which angle B could turn against A.
    pub reach: Reach,
    /// Where the geoms have no contact point because they cannot come together: the unit normal from A to B along which they are apart,
    /// and by how much, m.
    pub apart: Option<(DVec3, f64)>,
    pub(crate) pair: u64,
    pub(crate) motion: RelativeMotion,
}

impl PairReach {
    pub(crate) fn new(pair: u64, bodies: [BodyId; 2], (place, radius): (DVec3, f64), motion: RelativeMotion) -> Self {
        Self { bodies, place, radius, reach: motion.reach(), apart: None, pair, motion }
    }

    /// How far any point of the smaller geom can move against the other one, m.
    pub(crate) fn travel(&self) -> f64 {
        self.reach.linear + self.reach.angular * self.radius
    }
}

/// The pairs of the last search that have a bound of their own, in the order of pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairReaches {
    pub known: Vec<PairReach>,
    /// Whether pairs that cannot come together along a direction are left out.
    pub is_directed: bool,
    next: usize,
}

impl PairReaches {
    /// Whether a bound could be worth asking for.
    ///
    /// - `travel`: what both geoms can travel, m; `radius`: of the smaller one, m
    pub fn is_worth_it(travel: f64, radius: f64) -> bool {
        travel > WORTH * radius
    }

    /// Begins to look up pairs in their order.
    pub fn begin(&mut self) {
        self.next = 0;
    }

    /// The bound of a pair that does not come before those asked for.
    pub fn of(&mut self, pair: u64) -> Option<&mut PairReach> {
        while self.known.get(self.next).is_some_and(|known| known.pair < pair) {
            self.next += 1;
        }
        self.known.get_mut(self.next).filter(|known| known.pair == pair)
    }
}

/// Up to which gap a pair of shapes is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Within {
    /// m.
    pub margin: f64,
    /// How B can move against A, with the radius of the ball that moves and the margins of the geoms, m.
    pub moving: Option<(RelativeMotion, f64, f64)>,
}

impl Within {
    /// What is left of the gap (m) of shapes along a unit normal from A to B, where they cannot come together.
    pub fn excluded(&self, normal: DVec3, gap: f64) -> Option<f64> {
        let (motion, radius, own) = self.moving.as_ref()?;
        (gap > *own && gap - own > motion.approach(normal, *radius)).then_some(gap - own)
    }
}
