//! One row of a comparison in a process of its own, which is ended when its time is over.

use std::io::Read;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::arguments::Arguments;
use super::plan::Plan;
use crate::error::CliError;
use crate::results::Row;

/// How often a running row is looked at.
const POLL: Duration = Duration::from_millis(2);

/// Solves row `k`.
pub fn solve_row(k: usize, plan: &Plan, arguments: &Arguments) -> Result<Row, CliError> {
    let program =
        std::env::current_exe().map_err(|source| CliError::Process { program: "signorini".into(), source })?;
    let failed = |source| CliError::Process { program: program.clone(), source };
    let begin = Instant::now();
    let mut child = Command::new(&program)
        .args(words(k, arguments))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(failed)?;
    // Read beside the process: it would wait for a reader once the pipe is full.
    let mut pipe = child.stdout.take();
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        pipe.as_mut().map_or(Ok(0), |pipe| pipe.read_to_string(&mut text)).map(|_| text)
    });
    let ended = wait(&mut child, begin, arguments.time_limit).map_err(failed)?;
    let text = reader.join().unwrap_or_else(|_| Ok(String::new())).map_err(failed)?;
    let Some(status) = ended else {
        let reason = format!("no answer within --time-limit {} s", arguments.time_limit);
        return Ok(Row { status: "stopped".into(), reason: Some(reason), ..plan.row() });
    };
    Ok(serde_json::from_str(&text).unwrap_or_else(|_| {
        let reason = format!("its process ended without an answer ({status})");
        Row { status: "failed".into(), reason: Some(reason), ..plan.row() }
    }))
}

/// The command line of the row's process.
fn words(k: usize, arguments: &Arguments) -> Vec<std::ffi::OsString> {
    let directions: Vec<String> = arguments.directions.iter().map(ToString::to_string).collect();
    let mut words: Vec<std::ffi::OsString> = vec!["compare".into(), arguments.problem.clone().into()];
    for (option, value) in [
        ("--row", k.to_string()),
        ("--directions", directions.join(",")),
        ("--tol", arguments.tol.to_string()),
        ("--repetitions", arguments.repetitions.to_string()),
        ("--time-limit", arguments.time_limit.to_string()),
    ] {
        words.extend([option.into(), value.into()]);
    }
    words
}

/// Waits for the process that was started at `begin`, and ends it when its time is over; nothing then, even where its
/// answer came while nobody looked, so that the limit alone decides and not who was scheduled first.
fn wait(child: &mut Child, begin: Instant, time_limit: f64) -> std::io::Result<Option<ExitStatus>> {
    loop {
        if begin.elapsed().as_secs_f64() > time_limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        std::thread::sleep(POLL);
    }
}
