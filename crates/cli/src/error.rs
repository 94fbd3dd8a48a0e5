//! What can go wrong, in words for people.

use std::path::{Path, PathBuf};

use signorini::SimulationError;
use signorini::contact::ProblemError;
use signorini::formats::FormatError;
use signorini::multibody::StateError;
use signorini::recording::RecordingError;
use signorini::render::RenderError;
use signorini::viewer::ViewerError;
use signorini_check::CheckError;
use signorini_generate::GenerateError;
use signorini_replay::ReplayError;

use crate::exit::Exit;

/// Input that a command cannot use. Every message says where and what to do.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// A model file.
    #[error(transparent)]
    Model(Box<FormatError>),
    /// A recording in the place of a model.
    #[error("{}: this is a recording, and no model; `signorini replay` shows it, `signorini convert` and `signorini check` read it", path.display())]
    NoModel {
        /// The recording.
        path: PathBuf,
    },
    /// Settings, keyframe or state of a simulation.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The run broke down on the way; what was recorded up to there is kept.
    #[error("at t = {time} s: {source}")]
    Step {
        /// Time at the beginning of the step.
        time: f64,
        /// What is wrong.
        source: SimulationError,
    },
    /// A problem or solution file. The path is given where the error itself does not name it.
    #[error("{}{source}", prefix(path, source))]
    Problem {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<ProblemError>,
    },
    /// A recording or report.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// What is done with a recording.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A recording in which no step can be checked.
    #[error("{}: it holds no step", path.display())]
    NoSteps {
        /// The recording.
        path: PathBuf,
    },
    /// `check` has too much or too little.
    #[error("{}: {problem}", path.display())]
    CheckArguments {
        /// The first file.
        path: PathBuf,
        /// What is wrong.
        problem: &'static str,
    },
    /// The page of a running simulation.
    #[error(transparent)]
    Viewer(#[from] ViewerError),
    /// A file that cannot be written.
    #[error("cannot write '{}': {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// No bundled scene has this name.
    #[error("there is no bundled scene '{name}'; the scenes are: {known}")]
    UnknownScene {
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// `--set` names nothing in the model.
    #[error("--set {name}: the model has no joint or body of this name; it has {known}")]
    UnknownPart {
        /// The name.
        name: String,
        /// Names there are.
        known: String,
    },
    /// An option names no body.
    #[error("{option} '{name}': the model has no body or geom of this name; it has {known}")]
    UnknownBody {
        /// The option.
        option: &'static str,
        /// The name.
        name: String,
        /// Names there are.
        known: String,
    },
    /// What is written would take the place of something else.
    #[error("{option} '{}' would be written over {other}; name another file", path.display())]
    Overwrites {
        /// The option.
        option: &'static str,
        /// Its file.
        path: PathBuf,
        /// What is there, or is to be there.
        other: String,
    },
    /// `--set` gives a part the wrong number of values.
    #[error("--set {name}.{list}: expected {expected} values, found {found}")]
    ValueCount {
        /// The joint or body.
        name: String,
        /// `q` or `v`.
        list: char,
        /// What fits.
        expected: String,
        /// What was given.
        found: usize,
    },
    /// `--set` makes a state that the model cannot be in.
    #[error("--set: {0}")]
    State(StateError),
    /// A solver of contact problems was asked for where there are none.
    #[error(
        "{}: --method {method} needs kind {}, this is '{kind}'; use --method automatic", path.display(),
        if method == "circular" { "'contact', 'frictional3d' or 'frictional2d'" } else { "'contact'" }
    )]
    NeedsContacts {
        /// The file.
        path: PathBuf,
        /// The solver.
        method: String,
        /// Its kind.
        kind: &'static str,
    },
    /// What was asked for in addition needs contacts.
    #[error("{}: {option} needs kind 'contact', this is '{kind}'", path.display())]
    OptionNeedsContacts {
        /// The file.
        path: PathBuf,
        /// The option.
        option: &'static str,
        /// Its kind.
        kind: &'static str,
    },
    /// A solution that cannot be checked.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// An option that has no meaning without another one.
    #[error("{option} has a meaning with {needs} only")]
    UnusedOption {
        /// The option.
        option: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// The process of one row of a comparison cannot be run.
    #[error("cannot run '{}': {source}", program.display())]
    Process {
        /// The program.
        program: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A row of a comparison that the problem does not have.
    #[error("--row {row}: the comparison has {rows} rows")]
    NoSuchRow {
        /// The row.
        row: usize,
        /// Rows there are.
        rows: usize,
    },
    /// A kind of problem that this version does not know.
    #[error("{}: problems of this kind cannot be solved", path.display())]
    UnsupportedKind {
        /// The file.
        path: PathBuf,
    },
    /// One solution file for several problems.
    #[error("--out takes the solution of one problem, {problems} are given; solve them one by one")]
    OneSolution {
        /// Number of problems.
        problems: usize,
    },
    /// A world that cannot be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A file that cannot be read.
    #[error("cannot read '{}': {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A picture or film.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// `render` into a file whose ending says nothing.
    #[error("{}: --out must end in .png (a picture), .mp4 or .apng (a film)", path.display())]
    PictureEnding {
        /// The file.
        path: PathBuf,
    },
    /// A run in which no step fits.
    #[error("--duration {duration} s is less than half a time step of {timestep} s: no step would be made")]
    NoStep {
        /// The time asked for, s.
        duration: f64,
        /// The time step, s.
        timestep: f64,
    },
    /// A time that no run gets to.
    #[error(
        "{option} {time:e} s: a run with time steps of {timestep} s goes no farther than {end:.3e} s, where rounding takes all of a step"
    )]
    TooLong {
        /// The option.
        option: &'static str,
        /// The time asked for, s.
        time: f64,
        /// The time step, s.
        timestep: f64,
        /// Where runs end, s.
        end: f64,
    },
    /// A film with more frames than its file can count.
    #[error("--time {time} s at --fps {rate:e} are {:.3e} frames: a film has at most {most}", time * rate)]
    TooManyFrames {
        /// The time asked for, s.
        time: f64,
        /// Frames per second.
        rate: f64,
        /// Frames at most.
        most: i32,
    },
    /// A film that cannot go on.
    #[error("at t = {time} s the contacts contradict each other: take a shorter --time, or --infeasible go-on")]
    NoFurther {
        /// Time of the last state.
        time: f64,
    },
    /// `export` for a time before the beginning.
    #[error("--time {time}: the model starts at t = {start} s")]
    TimeBeforeStart {
        /// The time asked for.
        time: f64,
        /// The time of the first state.
        start: f64,
    },
}

impl From<FormatError> for CliError {
    fn from(error: FormatError) -> Self {
        Self::Model(Box::new(error))
    }
}

impl CliError {
    /// The exit code it leads to.
    pub fn exit(&self) -> Exit {
        match self {
            Self::OneSolution { .. }
            | Self::PictureEnding { .. }
            | Self::UnusedOption { .. }
            | Self::Overwrites { .. }
            | Self::NoStep { .. }
            | Self::TooLong { .. }
            | Self::TooManyFrames { .. }
            | Self::CheckArguments { .. }
            | Self::Simulation(SimulationError::Incompatible { .. }) => Exit::Usage,
            _ => Exit::Failure,
        }
    }

    /// Attaches the file to an error of its contents.
    pub fn in_file(path: &Path) -> impl FnOnce(ProblemError) -> Self + '_ {
        |source| Self::Problem { path: path.to_owned(), source: Box::new(source) }
    }
}

fn prefix(path: &Path, source: &ProblemError) -> String {
    match source {
        ProblemError::Archive(_) | ProblemError::File { .. } => String::new(),
        _ => format!("{}: ", path.display()),
    }
}
