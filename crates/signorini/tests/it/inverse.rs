//! Inverse dynamics with contact, against the step and against balances.

use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{
    ArticulatedBodies, BodyId, Inertia, Input, Joint, JointKind, Kinematics, ModelBuilder, NewtonEuler, Pose, State,
    bias_force_into, forward_dynamics_into, forward_kinematics_into,
};
use signorini::{DrivenVelocity, InverseMotion, Settings, Simulation, SimulationError, Workspace, inverse_step, step};

use crate::support::{G, Random, bundled, run_certified};

/// Runs the inverse and then a step with its answer.
struct RoundTrip {
    state: State,
    tau: Vec<f64>,
    wanted: State,
    reached: State,
}

fn round_trip(simulation: &Simulation, driven: &[DrivenVelocity]) -> RoundTrip {
    let (model, settings, state) = (simulation.model(), Settings::default(), simulation.state().clone());
    let mut workspace = Workspace::new(model, &settings).unwrap();
    let (mut motion, mut reached) = (InverseMotion::new(model), state.clone());
    let input = &simulation.input;
    let report = inverse_step(model, &state, input, &settings, driven, &mut workspace, &mut motion).unwrap();
    assert!(report.advanced() && report.certificate.holds(1e-9), "{report:?}");
    let InverseMotion { next: wanted, generalized_force: tau, .. } = motion;
    let mut forced = input.clone();
    forced.generalized_force = tau.clone();
    workspace.clear_warm_start();
    let report = step(model, &state, &forced, &settings, &mut workspace, &mut reached).unwrap();
    assert!(report.advanced() && report.certificate.holds(1e-9), "{report:?}");
    RoundTrip { state, tau, wanted, reached }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

/// Joints of the quadruped that stands on the floor are driven with random velocities; the torso and the feet follow.
#[test]
fn a_step_with_the_torques_of_the_inverse_is_the_prescribed_motion() {
    let mut simulation = bundled("quadruped");
    run_certified(&mut simulation, 0.5);
    let mut random = Random(5);
    for _ in 0..20 {
        let driven: Vec<_> =
            (6..simulation.model().nv).map(|dof| DrivenVelocity { dof, velocity: random.between(-0.5, 0.5) }).collect();
        let RoundTrip { tau, wanted, reached, .. } = round_trip(&simulation, &driven);
        assert!(tau[..6].iter().all(|t| *t == 0.0), "the torso is not driven");
        for drive in &driven {
            assert!((wanted.v[drive.dof] - drive.velocity).abs() < 1e-9, "{drive:?} {}", wanted.v[drive.dof]);
        }
        let error = largest_difference(&wanted.v, &reached.v);
        assert!(error < 1e-7, "{error:e}");
        assert!(largest_difference(&wanted.q, &reached.q) < 1e-9);
    }
}

/// With every degree of freedom driven to where a step went, and the contacts of that step, no force is missing that the
/// step did not have: both motions and both sums of generalized impulses agree.
#[test]
fn all_degrees_of_freedom_can_be_driven() {
    let mut simulation = bundled("quadruped");
    run_certified(&mut simulation, 0.5);
    let before = simulation.state().clone();
    simulation.step().unwrap();
    let after = simulation.state().clone();
    simulation.set_state(&before).unwrap();
    let driven: Vec<_> = after.v.iter().enumerate().map(|(dof, &velocity)| DrivenVelocity { dof, velocity }).collect();
    let RoundTrip { wanted, reached, .. } = round_trip(&simulation, &driven);
    assert!(largest_difference(&wanted.v, &after.v) < 1e-9);
    assert!(largest_difference(&reached.v, &after.v) < 1e-7);
}

/// An arm without contact: the torque is that of the free motion's equation, `M v̇ + h` at the prescribed acceleration, with the product of the
/// velocities at both ends in `h` in place of the square of the first.
#[test]
fn without_contact_it_is_inverse_dynamics() {
    let mut builder = ModelBuilder::new("arm");
    let mut parent = BodyId::WORLD;
    for (i, axis) in [DVec3::Z, DVec3::Y, DVec3::X].into_iter().enumerate() {
        let inertia = Inertia {
            mass: 1.0 + i as f64,
            center_of_mass: DVec3::new(0.1, 0.02, 0.2),
            rotational: DMat3::from_diagonal(DVec3::new(0.02, 0.03, 0.04)),
        };
        parent = builder.add_body(format!("b{i}"), parent, Pose::from_position(DVec3::Z * 0.4), inertia).unwrap();
        builder.add_joint(parent, Joint::new(format!("j{i}"), JointKind::Hinge { axis })).unwrap();
    }
    let model = builder.build().unwrap();
    let (dt, v) = (model.timestep, [0.4, -1.2, 2.0]);
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.set_state(&State::at(vec![0.3, -0.7, 1.1], v.to_vec())).unwrap();
    let acceleration = [3.0, -5.0, 7.0];
    let driven = [0, 1, 2].map(|dof| DrivenVelocity { dof, velocity: v[dof] + dt * acceleration[dof] });
    let RoundTrip { state, tau, .. } = round_trip(&simulation, &driven);
    let model = simulation.model();
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let bias_at = |sign: f64| {
        let (mut at, mut bias) = (Kinematics::new(model), vec![0.0; 3]);
        let v: Vec<f64> = (0..3).map(|k| v[k] + sign * dt * acceleration[k]).collect();
        forward_kinematics_into(model, &state.q, &v, &mut at);
        bias_force_into(model, &at, &mut NewtonEuler::new(model), &mut bias);
        bias
    };
    let (ahead, behind) = (bias_at(1.0), bias_at(-1.0));
    let tau: Vec<f64> = (0..3).map(|k| tau[k] - 0.25 * (ahead[k] - behind[k])).collect();
    let mut back = vec![0.0; 3];
    forward_dynamics_into(model, &kinematics, &tau, &mut ArticulatedBodies::new(model), &mut back).unwrap();
    assert!(largest_difference(&back, &acceleration) < 1e-9, "{back:?}");
}

/// A joint outside its range that is driven the wrong way keeps what it lacks, and so does the one beside it that it carries.
#[test]
fn what_is_driven_out_of_its_range_moves_as_prescribed() {
    let text = "<mujoco><option timestep='0.002'/><compiler angle='radian'/>
        <default><geom type='capsule' size='.05' contype='0' conaffinity='0'/></default><worldbody>
        <body><joint axis='0 0 1' range='0.2 1'/><geom fromto='0 0 0 .5 0 0'/>
        <body pos='.5 0 0'><joint axis='0 0 1' range='0.3 1'/><geom fromto='0 0 0 .5 0 0'/></body></body></worldbody></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let (settings, state) = (Settings::default(), State::new(&model));
    let mut workspace = Workspace::new(&model, &settings).unwrap();
    let mut motion = InverseMotion::new(&model);
    let driven = [DrivenVelocity { dof: 0, velocity: 0.0 }];
    let report =
        inverse_step(&model, &state, &Input::default(), &settings, &driven, &mut workspace, &mut motion).unwrap();
    assert!(report.certificate.holds(1e-9) && report.theta == 0.0 && !report.kept.is_empty(), "{report:?}");
    assert!(motion.next.v[0].abs() < 1e-12, "{:?}", motion.next.v);
}

/// Held at rest in every joint, a quadruped's feet carry its weight, and the torso stays.
#[test]
fn a_standing_robot_is_carried_by_its_feet() {
    let mut simulation = bundled("quadruped");
    run_certified(&mut simulation, 1.0);
    let (model, settings) = (simulation.model(), Settings::default());
    let driven: Vec<_> = (6..model.nv).map(|dof| DrivenVelocity { dof, velocity: 0.0 }).collect();
    let mut workspace = Workspace::new(model, &settings).unwrap();
    let mut state = simulation.state().clone();
    state.v.fill(0.0);
    let mut motion = InverseMotion::new(model);
    inverse_step(model, &state, &Input::default(), &settings, &driven, &mut workspace, &mut motion).unwrap();
    let weight = G * model.bodies.iter().map(|b| b.inertia.mass).sum::<f64>();
    let up: f64 = workspace.solution().lambda_n.iter().take(workspace.contact_points().len()).sum();
    assert!((up / model.timestep / weight - 1.0).abs() < 1e-2, "{up} {weight}");
    assert!(motion.next.v[..6].iter().all(|v| v.abs() < 1e-2), "{:?}", &motion.next.v[..6]);
}

#[test]
fn wrong_prescriptions_are_errors_that_name_the_entry() {
    let simulation = bundled("quadruped");
    let (model, settings) = (simulation.model(), Settings::default());
    let mut workspace = Workspace::new(model, &settings).unwrap();
    let mut error = |driven: &[DrivenVelocity]| {
        let state = simulation.state();
        let mut motion = InverseMotion::new(model);
        match inverse_step(model, state, &Input::default(), &settings, driven, &mut workspace, &mut motion) {
            Err(SimulationError::Prescription { index, expected, .. }) => (index, expected),
            other => panic!("{other:?}"),
        }
    };
    let drive = |dof, velocity| DrivenVelocity { dof, velocity };
    assert_eq!(error(&[drive(3, 0.0), drive(99, 0.0)]), (1, "the model has no such degree of freedom"));
    assert_eq!(error(&[drive(3, f64::NAN)]), (0, "it must be finite"));
    assert_eq!(error(&[drive(3, 0.0), drive(4, 0.0), drive(3, 1.0)]), (2, "it is prescribed twice"));
}
