//! Derivatives of steps against extrapolated differences of the steps themselves.

use crate::common::{Bench, disturbed, model_of};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Model, ModelBuilder, SpatialVector, integrate_into};
use signorini_simulation::{ContactMethod, Settings};
use signorini_testkit::Random;

/// Relative error inside modes, as the differences resolve it.
const TOLERANCE: f64 = 1e-7;

/// Steps that end where they come no nearer: those of differences begin at impulses that are off by the difference, and what they
/// leave of it would be an error of the slope.
pub fn polished() -> Settings {
    let mut settings = Settings::default();
    if let ContactMethod::Structured(solver) = &mut settings.method {
        solver.polish = 1e-15;
    }
    settings
}

/// Runs a model, disturbs it every few steps, and compares the products of exact derivatives with
/// differences along random changes.
pub fn compare(name: &str, model: Model, seeds: std::ops::Range<u64>, sizes: [f64; 3], least: usize) {
    compare_under(polished(), name, model, seeds, sizes, least);
}

/// The same of steps with other settings.
pub fn compare_under(
    settings: Settings,
    name: &str,
    model: Model,
    seeds: std::ops::Range<u64>,
    sizes: [f64; 3],
    least: usize,
) {
    let mut bench = Bench::new(model, settings);
    let (mut compared, mut left, mut worst) = (0, 0, 0.0_f64);
    for seed in seeds {
        let mut random = Random::new(seed);
        let (mut state, mut input) = bench.start();
        bench.workspace.clear_warm_start();
        for n in 0..120 {
            if n % 4 == 0 {
                let (near, with) = disturbed(&bench, &mut random, &state, &input, sizes);
                let Some(end) = bench.differentiate(&near, &with) else { continue };
                if bench.is_exact() {
                    let change = bench.random_change(&mut random);
                    let Some(error) = bench.error_along(&near, &with, &change, &end) else {
                        left += 1;
                        continue;
                    };
                    assert!(error < TOLERANCE, "{name}, seed {seed}, step {n}: {error:.1e}");
                    (compared, worst) = (compared + 1, worst.max(error));
                }
            }
            if n % 30 == 29 {
                input.control.iter_mut().for_each(|u| *u += 0.2 * random.normal());
                state.v.iter_mut().for_each(|v| *v += sizes[1] * random.normal());
            }
            if n % 30 == 14 {
                // A push that keeps its direction in world.
                input.wrench = vec![SpatialVector::ZERO; bench.model.bodies.len()];
                let (angular, linear) = (random.normal_vector() * 0.1, random.normal_vector());
                input.wrench[1 + random.below(bench.model.bodies.len() - 1)] = SpatialVector { angular, linear };
            }
            let Some(next) = bench.differentiate(&state, &input) else { break };
            state = next;
        }
    }
    println!("{name}: {compared} states, {left} near the border of their mode, worst {worst:.1e}");
    assert!(compared >= least, "{name}: only {compared} states were compared");
}

fn scene(name: &str) -> Model {
    model_of(signorini_scenes::named(name).expect("a scene").text)
}

#[test]
fn a_quadruped_on_its_feet() {
    compare("quadruped", scene("quadruped"), 0..6, [1e-4, 0.05, 0.1], 60);
}

#[test]
fn a_gripper_that_lifts_a_box() {
    compare("gripper", scene("gripper"), 0..6, [3e-5, 0.02, 0.5], 5);
}

#[test]
fn a_box_on_an_incline() {
    compare("incline", scene("incline"), 0..6, [3e-5, 0.1, 0.0], 20);
}

#[test]
fn a_tumbling_top() {
    compare("spinning top", scene("spinning_top"), 0..3, [1e-3, 0.5, 0.0], 30);
}

#[test]
fn a_humanoid() {
    compare("humanoid", model_of(include_str!("../../testdata/humanoid.xml")), 0..5, [1e-4, 0.05, 0.1], 40);
}

#[test]
fn an_arm_with_a_box() {
    compare("arm", model_of(include_str!("../../testdata/arm.xml")), 0..5, [1e-4, 0.05, 0.1], 30);
}

#[test]
fn loops_welds_and_coupled_joints() {
    compare("four-bar", model_of(include_str!("../../testdata/four_bar.xml")), 0..5, [1e-5, 0.02, 0.1], 40);
}

#[test]
fn tendons_around_geoms_and_muscles() {
    compare("tendons", model_of(include_str!("../../testdata/tendons.xml")), 0..6, [1e-4, 0.3, 0.1], 60);
}

#[test]
fn a_pile_of_twenty() {
    for seed in 0..3 {
        compare("pile", pile(seed), seed..seed + 1, [1e-5, 0.05, 0.0], 3);
    }
}

/// Two contacts along a line that is tilted a little: at one height the friction of one follows from that of the other whatever the tilt. A body that
/// sticks at both and may roll about the line.
#[test]
fn a_capsule_that_lies_all_but_flat() {
    let text = "<mujoco><option timestep='0.004'/><worldbody><geom type='plane' friction='1'/>
      <body pos='0 0 0.02'><freejoint/><geom type='capsule' size='0.02 0.1' euler='0 90 0' pos='0.02 0 0' mass='1' friction='1'/></body></worldbody></mujoco>";
    let settings = Settings::default().with_tolerance(1e-12);
    let mut bench = Bench::new(model_of(text), settings);
    let mut random = Random::new(4);
    let mut compared = 0;
    for power in 0..80 {
        let (mut state, input) = bench.start();
        let tilt = 1e-12 * 10.0_f64.powf(0.1 * f64::from(power));
        let start = state.q.clone();
        integrate_into(&bench.model, &start, &[0.0, 0.0, 0.0, 0.0, tilt, 0.0], 1.0, &mut state.q);
        // It rolls, and comes down on both ends.
        state.v[..].copy_from_slice(&[0.0, 0.02, -0.01, -1.0, 0.0, 0.0]);
        bench.workspace.clear_warm_start();
        let next = bench.differentiate(&state, &input).expect("a step");
        assert!(bench.is_exact(), "tilt {tilt:.1e}");
        let change = bench.random_change(&mut random);
        if let Some(error) = bench.error_along(&state, &input, &change, &next) {
            assert!(error < TOLERANCE, "tilt {tilt:.1e}: {error:.1e}");
            compared += 1;
        }
    }
    println!("{compared} of 80 compared");
    assert!(compared >= 40);
}

#[test]
fn ellipsoids_and_cylinders_on_a_floor_and_boxes_on_boxes() {
    let mut world = ModelBuilder::new("shapes");
    world.floor().timestep(0.004);
    let shapes = [
        Geometry::Ellipsoid { semi_axes: DVec3::new(0.08, 0.05, 0.06) },
        Geometry::Cylinder { radius: 0.06, half_length: 0.05 },
        Geometry::Cylinder { radius: 0.03, half_length: 0.09 },
        Geometry::Box { half_extents: DVec3::new(0.09, 0.09, 0.04) },
    ];
    for (i, geometry) in shapes.into_iter().enumerate() {
        let body = world.body(format!("part{i}")).at([0.3 * i as f64, 0.0, 0.1]).free();
        body.solid(Geom::from(geometry).with_friction(0.6), 0.5).add().expect("a body");
    }
    let upper = world.body("upper").at([0.92, 0.01, 0.2]).free();
    let shape = Geometry::Box { half_extents: DVec3::new(0.05, 0.04, 0.06) };
    upper.solid(Geom::from(shape).with_friction(0.7), 0.4).add().expect("a body");
    compare("shapes", world.build().expect("a model"), 0..6, [1e-4, 0.3, 0.0], 40);
}

/// Spheres, capsules, boxes and a few other shapes above each other, with their own masses and centres.
fn pile(seed: u64) -> Model {
    let mut random = Random::new(100 + seed);
    let mut world = ModelBuilder::new("pile");
    world.floor().timestep(0.004);
    for i in 0..20 {
        let size = random.between(0.05, 0.09);
        let geometry = match i % 4 {
            0 => Geometry::Sphere { radius: size },
            1 => Geometry::Capsule { radius: 0.6 * size, half_length: size },
            2 => Geometry::Box { half_extents: DVec3::new(size, 0.8 * size, 0.6 * size) },
            _ => Geometry::Ellipsoid { semi_axes: DVec3::new(size, 0.7 * size, 0.8 * size) },
        };
        let place = [random.between(-0.15, 0.15), random.between(-0.15, 0.15), 0.08 + 0.11 * f64::from(i)];
        let shape = Geom::from(geometry).with_friction(random.between(0.2, 0.9)).with_placement([0.01, 0.0, 0.005]);
        world.body(format!("part{i}")).at(place).free().solid(shape, random.between(0.2, 2.0)).add().expect("a body");
    }
    world.build().expect("a pile")
}
