//! Stopping and going on: a run that continues from a snapshot has the bits of one that was never interrupted.
//! `cargo run --release -p signorini --example snapshot`

use signorini::prelude::*;

fn stack() -> Result<Simulation, Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("stack that is pushed");
    world.floor();
    for k in 0..4 {
        let shape = Geom::from(Geometry::Box { half_extents: DVec3::splat(0.1) }).with_friction(0.5);
        world
            .body(format!("box {k}"))
            .at([0.01 * k as f64, 0.0, 0.1 + 0.2 * k as f64])
            .free()
            .solid(shape, 1.0)
            .add()?;
    }
    let mut simulation = Simulation::new(world.build()?, Settings::default())?;
    let mut state = simulation.state().clone();
    state.v[6 * 3] = 1.5;
    simulation.set_state(&state)?;
    Ok(simulation)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut whole = stack()?;
    whole.run(0.2, |_, _| true)?;

    // State, input and the impulses that the next step starts from, as bytes that can be stored.
    let bytes = whole.save().to_bytes();
    let mut resumed = stack()?;
    resumed.restore(&Snapshot::from_bytes(&bytes)?)?;

    whole.run(0.5, |_, _| true)?;
    resumed.run(0.5, |_, _| true)?;
    let same = whole.state().q.iter().zip(&resumed.state().q).all(|(a, b)| a.to_bits() == b.to_bits());
    println!("{} bytes; after 0.5 s more the bits are {}", bytes.len(), if same { "the same" } else { "different" });
    assert!(same && whole.state().time > 0.69);
    Ok(())
}
