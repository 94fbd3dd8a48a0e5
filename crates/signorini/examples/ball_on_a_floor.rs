//! A model in code: a ball falls on a floor and stays there.
//! `cargo run --release -p signorini --example ball_on_a_floor`

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (radius, mass, height, gravity) = (0.1, 1.0, 1.0, 9.81_f64);

    let mut world = ModelBuilder::new("ball on a floor");
    world.floor();
    world.body("ball").at([0.0, 0.0, radius + height]).free().solid(Geometry::Sphere { radius }, mass).add()?;
    let mut simulation = Simulation::new(world.build()?, Settings::default())?;

    // Every step comes with residuals of the contact laws, computed from its data alone.
    let mut struck = None;
    simulation.run(1.0, |simulation, report| {
        assert!(report.certificate.holds(1e-9));
        if struck.is_none() && simulation.contact_forces().any(|(_, force)| force.z > 0.0) {
            struck = Some(simulation.state().time);
        }
        true
    })?;

    // The fall takes √(2h/g), which the steps meet to their length; the floor then carries the weight.
    let (struck, fall) = (struck.ok_or("the ball never struck")?, (2.0 * height / gravity).sqrt());
    let force: f64 = simulation.contact_forces().map(|(_, force)| force.z).sum();
    println!(
        "struck after {struck:.3} s (√(2h/g) = {fall:.3} s), rests at {:.9} m, pushed by {force:.6} N",
        simulation.state().q[2]
    );
    assert!((struck - fall).abs() < 2.0 * simulation.timestep());
    assert!((simulation.state().q[2] - radius).abs() < 1e-9);
    assert!((force - mass * gravity).abs() < 1e-6);
    Ok(())
}
