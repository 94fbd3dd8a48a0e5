//! Things that stand.

use signorini::contact::SolveStatus;
use signorini::multibody::glam::DVec3;
use signorini::{RunEnd, Settings, Simulation};

use crate::support::{World, body_poses, bundled, largest_move, run_certified};

/// Largest drift and deepest penetration allowed, m.
const MICROMETRE: f64 = 1e-6;

fn stands(simulation: &mut Simulation, duration: f64) {
    let start = body_poses(simulation);
    run_certified(simulation, duration);
    let moved = largest_move(&start, &body_poses(simulation));
    let turned = start.iter().zip(body_poses(simulation)).map(|(a, b)| a.rotation.angle_between(b.rotation));
    let turned = turned.fold(0.0, f64::max);
    assert!(moved < MICROMETRE, "moved {moved:e} m");
    assert!(turned < 1e-6, "turned {turned:e} rad");
    assert!(simulation.summary().deepest_penetration < MICROMETRE);
}

/// Unit boxes of these masses on top of each other.
fn stack(masses: &[f64]) -> Simulation {
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    for (k, &mass) in masses.iter().enumerate() {
        world.free_box(DVec3::splat(0.5), mass, DVec3::new(0.0, 0.0, 0.5 + k as f64));
    }
    world.simulation(Settings::default())
}

#[test]
fn ten_boxes() {
    stands(&mut stack(&[1.0; 10]), 5.0);
}

#[test]
fn twenty_boxes() {
    stands(&mut stack(&[1.0; 20]), 2.0);
}

#[test]
fn heavy_on_light() {
    stands(&mut stack(&[1.0, 1000.0]), 5.0);
    stands(&mut stack(&[1.0, 1e6]), 1.0);
}

/// At rest nothing moves by as much as a last digit.
#[test]
fn a_stack_at_rest_stays_as_it_is() {
    let mut simulation = stack(&[3.0, 1.0, 7.0]);
    run_certified(&mut simulation, 0.5);
    let before = simulation.state().clone();
    run_certified(&mut simulation, 0.5);
    assert_eq!(simulation.state().q, before.q);
    assert!(simulation.state().v.iter().all(|v| *v == 0.0), "{:?}", simulation.state().v);
}

/// What is on top of a stack would move by the rounding of all contacts below it, and be stopped by the next step, which leaves other impulses.
#[test]
fn stacks_of_any_height_rest_without_another_factorisation() {
    for height in 2..=15 {
        let mut simulation = stack(&vec![1.0; height]);
        run_certified(&mut simulation, 0.25);
        let mut solved = 0;
        let end = simulation.run(0.75, |_, report| {
            solved += report.solver.factorizations;
            true
        });
        assert_eq!(end.unwrap(), RunEnd::Finished);
        assert_eq!(solved, 0, "{height} boxes");
        assert!(simulation.state().v.iter().all(|v| *v == 0.0), "{height} boxes: {:?}", simulation.state().v);
    }
}

/// A bin of bricks in bond rests from its second step on, although there the rounding of gaps and of sums of impulses is above what
/// the solver polishes to.
#[test]
fn bricks_in_a_bin_rest() {
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    let across = 3;
    for layer in 0..20 {
        let over = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y][layer % 4] * 0.025;
        for (i, k) in (0..2 * across * across).map(|brick| (brick / (2 * across), brick % (2 * across))) {
            let (along, beside) = (0.202 * (i as f64 + 0.5), 0.101 * (k as f64 + 0.5));
            let (half, x, y) = if layer % 2 == 0 {
                (DVec3::new(0.1, 0.05, 0.05), along, beside)
            } else {
                (DVec3::new(0.05, 0.1, 0.05), beside, along)
            };
            let mass = 1.0 + 0.1 * ((layer + i + 2 * k) % 7) as f64;
            world.free_box(half, mass, DVec3::new(x, y, 0.05 + 0.1 * layer as f64) + over);
        }
    }
    let mut simulation = world.simulation(Settings::default());
    for step in 0..4 {
        let report = simulation.step().expect("bricks");
        assert!(!report.missed_tolerance, "step {step}: {report:?}");
        assert!(step == 0 || report.solver.factorizations == 0, "step {step}: {:?}", report.solver);
    }
    assert!(simulation.state().v.iter().all(|v| *v == 0.0));
}

/// Whatever tolerance a step is held to, its solver is held to as well.
#[test]
fn the_solver_has_the_tolerance_of_the_settings() {
    let mut missed = 0;
    for tolerance in [1e-9, 1e-17] {
        let mut world = World::upright(0.005, 0.5);
        world.floor();
        for (k, mass) in [1.0, 1e3, 1e-2].into_iter().enumerate() {
            world.free_box(DVec3::splat(0.5), mass, DVec3::new(0.1, 0.0, 0.5 + k as f64));
        }
        let mut simulation = world.simulation(Settings::default().with_tolerance(tolerance));
        for _ in 0..20 {
            let report = simulation.step().expect("a stack");
            assert_eq!(report.missed_tolerance, report.status != SolveStatus::Solved, "{tolerance:e}: {report:?}");
            missed += usize::from(report.missed_tolerance);
        }
    }
    assert!(missed > 0, "no solver reaches 1e-17 in every step");
}

/// The floor carries the weight, each contact of a corner a quarter of it.
#[test]
fn a_stack_weighs_what_it_weighs() {
    let mut simulation = stack(&[3.0, 1.0, 7.0]);
    run_certified(&mut simulation, 0.1);
    let workspace = simulation.workspace();
    let on_floor = |p: &signorini::multibody::ContactPoint| p.body_a.index() == 0 || p.body_b.index() == 0;
    let points = workspace.contact_points().iter().zip(&workspace.solution().lambda_n);
    let weight: f64 = points.filter(|(p, _)| on_floor(p)).map(|(_, impulse)| impulse / 0.005).sum();
    assert!((weight / (11.0 * crate::support::G) - 1.0).abs() < 1e-9, "{weight} N");
}

#[test]
fn bundled_stack() {
    stands(&mut bundled("stack_of_ten"), 2.0);
}

#[test]
fn bundled_wall() {
    stands(&mut bundled("wall"), 1.0);
}

#[test]
fn bundled_house_of_cards() {
    stands(&mut bundled("house_of_cards"), 2.0);
}

#[test]
fn bundled_arch() {
    stands(&mut bundled("arch"), 2.0);
}

/// Boxes that are meshes, on each other and turned: their gaps are zero but for last digits, and nothing is factorised once they rest.
#[test]
fn what_rests_is_not_solved_anew_for_last_digits_of_its_gaps() {
    const SOME: u32 = 20;
    let corners = (0..8).map(|k| [1, 2, 4].map(|bit| if k & bit == 0 { "-0.1" } else { "0.1" }).join(" "));
    let corners = corners.collect::<Vec<_>>().join(" ");
    let boxes = (0..18).map(|k| {
        let (column, level) = (f64::from(k % 6), f64::from(k / 6));
        let (x, y, z, turn) = (0.37 * column, 0.01 * level * column, 0.1 + 0.2 * level, 7.0 * column + 13.0 * level);
        format!("<body pos='{x} {y} {z}' euler='0 0 {turn}'><freejoint/><geom type='mesh' mesh='box'/></body>")
    });
    let text = format!(
        "<mujoco><option timestep='0.002'/><asset><mesh name='box' vertex='{corners}'/></asset>\
         <worldbody><geom type='plane' size='5 5 1'/>{}</worldbody></mujoco>",
        boxes.collect::<String>()
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let (mut steps, mut solved) = (0, 0);
    let end = simulation.run(0.8, |_, report| {
        (steps, solved) = (steps + 1, solved + u32::from(steps >= SOME && report.solver.factorizations > 0));
        report.certificate.holds(1e-9)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", simulation.report());
    assert!(solved * 20 <= steps, "{solved} of {steps} steps were solved");
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-12));
}
