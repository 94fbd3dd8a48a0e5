//! Named states, part by part, so that they stay what they are while parts come and go.

use signorini_multibody::{ActuatorId, BodyId, JointId, Keyframe, Model, Pose};

/// A named state; what it does not name is at its reference, at rest, at zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyframeSpec {
    /// Unique name.
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Configuration of joints: as many numbers as the joint's q has.
    pub q: Vec<(JointId, Vec<f64>)>,
    /// Velocity of joints: as many numbers as the joint's v has.
    pub v: Vec<(JointId, Vec<f64>)>,
    /// Activations of actuators.
    pub activation: Vec<(ActuatorId, f64)>,
    /// Control values.
    pub control: Vec<(ActuatorId, f64)>,
    /// Where bodies stand that are moved from outside.
    pub mocap: Vec<(BodyId, Pose)>,
}

impl KeyframeSpec {
    pub(crate) fn of(model: &Model, keyframe: &Keyframe) -> Self {
        let joints = || (0..).map(JointId).zip(&model.joints);
        let part = |list: &[f64], start: usize, count: usize| list.get(start..start + count).unwrap_or(&[]).to_vec();
        let remembers = (0..).map(ActuatorId).zip(&model.actuators);
        let activation =
            remembers.filter_map(|(id, actuator)| Some((id, *keyframe.activation.get(actuator.activation?.index)?)));
        Self {
            name: keyframe.name.clone(),
            time: keyframe.time,
            q: joints().map(|(id, joint)| (id, part(&keyframe.q, joint.q_index, joint.kind.nq()))).collect(),
            v: joints().map(|(id, joint)| (id, part(&keyframe.v, joint.v_index, joint.kind.nv()))).collect(),
            activation: activation.collect(),
            control: (0..).map(ActuatorId).zip(keyframe.control.iter().copied()).collect(),
            mocap: model.mocap_bodies.iter().copied().zip(keyframe.mocap.iter().copied()).collect(),
        }
    }
}
