//! Scenes at rest, from scenes that are not.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use cpu_time::ThreadTime;
use serde_json::{Value, json};
use signorini::multibody::{Kinematics, forward_kinematics_into};
use signorini::{Settings, SettleProgress, SettleReport, SettleSettings, Simulation, SimulationError, Snapshot};

use super::{Scene, build};
use crate::table;

/// A scene whose bodies were brought to rest.
pub struct Settled {
    /// The scene with the bodies where they lie.
    pub scene: Value,
    /// A simulation of it, at rest, with the impulses that hold the bodies there.
    pub snapshot: Snapshot,
    report: SettleReport,
    /// CPU time, s.
    seconds: f64,
    /// How far a body's centre moved at most, m.
    moved: f64,
    after: After,
}

/// Steps from the state of rest.
#[derive(Default)]
struct After {
    /// Worst residual.
    residual: f64,
    /// Largest change of an entry of the configuration.
    creep: f64,
    /// Median CPU time of a step, µs.
    micro: f64,
}

/// How many of them.
const STEPS_AFTER: usize = 100;

/// CPU time between two words of how far it is.
const EVERY: Duration = Duration::from_secs(10);

impl Settled {
    /// What [`row`](Self::row) says.
    pub const HEADER: [&str; 9] = [
        "scene",
        "steps",
        "factorizations",
        "CPU s",
        "moved mm",
        "contacts",
        "at rest: residual",
        "creep",
        "us a step",
    ];

    /// How that went, for people.
    pub fn row(&self, name: &str) -> Vec<String> {
        vec![
            name.to_owned(),
            self.report.steps.to_string(),
            self.report.factorizations.to_string(),
            format!("{:.1}", self.seconds),
            format!("{:.1}", 1e3 * self.moved),
            self.report.at_rest.contacts.to_string(),
            format!("{:.1e}", self.after.residual),
            format!("{:.1e}", self.after.creep),
            format!("{:.0}", self.after.micro),
        ]
    }
}

/// Brings the free bodies of a scene to rest; the scene at rest is named `rest`.
///
/// # Errors
/// What is wrong with the scene or the settings, or that it does not come to rest, as a sentence.
pub fn settle(name: &str, rest: &str, scene: &Value, robots: &Path, settings: &Settings) -> Result<Settled, String> {
    let text = |e: SimulationError| format!("{name}: {e}");
    let Scene { model, input, .. } = build(name, scene, robots)?;
    let mut scene = scene.clone();
    let bodies = scene["bodies"].as_array_mut().ok_or(format!("{name}: no bodies"))?;
    let mut simulation = Simulation::new(model, settings.clone()).map_err(text)?;
    simulation.input = input;
    let start = ThreadTime::now();
    let mut told = start.elapsed();
    let tell = |progress: &SettleProgress| {
        let now = start.elapsed();
        if now >= told + EVERY {
            let SettleProgress { steps, factorizations, speed, slack, .. } = progress;
            eprintln!(
                "{name}: {:.0} s, {steps} steps, {factorizations} factorizations, speed {speed:.1e}, slack {slack:.1e} of the scale",
                now.as_secs_f64()
            );
            told = now;
        }
        ControlFlow::Continue(())
    };
    let report = simulation.settle_while(&SettleSettings::default(), tell).map_err(text)?;
    let seconds = start.elapsed().as_secs_f64();
    let mut kinematics = Kinematics::new(simulation.model());
    forward_kinematics_into(simulation.model(), &simulation.state().q, &simulation.state().v, &mut kinematics);
    let mut moved = 0.0_f64;
    for (row, pose) in bodies.iter_mut().zip(&kinematics.pose[1..]) {
        let (p, q) = (pose.position, pose.rotation);
        let lies = [p.x, p.y, p.z, q.w, q.x, q.y, q.z];
        let distance = (0..3).map(|k| row[5 + k].as_f64().map_or(0.0, |x| (lies[k] - x).powi(2))).sum::<f64>();
        moved = moved.max(distance.sqrt());
        lies.iter().enumerate().for_each(|(k, x)| row[5 + k] = json!(x));
    }
    scene["what"] = json!(format!("{}, brought to rest exactly", scene["what"].as_str().unwrap_or(name)));
    let mut resting = at_rest(&simulation, build(rest, &scene, robots)?).map_err(text)?;
    let snapshot = resting.save();
    let after = stay(&mut resting).map_err(text)?;
    Ok(Settled { scene, snapshot, report, seconds, moved, after })
}

/// The state and the impulses of a simulation in the scene that begins there: the same bodies and geoms, another model by its poses.
fn at_rest(settled: &Simulation, Scene { model, input, .. }: Scene) -> Result<Simulation, SimulationError> {
    let mut resting = Simulation::new(model, settled.settings().clone())?;
    resting.input = input;
    resting.set_state(&settled.state().clone().with_time(0.0))?;
    resting.set_warm_start(&settled.workspace().warm_start())?;
    Ok(resting)
}

/// Goes on with ordinary steps.
fn stay(simulation: &mut Simulation) -> Result<After, SimulationError> {
    let (begin, mut times, mut after) = (simulation.state().q.clone(), Vec::new(), After::default());
    for _ in 0..STEPS_AFTER {
        let start = ThreadTime::now();
        after.residual = after.residual.max(simulation.step()?.certificate.worst());
        times.push(start.elapsed().as_secs_f64() * 1e6);
    }
    let changes = simulation.state().q.iter().zip(&begin).map(|(a, b)| (a - b).abs());
    after.creep = changes.fold(0.0, f64::max);
    after.micro = table::quantile(&mut times, 0.5);
    Ok(after)
}
