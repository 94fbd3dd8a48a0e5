//! How far bodies can move within a step, so that no contact is missed.
//!
//! Candidates are found before the velocity at the end of the step is known. The reach starts from the velocities at the
//! beginning and without contact, with a factor to spare; after the solve it is compared with the true motion, and where a
//! body outran its reach (one that was struck, say) the step is found and solved again with more.

use signorini_collision::{Collider, Reach};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Kinematics, Model, body_velocities_into};

/// Factor between a velocity and the reach it is given.
const MARGIN: f64 = 2.0;

/// Travel beyond the reach that is rounding of a body at rest, m or rad: no gap that it could close matters.
const NEGLIGIBLE: f64 = 1e-12;

/// The reach of every body that can touch another one, and the velocities it was made from.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyReach {
    /// Of every body; zero for those that touch nothing.
    pub reach: Vec<Reach>,
    /// Velocities without contact.
    pub free: Velocities,
    /// Velocities at the end of the step.
    pub end: Velocities,
    /// The bodies that can touch another one and move.
    bodies: Vec<u32>,
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

    /// Velocity of a body's material point at a place in world, m/s.
    pub fn at(&self, body: BodyId, kinematics: &Kinematics, place: DVec3) -> DVec3 {
        let i = body.index();
        self.linear[i] + self.angular[i].cross(place - kinematics.pose[i].position)
    }
}

impl BodyReach {
    /// Storage for a model.
    pub fn new(model: &Model, collider: &Collider) -> Self {
        let moves = |body: &BodyId| model.body_weld[body.index()] != BodyId::WORLD;
        let bodies = collider.touching_bodies().filter(moves).map(|body| body.0).collect();
        Self { reach: vec![Reach::default(); model.bodies.len()], bodies, ..Self::default() }
    }

    /// The reach for the velocity at the beginning of the step, that of `kinematics`, and for another one.
    /// - `v_free`: generalized velocity, `[nv]`
    pub fn start(&mut self, model: &Model, kinematics: &Kinematics, v_free: &[f64], dt: f64) {
        if self.bodies.is_empty() {
            return;
        }
        self.free.take(model, kinematics, v_free);
        for i in self.bodies.iter().map(|&i| i as usize) {
            let faster = |a: DVec3, b: DVec3| MARGIN * dt * a.length_squared().max(b.length_squared()).sqrt();
            self.reach[i] = Reach {
                linear: faster(self.free.linear[i], kinematics.linear_velocity[i]),
                angular: faster(self.free.angular[i], kinematics.angular_velocity[i]),
            };
        }
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
        for i in self.bodies.iter().map(|&i| i as usize) {
            let reach = &mut self.reach[i];
            for (speed, limit) in [(self.end.linear[i], &mut reach.linear), (self.end.angular[i], &mut reach.angular)] {
                let allowed = *limit * (1.0 + 1e-9) + NEGLIGIBLE;
                if dt * dt * speed.length_squared() > allowed * allowed {
                    *limit = MARGIN * dt * speed.length();
                    exceeded = true;
                }
            }
        }
        exceeded
    }
}
