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

/// A penetration that nothing contradicts is removed at the speed of corrections, and by the paper's scheme in one step.
#[test]
fn a_single_penetration_is_pushed_out() {
    let at_once = Settings::default().with_correction_speed(f64::INFINITY);
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.09);
    let mut simulation = world.simulation(at_once);
    simulation.step().unwrap();
    assert!((position(&simulation, 0).z - 0.1).abs() < 1e-12);
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.09);
    let mut simulation = world.simulation(Settings::default());
    simulation.step().unwrap();
    let [point] = simulation.workspace().kept_overlaps()[..] else { panic!("one pair") };
    assert!((point.gap + 0.01).abs() < 1e-12 && point.geom_a.index() == 0);
    // 1 cm at 0.25 m/s takes 8 steps of 5 ms.
    assert!((position(&simulation, 0).z - 0.09125).abs() < 1e-12);
    simulation.run(0.035, |_, _| true).unwrap();
    assert!((position(&simulation, 0).z - 0.1).abs() < 1e-12);
    assert!(simulation.workspace().kept_overlaps().is_empty());
}

/// Two capsules overlap at the centre of the ball joint between them, where no motion can part them: the contact is named and left out.
#[test]
fn an_overlap_that_no_motion_opens_is_named_and_harmless() {
    let text = "<mujoco><default><geom type='capsule' size='0.01'/></default><worldbody>
        <geom name='fixed' fromto='0.3 0.2 0.1 0.3 0.2 0.2'/>
        <body pos='0.3 0.2 0.2'><joint type='ball' damping='0.005'/><geom name='moved' fromto='0 0 0 0 0.1 0.1'/></body>
        </worldbody></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let named = [model.geom_named("fixed").unwrap(), model.geom_named("moved").unwrap()];
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
    let mut simulation = Simulation::new(model, settings.clone()).unwrap();
    simulation.step().unwrap();
    let left_out = simulation.workspace().left_out();
    assert!(!left_out.is_empty() && left_out.iter().all(|point| [point.geom_a, point.geom_b] == named));
    assert_eq!(simulation.report().left_out, left_out.len());
    let note = simulation.workspace().start_note(simulation.model(), &settings).unwrap();
    assert!(note.contains("'fixed' and 'moved'"), "{note}");
    assert_eq!(simulation.run(1.0, |_, _| true).unwrap(), RunEnd::Finished);
    // With a second joint the arms fold onto the fixed capsule, where levers are short and not zero.
    let text = text.replace(
        "</body>",
        "<body pos='0 0.1 0.1'><joint type='ball' damping='0.005'/><geom fromto='0 0 0 0 0.1 0'/></body></body>",
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut folding = Simulation::new(model, Settings::default()).unwrap();
    let end = folding.run(1.0, |now, _| now.state().v.iter().all(|v| v.abs() < 100.0)).unwrap();
    assert_eq!(end, RunEnd::Finished, "{:?}", folding.state());
}

/// Swimmers and pushers move in a plane: what their bodies reach into the floor, by a rounding or by millimetres, no joint can take out, and it
/// stops nobody; a wall in their way is a contact as ever.
#[test]
fn what_moves_in_a_plane_may_reach_into_the_floor() {
    for depth in [1.1e-16, 1e-9, 3e-3] {
        let text = format!(
            "<mujoco><option timestep='0.01'/><worldbody><geom name='floor' type='plane'/>
            <geom name='wall' type='box' size='0.1 1 1' pos='1.1 0 0'/><body name='torso' pos='0 0 {}'>
            <joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint axis='0 0 1'/>
            <geom name='front' type='capsule' fromto='0.5 0 0 0 0 0' size='0.1'/>
            <body><joint axis='0 0 1' range='-100 100'/><geom name='back' type='capsule' fromto='0 0 0 -0.5 0 0' size='0.1'/>
            </body></body></worldbody></mujoco>",
            0.1 - depth
        );
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let mut simulation =
            Simulation::new(model, Settings::default().with_infeasible(InfeasiblePolicy::Stop)).unwrap();
        let mut state = simulation.state().clone();
        state.v[0] = 1.0;
        simulation.set_state(&state).unwrap();
        let end = simulation.run(1.0, |_, report| report.certificate.holds(1e-9)).unwrap();
        assert_eq!(end, RunEnd::Finished, "{depth}: {:?}", simulation.report());
        assert!(simulation.summary().left_out_max > 0, "{depth}");
        // Head-on: it stops where its front meets the wall.
        let state = simulation.state();
        assert!((state.q[0] - 0.4).abs() < 1e-9 && state.v[0].abs() < 1e-9, "{depth}: {:?}", state.q);
    }
}
