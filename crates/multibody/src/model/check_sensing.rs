//! What sites, tendons, sensors and keyframes must satisfy.

use super::check::{
    check_actuators, check_equalities, check_geoms, check_joints, check_mass, check_mocap, check_pairs, check_pose,
    check_range, known, number, scalar_joint,
};
use super::{
    Camera, CameraMode, ContactSide, FrameId, Geometry, JointKind, Model, ModelError, PathPart, SensorKind, Shapes,
};
use crate::math::unit_rotation;

/// What joints, geoms, constraints and all that refers to them must satisfy.
pub(super) fn check_relations(model: &Model) -> Result<(), ModelError> {
    check_joints(model)?;
    check_mocap(model)?;
    check_mass(model)?;
    check_geoms(model)?;
    check_pairs(model)?;
    check_equalities(model)?;
    check_sites(model)?;
    check_tendons(model)?;
    check_actuators(model)
}

fn check_sites(model: &Model) -> Result<(), ModelError> {
    for site in &model.sites {
        check_pose(|| format!("site '{}'", site.name), &site.placement)?;
        let kind = site.zone.kind_name();
        let invalid = |reason| Err(ModelError::InvalidGeometry { geom: site.name.clone(), kind, reason });
        if let Err(reason) = site.zone.check() {
            return invalid(reason);
        }
        let solid = matches!(
            site.zone,
            Geometry::Sphere { .. }
                | Geometry::Box { .. }
                | Geometry::Capsule { .. }
                | Geometry::Cylinder { .. }
                | Geometry::Ellipsoid { .. }
        );
        if !solid {
            return invalid("the zone of a site is a sphere, box, capsule, cylinder or ellipsoid".into());
        }
    }
    Ok(())
}

fn check_tendons(model: &Model) -> Result<(), ModelError> {
    for tendon in &model.tendons {
        let part = || format!("tendon '{}'", tendon.name);
        for &(joint, coefficient) in &tendon.terms {
            scalar_joint(model, part, joint, "only hinges and slides can be part of a fixed tendon")?;
            number(part, "coefficient", "finite", coefficient, |_| true)?;
        }
        check_path(model, part, &tendon.path)?;
        number(part, "stiffness", "finite and not negative", tendon.stiffness, |x| x >= 0.0)?;
        number(part, "damping", "finite and not negative", tendon.damping, |x| x >= 0.0)?;
        for range in std::iter::once(tendon.rest).chain(tendon.limits) {
            check_range(part, range)?;
        }
    }
    Ok(())
}

/// Every branch of a path begins and ends with a site, and no two obstacles follow each other.
fn check_path(model: &Model, part: impl Fn() -> String + Copy, path: &[PathPart]) -> Result<(), ModelError> {
    let invalid = |reason: &str| Err(ModelError::InvalidPath { part: part(), reason: reason.into() });
    let (mut sites, mut last) = (0, None);
    for (k, step) in path.iter().enumerate() {
        match *step {
            PathPart::Site(site) => {
                known(part(), "site", site.index(), model.sites.len())?;
                sites += 1;
            }
            PathPart::Wrap { geom, side } => {
                known(part(), "geom", geom.index(), model.geoms.len())?;
                if let Some(site) = side {
                    known(part(), "site", site.index(), model.sites.len())?;
                }
                if !matches!(model.geoms[geom.index()].geometry, Geometry::Sphere { .. } | Geometry::Cylinder { .. }) {
                    return invalid("only spheres and cylinders can be in the way of a tendon");
                }
                let between = |other: Option<&PathPart>| matches!(other, Some(PathPart::Site(_)));
                if !between(last) || !between(path.get(k + 1)) {
                    return invalid("a geom in the way of a tendon stands between two sites");
                }
            }
            PathPart::Pulley { divisor } => {
                number(part, "divisor", "positive and finite", divisor, |x| x > 0.0)?;
                if k > 0 && sites < 2 {
                    return invalid("every branch needs two sites");
                }
                sites = 0;
            }
        }
        last = Some(step);
    }
    if path.is_empty() || sites >= 2 { Ok(()) } else { invalid("every branch needs two sites") }
}

pub(super) fn check_sensors(model: &Model) -> Result<(), ModelError> {
    use SensorKind::*;
    for sensor in &model.sensors {
        let part = || format!("sensor '{}'", sensor.name);
        let at = |sort, index, count| known(part(), sort, index, count);
        let site = |id: super::SiteId| at("site", id.index(), model.sites.len());
        let body = |id: super::BodyId| at("body", id.index(), model.bodies.len());
        let frame = |id: FrameId| match id {
            FrameId::Body(id) | FrameId::CenterOfMass(id) => body(id),
            FrameId::Geom(id) => at("geom", id.index(), model.geoms.len()),
            FrameId::Site(id) => site(id),
        };
        match sensor.kind {
            JointPosition(joint) | JointVelocity(joint) | JointActuatorForce(joint) => {
                scalar_joint(model, part, joint, "this sensor needs a hinge or slide")?;
            }
            JointLimitPosition(joint) | JointLimitVelocity(joint) | JointLimitForce(joint) => {
                at("joint", joint.index(), model.joints.len())?;
            }
            BallQuaternion(joint) | BallAngularVelocity(joint) => {
                at("joint", joint.index(), model.joints.len())?;
                let joint = &model.joints[joint.index()];
                if joint.kind != JointKind::Ball {
                    let body = model.bodies[joint.body.index()].name.clone();
                    let reason = "this sensor needs a ball joint";
                    return Err(ModelError::InvalidJoint { joint: joint.name.clone(), body, reason });
                }
            }
            TendonPosition(tendon)
            | TendonVelocity(tendon)
            | TendonActuatorForce(tendon)
            | TendonLimitPosition(tendon)
            | TendonLimitVelocity(tendon)
            | TendonLimitForce(tendon) => {
                at("tendon", tendon.index(), model.tendons.len())?;
            }
            ActuatorPosition(actuator) | ActuatorVelocity(actuator) | ActuatorForce(actuator) => {
                at("actuator", actuator.index(), model.actuators.len())?;
            }
            Velocimeter(id) | Gyro(id) | Accelerometer(id) | Force(id) | Torque(id) | Touch(id) => site(id)?,
            Magnetometer(id) | Rangefinder(id) => site(id)?,
            InsideSite(own, id) => {
                frame(own)?;
                site(id)?;
            }
            CameraProjection(id, camera) => {
                site(id)?;
                at("camera", camera.index(), model.cameras.len())?;
            }
            Contacts(contacts) => {
                number(part, "number of slots", "positive", f64::from(contacts.slots), |x| x > 0.0)?;
                number(part, "numbers for each contact", "at least 1", contacts.slot_size() as f64, |x| x >= 1.0)?;
                contacts.sides.into_iter().try_for_each(|side| match side {
                    ContactSide::Any => Ok(()),
                    ContactSide::Geom(id) => frame(FrameId::Geom(id)),
                    ContactSide::Body(id) | ContactSide::Subtree(id) => body(id),
                    ContactSide::Zone(id) => site(id),
                })?;
            }
            ShapeDistance(a, b) | ShapeNormal(a, b) | ShapePoints(a, b) => {
                [a, b].into_iter().try_for_each(|shapes| match shapes {
                    Shapes::Geom(id) => frame(FrameId::Geom(id)),
                    Shapes::Body(id) => body(id),
                })?;
            }
            FramePosition(id, reference)
            | FrameQuaternion(id, reference)
            | FrameLinearVelocity(id, reference)
            | FrameAngularVelocity(id, reference) => [Some(id), reference].into_iter().flatten().try_for_each(frame)?,
            FrameAxis(id, reference, axis) => {
                [Some(id), reference].into_iter().flatten().try_for_each(frame)?;
                number(part, "axis", "0, 1 or 2", f64::from(axis), |axis| axis <= 2.0)?;
            }
            FrameLinearAcceleration(id) | FrameAngularAcceleration(id) => frame(id)?,
            SubtreeCenterOfMass(id) | SubtreeLinearVelocity(id) | SubtreeAngularMomentum(id) => body(id)?,
            PotentialEnergy | KineticEnergy | Clock => {}
        }
        if let Some(cutoff) = sensor.cutoff {
            number(part, "cutoff", "positive and finite", cutoff, |x| x > 0.0)?;
        }
    }
    Ok(())
}

/// Checks that numbers of cameras are in their ranges, and makes rotations unit.
pub(super) fn check_cameras(cameras: &mut [Camera], bodies: usize) -> Result<(), ModelError> {
    for camera in cameras {
        let part = || format!("camera '{}'", camera.name);
        let inside = |angle: f64| angle > 0.0 && angle < std::f64::consts::PI;
        number(part, "field of view", "between 0 and 180 degrees", camera.field_of_view, inside)?;
        for count in camera.resolution {
            number(part, "resolution", "positive", f64::from(count), |n| n > 0.0)?;
        }
        for x in camera.focal.into_iter().flatten() {
            number(part, "focal length", "positive and finite", x, |x| x > 0.0)?;
        }
        if let CameraMode::Target(body) | CameraMode::TargetCenterOfMass(body) = camera.mode
            && body.index() >= bodies
        {
            return Err(ModelError::UnknownPart { part: part(), sort: "body", index: body.index(), count: bodies });
        }
        camera.placement.rotation = unit_rotation(camera.placement.rotation);
    }
    Ok(())
}

/// Checks sizes and numbers and normalises the quaternions.
pub(super) fn check_keyframes(model: &mut Model) -> Result<(), ModelError> {
    let (nq, nv, na, nu) = (model.nq, model.nv, model.na, model.actuators.len());
    for keyframe in &mut model.keyframes {
        let part = format!("keyframe '{}'", keyframe.name);
        for (list, expected, values) in [
            ("qpos", nq, &keyframe.q),
            ("qvel", nv, &keyframe.v),
            ("act", na, &keyframe.activation),
            ("ctrl", nu, &keyframe.control),
        ] {
            if values.len() != expected {
                return Err(ModelError::WrongLength { part, list, expected, found: values.len() });
            }
            for &x in values {
                number(|| part.clone(), list, "finite", x, |_| true)?;
            }
        }
        let count = model.mocap_bodies.len();
        if ![0, count].contains(&keyframe.mocap.len()) {
            let (list, found) = ("mpos and mquat", keyframe.mocap.len());
            return Err(ModelError::WrongLength { part, list, expected: count, found });
        }
        for pose in &mut keyframe.mocap {
            check_pose(|| part.clone(), pose)?;
            pose.rotation = pose.rotation.normalize();
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
