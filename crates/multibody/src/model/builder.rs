//! Building a model part by part, with every check in one place.

use std::collections::HashSet;

use glamx::glam::{DMat3, DVec3};

use super::{
    Actuator, Body, BodyId, ContactFilter, Geom, GeomId, GeomPair, Inertia, Joint, JointId, JointKind, Keyframe, Model,
    ModelError,
};
use crate::math::Pose;

/// Collects parts and checks them; [`build`](Self::build) gives the immutable [`Model`].
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    name: String,
    gravity: DVec3,
    timestep: f64,
    bodies: Vec<Body>,
    joints: Vec<Vec<Joint>>,
    joint_ids: Vec<(usize, usize)>,
    geoms: Vec<Geom>,
    pairs: Vec<GeomPair>,
    excluded: Vec<(BodyId, BodyId)>,
    actuators: Vec<Actuator>,
    keyframes: Vec<Keyframe>,
}

impl ModelBuilder {
    /// An empty world with gravity (0, 0, −9.81) m/s² and a time step of 2 ms.
    pub fn new(name: impl Into<String>) -> Self {
        let world = Body {
            name: "world".into(),
            parent: BodyId::WORLD,
            placement: Pose::IDENTITY,
            inertia: Inertia::ZERO,
            first_joint: 0,
            joint_count: 0,
        };
        Self {
            name: name.into(),
            gravity: DVec3::new(0.0, 0.0, -9.81),
            timestep: 0.002,
            bodies: vec![world],
            joints: vec![Vec::new()],
            joint_ids: Vec::new(),
            geoms: Vec::new(),
            pairs: Vec::new(),
            excluded: Vec::new(),
            actuators: Vec::new(),
            keyframes: Vec::new(),
        }
    }

    /// Sets gravity, m/s².
    pub fn gravity(&mut self, gravity: DVec3) -> &mut Self {
        self.gravity = gravity;
        self
    }

    /// Sets the suggested time step, s.
    pub fn timestep(&mut self, timestep: f64) -> &mut Self {
        self.timestep = timestep;
        self
    }

    /// Adds a body at `placement` (`X_PB`) in its parent, welded to it until a joint is added.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the parent is not there yet.
    pub fn add_body(
        &mut self,
        name: impl Into<String>,
        parent: BodyId,
        placement: Pose,
        inertia: Inertia,
    ) -> Result<BodyId, ModelError> {
        let name = name.into();
        self.known_body(parent, || format!("body '{name}'"))?;
        let id = BodyId(self.bodies.len() as u32);
        self.bodies.push(Body { name, parent, placement, inertia, first_joint: 0, joint_count: 0 });
        self.joints.push(Vec::new());
        Ok(id)
    }

    /// Replaces a body's inertia.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn set_inertia(&mut self, body: BodyId, inertia: Inertia) -> Result<(), ModelError> {
        self.known_body(body, || "an inertia".into())?;
        self.bodies[body.index()].inertia = inertia;
        Ok(())
    }

    /// Adds a joint to a body, after the joints it already has. The identifier counts joints in the order they are
    /// added; [`Model::joints`] orders them by body, which is the same order when bodies are finished one by one.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_joint(&mut self, body: BodyId, mut joint: Joint) -> Result<JointId, ModelError> {
        self.known_body(body, || format!("joint '{}'", joint.name))?;
        joint.body = body;
        let id = JointId(self.joint_ids.len() as u32);
        self.joint_ids.push((body.index(), self.joints[body.index()].len()));
        self.joints[body.index()].push(joint);
        Ok(id)
    }

    /// Adds a shape to a body.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_geom(&mut self, body: BodyId, mut geom: Geom) -> Result<GeomId, ModelError> {
        self.known_body(body, || format!("geom '{}'", geom.name))?;
        geom.body = body;
        let id = GeomId(self.geoms.len() as u32);
        self.geoms.push(geom);
        Ok(id)
    }

    /// Makes two geoms meet with a friction of their own.
    pub fn add_pair(&mut self, pair: GeomPair) -> &mut Self {
        self.pairs.push(pair);
        self
    }

    /// Keeps two bodies from touching.
    pub fn exclude(&mut self, a: BodyId, b: BodyId) -> &mut Self {
        self.excluded.push((a, b));
        self
    }

    /// Adds an actuator.
    pub fn add_actuator(&mut self, actuator: Actuator) -> &mut Self {
        self.actuators.push(actuator);
        self
    }

    /// Adds a named state.
    pub fn add_keyframe(&mut self, keyframe: Keyframe) -> &mut Self {
        self.keyframes.push(keyframe);
        self
    }

    /// Checks everything and orders the joints.
    ///
    /// # Errors
    /// The first [`ModelError`] met, in the order names, bodies, joints, geoms, actuators, keyframes.
    pub fn build(self) -> Result<Model, ModelError> {
        self.check_names()?;
        self.check_options()?;
        for body in &self.bodies {
            check_inertia(body)?;
        }
        let mut model = self.assemble();
        check_joints(&model)?;
        check_mass(&model)?;
        check_geoms(&model)?;
        check_pairs(&model)?;
        check_actuators(&model)?;
        check_keyframes(&mut model)?;
        Ok(model)
    }

    fn known_body(&self, body: BodyId, part: impl FnOnce() -> String) -> Result<(), ModelError> {
        if body.index() < self.bodies.len() {
            return Ok(());
        }
        Err(ModelError::UnknownPart { part: part(), sort: "body", index: body.index(), count: self.bodies.len() })
    }

    fn check_names(&self) -> Result<(), ModelError> {
        unique("body", self.bodies.iter().map(|b| &b.name))?;
        unique("joint", self.joints.iter().flatten().map(|j| &j.name))?;
        unique("geom", self.geoms.iter().map(|g| &g.name))?;
        unique("actuator", self.actuators.iter().map(|a| &a.name))?;
        unique("keyframe", self.keyframes.iter().map(|k| &k.name))
    }

    fn check_options(&self) -> Result<(), ModelError> {
        let part = || format!("model '{}'", self.name);
        number(part, "time step", "positive and finite", self.timestep, |x| x > 0.0)?;
        self.gravity.to_array().iter().try_for_each(|&g| number(part, "gravity", "finite", g, |_| true))
    }

    fn assemble(self) -> Model {
        let mut bodies = self.bodies;
        let mut joints = Vec::new();
        let mut body_weld = vec![BodyId::WORLD; bodies.len()];
        let mut body_last_dof = vec![None; bodies.len()];
        let (mut dof_parent, mut dof_joint) = (Vec::new(), Vec::new());
        let (mut nq, mut nv) = (0, 0);
        let mut first = vec![0; bodies.len()];
        for (i, own) in self.joints.into_iter().enumerate() {
            let parent = bodies[i].parent.index();
            let mut last_dof: Option<usize> = if i == 0 { None } else { body_last_dof[parent] };
            body_weld[i] = if own.is_empty() && i > 0 { body_weld[parent] } else { BodyId(i as u32) };
            bodies[i].first_joint = joints.len();
            bodies[i].joint_count = own.len();
            first[i] = joints.len();
            for mut joint in own {
                (joint.q_index, joint.v_index) = (nq, nv);
                let id = JointId(joints.len() as u32);
                for _ in 0..joint.kind.nv() {
                    dof_parent.push(last_dof);
                    dof_joint.push(id);
                    last_dof = Some(nv);
                    nv += 1;
                }
                nq += joint.kind.nq();
                joints.push(joint);
            }
            body_last_dof[i] = last_dof;
        }
        let mut actuators = self.actuators;
        for actuator in &mut actuators {
            if let Some(&(body, k)) = self.joint_ids.get(actuator.joint.index()) {
                actuator.joint = JointId((first[body] + k) as u32);
            }
        }
        let weld_parent = body_weld.iter().map(|w| body_weld[bodies[w.index()].parent.index()]).collect();
        let contact_filter = ContactFilter::new(&self.pairs, &self.excluded, body_weld.clone(), weld_parent);
        Model {
            name: self.name,
            gravity: self.gravity,
            timestep: self.timestep,
            bodies,
            joints,
            geoms: self.geoms,
            pairs: self.pairs,
            contact_filter,
            actuators,
            keyframes: self.keyframes,
            nq,
            nv,
            dof_parent,
            dof_joint,
            body_last_dof,
            body_weld,
        }
    }
}

fn unique<'a>(sort: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), ModelError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(ModelError::DuplicateName { sort, name: name.clone() });
        }
    }
    Ok(())
}

fn number(
    part: impl Fn() -> String,
    quantity: &'static str,
    expected: &'static str,
    found: f64,
    ok: impl Fn(f64) -> bool,
) -> Result<(), ModelError> {
    if found.is_finite() && ok(found) {
        return Ok(());
    }
    Err(ModelError::InvalidNumber { part: part(), quantity, expected, found })
}

fn check_pose(part: impl Fn() -> String + Copy, pose: &Pose) -> Result<(), ModelError> {
    for x in pose.position.to_array() {
        number(part, "position", "finite", x, |_| true)?;
    }
    number(part, "norm of the quaternion", "1", pose.rotation.length(), |n| (n - 1.0).abs() < 1e-6)
}

fn check_inertia(body: &Body) -> Result<(), ModelError> {
    let part = || format!("body '{}'", body.name);
    check_pose(part, &body.placement)?;
    number(part, "mass", "finite and not negative", body.inertia.mass, |m| m >= 0.0)?;
    for x in body.inertia.center_of_mass.to_array() {
        number(part, "centre of mass", "finite", x, |_| true)?;
    }
    for x in body.inertia.rotational.to_cols_array() {
        number(part, "rotational inertia", "finite", x, |_| true)?;
    }
    let moments = principal_moments(body.inertia.rotational);
    let slack = 1e-6 * moments[2].abs();
    if moments[0] < -slack || moments[2] > moments[0] + moments[1] + slack {
        return Err(ModelError::InvalidInertia { body: body.name.clone(), moments });
    }
    Ok(())
}

/// Eigenvalues of a symmetric 3×3 matrix in ascending order, by the trigonometric formula
/// (O. K. Smith, Eigenvalues of a symmetric 3 × 3 matrix, CACM 1961).
fn principal_moments(a: DMat3) -> [f64; 3] {
    let a = (a + a.transpose()) * 0.5;
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let b = a - DMat3::from_diagonal(DVec3::splat(mean));
    let norm2 = b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared();
    let p = (norm2 / 6.0).sqrt();
    if p == 0.0 {
        return [mean; 3];
    }
    let angle = ((b * (1.0 / p)).determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
    let third = 2.0 * std::f64::consts::FRAC_PI_3;
    let largest = mean + 2.0 * p * angle.cos();
    let smallest = mean + 2.0 * p * (angle + third).cos();
    [smallest, 3.0 * mean - largest - smallest, largest]
}

fn check_joints(model: &Model) -> Result<(), ModelError> {
    for joint in &model.joints {
        let body = &model.bodies[joint.body.index()];
        let invalid =
            |reason| Err(ModelError::InvalidJoint { joint: joint.name.clone(), body: body.name.clone(), reason });
        match joint.kind {
            _ if joint.body == BodyId::WORLD => return invalid("the world cannot have joints"),
            JointKind::Free if body.parent != BodyId::WORLD => {
                return invalid("a free joint is only possible on a child of the world");
            }
            JointKind::Free if body.joint_count > 1 => return invalid("a free joint must be its body's only joint"),
            JointKind::Hinge { axis } | JointKind::Slide { axis } if (axis.length() - 1.0).abs() > 1e-9 => {
                return invalid("the axis must be a unit vector");
            }
            _ => {}
        }
        let part = || format!("joint '{}'", joint.name);
        for (quantity, x) in [
            ("damping", joint.damping),
            ("stiffness", joint.stiffness),
            ("armature", joint.armature),
            ("friction loss", joint.friction_loss),
        ] {
            number(part, quantity, "finite and not negative", x, |x| x >= 0.0)?;
        }
        for x in joint.anchor.to_array().into_iter().chain([joint.reference, joint.spring_reference]) {
            number(part, "anchor or reference", "finite", x, |_| true)?;
        }
        if let Some([lower, upper]) = joint.limits {
            number(part, "lower limit", "finite", lower, |_| true)?;
            number(part, "upper limit", "finite and not below the lower one", upper, |x| x >= lower)?;
        }
    }
    Ok(())
}

/// Every joint must move some mass (or have an armature): otherwise the mass matrix is singular.
fn check_mass(model: &Model) -> Result<(), ModelError> {
    let mut mass: Vec<f64> = model.bodies.iter().map(|b| b.inertia.mass).collect();
    let mut rotational: Vec<f64> = model.bodies.iter().map(|b| principal_moments(b.inertia.rotational)[2]).collect();
    for i in (1..model.bodies.len()).rev() {
        let parent = model.bodies[i].parent.index();
        let arm = mass[i] * model.bodies[i].inertia.center_of_mass.length_squared();
        rotational[parent] += rotational[i] + arm + mass[i] * model.bodies[i].placement.position.length_squared();
        mass[parent] += mass[i];
    }
    for joint in model.joints.iter().filter(|j| j.armature == 0.0) {
        let i = joint.body.index();
        let body = &model.bodies[i];
        let turning = rotational[i] + mass[i] * (body.inertia.center_of_mass - joint.anchor).length_squared();
        let missing = match joint.kind {
            JointKind::Free if mass[i] <= 0.0 => "mass",
            JointKind::Slide { .. } if mass[i] <= 0.0 => "mass",
            JointKind::Free if rotational[i] <= 0.0 => "rotational inertia",
            JointKind::Ball | JointKind::Hinge { .. } if turning <= 0.0 => "rotational inertia",
            _ => continue,
        };
        return Err(ModelError::Massless { body: body.name.clone(), missing });
    }
    Ok(())
}

fn check_geoms(model: &Model) -> Result<(), ModelError> {
    for geom in &model.geoms {
        let part = || format!("geom '{}'", geom.name);
        check_pose(part, &geom.placement)?;
        number(part, "friction", "finite and not negative", geom.friction, |x| x >= 0.0)?;
        let invalid = |reason| {
            Err(ModelError::InvalidGeometry { geom: geom.name.clone(), kind: geom.geometry.kind_name(), reason })
        };
        if let Err(reason) = geom.geometry.check() {
            return invalid(reason);
        }
        let moves = model.body_weld[geom.body.index()] != BodyId::WORLD;
        if matches!(geom.geometry, super::Geometry::Plane) && moves {
            return invalid("a plane can only be fixed to the world or to a body that cannot move".into());
        }
    }
    Ok(())
}

fn check_pairs(model: &Model) -> Result<(), ModelError> {
    for pair in &model.pairs {
        for geom in [pair.geom_a, pair.geom_b] {
            known("a contact pair".into(), "geom", geom.index(), model.geoms.len())?;
        }
        number(|| "a contact pair".into(), "friction", "finite and not negative", pair.friction, |x| x >= 0.0)?;
    }
    Ok(())
}

fn check_actuators(model: &Model) -> Result<(), ModelError> {
    for actuator in &model.actuators {
        let part = || format!("actuator '{}'", actuator.name);
        known(part(), "joint", actuator.joint.index(), model.joints.len())?;
        let joint = &model.joints[actuator.joint.index()];
        if joint.kind.nv() != 1 {
            return Err(ModelError::InvalidJoint {
                joint: joint.name.clone(),
                body: model.bodies[joint.body.index()].name.clone(),
                reason: "only hinges and slides can have an actuator",
            });
        }
        number(part, "gear", "finite", actuator.gear, |_| true)?;
        let gains = match actuator.kind {
            super::ActuatorKind::Motor => [0.0, 0.0],
            super::ActuatorKind::Position { kp, kv } => [kp, kv],
            super::ActuatorKind::Velocity { kv } => [0.0, kv],
        };
        gains.iter().try_for_each(|&g| number(part, "gain", "finite and not negative", g, |g| g >= 0.0))?;
        for range in [actuator.control_range, actuator.force_range].into_iter().flatten() {
            number(part, "upper end of a range", "finite and not below the lower one", range[1], |x| x >= range[0])?;
            number(part, "lower end of a range", "finite", range[0], |_| true)?;
        }
    }
    Ok(())
}

/// Checks sizes and numbers and normalises the quaternions.
fn check_keyframes(model: &mut Model) -> Result<(), ModelError> {
    let (nq, nv, nu) = (model.nq, model.nv, model.actuators.len());
    for keyframe in &mut model.keyframes {
        let part = format!("keyframe '{}'", keyframe.name);
        for (list, expected, values) in
            [("qpos", nq, &keyframe.q), ("qvel", nv, &keyframe.v), ("ctrl", nu, &keyframe.control)]
        {
            if values.len() != expected {
                return Err(ModelError::WrongLength { part, list, expected, found: values.len() });
            }
            for &x in values {
                number(|| part.clone(), list, "finite", x, |_| true)?;
            }
        }
        for joint in &model.joints {
            let start = joint.q_index + if joint.kind == JointKind::Free { 3 } else { 0 };
            if !matches!(joint.kind, JointKind::Free | JointKind::Ball) {
                continue;
            }
            let quat = &mut keyframe.q[start..start + 4];
            let norm = quat.iter().map(|x| x * x).sum::<f64>().sqrt();
            number(|| part.clone(), "norm of a quaternion", "positive", norm, |n| n > 1e-12)?;
            quat.iter_mut().for_each(|x| *x /= norm);
        }
    }
    Ok(())
}

fn known(part: String, sort: &'static str, index: usize, count: usize) -> Result<(), ModelError> {
    if index < count { Ok(()) } else { Err(ModelError::UnknownPart { part, sort, index, count }) }
}
