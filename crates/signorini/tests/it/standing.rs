//! Quadruped robots that stand on four feet by servos: no creep, and the forces of statics.

use std::path::PathBuf;

use signorini::multibody::{
    Actuator, ActuatorKind, Geom, Geometry, Input, JointId, JointKind, Model, NewtonEuler, State, Transmission,
    forward_kinematics_into, inverse_dynamics_into, point_column, total_mass,
};
use signorini::{DrivenVelocity, FrictionSource, InverseMotion, Settings, Simulation, Workspace, inverse_step};
use signorini_formats::LoadOptions;

use crate::support::{G, bundled, kinematics, run_certified};

const ROBOTS: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../build/robots/cmeel.prefix/share/example-robot-data/robots");

/// Stiffness and damping of the servos of the robots that come without, N·m/rad and N·m·s/rad.
const SERVO: ActuatorKind = ActuatorKind::Position { kp: 100.0, kv: 5.0 };

/// The slowest sway on such servos decays within a fifth of a second; after this time it is below a picometre.
const SETTLING: f64 = 6.0;

/// A published robot of twelve hinges on a floor, bent to stand: every leg with its hip, thigh and calf at `LEG`.
fn published(path: &str) -> Option<(Model, State, Vec<f64>)> {
    const LEG: [f64; 3] = [0.0, 0.8, -1.6];
    let path = PathBuf::from(ROBOTS).join(path);
    if !path.is_file() {
        println!("skipped: {} is absent; benchmarks/robots/fetch.py fetches it", path.display());
        return None;
    }
    let mut model = signorini_formats::load(&path, &LoadOptions::default().with_floating_base(true)).unwrap().model;
    model.geoms.iter_mut().for_each(|geom| geom.contact_affinity = 0);
    let floor = Geom::new("floor", Geometry::Plane).with_friction(0.7);
    model.geoms.push(floor);
    let mut state = State::new(&model);
    let mut control = Vec::new();
    // Some files bring motors, which do not hold.
    model.actuators.clear();
    for (j, joint) in model.joints.iter().enumerate().filter(|(_, joint)| joint.kind != JointKind::Free) {
        let part = ["hip", "thigh", "calf"].iter().position(|part| joint.name.contains(part)).unwrap();
        state.q[joint.q_index] = LEG[part];
        control.push(LEG[part]);
        model.actuators.push(Actuator::new(joint.name.clone(), Transmission::Joint(JointId(j as u32)), SERVO));
    }
    // Two links of 0.2 m and 0.213 m at most, and a foot.
    state.q[2] = 0.35;
    Some((model, state, control))
}

/// What a joint holds, as a servo's law gives it: `kp (control − q) − kv v`.
fn servo_torques(simulation: &Simulation) -> Vec<f64> {
    let (model, state) = (simulation.model(), simulation.state());
    let mut tau = vec![0.0; model.nv];
    for (actuator, control) in model.actuators.iter().zip(&simulation.input.control) {
        let (Transmission::Joint(joint), ActuatorKind::Position { kp, kv }) = (actuator.transmission, actuator.kind)
        else {
            panic!("{actuator:?}");
        };
        let joint = &model.joints[joint.index()];
        tau[joint.v_index] += kp * (control - state.q[joint.q_index]) - kv * state.v[joint.v_index];
    }
    tau
}

/// The generalized force that is missing for rest: inverse dynamics at zero velocity and acceleration less the forces of the
/// contacts of a workspace, brought to the joints by the columns of point Jacobians, and the dry friction in joints.
fn statics(simulation: &Simulation, workspace: &Workspace) -> Vec<f64> {
    let model = simulation.model();
    let mut at = kinematics(simulation);
    forward_kinematics_into(model, &simulation.state().q, &vec![0.0; model.nv], &mut at);
    let mut tau = vec![0.0; model.nv];
    inverse_dynamics_into(model, &at, &vec![0.0; model.nv], &mut NewtonEuler::new(model), &mut tau);
    let points = workspace.contact_points().iter().zip(workspace.contact_frames());
    for (i, (point, frame)) in points.enumerate() {
        let [n, t_1, t_2] = workspace.contact_impulse(i);
        let force = (frame.normal * n + frame.tangent_1 * t_1 + frame.tangent_2 * t_2) / simulation.timestep();
        for (body, sign) in [(point.body_a, -1.0), (point.body_b, 1.0)] {
            for k in model.dofs_moving(body) {
                tau[k] -= sign * force.dot(point_column(model, &at, k, point.position));
            }
        }
    }
    for (j, impulse) in workspace.solution().group_impulse.iter().enumerate() {
        let Some(FrictionSource::Joint { dof, .. }) = workspace.friction_source(j) else { panic!("group {j}") };
        tau[dof] -= impulse[0] / simulation.timestep();
    }
    tau
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

/// Vertical force on the floor and the number of feet that carry some of it.
fn weight_on_feet(simulation: &Simulation, workspace: &Workspace) -> (f64, usize) {
    let forces = (0..workspace.contact_points().len()).map(|i| {
        workspace.contact_impulse(i)[0] * workspace.contact_frames()[i].normal.z.abs() / simulation.timestep()
    });
    let forces: Vec<f64> = forces.collect();
    (forces.iter().sum(), forces.iter().filter(|f| **f > 1.0).count())
}

/// After settling no coordinate moves by a nanometre (nanoradian) in a second, the servos
/// carry what inverse dynamics asks for with the contact forces of the step, and so do the torques of the inverse step.
fn stands(name: &str, mut simulation: Simulation) {
    run_certified(&mut simulation, SETTLING);
    let before = simulation.state().q.clone();
    run_certified(&mut simulation, 1.0);
    let creep = largest_difference(&before, &simulation.state().q);
    let model = simulation.model();
    let weight = total_mass(model) * G;
    let (carried, feet) = weight_on_feet(&simulation, simulation.workspace());
    let held = servo_torques(&simulation);
    let error = largest_difference(&held, &statics(&simulation, simulation.workspace()));
    println!(
        "{name}, Δt = {} s: creeps {creep:.1e} in 1 s, torques off {error:.1e} N·m of {:.1}",
        simulation.timestep(),
        held.iter().fold(0.0_f64, |m, t| m.max(t.abs()))
    );
    assert!(creep < 1e-9, "{name}: creeps by {creep:e} in a second");
    assert_eq!(feet, 4, "{name}: all feet carry");
    assert!((carried / weight - 1.0).abs() < 1e-9, "{name}: the floor carries {carried} of {weight} N");
    assert!(error < 1e-8, "{name}: torques are off by {error} N·m");

    // The same without servos: what holds the joints still?
    let driven: Vec<_> = (6..model.nv).map(|dof| DrivenVelocity { dof, velocity: 0.0 }).collect();
    let mut bare = model.clone();
    bare.actuators.clear();
    let mut state = simulation.state().clone();
    state.v.fill(0.0);
    let settings = simulation.settings().clone();
    let (mut workspace, mut motion) = (Workspace::new(&bare, &settings).unwrap(), InverseMotion::new(&bare));
    let report =
        inverse_step(&bare, &state, &Input::default(), &settings, &driven, &mut workspace, &mut motion).unwrap();
    assert!(report.advanced() && report.certificate.holds(1e-9), "{name}: {report:?}");
    let error = largest_difference(&motion.generalized_force, &statics(&simulation, &workspace));
    let (carried, _) = weight_on_feet(&simulation, &workspace);
    println!(
        "    inverse step: torques off {error:.1e} N·m, moves {:.1e}",
        largest_difference(&motion.next.v, &state.v)
    );
    assert!(largest_difference(&motion.next.v, &state.v) < 1e-9, "{name}: {:?}", motion.next.v);
    assert!((carried / weight - 1.0).abs() < 1e-7, "{name}: the inverse step's floor carries {carried} of {weight} N");
    assert!(error < 1e-8, "{name}: the inverse step's torques are off by {error} N·m");
}

fn with_timestep(model: &Model, dt: f64) -> Simulation {
    Simulation::new(model.clone(), Settings::default().with_timestep(dt)).unwrap()
}

#[test]
fn the_bundled_quadruped_stands_without_creeping() {
    let scene = bundled("quadruped");
    for dt in [2e-3, 5e-3] {
        let mut simulation = with_timestep(scene.model(), dt);
        let keyframe = scene.model().keyframes[0].name.clone();
        simulation.reset_to(&keyframe).unwrap();
        stands("quadruped", simulation);
    }
}

/// Unitree's A1 and Go1, whose files are fetched.
#[test]
fn published_quadrupeds_stand_without_creeping() {
    for (name, path) in [("a1", "a1_description/urdf/a1.urdf"), ("go1", "go1_description/urdf/go1.urdf")] {
        let Some((model, state, control)) = published(path) else { continue };
        for dt in [2e-3, 5e-3] {
            let mut simulation = with_timestep(&model, dt);
            simulation.set_state(&state).unwrap();
            simulation.input.control = control.clone();
            stands(name, simulation);
        }
    }
}
