//! What can move, and how much of it there is.

use signorini_multibody::{BodyId, JointKind, Model, MovingBodies};

/// What corrections can set in motion.
pub(crate) struct Moving {
    pub bodies: MovingBodies,
    /// Of all bodies, and what armatures add to it along slides, kg.
    pub mass: f64,
    /// The armatures of other joints, kg m²: some robots have no other inertia.
    pub inertia: f64,
}

impl Moving {
    pub fn of(model: &Model) -> Self {
        let moves = |i: &usize| model.body_weld[*i] != BodyId::WORLD;
        let mut mass = (0..model.bodies.len()).filter(moves).map(|i| model.bodies[i].inertia.mass).sum();
        let mut inertia = 0.0;
        for joint in &model.joints {
            let sum = if matches!(joint.kind, JointKind::Slide { .. }) { &mut mass } else { &mut inertia };
            *sum += joint.armature;
        }
        Self { bodies: MovingBodies::of(model), mass, inertia }
    }
}
