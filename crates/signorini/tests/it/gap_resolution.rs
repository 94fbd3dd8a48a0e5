//! Gaps below a resolution: what lies within it rests there, and the laws hold for the gaps that count.

use signorini::derivatives::{StepDerivatives, Validity};
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Geometry, Pose};
use signorini::{Settings, Simulation};
use signorini_testkit::Random;

use crate::support::{World, position};

/// Above the micrometres that sweeps leave of the gaps of a heap, and a ten-thousandth of its boxes.
const RESOLUTION: f64 = 1e-5;

fn settings() -> Settings {
    Settings::default().with_gap_resolution(RESOLUTION)
}

/// A ball of 0.1 m above the floor, or in it.
fn ball(gap: f64, settings: Settings) -> Simulation {
    let mut world = World::upright(0.004, 0.5);
    world.floor();
    world.free_ball(0.1, 1.0, DVec3::new(0.0, 0.0, 0.1 + gap));
    world.simulation(settings)
}

/// Where the ball comes to rest.
fn rest(gap: f64, settings: Settings) -> f64 {
    let mut simulation = ball(gap, settings);
    for _ in 0..40 {
        let report = simulation.step().unwrap();
        assert!(report.certificate.holds(1e-9) && report.theta == 1.0);
    }
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-12));
    position(&simulation, 0).z - 0.1
}

/// Within the resolution nothing moves; what is above comes down to the surface, and what is deeper comes out to the resolution.
#[test]
fn what_lies_within_it_rests_there() {
    for (gap, wanted) in [(3e-6, 3e-6), (-3e-6, -3e-6), (1e-4, 0.0), (-1e-4, -RESOLUTION)] {
        assert!((rest(gap, settings()) - wanted).abs() < 1e-12, "{gap:e}: {:e}", rest(gap, settings()));
        assert!(rest(gap, Settings::default()).abs() < 1e-12);
    }
    assert!(Settings::default().with_gap_resolution(-1.0).validate().is_err());
    assert!(Settings::default().with_gap_resolution(f64::INFINITY).validate().is_err());
}

/// Derivatives by the configuration are those of the gaps that count: within the resolution a change of height stays, beyond it the step takes it back.
#[test]
fn derivatives_are_those_of_gaps_that_count() {
    for (gap, kept) in [(3e-6, 1.0), (-3e-6, 1.0), (-1e-4, 0.0)] {
        let height = |shift: f64| {
            let mut simulation = ball(gap + shift, settings());
            simulation.step().unwrap();
            position(&simulation, 0).z
        };
        let difference = (height(1e-7) - height(-1e-7)) / 2e-7;
        let mut simulation = ball(gap, settings());
        let mut derivatives = StepDerivatives::new(simulation.model());
        let validity = derivatives.step(&mut simulation).unwrap();
        assert!(matches!(validity, Validity::Exact), "{gap:e}: {validity:?}");
        let found = derivatives.state_matrix().unwrap()[(2, 2)];
        assert!((found - kept).abs() < 1e-9 && (difference - kept).abs() < 1e-6, "{gap:e}: {found} {difference}");
    }
}

/// A heap of boxes that sweeps alone have brought near rest, and that stands still.
fn heap(seed: u64) -> Simulation {
    let mut random = Random::new(seed);
    let mut world = World::upright(0.004, 0.5);
    world.floor();
    for k in 0..150 {
        let at = |random: &mut Random| random.between(-0.05, 0.05);
        let place = DVec3::new(at(&mut random), at(&mut random), 0.06 + 0.03 * f64::from(k));
        let turn = DQuat::from_scaled_axis(DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0))));
        let half_extents = DVec3::from_array(std::array::from_fn(|_| random.between(0.03, 0.06)));
        world.free(Geometry::Box { half_extents }, 0.5, Pose::new(place, turn));
    }
    let mut simulation = world.simulation(Settings::default().with_budget(50));
    for _ in 0..900 {
        simulation.step().unwrap();
    }
    let mut state = simulation.state().clone();
    state.v.fill(0.0);
    simulation.set_state(&state).unwrap();
    simulation
}

/// Sweeps leave a heap with gaps of micrometres. To close them exactly contacts change their modes by the hundred; where they do not count the heap stands, with a
/// fraction of the work.
#[test]
fn a_heap_comes_to_rest() {
    let (mut changes_with, mut changes_without) = (0, 0);
    for seed in 2..8 {
        let near_rest = heap(seed);
        let run = |settings: Settings| {
            let mut simulation = Simulation::new(near_rest.model().clone(), settings.with_tolerance(1e-8)).unwrap();
            simulation.set_state(near_rest.state()).unwrap();
            let mut changes = 0;
            for step in 0..10 {
                let report = simulation.step().unwrap();
                assert!(report.certificate.holds(1e-8), "seed {seed}, step {step}: {:?}", report.certificate);
                changes += report.solver.mode_changes;
            }
            let lowest =
                simulation.workspace().candidate_points().fold(0.0, |lowest, point| f64::min(lowest, point.gap));
            (changes, -lowest)
        };
        let ((with, deepest), (without, _)) = (run(settings()), run(Settings::default()));
        assert!(deepest < 1.01 * RESOLUTION, "seed {seed}: {deepest:e} m");
        assert!(with < without, "seed {seed}: {with} changes of modes with it, {without} without");
        (changes_with, changes_without) = (changes_with + with, changes_without + without);
    }
    assert!(2 * changes_with < changes_without, "{changes_with} changes of modes with it, {changes_without} without");
}

/// A recording says the resolution, and is certified again with it.
#[test]
fn its_steps_are_certified_again() {
    let mut world = World::upright(0.004, 0.5);
    world.floor();
    for k in 0..4 {
        let turn = DQuat::from_rotation_y(0.3 * f64::from(k));
        let place = DVec3::new(0.02 * f64::from(k), 0.0, 0.12 + 0.25 * f64::from(k));
        world.free(Geometry::Box { half_extents: DVec3::splat(0.1) }, 1.0, Pose::new(place, turn));
    }
    crate::recertify::shows_the_same(
        world.simulation(settings().with_gap_resolution(1e-4)),
        200,
        "a resolution of gaps",
    );
}
