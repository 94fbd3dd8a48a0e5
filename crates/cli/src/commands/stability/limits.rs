//! How far a configuration is from collapse.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use signorini::contact::problem_file::{write_contact, write_stability};
use signorini::contact::{ContactProblem, statics::StabilityProof};
use signorini::multibody::glam::DVec3;
use signorini::multibody::{BodyId, Model};
use signorini::statics::{Configuration, Safety, SafetyQuestion, Sideload, StabilitySettings};

use crate::assignment::named;
use crate::error::CliError;
use crate::results::SafetyResult;

/// How far from collapse.
#[derive(Clone, Debug, Args)]
pub struct LimitArguments {
    /// How far from collapse, with a proof on either side: the angle of a tilting table, a horizontal share of gravity, a force at the
    /// centre of mass of a body, a weight that is added to one, or the multiplier of all friction or of the motors' force ranges. Tilt,
    /// share and push act towards --towards.
    #[arg(long, value_name = "WHAT", value_enum)]
    pub safety: Option<SafetyName>,
    /// Direction of --safety tilt and horizontal, in the plane across gravity, and of push. [default: 1,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true, requires = "safety")]
    pub towards: Option<[f64; 3]>,
    /// The worst of all directions of --safety tilt, horizontal or push (across gravity), instead of --towards.
    #[arg(long, requires = "safety", conflicts_with = "towards")]
    pub worst: bool,
    /// Also the limit under circular cones of friction, between polygons inside and outside them.
    #[arg(long, requires = "safety", conflicts_with = "worst")]
    pub circular: bool,
    /// Also where the first step from rest begins to move, which may be before the static limit.
    #[arg(long, requires = "safety", conflicts_with = "worst")]
    pub moves: bool,
    /// The body of --safety weight and push.
    #[arg(long, value_name = "BODY", requires = "safety")]
    pub on: Option<String>,
    /// Write both proofs of the limit, with their problems, for `signorini check`: PREFIX-holds.npz and PREFIX-holds-proof.npz, PREFIX-falls.npz
    /// and PREFIX-falls-proof.npz.
    #[arg(long, value_name = "PREFIX", requires = "safety")]
    pub limit_files: Option<PathBuf>,
}

/// The body of this name, or of the geom of this name.
pub fn body_named(model: &Model, option: &'static str, name: &str) -> Result<BodyId, CliError> {
    let of_geom = || model.geoms.iter().find(|geom| geom.name == name).map(|geom| geom.body);
    model.body_named(name).or_else(of_geom).ok_or_else(|| CliError::UnknownBody {
        option,
        name: name.to_owned(),
        known: named("bodies", &mut model.bodies.iter().skip(1).map(|body| &body.name)),
    })
}

/// Three numbers that point somewhere.
fn direction(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|c: &f64| c.is_finite()) && [x, y, z] != [0.0; 3] => Ok([x, y, z]),
        _ => Err("must be three numbers X,Y,Z that are not all zero".into()),
    }
}

/// What is increased until a model must move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SafetyName {
    /// The angle of a tilting table, degrees.
    Tilt,
    /// A horizontal share of gravity beside gravity itself.
    Horizontal,
    /// A force at the centre of mass of the body that --on names, N.
    Push,
    /// A weight on the body that --on names, kg.
    Weight,
    /// The multiplier of the motors' force ranges, which is lowered; with --hold.
    Motors,
    /// The multiplier of all coefficients of friction, which is lowered.
    Friction,
}

impl SafetyName {
    fn name(self) -> &'static str {
        match self {
            Self::Tilt => "tilt",
            Self::Horizontal => "horizontal",
            Self::Push => "push",
            Self::Weight => "weight",
            Self::Motors => "motors",
            Self::Friction => "friction",
        }
    }
}

impl LimitArguments {
    /// The limit that was asked for.
    pub fn find(
        &self,
        configuration: &Configuration,
        model: &Model,
        settings: &StabilitySettings,
    ) -> Result<Option<SafetyResult>, CliError> {
        let Some(what) = self.safety else { return Ok(None) };
        self.check(what)?;
        let unit = if what == SafetyName::Tilt { 1.0_f64.to_degrees() } else { 1.0 };
        let mut result = SafetyResult { what: what.name(), ..SafetyResult::default() };
        let found = if self.worst {
            let worst = configuration.worst_direction(settings, self.sideload(what, model)?)?;
            result.direction = Some(worst.direction.to_array());
            result.at_least = Some(unit * worst.at_least);
            worst.limit
        } else {
            configuration.safety(settings, &self.question(what, model)?)?
        };
        (result.holds, result.falls) = (unit * found.holds, unit * found.falls);
        if self.circular {
            let circular = configuration.circular_safety(settings, &self.question(what, model)?)?;
            result.polygons = Some(circular.polygons.map(|x| unit * x));
            result.circular = Some([unit * circular.inside.holds, unit * circular.outside.falls]);
        }
        if self.moves {
            let limit = configuration.motion_limit(settings, &self.question(what, model)?)?;
            result.motion = Some([unit * limit.still, unit * limit.moves]);
        }
        self.write(&found)?;
        Ok(Some(result))
    }

    /// Refuses options that this question has no use for.
    fn check(&self, what: SafetyName) -> Result<(), CliError> {
        let unused = |option, needs| Err(CliError::UnusedOption { option, needs });
        if self.on.is_some() && !matches!(what, SafetyName::Push | SafetyName::Weight) {
            return unused("--on", "--safety push or weight");
        }
        if self.towards.is_some() && matches!(what, SafetyName::Weight | SafetyName::Motors | SafetyName::Friction) {
            return unused("--towards", "--safety tilt, horizontal or push");
        }
        Ok(())
    }

    fn body(&self, model: &Model) -> Result<BodyId, CliError> {
        let needs = "--on with the name of a body";
        let name = self.on.as_deref().ok_or(CliError::UnusedOption { option: "--safety weight or push", needs })?;
        body_named(model, "--on", name)
    }

    fn sideload(&self, what: SafetyName, model: &Model) -> Result<Sideload, CliError> {
        match what {
            SafetyName::Tilt => Ok(Sideload::Tilt),
            SafetyName::Horizontal => Ok(Sideload::Horizontal),
            SafetyName::Push => Ok(Sideload::Push(self.body(model)?)),
            _ => Err(CliError::UnusedOption { option: "--worst", needs: "--safety tilt, horizontal or push" }),
        }
    }

    fn question(&self, what: SafetyName, model: &Model) -> Result<SafetyQuestion, CliError> {
        let direction = DVec3::from_array(self.towards.unwrap_or([1.0, 0.0, 0.0]));
        Ok(match what {
            SafetyName::Tilt => SafetyQuestion::Tilt(direction),
            SafetyName::Horizontal => SafetyQuestion::Horizontal(direction),
            SafetyName::Push => SafetyQuestion::Push(self.body(model)?, direction),
            SafetyName::Weight => SafetyQuestion::Weight(self.body(model)?),
            SafetyName::Motors => SafetyQuestion::Motors,
            SafetyName::Friction => SafetyQuestion::Friction,
        })
    }

    /// Writes both proofs with their problems, as far as there are any.
    fn write(&self, found: &Safety) -> Result<(), CliError> {
        let Some(prefix) = &self.limit_files else { return Ok(()) };
        let one = |side: &str, proof: &Option<(ContactProblem, StabilityProof)>| -> Result<(), CliError> {
            let Some((problem, proof)) = proof else { return Ok(()) };
            let path = |ending: &str| {
                let mut name = prefix.clone().into_os_string();
                name.push(format!("-{side}{ending}.npz"));
                PathBuf::from(name)
            };
            let (data, claim) = (path(""), path("-proof"));
            write_contact(&data, problem).map_err(CliError::in_file(&data))?;
            write_stability(&claim, proof).map_err(CliError::in_file(&claim))
        };
        one("holds", &found.at_holds)?;
        one("falls", &found.at_falls)
    }
}
