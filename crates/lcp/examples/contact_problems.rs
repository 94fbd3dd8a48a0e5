//! Solves every public contact problem with Lemke and prints a table; arguments: largest size, name filter,
//! another folder.
#![allow(non_snake_case)]

#[path = "../tests/it/contact_data.rs"]
mod contact_data;

use std::path::PathBuf;
use std::time::Instant;

use signorini_lcp::{Lemke, Method, Solution, solve_mixed};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let max_pairs = arguments.next().map_or(2000, |n| n.parse().expect("a size"));
    let filter = arguments.next().unwrap_or_default();
    let Some(folder) = arguments.next().map(PathBuf::from).or_else(contact_data::folder) else {
        return;
    };
    let mut files = contact_data::files(&folder);
    let synthetic = folder.join("synthetic");
    if synthetic.is_dir() {
        files.extend(contact_data::files(&synthetic));
    }
    println!(
        "{:44} {:>5} {:10} {:>9} {:>7} {:>9}  status, attempts",
        "problem", "n", "expected", "seconds", "pivots", "residual"
    );
    let mut lemke = Lemke::default();
    for path in files.iter().filter(|path| path.to_string_lossy().contains(&filter)) {
        for named in contact_data::lcps(path, max_pairs) {
            let start = Instant::now();
            let solution = lemke.solve(&named.problem, None);
            print_row(&named.name, &named.expected, start.elapsed().as_secs_f64(), &solution);
        }
        if let Some(named) = contact_data::mixed(path) {
            let start = Instant::now();
            let solution = solve_mixed(&named.problem, &mut lemke, None);
            print_row(&named.name, &named.expected, start.elapsed().as_secs_f64(), &solution);
        }
    }
}

fn print_row(name: &str, expected: &str, seconds: f64, solution: &Solution) {
    let status = format!("{:?}", solution.status);
    let attempts: Vec<String> = solution
        .report
        .attempts
        .iter()
        .map(|a| format!("{:?}: {:?} after {} at {:.0e}", a.start, a.outcome, a.pivots, a.residual.unwrap_or(f64::NAN)))
        .collect();
    println!(
        "{name:44} {:5} {expected:10} {seconds:9.6} {:7} {:9.1e}  {} {}",
        solution.z.len(),
        solution.iterations,
        solution.residual.value,
        status.split(['(', ' ']).next().unwrap(),
        if attempts.len() > 1 { attempts.join(", ") } else { String::new() }
    );
}
