//! How long does each part of the smooth dynamics take for one free box and for a quadruped with 18 degrees of freedom?
//!
//! Prints nanoseconds per call, the best of 20 rounds: `cargo bench -p signorini-multibody`.

use std::hint::black_box;
use std::time::Instant;

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{
    ArticulatedBodies, BodyId, FreeMotion, Inertia, Input, JacobianRows, Joint, JointKind, Kinematics, MassMatrix,
    Model, ModelBuilder, NewtonEuler, Pose, State, bias_force_into, contact_rows_into, forward_dynamics_into,
    forward_kinematics_into, free_motion_into, integrate_into, mass_matrix_into,
};

fn cuboid(mass: f64, half: DVec3, center_of_mass: DVec3) -> Inertia {
    let s = half * half * (mass / 3.0);
    let rotational = DMat3::from_diagonal(DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y));
    Inertia { mass, center_of_mass, rotational }
}

fn free_box() -> Model {
    let mut builder = ModelBuilder::new("free box");
    let inertia = cuboid(1.0, DVec3::new(0.1, 0.2, 0.3), DVec3::ZERO);
    let body = builder.add_body("box", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    builder.build().unwrap()
}

fn quadruped() -> Model {
    let mut builder = ModelBuilder::new("quadruped");
    let inertia = cuboid(10.0, DVec3::new(0.3, 0.15, 0.1), DVec3::new(0.01, 0.0, 0.02));
    let torso = builder.add_body("torso", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(torso, Joint::new("root", JointKind::Free)).unwrap();
    for (leg, (x, y)) in [(0.25, 0.1), (0.25, -0.1), (-0.25, 0.1), (-0.25, -0.1)].into_iter().enumerate() {
        let mut parent = torso;
        let mut position = DVec3::new(x, y, 0.0);
        for (part, axis) in [("hip", DVec3::X), ("thigh", DVec3::Y), ("calf", DVec3::Y)] {
            let inertia = cuboid(0.8, DVec3::new(0.02, 0.02, 0.1), DVec3::new(0.0, 0.01, -0.1));
            parent = builder.add_body(format!("{part}{leg}"), parent, Pose::from_position(position), inertia).unwrap();
            let joint = Joint::new(format!("{part}{leg}"), JointKind::Hinge { axis }).with_damping(0.1);
            builder.add_joint(parent, joint).unwrap();
            position = DVec3::new(0.0, 0.0, -0.2);
        }
    }
    builder.build().unwrap()
}

/// Best time of a call, ns.
fn time(name: &str, mut call: impl FnMut()) {
    const CALLS: u32 = 20_000;
    let round = |call: &mut dyn FnMut()| {
        let start = Instant::now();
        (0..CALLS).for_each(|_| call());
        start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    let best = (0..20).map(|_| round(&mut call)).fold(f64::INFINITY, f64::min);
    println!("  {name:<22} {best:9.1} ns");
}

fn measure(model: &Model) {
    println!("{} ({} degrees of freedom)", model.name, model.nv);
    let mut state = State::new(model);
    (0..model.nv).for_each(|k| state.v[k] = 0.1 * (k as f64 + 1.0).sin());
    let velocity = state.v.clone();
    integrate_into(model, &State::new(model).q, &velocity, 3.0, &mut state.q);
    let (input, last) = (Input::default(), BodyId(model.bodies.len() as u32 - 1));
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    time("forward kinematics", || forward_kinematics_into(model, black_box(&state.q), &state.v, &mut kinematics));
    let mut rows = JacobianRows::new(model);
    let directions = DVec3::AXES;
    time("contact rows", || {
        contact_rows_into(model, &kinematics, (BodyId::WORLD, last), black_box(DVec3::X), &directions, &mut rows);
    });
    let mut mass = MassMatrix::new(model);
    time("mass matrix", || mass_matrix_into(model, black_box(&kinematics), &mut mass));
    let mut factor = mass.matrix.factor().unwrap();
    time("factor", || factor.refactor(black_box(&mass.matrix)).unwrap());
    let mut x = state.v.clone();
    time("solve", || factor.solve_in_place(black_box(&mut x)));
    let mut half = rows.columns.clone();
    time("half solve of rows", || {
        half.copy_from_slice(black_box(&rows.columns));
        factor.half_solve_sparse(&rows.dofs, &mut half);
    });
    let (mut work, mut h) = (NewtonEuler::new(model), vec![0.0; model.nv]);
    time("bias force", || bias_force_into(model, black_box(&kinematics), &mut work, &mut h));
    let (mut work, mut acceleration) = (ArticulatedBodies::new(model), vec![0.0; model.nv]);
    time("forward dynamics", || {
        forward_dynamics_into(model, black_box(&kinematics), &h, &mut work, &mut acceleration).unwrap();
    });
    let mut free = FreeMotion::new(model);
    time("free motion", || {
        free_motion_into(model, black_box(&kinematics), &state, &input, 1e-3, &mut free).unwrap();
    });
    let mut q = state.q.clone();
    time("integrate", || integrate_into(model, black_box(&state.q), &state.v, 1e-3, &mut q));
}

fn main() {
    measure(&free_box());
    measure(&quadruped());
}
