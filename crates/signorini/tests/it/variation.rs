//! Parameters of their own for the simulations of a batch.

use signorini::multibody::glam::DVec3;
use signorini::{Batch, Settings, Simulation, SimulationError, Variation};

use crate::support::{G, World, bits, bundled};

/// A block on a floor, of 2 kg.
fn sliding_block() -> Simulation {
    let mut world = World::upright(0.002, 0.3);
    world.floor();
    world.free_box(DVec3::splat(0.1), 2.0, DVec3::Z * 0.1);
    world.simulation(Settings::default())
}

/// The block slows down by μ g Δt in every step; under a pull F it gains (F/m) Δt.
#[test]
fn every_simulation_has_its_own_laws() {
    let (steps, dt) = (100.0, 0.002);
    let variations = [
        Variation::default(),
        Variation::default().with_friction(0.5),
        Variation::default().with_friction(0.0),
        Variation::default().with_mass(4.0),
        Variation::default().with_gravity(DVec3::NEG_Z * 1.62),
    ];
    let simulation = sliding_block();
    let mut batch = Batch::new(simulation.model().clone(), Settings::default(), variations.len(), 2).unwrap();
    let pull = 4.0;
    for (i, variation) in variations.iter().enumerate() {
        batch.state_mut(i).v[0] = 2.0;
        batch.input_mut(i).generalized_force = vec![pull, 0.0, 0.0, 0.0, 0.0, 0.0];
        batch.vary(i, variation).unwrap();
    }
    assert!(batch.step(steps as u64));
    for (i, Variation { friction, mass, gravity, .. }) in variations.iter().enumerate() {
        let g = gravity.map_or(G, |g| -g.z);
        let expected = 2.0 + steps * dt * (pull / (2.0 * mass) - 0.3 * friction * g);
        let found = batch.state(i).v[0];
        assert!((found - expected).abs() < 1e-9, "simulation {i}: {found} m/s, not {expected}");
        assert!(batch.report(i).certificate.holds(1e-9));
    }
}

/// The bits of a single simulation of the varied model; and a variation of 1 is none.
#[test]
fn a_varied_simulation_has_the_bits_that_it_has_alone() {
    let model = bundled("quadruped").model().clone();
    let variation = Variation::default().with_friction(0.7).with_mass(1.3).with_gravity(DVec3::new(0.5, 0.0, -9.0));
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 2).unwrap();
    batch.vary(0, &variation).unwrap();
    batch.vary(1, &Variation::default()).unwrap();
    assert!(batch.step(80));
    let mut alone = Simulation::new(variation.of(&model).unwrap(), Settings::default()).unwrap();
    (0..80).for_each(|_| assert!(alone.step().unwrap().advanced()));
    assert_eq!(bits(batch.state(0)), bits(alone.state()));
    assert_eq!(bits(batch.state(1)), bits(batch.state(2)));
    assert_ne!(bits(batch.state(0)), bits(batch.state(2)));
}

#[test]
fn parameters_out_of_range_are_named() {
    let mut batch = Batch::new(sliding_block().model().clone(), Settings::default(), 1, 1).unwrap();
    let wrong = [
        ("variation.mass", Variation::default().with_mass(0.0)),
        ("variation.friction", Variation::default().with_friction(-1.0)),
        ("variation.friction", Variation::default().with_friction(f64::NAN)),
        ("variation.gravity", Variation::default().with_gravity(DVec3::X * f64::INFINITY)),
    ];
    for (name, variation) in wrong {
        match batch.vary(0, &variation) {
            Err(SimulationError::Setting { setting, .. }) => assert_eq!(setting, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}
