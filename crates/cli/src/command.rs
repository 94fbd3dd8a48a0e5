//! The command line: every command with its arguments.

use std::any::TypeId;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::commands::{
    check, compare, convert, export, inspect, make, render, replay, scenes, simulate, solve, stability, view,
};
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

impl Cli {
    /// The command line that the program was called with.
    pub fn read() -> Result<Self, clap::Error> {
        Self::from_arg_matches(&numbers_may_be_negative(Self::command()).try_get_matches()?)
    }
}

/// A number out of its range is told by what it is for, and not taken for an option.
fn numbers_may_be_negative(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| match arg.get_action().takes_values() {
            // What clap takes for a negative number has no negative exponent.
            true if arg.get_value_parser().type_id() == TypeId::of::<f64>() => arg.allow_hyphen_values(true),
            true => arg.allow_negative_numbers(true),
            false => arg,
        })
        .mut_subcommands(numbers_may_be_negative)
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
    /// Say whether a model at rest stands, with a proof.
    Stability(stability::Arguments),
    /// Solve one problem with every law and method, side by side.
    Compare(compare::Arguments),
    /// Check a solution against its problem, or every step of a recording; no solver is involved.
    Check(check::Arguments),
    /// Show a recording in the browser, or write its report.
    Replay(replay::Arguments),
    /// Make a world to simulate: a heap, a wall, an arch, rough ground.
    #[command(alias = "generate")]
    Make(make::Arguments),
    /// Take a picture of a model, or a film of its run, without a window.
    Render(render::Arguments),
    /// Write a recording in another format: NumPy arrays, CSV, MCAP.
    Convert(convert::Arguments),
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
            Self::Stability(arguments) => stability::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            Self::Check(arguments) => check::run(arguments),
            Self::Replay(arguments) => replay::run(arguments),
            Self::Make(arguments) => make::run(arguments),
            Self::Render(arguments) => render::run(arguments),
            Self::Convert(arguments) => convert::run(arguments),
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
            Self::Stability(arguments) => arguments.json,
            Self::Compare(arguments) => arguments.json,
            Self::Check(arguments) => arguments.json,
            Self::Replay(arguments) => arguments.json,
            Self::Make(arguments) => arguments.json,
            Self::Render(arguments) => arguments.json,
            Self::Convert(arguments) => arguments.json,
        }
    }
}
