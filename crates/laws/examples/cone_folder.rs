//! Solves contact problems with the circular friction cone, by Newton's method and by direction refinement, and prints a table.
//!
//!     cargo run --release -p signorini-contact --example cone_folder -- [-v] [families=COUNT] PATH…
//!
//! `PATH` is a problem file or a folder of them; `families=COUNT` adds that many seeded problems of each generator family.
//! "Solved" is the word of the circular cone's certificate at 1e-9; "denied" that the problem with the polygon is infeasible or
//! ends on a ray. The warm solve starts from the problem's own solution. Times are of single solves; `-v` adds a line for
//! each problem.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use signorini_contact::problem_file::{self, FrictionalProblem, ProblemFile};
use signorini_contact::{
    ConeReport, ConeSolution, ConeStart, ConeStatus, ConeWarmStart, ContactProblem, ContactSolution, SolveStatus,
};
use signorini_laws::CircularConeSolver;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Parameters, Random};

/// Largest problem in impulse space that is tried: its matrices are dense.
const MAX_ROWS: usize = 3000;
/// The refinement's bound on the circular cone's residuals.
const TOLERANCE: f64 = 1e-6;

/// One solved problem.
struct Row {
    group: String,
    name: String,
    contacts: usize,
    status: ConeStatus,
    residual: f64,
    report: ConeReport,
    /// Seconds.
    polygon_time: f64,
    cold_time: f64,
    warm_time: f64,
    refined: Option<Refined>,
}

struct Refined {
    converged: bool,
    /// Of the last LCP.
    status: SolveStatus,
    residual: f64,
    solves: u32,
    time: f64,
}

/// The solvers, whose memory is kept.
#[derive(Default)]
struct Solvers {
    cone: CircularConeSolver,
    polygon: ContactSolver,
}

fn main() {
    let (mut verbose, mut families, mut paths) = (false, 0, Vec::new());
    for argument in std::env::args().skip(1) {
        match argument.strip_prefix("families=") {
            Some(count) => families = count.parse().expect("families=COUNT"),
            None if argument == "-v" => verbose = true,
            None => paths.push(argument),
        }
    }
    let mut solvers = Solvers::default();
    let mut rows = Vec::new();
    let mut add = |row: Row| {
        if verbose {
            print_problem(&row);
        }
        rows.push(row);
    };
    for path in paths.iter().flat_map(|path| files(Path::new(path))) {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let group = name.split_once('_').filter(|_| name.starts_with("syn")).map_or("file", |parts| parts.1).to_owned();
        match problem_file::read(&path) {
            Ok(ProblemFile::Contact(problem)) => add(solvers.contact(group, name, &problem)),
            Ok(ProblemFile::Frictional(problem)) if problem.free_velocity.len() <= MAX_ROWS => {
                add(solvers.frictional("impulse space".to_owned(), name, &problem));
            }
            Ok(ProblemFile::Frictional(problem)) => {
                println!("{name}: {} rows, not tried", problem.free_velocity.len());
            }
            Ok(_) => {}
            Err(error) => eprintln!("{error}"),
        }
    }
    for (k, family) in Family::ALL.into_iter().enumerate() {
        for seed in 0..families {
            let mut random = Random::new(50_000 + 1000 * k as u64 + seed);
            let parameters = Parameters::random(&mut random);
            let problem = family.small(&mut random, &parameters);
            add(solvers.contact(format!("{family:?}"), format!("{family:?} {seed} {:?}", parameters.gap), &problem));
        }
    }
    print_table(&rows);
}

/// The file itself, or the `.npz` files of a folder in order.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.to_owned()] };
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|e| e == "npz"));
    files.sort();
    files
}

impl Solvers {
    fn contact(&mut self, group: String, name: String, problem: &ContactProblem) -> Row {
        let mut polygon = ContactSolution::default();
        let polygon_time = seconds(|| self.polygon.solve_into(problem, None, &mut polygon));
        let mut cold = ConeSolution::default();
        let cold_time = seconds(|| self.cone.solve_into(problem, None, &mut cold));
        let mut start = ConeWarmStart::default();
        cold.impulse.iter().for_each(|p| start.push(*p));
        start.set_bilateral(&cold.bilateral);
        let mut warm = ConeSolution::default();
        let warm_time = seconds(|| self.cone.solve_into(problem, Some(&start), &mut warm));
        let solvable = polygon.status == SolveStatus::Solved;
        let mut refined = problem.clone();
        let mut report = Default::default();
        let time = seconds(|| {
            report = self.cone.refine_into(&mut refined, None, TOLERANCE, &mut polygon);
        });
        let refined = solvable.then(|| Refined {
            converged: report.converged,
            status: polygon.status.clone(),
            residual: report.certificate.worst(),
            solves: report.solves,
            time,
        });
        let (contacts, residual, report) = (problem.contact_count(), cold.certificate.worst(), cold.report);
        Row {
            group,
            name,
            contacts,
            status: cold.status,
            residual,
            report,
            polygon_time,
            cold_time,
            warm_time,
            refined,
        }
    }

    fn frictional(&mut self, group: String, name: String, problem: &FrictionalProblem) -> Row {
        let mut solution = ConeSolution::default();
        let cold_time = seconds(|| solution = self.cone.solve_frictional(problem));
        let (contacts, residual) = (problem.friction.len(), solution.certificate.worst());
        let (status, report, none) = (solution.status, solution.report, f64::NAN);
        Row {
            group,
            name,
            contacts,
            status,
            residual,
            report,
            polygon_time: none,
            cold_time,
            warm_time: none,
            refined: None,
        }
    }
}

fn seconds(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn print_problem(row: &Row) {
    let refined = row.refined.as_ref().map_or(String::new(), |r| {
        format!(
            "refined {} in {} LCPs ({:?}), {:.1e}, {:.1} us",
            r.converged,
            r.solves,
            r.status,
            r.residual,
            1e6 * r.time
        )
    });
    println!(
        "{:44} nc {:4} {:?} {:.1e} {:?} ({} starts, {} Newton, {} sweeps) cold {:.1} us, warm {:.1} us, {refined}",
        row.name,
        row.contacts,
        row.status,
        row.residual,
        row.report.start,
        row.report.starts,
        row.report.newton_iterations,
        row.report.sweeps,
        1e6 * row.cold_time,
        1e6 * row.warm_time,
    );
}

/// One line for each group. "start" counts the solved problems by what Newton's method started from: zero, polygon,
/// refinement, sweeps.
fn print_table(rows: &[Row]) {
    let mut groups: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    rows.iter().for_each(|row| groups.entry(&row.group).or_default().push(row));
    println!(
        "\n{:20} {:>5} {:>7} {:>6} {:>12} {:>9} {:>11} {:>11} {:>11} {:>11} {:>8} {:>5} {:>11}",
        "family",
        "count",
        "solved",
        "denied",
        "start",
        "worst r",
        "polygon us",
        "cold us",
        "worst us",
        "warm us",
        "refined",
        "LCPs",
        "refine us"
    );
    for (name, rows) in groups {
        let solved: Vec<&&Row> = rows.iter().filter(|row| row.status == ConeStatus::Solved).collect();
        let denied = rows.iter().filter(|row| matches!(row.status, ConeStatus::Denied(_))).count();
        let by = |start| solved.iter().filter(|row| row.report.start == Some(start)).count();
        let starts = [ConeStart::Zero, ConeStart::Polygon, ConeStart::Refinement, ConeStart::Sweeps].map(by);
        let refined: Vec<&Refined> = rows.iter().filter_map(|row| row.refined.as_ref()).collect();
        let median_of = |value: fn(&Row) -> f64| median(rows.iter().map(|row| value(row)).collect());
        println!(
            "{name:20} {:5} {:6.1}% {denied:6} {:>12} {:9.1e} {:11.1} {:11.1} {:11.1} {:11.1} {:>8} {:5.0} {:11.1}",
            rows.len(),
            100.0 * solved.len() as f64 / rows.len() as f64,
            format!("{}/{}/{}/{}", starts[0], starts[1], starts[2], starts[3]),
            solved.iter().map(|row| row.residual).fold(0.0, f64::max),
            1e6 * median_of(|row| row.polygon_time),
            1e6 * median_of(|row| row.cold_time),
            1e6 * rows.iter().map(|row| row.cold_time).fold(0.0, f64::max),
            1e6 * median_of(|row| row.warm_time),
            format!("{}/{}", refined.iter().filter(|r| r.converged).count(), refined.len()),
            median(refined.iter().map(|r| f64::from(r.solves)).collect()),
            1e6 * median(refined.iter().map(|r| r.time).collect()),
        );
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
