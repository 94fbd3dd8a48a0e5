//! `signorini stability`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use signorini::contact::problem_file::{write_contact, write_stability};
use signorini::multibody::glam::DVec3;
use signorini::statics::{SafetyQuestion, StabilitySettings, safety, stability};
use signorini::{Settings, Simulation};

use crate::args::{ModelArguments, StartArguments, directions, fraction, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::{load_model, start};
use crate::results::{SafetyResult, StabilityResult};
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini stability pallet.xml
  signorini stability arch.xml --json
  signorini stability wall.xml --safety tilt --towards 0,1,0
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
    /// How far from collapse, with a proof on either side: the angle of a tilting table, a horizontal share of gravity, or the multiplier
    /// of all friction. Tilt and share act towards --towards.
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
    /// The multiplier of all coefficients of friction, which is lowered.
    Friction,
}

/// The limit that was asked for.
fn limit(
    arguments: &Arguments,
    simulation: &Simulation,
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
    };
    let found = safety(simulation.model(), simulation.state(), &simulation.input, settings, &question)?;
    Ok(Some(SafetyResult { what, holds: unit * found.holds, falls: unit * found.falls }))
}

/// Says whether a model stands, with a proof.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let loaded = load_model(&arguments.model)?;
    let settings = Settings::default().with_directions(arguments.directions);
    let simulation = start(&loaded, &arguments.start, settings.clone())?;
    let settings = StabilitySettings::default()
        .with_contact_tolerance(arguments.touching)
        .with_tolerance(arguments.tolerance)
        .with_enumeration_programs(arguments.enumeration)
        .with_simulation(settings);
    let found = stability(simulation.model(), simulation.state(), &simulation.input, &settings)?;
    if let Some(path) = &arguments.problem {
        write_contact(path, &found.rest.problem).map_err(CliError::in_file(path))?;
    }
    if let Some(path) = &arguments.out {
        write_stability(path, &found.stability.proof).map_err(CliError::in_file(path))?;
    }
    let motion = found.motion(simulation.model(), simulation.state(), &simulation.input);
    let mut result = StabilityResult::new(&loaded, &found, &motion, settings.tolerance);
    result.safety = limit(arguments, &simulation, &settings)?;
    output::print_result(&result, arguments.json, text::stability);
    Ok(if result.proved { Exit::Success } else { Exit::NotSolved })
}
