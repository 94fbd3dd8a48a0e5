//! The `signorini` command: simulate, inspect and export models; solve, compare and check contact problems.
//!
//! Arguments → [`commands`] compute → [`results`] (plain data, JSON as they are) → [`text`] for people.

mod args;
mod assignment;
mod clock;
mod command;
mod commands;
mod error;
mod exit;
mod interrupt;
mod loading;
mod output;
mod pack;
mod results;
mod scene;
mod solving;
mod text;

use std::process::ExitCode;

use command::Cli;
use exit::Exit;

fn main() -> ExitCode {
    let cli = match Cli::read() {
        Ok(cli) => cli,
        Err(message) => {
            // Help and version come this way too.
            return match message.print() {
                _ if message.use_stderr() => Exit::Usage.into(),
                Ok(()) => Exit::Success.into(),
                Err(error) => output::unwritten(&error).into(),
            };
        }
    };
    match cli.command.run() {
        Ok(exit) => exit.into(),
        Err(error) => {
            output::error(&error, cli.command.json());
            error.exit().into()
        }
    }
}
