//! Derivatives of steps against extrapolated differences of the steps themselves.

use crate::common::{Bench, disturbed, model_of};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Model, ModelBuilder, SpatialVector};
use signorini_simulation::Settings;
use signorini_testkit::Random;

/// Relative error inside modes, as the differences resolve it.
const TOLERANCE: f64 = 1e-7;

/// Runs a model, disturbs it every few steps, and compares the products of exact derivatives with
/// differences along random changes.
fn compare(name: &str, model: Model, seeds: std::ops::Range<u64>, sizes: [f64; 3], least: usize) {
    let mut bench = Bench::new(model, Settings::default());
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
