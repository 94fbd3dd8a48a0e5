//! Seeded random mechanisms and states.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{BodyId, Inertia, Joint, JointKind, Model, ModelBuilder, Pose, State};

/// Random numbers by SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Uniform in the cube of half-width `size`.
    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.uniform(-size, size), self.uniform(-size, size), self.uniform(-size, size))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(1.0);
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.uniform(-3.0, 3.0))
    }

    pub fn pose(&mut self) -> Pose {
        Pose::new(self.vector(0.7), self.rotation())
    }

    pub fn list(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| self.uniform(-size, size)).collect()
    }

    /// Some distribution of mass with an offset centre of mass and turned principal axes.
    pub fn inertia(&mut self) -> Inertia {
        let (a, b, c) = (self.uniform(0.1, 1.0), self.uniform(0.1, 1.0), self.uniform(0.1, 1.0));
        let mass = self.uniform(0.3, 3.0);
        let r = DMat3::from_quat(self.rotation());
        let principal = DMat3::from_diagonal(DVec3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (mass * 0.2));
        let rotational = r * principal * r.transpose();
        let rotational = (rotational + rotational.transpose()) * 0.5;
        Inertia { mass, center_of_mass: self.vector(0.3), rotational }
    }

    pub fn joint(&mut self, name: String, kind: JointKind) -> Joint {
        let mut joint = Joint::new(name, kind);
        joint.anchor = self.vector(0.4);
        joint.reference = self.uniform(-0.8, 0.8);
        joint
    }

    /// Zero to `most` joints, at most one of them a ball (two would share a rotation).
    fn joint_kinds(&mut self, most: usize) -> Vec<JointKind> {
        let mut kinds = Vec::new();
        for _ in 0..self.below(most + 1) {
            let axis = self.direction();
            kinds.push(match self.below(5) {
                0 if !kinds.contains(&JointKind::Ball) => JointKind::Ball,
                1 | 2 => JointKind::Slide { axis },
                _ => JointKind::Hinge { axis },
            });
        }
        kinds
    }
}

/// What a random mechanism looks like.
#[derive(Clone, Copy)]
pub struct Recipe {
    pub bodies: usize,
    /// Every child of the world has a free joint.
    pub floating: bool,
    /// Joints have rotor inertia. Without it a body has at most one joint, since the mass matrix of several joints in
    /// one body can come close to singular.
    pub armature: bool,
}

/// Several trees of bodies with joints of all kinds, up to three per body, added in an order that mixes the trees.
pub fn random_model(random: &mut Random, recipe: Recipe) -> Model {
    let mut builder = ModelBuilder::new("random");
    builder.gravity(random.vector(10.0));
    let mut bodies = vec![BodyId::WORLD];
    for i in 0..recipe.bodies {
        let parent = if i < 2 { BodyId::WORLD } else { bodies[random.below(bodies.len())] };
        let (placement, inertia) = (random.pose(), random.inertia());
        let body = builder.add_body(format!("b{i}"), parent, placement, inertia).unwrap();
        let at_root = parent == BodyId::WORLD;
        let kinds = if at_root && (recipe.floating || random.below(3) == 0) {
            vec![JointKind::Free]
        } else {
            random.joint_kinds(if recipe.armature { 3 } else { 1 })
        };
        for (j, kind) in kinds.into_iter().enumerate() {
            let mut joint = random.joint(format!("b{i}j{j}"), kind);
            if recipe.armature {
                joint.armature = random.uniform(0.0, 0.2);
            }
            builder.add_joint(body, joint).unwrap();
        }
        bodies.push(body);
    }
    builder.build().unwrap()
}

/// A random configuration and velocity.
pub fn random_state(random: &mut Random, model: &Model) -> State {
    let mut state = State::at(random.list(model.nq, 1.5), random.list(model.nv, 2.0));
    for joint in &model.joints {
        let start = joint.q_index + if joint.kind == JointKind::Free { 3 } else { 0 };
        if joint.kind.nv() >= 3 {
            let r = random.rotation();
            state.q[start..start + 4].copy_from_slice(&[r.w, r.x, r.y, r.z]);
        }
    }
    state
}

/// Calls `check` with a number of random mechanisms in random states.
pub fn for_random_models(seed: u64, recipe: Recipe, check: impl Fn(&Model, &State, &mut Random)) {
    for i in 0..40 {
        let mut random = Random(seed.wrapping_mul(1000) + i);
        let bodies = 1 + i as usize % recipe.bodies;
        let model = random_model(&mut random, Recipe { bodies, ..recipe });
        let state = random_state(&mut random, &model);
        check(&model, &state, &mut random);
    }
}
