//! Free flight, momentum, energy.

use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{angular_momentum, linear_momentum};
use signorini::{Settings, Simulation};

use crate::support::{G, Random, World, kinematics, position, run_certified, run_observed, set_velocity, velocity};

/// The scheme's parabola: `z_k = z₀ + k Δt w₀ − g Δt² k (k + 1) / 2`.
#[test]
fn free_flight() {
    let (dt, v0) = (0.002, DVec3::new(3.0, -1.0, 5.0));
    let mut world = World::upright(dt, 0.5);
    world.free_box(DVec3::new(0.1, 0.2, 0.3), 2.0, DVec3::ZERO);
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 0, v0, DVec3::new(1.0, 2.0, 3.0));
    run_certified(&mut simulation, 1.0);
    let k = simulation.summary().steps as f64;
    let expected = v0 * (k * dt) - DVec3::Z * (G * dt * dt * k * (k + 1.0) / 2.0);
    assert!((position(&simulation, 0) - expected).length() < 1e-12);
    assert!((velocity(&simulation, 0) - (v0 - DVec3::Z * (G * k * dt))).length() < 1e-12);
}

fn momenta(simulation: &Simulation) -> (DVec3, DVec3) {
    let (model, kinematics) = (simulation.model(), kinematics(simulation));
    (linear_momentum(model, &kinematics), angular_momentum(model, &kinematics, DVec3::new(0.3, -0.2, 0.5)))
}

/// Impulses act on both bodies at one point, and cubes have no gyroscopic torque: both momenta stay.
#[test]
fn collision_in_space_keeps_both_momenta() {
    let mut world = World::new(0.002, DVec3::ZERO, 0.4);
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::new(-0.3, 0.03, 0.02));
    world.free_box(DVec3::splat(0.15), 3.0, DVec3::new(0.3, -0.04, -0.05));
    let mut simulation = world.simulation(Settings::default());
    set_velocity(&mut simulation, 0, DVec3::new(4.0, 0.3, -0.2), DVec3::new(1.0, -3.0, 2.0));
    set_velocity(&mut simulation, 1, DVec3::new(-2.0, 0.0, 0.1), DVec3::new(-2.0, 0.5, 1.0));
    let (p, l) = momenta(&simulation);
    let mut touched = false;
    run_observed(&mut simulation, 0.5, |now, _| {
        touched |= now.workspace().solution().lambda_n.iter().any(|&impulse| impulse > 0.0);
        let (p_now, l_now) = momenta(now);
        assert!((p_now - p).length() < 1e-11 * p.length().max(1.0), "linear");
        assert!((l_now - l).length() < 1e-11 * l.length().max(1.0), "angular");
    });
    assert!(touched);
}

/// With `v⁺ᵀM(v⁺ − v) ≤ Δt fᵀv⁺` — contacts take energy as long as φ ≥ 0 — the energy falls in every step. Balls have no
/// gyroscopic torque, and as distances are convex in their positions they never penetrate.
#[test]
fn energy_of_balls_in_a_bin_never_rises() {
    let mut simulation = balls_in_a_bin(40);
    let mut energy = total_energy(&simulation);
    let scale = energy.abs();
    run_observed(&mut simulation, 1.5, |now, _| {
        let next = total_energy(now);
        assert!(next <= energy + 1e-10 * scale, "t = {} s: rises by {:e} J", now.state().time, next - energy);
        energy = next;
    });
    assert!(simulation.summary().deepest_penetration < 1e-9);
    assert!(energy < 0.8 * scale, "they have fallen");
}

fn total_energy(simulation: &Simulation) -> f64 {
    let (kinetic, potential) = simulation.energy();
    kinetic + potential
}

pub fn balls_in_a_bin(count: usize) -> Simulation {
    let mut world = World::upright(0.005, 0.4);
    world.floor();
    for normal in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
        world.plane(normal * -0.3, normal);
    }
    let mut random = Random(7);
    for k in 0..count {
        let (column, layer) = (k % 9, k / 9);
        let offset = DVec3::new(random.between(-0.03, 0.03), random.between(-0.03, 0.03), 0.0);
        let place = DVec3::new((column % 3) as f64 - 1.0, (column / 3) as f64 - 1.0, 0.0) * 0.18;
        let radius = random.between(0.04, 0.06);
        let height = DVec3::Z * (0.1 + 0.15 * layer as f64);
        world.free_ball(radius, 4000.0 * radius.powi(3), place + offset + height);
    }
    world.simulation(Settings::default())
}

/// A body whose principal moments differ tumbles about its middle axis: its energy does not drift, and halving the step
/// divides the largest error by four.
#[test]
fn energy_of_a_tumbling_body_stays_to_second_order() {
    let errors = |dt: f64| {
        let mut world = World::new(dt, DVec3::ZERO, 0.5);
        let body = world.free_box(DVec3::splat(0.1), 1.0, DVec3::ZERO);
        let inertia = signorini::multibody::Inertia {
            mass: 1.0,
            center_of_mass: DVec3::ZERO,
            rotational: DMat3::from_diagonal(DVec3::new(0.01, 0.02, 0.025)),
        };
        world.builder.set_inertia(body, inertia).unwrap();
        let mut simulation = world.simulation(Settings::default());
        set_velocity(&mut simulation, 0, DVec3::ZERO, DVec3::new(0.5, 3.0, 0.2));
        let start = total_energy(&simulation);
        let mut worst = [0.0_f64; 2];
        run_observed(&mut simulation, 20.0, |now, report| {
            assert_eq!(report.unresolved_rotations, 0);
            let half = usize::from(now.state().time > 10.0);
            worst[half] = worst[half].max((total_energy(now) / start - 1.0).abs());
        });
        worst
    };
    let (coarse, fine) = (errors(0.004), errors(0.002));
    assert!(coarse[1] < 1.1 * coarse[0] && coarse[0] < 1e-4, "{coarse:?}");
    let ratio = coarse[1] / fine[1];
    assert!((3.8..4.2).contains(&ratio), "{ratio}");
}
