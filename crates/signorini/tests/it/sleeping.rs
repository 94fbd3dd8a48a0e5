//! With sleeping and without: the same motion.

use signorini::contact::certify;
use signorini::derivatives::StepDerivatives;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{BodyId, Geometry, Joint, JointKind, Pose};
use signorini::{Settings, Simulation, StepReport, Workspace};
use signorini_testkit::Random;

use crate::support::{World, bits, bundled, run_certified, run_observed, set_velocity};

fn sleeping(scene: &Simulation) -> Simulation {
    let settings = scene.settings().clone().with_sleeping(true);
    let mut simulation = Simulation::new(scene.model().clone(), settings).unwrap();
    simulation.set_state(scene.state()).unwrap();
    simulation.input = scene.input.clone();
    simulation
}

/// The largest difference of a number of their states.
pub fn difference(a: &Simulation, b: &Simulation) -> f64 {
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

/// The same step from the same start with everyone awake; both reports.
fn step_both(beside: &mut Simulation, all: &mut Simulation) -> [StepReport; 2] {
    all.restore(&beside.save()).unwrap();
    all.input = beside.input.clone();
    [beside, all].map(|simulation| simulation.step().unwrap().clone())
}

/// All that one of two steps tells is what the other one tells.
fn same_steps(beside: &mut Simulation, all: &mut Simulation, reports: &[StepReport; 2], at: &str) {
    assert_eq!(bits(beside.state()), bits(all.state()), "{at}");
    let [a, b] = [&*beside, &*all].map(Simulation::workspace);
    assert_eq!(a.contact_points(), b.contact_points(), "{at}");
    assert_eq!((a.contact_frames(), a.left_out()), (b.contact_frames(), b.left_out()), "{at}");
    let [p, q] = [a, b].map(Workspace::problem);
    assert_eq!((&p.jacobian, &p.gap, &p.friction, &p.directions), (&q.jacobian, &q.gap, &q.friction, &q.directions));
    assert_eq!((&p.free_velocity, &p.mass), (&q.free_velocity, &q.mass), "{at}");
    assert_eq!(p.friction_groups, q.friction_groups, "{at}");
    let islands = [0, 1].map(|k| (reports[k].contacts, reports[k].solver.islands));
    assert_eq!(islands[0], islands[1], "{at}");
    if reports[0].solver.sleeping_islands == reports[0].solver.islands {
        return; // What ends where it began is told again as it was: other last digits of its impulses would do as well.
    }
    let [x, y] = [a, b].map(Workspace::solution);
    assert_eq!((&x.impulse, &x.velocity, &x.alpha, &x.beta), (&y.impulse, &y.velocity, &y.alpha, &y.beta), "{at}");
    assert_eq!((&x.modes, &x.group_impulse, &x.group_modes), (&y.modes, &y.group_impulse, &y.group_modes), "{at}");
    // The rows of those that sleep are certified relative to their own scales, which are no larger.
    let [told, known] = [reports[0].certificate, certify(p, x)].map(|certificate| certificate.worst());
    assert!((known - certify(q, y).worst()).abs() < 1e-15, "{at}");
    assert!(told >= known - 1e-15 && reports[0].certificate.holds(1e-9), "{at}: {told:e}, {known:e}");
    assert_eq!(a.warm_start(), b.warm_start(), "{at}");
    assert_eq!(beside.sensors(), all.sensors(), "{at}");
}

/// Stacks, a door against its stop, a lever with dry friction, balls that resist rolling, and a ball that rolls through them.
const ROOM: &str = r#"<mujoco><option timestep="0.004"><flag sleep="enable"/></option>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="step" type="box" size=".2 .2 .05" pos="-1 1 .05"/>
    <body name="door" pos="0 1 .5" euler="20 0 0"><joint name="hinge" type="hinge" axis="0 0 1" range="0 90"/>
      <geom type="box" size=".2 .02 .3" pos=".2 0 0" mass="2"/></body>
    <body name="lever" pos="1 1 .5"><joint type="hinge" axis="0 1 0" frictionloss="3"/>
      <geom type="capsule" size=".02" fromto="0 0 0 .2 0 0" mass="1"/></body>
    <body pos="-1 1 .2"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
    <body pos="-1 1 .4"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/><site name="in" type="box" size=".2 .2 .2"/></body>
    <body pos="1 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
    <body pos="1 0 .3"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
    <body pos="2 0 .1"><freejoint/><geom type="sphere" size=".1" mass="1" condim="6" friction="1 .01 .01"/></body>
    <body pos="2 .21 .1"><freejoint/><geom type="sphere" size=".1" mass="1" condim="6" friction="1 .01 .01"/></body>
    <body name="ball" pos="-.6 0 .2"><freejoint/><geom type="sphere" size=".2" mass="4"/></body>
  </worldbody>
  <sensor><touch site="in"/><accelerometer site="in"/><force site="in"/><jointlimitfrc joint="hinge"/></sensor></mujoco>"#;

/// That room, its ball rolling.
fn room() -> Simulation {
    let room = signorini_formats::load_mjcf_str(ROOM, "").unwrap();
    let mut room = Simulation::new(room.model, Settings::default()).unwrap();
    let mut start = room.state().clone();
    let ball = start.v.len() - 6;
    start.v[ball] = 3.0;
    room.set_state(&start).unwrap();
    room
}

/// Runs a scene and compares every step; gives back in how many some bodies slept beside others that did not, and how often one woke.
fn compare_steps(mut beside: Simulation, steps: usize, name: &str) -> [usize; 2] {
    let mut all = Simulation::new(beside.model().clone(), beside.settings().clone()).unwrap();
    let (mut partly, mut woken, mut before) = (0, 0, Vec::new());
    for k in 0..steps {
        let reports = step_both(&mut beside, &mut all);
        same_steps(&mut beside, &mut all, &reports, &format!("{name}, step {k}"));
        let bodies = (0..beside.model().bodies.len() as u32).map(BodyId);
        let moves = |body: &BodyId| beside.model().dofs_moving(*body).next().is_some();
        let sleep: Vec<bool> = bodies.filter(moves).map(|body| beside.workspace().sleeps(body)).collect();
        partly += usize::from(sleep.contains(&true) && sleep.contains(&false));
        woken += before.iter().zip(&sleep).filter(|(before, now)| **before && !**now).count();
        before = sleep;
    }
    [partly, woken]
}

#[test]
fn a_step_beside_those_that_sleep_is_the_step_of_all() {
    let [partly, woken] = compare_steps(room(), 500, "room");
    assert!(partly > 490 && woken == 2, "{partly} steps, {woken} woken: one stack is struck");
    let [partly, woken] = compare_steps(sleeping(&bundled("dominoes")), 400, "dominoes");
    assert!(partly > 100 && woken > 10, "{partly} steps, {woken} woken");
    let mut pile = sleeping(&pile_and_slider());
    set_velocity(&mut pile, 4, DVec3::X * 6.0, DVec3::ZERO);
    let [partly, woken] = compare_steps(pile, 300, "pile");
    assert!(partly > 10 && woken >= 4, "{partly} steps, {woken} woken");
}

/// A room of boxes, balls and hinged bars at places that a seed chooses, some of them on each other.
fn random_room(rng: &mut Random) -> Simulation {
    let mut world = World::upright(0.004, rng.between(0.3, 0.8));
    world.floor();
    for k in 0..12 {
        let place = DVec3::new(0.45 * f64::from(k % 4), 0.45 * f64::from(k / 4), 0.1);
        let place = place + DVec3::new(rng.between(-0.1, 0.1), rng.between(-0.1, 0.1), 0.0);
        match rng.below(4) {
            0 => {
                world.free_ball(0.1, rng.between(0.3, 3.0), place);
            }
            1 => {
                world.free_box(DVec3::splat(0.1), rng.between(0.3, 3.0), place);
                world.free_box(DVec3::splat(0.08), rng.between(0.3, 3.0), place + DVec3::new(0.03, 0.0, 0.18));
            }
            2 => {
                world.free_box(DVec3::new(0.15, 0.05, 0.1), rng.between(0.3, 3.0), place);
            }
            _ => {
                let bar = Geometry::Box { half_extents: DVec3::new(0.2, 0.02, 0.1) };
                let body = world.body(bar, 1.0, Pose::from_position(place + DVec3::Z * 0.02));
                let mut joint = Joint::new(format!("hinge{}", body.0), JointKind::Hinge { axis: DVec3::Z });
                joint.friction_loss = rng.choice(&[0.0, 0.05]);
                joint.limits = rng.choice(&[None, Some([-0.3, 0.3])]);
                joint.damping = 0.02;
                world.builder.add_joint(body, joint).unwrap();
            }
        }
    }
    world.simulation(Settings::default().with_sleeping(true))
}

/// Pushes of random bodies at random times set islands in motion, which strike others and come to rest again.
#[test]
fn in_random_rooms_a_step_beside_those_that_sleep_is_the_step_of_all() {
    let seeds = std::env::var("SLEEPING_SEEDS").map_or(30, |seeds| seeds.parse().unwrap());
    let (mut partly, mut changes, mut others) = (0, 0, 0);
    for seed in 0..seeds {
        let mut rng = Random::new(seed);
        let mut beside = random_room(&mut rng);
        let mut all = Simulation::new(beside.model().clone(), beside.settings().clone()).unwrap();
        let (nv, mut before) = (beside.model().nv, Vec::new());
        for k in 0..300 {
            if rng.below(50) == 0 {
                let mut force = vec![0.0; nv];
                force[rng.below(nv)] = rng.between(-80.0, 80.0);
                beside.input.generalized_force = force;
            } else if rng.below(3) == 0 {
                beside.input.generalized_force.clear();
            }
            let reports = step_both(&mut beside, &mut all);
            let work =
                [0, 1].map(|k| (reports[k].solver.factorizations, reports[k].solver.restarts, reports[k].solves));
            let is_repeated = reports[0].solver.sleeping_islands == reports[0].solver.islands;
            if work[0] == work[1] && !is_repeated {
                same_steps(&mut beside, &mut all, &reports, &format!("seed {seed}, step {k}"));
            } else {
                // Where an island in motion fails its certificate at first, those at rest beside it are solved once more, too; where what was struck
                // goes farther than was searched, it may wake others, with which the step is solved once more. Where everything rests the step is told
                // again as it was.
                others += u64::from(!is_repeated);
                let apart = difference(&beside, &all);
                assert!(apart < 1e-9, "seed {seed}, step {k}: {apart:e}, more than what both are certified to");
            }
            let sleep: Vec<bool> =
                (0..beside.model().bodies.len() as u32).map(|i| beside.workspace().sleeps(BodyId(i))).collect();
            partly += usize::from(sleep[1..].contains(&true) && sleep[1..].contains(&false));
            changes += before.iter().zip(&sleep).filter(|(a, b)| a != b).count();
            before = sleep;
        }
    }
    let counts = format!("{partly} steps, {changes} changes, {others} with other work");
    assert!(partly as u64 > 100 * seeds && changes as u64 > 20 * seeds && others < 3 * seeds, "{counts}");
}

/// Derivatives of steps, some of whose bodies sleep, are those of the same steps with everyone awake.
#[test]
fn derivatives_beside_those_that_sleep_are_those_of_all() {
    let mut beside = room();
    let mut all = Simulation::new(beside.model().clone(), Settings::default()).unwrap();
    let mut derivatives = [0, 1].map(|_| StepDerivatives::new(beside.model()));
    let mut known = 0;
    for k in 0..200 {
        all.restore(&beside.save()).unwrap();
        let [of_beside, of_all] = &mut derivatives;
        let validity = of_beside.step(&mut beside).unwrap();
        assert_eq!(validity, of_all.step(&mut all).unwrap(), "step {k}");
        assert_eq!(of_beside.state_matrix(), of_all.state_matrix(), "step {k}");
        known += usize::from(of_beside.state_matrix().is_some());
    }
    assert!(known > 20 && beside.workspace().sleeps(BodyId(1)), "{known}");
}
