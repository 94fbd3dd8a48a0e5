//! Reading forces: a box that friction holds on a slope.
//! `cargo run --release -p signorini --example contact_forces`

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mass, angle) = (2.0, 20.0_f64.to_radians());

    // The slope is a floor under tilted gravity. Of two geoms in contact the larger coefficient of friction counts.
    let gravity = 9.81 * DVec3::new(angle.sin(), 0.0, -angle.cos());
    let mut world = ModelBuilder::new("box on a slope");
    world.gravity(gravity).floor();
    let shape = Geom::from(Geometry::Box { half_extents: DVec3::new(0.1, 0.1, 0.05) }).with_friction(0.5);
    let block = world.body("box").at([0.0, 0.0, 0.05]).free().solid(shape, mass).add()?;
    let mut simulation = Simulation::new(world.build()?, Settings::default())?;
    simulation.run(0.5, |_, _| true)?;

    // One force for each contact point, mean over the last step, on the second body of the pair.
    let mut total = DVec3::ZERO;
    for (point, force) in simulation.contact_forces() {
        let on_block = if point.body_b == block { force } else { -force };
        println!("at {:.3}: {:.4} N", point.position, on_block);
        total += on_block;
    }

    // The four forces are not unique, their sum is: what holds the weight.
    println!("in all {total:.6} N, against the weight {:.6} N", mass * gravity);
    assert!((total + mass * gravity).length() < 1e-9 * mass * 9.81);

    // Inside the friction cone, T ≤ μ N, as tan 20° = 0.36 < 0.5 promises.
    assert!(total.truncate().length() < 0.5 * total.z);
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-9));
    Ok(())
}
