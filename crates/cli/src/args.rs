//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use signorini::contact::SolverSettings;
use signorini::lcp::MethodKind;
use signorini::{ContactMethod, Settings};

use crate::commands::{check, export, inspect, scenes, simulate, solve, view};
use crate::error::CliError;
use crate::exit::{EXIT_CODES, Exit};

/// Multibody dynamics with hard contact and dry friction; every step is an exactly solved, certified complementarity
/// problem.
///
/// `signorini simulate` without a model runs a house of cards and writes a report for the browser.
#[derive(Debug, Parser)]
#[command(name = "signorini", version, after_help = EXIT_CODES, propagate_version = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a model and say how well every step was solved.
    Simulate(simulate::Arguments),
    /// Show a model in the browser while it runs: pause, step, drag bodies.
    View(view::Arguments),
    /// Show what a model file became: tree, joints, masses, shapes, and what was left out.
    Inspect(inspect::Arguments),
    /// List the bundled scenes.
    Scenes(scenes::Arguments),
    /// Write the contact problem of one step as a file.
    Export(export::Arguments),
    /// Solve complementarity and contact problems from files.
    Solve(solve::Arguments),
    /// Check a solution against its problem; no solver is involved.
    Check(check::Arguments),
}

impl Command {
    /// Runs the command.
    pub fn run(&self) -> Result<Exit, CliError> {
        match self {
            Self::Simulate(arguments) => simulate::run(arguments),
            Self::View(arguments) => view::run(arguments),
            Self::Inspect(arguments) => inspect::run(arguments),
            Self::Scenes(arguments) => scenes::run(arguments),
            Self::Export(arguments) => export::run(arguments),
            Self::Solve(arguments) => solve::run(arguments),
            Self::Check(arguments) => check::run(arguments),
        }
    }

    /// Whether the result is for a machine.
    pub fn json(&self) -> bool {
        match self {
            Self::Simulate(arguments) => arguments.json,
            Self::View(arguments) => arguments.json,
            Self::Inspect(arguments) => arguments.json,
            Self::Scenes(arguments) => arguments.json,
            Self::Export(arguments) => arguments.json,
            Self::Solve(arguments) => arguments.json,
            Self::Check(arguments) => arguments.json,
        }
    }
}

/// Which model, and how its file is read.
#[derive(Clone, Debug, Args)]
pub struct ModelArguments {
    /// Model file, MJCF or URDF; a bundled scene where none is given.
    pub model: Option<PathBuf>,
    /// Bundled scene; `signorini scenes` lists them. A scene starts from its first keyframe. [default: house_of_cards]
    #[arg(long, value_name = "NAME", conflicts_with = "model")]
    pub scene: Option<String>,
    /// Let the root link of a URDF move freely instead of fixing it to the world.
    #[arg(long)]
    pub floating_base: bool,
    /// Folder in which packages of `package://` names (URDF) are looked for; can be given several times.
    #[arg(long, value_name = "DIR")]
    pub package_dir: Vec<PathBuf>,
}

/// The state to start from.
#[derive(Clone, Debug, Args)]
pub struct StartArguments {
    /// Start from this keyframe of the model.
    #[arg(long, value_name = "NAME")]
    pub keyframe: Option<String>,
    /// Set the position (NAME.q=1,2,…) or velocity (NAME.v=…) of a joint, or of all joints of a body; NAME=… is NAME.q=….
    /// A free joint takes x,y,z,qw,qx,qy,qz or just x,y,z. Quaternions are normalised. Can be given several times.
    #[arg(long = "set", value_name = "NAME.q=VALUES", value_parser = crate::assignment::parse)]
    pub assignments: Vec<crate::assignment::Assignment>,
}

/// How steps are made.
#[derive(Clone, Debug, Args)]
pub struct StepArguments {
    /// Time step in seconds; the model's own where it is not given.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub dt: Option<f64>,
    /// Friction directions of every contact, an even number of at least 4.
    #[arg(long, value_name = "M", default_value_t = 8, value_parser = directions)]
    pub directions: usize,
    /// Solver: structured, or a general LCP method (automatic, lemke, enumeration, principal-pivoting, psor,
    /// newton-fischer-burmeister, newton-minimum).
    #[arg(long, value_name = "NAME", default_value = "structured", value_parser = MethodChoice::parse)]
    pub method: MethodChoice,
    /// A step has missed its tolerance when a residual of its certificate is above this.
    #[arg(long, value_name = "X", default_value = "1e-9", value_parser = fraction)]
    pub tolerance: f64,
    /// Factor γ in (0, 1] on penetrations: the part of them that one step removes.
    #[arg(long, value_name = "γ", default_value = "1", value_parser = part)]
    pub stabilization: f64,
    /// Where a step has no solution, take its penetrations as zero instead of stopping.
    #[arg(long)]
    pub clip_gaps: bool,
}

impl StepArguments {
    /// The settings of a simulation.
    pub fn settings(&self) -> Settings {
        use signorini::InfeasiblePolicy::{ClipGaps, Stop};
        Settings {
            timestep: self.dt,
            directions: self.directions,
            stabilization: self.stabilization,
            tolerance: self.tolerance,
            method: match &self.method {
                MethodChoice::Structured => ContactMethod::Structured(structured(self.tolerance)),
                MethodChoice::Lcp(kind) => ContactMethod::Lcp(kind.clone()),
            },
            infeasible: if self.clip_gaps { ClipGaps } else { Stop },
            ..Settings::default()
        }
    }
}

/// A solver by name.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodChoice {
    /// The structured contact solver.
    Structured,
    /// A method for general LCPs.
    Lcp(MethodKind),
}

impl MethodChoice {
    /// The method of this name.
    pub fn parse(name: &str) -> Result<Self, String> {
        if name == "structured" {
            return Ok(Self::Structured);
        }
        name.parse().map(Self::Lcp).map_err(|_| {
            let known: Vec<String> = MethodKind::all().iter().map(ToString::to_string).collect();
            format!("no method has this name; the methods are: structured, {}", known.join(", "))
        })
    }
}

/// Settings of the structured solver for a tolerance.
pub fn structured(tolerance: f64) -> SolverSettings {
    let default = SolverSettings::default();
    SolverSettings {
        tolerance,
        accept: default.accept.min(tolerance),
        polish: default.polish.min(tolerance),
        ..default
    }
}

/// A number of friction directions.
pub fn directions(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(count) if count >= 4 && count.is_multiple_of(2) => Ok(count),
        _ => Err("must be an even number of at least 4".into()),
    }
}

/// A positive finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("must be a positive number".into()),
    }
}

/// A number in (0, 1].
fn part(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err("must be above 0 and at most 1".into()),
    }
}

/// A number in (0, 1).
pub fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x < 1.0 => Ok(x),
        _ => Err("must be between 0 and 1, both excluded".into()),
    }
}
