//! Solves contact LCPs with our solver and, with `--peers`, with those of Siconos and Drake, and prints who solves how much,
//! how exactly, and how fast. See `benchmarks/contact_lcp/README.md`.

use std::error::Error;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Parser;
use signorini::contact::problem_file;
use signorini_benchmarks::contact_lcp::{Limits, Problem, Record, Session, Spec, print_all, serve};
use signorini_benchmarks::table;

/// Number of boxes and bodies in the series of growing size: up to 2,000 contacts.
const STACKS: [usize; 8] = [2, 5, 10, 20, 50, 100, 200, 500];
const CLUSTERS: [usize; 8] = [5, 10, 20, 40, 80, 160, 320, 500];

/// Solves contact LCPs, cold and warm, and prints tables.
#[derive(Parser)]
struct Options {
    /// More problem files
    files: Vec<PathBuf>,
    /// Seeds of the list of problems, "first..last" with both ends; the list has 154 entries and repeats with other seeds
    #[arg(long, default_value = "0..153")]
    seeds: String,
    /// Friction directions with which every problem is solved
    #[arg(long, value_delimiter = ',', default_values_t = [4, 8, 16])]
    directions: Vec<usize>,
    /// Leave out the list
    #[arg(long)]
    no_list: bool,
    /// Leave out the series of growing stacks and clusters
    #[arg(long)]
    no_growth: bool,
    /// Leave out the files of ../shared/data/contact_problems beside the repository
    #[arg(long)]
    no_shared: bool,
    /// Skip problems with more contacts
    #[arg(long, default_value_t = usize::MAX)]
    most_contacts: usize,
    /// Run the peers, too; `benchmarks/contact_lcp/peers.py --install` installs them
    #[arg(long)]
    peers: bool,
    /// Standard LCPs up to this size are given to the peers; beyond it no LCP is formed
    #[arg(long, default_value_t = 2000)]
    peer_size: usize,
    /// Factor on the peers' limits of CPU time
    #[arg(long, default_value_t = 1.0)]
    peer_factor: f64,
    /// Seconds that our solver has for one problem
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Rounds in which everybody gets one turn at a problem
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Seconds of a turn
    #[arg(long, default_value_t = 0.01)]
    turn: f64,
    /// Append one JSON object per problem to this file
    #[arg(long)]
    records: Option<PathBuf>,
    /// Solve nothing and print the tables of the records
    #[arg(long, requires = "records")]
    tables: bool,
    /// Save problems that our solver neither solved nor rightly denied in this folder
    #[arg(long)]
    save_failures: Option<PathBuf>,
    /// A few small problems only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
    /// Answer requests of this program itself
    #[arg(long, hide = true)]
    serve: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    if options.serve {
        return serve();
    }
    if let Some(path) = options.records.as_ref().filter(|_| options.tables) {
        let lines = BufReader::new(File::open(path)?).lines();
        let records: Vec<Record> =
            lines.map(|line| Ok(serde_json::from_str(&line?)?)).collect::<Result<_, Box<dyn Error>>>()?;
        print_all(&records);
        return Ok(());
    }
    let mut session = session(&options)?;
    let mut output =
        options.records.as_ref().map(|path| File::options().create(true).append(true).open(path)).transpose()?;
    let mut records = Vec::new();
    let specs = specs(&options)?;
    for (k, spec) in specs.iter().enumerate() {
        match session.measure(spec, options.most_contacts) {
            Ok(Some(record)) => {
                eprintln!("{:4} of {} {}", k + 1, specs.len(), summary(&record));
                if let Some(file) = &mut output {
                    writeln!(file, "{}", serde_json::to_string(&record)?)?;
                }
                save_failure(&options, spec, &record)?;
                records.push(record);
            }
            Ok(None) => {}
            Err(error) => println!("left out: {spec}: {error}"),
        }
    }
    print_all(&records);
    Ok(())
}

fn session(options: &Options) -> Result<Session, Box<dyn Error>> {
    let limits = Limits {
        rounds: if options.smoke { 1 } else { options.rounds },
        turn: options.turn,
        own: options.limit,
        peer_factor: options.peer_factor,
        peer_size: options.peer_size,
    };
    let mut own = Command::new(std::env::current_exe()?);
    own.arg("--serve");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = folder.join("../build/peers/venv/bin/python");
    let peers = options.peers && python.exists();
    if options.peers && !peers {
        println!("The peers are absent; benchmarks/contact_lcp/peers.py --install installs them.");
    }
    let mut command = Command::new(&python);
    command.arg(folder.join("contact_lcp/peers.py"));
    let session = Session::new(own, peers.then_some(command), limits)?;
    println!("peers: {}", if session.solvers.is_empty() { "none".to_owned() } else { session.solvers.join(", ") });
    Ok(session)
}

/// The problems of a run, in order.
fn specs(options: &Options) -> Result<Vec<Spec>, Box<dyn Error>> {
    let mut specs = Vec::new();
    if options.smoke {
        // One of each family.
        let seeds = [0, 27, 48, 55, 63, 94, 118, 123, 127, 139, 145, 147];
        specs.extend(seeds.map(|seed| Spec::list(seed, 4)));
        specs.extend([2, 5].map(|boxes| Spec::stack(boxes, 4)));
        return Ok(specs);
    }
    let (first, last) = options.seeds.split_once("..").ok_or("--seeds wants two numbers like 0..153")?;
    let (first, last): (u32, u32) = (first.parse()?, last.parse()?);
    for seed in (first..=last).filter(|_| !options.no_list) {
        specs.extend(options.directions.iter().map(|&m| Spec::list(seed, m)));
    }
    for file in &options.files {
        specs.extend(options.directions.iter().map(|&m| Spec::file(file.clone(), m)));
    }
    let folder = table::shared("data/contact_problems");
    if !options.no_shared && folder.is_dir() {
        specs.extend(files(&folder, options)?);
    } else if !options.no_shared {
        println!("skipped: no problems in {}", folder.display());
    }
    if !options.no_growth {
        specs.extend(STACKS.map(|boxes| Spec::stack(boxes, 4)));
        specs.extend(CLUSTERS.map(|bodies| Spec::cluster(bodies, 4)));
    }
    Ok(specs)
}

/// The problems of a folder. Those without contacts, and those in the plane, have no choice of directions.
fn files(folder: &Path, options: &Options) -> Result<Vec<Spec>, Box<dyn Error>> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        paths.push(entry?.path());
    }
    paths.retain(|path| path.extension() == Some(OsStr::new("npz")));
    paths.sort();
    let mut specs = Vec::new();
    for path in paths {
        let kind = signorini_npz::Archive::read(&path)?.string("kind")?;
        let count = if kind == "frictional3d" || kind == "contact" { options.directions.len() } else { 1 };
        specs.extend(options.directions.iter().take(count).map(|&m| Spec::file(path.clone(), m)));
    }
    Ok(specs)
}

fn summary(record: &Record) -> String {
    let time = record.cold.seconds.map_or("–".to_owned(), |s| format!("{:.1} us", 1e6 * s));
    let residual = record.cold.residual.unwrap_or(f64::NAN);
    format!("{} n {} cold {} {residual:.1e} {time}", record.name, record.size, record.cold.status)
}

/// Writes a problem that our solver neither solved nor denied, or denied although it has a solution.
fn save_failure(options: &Options, spec: &Spec, record: &Record) -> Result<(), Box<dyn Error>> {
    let failed = !record.cold.solves() && (record.is_solvable() || !record.is_denied());
    let Some(folder) = options.save_failures.as_ref().filter(|_| failed) else {
        return Ok(());
    };
    if let Problem::Contact(problem) = spec.build()? {
        let name: String = spec.to_string().chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        problem_file::write_contact(folder.join(format!("{name}.npz")), &problem)?;
    }
    Ok(())
}
