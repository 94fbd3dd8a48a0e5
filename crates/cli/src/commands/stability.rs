//! `signorini stability`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use signorini::contact::problem_file::{write_contact, write_stability};
use signorini::formats::ImportReport;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{BodyId, Input, Model, State};
use signorini::statics::{
    Assembly, ModelStability, Safety, SafetyQuestion, StabilitySettings, held_by_motors, safety, stability,
};
use signorini::{Settings, Simulation, SimulationError};

use crate::args::{ModelArguments, StartArguments, directions, fraction, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::{Loaded, load_model, start};
use crate::pack::{self, PackArguments};
use crate::results::{SafetyResult, StabilityResult};
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini stability pallet.xml
  signorini stability arch.xml --json
  signorini stability wall.xml --safety tilt --towards 0,1,0
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
    #[arg(long, value_name = "GAP", default_value = "1e-6", value_parser = positive)]
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
    /// How far from collapse, with a proof on either side: the angle of a tilting table, a horizontal share of gravity, or the multiplier
    /// of all friction or of the motors' force ranges, or a weight that is added to a body. Tilt and share act towards --towards.
    #[arg(long, value_name = "WHAT", value_enum)]
    pub safety: Option<SafetyName>,
    /// Direction of --safety tilt and horizontal, in the plane across gravity.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        num_args = 1,
        default_value = "1,0,0",
        allow_hyphen_values = true
    )]
    pub towards: Vec<f64>,
    /// The body of --safety weight.
    #[arg(long, value_name = "BODY")]
    pub on: Option<String>,
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

/// What is increased until a model must move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SafetyName {
    /// The angle of a tilting table, degrees.
    Tilt,
    /// A horizontal share of gravity beside gravity itself.
    Horizontal,
    /// A weight on the body that --on names, kg.
    Weight,
    /// The multiplier of the motors' force ranges, which is lowered; with --hold.
    Motors,
    /// The multiplier of all coefficients of friction, which is lowered.
    Friction,
}

/// What is asked: a model in a state, or an assembly of blocks.
enum Subject {
    /// With the model that is judged, whose motors may hold.
    Model(Box<Loaded>, Box<Simulation>, Arc<Model>),
    Blocks(Box<Assembly>, String),
}

impl Subject {
    fn new(arguments: &Arguments, settings: &Settings) -> Result<Self, CliError> {
        if let Some(folder) = &arguments.pack.pack {
            let (friction, floor) = (arguments.model.friction, arguments.model.floor);
            let assembly = pack::read(folder, &arguments.pack, friction, floor, arguments.touching)?;
            return Ok(Self::Blocks(Box::new(assembly), folder.display().to_string()));
        }
        let loaded = load_model(&arguments.model)?;
        let simulation = start(&loaded, &arguments.start, settings.clone())?;
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

    fn stability(&self, settings: &StabilitySettings) -> Result<ModelStability, SimulationError> {
        match self {
            Self::Model(_, s, model) => stability(model, s.state(), &s.input, settings),
            Self::Blocks(assembly, _) => assembly.stability(settings),
        }
    }

    fn safety(&self, settings: &StabilitySettings, question: &SafetyQuestion) -> Result<Safety, SimulationError> {
        match self {
            Self::Model(_, s, model) => safety(model, s.state(), &s.input, settings, question),
            Self::Blocks(assembly, _) => assembly.safety(settings, question),
        }
    }

    fn result(&self, found: &ModelStability, tolerance: f64) -> StabilityResult {
        let (state, input) = (State::new(self.model()), Input::default());
        match self {
            Self::Model(loaded, simulation, _) => {
                let motion = found.motion(simulation.model(), simulation.state(), &simulation.input);
                StabilityResult::new(&loaded.model, &loaded.source, &loaded.report, found, &motion, tolerance)
            }
            Self::Blocks(assembly, source) => {
                let motion = found.motion(&assembly.model, &state, &input);
                StabilityResult::new(&assembly.model, source, &ImportReport::default(), found, &motion, tolerance)
            }
        }
    }
}

/// The limit that was asked for.
fn limit(
    arguments: &Arguments,
    subject: &Subject,
    settings: &StabilitySettings,
) -> Result<Option<SafetyResult>, CliError> {
    let Some(name) = arguments.safety else { return Ok(None) };
    let [x, y, z] = arguments.towards[..] else {
        return Err(CliError::UnusedOption { option: "--towards", needs: "three numbers X,Y,Z" });
    };
    let direction = DVec3::new(x, y, z);
    let (question, what, unit) = match name {
        SafetyName::Tilt => (SafetyQuestion::Tilt(direction), "tilt", 1.0_f64.to_degrees()),
        SafetyName::Horizontal => (SafetyQuestion::Horizontal(direction), "horizontal", 1.0),
        SafetyName::Friction => (SafetyQuestion::Friction, "friction", 1.0),
        SafetyName::Motors => (SafetyQuestion::Motors, "motors", 1.0),
        SafetyName::Weight => {
            let name = arguments.on.as_deref().unwrap_or_default();
            let Some(body) = subject.model().bodies.iter().position(|body| body.name == name) else {
                return Err(CliError::UnusedOption {
                    option: "--safety weight",
                    needs: "--on with the name of a body",
                });
            };
            (SafetyQuestion::Weight(BodyId(body as u32)), "weight", 1.0)
        }
    };
    let found = subject.safety(settings, &question)?;
    Ok(Some(SafetyResult { what, holds: unit * found.holds, falls: unit * found.falls }))
}

/// Says whether a model stands, with a proof.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let settings = Settings::default().with_directions(arguments.directions);
    let subject = Subject::new(arguments, &settings)?;
    let settings = StabilitySettings::default()
        .with_contact_tolerance(arguments.touching)
        .with_tolerance(arguments.tolerance)
        .with_enumeration_programs(arguments.enumeration)
        .with_simulation(settings);
    let found = subject.stability(&settings)?;
    if let Some(path) = &arguments.problem {
        write_contact(path, &found.rest.problem).map_err(CliError::in_file(path))?;
    }
    if let Some(path) = &arguments.out {
        write_stability(path, &found.stability.proof).map_err(CliError::in_file(path))?;
    }
    let mut result = subject.result(&found, settings.tolerance);
    result.safety = limit(arguments, &subject, &settings)?;
    output::print_result(&result, arguments.json, text::stability);
    Ok(if result.proved { Exit::Success } else { Exit::NotSolved })
}
