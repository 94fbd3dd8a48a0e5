//! Bodies that hit: no bounce, no penetration, no tunnelling.

use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Geometry, Pose};
use signorini::{Settings, Simulation};

use crate::support::{World, position, run_certified, run_observed, set_velocity, velocity};

#[test]
fn dropped_ball_stays_where_it_lands() {
    let radius = 0.1;
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    world.free_ball(radius, 1.0, DVec3::new(0.0, 0.0, 0.6));
    let mut simulation = world.simulation(Settings::default());
    run_observed(&mut simulation, 1.0, |now, _| {
        assert!(position(now, 0).z >= radius - 1e-12, "{}", position(now, 0).z - radius);
        assert!(velocity(now, 0).z <= 1e-12, "bounces");
    });
    assert!((position(&simulation, 0).z - radius).abs() < 1e-12);
}

/// A projectile at 500 m/s goes 2.5 m in a step and the wall is 10 mm thick.
fn shoot(projectile: Geometry, spin: DVec3) -> Simulation {
    let mut world = World::new(0.005, DVec3::ZERO, 0.5);
    world.fixed(
        Geometry::Box { half_extents: DVec3::new(0.005, 1.0, 1.0) },
        Pose::from_position(DVec3::new(3.1, 0.0, 0.0)),
    );
    let turned = Pose::new(DVec3::ZERO, DQuat::from_euler(signorini::multibody::glam::EulerRot::XYZ, 0.3, 0.5, 0.7));
    world.free(projectile, 0.1, turned);
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 0, DVec3::X * 500.0, spin);
    simulation
}

#[test]
fn fast_ball_does_not_pass_a_thin_wall() {
    let mut simulation = shoot(Geometry::Sphere { radius: 0.02 }, DVec3::ZERO);
    run_certified(&mut simulation, 0.1);
    assert!((position(&simulation, 0).x - (3.1 - 0.005 - 0.02)).abs() < 1e-9);
}

#[test]
fn fast_box_does_not_pass_a_thin_wall() {
    for spin in [DVec3::ZERO, DVec3::new(3.0, 20.0, -10.0)] {
        let mut simulation = shoot(Geometry::Box { half_extents: DVec3::splat(0.01) }, spin);
        run_observed(&mut simulation, 0.1, |now, _| assert!(position(now, 0).x < 3.1 - 0.005, "in the wall"));
    }
}

/// A struck ball leaves at a speed that nothing before the impact hints at; it must not pass the next one.
#[test]
fn struck_balls_do_not_pass_each_other() {
    let radius = 0.05;
    let starts = [-0.3, 0.0, 0.25, 0.4, 0.55];
    let mut world = World::new(0.005, DVec3::ZERO, 0.5);
    for x in starts {
        world.free_ball(radius, 1.0, DVec3::X * x);
    }
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 0, DVec3::X * 400.0, DVec3::ZERO);
    let mut enlargements = 0;
    run_observed(&mut simulation, 0.05, |now, report| {
        enlargements += report.enlargements;
        for k in 1..starts.len() {
            let gap = position(now, k).x - position(now, k - 1).x - 2.0 * radius;
            assert!(gap > -1e-9, "balls {} and {k}: gap {gap:e}", k - 1);
        }
        let momentum: f64 = (0..starts.len()).map(|k| velocity(now, k).x).sum();
        assert!((momentum - 400.0).abs() < 1e-9 * 400.0);
    });
    assert!(enlargements > 0, "the balls were found without enlargement: the test is too easy");
    // Without bounce they end with the same velocity.
    (0..starts.len()).for_each(|k| assert!((velocity(&simulation, k).x - 80.0).abs() < 1e-6));
}
