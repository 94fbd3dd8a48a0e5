//! `signorini-check PROBLEM.npz SOLUTION.npz [TOLERANCE [DIRECTIONS]]`: which laws hold. Exit code 0 if all do, 1 if not, 2 for wrong input.

use std::path::PathBuf;
use std::process::ExitCode;

use signorini_check::{Checked, check};

const USAGE: &str = "usage: signorini-check PROBLEM.npz SOLUTION.npz [TOLERANCE [DIRECTIONS]]
  TOLERANCE   a law holds when its residual is at most this, default 1e-8
  DIRECTIONS  friction directions of every contact, where the solution was made with others than the file's";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match run(&words) {
        Ok((checked, tolerance)) => {
            let violated = checked.violated(tolerance);
            for (name, residual) in &checked.residuals {
                println!("{name:12} {residual:9.2e}  {}", if violated.contains(name) { "violated" } else { "holds" });
            }
            ExitCode::from(u8::from(!violated.is_empty()))
        }
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn run(words: &[String]) -> Result<(Checked, f64), String> {
    let ([problem, solution], options) = words.split_first_chunk().ok_or(USAGE)?;
    if options.len() > 2 {
        return Err(USAGE.into());
    }
    let tolerance = match options.first() {
        None => 1e-8,
        Some(word) => word.parse().ok().filter(|x| (0.0..1.0).contains(x)).ok_or("TOLERANCE must be in [0, 1)")?,
    };
    let directions = options.get(1).map(|word| word.parse().map_err(|_| "DIRECTIONS must be a number"));
    let checked = check(&PathBuf::from(problem), &PathBuf::from(solution), directions.transpose()?);
    checked.map(|checked| (checked, tolerance)).map_err(|error| error.to_string())
}
