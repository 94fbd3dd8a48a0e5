//! `signorini stability`.

mod limits;
mod page;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use signorini::contact::problem_file::{write_contact, write_stability};
use signorini::formats::ImportReport;
use signorini::multibody::{Input, Model, State};
use signorini::statics::{
    Assembly, Attraction, Configuration, ModelStability, StabilitySettings, Verdict, held_by_motors,
};
use signorini::{Settings, Simulation, SimulationError, rest_problem};

use crate::args::{ModelArguments, StartArguments, directions, fraction, touching};
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::{Loaded, load_model, start};
use crate::pack::{self, PackArguments};
use crate::results::{CriticalLine, StabilityResult};
use crate::{output, text};
use limits::{LimitArguments, body_named};

const EXAMPLE: &str = "\
Examples:
  signorini stability pallet.xml
  signorini stability arch.xml --json
  signorini stability wall.xml --safety tilt --towards 0,1,0
  signorini stability wall.xml --safety tilt --worst --report wall.html
  signorini stability wall.xml --safety friction --limit-files wall
  signorini stability arm.xml --hold --safety motors
  signorini stability --pack stones --density 2400 --friction 0.7 --fixed left --fixed right
  signorini stability stack.xml --problem stack.npz --out proof.npz
  signorini check stack.npz proof.npz

The verdicts:
  must_move      no contact forces within the friction cones balance the loads; proof: a mechanism
  stays          forces balance the loads, and it is proved that nothing can begin to move
  may_do_either  forces balance the loads, and there is a moving solution as well; both are certified
  stands         forces balance the loads, and a search for a moving solution found none; nothing more is proved

Coulomb friction is not associated: forces that balance the loads are alone no proof that nothing moves.";

/// Arguments of `stability`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// The configuration; its velocity is taken as zero.
    #[command(flatten)]
    pub start: StartArguments,
    /// Blocks from meshes.
    #[command(flatten)]
    pub pack: PackArguments,
    /// Shapes touch up to this gap in metres (limits of hinges: radians).
    #[arg(long, value_name = "GAP", default_value = "1e-6", value_parser = touching)]
    pub touching: f64,
    /// Friction directions of every contact, an even number of at least 4.
    #[arg(long, value_name = "M", default_value_t = 8, value_parser = directions)]
    pub directions: usize,
    /// A proof holds when its residuals are at most this.
    #[arg(long, value_name = "X", default_value = "1e-9", value_parser = fraction)]
    pub tolerance: f64,
    /// Linear programs of the complete enumeration of modes at most; 0 for no enumeration.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub enumeration: usize,
    /// Let every actuator hold still with whatever force within its range that takes: does this robot hold this posture?
    #[arg(long, conflicts_with = "pack")]
    pub hold: bool,
    /// How far from collapse.
    #[command(flatten)]
    pub limits: LimitArguments,
    /// Bodies, or geoms' bodies, that hold together: A,B=FORCE in N for a pair, over all its contact points, or FORCE for every contact
    /// point: studs, glue, magnets, clamps. Can be given several times.
    #[arg(long, value_name = "[A,B=]FORCE", value_parser = AttractArgument::parse)]
    pub attract: Vec<AttractArgument>,
    /// The range of every contact force over all balances (in --json, and the widest in words).
    #[arg(long)]
    pub ranges: bool,
    /// How far every body can be pushed: the least horizontal force at its centre of mass that nothing balances any more.
    #[arg(long)]
    pub bodies: bool,
    /// Write a page with forces, friction use, collapse mechanism and margins.
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the contact problem that the verdict speaks of (.npz, kind = "contact").
    #[arg(long, value_name = "FILE.npz")]
    pub problem: Option<PathBuf>,
    /// Write the verdict with its proof, for `signorini check`.
    #[arg(long, value_name = "FILE.npz")]
    pub out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// The gap within which shapes of what must move nearly touch, m: the mistake of a drawing, and no distance.
const NEARLY: f64 = 1e-3;

/// What is asked: a model in a state, or an assembly of blocks.
enum Subject {
    /// With the model that is judged, whose motors may hold.
    Model(Box<Loaded>, Box<Simulation>, Arc<Model>),
    Blocks(Box<Assembly>, String),
}

impl Subject {
    fn new(arguments: &Arguments, settings: &Settings) -> Result<Self, CliError> {
        if let Some(folder) = &arguments.pack.pack {
            let floor = arguments.model.floor;
            let (assembly, height) =
                pack::read(folder, &arguments.pack, arguments.model.friction, floor, arguments.touching)?;
            if let Some(height) = height.filter(|_| !floor) {
                eprintln!("note: the blocks stand on a floor at z = {height}");
            }
            return Ok(Self::Blocks(Box::new(assembly), folder.display().to_string()));
        }
        let loaded = load_model(&arguments.model)?;
        let simulation = start(&loaded, &arguments.start, settings.clone())?;
        if arguments.hold && loaded.model.actuators.is_empty() {
            eprintln!("note: --hold changes nothing: the model has no actuators that could hold");
        }
        let judged = match arguments.hold {
            true => Arc::new(held_by_motors(&loaded.model)?),
            false => Arc::clone(&loaded.model),
        };
        Ok(Self::Model(Box::new(loaded), Box::new(simulation), judged))
    }

    fn model(&self) -> &Model {
        match self {
            Self::Model(_, _, model) => model,
            Self::Blocks(assembly, _) => &assembly.model,
        }
    }

    fn configuration(&self) -> Configuration<'_> {
        match self {
            Self::Model(_, s, model) => Configuration::new(model, s.state(), &s.input),
            Self::Blocks(assembly, _) => assembly.configuration(),
        }
    }

    /// The state that is judged, and its input.
    fn state(&self) -> (State, Input) {
        match self {
            Self::Model(_, s, _) => (s.state().clone(), s.input.clone()),
            Self::Blocks(assembly, _) => (State::new(&assembly.model), Input::default()),
        }
    }

    /// Contacts if shapes touched up to another gap, m.
    fn contacts_within(&self, gap: f64, arguments: &Arguments, settings: &Settings) -> Result<usize, CliError> {
        let ModelArguments { friction, floor, .. } = arguments.model;
        Ok(match (self, &arguments.pack.pack) {
            (Self::Model(_, s, model), _) => {
                rest_problem(model, s.state(), &s.input, settings, gap)?.problem.contact_count()
            }
            (Self::Blocks(..), Some(folder)) => {
                pack::read(folder, &arguments.pack, friction, floor, gap)?.0.points.len()
            }
            (Self::Blocks(assembly, _), None) => assembly.points.len(),
        })
    }

    fn result(&self, found: &ModelStability, tolerance: f64) -> StabilityResult {
        let (state, input) = self.state();
        let motion = found.motion(self.model(), &state, &input);
        let none = ImportReport::default();
        let (source, report) = match self {
            Self::Model(loaded, ..) => (&loaded.source, &loaded.report),
            Self::Blocks(_, source) => (source, &none),
        };
        StabilityResult::new(self.model(), source, report, found, &motion, tolerance)
    }
}

/// What holds bodies together, as the command line has it.
#[derive(Clone, Debug)]
pub struct AttractArgument {
    /// Two bodies or geoms; every contact point where there are none.
    pair: Option<[String; 2]>,
    /// N.
    force: f64,
}

impl AttractArgument {
    fn parse(text: &str) -> Result<Self, String> {
        let (pair, force) = text.rsplit_once('=').map_or((None, text), |(pair, force)| (Some(pair), force));
        let force = force.trim().parse::<f64>().ok().filter(|force| *force >= 0.0 && force.is_finite());
        let pair = pair.map(|pair| pair.split_once(',').map(|(a, b)| [a, b].map(|name| name.trim().to_owned())));
        match (pair, force) {
            (None, Some(force)) => Ok(Self { pair: None, force }),
            (Some(Some(pair)), Some(force)) => Ok(Self { pair: Some(pair), force }),
            _ => Err("must be FORCE or A,B=FORCE: two names, and newtons from 0 on".into()),
        }
    }
}

/// The attractions of this model.
fn attractions(words: &[AttractArgument], model: &Model) -> Result<Vec<Attraction>, CliError> {
    let body = |name: &str| body_named(model, "--attract", name);
    let read = |attract: &AttractArgument| {
        Ok(match &attract.pair {
            None => Attraction::Points(attract.force),
            Some([a, b]) => Attraction::Pair([body(a)?, body(b)?], attract.force),
        })
    };
    words.iter().map(read).collect()
}

/// Says whether a model stands, with a proof.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let outputs = [
        ("--report", arguments.report.as_deref()),
        ("--problem", arguments.problem.as_deref()),
        ("--out", arguments.out.as_deref()),
    ];
    output::keep_apart(&arguments.model.files(), &outputs)?;
    let settings = Settings::default().with_directions(arguments.directions);
    let subject = Subject::new(arguments, &settings)?;
    let settings = StabilitySettings::default()
        .with_contact_tolerance(arguments.touching)
        .with_tolerance(arguments.tolerance)
        .with_enumeration_programs(arguments.enumeration)
        .with_attraction(attractions(&arguments.attract, subject.model())?)
        .with_simulation(settings);
    let configuration = subject.configuration();
    let found = configuration.stability(&settings)?;
    if let Some(path) = &arguments.problem {
        write_contact(path, &found.rest.problem).map_err(CliError::in_file(path))?;
    }
    if let Some(path) = &arguments.out {
        write_stability(path, &found.stability.proof).map_err(CliError::in_file(path))?;
    }
    if found.stability.verdict() == Verdict::MustMove && arguments.touching < NEARLY {
        let touching = found.rest.problem.contact_count();
        let more = subject.contacts_within(NEARLY, arguments, &settings.simulation)?.saturating_sub(touching);
        if more > 0 {
            eprintln!("note: {touching} points touch; {more} more would with --touching {NEARLY:e}");
        }
    }
    let mut result = subject.result(&found, settings.tolerance);
    result.safety = arguments.limits.find(&configuration, subject.model(), &settings)?;
    if arguments.ranges {
        let ranges = found.force_ranges().map_err(SimulationError::from)?;
        result.forces.iter_mut().zip(ranges).for_each(|(force, range)| force.range = Some(range.normal));
    }
    if arguments.bodies && found.stability.verdict() != Verdict::MustMove {
        let bodies = configuration.critical_bodies(&settings)?;
        result.bodies = bodies.iter().map(|body| CriticalLine::new(subject.model(), body)).collect();
    }
    if let Some(path) = &arguments.report {
        let (state, input) = subject.state();
        page::write(path, subject.model(), &state, &input, &result)?;
    }
    output::print_result(&result, arguments.json, text::stability);
    Ok(if result.proved { Exit::Success } else { Exit::NotSolved })
}
