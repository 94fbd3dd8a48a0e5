//! One run of a scene, in the form in which every engine's runs are written (`benchmarks/sim/peers/protocol.py`).

use std::path::Path;

use cpu_time::ThreadTime;
use serde::Serialize;
use serde_json::Value;
use signorini::multibody::{BodyId, Kinematics, forward_kinematics_into};
use signorini::{Settings, Simulation, SimulationError, Summary, Workspace};

use super::{Motors, Scene, build};

/// Position, quaternion wxyz, linear and angular velocity of a body, world axes.
type BodyRow = [f64; 13];

/// Bodies `i` and `j` (−1 is the world), point, normal from `j` to `i`, normal force (N), tangential force on `i`, μ, gap at the
/// beginning of the step (m), first direction of the friction polygon.
pub type Contact = (i64, i64, [f64; 15]);

/// One step with the forces in it.
#[derive(Clone, Debug, Serialize)]
pub struct Snapshot {
    /// Time at the end of the step, s.
    pub t: f64,
    before: Vec<BodyRow>,
    after: Vec<BodyRow>,
    #[serde(serialize_with = "flat")]
    forces: Vec<Contact>,
}

/// What is written of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    engine: &'static str,
    variant: &'static str,
    version: &'static str,
    scene: String,
    dt: f64,
    planned: usize,
    /// Steps made.
    pub done: usize,
    /// Why it ended early, if not for lack of time.
    pub error: Option<String>,
    /// CPU time of every step, ns.
    pub step_ns: Vec<u64>,
    samples: Vec<(f64, Vec<BodyRow>)>,
    contacts: Vec<usize>,
    snapshots: Vec<Snapshot>,
    /// Worst residual of every step's certificate.
    pub certificates: Vec<f64>,
    /// What the certificates' residuals may be.
    tolerance: f64,
    /// Steps whose certificate does not hold within the tolerance.
    pub missed: u64,
    /// Steps with negative gaps taken as zero.
    pub clipped: u64,
    /// Largest number of contacts in a step.
    pub contacts_max: usize,
    /// Deepest gap below zero at the beginning of a step, m (≥ 0).
    pub deepest: f64,
}

fn flat<S: serde::Serializer>(rows: &[Contact], serializer: S) -> Result<S::Ok, S::Error> {
    let numbers = |(i, j, rest): &Contact| [*i as f64, *j as f64].into_iter().chain(*rest).collect::<Vec<_>>();
    serializer.collect_seq(rows.iter().map(numbers))
}

/// Runs a scene until its end, or until `cap` seconds of CPU time are used up.
///
/// - `rest`: where it begins, with the impulses that hold it there; without, at the scene's poses and cold
/// - `robots`: the folder with the model files that robot scenes name.
///
/// # Errors
/// What is wrong with the scene or the settings, as a sentence.
pub fn drive(
    name: &str,
    scene: &Value,
    rest: Option<&signorini::Snapshot>,
    robots: &Path,
    settings: &Settings,
    cap: f64,
) -> Result<Run, String> {
    let Scene { model, input, duration, velocity } = build(name, scene, robots)?;
    let free_bodies = scene["bodies"].is_array();
    let text = |e: SimulationError| format!("{name}: {e}");
    let mut simulation = Simulation::new(model, settings.clone()).map_err(text)?;
    simulation.input = input;
    if let Some(velocity) = velocity {
        let mut state = simulation.state().clone();
        state.v = velocity;
        simulation.set_state(&state).map_err(text)?;
    }
    let motors = if scene["motors"].is_array() { Some(Motors::new(scene, simulation.model())?) } else { None };
    if let Some(motors) = &motors {
        let mut state = simulation.state().clone();
        motors.stand(&mut state);
        simulation.set_state(&state).map_err(text)?;
    }
    if let Some(rest) = rest {
        simulation.restore(rest).map_err(text)?;
    }
    let dt = simulation.timestep();
    let steps = (duration / dt).round() as usize;
    let every = scene["sample_every"].as_u64().unwrap_or(50) as usize;
    let mut observer = Observer { kinematics: Kinematics::new(simulation.model()), all: free_bodies };
    let mut run = Run::new(name, dt, steps, settings.tolerance);
    run.samples.push((0.0, observer.bodies(&simulation)));
    let begin = ThreadTime::now();
    for k in 0..steps {
        if let Some(motors) = &motors {
            let mut input = std::mem::take(&mut simulation.input);
            motors.drive(simulation.state(), &mut input);
            simulation.input = input;
        }
        let snapshot = free_bodies && (k + 3 >= steps || (steps > 20 && k % (steps / 4) == steps / 8));
        let before = if snapshot { observer.bodies(&simulation) } else { Vec::new() };
        let start = ThreadTime::now();
        let report = match simulation.step() {
            Ok(report) => report,
            Err(error) => {
                run.error = Some(error.to_string());
                break;
            }
        };
        run.step_ns.push(start.elapsed().as_nanos() as u64);
        run.certificates.push(report.certificate.worst());
        if !report.advanced() {
            run.error = Some(format!("no solution in step {k}: {:?}", report.status));
            break;
        }
        let t = (k + 1) as f64 * dt;
        if snapshot {
            let forces = forces(simulation.workspace(), dt);
            run.snapshots.push(Snapshot { t, before, after: observer.bodies(&simulation), forces });
        }
        let late = begin.elapsed().as_secs_f64() > cap;
        if late || (k + 1) % every == 0 || k + 1 == steps {
            run.samples.push((t, observer.bodies(&simulation)));
            run.contacts.push(simulation.workspace().contact_points().len());
        }
        if late {
            break;
        }
    }
    run.sum_up(simulation.summary());
    Ok(run)
}

impl Run {
    fn new(name: &str, dt: f64, planned: usize, tolerance: f64) -> Self {
        Self {
            engine: "signorini",
            variant: "default",
            version: env!("CARGO_PKG_VERSION"),
            scene: name.to_owned(),
            dt,
            planned,
            done: 0,
            error: None,
            step_ns: Vec::new(),
            samples: Vec::new(),
            contacts: vec![0],
            snapshots: Vec::new(),
            certificates: Vec::new(),
            tolerance,
            missed: 0,
            clipped: 0,
            contacts_max: 0,
            deepest: 0.0,
        }
    }

    fn sum_up(&mut self, summary: &Summary) {
        self.done = summary.steps as usize;
        self.missed = summary.missed_steps;
        self.clipped = summary.clipped_steps;
        self.contacts_max = summary.contacts_max;
        self.deepest = summary.deepest_penetration;
    }

    /// Whether all steps were made.
    pub fn finished(&self) -> bool {
        self.done == self.planned
    }

    /// Height of the first body at the beginning and its motion until the end, m.
    pub fn largest_motion(&self) -> (f64, f64) {
        let (first, last) = (&self.samples[0].1, &self.samples[self.samples.len() - 1].1);
        let moved = first.iter().zip(last).map(|(a, b)| [b[0] - a[0], b[1] - a[1], b[2] - a[2]]);
        moved.fold((0.0, 0.0), |(drop, drift), [x, y, z]| (f64::max(drop, -z), f64::max(drift, x.hypot(y))))
    }
}

struct Observer {
    kinematics: Kinematics,
    /// All bodies, or only the first.
    all: bool,
}

impl Observer {
    fn bodies(&mut self, simulation: &Simulation) -> Vec<BodyRow> {
        let (model, state, kinematics) = (simulation.model(), simulation.state(), &mut self.kinematics);
        forward_kinematics_into(model, &state.q, &state.v, kinematics);
        let row = |i: usize| {
            let (p, q) = (kinematics.pose[i].position, kinematics.pose[i].rotation);
            let (v, w) = (kinematics.linear_velocity[i], kinematics.angular_velocity[i]);
            [p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z]
        };
        let last = if self.all { model.bodies.len() } else { 2 };
        (1..last).map(row).collect()
    }
}

/// Contact forces of the last step.
fn forces(workspace: &Workspace, dt: f64) -> Vec<Contact> {
    let index = |body: BodyId| body.index() as i64 - 1;
    let points = workspace.contact_points().iter().zip(workspace.contact_frames());
    let row = |(k, (point, frame)): (usize, (&_, &signorini::contact::ContactFrame))| {
        let point: &signorini::multibody::ContactPoint = point;
        let [normal_force, t_1, t_2] = workspace.contact_impulse(k).map(|impulse| impulse / dt);
        // The normal points from body A to body B, and the force acts on B; the world comes second.
        let (mut i, mut j, mut sign) = (index(point.body_b), index(point.body_a), 1.0);
        if i < 0 {
            (i, j, sign) = (j, i, -1.0);
        }
        let (p, n, f) = (point.position, sign * frame.normal, sign * frame.to_world([0.0, t_1, t_2]));
        let (gap, d) = (point.gap, frame.to_world([0.0, 1.0, 0.0]));
        (i, j, [p.x, p.y, p.z, n.x, n.y, n.z, normal_force, f.x, f.y, f.z, point.friction, gap, d.x, d.y, d.z])
    };
    points.enumerate().map(row).collect()
}
