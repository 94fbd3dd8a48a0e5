//! Every method on the problems with known answers and on random families: how it ends, iterations and time.
//!
//! `cargo run --release -p signorini-lcp --example compare_methods`
#![allow(non_snake_case, dead_code)]

#[path = "../tests/it/cases.rs"]
mod cases;
#[path = "../tests/it/contact_data.rs"]
mod contact_data;
#[path = "../tests/it/support.rs"]
mod support;

use std::time::Instant;

use signorini_lcp::{Lcp, Method, MethodKind, Solution, Status};
use support::{Random, gram, monotone, p_matrix, quadratic_program, touching_contacts};

/// Enumeration takes 2ⁿ bases.
const MAX_ENUMERATED: usize = 12;

fn main() {
    let kinds = MethodKind::all();
    print!("{:34} {:>4}", "problem", "n");
    kinds.iter().for_each(|kind| print!(" {:>27}", kind.to_string()));
    println!();
    for case in cases::all() {
        row(case.name, &case.problem, &kinds);
    }
    for n in [5, 10, 50, 100, 200] {
        let mut random = Random(n as u64);
        let mut definite = gram(&random.matrix(n, n));
        (0..n).for_each(|i| definite[(i, i)] += 0.1);
        let b = random.vector(n);
        row("symmetric positive definite", &lcp(definite, b), &kinds);
        let singular = random.matrix(n, n / 2 + 1);
        let b = singular.data().chunks(n / 2 + 1).map(|row| row.iter().sum()).collect();
        row("symmetric semidefinite, singular", &lcp(gram(&singular), b), &kinds);
        let A = p_matrix(&mut random, n);
        row("P-matrix, not symmetric", &lcp(A, random.vector(n)), &kinds);
        let A = monotone(&mut random, n, n / 2, false);
        row("monotone, not symmetric", &lcp(A, random.vector(n)), &kinds);
        row("convex quadratic program", &quadratic_program(&mut random, n / 2, n - n / 2, n / 3, true), &kinds);
    }
    for contacts in [1, 2, 8, 16] {
        let problem = touching_contacts(&mut Random(contacts as u64), contacts, 4, 6, contacts / 4);
        row("contacts with friction", &problem, &kinds);
    }
}

fn lcp(A: signorini_lcp::Matrix, b: Vec<f64>) -> Lcp {
    Lcp::new(A, b).expect("a square matrix of finite numbers")
}

fn row(name: &str, problem: &Lcp, kinds: &[MethodKind]) {
    print!("{name:34} {:4}", problem.len());
    for kind in kinds {
        if matches!(kind, MethodKind::Enumeration(_)) && problem.len() > MAX_ENUMERATED {
            print!(" {:>27}", "too large");
            continue;
        }
        let mut method = kind.build().expect("default settings");
        let solution = method.solve(problem, None);
        let microseconds = 1e6 * median_seconds(&mut *method, problem);
        print!(" {:>27}", format!("{} {:5} {microseconds:8.1} µs", ending(&solution), solution.iterations));
    }
    println!();
}

fn ending(solution: &Solution) -> &'static str {
    match solution.status {
        Status::Solved => "solved",
        Status::Infeasible(_) => "infeasible",
        Status::NoSolution => "none",
        Status::Ray(_) => "ray",
        Status::Refused(_) => "refused",
        Status::Stationary { .. } => "stationary",
        Status::IterationLimit => "limit",
        _ => "failed",
    }
}

fn median_seconds(method: &mut dyn Method, problem: &Lcp) -> f64 {
    let mut seconds: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(method.solve(std::hint::black_box(problem), None));
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
