//! With sleeping and without: the same motion.

use signorini::multibody::glam::DVec3;
use signorini::{Settings, Simulation};

use crate::support::{World, bits, bundled, run_certified, run_observed, set_velocity};

fn sleeping(scene: &Simulation) -> Simulation {
    let settings = scene.settings().clone().with_sleeping(true);
    let mut simulation = Simulation::new(scene.model().clone(), settings).unwrap();
    simulation.set_state(scene.state()).unwrap();
    simulation.input = scene.input.clone();
    simulation
}

fn difference(a: &Simulation, b: &Simulation) -> f64 {
    let values = |s: &Simulation| s.state().q.iter().chain(&s.state().v).copied().collect::<Vec<_>>();
    values(a).iter().zip(values(b)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Runs both and gives back in how many steps something slept.
fn run_both(awake: &mut Simulation, asleep: &mut Simulation, duration: f64) -> usize {
    run_certified(awake, duration);
    let mut steps = 0;
    run_observed(asleep, duration, |_, report| steps += usize::from(report.solver.sleeping_islands > 0));
    steps
}

/// A pile of boxes, three of them loose, beside a block that slides to a stop.
fn pile_and_slider() -> Simulation {
    let mut world = World::upright(0.004, 0.5);
    world.floor();
    for level in 0..4 {
        world.free_box(DVec3::new(0.2, 0.2, 0.1), 2.0, DVec3::new(0.0, 0.0, 0.1 + 0.2 * f64::from(level)));
    }
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::new(-2.0, 0.0, 0.1));
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 4, DVec3::X * 1.0, DVec3::ZERO);
    simulation
}

#[test]
fn scenes_move_alike() {
    let mut slept = 0;
    for name in ["incline", "stack_of_ten", "house_of_cards", "dominoes", "quadruped", "wall"] {
        let mut awake = bundled(name);
        let mut asleep = sleeping(&awake);
        slept += run_both(&mut awake, &mut asleep, 0.6);
        let apart = difference(&awake, &asleep);
        assert!(apart < 1e-9, "{name}: {apart:e}");
    }
    assert!(slept > 100, "something slept in {slept} steps");
}

/// The pile sleeps while the block slides; once that has stopped the step is a fixed point and every bit stays.
#[test]
fn an_island_sleeps_beside_one_that_moves() {
    let mut awake = pile_and_slider();
    let mut asleep = sleeping(&awake);
    run_both(&mut awake, &mut asleep, 0.1);
    let report = asleep.step().unwrap().solver;
    awake.step().unwrap();
    assert_eq!((report.islands, report.sleeping_islands), (2, 1));
    run_both(&mut awake, &mut asleep, 1.5);
    assert!(difference(&awake, &asleep) < 1e-9);
    let rest = bits(asleep.state());
    let report = asleep.step().unwrap();
    assert_eq!((report.solver.sleeping_islands, report.solver.iterations()), (2, 0));
    assert!(report.certificate.holds(1e-9) && report.contacts == 20);
    assert_eq!(bits(asleep.state()), rest);
}

/// A model can ask for it, and the settings have the last word.
#[test]
fn a_model_asks_for_sleep() {
    for (asked, settings, sleeps) in
        [(false, None, false), (true, None, true), (true, Some(false), false), (false, Some(true), true)]
    {
        let mut world = World::upright(0.004, 0.5);
        world.floor();
        world.free_box(DVec3::splat(0.1), 1.0, DVec3::new(0.0, 0.0, 0.1));
        world.builder.sleeping(asked);
        let mut simulation = world.simulation(Settings::default().with_sleeping(settings));
        run_certified(&mut simulation, 0.1);
        let slept = simulation.step().unwrap().solver.sleeping_islands;
        assert_eq!(slept, usize::from(sleeps), "asked {asked}, settings {settings:?}");
    }
}

/// An input, a struck neighbour, a changed state and its end: each wakes what it touches.
#[test]
fn every_change_wakes() {
    let mut awake = pile_and_slider();
    let mut asleep = sleeping(&awake);
    run_both(&mut awake, &mut asleep, 1.0);
    assert_eq!(asleep.step().unwrap().solver.sleeping_islands, 2);
    awake.step().unwrap();
    for simulation in [&mut awake, &mut asleep] {
        let mut force = vec![0.0; 30];
        force[18] = 15.0;
        simulation.input.generalized_force = force;
    }
    run_both(&mut awake, &mut asleep, 0.2);
    assert!(asleep.state().v[18] > 0.1, "the top box is pushed: {} m/s", asleep.state().v[18]);
    assert!(difference(&awake, &asleep) < 1e-9, "pushed: {:e}", difference(&awake, &asleep));
    for simulation in [&mut awake, &mut asleep] {
        simulation.input.generalized_force.clear();
        set_velocity(simulation, 4, DVec3::X * 5.0, DVec3::ZERO);
    }
    run_both(&mut awake, &mut asleep, 0.4);
    assert!(asleep.state().q[0].abs() > 1e-3 || asleep.state().v[0].abs() > 1e-3, "the block has struck the pile");
    assert!(difference(&awake, &asleep) < 1e-7, "struck: {:e}", difference(&awake, &asleep));
}
