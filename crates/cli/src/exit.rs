//! Exit codes.

use std::process::ExitCode;

/// How the command ends; the numbers are part of its interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done; everything holds.
    Success = 0,
    /// The input cannot be used, or `check` found a violated law.
    Failure = 1,
    /// Finished, but a step missed its tolerance or a problem was not solved.
    NotSolved = 2,
    /// A step's contacts contradict each other.
    Contradiction = 3,
    /// The command line is wrong (`EX_USAGE` of sysexits.h).
    Usage = 64,
    /// Ended by a signal, with what was computed until then.
    Interrupted = 130,
}

/// The exit codes for `signorini --help`.
pub const EXIT_CODES: &str = "\
Exit codes:
  0   done: every step within its tolerance, every problem solved, every law holds
  1   the input cannot be used (the message says where and why), or `check` found a violated law
  2   finished, but a step missed its tolerance or a problem was not solved
  3   the contacts of a step contradict each other: no motion satisfies them
  64  the command line is wrong
  130 interrupted; `simulate` and films keep what was computed until then

With --json every command prints one JSON object on one line for each model or problem; an error is {\"error\": \"...\"}.";

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}
