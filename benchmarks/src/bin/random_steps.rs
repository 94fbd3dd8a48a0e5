//! Solves small random contact problems by the million, one after another from the solution before, and counts what became of
//! them. See `benchmarks/random_steps/README.md`.

use std::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use serde::{Deserialize, Serialize};
use signorini::contact::problem_file::write_contact;
use signorini_benchmarks::random_steps::{FAMILIES, Limits, Outcome, Tally, Trial, print_tables, run, sequence};

/// Files of failures that one chunk of seeds may write.
const MOST_FILES: usize = 200;

/// Solves random contact problems and judges the answers independently.
#[derive(Parser)]
struct Options {
    /// Seeds "first..end", the end excluded; a seed stands for one to five problems
    #[arg(long, default_value = "0..100000")]
    seeds: String,
    /// Seeds of a chunk; after each a line is appended to the records
    #[arg(long, default_value_t = 20_000)]
    chunk: u64,
    /// Append the counts of each chunk to this file and leave out the chunks that it has
    #[arg(long)]
    records: Option<PathBuf>,
    /// Threads
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds of wall time for one seed
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Examine what was not solved with linear programs for every so many seeds; Lemke's method always looks at it
    #[arg(long, default_value_t = 500)]
    examine_every: u64,
    /// Linear programs for one problem at most
    #[arg(long, default_value_t = 200)]
    programs: usize,
    /// Rows of the problems that are examined with linear programs
    #[arg(long, default_value_t = 24)]
    examined_rows: usize,
    /// Save problems that failed in this folder
    #[arg(long)]
    save: Option<PathBuf>,
    /// A few hundred problems only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

/// A chunk of seeds.
#[derive(Serialize, Deserialize)]
struct Record {
    first: u64,
    end: u64,
    tallies: Vec<Tally>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let (first, end) = if options.smoke { (0, 900) } else { seeds(&options.seeds)? };
    let limits = Limits {
        threads: options.threads,
        seconds: options.limit,
        examine_every: options.examine_every,
        programs: options.programs,
        examined_rows: options.examined_rows,
    };
    let mut total = vec![Tally::default(); FAMILIES.len()];
    let mut known = Vec::new();
    if let Some(path) = options.records.as_ref().filter(|path| path.exists()) {
        for line in BufReader::new(File::open(path)?).lines() {
            let record: Record = serde_json::from_str(&line?)?;
            merge(&mut total, &record.tallies);
            known.push((record.first, record.end));
        }
    }
    let mut output =
        options.records.as_ref().map(|path| File::options().create(true).append(true).open(path)).transpose()?;
    let chunk = options.chunk.max(1);
    for from in (first..end).step_by(chunk as usize) {
        let record = (from, end.min(from + chunk));
        if known.contains(&record) {
            continue;
        }
        let (begin, mut files) = (Instant::now(), 0);
        let tallies = run(record.0..record.1, limits, |trial| {
            if trial.outcome.is_failure() {
                println!("{}", line(trial));
                if let Some(folder) =
                    options.save.as_ref().filter(|_| files < MOST_FILES && trial.outcome != Outcome::Unclaimed)
                {
                    files += 1;
                    if let Err(error) = save(folder, trial) {
                        eprintln!("not saved: {error}");
                    }
                }
            }
        });
        let problems: u64 = tallies.iter().map(|tally| tally.problems).sum();
        eprintln!("seeds {}..{}: {problems} problems in {:.1?}", record.0, record.1, begin.elapsed());
        merge(&mut total, &tallies);
        if let Some(file) = &mut output {
            writeln!(file, "{}", serde_json::to_string(&Record { first: record.0, end: record.1, tallies })?)?;
        }
    }
    print_tables(&total);
    Ok(())
}

fn seeds(text: &str) -> Result<(u64, u64), Box<dyn Error>> {
    let (first, end) = text.split_once("..").ok_or("--seeds wants two numbers like 0..100000")?;
    Ok((first.parse()?, end.parse()?))
}

fn merge(total: &mut [Tally], tallies: &[Tally]) {
    total.iter_mut().zip(tallies).for_each(|(total, tally)| total.merge(tally));
}

fn line(trial: &Trial) -> String {
    format!(
        "seed {} step {} {}, {} rows: {:?}, solver says {}, residual {:.1e}, {:.0} us, {:?}",
        trial.seed,
        trial.step,
        FAMILIES[trial.family],
        trial.rows,
        trial.outcome,
        if trial.status.is_empty() { "nothing" } else { &trial.status },
        trial.residual,
        1e6 * trial.seconds,
        trial.certificate,
    )
}

/// Writes the problems of a sequence up to the one that failed: each is started from the solution before.
fn save(folder: &Path, trial: &Trial) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for (step, data) in sequence(trial.seed).steps.iter().enumerate().take(trial.step + 1) {
        write_contact(folder.join(format!("{}_{step}.npz", trial.seed)), &data.problem)?;
    }
    Ok(())
}
