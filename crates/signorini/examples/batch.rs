//! Many simulations on threads: boxes that slide as far as their friction lets them.
//! `cargo run --release -p signorini --example batch`

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (count, speed, gravity) = (64, 2.0, 9.81);

    let mut world = ModelBuilder::new("sliding box");
    world.timestep(0.001).floor();
    // Flat, so that it slides and does not tumble.
    let shape = Geom::from(Geometry::Box { half_extents: DVec3::new(0.2, 0.2, 0.02) }).with_friction(1.0);
    world.body("box").at([0.0, 0.0, 0.02]).free().solid(shape, 3.0).add()?;

    // Zero threads are those of the machine. Whatever their number, every simulation has the bits that it has alone.
    let mut batch = Batch::new(world.build()?, Settings::default(), count, 0)?;
    let friction = |i: usize| 0.2 + 0.01 * i as f64;
    for i in 0..count {
        batch.vary(i, &Variation::default().with_friction(friction(i)))?;
        batch.state_mut(i).v[0] = speed;
    }
    let finished = batch.step(1500);
    assert!(finished, "a simulation stopped: {:?}", batch.stops().next());

    // Coulomb: v²/(2 μ g), less at most half a step of the initial speed.
    for i in 0..count {
        let (x, expected) = (batch.state(i).q[0], speed * speed / (2.0 * friction(i) * gravity));
        assert!((x - expected).abs() < speed * batch.timestep(), "μ = {}: {x} m, expected {expected} m", friction(i));
        assert!(batch.state(i).v.iter().all(|v| v.abs() < 1e-9));
        if i % 16 == 0 {
            println!("μ = {:.2}: slid {x:.4} m, v²/(2 μ g) = {expected:.4} m", friction(i));
        }
    }
    let missed: u64 = (0..count).map(|i| batch.simulation(i).summary().missed_steps).sum();
    println!("{count} simulations of 1500 steps, {missed} steps above the tolerance");
    assert_eq!(missed, 0);
    Ok(())
}
