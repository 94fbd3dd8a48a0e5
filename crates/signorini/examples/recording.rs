//! Recording a run, certifying it again afterwards, and showing it in a browser.
//! `cargo run --release -p signorini --example recording`

use signorini::prelude::*;
use signorini::recording::report::{ReportSettings, write_html};
use signorini::recording::{Ending, Recording};
use signorini::{Recertifier, RunRecorder};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("dominoes");
    world.floor();
    for k in 0..5 {
        let shape = Geom::from(Geometry::Box { half_extents: DVec3::new(0.01, 0.05, 0.1) }).with_friction(0.4);
        world.body(format!("domino {k}")).at([0.1 * k as f64, 0.0, 0.1]).free().solid(shape, 0.1).add()?;
    }
    let model = world.build()?;
    let mut simulation = Simulation::new(model.clone(), Settings::default())?;
    // The first one gets a push: 1.5 rad/s about +y.
    let mut state = simulation.state().clone();
    state.v[4] = 1.5;
    simulation.set_state(&state)?;

    // Every frame reaches the file at once: a run that is killed leaves a readable recording.
    let path = std::env::temp_dir().join(format!("signorini_dominoes_{}.rec", std::process::id()));
    let mut recorder = RunRecorder::create(&path, &simulation)?;
    for _ in 0..500 {
        simulation.step()?;
        recorder.add(&simulation)?;
    }
    recorder.finish(&simulation, "reached 1 s")?;

    // Read again, every step is judged as a claimed solution of a problem built anew from the model.
    let recording = Recording::read(&path)?;
    let frames = recording.frames();
    assert!(matches!(recording.ending(), Ending::Finished { .. }) && frames.len() == 501);
    let mut recertifier = Recertifier::new(model, recording.header())?;
    for (frame, next) in frames.iter().zip(&frames[1..]) {
        assert!(recertifier.check(frame)?.holds(1e-9, 0.0) && recertifier.leads_to(next));
    }
    // A recording that was altered is not believed.
    let mut altered = frames[300].clone();
    altered.solution.impulses[0].lambda_n.iter_mut().for_each(|impulse| *impulse *= 1.001);
    recertifier.check(&frames[299])?;
    assert!(!recertifier.check(&altered)?.holds(1e-9, 0.0));

    // One HTML file with the run in 3-D, curves and contacts.
    let page = path.with_extension("html");
    write_html(&recording, &page, &ReportSettings::default().with_title("dominoes"))?;
    println!("{} steps certified again; report of {} bytes", frames.len() - 1, std::fs::metadata(&page)?.len());
    std::fs::remove_file(&path)?;
    std::fs::remove_file(&page)?;
    Ok(())
}
