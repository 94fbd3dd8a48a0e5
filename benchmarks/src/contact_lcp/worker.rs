//! A process that answers requests, and is replaced when it does not.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use serde_json::Value;

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Not in time; the process was ended.
    TimeOut,
    /// The process ended, or it did not answer in JSON.
    Died,
}

/// A process that reads a JSON object per line and answers each with one. It is started when it is first asked, and again
/// after a [`Failure`].
#[derive(Debug)]
pub struct Worker {
    command: Command,
    running: Option<Running>,
}

#[derive(Debug)]
struct Running {
    child: Child,
    answers: Receiver<String>,
}

impl Worker {
    /// A worker that `command` starts. Its standard error is passed on.
    pub fn new(mut command: Command) -> Self {
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        Self { command, running: None }
    }

    /// Sends a request and waits at most `patience` for the answer.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn ask(&mut self, request: &Value, patience: Duration) -> Result<Value, Failure> {
        let answer = self.try_ask(request, patience);
        if answer.is_err() {
            self.stop();
        }
        answer
    }

    fn try_ask(&mut self, request: &Value, patience: Duration) -> Result<Value, Failure> {
        if self.running.is_none() {
            self.running = Some(start(&mut self.command).ok_or(Failure::Died)?);
        }
        let running = self.running.as_mut().ok_or(Failure::Died)?;
        let input = running.child.stdin.as_mut().ok_or(Failure::Died)?;
        writeln!(input, "{request}").map_err(|_| Failure::Died)?;
        let line = running.answers.recv_timeout(patience).map_err(|error| match error {
            RecvTimeoutError::Timeout => Failure::TimeOut,
            RecvTimeoutError::Disconnected => Failure::Died,
        })?;
        serde_json::from_str(&line).map_err(|_| Failure::Died)
    }

    fn stop(&mut self) {
        if let Some(mut running) = self.running.take() {
            // It may have ended by itself; either way it is gone after the wait.
            let _ = running.child.kill();
            let _ = running.child.wait();
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.stop();
    }
}

fn start(command: &mut Command) -> Option<Running> {
    let mut child = command.spawn().ok()?;
    let output = BufReader::new(child.stdout.take()?);
    let (sender, answers) = channel();
    // Ends with the process, whose end closes the pipe.
    std::thread::spawn(move || {
        for line in output.lines() {
            let Ok(line) = line else { return };
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    Some(Running { child, answers })
}
