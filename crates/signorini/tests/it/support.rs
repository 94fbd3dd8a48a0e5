//! Small worlds and what is asked of every run.

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{
    BodyId, Geom, Geometry, Inertia, Joint, JointKind, Kinematics, Model, ModelBuilder, Pose, State,
    forward_kinematics_into,
};
use signorini::{RunEnd, Settings, Simulation, StepReport};

/// The gravity of all tests, m/s².
pub const G: f64 = 9.81;

/// A world of free bodies over static ones, all with the same friction.
pub struct World {
    pub builder: ModelBuilder,
    friction: f64,
    count: usize,
}

impl World {
    pub fn new(dt: f64, gravity: DVec3, friction: f64) -> Self {
        let mut builder = ModelBuilder::new("test");
        builder.gravity(gravity).timestep(dt);
        Self { builder, friction, count: 0 }
    }

    /// With gravity along −z.
    pub fn upright(dt: f64, friction: f64) -> Self {
        Self::new(dt, DVec3::new(0.0, 0.0, -G), friction)
    }

    fn name(&mut self) -> String {
        self.count += 1;
        format!("part{}", self.count)
    }

    /// A shape fixed to the world.
    pub fn fixed(&mut self, geometry: Geometry, pose: Pose) {
        let mut geom = Geom::new(self.name(), geometry);
        (geom.placement, geom.friction) = (pose, self.friction);
        self.builder.add_geom(BodyId::WORLD, geom).unwrap();
    }

    /// The half-space below `point` with this outward normal.
    pub fn plane(&mut self, point: DVec3, normal: DVec3) {
        self.fixed(Geometry::Plane, Pose::new(point, DQuat::from_rotation_arc(DVec3::Z, normal)));
    }

    pub fn floor(&mut self) {
        self.plane(DVec3::ZERO, DVec3::Z);
    }

    /// A body with one shape about its centre of mass, without joints.
    pub fn body(&mut self, geometry: Geometry, mass: f64, pose: Pose) -> BodyId {
        let inertia = Inertia { mass, center_of_mass: DVec3::ZERO, rotational: rotational_inertia(&geometry, mass) };
        let name = self.name();
        let body = self.builder.add_body(&name, BodyId::WORLD, pose, inertia).unwrap();
        let mut geom = Geom::new(name, geometry);
        geom.friction = self.friction;
        self.builder.add_geom(body, geom).unwrap();
        body
    }

    pub fn free(&mut self, geometry: Geometry, mass: f64, pose: Pose) -> BodyId {
        let body = self.body(geometry, mass, pose);
        let joint = Joint::new(self.name(), JointKind::Free);
        self.builder.add_joint(body, joint).unwrap();
        body
    }

    pub fn free_box(&mut self, half_extents: DVec3, mass: f64, position: DVec3) -> BodyId {
        self.free(Geometry::Box { half_extents }, mass, Pose::from_position(position))
    }

    pub fn free_ball(&mut self, radius: f64, mass: f64, position: DVec3) -> BodyId {
        self.free(Geometry::Sphere { radius }, mass, Pose::from_position(position))
    }

    pub fn simulation(self, settings: Settings) -> Simulation {
        Simulation::new(self.builder.build().unwrap(), settings).unwrap()
    }
}

/// Of a uniform solid about its centre.
fn rotational_inertia(geometry: &Geometry, mass: f64) -> DMat3 {
    match geometry {
        Geometry::Sphere { radius } => DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius)),
        Geometry::Box { half_extents } => {
            let s = half_extents * half_extents;
            DMat3::from_diagonal(DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 3.0))
        }
        other => panic!("no inertia for a {}", other.kind_name()),
    }
}

/// A bundled scene at its start.
pub fn bundled(name: &str) -> Simulation {
    let path = format!("{}/../../scenes/{name}.xml", env!("CARGO_MANIFEST_DIR"));
    let imported = signorini_formats::load(path, &Default::default()).unwrap();
    assert_eq!(imported.report.motion_warnings().count(), 0, "{}", imported.report);
    let keyframe = imported.model.keyframes.first().map(|k| k.name.clone());
    let mut simulation = Simulation::new(imported.model, Settings::default()).unwrap();
    if let Some(name) = keyframe {
        simulation.reset_to(&name).unwrap();
    }
    simulation
}

/// Runs to the end; every step must be solved and certified.
pub fn run_certified(simulation: &mut Simulation, duration: f64) {
    run_observed(simulation, duration, |_, _| {});
}

/// The same with a look at every step.
pub fn run_observed(simulation: &mut Simulation, duration: f64, mut look: impl FnMut(&Simulation, &StepReport)) {
    let end = simulation
        .run(duration, |now, report| {
            assert!(report.certificate.holds(1e-9), "t = {} s: {report:?}", now.state().time);
            look(now, report);
            true
        })
        .unwrap();
    assert_eq!(end, RunEnd::Finished);
    assert_eq!(simulation.summary().missed_steps, 0);
}

/// The numbers of a state, bit by bit.
pub fn bits(state: &State) -> Vec<u64> {
    state.q.iter().chain(&state.v).map(|x| x.to_bits()).collect()
}

/// Origin of free body `k` (counted from 0) in world.
pub fn position(simulation: &Simulation, k: usize) -> DVec3 {
    DVec3::from_slice(&simulation.state().q[7 * k..7 * k + 3])
}

/// Velocity of free body `k` in world.
pub fn velocity(simulation: &Simulation, k: usize) -> DVec3 {
    DVec3::from_slice(&simulation.state().v[6 * k..6 * k + 3])
}

/// Gives free body `k` a velocity: linear in world axes, angular in body axes.
pub fn set_velocity(simulation: &mut Simulation, k: usize, linear: DVec3, angular: DVec3) {
    let mut state = simulation.state().clone();
    state.v[6 * k..6 * k + 3].copy_from_slice(&linear.to_array());
    state.v[6 * k + 3..6 * k + 6].copy_from_slice(&angular.to_array());
    simulation.set_state(&state).unwrap();
}

/// World pose of every body.
pub fn body_poses(simulation: &Simulation) -> Vec<Pose> {
    kinematics(simulation).pose
}

pub fn kinematics(simulation: &Simulation) -> Kinematics {
    let (model, state): (&Model, _) = (simulation.model(), simulation.state());
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    kinematics
}

/// Largest distance that a body's origin is from where it was, m.
pub fn largest_move(start: &[Pose], now: &[Pose]) -> f64 {
    start.iter().zip(now).map(|(a, b)| (a.position - b.position).length()).fold(0.0, f64::max)
}

/// Numbers in [0, 1) from a seed (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
