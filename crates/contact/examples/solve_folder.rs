//! Solves every contact problem of the given files and prints one line for each.

use signorini_contact::{ContactSolver, problem_file};
use std::time::Instant;

fn main() {
    let mut solver = ContactSolver::default();
    for path in std::env::args().skip(1) {
        let problem = match problem_file::read(&path) {
            Ok(problem_file::ProblemFile::Contact(problem)) => problem,
            Ok(_) => continue,
            Err(error) => {
                println!("{path}: {error}");
                continue;
            }
        };
        let start = Instant::now();
        let solution = solver.solve(&problem, None);
        let cold = start.elapsed().as_secs_f64();
        let r = solution.report;
        println!(
            "{:34} nc {:4} nv {:4} {:<22} worst {:.1e} nat {:.1e} {:9.1} us | its {} fact {} changes {} restarts {} lemke {}",
            path.rsplit('/').next().unwrap_or(&path),
            problem.contact_count(),
            problem.nv(),
            format!("{:?}", solution.status).chars().take(22).collect::<String>(),
            solution.certificate.worst(),
            solution.certificate.natural_map,
            1e6 * cold,
            r.proximal_iterations,
            r.factorizations,
            r.mode_changes,
            r.restarts,
            r.lemke_pivots
        );
    }
}
