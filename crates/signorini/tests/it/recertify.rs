//! Recorded steps certified again: with the residuals of the run, whatever acts in it, and never after somebody changed them.

use std::sync::Arc;

use signorini::lcp::MethodKind;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{Input, Model};
use signorini::recording::{Frame, Header};
use signorini::{
    ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, Recertifier, RestitutionLaw, Settings, Simulation,
    SimulationError, StepCheck, StepFault, StepReport, frame_into, recording_header, step_solution_into,
};

use crate::support::bundled;

/// A loop, a limit, a tendon's limit, dry friction, a servo of speed, a winch whose force grows, a rolling ball, a belt, a crate that a ball strikes.
const EVERYTHING: &str = r#"<mujoco model="everything">
  <compiler angle="radian"/>
  <option timestep="0.002"/>
  <default><geom friction="0.5"/></default>
  <worldbody>
    <geom name="floor" type="plane"/>
    <geom name="belt" type="box" size="1 0.3 0.05" pos="0 3 0.05"/>
    <body name="crate" pos="0 3 0.2"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <body name="ball" pos="-0.3 3 0.25"><freejoint/><geom size="0.05" mass="0.2"/></body>
    <body name="marble" pos="0 -3 0.06"><freejoint/><geom size="0.05" mass="0.2" condim="6" friction="0.5 0.01 0.002"/></body>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" range="-0.4 0.1" frictionloss="0.05"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="0.4"/>
      <body name="hand" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 -0.3" size="0.02" mass="0.4"/>
      </body>
    </body>
    <body name="slider" pos="0.7 0 0.7"><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.04" mass="0.3" contype="0" conaffinity="0"/></body>
    <body name="weight" pos="1.5 0 1"><joint name="lift" type="slide" axis="0 0 1"/><geom size="0.04" mass="0.3"/></body>
  </worldbody>
  <tendon><fixed name="rope" limited="true" range="-0.02 0.02"><joint joint="lift" coef="1"/></fixed></tendon>
  <equality><connect body1="hand" body2="slider" anchor="0.3 0 -0.3"/></equality>
  <actuator><velocity name="drive" joint="rail" kv="20" ctrlrange="-1 1"/>
    <general name="winch" joint="lift" dyntype="integrator"/></actuator>
</mujoco>"#;

fn everything(settings: Settings) -> Simulation {
    let mut model = signorini_formats::load_mjcf_str(EVERYTHING, "").unwrap().model;
    for (name, surface_velocity, restitution) in [("belt", DVec3::new(0.5, 0.0, 0.0), 0.0), ("ball", DVec3::ZERO, 0.6)]
    {
        let body = model.body_named(name);
        let is_it = |geom: &&mut signorini::multibody::Geom| geom.name == name || Some(geom.body) == body;
        let geom = model.geoms.iter_mut().find(is_it).unwrap();
        (geom.surface_velocity, geom.restitution) = (surface_velocity, restitution);
    }
    let mut simulation = Simulation::new(model, settings).unwrap();
    let mut state = simulation.state().clone();
    let ball = simulation.model().joints.iter().find(|j| simulation.model().bodies[j.body.index()].name == "ball");
    state.v[ball.unwrap().v_index] = 2.0;
    simulation.set_state(&state).unwrap();
    simulation.input =
        Input::default().with_control(vec![0.3, 1.5]).with_generalized_force(vec![0.01; simulation.model().nv]);
    simulation
}

/// The next step as a frame.
fn recorded_step(simulation: &mut Simulation, index: u64) -> (Frame, StepReport) {
    let (before, mut frame) = (simulation.state().clone(), Frame::default());
    let report = simulation.step().unwrap().clone();
    frame_into(simulation.model(), index, &before, simulation.workspace(), &report, &mut frame);
    step_solution_into(&simulation.input, simulation.workspace(), &report, &mut frame);
    (frame, report)
}

fn header(simulation: &Simulation) -> Header {
    recording_header(simulation.model(), simulation.settings(), simulation.workspace())
}

fn recertifier(simulation: &Simulation) -> Recertifier {
    Recertifier::new(simulation.model().clone(), &header(simulation)).unwrap()
}

/// Every step of a run shows the residuals that it had, and leads to the next.
pub fn shows_the_same(mut simulation: Simulation, steps: u64, what: &str) {
    let mut recertifier = recertifier(&simulation);
    for i in 0..steps {
        let (frame, report) = recorded_step(&mut simulation, i);
        if i > 0 {
            assert!(recertifier.leads_to(&frame), "{what}: step {i} does not follow from the one before");
        }
        let check = recertifier.check(&frame).unwrap_or_else(|fault| panic!("{what}: step {i}: {fault}"));
        assert_eq!(check.fault, None, "{what}: step {i}");
        assert_eq!((check.law, check.cone_certificate.is_some()), (report.law, report.cone_certificate.is_some()));
        let pairs = [
            (check.certificate.worst(), report.certificate.worst()),
            (check.cone_certificate.map_or(0.0, |c| c.worst()), report.cone_certificate.map_or(0.0, |c| c.worst())),
        ];
        for (again, then) in pairs {
            assert!(
                (again - then).abs() <= 1e-12 + 1e-6 * then,
                "{what}: step {i}: {again:e} now, {then:e} in the run"
            );
        }
    }
}

#[test]
fn scenes_are_certified_again() {
    for (name, steps) in [("arch", 60), ("dominoes", 150), ("gripper", 300), ("quadruped", 300), ("spinning_top", 100)]
    {
        shows_the_same(bundled(name), steps, name);
    }
}

#[test]
fn all_that_acts_in_a_step_is_certified_again() {
    let poisson = Settings::default().with_restitution(RestitutionLaw::Poisson);
    let projected = Settings::default().with_position_iterations(3).with_stabilization(0.5).with_direction_angle(0.2);
    let lemke = Settings::default().with_method(ContactMethod::Lcp("lemke".parse::<MethodKind>().unwrap()));
    let sleeping = Settings::default().with_sleeping(true);
    for (what, settings) in [
        ("defaults", Settings::default()),
        ("Poisson", poisson),
        ("projected", projected),
        ("Lemke", lemke),
        ("asleep", sleeping),
    ] {
        let mut seen = everything(settings.clone());
        let (mut limits, mut phases) = (0, 0);
        for i in 0..250 {
            let (frame, _) = recorded_step(&mut seen, i);
            limits = frame.solution.limits.len().max(limits);
            phases = frame.solution.phases.max(phases);
        }
        assert!(limits >= 1, "{what}: a limit is met");
        assert_eq!(phases, if what == "Poisson" { 2 } else { 1 });
        shows_the_same(everything(settings), 250, what);
    }
}

#[test]
fn other_laws_of_friction_are_certified_again() {
    let law = |friction_law| Settings::default().with_friction_law(friction_law);
    let least_norm = Settings::default().with_impulses(ImpulseChoice::LeastNorm);
    for (what, settings) in [
        ("circular", law(FrictionLaw::Circular)),
        ("refined", law(FrictionLaw::Refined { tolerance: 1e-6 })),
        ("least norm", least_norm),
    ] {
        let scene = bundled("dominoes");
        let mut simulation = Simulation::new(scene.model().clone(), settings).unwrap();
        simulation.set_state(scene.state()).unwrap();
        shows_the_same(simulation, 60, what);
    }
}

/// A marble that spins and rolls, dry friction in a joint and a belt: groups of which some have circular laws and turned directions.
#[test]
fn groups_under_other_laws_of_friction_are_certified_again() {
    for law in [FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-6 }] {
        let simulation = || {
            let mut simulation = everything(Settings::default().with_friction_law(law));
            let mut state = simulation.state().clone();
            let model = simulation.model();
            let marble = model.body_named("marble").unwrap();
            let marble = model.joints.iter().find(|joint| joint.body == marble).unwrap().v_index;
            state.v[marble..marble + 6].copy_from_slice(&[0.4, 0.3, 0.0, 1.0, -2.0, 3.0]);
            simulation.set_state(&state).unwrap();
            simulation
        };
        let mut seen = simulation();
        let turned = (0..100).any(|i| {
            let solution = recorded_step(&mut seen, i).0.solution;
            let groups = &solution.group_direction_counts;
            groups.iter().any(|count| *count > 2)
        });
        assert!(turned, "{law:?}: a group of two dimensions is recorded");
        shows_the_same(simulation(), 150, &format!("{law:?}"));
    }
}

/// A ball that another one strikes moves farther than its own velocity says: contacts were looked for with more reach.
#[test]
fn enlarged_reaches_are_recorded() {
    let mut world = crate::support::World::new(1e-2, DVec3::ZERO, 0.0);
    world.free_ball(0.1, 10.0, DVec3::ZERO);
    world.free_ball(0.1, 0.1, DVec3::X * 0.21);
    world.free_ball(0.1, 0.1, DVec3::X * 0.42);
    let mut simulation = world.simulation(Settings::default());
    crate::support::set_velocity(&mut simulation, 0, DVec3::X * 3.0, DVec3::ZERO);
    let mut recertifier = recertifier(&simulation);
    let (frame, report) = recorded_step(&mut simulation, 0);
    assert!(report.enlargements > 0 && frame.solution.reach.len() == 4);
    assert!(recertifier.check(&frame).unwrap().holds(1e-9, 0.0));
    let mut without = frame.clone();
    without.solution.reach.clear();
    assert!(recertifier.check(&without).is_err());
}

#[test]
fn clipped_gaps_are_certified_again() {
    let text = r#"<mujoco><worldbody>
        <geom type="box" size="0.1 1 1" pos="-0.19 0 0"/><geom type="box" size="0.1 1 1" pos="0.19 0 0"/>
        <body><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body></worldbody></mujoco>"#;
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::ClipGaps);
    let mut simulation = Simulation::new(model.clone(), settings).unwrap();
    let (frame, report) = recorded_step(&mut simulation, 0);
    assert!(report.clipped_gaps && frame.solution.clipped_gaps);
    assert!(recertifier(&simulation).check(&frame).unwrap().holds(1e-9, 0.0));
    // Stopped instead, the step has nothing that could be certified.
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
    let mut simulation = Simulation::new(model, settings).unwrap();
    let (frame, report) = recorded_step(&mut simulation, 0);
    assert!(!report.advanced());
    assert_eq!(recertifier(&simulation).check(&frame), Err(StepFault::NoSolution));
}

/// A block between walls that leave it no room: the recording tells the part θ, and without it or with another one the step does not
/// hold.
#[test]
fn limited_corrections_are_certified_again() {
    let text = r#"<mujoco><worldbody>
        <geom type="box" size="0.1 1 1" pos="-0.19 0 0"/><geom type="box" size="0.1 1 1" pos="0.19 0 0"/>
        <body><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body></worldbody></mujoco>"#;
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let (frame, report) = recorded_step(&mut simulation, 0);
    assert!(report.advanced() && report.theta == 0.0 && frame.solution.theta == Some(0.0), "{report:?}");
    let mut recertifier = recertifier(&simulation);
    assert!(recertifier.check(&frame).unwrap().holds(1e-9, 0.0));
    for (theta, holds) in [(None, false), (Some(0.5), false), (Some(0.0), true)] {
        let mut other = frame.clone();
        other.solution.theta = theta;
        assert_eq!(recertifier.check(&other).unwrap().holds(1e-9, 0.0), holds, "{theta:?}");
    }
    let mut beyond = frame.clone();
    beyond.solution.theta = Some(-1.0);
    assert_eq!(recertifier.check(&beyond), Err(StepFault::Theta { theta: -1.0 }));
}

/// A step of the run with everything, late enough that all of it acts.
fn one_step() -> (Recertifier, Frame) {
    let mut simulation = everything(Settings::default());
    let frames: Vec<Frame> = (0..120).map(|i| recorded_step(&mut simulation, i).0).collect();
    let touching = |frame: &&Frame| {
        let solution = &frame.solution;
        let slides = frame.contacts.iter().any(|c| c.lambda_n > 0.0 && c.lambda_t[0].abs() > 0.0);
        slides && solution.limits.iter().any(|l| l.impulse > 0.0) && !solution.impulses[0].bilateral.is_empty()
    };
    (recertifier(&simulation), frames.iter().rev().find(touching).unwrap().clone())
}

/// Whatever number of a frame is changed by a thousandth of its size, or by 1e-6, is found.
#[test]
fn every_change_is_found() {
    let (mut recertifier, frame) = one_step();
    assert!(recertifier.check(&frame).unwrap().holds(1e-9, 0.0));
    let change = |x: &mut f64| *x += 1e-6 + 1e-3 * x.abs();
    let pushed = |frame: &Frame| frame.contacts.iter().position(|c| c.lambda_n > 0.0).unwrap();
    let i = pushed(&frame);
    type Change = (&'static str, Box<dyn Fn(&mut Frame)>);
    let on = move |what, f: fn(&mut Frame, usize) -> &mut f64| -> Change {
        (what, Box::new(move |frame| change(f(frame, i))))
    };
    let changes = [
        on("q of the arm", |frame, _| frame.q.last_mut().unwrap()),
        on("v", |frame, _| frame.v.last_mut().unwrap()),
        on("activation", |frame, _| &mut frame.activation[0]),
        on("control", |frame, _| &mut frame.solution.control[0]),
        on("force", |frame, _| &mut frame.solution.generalized_force[0]),
        on("v⁺", |frame, _| &mut frame.solution.impulses[0].velocity[0]),
        on("λ_N of the solution", |frame, i| &mut frame.solution.impulses[0].lambda_n[i]),
        on("α", |frame, _| frame.solution.impulses[0].alpha.iter_mut().max_by(|a, b| a.total_cmp(b)).unwrap()),
        on("β", |frame, _| frame.solution.impulses[0].beta.iter_mut().max_by(|a, b| a.total_cmp(b)).unwrap()),
        on("λ_B", |frame, _| &mut frame.solution.impulses[0].bilateral[0]),
        on("α_F", |frame, _| frame.solution.impulses[0].group_alpha.iter_mut().max_by(|a, b| a.total_cmp(b)).unwrap()),
        on("λ_N of the contact", |frame, i| &mut frame.contacts[i].lambda_n),
        on("λ_T of the contact", |frame, i| &mut frame.contacts[i].lambda_t[1]),
        on("gap", |frame, i| &mut frame.contacts[i].gap),
        on("point", |frame, i| &mut frame.contacts[i].point[2]),
        on("normal", |frame, i| &mut frame.contacts[i].normal[0]),
        on("tangent", |frame, i| &mut frame.contacts[i].tangent_2[0]),
        on("friction", |frame, i| &mut frame.contacts[i].friction),
        on("slip", |frame, i| &mut frame.contacts[i].velocity_t[0]),
        on("limit's gap", |frame, _| &mut frame.solution.limits[0].gap),
        on("limit's impulse", |frame, _| &mut frame.solution.limits[0].impulse),
        on("pose", |frame, _| &mut frame.body_poses[2][1]),
        on("energy", |frame, _| &mut frame.energy.potential),
    ];
    for (what, change) in changes {
        let mut changed = frame.clone();
        change(&mut changed);
        let held = recertifier.check(&changed).is_ok_and(|check| check.holds(1e-9, 0.0));
        assert!(!held, "{what} was changed and the step still holds");
    }
}

#[test]
fn what_does_not_fit_is_a_fault_and_no_panic() {
    let (mut recertifier, frame) = one_step();
    let fault = |recertifier: &mut Recertifier, change: &dyn Fn(&mut Frame)| {
        let mut changed = frame.clone();
        change(&mut changed);
        match recertifier.check(&changed) {
            Err(fault) => fault,
            Ok(StepCheck { fault: Some(fault), .. }) => fault,
            Ok(check) => panic!("{check:?}"),
        }
    };
    let r = &mut recertifier;
    assert!(matches!(fault(r, &|f| f.contacts.truncate(1)), StepFault::Length { array: "λ_N", .. }));
    assert!(matches!(fault(r, &|f| f.q[0] = f64::NAN), StepFault::Unusable(_)));
    assert!(matches!(fault(r, &|f| f.q.truncate(3)), StepFault::Unusable(_)));
    assert!(matches!(fault(r, &|f| f.solution.phases = 2), StepFault::Phases { recorded: 2 }));
    assert!(matches!(
        fault(r, &|f| f.solution.impulses[0].velocity.truncate(2)),
        StepFault::Length { array: "v⁺", .. }
    ));
    assert!(matches!(fault(r, &|f| f.solution.impulses[0].alpha.truncate(2)), StepFault::Length { array: "α", .. }));
    assert!(matches!(fault(r, &|f| f.contacts[0].geom_b = 99), StepFault::Contacts { found: 0, .. }));
    assert!(matches!(
        fault(r, &|f| f.solution.limits[0].index = 99),
        StepFault::Contact { .. } | StepFault::Length { .. }
    ));
    assert!(matches!(fault(r, &|f| f.energy.kinetic = f64::NAN), StepFault::Energy { .. }));
    let mut other = frame.clone();
    other.solution.clear();
    assert_eq!(r.check(&other), Err(StepFault::NoSolution));
}

/// Contacts that bear nothing may be left out of a problem, and no others: a fall through the floor is no step without contacts.
#[test]
fn a_contact_that_would_close_cannot_be_left_out() {
    let fall = |gravity: f64| {
        let text = format!(
            "<mujoco><option gravity='0 0 {gravity}'/><worldbody><geom type='plane'/><body pos='0 0 0.1'><freejoint/><geom size='0.1'/>\
             </body></worldbody></mujoco>"
        );
        Simulation::new(signorini_formats::load_mjcf_str(&text, "").unwrap().model, Settings::default()).unwrap()
    };
    let mut resting = fall(-9.81);
    let mut recertifier = recertifier(&resting);
    let (mut frame, _) = recorded_step(&mut resting, 0);
    assert_eq!(frame.contacts.len(), 1);
    frame.contacts.clear();
    let impulses = &mut frame.solution.impulses[0];
    impulses.velocity = vec![0.0, 0.0, -9.81 * resting.timestep(), 0.0, 0.0, 0.0];
    for array in [&mut impulses.lambda_n, &mut impulses.alpha, &mut impulses.beta] {
        array.clear();
    }
    assert_eq!(recertifier.check(&frame), Err(StepFault::CrossedContact));
}

#[test]
fn another_model_is_refused() {
    let simulation = bundled("arch");
    let mut model: Model = simulation.model().clone();
    model.geoms[0].friction += 0.1;
    let refused = Recertifier::new(Arc::new(model), &header(&simulation)).err().unwrap();
    assert!(matches!(refused, SimulationError::Recording { reason } if reason.contains("hashes")));
    let old = Header { laws: None, ..header(&simulation) };
    let refused = Recertifier::new(simulation.model().clone(), &old).err().unwrap();
    assert!(matches!(refused, SimulationError::Recording { reason } if reason.contains("version 1")));
    assert_eq!(recertifier(&simulation).settings().friction_law, FrictionLaw::Polygon);
}
