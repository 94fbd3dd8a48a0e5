//! How many factorisations of the active block does Lemke's method cost?
//!
//! The basis of the solution given as warm start makes the method do one LU of the active block, its refinement and
//! the residual, and nothing else: the time any method needs at least. The ratio cold/warm is the price of the search.
#![allow(non_snake_case, dead_code)]

#[path = "../tests/it/contact_data.rs"]
mod contact_data;
#[path = "../tests/it/support.rs"]
mod support;

use std::time::Instant;

use signorini_lcp::{Basis, Lcp, Lemke, Method};
use support::{Random, touching_contacts};

const PUBLIC: &[&str] = &[
    "synthetic/syn007_box",
    "synthetic/syn016_box",
    "synthetic/syn094_articulated",
    "synthetic/syn105_articulated",
    "synthetic/syn036_stack",
    "synthetic/syn041_stack",
    "synthetic/syn034_stack",
    "synthetic/syn058_pyramid",
    "synthetic/syn067_cluster",
    "synthetic/syn069_cluster",
    "Rover1040",
    "Capsules-i101-404",
];

fn main() {
    println!(
        "{:34} {:>5} {:>6} {:>7} {:>11} {:>11} {:>6}",
        "problem", "n", "active", "pivots", "lemke µs", "one LU µs", "ratio"
    );
    for (nc, nv) in [(4, 6), (8, 12), (16, 24), (40, 60)] {
        let problem = touching_contacts(&mut Random(nc as u64), nc, 4, nv, nc / 4);
        measure(&format!("random, {nc} contacts"), &problem);
    }
    let Some(folder) = contact_data::folder() else {
        return;
    };
    for name in PUBLIC {
        for named in contact_data::lcps(&folder.join(format!("{name}.npz")), 1500) {
            measure(&named.name, &named.problem);
        }
    }
}

fn measure(name: &str, problem: &Lcp) {
    let mut lemke = Lemke::default();
    let solution = lemke.solve(problem, None);
    if !solution.status.is_solved() {
        println!("{name:34} {:?}", solution.status);
        return;
    }
    let cold = median_seconds(&mut lemke, problem, None);
    let warm = median_seconds(&mut lemke, problem, Some(&solution.basis));
    println!(
        "{name:34} {:5} {:6} {:7} {:11.1} {:11.1} {:6.1}",
        problem.len(),
        solution.basis.active().len(),
        solution.iterations,
        1e6 * cold,
        1e6 * warm,
        cold / warm
    );
}

fn median_seconds(lemke: &mut Lemke, problem: &Lcp, warm: Option<&Basis>) -> f64 {
    let mut seconds: Vec<f64> = (0..15)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(lemke.solve(std::hint::black_box(problem), warm));
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
