//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use signorini::contact::{MOST_DIRECTIONS, SolverSettings};
use signorini::lcp::MethodKind;
use signorini::{ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, OverlapPolicy, Settings};
use signorini_generate::LENGTHS;

use crate::error::CliError;

/// Which model, and how its file is read.
#[derive(Clone, Debug, Args)]
pub struct ModelArguments {
    /// Model file, MJCF, URDF or SDF; a bundled scene where none is given.
    pub model: Option<PathBuf>,
    /// Bundled scene; `signorini scenes` lists them. A scene starts from its first keyframe. [default: house_of_cards]
    #[arg(long, value_name = "NAME", conflicts_with = "model")]
    pub scene: Option<String>,
    /// Let the root link of a URDF move freely instead of fixing it to the world.
    #[arg(long)]
    pub floating_base: bool,
    /// Folder in which packages of `package://` names (URDF) are looked for; can be given several times.
    #[arg(long, value_name = "DIR")]
    pub package_dir: Vec<PathBuf>,
    /// Coefficient of friction of the shapes of a URDF, which has no word for it.
    #[arg(long, value_name = "MU", default_value_t = 1.0)]
    pub friction: f64,
    /// Put a floor under a URDF or SDF, the plane z = 0; the friction of what stands on it counts.
    #[arg(long)]
    pub floor: bool,
    /// What becomes of a geom whose mesh file is not there: the model is refused (stop), or the geom is left out (skip).
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = MissingMeshArgument::Stop)]
    pub missing_meshes: MissingMeshArgument,
    /// Take meshes apart into convex parts of at most this concavity (in (0, 1]; 0.01 where none is given) instead of taking their hulls; the
    /// parts are kept in the folder signorini.parts beside the model.
    #[arg(long, value_name = "CONCAVITY", num_args = 0..=1, require_equals = true, default_missing_value = "0.01")]
    pub decompose: Option<f64>,
}

impl ModelArguments {
    /// The files that are named.
    pub fn files(&self) -> Vec<&Path> {
        self.model.iter().map(PathBuf::as_path).collect()
    }
}

/// What becomes of a geom whose mesh file is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MissingMeshArgument {
    /// The model is refused.
    Stop,
    /// The geom is left out.
    Skip,
}

/// The state to start from.
#[derive(Clone, Debug, Args)]
pub struct StartArguments {
    /// Start from this keyframe of the model.
    #[arg(long, value_name = "NAME")]
    pub keyframe: Option<String>,
    /// Set the position (NAME.q=1,2,…) or velocity (NAME.v=…) of a joint, or of all joints of a body; NAME=… is NAME.q=….
    /// A free joint takes x,y,z,qw,qx,qy,qz or just x,y,z. Quaternions are normalised. Can be given several times.
    #[arg(long = "set", value_name = "NAME.q=VALUES", value_parser = crate::assignment::parse)]
    pub assignments: Vec<crate::assignment::Assignment>,
    /// Bring this state to rest first: bodies fall, slide and tumble until they lie. The way there is no simulation and leaves the
    /// time as it is; at its end an ordinary step certifies that they rest.
    #[arg(long)]
    pub settle: bool,
}

/// How steps are made.
#[derive(Clone, Debug, Args)]
pub struct StepArguments {
    /// Time step in seconds; the model's own where it is not given.
    #[arg(long, alias = "timestep", value_name = "S", value_parser = positive)]
    pub dt: Option<f64>,
    /// Friction directions of every contact, an even number of at least 4.
    #[arg(long, value_name = "M", default_value_t = 8, value_parser = directions)]
    pub directions: usize,
    /// Solver: structured, or a general LCP method (automatic, lemke, enumeration, principal-pivoting, psor,
    /// newton-fischer-burmeister, newton-minimum).
    #[arg(long, value_name = "NAME", default_value = "structured", value_parser = MethodChoice::parse)]
    pub method: MethodChoice,
    /// Law of friction: the polygon's, the circular cone's, or polygons whose directions are turned into the slip until the
    /// circular cone's laws hold within --cone-tolerance. The last two need the structured solver and contacts as the only
    /// friction.
    #[arg(long, value_enum, default_value = "polygon")]
    pub friction_law: FrictionLawName,
    /// Bound on every residual of the circular cone's laws with --friction-law refined. [default: 1e-6]
    #[arg(long, value_name = "X", value_parser = fraction)]
    pub cone_tolerance: Option<f64>,
    /// Choice among the impulses that give the same motion: the solver's, or those of least norm.
    #[arg(long, value_enum, default_value = "solver")]
    pub impulses: ImpulseName,
    /// A step has missed its tolerance when a residual of its certificate is above this.
    #[arg(long, value_name = "X", default_value = "1e-9", value_parser = fraction)]
    pub tolerance: f64,
    /// Make at most so many contact sweeps in a step and go on with the best point found: quick, and its certificate says how far it is
    /// from the laws. A count and no clock: the same bits every time.
    #[arg(long, value_name = "SWEEPS", value_parser = clap::value_parser!(u32).range(1..))]
    pub budget: Option<u32>,
    /// Factor γ in (0, 1] on penetrations: the part of them that one step removes.
    #[arg(long, value_name = "γ", default_value = "1", value_parser = part)]
    pub stabilization: f64,
    /// Gaps and overlaps of at most this many metres count as closed: a ten-thousandth of a body's size, say, lets piles of hundreds of bodies come to rest.
    #[arg(long, value_name = "M", default_value = "0", value_parser = gap)]
    pub gap_resolution: f64,
    /// Where a step cannot remove all of its penetrations and violations: remove as much as the laws permit, stop, or take
    /// penetrations as zero.
    #[arg(long, value_enum, default_value = "go-on")]
    pub infeasible: InfeasibleName,
    /// Short for --infeasible clip-gaps.
    #[arg(long, conflicts_with = "infeasible")]
    pub clip_gaps: bool,
    /// Parts of one mechanism that overlap in its reference configuration: do not let them touch each other, keep them as
    /// contacts, or stop.
    #[arg(long, value_enum, default_value = "exclude")]
    pub overlaps: OverlapName,
    /// Speed in m/s at which overlaps and violations that come from outside are removed at most; `inf` for all in one step.
    #[arg(long, value_name = "M/S", default_value = "0.25", value_parser = speed)]
    pub correction_speed: f64,
    /// The same for angles, in rad/s.
    #[arg(long, value_name = "RAD/S", default_value = "1", value_parser = speed)]
    pub correction_angular_speed: f64,
}

impl StepArguments {
    /// The settings of a simulation.
    ///
    /// # Errors
    /// [`CliError::UnusedOption`] for a tolerance of a law that is not asked for.
    pub fn settings(&self) -> Result<Settings, CliError> {
        if self.cone_tolerance.is_some() && self.friction_law != FrictionLawName::Refined {
            return Err(CliError::UnusedOption { option: "--cone-tolerance", needs: "--friction-law refined" });
        }
        Ok(Settings::default()
            .with_timestep(self.dt)
            .with_directions(self.directions)
            .with_stabilization(self.stabilization)
            .with_gap_resolution(self.gap_resolution)
            .with_tolerance(self.tolerance)
            .with_budget(self.budget)
            .with_method(match &self.method {
                MethodChoice::Structured => ContactMethod::Structured(SolverSettings::default().with_time_stages(true)),
                MethodChoice::Lcp(kind) => ContactMethod::Lcp(kind.clone()),
            })
            .with_friction_law(match self.friction_law {
                FrictionLawName::Polygon => FrictionLaw::Polygon,
                FrictionLawName::Circular => FrictionLaw::Circular,
                FrictionLawName::Refined => {
                    FrictionLaw::Refined { tolerance: self.cone_tolerance.unwrap_or(DEFAULT_CONE_TOLERANCE) }
                }
            })
            .with_impulses(match self.impulses {
                ImpulseName::Solver => ImpulseChoice::Solver,
                ImpulseName::LeastNorm => ImpulseChoice::LeastNorm,
            })
            .with_correction_speed(self.correction_speed)
            .with_correction_angular_speed(self.correction_angular_speed)
            .with_overlaps(match self.overlaps {
                OverlapName::Exclude => OverlapPolicy::Exclude,
                OverlapName::Keep => OverlapPolicy::Keep,
                OverlapName::Stop => OverlapPolicy::Stop,
            })
            .with_infeasible(match self.infeasible {
                _ if self.clip_gaps => InfeasiblePolicy::ClipGaps,
                InfeasibleName::GoOn => InfeasiblePolicy::GoOn,
                InfeasibleName::Stop => InfeasiblePolicy::Stop,
                InfeasibleName::ClipGaps => InfeasiblePolicy::ClipGaps,
            }))
    }
}

/// Bound on the residuals of the circular cone's laws where directions are refined and none is given.
pub const DEFAULT_CONE_TOLERANCE: f64 = 1e-6;

/// What becomes of parts of one mechanism that overlap in its reference configuration, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OverlapName {
    /// They do not touch each other.
    Exclude,
    /// They are contacts like all others.
    Keep,
    /// The run does not begin.
    Stop,
}

/// What happens where a step cannot remove all of its penetrations and violations, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum InfeasibleName {
    /// It removes as much as the laws permit.
    GoOn,
    /// The run stops before it.
    Stop,
    /// Its penetrations are taken as zero.
    ClipGaps,
}

/// A law of friction by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FrictionLawName {
    /// Maximum dissipation over a polygon.
    Polygon,
    /// Coulomb's law with the circular cone.
    Circular,
    /// A polygon turned into the slip.
    Refined,
}

/// A choice among impulses by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ImpulseName {
    /// The solver's, near those of the step before.
    Solver,
    /// Those of least norm.
    LeastNorm,
}

/// A solver of the polygon's laws by name.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodChoice {
    /// The structured contact solver.
    Structured,
    /// A method for general LCPs.
    Lcp(MethodKind),
}

impl MethodChoice {
    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Self::Structured => "structured".into(),
            Self::Lcp(kind) => kind.to_string(),
        }
    }

    /// The method of this name.
    pub fn parse(name: &str) -> Result<Self, String> {
        if name == "structured" {
            return Ok(Self::Structured);
        }
        name.parse().map(Self::Lcp).map_err(|_| {
            let known: Vec<String> = MethodKind::all().iter().map(ToString::to_string).collect();
            format!("no method has this name; the methods are: structured, {}", known.join(", "))
        })
    }
}

/// A number of friction directions.
pub fn directions(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(count) if (4..=MOST_DIRECTIONS).contains(&count) && count.is_multiple_of(2) => Ok(count),
        _ => Err(format!("must be an even number from 4 to {MOST_DIRECTIONS}")),
    }
}

/// A positive finite number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("must be a positive number".into()),
    }
}

/// A number that is neither infinite nor NaN.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("must be a finite number".into()),
    }
}

/// A positive number, or `inf`.
fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 => Ok(x),
        _ => Err("must be a positive number or inf".into()),
    }
}

/// A gap that something counts as closed, in metres or radians: what is farther away than 1 is apart by any measure.
fn gap(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err("must be a gap from 0 to 1".into()),
    }
}

/// A gap within which shapes touch.
pub fn touching(text: &str) -> Result<f64, String> {
    gap(text).ok().filter(|x| *x > 0.0).ok_or_else(|| "must be a gap above 0 and at most 1".into())
}

/// A length of a world that is made, m.
pub fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if LENGTHS.contains(&x) => Ok(x),
        _ => Err(format!("must be a length in metres from {:e} to {:e}", LENGTHS.start(), LENGTHS.end())),
    }
}

/// A number in (0, 1].
fn part(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err("must be above 0 and at most 1".into()),
    }
}

/// A number in (0, 1).
pub fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x < 1.0 => Ok(x),
        _ => Err("must be between 0 and 1, both excluded".into()),
    }
}
