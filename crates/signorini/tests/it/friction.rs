//! Sliding and rolling on a level floor.

use std::f64::consts::{PI, TAU};

use signorini::multibody::glam::DVec3;
use signorini::{Settings, Simulation};

use crate::support::{G, World, position, run_certified, set_velocity, velocity};

const MU: f64 = 0.3;
const DT: f64 = 0.002;

/// A flat box on the floor with velocity `v`.
fn sliding_box(v: DVec3, directions: usize, direction_angle: f64) -> Simulation {
    let mut world = World::upright(DT, MU);
    world.floor();
    world.free_box(DVec3::new(0.2, 0.2, 0.02), 2.0, DVec3::new(0.0, 0.0, 0.02));
    let mut simulation =
        world.simulation(Settings::default().with_directions(directions).with_direction_angle(direction_angle));
    set_velocity(&mut simulation, 0, v, DVec3::ZERO);
    simulation
}

/// `v_k = v₀ − k μ g Δt` while positive, so that the distance is `Δt (n v₀ − μ g Δt n (n + 1) / 2)`, which is v₀²/(2 μ g)
/// up to one step's travel.
#[test]
fn stopping_distance() {
    let v0 = 1.7;
    let mut simulation = sliding_box(DVec3::X * v0, 8, 0.0);
    run_certified(&mut simulation, 1.0);
    let loss = MU * G * DT;
    let n = (v0 / loss).floor();
    let expected = DT * (n * v0 - loss * n * (n + 1.0) / 2.0);
    let distance = position(&simulation, 0).x;
    assert!((distance / expected - 1.0).abs() < 1e-9, "slid {distance}, expected {expected}");
    assert!((distance - v0 * v0 / (2.0 * MU * G)).abs() < v0 * DT);
    assert!(velocity(&simulation, 0).length() < 1e-12);
}

/// Along the bisector of two directions the polygon's friction is Coulomb's times cos(π/m).
#[test]
fn worst_direction_of_the_polygon() {
    for m in [4, 8, 16, 64] {
        let v0 = 2.0;
        let mut simulation = sliding_box(DVec3::X * v0, m, PI / m as f64);
        run_certified(&mut simulation, 0.2);
        let steps = simulation.summary().steps as f64;
        let now = velocity(&simulation, 0);
        let factor = (v0 - now.x) / (MU * G * DT * steps);
        let expected = (PI / m as f64).cos();
        assert!((factor - expected).abs() < 1e-9, "m = {m}: factor {factor}, expected {expected}");
        assert!(now.y.abs() < 1e-9, "m = {m}: drifts sideways");
    }
}

/// In any direction the power lost is that of the polygon's support function, between cos(π/m) and 1 times Coulomb's.
#[test]
fn any_direction_loses_the_power_of_the_support_function() {
    for m in [4, 8, 16] {
        for k in 0..11 {
            let angle = 0.1 + TAU * k as f64 / 11.0;
            let v0 = DVec3::new(angle.cos(), angle.sin(), 0.0) * 2.0;
            let mut simulation = sliding_box(v0, m, 0.0);
            simulation.step().unwrap();
            let lost = (v0 - velocity(&simulation, 0)).dot(v0) / (MU * G * DT * v0.length());
            let support = (0..m).map(|j| (angle - TAU * j as f64 / m as f64).cos()).fold(f64::MIN, f64::max);
            assert!((lost - support).abs() < 1e-9, "m = {m}, angle {angle}: {lost}, expected {support}");
            assert!(lost >= (PI / m as f64).cos() - 1e-9 && lost <= 1.0 + 1e-9);
        }
    }
}

/// A solid ball that starts without spin rolls at 5/7 of its speed: its angular momentum about the contact stays.
#[test]
fn sliding_ball_rolls_at_five_sevenths() {
    let (radius, v0) = (0.05, 1.4);
    let mut world = World::upright(DT, MU);
    world.floor();
    world.free_ball(radius, 0.5, DVec3::new(0.0, 0.0, radius));
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 0, DVec3::X * v0, DVec3::ZERO);
    // Sliding ends at t = 2 v₀ / (7 μ g) = 0.136 s.
    run_certified(&mut simulation, 1.0);
    let v = velocity(&simulation, 0);
    assert!((v.x / v0 - 5.0 / 7.0).abs() < 1e-9, "rolls at {} v₀", v.x / v0);
    assert!(v.y.abs() < 1e-9 && v.z.abs() < 1e-12);
    let spin = spin_of_first_body(&simulation);
    assert!((spin.y * radius - v.x).abs() < 1e-9 && spin.x.abs() < 1e-9 && spin.z.abs() < 1e-9);
}

/// Angular velocity of the first body in world.
fn spin_of_first_body(simulation: &Simulation) -> DVec3 {
    crate::support::kinematics(simulation).angular_velocity[1]
}
