//! Contact problems without a solution.

use signorini::contact::SolveStatus;
use signorini::multibody::glam::DVec3;
use signorini::{InfeasiblePolicy, RunEnd, Settings, Simulation};

use crate::support::{World, position};

/// A box of 200 mm between walls that are 180 mm apart.
fn squeezed(infeasible: InfeasiblePolicy) -> Simulation {
    let mut world = World::new(0.005, DVec3::ZERO, 0.5);
    world.plane(DVec3::X * -0.09, DVec3::X);
    world.plane(DVec3::X * 0.09, DVec3::NEG_X);
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::ZERO);
    world.simulation(Settings::default().with_infeasible(infeasible))
}

#[test]
fn stops_before_the_step_and_names_the_contacts() {
    let mut simulation = squeezed(InfeasiblePolicy::Stop);
    let before = simulation.state().clone();
    let end = simulation.run(0.1, |_, _| true).unwrap();
    let RunEnd::NoSolution(report) = end else { panic!("{end:?}") };
    assert!(!report.advanced());
    let (SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts }) = &report.status else {
        panic!("{:?}", report.status)
    };
    let walls = |k: &usize| simulation.workspace().contact_points()[*k].geom_a;
    let mut named: Vec<_> = contacts.iter().map(walls).collect();
    named.sort();
    named.dedup();
    assert_eq!(named.len(), 2, "contacts of both walls: {contacts:?}");
    assert_eq!(*simulation.state(), before);
    assert_eq!(simulation.summary().steps, 0);
}

#[test]
fn goes_on_with_clipped_gaps_and_says_so() {
    let mut simulation = squeezed(InfeasiblePolicy::ClipGaps);
    assert_eq!(simulation.run(0.1, |_, report| report.clipped_gaps).unwrap(), RunEnd::Finished);
    let summary = simulation.summary();
    assert_eq!((summary.steps, summary.clipped_steps, summary.missed_steps), (20, 20, 0));
    assert!(position(&simulation, 0).length() < 1e-12);
}

/// A penetration that nothing contradicts is gone after one step.
#[test]
fn a_single_penetration_is_pushed_out() {
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.09);
    let mut simulation = world.simulation(Settings::default());
    simulation.step().unwrap();
    // 1 cm in 5 ms.
    let (point, speed) = simulation.workspace().sudden_overlap().expect("faster than 1 m/s");
    assert!((point.gap + 0.01).abs() < 1e-12 && (speed - 2.0).abs() < 1e-9 && point.geom_a.index() == 0);
    assert!((position(&simulation, 0).z - 0.1).abs() < 1e-12);
    simulation.step().unwrap();
    assert!(simulation.workspace().sudden_overlap().is_none());
}

/// Two capsules overlap at the centre of the ball joint between them, where no motion can part them: what is left of the contact's
/// row is rounding, which must not become an impulse without bound.
#[test]
fn an_overlap_that_no_motion_opens_is_named_and_harmless() {
    let text = "<mujoco><default><geom type='capsule' size='0.01'/></default><worldbody>
        <geom name='fixed' fromto='0.3 0.2 0.1 0.3 0.2 0.2'/>
        <body pos='0.3 0.2 0.2'><joint type='ball' damping='0.005'/><geom name='moved' fromto='0 0 0 0 0.1 0.1'/></body>
        </worldbody></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let named = [model.geom_named("fixed").unwrap(), model.geom_named("moved").unwrap()];
    let mut stopped = Simulation::new(model.clone(), Settings::default()).unwrap();
    let end = stopped.run(1.0, |_, _| true).unwrap();
    let RunEnd::NoSolution(report) = end else { panic!("{end:?}") };
    let SolveStatus::Infeasible { contacts } = &report.status else { panic!("{:?}", report.status) };
    let points = stopped.workspace().contact_points();
    assert!(!contacts.is_empty() && contacts.iter().all(|k| [points[*k].geom_a, points[*k].geom_b] == named));
    // With a second joint the arms fold onto the fixed capsule, where levers are short and not zero.
    let text = text.replace(
        "</body>",
        "<body pos='0 0.1 0.1'><joint type='ball' damping='0.005'/><geom fromto='0 0 0 0 0.1 0'/></body></body>",
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::ClipGaps);
    let mut clipped = Simulation::new(model, settings).unwrap();
    let end = clipped.run(1.0, |now, _| now.state().v.iter().all(|v| v.abs() < 100.0)).unwrap();
    assert_eq!(end, RunEnd::Finished, "{:?}", clipped.state());
}
