//! Checks contact points of many random and degenerate pairs against an independent method, and prints the largest deviations.
//!
//!     cargo run --release -p signorini-collision --example cross_check -- [PAIRS] [SEED]
//!
//! The checks are those of the test `cross_check`. The exit code is 1 if a pair deviates more than the documentation of the crate says.

#[path = "../tests/it/cross_check/mod.rs"]
mod cross_check;
#[allow(dead_code, unused_imports)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code, unused_imports)]
#[path = "../tests/it/scene.rs"]
mod scene;
#[allow(dead_code)]
#[path = "../tests/it/support.rs"]
mod support;

use std::process::ExitCode;

use cross_check::{Deviation, Kind, MODES, check, pair, within};

/// Pairs that are printed in full.
const SHOWN: usize = 20;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<u64>().expect("a number"));
    let (pairs, seed) = (arguments.next().unwrap_or(100_000), arguments.next().unwrap_or(1));
    let kinds: Vec<(Kind, Kind)> =
        Kind::all().enumerate().flat_map(|(i, a)| Kind::all().skip(i.max(1)).map(move |b| (a, b))).collect();
    let rounds = pairs.div_ceil((kinds.len() * MODES.len()) as u64);
    println!(
        "| pair | checked | beyond reach | gap | shortfall | outside | normal | invariance | turned | twice | proven | wrong |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    let (mut total, mut failures) = (0, Vec::new());
    for &(a, b) in &kinds {
        let (mut worst, mut checked, mut far, mut proven, mut wrong) = (Deviation::default(), 0, 0, 0, 0);
        for mode in MODES {
            for round in 0..rounds {
                let pair = pair(a, b, mode, seed << 32 | round);
                let Some(found) = check(&pair) else {
                    far += 1;
                    continue;
                };
                checked += 1;
                proven += u64::from(found.proven);
                worst.merge(&found);
                if !within(&pair, &found) {
                    wrong += 1;
                    failures.push((mode, found, pair));
                }
            }
        }
        total += checked + far;
        println!(
            "| {a:?}–{b:?} | {checked} | {far} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {} | {proven} | {wrong} |",
            worst.gap, worst.shortfall, worst.outside, worst.common_normal, worst.invariance, worst.turned, worst.twice,
        );
    }
    println!("\n{total} pairs, {} wrong", failures.len());
    for (mode, found, pair) in failures.iter().take(SHOWN) {
        println!("{mode:?} {found:?}\n    {pair:?}");
    }
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
