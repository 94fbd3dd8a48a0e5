//! Rapier. Arguments: scenes file, output, scene's name, variant, seconds of CPU time. Writes what `protocol.py` describes.
//!
//! Variants: `default` (4 iterations, simplified friction), or tokens joined by `-`: `itN` (N iterations), `hz60` (contact
//! frequency 60 Hz, against fixed bodies 120 Hz), `coulomb` (friction point by point, of which alone it tells the impulses of a whole
//! step). No sleeping, no continuous collision detection, one thread.

use std::collections::HashMap;

use rapier3d_f64::prelude::*;
use rapier3d_f64::utils::OrthonormalBasis;
use serde_json::{Value, json};

/// CPU seconds of this thread.
fn cpu_seconds() -> f64 {
    #[repr(C)]
    struct Time {
        seconds: i64,
        nanoseconds: i64,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut Time) -> i32;
    }
    const THREAD_CPU: i32 = 3;
    let mut time = Time { seconds: 0, nanoseconds: 0 };
    // SAFETY: the pointer is to a timespec of this platform.
    unsafe { clock_gettime(THREAD_CPU, &mut time) };
    time.seconds as f64 + 1e-9 * time.nanoseconds as f64
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(row: &Value, first: usize) -> Vector {
    Vector::new(number(&row[first]), number(&row[first + 1]), number(&row[first + 2]))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn parameters(variant: &str, dt: f64) -> IntegrationParameters {
    let mut parameters = IntegrationParameters { dt, max_ccd_substeps: 0, ..Default::default() };
    for token in variant.split('-') {
        match token {
            "default" => {}
            "hz60" => {
                parameters.contact_softness.natural_frequency = 60.0;
                parameters.static_contact_softness.natural_frequency = 120.0;
            }
            "coulomb" => parameters.friction_model = FrictionModel::Coulomb,
            _ => parameters.num_solver_iterations = token.trim_start_matches("it").parse().expect("itN"),
        }
    }
    parameters
}

struct World {
    parameters: IntegrationParameters,
    gravity: Vector,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    multibody: MultibodyJointSet,
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    narrow_phase: NarrowPhase,
    ccd: CCDSolver,
    soft: SoftBodySet,
    handles: Vec<RigidBodyHandle>,
    index: HashMap<RigidBodyHandle, i64>,
    /// Poses at the beginning of the step.
    before: Vec<Pose>,
}

impl World {
    fn new(scene: &Value, variant: &str) -> Self {
        let mut world = Self {
            parameters: parameters(variant, number(&scene["dt"])),
            gravity: vector(&scene["gravity"], 0),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: ImpulseJointSet::new(),
            multibody: MultibodyJointSet::new(),
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: DefaultBroadPhase::new(),
            narrow_phase: NarrowPhase::new(),
            ccd: CCDSolver::new(),
            soft: SoftBodySet::new(),
            handles: Vec::new(),
            index: HashMap::new(),
            before: Vec::new(),
        };
        let friction = number(&scene["mu"]);
        let fixed = world.bodies.insert(RigidBodyBuilder::fixed());
        for plane in list(&scene["planes"]) {
            let normal = vector(plane, 0);
            let shape = SharedShape::halfspace(normal.normalize());
            let collider = ColliderBuilder::new(shape).translation(normal * number(&plane[3])).friction(friction);
            world.colliders.insert_with_parent(collider, fixed, &mut world.bodies);
        }
        for row in list(&scene["bodies"]) {
            world.add_body(row, friction, scene["collide"].as_bool().unwrap_or(true));
        }
        for (handle, row) in world.handles.iter().zip(list(&scene["velocities"])) {
            let body = &mut world.bodies[*handle];
            body.set_linvel(vector(row, 0), true);
            body.set_angvel(vector(row, 3), true);
        }
        for joint in list(&scene["joints"]) {
            world.add_joint(joint, fixed);
        }
        for force in list(&scene["forces"]) {
            let body = world.handles[number(&force[0]) as usize];
            world.bodies[body].add_force(vector(force, 1), true);
        }
        world
    }

    fn add_body(&mut self, row: &Value, friction: f64, collide: bool) {
        let (size, mass, is_box) = (vector(row, 1), number(&row[4]), row[0] == "b");
        let squares = size * size;
        let moments = if is_box {
            Vector::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y) * (mass / 3.0)
        } else {
            Vector::splat(0.4 * mass * squares.x)
        };
        let q = Rotation::from_xyzw(number(&row[9]), number(&row[10]), number(&row[11]), number(&row[8]));
        let body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(vector(row, 5), q))
            .can_sleep(false)
            .linear_damping(0.0)
            .angular_damping(0.0)
            .additional_mass_properties(MassProperties::new(Vector::ZERO, mass, moments));
        let handle = self.bodies.insert(body);
        if collide {
            let collider =
                if is_box { ColliderBuilder::cuboid(size.x, size.y, size.z) } else { ColliderBuilder::ball(size.x) };
            let collider = collider.density(0.0).friction(friction).restitution(0.0);
            self.colliders.insert_with_parent(collider, handle, &mut self.bodies);
        }
        self.index.insert(handle, self.handles.len() as i64);
        self.handles.push(handle);
    }

    fn add_joint(&mut self, joint: &Value, fixed: RigidBodyHandle) {
        let parent = number(&joint["a"]);
        let a = if parent < 0.0 { fixed } else { self.handles[parent as usize] };
        let b = self.handles[number(&joint["b"]) as usize];
        let (anchor, axis) = (vector(&joint["anchor"], 0), vector(&joint["axis"], 0));
        let (pose_a, pose_b) = (*self.bodies[a].position(), *self.bodies[b].position());
        let local = |pose: Pose, point: Vector| pose.rotation.inverse() * (point - pose.translation);
        let hinge = joint["type"] == "hinge";
        let locked =
            if hinge { JointAxesMask::LOCKED_REVOLUTE_AXES } else { JointAxesMask::LOCKED_PRISMATIC_AXES };
        let builder = GenericJointBuilder::new(locked);
        let mut data = builder.local_anchor1(local(pose_a, anchor)).local_anchor2(local(pose_b, anchor)).build();
        data.set_local_axis1(pose_a.rotation.inverse() * axis);
        // The same frame of the world seen from both bodies.
        data.local_frame2.rotation = pose_b.rotation.inverse() * (pose_a.rotation * data.local_frame1.rotation);
        self.joints.insert(a, b, data, true);
    }

    fn step(&mut self) {
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.joints,
            &mut self.multibody,
            &mut self.soft,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    fn state(&self) -> Value {
        let row = |handle: &RigidBodyHandle| {
            let body = &self.bodies[*handle];
            let (p, q, v, w) = (body.translation(), *body.rotation(), body.linvel(), body.angvel());
            json!([p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z])
        };
        self.handles.iter().map(row).collect()
    }

    fn finite(&self) -> bool {
        self.handles.iter().all(|h| self.bodies[*h].translation().z.is_finite())
    }

    /// Points that the solver sees, speculative ones included.
    fn contacts(&self) -> usize {
        let pairs = self.narrow_phase.contact_pairs();
        pairs.map(|p| p.solver_manifolds().iter().map(|m| m.data.solver_contacts.len()).sum::<usize>()).sum()
    }

    /// Where a contact's point on a body was at the beginning of the step.
    fn point(&self, body: i64, anchor: Vector) -> Vector {
        if body < 0 { anchor } else { self.before[body as usize] * anchor }
    }

    /// Friction impulse on the second body of a pair: of the whole step in Coulomb's model, else what is left for the next warm start.
    fn friction(&self, data: &ContactData, normal: Vector) -> Vector {
        if self.parameters.friction_model != FrictionModel::Coulomb {
            return data.warmstart_tangent_world;
        }
        let first = (-normal).orthonormal_vector();
        -(first * data.tangent_impulse.x + (-normal).cross(first) * data.tangent_impulse.y)
    }

    /// Impulses over Δt, gaps and points of the beginning of the step.
    fn forces(&self) -> Vec<Value> {
        let mut rows = Vec::new();
        for manifold in self.narrow_phase.contact_pairs().flat_map(|p| p.solver_manifolds()) {
            let index = |h: Option<RigidBodyHandle>| h.and_then(|h| self.index.get(&h).copied()).unwrap_or(-1);
            let (mut i, mut j) = (index(manifold.data.rigid_body2), index(manifold.data.rigid_body1));
            let sign = if i < 0 { -1.0 } else { 1.0 };
            if i < 0 {
                std::mem::swap(&mut i, &mut j);
            }
            for contact in &manifold.data.solver_contacts {
                let data = &manifold.points[(contact.contact_id[0] & 0x7fff_ffff) as usize].data;
                let (first, second) = if sign < 0.0 { (i, j) } else { (j, i) };
                let (p_1, p_2) = (self.point(first, contact.anchor1), self.point(second, contact.anchor2));
                let (p, n) = ((p_1 + p_2) * 0.5, manifold.data.normal * sign);
                let f = self.friction(data, manifold.data.normal) * (sign / self.parameters.dt);
                let (normal, gap) = (data.impulse / self.parameters.dt, (p_2 - p_1).dot(manifold.data.normal));
                let friction = manifold.data.friction;
                rows.push(json!([i, j, p.x, p.y, p.z, n.x, n.y, n.z, normal, f.x, f.y, f.z, friction, gap, 0.0, 0.0, 0.0]));
            }
        }
        rows
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, file, out, name, variant, cap] = arguments.as_slice() else {
        panic!("expected: scenes file, output, scene, variant, seconds");
    };
    let scenes: Value = serde_json::from_str(&std::fs::read_to_string(file).expect("the scenes")).expect("JSON");
    let scene = &scenes[name];
    let cap: f64 = cap.parse().expect("seconds");
    let dt = number(&scene["dt"]);
    let (steps, every) = ((number(&scene["duration"]) / dt).round() as usize, number(&scene["sample_every"]) as usize);
    let mut world = World::new(scene, variant);
    let (mut times, mut samples, mut counts) = (Vec::new(), vec![json!([0.0, world.state()])], vec![0]);
    let (mut snapshots, mut error) = (Vec::new(), Value::Null);
    let begin = cpu_seconds();
    for k in 0..steps {
        let snapshot = k + 3 >= steps || (steps > 20 && k % (steps / 4) == steps / 8);
        let before = if snapshot { world.state() } else { Value::Null };
        world.before = world.handles.iter().map(|handle| *world.bodies[*handle].position()).collect();
        let start = cpu_seconds();
        world.step();
        times.push(((cpu_seconds() - start) * 1e9) as u64);
        let t = (k + 1) as f64 * dt;
        if snapshot {
            snapshots.push(json!({"t": t, "before": before, "after": world.state(), "forces": world.forces()}));
        }
        let (late, finite) = (cpu_seconds() - begin > cap, world.finite());
        if late || !finite || (k + 1) % every == 0 || k + 1 == steps {
            samples.push(json!([t, world.state()]));
            counts.push(world.contacts());
        }
        if !finite {
            error = json!("a state that is not finite");
        }
        if late || !finite {
            break;
        }
    }
    let run = json!({"engine": "rapier", "variant": variant, "version": "0.36.1", "scene": name, "dt": dt, "planned": steps,
        "done": times.len(), "error": error, "step_ns": times, "samples": samples, "contacts": counts, "snapshots": snapshots});
    std::fs::write(out, run.to_string()).expect("the output can be written");
}
