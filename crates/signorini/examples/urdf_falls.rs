//! A robot from a file falls on a floor: `cargo run --release -p signorini --example urdf_falls -- robot.urdf`.

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/robot.urdf").to_owned();
    let path = std::env::args().nth(1).unwrap_or(own);

    // A URDF says neither that its root moves freely nor that there is a floor.
    let imported = load(path, &LoadOptions::default().with_floating_base(true).with_floor(true))?;
    // What the file has and the model has not, each with its line.
    eprint!("{}", imported.report);
    let model = imported.model;
    let weight = -model.gravity.z * model.bodies.iter().map(|body| body.inertia.mass).sum::<f64>();

    let mut simulation = Simulation::new(model, Settings::default())?;
    let mut state = simulation.state().clone();
    let (start, drop) = (state.q[2] + 1.0, 0.2);
    state.q[2] = start;
    simulation.set_state(&state)?;

    // Until something strikes, everything falls alike: ½ g t², and ½ g Δt t more in steps that move with the new velocity.
    while start - simulation.state().q[2] < drop {
        simulation.step()?;
    }
    let (t, dt) = (simulation.state().time, simulation.timestep());
    let fallen = start - simulation.state().q[2];
    println!("fell {fallen:.6} m in {t:.3} s");
    assert!((fallen - 0.5 * 9.81 * t * (t + dt)).abs() < 1e-9);

    // At rest the contacts carry the weight.
    simulation.run(4.0, |_, _| true)?;
    let force: f64 = simulation.contact_forces().map(|(_, force)| force.z).sum();
    let summary = simulation.summary();
    println!("{} steps, worst residual {:.1e}, missed {}", summary.steps, summary.worst.worst(), summary.missed_steps);
    println!("the floor pushes with {force:.4} N, the weight is {weight:.4} N");
    assert!((force - weight).abs() < 1e-3 * weight);
    Ok(())
}
