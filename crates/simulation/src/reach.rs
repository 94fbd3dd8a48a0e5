//! How far bodies can move within a step, so that no contact is missed.
//!
//! Candidates are found before the velocity at the end of the step is known. The reach starts from the velocities at the
//! beginning and without contact, with a factor to spare; after the solve it is compared with the true motion, and where a
//! body outran its reach (one that was struck, say) the step is found and solved again with more.
//!
//! Bodies that travel together can move against each other by less than either of them travels: pairs are looked at within a bound of
//! their relative motion, made and compared in the same way, and all of them, where they fall together, say, within what each does beside
//! the mean motion. A pair that exceeded its bound is looked at within both travels when the step is found again; the others keep theirs, so
//! that what they find does not depend on what is struck elsewhere.

use signorini_collision::{Collider, PairReach, Reach, RelativeMotion};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Kinematics, Model, MovingBodies, body_velocities_into};

/// Factor between a velocity and the reach it is given.
const MARGIN: f64 = 2.0;

/// Travel beyond the reach that is rounding of a body at rest, m or rad: no gap that it could close matters.
const NEGLIGIBLE: f64 = 1e-12;

/// Part of a reach that is rounding.
const ROUNDING: f64 = 1e-9;

/// The reach of every body that can touch another one, and the velocities it was made from.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyReach {
    /// Of every body; zero for those that touch nothing.
    pub reach: Vec<Reach>,
    /// Velocities without contact.
    pub free: Velocities,
    /// Velocities at the end of the step.
    pub end: Velocities,
    /// The bodies that can touch another one and can move, and those of them that do not [stand](Self::let_stand).
    movable: Vec<u32>,
    bodies: Vec<u32>,
    /// How far every body's origin can move beside the mean motion of all, m; empty where that is not much less than they can move.
    pub beside: Vec<f64>,
    /// Their mean velocity, m/s.
    mean: DVec3,
    /// By how much farther each body is looked at than it moves, m; empty where none is.
    layers: Vec<f64>,
    /// Whether pairs are looked at within their relative motion.
    pub by_pairs: bool,
    /// Those that outran it in this step, each once, ascending.
    outrun: Vec<[BodyId; 2]>,
    /// Whether bodies outran theirs in this step.
    is_enlarged: bool,
}

/// Velocities of all bodies; empty where none touches another one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Velocities {
    angular: Vec<DVec3>,
    linear: Vec<DVec3>,
}

impl Velocities {
    fn take(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        body_velocities_into(model, kinematics, v, &mut self.angular, &mut self.linear);
    }

    /// The kinetic energy of a generalized velocity, J; these become its velocities.
    pub fn kinetic_energy(&mut self, model: &Model, moving: &MovingBodies, kinematics: &Kinematics, v: &[f64]) -> f64 {
        self.take(model, kinematics, v);
        moving.kinetic_energy(model, kinematics, v, (&self.angular, &self.linear))
    }

    /// Velocity of a body's material point at a place in world, m/s.
    pub fn at(&self, body: BodyId, kinematics: &Kinematics, place: DVec3) -> DVec3 {
        let i = body.index();
        self.linear[i] + self.angular[i].cross(place - kinematics.pose[i].position)
    }

    /// How far a body may move with its velocity at the beginning of a step, or with this one.
    fn reach(&self, kinematics: &Kinematics, i: usize, dt: f64) -> Reach {
        let faster = |a: DVec3, b: DVec3| MARGIN * dt * a.length_squared().max(b.length_squared()).sqrt();
        Reach {
            linear: faster(self.linear[i], kinematics.linear_velocity[i]),
            angular: faster(self.angular[i], kinematics.angular_velocity[i]),
        }
    }

    /// How far the second body moves against the first one at a place in world, m, and turns, rad, in a time.
    fn between(&self, kinematics: &Kinematics, [a, b]: [BodyId; 2], place: DVec3, dt: f64) -> [DVec3; 2] {
        let moved = dt * (self.at(b, kinematics, place) - self.at(a, kinematics, place));
        [moved, dt * (self.angular[b.index()] - self.angular[a.index()])]
    }

    /// Whether these velocities move the bodies of a pair farther against each other than they were searched for.
    fn outruns(&self, kinematics: &Kinematics, pair: &PairReach, dt: f64) -> bool {
        let [moved, turned] = self.between(kinematics, pair.bodies, pair.place, dt);
        let exceeds = |found: f64, allowed: f64| found > allowed * (1.0 + ROUNDING) + NEGLIGIBLE;
        if let Some((normal, gap)) = pair.apart {
            return exceeds(normal.cross(turned).length() * pair.radius - normal.dot(moved), gap);
        }
        let travel = |linear: f64, angular: f64| linear + angular * pair.radius;
        exceeds(turned.length(), pair.reach.angular)
            || exceeds(travel(moved.length(), turned.length()), travel(pair.reach.linear, pair.reach.angular))
    }
}

impl BodyReach {
    /// Storage for a model.
    pub fn new(model: &Model, collider: &Collider) -> Self {
        let moves = |body: &BodyId| model.body_weld[body.index()] != BodyId::WORLD;
        let movable: Vec<u32> = collider.touching_bodies().filter(moves).map(|body| body.0).collect();
        let reach = vec![Reach::default(); model.bodies.len()];
        Self { outrun: Vec::with_capacity(reach.len()), reach, bodies: movable.clone(), movable, ..Self::default() }
    }

    /// The reach for the velocity at the beginning of the step, that of `kinematics`, and for another one.
    /// - `v_free`: generalized velocity, `[nv]`
    pub fn start(&mut self, model: &Model, kinematics: &Kinematics, v_free: &[f64], dt: f64) {
        if self.bodies.is_empty() {
            return;
        }
        self.free.take(model, kinematics, v_free);
        self.by_pairs = true;
        self.outrun.clear();
        self.is_enlarged = false;
        for i in self.bodies.iter().map(|&i| i as usize) {
            self.reach[i] = self.free.reach(kinematics, i, dt);
        }
        self.bound_beside_mean(kinematics, dt);
    }

    /// Takes bodies for standing until it is told otherwise: they keep the reach that they have.
    pub fn let_stand(&mut self, stands: impl Fn(BodyId) -> bool) {
        self.bodies.clear();
        self.bodies.extend(self.movable.iter().copied().filter(|&i| !stands(BodyId(i))));
    }

    /// Gives bodies that stood a reach within a step that has begun, as [`start`](Self::start) would have.
    pub fn admit(&mut self, kinematics: &Kinematics, dt: f64, admitted: impl Fn(BodyId) -> bool) {
        // Of them is not known how they move beside the mean motion of the others.
        self.beside.clear();
        for &i in self.movable.iter().filter(|&&i| admitted(BodyId(i))) {
            self.reach[i as usize] = self.free.reach(kinematics, i as usize, dt);
        }
    }

    /// Bounds how far bodies can move beside their mean velocity without contact: two of them by no more than that against each other
    /// ([`of_pair`](Self::of_pair)).
    fn bound_beside_mean(&mut self, kinematics: &Kinematics, dt: f64) {
        let Self { beside, bodies, free, reach, .. } = self;
        let mean = bodies.iter().map(|&i| free.linear[i as usize]).sum::<DVec3>() / bodies.len() as f64;
        beside.clear();
        beside.resize(reach.len(), 0.0);
        let (mut all, mut aside_of_all) = (0.0, 0.0);
        for i in bodies.iter().map(|&i| i as usize) {
            let (now, free) = (kinematics.linear_velocity[i], free.linear[i]);
            let aside = (now - mean).length_squared().max((free - mean).length_squared()).sqrt();
            beside[i] = MARGIN * dt * (aside + (free - now).length());
            (all, aside_of_all) = (all + reach[i].linear, aside_of_all + beside[i]);
        }
        self.mean = mean;
        // A body that is stopped outruns this bound sooner, and makes a further search.
        let is_worth_it = 2.0 * aside_of_all < all;
        if !is_worth_it {
            beside.clear();
        }
    }

    /// Looks farther by the layers within which bodies stick, m each; none where nothing does.
    pub fn widen(&mut self, layers: &[f64]) {
        self.layers.clear();
        self.layers.extend_from_slice(layers);
        self.reach.iter_mut().zip(layers).for_each(|(reach, layer)| reach.linear += layer);
        self.beside.iter_mut().zip(layers).for_each(|(beside, layer)| *beside += layer);
    }

    /// How body B can move against body A, and its point at a place in world: with the relative velocity at the beginning or without contact,
    /// and besides what forces change of both, which contacts may have to take away from one body alone.
    pub fn of_pair(&self, kinematics: &Kinematics, [a, b]: [BodyId; 2], place: DVec3, dt: f64) -> RelativeMotion {
        let scale = MARGIN * dt;
        let now = [a, b].map(|body| kinematics.point_velocity(body, place));
        let free = [a, b].map(|body| self.free.at(body, kinematics, place));
        let turn_now = [a, b].map(|body| kinematics.angular_velocity[body.index()]);
        let turn_free = [a, b].map(|body| self.free.angular[body.index()]);
        let between = |of: [DVec3; 2]| scale * (of[1] - of[0]);
        let forced =
            |now: [DVec3; 2], free: [DVec3; 2]| scale * ((free[0] - now[0]).length() + (free[1] - now[1]).length());
        let mut besides = Reach { linear: forced(now, free), angular: forced(turn_now, turn_free) };
        if !self.layers.is_empty() {
            besides.linear += self.layers[a.index()] + self.layers[b.index()];
        }
        let motion = RelativeMotion {
            linear: [between(now), between(free)],
            angular: [between(turn_now), between(turn_free)],
            besides,
        };
        let has_outrun = self.outrun.binary_search(&[a, b]).is_ok();
        if has_outrun || self.is_enlarged && self.end_exceeds(kinematics, [a, b], place, dt, &motion) {
            let besides = Reach { linear: f64::INFINITY, angular: f64::INFINITY };
            return RelativeMotion { besides, ..RelativeMotion::default() };
        }
        motion
    }

    /// Whether a pair that came within reach by what the bodies were seen to do is known to move farther than that.
    fn end_exceeds(
        &self,
        kinematics: &Kinematics,
        bodies: [BodyId; 2],
        place: DVec3,
        dt: f64,
        motion: &RelativeMotion,
    ) -> bool {
        let [moved, turned] = self.end.between(kinematics, bodies, place, dt);
        let longest = |[x, y]: [DVec3; 2]| x.length().max(y.length());
        moved.length() > longest(motion.linear) + motion.besides.linear
            || turned.length() > longest(motion.angular) + motion.besides.angular
    }

    /// Takes note of the pairs that the velocity at the end of the step moves farther against each other than they were searched for; whether there
    /// are any.
    pub fn note_outrun(&mut self, kinematics: &Kinematics, pairs: &[PairReach], dt: f64) -> bool {
        let Self { end, outrun, .. } = self;
        let before = outrun.len();
        outrun.extend(pairs.iter().filter(|pair| end.outruns(kinematics, pair, dt)).map(|pair| pair.bodies));
        let is_any = outrun.len() > before;
        if is_any {
            // Several geoms of two bodies are several pairs.
            outrun.sort_unstable();
            outrun.dedup();
        }
        is_any
    }

    /// Takes over the velocity at the end of the step.
    pub fn end_with(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        if !self.bodies.is_empty() {
            self.end.take(model, kinematics, v);
        }
    }

    /// Enlarges the reach of every body that the velocity at the end of the step moves beyond it; whether there was one.
    pub fn enlarge(&mut self, dt: f64) -> bool {
        let mut exceeded = false;
        let mut raise = |speed: DVec3, limit: &mut f64| {
            let allowed = *limit * (1.0 + ROUNDING) + NEGLIGIBLE;
            if dt * dt * speed.length_squared() > allowed * allowed {
                *limit = MARGIN * dt * speed.length();
                exceeded = true;
            }
        };
        for i in self.bodies.iter().map(|&i| i as usize) {
            raise(self.end.linear[i], &mut self.reach[i].linear);
            raise(self.end.angular[i], &mut self.reach[i].angular);
            if let Some(beside) = self.beside.get_mut(i) {
                raise(self.end.linear[i] - self.mean, beside);
            }
        }
        self.is_enlarged |= exceeded;
        exceeded
    }
}
