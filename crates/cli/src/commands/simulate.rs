//! `signorini simulate`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::ProgressBar;
use signorini::multibody::BodyId;
use signorini::{CertifiedLaw, RunEnd, Simulation, SimulationError, StepReport};

use crate::args::{ModelArguments, StartArguments, StepArguments, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::interrupt::Interrupt;
use crate::loading::{Loaded, load_model, start};
use crate::results::{
    Budget, Contradiction, Laws, Miss, Range, RunResult, RunStatus, StageLine, Unfinished, import_warnings,
};
use crate::solving::ContactLaw;
use crate::{clock, output, text};

mod outputs;

use outputs::Outputs;

const EXAMPLE: &str = "\
Examples:
  signorini simulate
  signorini simulate robot.xml --duration 5 --keyframe home --report robot.html
  signorini simulate pile.xml --settle --duration 1
  signorini simulate pile.xml --budget 50 --tolerance 1e-2
  signorini simulate robot.xml --friction-law circular --impulses least-norm
  signorini simulate ball.xml --set ball.q=0,0,1 --set ball.v=1,0,0,0,0,0 --record ball.rec --json";

/// Report that a run of a bundled scene leaves where none is named.
const DEFAULT_REPORT: &str = "signorini-report.html";

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// Simulated time in seconds.
    #[arg(long, alias = "time", value_name = "S", default_value = "2", value_parser = positive)]
    pub duration: f64,
    /// The state to start from.
    #[command(flatten)]
    pub start: StartArguments,
    /// How steps are made.
    #[command(flatten)]
    pub step: StepArguments,
    /// Write a recording of every step; what is written stays readable if the run is cut off.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write a report, one HTML file for the browser. [default for a bundled scene: signorini-report.html]
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Runs a model, writes recording and report, prints the summary.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let default_report = arguments.model.model.is_none().then(|| DEFAULT_REPORT.into());
    let report = arguments.report.clone().or(default_report);
    let outputs = [("--record", arguments.record.as_deref()), ("--report", report.as_deref())];
    output::keep_apart(&arguments.model.files(), &outputs)?;
    let loaded = load_model(&arguments.model)?;
    let mut simulation = start(&loaded, &arguments.start, arguments.step.settings()?)?;
    let (duration, timestep) = (arguments.duration, simulation.timestep());
    let steps = clock::steps("--duration", duration, timestep)?;
    if steps < 1.0 {
        return Err(CliError::NoStep { duration, timestep });
    }
    let outputs = Outputs::create(&simulation, arguments.record.as_deref(), report.as_deref(), &loaded)?;

    let (start_time, start_energy) = (simulation.state().time, total_energy(&simulation));
    let driven = drive(&mut simulation, (duration, steps as u64), outputs)?;
    let mut result = summarise(&loaded, &simulation, &driven);
    result.time.start = start_time;
    result.energy.start = start_energy;
    result.recording = arguments.record.as_ref().map(Into::into);
    result.report = report.as_ref().map(Into::into);
    output::print_result(&result, arguments.json, text::run);
    Ok(match result.status {
        RunStatus::Finished => Exit::Success,
        RunStatus::MissedTolerance => Exit::NotSolved,
        RunStatus::NoSolution => Exit::Contradiction,
        RunStatus::Interrupted => Exit::Interrupted,
    })
}

/// What was seen on the way.
struct Driven {
    end: RunEnd,
    /// Steps tried.
    tried: u64,
    misses: Option<Miss>,
    /// The step that lacked most of those whose budget was used up.
    unfinished: Option<Unfinished>,
    /// Wall time of the steps, s.
    seconds: f64,
}

/// Runs the simulation for a time, s, of so many steps, and finishes the outputs however it ends.
fn drive(simulation: &mut Simulation, (duration, steps): (f64, u64), outputs: Outputs) -> Result<Driven, CliError> {
    let mut watch = Watch {
        outputs,
        progress: output::progress(steps, "steps"),
        interrupt: Interrupt::listen(),
        tried: 0,
        misses: None,
        unfinished: None,
        observing: Duration::ZERO,
        broken: None,
    };
    let begin = Instant::now();
    let end = simulation.run(duration, |simulation, report| watch.after_step(simulation, report));
    let seconds = begin.elapsed().saturating_sub(watch.observing).as_secs_f64();
    watch.progress.finish_and_clear();
    if let Some(error) = watch.broken {
        return Err(error);
    }
    let time = simulation.state().time;
    if matches!(end, Ok(RunEnd::Finished | RunEnd::Stopped)) {
        watch.outputs.add_last_state(watch.tried, simulation)?;
    }
    watch.outputs.finish(&reason(&end, time))?;
    let end = end.map_err(|source| CliError::Step { time, source })?;
    Ok(Driven { end, tried: watch.tried, misses: watch.misses, unfinished: watch.unfinished, seconds })
}

/// Looks at every step of a run.
struct Watch {
    outputs: Outputs,
    progress: ProgressBar,
    interrupt: Interrupt,
    tried: u64,
    misses: Option<Miss>,
    unfinished: Option<Unfinished>,
    /// Time spent here and not on stepping.
    observing: Duration,
    /// Why the outputs cannot be written.
    broken: Option<CliError>,
}

impl Watch {
    /// Records the step; whether to go on.
    fn after_step(&mut self, simulation: &Simulation, report: &StepReport) -> bool {
        let begin = Instant::now();
        let time = self.outputs.time();
        if self.tried == 0
            && report.advanced()
            && let Some(note) = simulation.workspace().start_note(simulation.model(), simulation.settings())
        {
            self.progress.suspend(|| eprintln!("note: {note}"));
        }
        if report.advanced() && report.missed_tolerance {
            let (law, worst) = missed_law(report, simulation.settings().tolerance);
            let miss = self.misses.get_or_insert(Miss { first_time: time, worst, worst_law: law, worst_time: time });
            if worst > miss.worst {
                (miss.worst, miss.worst_law, miss.worst_time) = (worst, law, time);
            }
        }
        if let Some(spread) = &report.spread
            && self.unfinished.as_ref().is_none_or(|worst| spread.worst > worst.residual)
        {
            self.unfinished = Some(Unfinished::of(simulation, spread, time));
        }
        if let Err(error) = self.outputs.add(self.tried, simulation, report) {
            self.broken = Some(error);
        }
        self.tried += 1;
        self.progress.set_position(self.tried);
        self.observing += begin.elapsed();
        self.broken.is_none() && !self.interrupt.came()
    }
}

/// The law that a step missed most; where its own hold, that of the circular cone, whose tolerance is another.
fn missed_law(report: &StepReport, tolerance: f64) -> (&'static str, f64) {
    let own = Laws::of_contacts(&report.certificate, true).worst();
    match &report.cone_certificate {
        Some(cone) if own.1 <= tolerance => Laws::of_contacts(cone, true).worst(),
        _ => own,
    }
}

fn total_energy(simulation: &Simulation) -> f64 {
    let (kinetic, potential) = simulation.energy();
    kinetic + potential
}

/// Why the run ended, for the recording.
fn reason(end: &Result<RunEnd, SimulationError>, time: f64) -> String {
    let time = text::number(time);
    match end {
        Ok(RunEnd::Finished) => format!("reached {time} s"),
        Ok(RunEnd::NoSolution(_)) => format!("the contacts contradict each other at {time} s"),
        Ok(RunEnd::Stopped) => format!("interrupted at {time} s"),
        Err(error) => format!("broke down at {time} s: {error}"),
    }
}

/// How a run ended that no contradiction did.
fn status(end: &RunEnd, missed_steps: u64) -> RunStatus {
    match end {
        RunEnd::Stopped => RunStatus::Interrupted,
        _ if missed_steps > 0 => RunStatus::MissedTolerance,
        _ => RunStatus::Finished,
    }
}

/// The result but for what only the caller knows: start, recording and report.
fn summarise(loaded: &Loaded, simulation: &Simulation, driven: &Driven) -> RunResult {
    let (summary, settings, model) = (simulation.summary(), simulation.settings(), simulation.model());
    let (time, energy) = (simulation.state().time, total_energy(simulation));
    let has_bilateral = !simulation.workspace().problem().bilateral_violation.is_empty();
    let bodies = (1..model.bodies.len() as u32).map(BodyId);
    let asleep = bodies.filter(|&body| simulation.workspace().sleeps(body)).count();
    let mut result = RunResult {
        status: status(&driven.end, summary.missed_steps),
        model: model.name.clone(),
        source: loaded.source.clone(),
        bodies: model.bodies.len() - 1,
        nv: model.nv,
        timestep: simulation.timestep(),
        directions: settings.directions,
        method: settings.solver_name(),
        law: match summary.law {
            CertifiedLaw::Polygon => ContactLaw::Polygon,
            CertifiedLaw::CircularCone => ContactLaw::Circular,
        },
        tolerance: settings.tolerance,
        gap_resolution: (settings.gap_resolution > 0.0).then_some(settings.gap_resolution),
        bodies_asleep: Some(asleep).filter(|count| *count > 0),
        time: Range { start: time, end: time },
        steps: summary.steps,
        missed_steps: summary.missed_steps,
        missed: driven.misses,
        budget: settings.budget.map(|sweeps| Budget {
            sweeps,
            unfinished_steps: summary.unfinished_steps,
            largest_rms: summary.largest_rms,
            worst: driven.unfinished.clone(),
        }),
        limited_steps: summary.limited_steps,
        smallest_theta: summary.smallest_theta,
        deepest_kept: summary.deepest_kept,
        correction_energy: summary.correction_energy,
        energy_from_corrections: simulation.energy_from_corrections(),
        left_out_max: summary.left_out_max,
        clipped_steps: summary.clipped_steps,
        contacts_max: summary.contacts_max,
        worst: Laws::of_contacts(&summary.worst, has_bilateral),
        worst_circular: summary.worst_cone.map(|cone| Laws::of_contacts(&cone, has_bilateral)),
        iterations: summary.iterations,
        stages: StageLine::list(&summary.stages),
        seconds: driven.seconds,
        steps_per_second: if driven.seconds > 0.0 { summary.steps as f64 / driven.seconds } else { 0.0 },
        energy: Range { start: energy, end: energy },
        deepest_penetration: summary.deepest_penetration,
        contradiction: None,
        warnings: import_warnings(&loaded.report),
        recording: None,
        report: None,
    };
    if let RunEnd::NoSolution(report) = &driven.end {
        result.add_contradiction(simulation, report, driven.tried - 1);
    }
    result
}

impl RunResult {
    /// Adds the step that has no solution, which the simulation's own summary leaves out.
    fn add_contradiction(&mut self, simulation: &Simulation, report: &StepReport, step: u64) {
        self.status = RunStatus::NoSolution;
        self.contradiction = Some(Contradiction::of(simulation, report, step));
        self.contacts_max = self.contacts_max.max(report.contacts);
        for point in simulation.workspace().contact_points() {
            self.deepest_penetration = self.deepest_penetration.max(-point.gap);
        }
    }
}
