//! Bringing a heap to rest before the run begins: `cargo run --release -p signorini --example settle`.

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (count, mass) = (12, 0.5);

    let mut world = ModelBuilder::new("heap");
    world.timestep(0.005).floor();
    for k in 0..count {
        // Above each other, each turned and moved a little, so that they tumble.
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 0.3 * k as f64, 0.5).normalize(), 0.7 * k as f64);
        let at = DVec3::new(0.03 * (k % 3) as f64, 0.02 * (k % 4) as f64, 0.12 + 0.16 * k as f64);
        let shape = Geom::from(Geometry::Box { half_extents: DVec3::new(0.08, 0.06, 0.04) }).with_friction(0.6);
        world.body(format!("box {k}")).at(Pose::new(at, turn)).free().solid(shape, mass).add()?;
    }
    let mut simulation = Simulation::new(world.build()?, Settings::default())?;

    // The way there is no simulation and takes no time; at its end an ordinary step certifies that nothing moves.
    let report = simulation.settle(&SettleSettings::default())?;
    println!("at rest after {} steps, residual {:.1e}", report.steps, report.at_rest.certificate.worst());
    assert!(report.at_rest.certificate.holds(1e-9) && report.speed == 0.0);
    assert_eq!(simulation.state().time, 0.0);

    // So it stays, to the bit, and the floor carries all of it.
    let before = simulation.state().q.clone();
    simulation.run(1.0, |_, _| true)?;
    assert_eq!(simulation.state().q, before);
    let carried: f64 = simulation
        .contact_forces()
        .filter(|(point, _)| point.body_a == BodyId::WORLD || point.body_b == BodyId::WORLD)
        .map(|(_, force)| force.z.abs())
        .sum();
    println!("the floor carries {carried:.6} N of {:.6} N", count as f64 * mass * 9.81);
    assert!((carried - count as f64 * mass * 9.81).abs() < 1e-6);
    Ok(())
}
