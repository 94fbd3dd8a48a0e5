//! Adhesion: actuators that pull a body and what it touches together.
//!
//! The force of such an actuator is spread evenly over the contact points of its body's geoms that touch, and acts along their normals as
//! a force of the step: with `f = −(F/n) Σ J_Nᵀ` the free velocity becomes `v^f + M̂⁻¹ Δt f`, and the laws of contact stay what they are. A
//! contact that bears the pull has the normal force of the load and `F/n`, and friction in proportion.

use signorini_contact::ContactProblem;
use signorini_multibody::{
    BodyId, ContactPoint, FreeMotion, Geom, GeomId, Kinematics, Model, Transmission, add_wrench,
};

/// Gap up to which a point touches, as a part of the size of the geom that sticks: what a step leaves of a contact that rolls or slides around
/// a body of its size, and far below what anyone would call a distance.
const TOUCHING: f64 = 1e-4;

/// What sticks, and what it did in the last step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Adhesion {
    sticky: Vec<Sticky>,
    /// Gap within which points of each body are looked for, m; empty where nothing sticks.
    pub layers: Vec<f64>,
    /// The points that were pulled.
    pub pulls: Vec<Pull>,
    impulse: Vec<f64>,
}

/// An actuator that pulls at contacts.
#[derive(Clone, Copy, Debug)]
struct Sticky {
    actuator: usize,
    body: BodyId,
    layer: f64,
}

/// A contact point that was pulled together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    pub actuator: usize,
    pub point: ContactPoint,
    /// Part of the force of its actuator, gear included.
    pub share: f64,
    /// N, against the normal on body B.
    pub force: f64,
}

impl Adhesion {
    pub fn new(model: &Model) -> Self {
        let sticky = model.actuators.iter().enumerate().filter_map(|(actuator, part)| match part.transmission {
            Transmission::Body { body, layer } => Some(Sticky { actuator, body, layer }),
            _ => None,
        });
        let sticky: Vec<Sticky> = sticky.collect();
        if sticky.is_empty() {
            return Self::default();
        }
        let mut layers = vec![0.0_f64; model.bodies.len()];
        for sticky in &sticky {
            let own = model.geoms.iter().filter(|geom| geom.body == sticky.body).map(touching);
            let layer = &mut layers[sticky.body.index()];
            *layer = own.fold(layer.max(sticky.layer), f64::max);
        }
        Self { sticky, layers, pulls: Vec::new(), impulse: vec![0.0; model.nv] }
    }

    /// Whether anything sticks.
    pub fn is_present(&self) -> bool {
        !self.sticky.is_empty()
    }

    /// Adds the pulls at the points that touch to the free motion of the step's problem.
    ///
    /// - `points`: all that were found
    pub fn act(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        points: &[ContactPoint],
        smooth: &FreeMotion,
        problem: &mut ContactProblem,
    ) {
        if !self.is_present() {
            return;
        }
        self.pull(model, kinematics, points, &smooth.actuator_force, problem.timestep);
        problem.mass_factor.solve_in_place(&mut self.impulse);
        let free = smooth.free_velocity.iter().zip(&self.impulse);
        problem.free_velocity.iter_mut().zip(free).for_each(|(v, (free, change))| *v = free + change);
    }

    /// Velocity of an actuator that pulls at contacts, in the last step: how fast they close on average, gear included (m/s).
    pub fn closing_rate(&self, kinematics: &Kinematics, actuator: usize) -> f64 {
        let own = self.pulls.iter().filter(|pull| pull.actuator == actuator);
        own.map(|Pull { point, share, .. }| {
            let [a, b] = [point.body_a, point.body_b].map(|body| kinematics.point_velocity(body, point.position));
            -share * point.normal.dot(b - a)
        })
        .sum()
    }

    /// Finds the points that are pulled and writes the impulse of the pulls.
    ///
    /// - `force`: of every actuator, before the gear, N
    fn pull(&mut self, model: &Model, kinematics: &Kinematics, points: &[ContactPoint], force: &[f64], dt: f64) {
        let Self { sticky, pulls, impulse, .. } = self;
        pulls.clear();
        impulse.fill(0.0);
        for &Sticky { actuator, body, layer } in sticky.iter() {
            let first = pulls.len();
            let whole = model.actuators[actuator].gear;
            for point in points {
                let own = [(point.body_a, point.geom_a), (point.body_b, point.geom_b)];
                let near = |geom: GeomId| point.gap <= layer.max(touching(&model.geoms[geom.index()]));
                if own.into_iter().any(|(other, geom)| other == body && near(geom)) {
                    pulls.push(Pull { actuator, point: *point, share: whole, force: whole * force[actuator] });
                }
            }
            let count = (pulls.len() - first) as f64;
            for pull in &mut pulls[first..] {
                (pull.share, pull.force) = (pull.share / count, pull.force / count);
                let (point, pulled) = (&pull.point, pull.point.normal * (dt * pull.force));
                let zero = pulled * 0.0;
                add_wrench(model, kinematics, point.body_b, point.position, -pulled, zero, impulse);
                add_wrench(model, kinematics, point.body_a, point.position, pulled, zero, impulse);
            }
        }
    }
}

fn touching(geom: &Geom) -> f64 {
    let size = geom.geometry.bounding_radius();
    if size.is_finite() { TOUCHING * size } else { 0.0 }
}
