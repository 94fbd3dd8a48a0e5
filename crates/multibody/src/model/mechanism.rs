//! The mechanism as a whole.

use glamx::glam::DVec3;

use super::path::{PathStep, reference_pose};
use super::{
    Actuator, ActuatorId, Body, BodyId, Camera, ContactFilter, Equality, Geom, GeomId, GeomPair, Joint, JointId,
    JointKind, Keyframe, Light, Sensor, Site, SiteId, SpinResistance, Tendon, TendonId,
};
use crate::math::Pose;

/// A mechanism: bodies in a tree, joints, shapes, actuators. Made by [`ModelBuilder`](super::ModelBuilder), checked once, never changed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Model {
    /// Name.
    pub name: String,
    /// Gravity in world, m/s².
    pub gravity: DVec3,
    /// Magnetic field in world, which magnetometers measure, in whatever unit.
    pub magnetic: DVec3,
    /// Suggested time step Δt, s.
    pub timestep: f64,
    /// Whether simulations leave alone what rests, where they are not told otherwise.
    pub sleeping: bool,
    /// Bodies, parents before children; body 0 is the world.
    pub bodies: Vec<Body>,
    /// Joints, in the order of their bodies.
    pub joints: Vec<Joint>,
    /// Shapes.
    pub geoms: Vec<Geom>,
    /// Pairs of geoms with a friction of their own.
    pub pairs: Vec<GeomPair>,
    /// Which pairs of geoms can touch.
    pub contact_filter: ContactFilter,
    /// Bilateral constraints.
    pub equalities: Vec<Equality>,
    /// Frames at which sensors measure and actuators pull.
    pub sites: Vec<Site>,
    /// Fixed tendons.
    pub tendons: Vec<Tendon>,
    /// Actuators.
    pub actuators: Vec<Actuator>,
    /// Sensors, in the order of their numbers.
    pub sensors: Vec<Sensor>,
    /// Named states.
    pub keyframes: Vec<Keyframe>,
    /// Bodies whose pose is given from outside, in their order (MJCF `mocap`).
    pub mocap_bodies: Vec<BodyId>,
    /// Cameras for pictures.
    pub cameras: Vec<Camera>,
    /// Lights for pictures; none: whoever makes the picture lights it.
    pub lights: Vec<Light>,
    /// Size of `q`.
    pub nq: usize,
    /// Size of `v`.
    pub nv: usize,
    /// Number of activations of actuators.
    pub na: usize,
    /// Size of the array of all sensors' numbers.
    pub sensor_size: usize,
    /// For every degree of freedom the one before it on the way to the root, if any.
    pub dof_parent: Vec<Option<usize>>,
    /// For every degree of freedom its joint.
    pub dof_joint: Vec<JointId>,
    /// For every body the last degree of freedom that moves it, if any.
    pub body_last_dof: Vec<Option<usize>>,
    /// For every body the nearest ancestor (or itself) that has joints: bodies with the same one are welded together.
    /// The world for bodies that cannot move.
    pub body_weld: Vec<BodyId>,
    /// For every body its place in its tree.
    pub(crate) path: Vec<PathStep>,
}

impl Model {
    /// The configuration at which every body is at its `placement`, `[nq]`.
    pub fn reference_configuration(&self) -> Vec<f64> {
        let mut q = Vec::with_capacity(self.nq);
        for joint in &self.joints {
            match joint.kind {
                JointKind::Free => {
                    let x = self.bodies[joint.body.index()].placement;
                    let r = x.rotation;
                    q.extend([x.position.x, x.position.y, x.position.z, r.w, r.x, r.y, r.z]);
                }
                JointKind::Ball => q.extend([1.0, 0.0, 0.0, 0.0]),
                JointKind::Hinge { .. } | JointKind::Slide { .. } => q.push(joint.reference),
            }
        }
        q
    }

    /// Poses `X_WB` where the model places the bodies that are moved from outside, `[mocap_bodies]`.
    pub fn mocap_placements(&self) -> Vec<Pose> {
        self.mocap_bodies.iter().map(|body| self.bodies[body.index()].placement).collect()
    }

    /// Whether a body, or one that it hangs on, is moved from outside.
    pub fn hangs_on_mocap(&self, body: BodyId) -> bool {
        let above = |body: &BodyId| (*body != BodyId::WORLD).then(|| self.bodies[body.index()].parent);
        std::iter::successors(Some(body), above).any(|body| self.bodies[body.index()].mocap.is_some())
    }

    /// Whether nothing moves a body, neither joints nor anybody from outside.
    pub fn is_fixed(&self, body: BodyId) -> bool {
        self.body_weld[body.index()] == BodyId::WORLD && !self.hangs_on_mocap(body)
    }

    /// The joints that move a body, in order.
    pub fn joints_of(&self, body: BodyId) -> &[Joint] {
        let b = &self.bodies[body.index()];
        &self.joints[b.first_joint..b.first_joint + b.joint_count]
    }

    /// The degrees of freedom of a body's own joints, as a range of indices into `v`.
    pub fn dofs_of(&self, body: BodyId) -> std::ops::Range<usize> {
        match self.joints_of(body) {
            [] => 0..0,
            [first, .., last] => first.v_index..last.v_index + last.kind.nv(),
            [only] => only.v_index..only.v_index + only.kind.nv(),
        }
    }

    /// The degrees of freedom that move a body, from the last one to the root's.
    pub fn dofs_moving(&self, body: BodyId) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.body_last_dof[body.index()], |&k| self.dof_parent[k])
    }

    /// A body and all that hangs on it, in the order of the model.
    pub fn subtree(&self, root: BodyId) -> impl Iterator<Item = BodyId> + '_ {
        (root.0..self.bodies.len() as u32).map(BodyId).filter(move |&body| self.is_descendant(body, root))
    }

    /// Whether a body is another one or hangs on it; everything hangs on the world.
    pub fn is_descendant(&self, body: BodyId, ancestor: BodyId) -> bool {
        let mut at = body;
        while at > ancestor {
            at = self.bodies[at.index()].parent;
        }
        at == ancestor
    }

    /// The body that a degree of freedom belongs to.
    pub fn dof_body(&self, dof: usize) -> BodyId {
        self.joints[self.dof_joint[dof].index()].body
    }

    /// The body of that name.
    pub fn body_named(&self, name: &str) -> Option<BodyId> {
        self.bodies.iter().position(|b| b.name == name).map(|i| BodyId(i as u32))
    }

    /// The joint of that name.
    pub fn joint_named(&self, name: &str) -> Option<JointId> {
        self.joints.iter().position(|j| j.name == name).map(|i| JointId(i as u32))
    }

    /// Index of the equality constraint of that name.
    pub fn equality_named(&self, name: &str) -> Option<usize> {
        self.equalities.iter().position(|e| e.name == name)
    }

    /// The geom of that name.
    pub fn geom_named(&self, name: &str) -> Option<GeomId> {
        self.geoms.iter().position(|g| g.name == name).map(|i| GeomId(i as u32))
    }

    /// The site of that name.
    pub fn site_named(&self, name: &str) -> Option<SiteId> {
        self.sites.iter().position(|s| s.name == name).map(|i| SiteId(i as u32))
    }

    /// The tendon of that name.
    pub fn tendon_named(&self, name: &str) -> Option<TendonId> {
        self.tendons.iter().position(|t| t.name == name).map(|i| TendonId(i as u32))
    }

    /// The actuator of that name.
    pub fn actuator_named(&self, name: &str) -> Option<ActuatorId> {
        self.actuators.iter().position(|a| a.name == name).map(|i| ActuatorId(i as u32))
    }

    /// The sensor of that name.
    pub fn sensor_named(&self, name: &str) -> Option<&Sensor> {
        self.sensors.iter().find(|s| s.name == name)
    }

    /// The keyframe of that name.
    pub fn keyframe_named(&self, name: &str) -> Option<&Keyframe> {
        self.keyframes.iter().find(|k| k.name == name)
    }

    /// Friction of a pair of geoms: the pair's own entry, else [what the two make of it](Geom::friction_with).
    pub fn pair_friction(&self, a: GeomId, b: GeomId) -> f64 {
        if let Some(pair) = self.own_pair(a, b) {
            return pair.friction;
        }
        self.geoms[a.index()].friction_with(&self.geoms[b.index()])
    }

    /// Friction of a pair of geoms against spinning about the normal and against rolling, m: the pair's own entry, else
    /// [what the two make of it](Geom::spin_friction_with); 0 for a motion that is not resisted.
    pub fn pair_spin_friction(&self, a: GeomId, b: GeomId) -> [f64; 2] {
        let (a_geom, b_geom) = (&self.geoms[a.index()], &self.geoms[b.index()]);
        let (resistance, spinning, rolling) = match self.own_pair(a, b) {
            Some(pair) => (pair.spin_resistance, pair.spinning_friction, pair.rolling_friction),
            None => a_geom.spin_friction_with(b_geom),
        };
        match resistance {
            SpinResistance::None => [0.0, 0.0],
            SpinResistance::Spinning => [spinning, 0.0],
            SpinResistance::Rolling => [spinning, rolling],
        }
    }

    /// Coefficient of restitution of a pair of geoms: the pair's own entry, else the larger of the two.
    pub fn pair_restitution(&self, a: GeomId, b: GeomId) -> f64 {
        match self.own_pair(a, b) {
            Some(GeomPair { restitution: Some(e), .. }) => *e,
            _ => self.geoms[a.index()].restitution.max(self.geoms[b.index()].restitution),
        }
    }

    /// Distance of the surfaces of a pair of geoms at which their contacts act, m: the pair's own entry, else the sum of the two.
    pub fn pair_margin(&self, a: GeomId, b: GeomId) -> f64 {
        match self.own_pair(a, b) {
            Some(GeomPair { margin: Some(margin), .. }) => *margin,
            _ => self.geoms[a.index()].margin + self.geoms[b.index()].margin,
        }
    }

    fn own_pair(&self, a: GeomId, b: GeomId) -> Option<&GeomPair> {
        self.pairs.iter().find(|p| (p.geom_a, p.geom_b) == (a, b) || (p.geom_a, p.geom_b) == (b, a))
    }

    /// `X_WB` of a body at the [reference configuration](Self::reference_configuration).
    pub fn reference_pose(&self, body: BodyId) -> Pose {
        reference_pose(&self.bodies, body)
    }
}
