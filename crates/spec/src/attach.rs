//! One spec put into another.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    ActuatorId, BodyId, CameraId, Equality, EqualityKind, GeomId, JointId, JointKind, Pose, SiteId, TendonId,
};

use crate::SpecError;
use crate::keyframe::KeyframeSpec;
use crate::parts::Named;
use crate::references::{Places, Refers};
use crate::spec::Spec;

impl Spec {
    /// Puts another spec at a body: what is fixed to its world is fixed to that body, `frame` (`X_BW`) says where. Names get `prefix` before
    /// them. Gravity and time step stay; keyframes come with it and say nothing of what was there before.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`] of the body; [`SpecError::DuplicateName`]; [`SpecError::FreeJoint`] where a floating body would hang on
    /// something that is not the world. Nothing has changed then.
    pub fn attach(&mut self, other: &Self, body: &str, frame: Pose, prefix: &str) -> Result<(), SpecError> {
        let target = self.body(body)?;
        let mut joined = self.clone();
        joined.absorb(other, target, frame, prefix)?;
        *self = joined;
        Ok(())
    }

    fn absorb(&mut self, other: &Self, target: BodyId, frame: Pose, prefix: &str) -> Result<(), SpecError> {
        let mut places = Places {
            bodies: vec![None; other.bodies.places()],
            joints: vec![None; other.joints.places()],
            geoms: vec![None; other.geoms.places()],
            sites: vec![None; other.sites.places()],
            tendons: vec![None; other.tendons.places()],
            actuators: vec![None; other.actuators.places()],
            cameras: (0..other.cameras.len()).map(|i| Some(CameraId((self.cameras.len() + i) as u32))).collect(),
        };
        places.bodies[0] = Some(target);
        for i in other.depth_first().into_iter().skip(1) {
            let Some(body) = other.bodies.get(i) else { continue };
            let (root, mut own) = (body.parent == BodyId::WORLD, prefixed(body, prefix));
            own.parent = places.bodies[body.parent.index()].unwrap_or(target);
            if root {
                own.placement = frame * body.placement;
            }
            let floats = other.joints.iter().any(|(_, j)| j.body.index() == i && j.kind == JointKind::Free);
            if root && target != BodyId::WORLD && (floats || body.mocap.is_some()) {
                return Err(SpecError::FreeJoint { body: own.name });
            }
            places.bodies[i] = Some(BodyId(self.bodies.add(own)? as u32));
        }
        self.absorb_fixed(other, frame, prefix, &mut places)?;
        self.absorb_relations(other, frame, prefix, &mut places)
    }

    /// Joints, geoms and sites.
    fn absorb_fixed(&mut self, other: &Self, frame: Pose, prefix: &str, places: &mut Places) -> Result<(), SpecError> {
        let lost = |part: &str| SpecError::DanglingReference { part: part.to_owned(), sort: "body" };
        for (i, joint) in other.joints.iter() {
            let mut own = prefixed(joint, prefix);
            places.body(&mut own.body).map_err(|_| lost(&joint.name))?;
            places.joints[i] = Some(JointId(self.joints.add(own)? as u32));
        }
        for (i, geom) in other.geoms.iter() {
            let mut own = prefixed(geom, prefix);
            if geom.body == BodyId::WORLD {
                own.placement = frame * geom.placement;
            }
            places.body(&mut own.body).map_err(|_| lost(&geom.name))?;
            places.geoms[i] = Some(GeomId(self.geoms.add(own)? as u32));
        }
        for (i, site) in other.sites.iter() {
            let mut own = prefixed(site, prefix);
            if site.body == BodyId::WORLD {
                own.placement = frame * site.placement;
            }
            places.body(&mut own.body).map_err(|_| lost(&site.name))?;
            places.sites[i] = Some(SiteId(self.sites.add(own)? as u32));
        }
        Ok(())
    }

    /// What refers to bodies, joints, geoms and sites.
    fn absorb_relations(
        &mut self,
        other: &Self,
        frame: Pose,
        prefix: &str,
        places: &mut Places,
    ) -> Result<(), SpecError> {
        for (i, tendon) in other.tendons.iter() {
            let own = prefixed(&tendon.moved(places)?, prefix);
            places.tendons[i] = Some(TendonId(self.tendons.add(own)? as u32));
        }
        for (i, actuator) in other.actuators.iter() {
            let own = prefixed(&actuator.moved(places)?, prefix);
            places.actuators[i] = Some(ActuatorId(self.actuators.add(own)? as u32));
        }
        for (_, sensor) in other.sensors.iter() {
            self.sensors.add(prefixed(&sensor.moved(places)?, prefix))?;
        }
        for (_, equality) in other.equalities.iter() {
            self.equalities.add(prefixed(&in_place(equality, frame).moved(places)?, prefix))?;
        }
        for (_, keyframe) in other.keyframes.iter() {
            self.keyframes.add(prefixed(&other.keyframe_in_place(keyframe, frame).moved(places)?, prefix))?;
        }
        for camera in &other.cameras {
            let mut own = camera.moved(places)?;
            own.name = format!("{prefix}{}", own.name);
            if camera.body == BodyId::WORLD {
                own.placement = frame * camera.placement;
            }
            self.cameras.push(own);
        }
        for light in &other.lights {
            let mut own = light.moved(places)?;
            if light.body == BodyId::WORLD {
                own.position = frame.transform_point(light.position);
                own.direction = frame.rotation * light.direction;
            }
            self.lights.push(own);
        }
        let dangling = |sort| SpecError::DanglingReference { part: "a contact pair or exclusion".into(), sort };
        for pair in &other.pairs {
            let mut pair = *pair;
            places.geom(&mut pair.geom_a).and_then(|()| places.geom(&mut pair.geom_b)).map_err(dangling)?;
            self.pairs.push(pair);
        }
        for &(mut a, mut b) in &other.excluded {
            places.body(&mut a).and_then(|()| places.body(&mut b)).map_err(dangling)?;
            self.excluded.push((a, b));
        }
        Ok(())
    }

    /// A keyframe with what it says in world axes moved: where floating bodies and bodies moved from outside are, and how the former
    /// translate. Everything else is relative to a body.
    fn keyframe_in_place(&self, keyframe: &KeyframeSpec, frame: Pose) -> KeyframeSpec {
        let floats = |id: JointId| self.joints.get(id.index()).is_some_and(|joint| joint.kind == JointKind::Free);
        let mut keyframe = keyframe.clone();
        for (_, q) in keyframe.q.iter_mut().filter(|(id, q)| floats(*id) && q.len() == JointKind::Free.nq()) {
            let position = frame.transform_point(DVec3::from_slice(q));
            let rotation = frame.rotation * DQuat::from_xyzw(q[4], q[5], q[6], q[3]);
            q[..3].copy_from_slice(&position.to_array());
            q[3..].copy_from_slice(&[rotation.w, rotation.x, rotation.y, rotation.z]);
        }
        for (_, v) in keyframe.v.iter_mut().filter(|(id, v)| floats(*id) && v.len() == JointKind::Free.nv()) {
            let linear = frame.rotation * DVec3::from_slice(v);
            v[..3].copy_from_slice(&linear.to_array());
        }
        keyframe.mocap.iter_mut().for_each(|(_, pose)| *pose = frame * *pose);
        keyframe
    }
}

/// A constraint whose anchors in the world have moved with it.
fn in_place(equality: &Equality, frame: Pose) -> Equality {
    let mut equality = equality.clone();
    match &mut equality.kind {
        EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
            for (body, point) in [(body_a, point_a), (body_b, point_b)] {
                if *body == BodyId::WORLD {
                    *point = frame.transform_point(*point);
                }
            }
        }
        EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
            for (body, own) in [(body_a, frame_a), (body_b, frame_b)] {
                if *body == BodyId::WORLD {
                    *own = frame * *own;
                }
            }
        }
        EqualityKind::Joint { .. } | EqualityKind::Tendon { .. } => {}
    }
    equality
}

fn prefixed<T: Named + Clone>(part: &T, prefix: &str) -> T {
    let mut part = part.clone();
    part.rename(format!("{prefix}{}", part.name()));
    part
}
