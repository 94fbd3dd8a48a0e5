//! A box on a slope of 20°, whose tangent is 0.364.

use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Geometry, Pose};
use signorini::{Settings, Simulation};

use crate::support::{G, World, position, run_certified, run_observed};

const SLOPE: f64 = 20.0 * std::f64::consts::PI / 180.0;
const DT: f64 = 0.005;
const HALF: DVec3 = DVec3::new(0.1, 0.1, 0.05);

/// A level plane under tilted gravity.
fn tilted_gravity(friction: f64) -> Simulation {
    let mut world = World::new(DT, DVec3::new(G * SLOPE.sin(), 0.0, -G * SLOPE.cos()), friction);
    world.floor();
    world.free_box(HALF, 4.0, DVec3::new(0.0, 0.0, HALF.z));
    world.simulation(Settings::default())
}

/// A tilted plane, falling towards +x, under gravity along −z.
fn tilted_plane(friction: f64) -> Simulation {
    let mut world = World::upright(DT, friction);
    let tilt = Pose::new(DVec3::ZERO, DQuat::from_rotation_y(SLOPE));
    world.fixed(Geometry::Plane, tilt);
    let above = Pose::from_position(DVec3::new(0.0, 0.0, HALF.z));
    world.free(Geometry::Box { half_extents: HALF }, 4.0, tilt * above);
    world.simulation(Settings::default())
}

#[test]
fn sticks_above_the_angle_of_friction() {
    for mut simulation in [tilted_gravity(0.5), tilted_plane(0.5)] {
        let start = position(&simulation, 0);
        let mut farthest = 0.0_f64;
        run_observed(&mut simulation, 10.0, |now, _| farthest = farthest.max((position(now, 0) - start).length()));
        assert!(farthest < 1e-9, "moved {farthest:e} m");
    }
}

/// With `v_k = k a Δt` the scheme's displacement after N steps is `a Δt² N (N + 1) / 2`.
#[test]
fn slides_below_the_angle_of_friction() {
    let a = G * (SLOPE.sin() - 0.3 * SLOPE.cos());
    for mut simulation in [tilted_gravity(0.3), tilted_plane(0.3)] {
        let start = position(&simulation, 0);
        run_certified(&mut simulation, 2.0);
        let steps = simulation.summary().steps as f64;
        let expected = a * DT * DT * steps * (steps + 1.0) / 2.0;
        let moved = (position(&simulation, 0) - start).length();
        assert!((moved / expected - 1.0).abs() < 1e-9, "moved {moved}, expected {expected}");
    }
}
