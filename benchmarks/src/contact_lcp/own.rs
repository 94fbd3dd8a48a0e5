//! Our own solvers behind the pipe.

use std::error::Error;
use std::io::{BufRead, Write};
use std::time::Instant;

use serde_json::{Value, json};
use signorini::contact::{ContactProblem, ContactSolution, ContactSolver, SolveStatus, SolverSettings, WarmStart};
use signorini::lcp::{EnumerationSettings, Lcp, LemkeSettings, MethodKind};
use signorini_npz::ArchiveWriter;

use super::stopwatch::seconds_of;
use super::{Problem, Spec};

/// Solves of one request at most.
const MOST_REPETITIONS: usize = 50;

/// Answers requests from standard input until it ends. One request per line,
/// `{"problem": SPEC, "warm": false, "budget": 0.02, "out": "z.npz"}`, is answered with
/// `{"status": "Solved", "claims": true, "certificate": 1e-12, "seconds": […]}`. `budget`: seconds after which a solve is not
/// repeated. The point goes to `out` as `z`.
///
/// # Errors
/// If a pipe breaks or a request is malformed.
pub fn serve() -> Result<(), Box<dyn Error>> {
    let mut current: Option<(Spec, Solving)> = None;
    for line in std::io::stdin().lock().lines() {
        let request: Value = serde_json::from_str(&line?)?;
        let spec: Spec = request["problem"].as_str().ok_or("a request without a problem")?.parse()?;
        if current.as_ref().is_none_or(|(known, _)| *known != spec) {
            current = Some((spec.clone(), Solving::of(spec.build()?)?));
        }
        let Some((_, solving)) = current.as_mut() else { continue };
        let budget = request["budget"].as_f64().unwrap_or(0.0);
        let reply = solving.run(request["warm"] == true, budget)?;
        if let Some(path) = request["out"].as_str() {
            let mut writer = ArchiveWriter::new();
            writer.f64("z", &[solving.z.len()], &solving.z)?;
            writer.write(path)?;
        }
        println!("{reply}");
        std::io::stdout().flush()?;
    }
    Ok(())
}

/// A problem with its solver's memory.
struct Solving {
    problem: Problem,
    solver: ContactSolver,
    solution: ContactSolution,
    /// The last point.
    z: Vec<f64>,
    /// Our solution without a start, as the start of the warm solves.
    start: Option<WarmStart>,
}

impl Solving {
    fn of(problem: Problem) -> Result<Self, Box<dyn Error>> {
        // The time that counts is that of one thread.
        let solver = ContactSolver::new(SolverSettings::default().with_threads(1))?;
        Ok(Self { problem, solver, solution: ContactSolution::default(), z: Vec::new(), start: None })
    }

    fn run(&mut self, warm: bool, budget: f64) -> Result<Value, Box<dyn Error>> {
        match &self.problem {
            Problem::Plain(lcp) => {
                let (reply, z) = run_plain(lcp, warm, budget)?;
                self.z = z;
                Ok(reply)
            }
            Problem::Contact(problem) => {
                let start = if warm { self.start.as_ref() } else { None };
                let solver = &mut self.solver;
                let solution = &mut self.solution;
                let seconds = repeat(budget, || solver.solve_into(problem, start, solution));
                if !warm {
                    self.start = Some(warm_start(problem, solution));
                }
                self.z = solution.z();
                let claims = solution.status == SolveStatus::Solved;
                let certificate = solution.certificate.worst();
                let status = word(&solution.status);
                // JSON has no infinity.
                let certificate = if certificate.is_finite() { certificate } else { f64::MAX };
                Ok(json!({"status": status, "claims": claims, "certificate": certificate, "seconds": seconds}))
            }
        }
    }
}

/// The general LCP solver on a problem without mechanics.
fn run_plain(lcp: &Lcp, warm: bool, budget: f64) -> Result<(Value, Vec<f64>), Box<dyn Error>> {
    let mut method = MethodKind::Automatic(LemkeSettings::default(), EnumerationSettings::default()).build()?;
    let mut solution = method.solve(lcp, None);
    let basis = solution.basis.clone();
    let seconds = repeat(budget, || solution = method.solve(lcp, warm.then_some(&basis)));
    let claims = solution.status.is_solved();
    let status = word(&solution.status);
    Ok((json!({"status": status, "claims": claims, "certificate": null, "seconds": seconds}), solution.z))
}

/// A solution's impulses and modes as a start.
fn warm_start(problem: &ContactProblem, solution: &ContactSolution) -> WarmStart {
    let mut start = WarmStart::default();
    (0..problem.contact_count()).for_each(|i| start.push(solution, Some(i)));
    start.set_bilateral(&solution.bilateral);
    start
}

/// The first word of a status, without its data.
fn word(status: &impl std::fmt::Debug) -> String {
    let text = format!("{status:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
}

/// Seconds of repeated runs: at least one, until the budget is used up.
fn repeat(budget: f64, mut run: impl FnMut()) -> Vec<f64> {
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.is_empty() || times.len() < MOST_REPETITIONS && begin.elapsed().as_secs_f64() < budget {
        times.push(seconds_of(&mut run));
    }
    times
}
