//! Solves every contact problem of folders or files, cold and warm, and prints one table by family and one by size.
//!
//!     cargo run --release -p signorini-contact --example solve_folder -- [-v] PATH…
//!
//! A family is the part of a file's name after the first underscore (`syn034_stack.npz`: stack). "Solved" is the certificate's
//! word at the default tolerance; a proof that there is no solution counts as "denied". The warm solve starts from the
//! problem's own solution: what a simulation at rest costs. Times are medians over repeated solves; `-v` adds a line for each
//! problem.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ThreadTime;

use signorini_contact::problem_file::{self, ProblemFile};
use signorini_contact::{ContactProblem, ContactSolution, SolveStatus, WarmStart};
use signorini_solver::{ContactSolver, SolverSettings};

/// Solves of one problem go on for this long, s, and at most `MAX_REPETITIONS` times.
const TIME_PER_PROBLEM: f64 = 0.2;
const MAX_REPETITIONS: usize = 50;

/// One solved problem.
struct Row {
    name: String,
    contacts: usize,
    nv: usize,
    cold: ContactSolution,
    /// Median seconds.
    cold_time: f64,
    warm_time: f64,
}

fn main() {
    let (flags, paths): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a == "-v");
    // The time that counts is that of one thread.
    let settings = SolverSettings::default().with_threads(1);
    let mut solver = ContactSolver::new(settings).unwrap_or_default();
    let mut rows = Vec::new();
    for path in paths.iter().flat_map(|path| files(Path::new(path))) {
        match problem_file::read(&path) {
            Ok(ProblemFile::Contact(problem)) => {
                let row = measure(&mut solver, &path, &problem);
                if !flags.is_empty() {
                    print_problem(&row);
                }
                rows.push(row);
            }
            Ok(_) => {}
            Err(error) => eprintln!("{error}"),
        }
    }
    print_table("family", &rows, |row| family(&row.name));
    print_table("contacts", &rows, |row| size_class(row.contacts));
}

/// The file itself, or the `.npz` files of a folder in order.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.to_owned()] };
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "npz"));
    files.sort();
    files
}

fn measure(solver: &mut ContactSolver, path: &Path, problem: &ContactProblem) -> Row {
    let mut cold = ContactSolution::default();
    let cold_time = median_time(|| solver.solve_into(problem, None, &mut cold));
    let mut start = WarmStart::default();
    (0..problem.contact_count()).for_each(|i| start.push(&cold, Some(i)));
    start.set_bilateral(&cold.bilateral);
    let mut warm = ContactSolution::default();
    let warm_time = median_time(|| solver.solve_into(problem, Some(&start), &mut warm));
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Row { name, contacts: problem.contact_count(), nv: problem.nv(), cold, cold_time, warm_time }
}

/// Median seconds of repeated runs.
fn median_time(mut run: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.is_empty() || times.len() < MAX_REPETITIONS && begin.elapsed().as_secs_f64() < TIME_PER_PROBLEM {
        let start = ThreadTime::now();
        run();
        times.push(start.elapsed().as_secs_f64());
    }
    median(times)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn family(name: &str) -> String {
    name.split_once('_').map_or(name, |parts| parts.1).to_owned()
}

fn size_class(contacts: usize) -> String {
    let upper = [4, 16, 64, 256, 1024].into_iter().find(|&most| contacts <= most);
    upper.map_or_else(|| "more".to_owned(), |most| format!("to {most:4}"))
}

fn print_problem(row: &Row) {
    let r = row.cold.report;
    println!(
        "{:28} nc {:4} nv {:4} residual {:.1e}, cold {:9.1} us ({} factorisations, {} mode changes, {} pivots), warm {:8.1} us, {:?}",
        row.name,
        row.contacts,
        row.nv,
        row.cold.certificate.worst(),
        1e6 * row.cold_time,
        r.factorizations,
        r.mode_changes,
        r.lemke_pivots,
        1e6 * row.warm_time,
        row.cold.status
    );
}

/// One line for each group: how many, solved, denied, residuals of the solved ones, median times.
fn print_table(title: &str, rows: &[Row], group: impl Fn(&Row) -> String) {
    let mut groups: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
    rows.iter().for_each(|row| groups.entry(group(row)).or_default().push(row));
    println!(
        "\n{title:20} {:>5} {:>7} {:>7} {:>9} {:>9} {:>11} {:>11} {:>10}",
        "count", "solved", "denied", "median r", "worst r", "cold us", "worst us", "warm us"
    );
    for (name, rows) in groups {
        let solved: Vec<&&Row> = rows.iter().filter(|row| row.cold.status == SolveStatus::Solved).collect();
        let denied = rows
            .iter()
            .filter(|row| matches!(row.cold.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. }))
            .count();
        let residuals: Vec<f64> = solved.iter().map(|row| row.cold.certificate.worst()).collect();
        let times = |time: fn(&Row) -> f64| rows.iter().map(|row| 1e6 * time(row)).collect::<Vec<f64>>();
        println!(
            "{name:20} {:5} {:6.1}% {:7} {:9.1e} {:9.1e} {:11.1} {:11.1} {:10.1}",
            rows.len(),
            100.0 * solved.len() as f64 / rows.len() as f64,
            denied,
            median(residuals.clone()),
            residuals.iter().copied().fold(0.0, f64::max),
            median(times(|row| row.cold_time)),
            times(|row| row.cold_time).into_iter().fold(0.0, f64::max),
            median(times(|row| row.warm_time)),
        );
    }
}
