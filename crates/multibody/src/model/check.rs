//! What a model must satisfy; the builder runs these checks once.

use std::collections::HashSet;

use glamx::glam::{DMat3, DVec3};

use super::{
    ActivationKind, ActuatorKind, Body, BodyId, EqualityKind, Geometry, Joint, JointId, JointKind, Model, ModelError,
    Muscle, Transmission,
};
use crate::math::Pose;

pub(super) fn unique<'a>(sort: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), ModelError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(ModelError::DuplicateName { sort, name: name.clone() });
        }
    }
    Ok(())
}

pub(super) fn number(
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

pub(super) fn check_pose(part: impl Fn() -> String + Copy, pose: &Pose) -> Result<(), ModelError> {
    for x in pose.position.to_array() {
        number(part, "position", "finite", x, |_| true)?;
    }
    number(part, "norm of the quaternion", "1", pose.rotation.length(), |n| (n - 1.0).abs() < 1e-6)
}

pub(super) fn check_inertia(body: &Body) -> Result<(), ModelError> {
    let part = || format!("body '{}'", body.name);
    check_pose(part, &body.placement)?;
    number(part, "mass", "finite and not negative", body.inertia.mass, |m| m >= 0.0)?;
    for x in body.inertia.center_of_mass.to_array() {
        number(part, "centre of mass", "finite", x, |_| true)?;
    }
    for x in body.inertia.rotational.to_cols_array() {
        number(part, "rotational inertia", "finite", x, |_| true)?;
    }
    number(part, "gravity compensation", "finite", body.gravity_compensation, |_| true)?;
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

pub(super) fn check_joints(model: &Model) -> Result<(), ModelError> {
    for joint in &model.joints {
        let body = &model.bodies[joint.body.index()];
        let invalid =
            |reason| Err(ModelError::InvalidJoint { joint: joint.name.clone(), body: body.name.clone(), reason });
        match joint.kind {
            _ if joint.body == BodyId::WORLD => return invalid("the world cannot have joints"),
            JointKind::Free if body.parent != BodyId::WORLD => {
                return invalid("a free joint is only possible on a child of the world");
            }
            JointKind::Free | JointKind::Ball if joint.stiffness != 0.0 => {
                return invalid("only hinges and slides can have a spring");
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
            if joint.kind == JointKind::Ball {
                number(part, "lower limit of a ball joint", "0", lower, |x| x == 0.0)?;
                number(part, "upper limit of a ball joint", "above 0 and below π", upper, |x| {
                    x > 0.0 && x < std::f64::consts::PI
                })?;
            }
            if joint.kind == JointKind::Free {
                return invalid("a free joint has no limits");
            }
        }
    }
    Ok(())
}

/// What is moved from outside hangs on the world and has no joints.
pub(super) fn check_mocap(model: &Model) -> Result<(), ModelError> {
    let wrong = |body: &&Body| body.parent != BodyId::WORLD || body.joint_count > 0 || body.name == "world";
    match model.mocap_bodies.iter().map(|id| &model.bodies[id.index()]).find(wrong) {
        None => Ok(()),
        Some(body) => Err(ModelError::InvalidMocap { body: body.name.clone() }),
    }
}

/// Every joint must move some mass (or have an armature): otherwise the mass matrix is singular.
pub(super) fn check_mass(model: &Model) -> Result<(), ModelError> {
    match moving_no_mass(&model.bodies, model.joints.iter().map(|joint| (joint.body.index(), joint))).next() {
        None => Ok(()),
        Some((body, _, missing)) => Err(ModelError::Massless { body: model.bodies[body].name.clone(), missing }),
    }
}

/// The joints, given with the indices of their bodies, that neither have an armature nor move what they need: with what is missing.
pub(super) fn moving_no_mass<'a>(
    bodies: &[Body],
    joints: impl Iterator<Item = (usize, &'a Joint)>,
) -> impl Iterator<Item = (usize, &'a Joint, &'static str)> {
    let mut mass: Vec<f64> = bodies.iter().map(|b| b.inertia.mass).collect();
    let mut rotational: Vec<f64> = bodies.iter().map(|b| principal_moments(b.inertia.rotational)[2]).collect();
    for i in (1..bodies.len()).rev() {
        let parent = bodies[i].parent.index();
        let arm = mass[i] * bodies[i].inertia.center_of_mass.length_squared();
        rotational[parent] += rotational[i] + arm + mass[i] * bodies[i].placement.position.length_squared();
        mass[parent] += mass[i];
    }
    joints.filter(|(_, joint)| joint.armature == 0.0).filter_map(move |(i, joint)| {
        let turning = rotational[i] + mass[i] * (bodies[i].inertia.center_of_mass - joint.anchor).length_squared();
        let missing = match joint.kind {
            JointKind::Free if mass[i] <= 0.0 => "mass",
            JointKind::Slide { .. } if mass[i] <= 0.0 => "mass",
            JointKind::Free if rotational[i] <= 0.0 => "rotational inertia",
            JointKind::Ball | JointKind::Hinge { .. } if turning <= 0.0 => "rotational inertia",
            _ => return None,
        };
        Some((i, joint, missing))
    })
}

pub(super) fn check_geoms(model: &Model) -> Result<(), ModelError> {
    for geom in &model.geoms {
        let part = || format!("geom '{}'", geom.name);
        check_pose(part, &geom.placement)?;
        for (quantity, x) in [
            ("friction", geom.friction),
            ("friction against spinning", geom.spinning_friction),
            ("friction against rolling", geom.rolling_friction),
        ] {
            number(part, quantity, "finite and not negative", x, |x| x >= 0.0)?;
        }
        number(part, "restitution", "between 0 and 1", geom.restitution, |e| (0.0..=1.0).contains(&e))?;
        number(part, "margin", "finite and not negative", geom.margin, |m| m >= 0.0)?;
        let grain = geom.grain.unwrap_or([1.0; 2]);
        grain.iter().try_for_each(|&g| number(part, "grain", "positive and finite", g, |g| g > 0.0))?;
        let belt = geom.surface_velocity.to_array();
        belt.into_iter().try_for_each(|x| number(part, "surface velocity", "finite", x, |_| true))?;
        let invalid = |reason| {
            Err(ModelError::InvalidGeometry { geom: geom.name.clone(), kind: geom.geometry.kind_name(), reason })
        };
        if let Err(reason) = geom.geometry.check() {
            return invalid(reason);
        }
        let moves = model.body_weld[geom.body.index()] != BodyId::WORLD;
        if matches!(geom.geometry, Geometry::Plane) && moves {
            return invalid("a plane can only be fixed to the world or to a body that cannot move".into());
        }
    }
    Ok(())
}

pub(super) fn check_pairs(model: &Model) -> Result<(), ModelError> {
    for pair in &model.pairs {
        for geom in [pair.geom_a, pair.geom_b] {
            known("a contact pair".into(), "geom", geom.index(), model.geoms.len())?;
        }
        if pair.geom_a == pair.geom_b {
            let name = model.geoms[pair.geom_a.index()].name.clone();
            return Err(ModelError::SamePart { part: "a contact pair".into(), sort: "geom", name });
        }
        let part = || "a contact pair".into();
        for x in [pair.friction, pair.spinning_friction, pair.rolling_friction] {
            number(part, "friction", "finite and not negative", x, |x| x >= 0.0)?;
        }
        let e = pair.restitution.unwrap_or(0.0);
        number(part, "restitution", "between 0 and 1", e, |e| (0.0..=1.0).contains(&e))?;
        number(part, "margin", "finite and not negative", pair.margin.unwrap_or(0.0), |m| m >= 0.0)?;
    }
    Ok(())
}

/// Checks what the constraints refer to; rotations are unit to 1e-6.
pub(super) fn check_equalities(model: &Model) -> Result<(), ModelError> {
    for equality in &model.equalities {
        let part = || format!("equality constraint '{}'", equality.name);
        let finite = |x: DVec3| x.to_array().into_iter().try_for_each(|x| number(part, "point", "finite", x, |_| true));
        let apart = |a: BodyId, b: BodyId| {
            known(part(), "body", a.index().max(b.index()), model.bodies.len())?;
            let name = || model.bodies[a.index()].name.clone();
            if a == b { Err(ModelError::SamePart { part: part(), sort: "body", name: name() }) } else { Ok(()) }
        };
        match equality.kind {
            EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
                apart(body_a, body_b)?;
                [point_a, point_b].into_iter().try_for_each(finite)?;
            }
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
                apart(body_a, body_b)?;
                [frame_a, frame_b].iter().try_for_each(|frame| check_pose(part, frame))?;
            }
            EqualityKind::Tendon { tendon, driver, polynomial } => {
                for id in [Some(tendon), driver].into_iter().flatten() {
                    known(part(), "tendon", id.index(), model.tendons.len())?;
                }
                let same = if driver == Some(tendon) { 0.0 } else { 1.0 };
                number(part, "number of tendons that differ from the follower", "1", same, |x| x == 1.0)?;
                polynomial.iter().try_for_each(|&a| number(part, "coefficient", "finite", a, |_| true))?;
            }
            EqualityKind::Joint { joint, driver, polynomial } => {
                for id in [Some(joint), driver].into_iter().flatten() {
                    known(part(), "joint", id.index(), model.joints.len())?;
                    let (joint, reason) = (&model.joints[id.index()], "only hinges and slides can be coupled");
                    if joint.kind.nv() != 1 {
                        let body = model.bodies[joint.body.index()].name.clone();
                        return Err(ModelError::InvalidJoint { joint: joint.name.clone(), body, reason });
                    }
                }
                let same = if driver == Some(joint) { 0.0 } else { 1.0 };
                number(part, "number of joints that differ from the follower", "1", same, |x| x == 1.0)?;
                polynomial.iter().try_for_each(|&a| number(part, "coefficient", "finite", a, |_| true))?;
            }
        }
    }
    Ok(())
}

pub(super) fn check_actuators(model: &Model) -> Result<(), ModelError> {
    for actuator in &model.actuators {
        let part = || format!("actuator '{}'", actuator.name);
        check_transmission(model, part, &actuator.transmission)?;
        number(part, "gear", "finite", actuator.gear, |_| true)?;
        if let (Transmission::Body { .. }, ActuatorKind::Speed | ActuatorKind::Muscle(_)) =
            (&actuator.transmission, actuator.kind)
        {
            let reason = "contacts have no length: their actuator is a motor or an affine one";
            return Err(ModelError::InvalidPath { part: part(), reason: reason.into() });
        }
        match actuator.kind {
            ActuatorKind::Motor => {}
            ActuatorKind::Position { kp, kv } => {
                [kp, kv].iter().try_for_each(|&g| number(part, "gain", "finite and not negative", g, |g| g >= 0.0))?;
            }
            ActuatorKind::Velocity { kv } => number(part, "gain", "finite and not negative", kv, |g| g >= 0.0)?,
            ActuatorKind::Affine { gain, bias } => {
                gain.iter().chain(&bias).try_for_each(|&g| number(part, "gain or bias", "finite", g, |_| true))?;
            }
            ActuatorKind::Muscle(muscle) => check_muscle(part, &muscle)?,
            ActuatorKind::Speed => {
                let ends = actuator.force_range.map_or(0.0, |_| 2.0);
                number(part, "number of ends of its force range", "2", ends, |n| n == 2.0)?;
            }
        }
        let (kind, range) = actuator.activation.map(|a| (a.kind, a.range)).unzip();
        if let Some(ActivationKind::Filter { time_constant } | ActivationKind::ExactFilter { time_constant }) = kind {
            number(part, "time constant", "positive and finite", time_constant, |x| x > 0.0)?;
        }
        if let Some(ActivationKind::Muscle { times, smoothing }) = kind {
            times.iter().try_for_each(|&t| number(part, "time constant", "positive and finite", t, |x| x > 0.0))?;
            number(part, "smoothing", "finite and not negative", smoothing, |x| x >= 0.0)?;
        }
        for range in [actuator.control_range, actuator.force_range, range.flatten()].into_iter().flatten() {
            check_range(part, range)?;
        }
    }
    Ok(())
}

fn check_muscle(part: impl Fn() -> String + Copy, muscle: &Muscle) -> Result<(), ModelError> {
    let not_negative = |what, x| number(part, what, "finite and not negative", x, |x| x >= 0.0);
    not_negative("force", muscle.force)?;
    not_negative("passive force", muscle.passive)?;
    let [low, high] = muscle.length_range;
    number(part, "width of the length range", "positive and finite", high - low, |x| x > 0.0)?;
    number(part, "width of the range", "positive and finite", muscle.range[1] - muscle.range[0], |x| x > 0.0)?;
    number(part, "shortest length", "in [0, 1)", muscle.shortest, |x| (0.0..1.0).contains(&x))?;
    number(part, "longest length", "above 1 and finite", muscle.longest, |x| x > 1.0)?;
    number(part, "largest speed", "positive and finite", muscle.fastest, |x| x > 0.0)?;
    number(part, "force of lengthening", "finite and not below 1", muscle.lengthening, |x| x >= 1.0)
}

pub(super) fn check_range(part: impl Fn() -> String + Copy, [lower, upper]: [f64; 2]) -> Result<(), ModelError> {
    number(part, "upper end of a range", "finite and not below the lower one", upper, |x| x >= lower)?;
    number(part, "lower end of a range", "finite", lower, |_| true)
}

fn check_transmission(
    model: &Model,
    part: impl Fn() -> String + Copy,
    transmission: &Transmission,
) -> Result<(), ModelError> {
    let vector = |v: &[f64; 6]| v.iter().try_for_each(|&x| number(part, "gear", "finite", x, |_| true));
    match transmission {
        Transmission::Joint(joint) => {
            scalar_joint(model, part, *joint, "only a hinge or slide has one coordinate that an actuator can drive")
        }
        Transmission::JointAxes { joint, axes } => {
            known(part(), "joint", joint.index(), model.joints.len())?;
            vector(axes)
        }
        Transmission::Tendon(tendon) => known(part(), "tendon", tendon.index(), model.tendons.len()),
        Transmission::Site { site, reference, wrench } => {
            for site in std::iter::once(site).chain(reference) {
                known(part(), "site", site.index(), model.sites.len())?;
            }
            vector(wrench)
        }
        Transmission::Body { body, layer } => {
            known(part(), "body", body.index(), model.bodies.len())?;
            number(part, "layer", "finite and not negative", *layer, |x| x >= 0.0)
        }
    }
}

/// Whether the joint is there and is a hinge or slide.
pub(super) fn scalar_joint(
    model: &Model,
    part: impl Fn() -> String,
    joint: JointId,
    reason: &'static str,
) -> Result<(), ModelError> {
    known(part(), "joint", joint.index(), model.joints.len())?;
    let joint = &model.joints[joint.index()];
    if joint.kind.nv() == 1 {
        return Ok(());
    }
    let body = model.bodies[joint.body.index()].name.clone();
    Err(ModelError::InvalidJoint { joint: joint.name.clone(), body, reason })
}

pub(super) fn known(part: String, sort: &'static str, index: usize, count: usize) -> Result<(), ModelError> {
    if index < count { Ok(()) } else { Err(ModelError::UnknownPart { part, sort, index, count }) }
}
