//! Bouncing: coefficients of restitution by Newton's law. `cargo run --release -p signorini --example restitution`

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (radius, height) = (0.05, 1.0);
    for restitution in [0.4, 0.6, 0.8] {
        let mut world = ModelBuilder::new("bouncing ball");
        world.timestep(1e-4).floor();
        let skin = Geom::from(Geometry::Sphere { radius }).with_restitution(restitution);
        world.body("ball").at([0.0, 0.0, radius + height]).free().solid(skin, 0.2).add()?;
        let mut simulation = Simulation::new(world.build()?, Settings::default())?;

        // Speed before and after the first impact, and how high the ball comes up again.
        let (mut before, mut after, mut top, mut struck) = (0.0_f64, 0.0, 0.0_f64, false);
        simulation.run(0.9, |simulation, _| {
            let (z, v) = (simulation.state().q[2] - radius, simulation.state().v[2]);
            if struck {
                top = top.max(z);
            } else if v > 0.0 {
                (struck, after) = (true, v);
            } else {
                before = before.min(v);
            }
            true
        })?;
        println!(
            "e = {restitution}: {before:.4} → {after:.4} m/s, up to {top:.4} m (e² h = {:.4} m)",
            restitution * restitution * height
        );
        assert!((after + restitution * before).abs() < 1e-2);
        assert!((top - restitution * restitution * height).abs() < 2e-3);
    }
    Ok(())
}
