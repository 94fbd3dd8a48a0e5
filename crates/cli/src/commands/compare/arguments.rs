//! What a comparison is asked for.

use std::path::PathBuf;

use clap::Args;

use crate::args::{directions, fraction, positive};
use crate::solving::Options;

const EXAMPLE: &str = "\
Examples:
  signorini compare problem.npz
  signorini compare problem.npz --directions 4,32 --repetitions 9 --json
  signorini compare large.npz --time-limit 60 --max-rows 10000

Laws: the polygons of the file, regular ones with --directions, the circular cone (solved as such, and by refined polygons),
and the convex relaxation, each with every method that there is for it. For kinds lcp and mlcp the methods alone; for
frictional problems the polygons and the circular cone.

Columns: status of the row's own law and its worst residual; the worst residual of the circular cone's laws; the median time
of a cold solve; iterations; the largest difference of the velocity from the reference, relative to the velocity scale of
the data (for kinds lcp and mlcp of z, relative to its largest entry). The reference is the first row that is solved.

Methods on dense matrices are skipped above --max-rows, and a row is stopped after --time-limit; the same method is then not
tried on larger problems. The exit code is 0 if any row is solved, else 2.";

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem file.
    #[arg(value_name = "PROBLEM.npz")]
    pub problem: PathBuf,
    /// Friction directions of the regular polygons beside the file's own.
    #[arg(long, value_name = "M,…", value_delimiter = ',', default_value = "4,8,16", value_parser = directions)]
    pub directions: Vec<usize>,
    /// A row is solved when every residual is at most this; refinement goes on until the circular cone's laws hold within it.
    #[arg(long, value_name = "X", default_value = "1e-8", value_parser = fraction)]
    pub tol: f64,
    /// Solves of each row; their median time is shown. Fewer where they take more than half of the time limit.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub repetitions: u32,
    /// Seconds after which a row is stopped.
    #[arg(long, value_name = "S", default_value = "10", value_parser = positive)]
    pub time_limit: f64,
    /// Complementarity problems with more rows are not given to methods on dense matrices.
    #[arg(long, value_name = "N", default_value_t = 3000)]
    pub max_rows: usize,
    /// Solve this row alone and print it; how the rows of a comparison run.
    #[arg(long, hide = true, value_name = "K")]
    pub row: Option<usize>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// The options of each solve.
    pub fn options(&self) -> Options {
        Options { tolerance: self.tol, cone_tolerance: self.tol, least_norm: false, ranges: false, history: false }
    }
}
