//! Replays recorded tosses of a real cube and prints how far the simulation is from them, beside other engines.
//! See `benchmarks/cube_toss/README.md`.

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use cpu_time::ProcessTime;
use signorini::multibody::Model;
use signorini::{InfeasiblePolicy, RestitutionLaw, Settings};
use signorini_benchmarks::table;
use signorini_benchmarks::toss_fit::{Fit, Quantity};
use signorini_benchmarks::tosses::{self, Effort, HALF_SIDE, IDENTIFICATION, Protocol, Toss, TossError};

/// Mean position error (% of the cube's width) and rotation error (degrees) of other engines, friction identified on
/// the same 50 tosses, 150 other tosses, 10 substeps unless the name says otherwise; measured with the peers' own
/// scripts.
const PEERS: [(&str, f64, f64); 10] = [
    ("LCP, Poisson restitution, 16 directions, 2 substeps", 13.7, 18.6),
    ("MuJoCo, elliptic cone", 13.9, 17.7),
    ("Drake, lagged", 14.4, 16.3),
    ("Drake, SAP", 14.4, 17.9),
    ("Bullet, soft contact", 14.5, 16.6),
    ("Bullet, rigid, restitution", 15.1, 17.0),
    ("LCP, Poisson restitution, 8 directions", 15.7, 18.1),
    ("LCP, no restitution, 8 directions", 17.9, 17.4),
    ("MuJoCo, default (4-sided pyramid)", 22.4, 21.5),
    ("DART, Dantzig (box friction)", 26.1, 18.8),
];

/// Replays recorded cube tosses: identifies the friction on 50 of them, scores the others.
#[derive(Parser)]
struct Options {
    /// Folder with cube_tosses.npz [default: ../shared/data/cube_tosses beside the repository]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Friction directions
    #[arg(long, default_value_t = 16)]
    directions: usize,
    /// Angle of the first friction direction from the world's x axis, degrees
    #[arg(long, default_value_t = 0.0)]
    direction_angle: f64,
    /// Steps between two samples of the recording (148 Hz)
    #[arg(long, default_value_t = 10)]
    substeps: usize,
    /// Factor on the correction of penetrations, in (0, 1]
    #[arg(long, default_value_t = 1.0)]
    stabilization: f64,
    /// What is done to the recording before it is compared
    #[arg(long, value_enum, default_value = "raw")]
    protocol: Protocol,
    /// Friction; identified where it is not given
    #[arg(long)]
    mu: Option<f64>,
    /// Law of restitution; without one nothing bounces
    #[arg(long, value_enum, default_value = "none")]
    law: Law,
    /// Coefficient of restitution; identified where it is not given
    #[arg(long)]
    restitution: Option<f64>,
    /// Identify by the derivatives of the steps what is named, beside the grid's friction
    #[arg(long, value_enum, value_delimiter = ',')]
    by_gradient: Vec<Quantity>,
    /// Steps between two samples while identifying by derivatives
    #[arg(long, default_value_t = 1)]
    fit_substeps: usize,
    /// Samples of the windows in which trajectories are predicted while identifying by derivatives, stage by stage; 0 for whole tosses
    #[arg(long, value_delimiter = ',', default_value = "16,0")]
    windows: Vec<usize>,
    /// Steps of the method in each stage at most
    #[arg(long, default_value_t = 6)]
    iterations: usize,
    /// Friction and restitution that the identification by derivatives begins with
    #[arg(long, value_delimiter = ',', default_value = "0.4,0")]
    begin: Vec<f64>,
    /// Sets drawn for the covariance that the identification by derivatives reports; none for the spread of slopes
    #[arg(long, default_value_t = 0)]
    draws: usize,
    /// Print every step of the identification by derivatives
    #[arg(long)]
    steps: bool,
    /// Leave out the grid
    #[arg(long)]
    no_grid: bool,
    /// Frictions within the bounds that are looked at before slopes are followed
    #[arg(long, default_value_t = 0)]
    starts: usize,
    /// Sets drawn from the tosses of the identification, each fitted, beside the covariance of the fit by derivatives
    #[arg(long, default_value_t = 0)]
    bootstrap: usize,
    /// A few tosses only, one friction: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Law {
    None,
    Newton,
    Poisson,
}

/// Coefficients of friction and restitution.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Surface {
    mu: f64,
    restitution: f64,
}

/// Sums over a set of tosses.
#[derive(Clone, Debug, Default)]
struct Score {
    errors: Vec<TossError>,
    effort: Effort,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let folder = options.data.clone().unwrap_or_else(|| table::shared("data/cube_tosses"));
    if !folder.join("cube_tosses.npz").exists() {
        println!("skipped: no cube_tosses.npz in {}", folder.display());
        return Ok(());
    }
    let all = tosses::load(&folder, options.protocol)?;
    let (mut identification, mut others) = split(all);
    if options.smoke {
        identification.truncate(3);
        others.truncate(6);
    }
    if !options.by_gradient.is_empty() {
        by_gradient(&options, &identification, &others)?;
    }
    if options.no_grid {
        return Ok(());
    }
    let begin = ProcessTime::now();
    let surface = identify(&options, &identification)?;
    println!("grid: {:.2} s of processor", begin.elapsed().as_secs_f64());
    let Surface { mu, restitution } = surface;
    let train = score(&options, surface, &identification)?;
    println!(
        "friction {mu:.4}, restitution {restitution:.4}; on {} tosses of the identification: {}",
        identification.len(),
        in_words(&train)
    );
    let test = score(&options, surface, &others)?;
    println!("on {} other tosses: {}\n", others.len(), in_words(&test));
    print_detail(&test);
    print!("{}", comparison(&options, &test));
    Ok(())
}

/// Identifies by derivatives, and scores the others with what was found.
fn by_gradient(options: &Options, identification: &[Toss], others: &[Toss]) -> Result<(), Box<dyn Error>> {
    let fit = Fit {
        quantities: options.by_gradient.clone(),
        directions: options.directions,
        substeps: options.fit_substeps,
        protocol: options.protocol,
        starts: options.starts,
        windows: options.windows.clone(),
        iterations: options.iterations,
        draws: options.draws,
        is_told: options.steps,
    };
    let begin = ProcessTime::now();
    let [mu, restitution] = options.begin[..] else { return Err("--begin takes two numbers".into()) };
    let found = fit.run(&tosses::model(mu, restitution)?, identification)?;
    let seconds = begin.elapsed().as_secs_f64();
    let deviations = match options.bootstrap {
        0 => Vec::new(),
        draws => fit.bootstrap(&found.model, identification, draws)?,
    };
    println!("by derivatives: {seconds:.2} s of processor, {} of {} steps without one", found.steps[1], found.steps[0]);
    let n = found.values.len();
    for (i, value) in found.values.iter().enumerate() {
        let reported = found.covariance[i * n + i].sqrt();
        let drawn = deviations.get(i).map_or(String::new(), |d| format!(", of drawn sets {d:.2e}"));
        let note = if found.determined[i] { "" } else { " (not determined)" };
        println!("  {i}: {value:.6}, standard deviation {reported:.2e}{drawn}{note}");
    }
    for (name, tosses) in [("of the identification", identification), ("others", others)] {
        let score = score_of(options, found.model.clone(), tosses)?;
        println!("  on {} tosses {name}: {}", tosses.len(), in_words(&score));
    }
    Ok(())
}

/// The tosses of the identification, and the others.
fn split(all: Vec<Toss>) -> (Vec<Toss>, Vec<Toss>) {
    let mut parts = (Vec::new(), Vec::new());
    for (k, toss) in all.into_iter().enumerate() {
        let part = if IDENTIFICATION.contains(&k) { &mut parts.0 } else { &mut parts.1 };
        part.push(toss);
    }
    parts
}

/// The friction and restitution with the least [`Score::objective`]. Tosses are chaotic and the objective is rough, so the
/// friction from 0.02 to 0.6 and the restitution from 0 to 0.5 are searched on a grid, and its best neighbourhood again on two
/// finer ones.
fn identify(options: &Options, tosses: &[Toss]) -> Result<Surface, Box<dyn Error>> {
    let fixed_e = if options.law == Law::None { Some(0.0) } else { options.restitution };
    let grids: &[(i32, f64, f64)] = match (options.smoke, fixed_e) {
        (true, _) => &[(2, 0.04, 0.1)],
        (false, Some(_)) => &[(14, 0.02, 0.0), (4, 0.004, 0.0), (4, 0.001, 0.0)],
        (false, None) => &[(7, 0.04, 0.05), (3, 0.01, 0.02), (2, 0.004, 0.01)],
    };
    let mut center = Surface { mu: if options.smoke { 0.18 } else { 0.31 }, restitution: 0.25 };
    let mut best = (f64::INFINITY, center);
    for &(half, friction_spacing, restitution_spacing) in grids {
        let values = |fixed: Option<f64>, center: f64, spacing: f64, half: i32| match fixed {
            Some(value) => vec![value],
            None => (-half..=half).map(|k| center + f64::from(k) * spacing).collect::<Vec<f64>>(),
        };
        for mu in values(options.mu, center.mu, friction_spacing, half) {
            for restitution in values(fixed_e, center.restitution, restitution_spacing, half.min(5)) {
                let surface = Surface { mu, restitution };
                if mu <= 0.0 || !(0.0..=1.0).contains(&restitution) {
                    continue;
                }
                let objective = score(options, surface, tosses)?.objective();
                if objective < best.0 {
                    best = (objective, surface);
                }
            }
        }
        center = best.1;
    }
    Ok(best.1)
}

fn score(options: &Options, surface: Surface, tosses: &[Toss]) -> Result<Score, Box<dyn Error>> {
    score_of(options, tosses::model(surface.mu, surface.restitution)?, tosses)
}

fn score_of(options: &Options, model: Model, tosses: &[Toss]) -> Result<Score, Box<dyn Error>> {
    let settings = Settings::default()
        .with_directions(options.directions)
        .with_direction_angle(options.direction_angle.to_radians())
        .with_stabilization(options.stabilization)
        .with_infeasible(InfeasiblePolicy::ClipGaps)
        .with_restitution(if options.law == Law::Poisson { RestitutionLaw::Poisson } else { RestitutionLaw::Newton });
    let mut simulation = tosses::simulation_of(model, options.substeps, &settings)?;
    let mut score = Score::default();
    for toss in tosses {
        let (poses, effort) = tosses::simulate(&mut simulation, toss, options.protocol, options.substeps)?;
        score.errors.push(tosses::compare(&poses, toss));
        score.effort.add(&effort);
    }
    Ok(score)
}

impl Score {
    /// Mean and standard error of a quantity over the tosses.
    fn mean(&self, quantity: impl Fn(&TossError) -> f64) -> (f64, f64) {
        let n = self.errors.len() as f64;
        let mean = self.errors.iter().map(&quantity).sum::<f64>() / n;
        let variance = self.errors.iter().map(|e| (quantity(e) - mean).powi(2)).sum::<f64>() / n;
        (mean, (variance / n).sqrt())
    }

    /// Mean position error and its standard error, % of the cube's width.
    fn position_percent(&self) -> (f64, f64) {
        self.mean(|e| 100.0 * e.position / (2.0 * HALF_SIDE))
    }

    /// Mean rotation error and its standard error, degrees.
    fn rotation_degrees(&self) -> (f64, f64) {
        self.mean(|e| e.rotation)
    }

    /// Position error over the width plus rotation error in radians.
    fn objective(&self) -> f64 {
        self.position_percent().0 / 100.0 + self.rotation_degrees().0.to_radians()
    }
}

fn in_words(score: &Score) -> String {
    let (position, rotation) = (score.position_percent(), score.rotation_degrees());
    format!("position {:.1} ± {:.1} %, rotation {:.1} ± {:.1}°", position.0, position.1, rotation.0, rotation.1)
}

fn print_detail(score: &Score) {
    let effort = &score.effort;
    let faces = 100.0 * score.mean(|e| f64::from(e.same_face)).0;
    let end = score.mean(|e| 100.0 * e.end_position / (2.0 * HALF_SIDE)).0;
    let deepest = score.errors.iter().map(|e| e.penetration).fold(0.0, f64::max);
    println!("at the last sample: {end:.1} % of the width away, same face up in {faces:.0} % of the tosses");
    println!(
        "steps {}, missed tolerance {}, clipped {}, tosses stopped {}, worst residual {:.1e}",
        effort.steps, effort.missed_steps, effort.clipped_steps, effort.stopped_tosses, effort.worst_residual
    );
    println!(
        "deepest corner {:.3} mm below the board; {:.1} us for a step\n",
        1e3 * deepest,
        1e6 * effort.seconds / effort.steps.max(1) as f64
    );
}

/// The table of all engines, best position first.
fn comparison(options: &Options, test: &Score) -> String {
    let law = match options.law {
        Law::None => "no restitution",
        Law::Newton => "Newton's restitution",
        Law::Poisson => "Poisson's restitution",
    };
    let own = format!("signorini, {law}, {} directions, {} substeps", options.directions, options.substeps);
    let mut entries: Vec<(String, f64, f64)> = PEERS.map(|(name, x, r)| (name.to_owned(), x, r)).to_vec();
    entries.push((format!("**{own}**"), test.position_percent().0, test.rotation_degrees().0));
    entries.sort_by(|a, b| a.1.total_cmp(&b.1));
    let header = vec!["engine".to_owned(), "position %".to_owned(), "rotation °".to_owned()];
    let rows = entries.into_iter().map(|(name, x, r)| vec![name, format!("{x:.1}"), format!("{r:.1}")]);
    table::markdown(&std::iter::once(header).chain(rows).collect::<Vec<_>>())
}
