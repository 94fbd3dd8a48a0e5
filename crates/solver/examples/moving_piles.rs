//! Solves recorded contact problems of piles in motion from their recorded warm starts, with the contact sweeps and without, in turn in one
//! run, and prints what each took. The certificate of every result is computed from the data.
//!
//!     cargo run --release -p signorini-solver --example moving_piles -- [--tolerance=1e-8] [--cold] [--sweeps-alone] [--history] [--budget=SWEEPS] PATH…
//!
//! With a budget: what a solve with so many sweeps takes, what a sweep takes for each contact, and what is left open.
//!
//! `PATH`: folders of problems with their starts beside them (`NAME.npz`, `NAME.warm`), or single problems.

use std::error::Error;
use std::path::{Path, PathBuf};

use cpu_time::ThreadTime;
use signorini_contact::problem_file::{self, ProblemFile};
use signorini_contact::projection::Mode;
use signorini_contact::{ContactProblem, ContactSolution, SolveStatus, StageKind, WarmStart, certify};
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::files_in;

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, paths): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let is_set = |name: &str| flags.iter().any(|flag| flag == name);
    let tolerance = flags.iter().find_map(|flag| flag.strip_prefix("--tolerance=")).unwrap_or("1e-8").parse()?;
    let settings = SolverSettings::default().for_tolerance(tolerance).with_record_history(is_set("--history"));
    let budget = flags.iter().find_map(|flag| flag.strip_prefix("--budget=")).map(str::parse).transpose()?;
    if budget.is_none() {
        println!(
            "{:14} {:>8}  {:>9} {:>9} {:>6}  {:>14} {:>15}  sweeps end it  certificates",
            "problem", "contacts", "sweeps ms", "cascade", "ratio", "factorisations", "mode changes"
        );
    }
    let files = paths.iter().map(PathBuf::from);
    for path in files.flat_map(|path| if path.is_dir() { files_in(&path, "npz") } else { vec![path] }) {
        let ProblemFile::Contact(problem) = problem_file::read(&path)? else { continue };
        let start = if is_set("--cold") { None } else { Some(read_start(&path.with_extension("warm"))?) };
        if let Some(budget) = budget {
            print_budget(&path, &problem, start.as_ref(), &settings, budget)?;
            continue;
        }
        let with = solve(&problem, start.as_ref(), settings.clone())?;
        print!(
            "{:14} {:8}  {:9.1} ",
            path.file_stem().unwrap_or_default().to_string_lossy(),
            problem.contact_count(),
            with.ms
        );
        let report = &with.solution.report;
        let ended = report.stages[StageKind::ContactSweeps].ended > 0;
        if is_set("--sweeps-alone") {
            println!(
                "{:9} {:6}  {:14} {:15}  {ended:13}  {}",
                "", "", report.factorizations, report.mode_changes, with.verdict
            );
            continue;
        }
        let without = solve(&problem, start.as_ref(), settings.clone().with_sweeps_from(usize::MAX))?;
        let other = &without.solution.report;
        println!(
            "{:9.1} {:6.2}  {:6} / {:5} {:6} / {:6}  {ended:13}  {} / {}",
            without.ms,
            with.ms / without.ms,
            report.factorizations,
            other.factorizations,
            report.mode_changes,
            other.mode_changes,
            with.verdict,
            without.verdict
        );
    }
    Ok(())
}

/// The cost of sweeps: the difference of solves with so many and with three times as many, the best of some.
fn print_budget(
    path: &Path,
    problem: &ContactProblem,
    start: Option<&WarmStart>,
    settings: &SolverSettings,
    budget: u32,
) -> Result<(), Box<dyn Error>> {
    let mut best = [(f64::INFINITY, 0); 2];
    let mut found = ContactSolution::default();
    for (best, budget) in best.iter_mut().zip([3 * budget, budget]) {
        let mut solver = ContactSolver::new(settings.clone().with_budget(budget))?;
        for _ in 0..8 {
            let begin = ThreadTime::now();
            solver.solve_into(problem, start, &mut found);
            *best = (best.0.min(1e3 * begin.elapsed().as_secs_f64()), found.report.sweeps);
        }
    }
    let [more, less] = best;
    let ns = 1e6 * (more.0 - less.0) / f64::from(more.1 - less.1) / problem.contact_count() as f64;
    let rms = found.spread.map_or(0.0, |spread| spread.rms);
    let worst = certify(problem, &found).worst();
    println!(
        "{:14} {:8} contacts  {:3} sweeps {:7.2} ms, {ns:5.1} ns a visit, residual {worst:.1e}, rms {rms:.1e}",
        path.file_stem().unwrap_or_default().to_string_lossy(),
        problem.contact_count(),
        less.1,
        less.0
    );
    Ok(())
}

/// One solve.
struct Solve {
    solution: ContactSolution,
    ms: f64,
    verdict: String,
}

fn solve(
    problem: &ContactProblem,
    start: Option<&WarmStart>,
    settings: SolverSettings,
) -> Result<Solve, Box<dyn Error>> {
    let mut solver = ContactSolver::new(settings)?;
    let begin = ThreadTime::now();
    let solution = solver.solve(problem, start);
    let ms = 1e3 * begin.elapsed().as_secs_f64();
    let worst = certify(problem, &solution).worst();
    for run in &solution.history {
        let residuals: Vec<String> = run.residuals.iter().map(|r| format!("{r:.1e}")).collect();
        println!("island {} {} {}: {}", run.island, run.stage.name(), run.outcome.name(), residuals.join(" "));
    }
    let missed = if solution.status == SolveStatus::Solved { "" } else { " missed" };
    Ok(Solve { solution, ms, verdict: format!("{worst:.1e}{missed}") })
}

/// Reads a start: per contact whether it had an impulse, the impulse, and the code of its mode, as little-endian doubles.
fn read_start(path: &Path) -> Result<WarmStart, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let mut start = WarmStart::default();
    for &[known, n, a, b, code] in numbers.as_chunks::<5>().0 {
        let mode = Mode::from_code(code as u32).ok_or_else(|| format!("{}: no mode {code}", path.display()))?;
        start.contacts.push((known > 0.0).then_some(([n, a, b], mode)));
    }
    Ok(start)
}
