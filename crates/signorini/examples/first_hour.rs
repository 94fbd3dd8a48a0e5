//! Loads a robot, puts it on a floor, runs it for a second and says how well that was solved:
//! `cargo run --release -p signorini --example first_hour -- robot.urdf`.

use signorini::multibody::JointKind;
use signorini::{Settings, Simulation};
use signorini_formats::{LoadOptions, load};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name a model file: MJCF, URDF or SDF")?;
    let options = LoadOptions { floating_base: true, floor: true, ..LoadOptions::default() };
    let imported = load(path, &options)?;
    // What the file has and the model has not, each with its line.
    eprint!("{}", imported.report);

    let mut simulation = Simulation::new(imported.model, Settings { directions: 16, ..Settings::default() })?;
    let mut state = simulation.state().clone();
    if let Some(joint) = simulation.model().joints.iter().find(|joint| joint.kind == JointKind::Free) {
        state.q[joint.q_index + 2] += 0.5;
    }
    simulation.set_state(&state)?;

    simulation.run(1.0, |simulation, report| {
        let problem = simulation.workspace().problem();
        let weight: f64 = simulation.workspace().solution().lambda_n.iter().sum::<f64>() / problem.timestep;
        if report.contacts > 0 && simulation.state().time > 0.999 {
            println!(
                "{} contacts push with {weight:.3} N, residual {:.1e}",
                report.contacts,
                report.certificate.worst()
            );
        }
        true
    })?;
    let summary = simulation.summary();
    println!("{} steps, worst residual {:.1e}, missed {}", summary.steps, summary.worst.worst(), summary.missed_steps);
    Ok(())
}
