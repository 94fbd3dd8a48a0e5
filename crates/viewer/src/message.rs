//! What page and simulation say to each other, but for the frames.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use signorini_multibody::BodyId;
use signorini_multibody::glam::DVec3;

use crate::drag::Grip;

/// Speeds that can be asked for, simulated seconds per second.
pub const SPEEDS: RangeInclusive<f64> = 1e-3..=100.0;
/// Steps that can be asked for at once.
const MOST_STEPS: u32 = 1000;
/// A drag's target may be this far from the origin, m.
const FARTHEST: f64 = 1e6;

/// A command of the page, as it comes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Go on.
    Run {},
    /// Stop.
    Pause {},
    /// Stop, and make this many steps.
    Step {
        /// Number of steps.
        count: u32,
    },
    /// Back to the start.
    Reset {},
    /// Choose the speed.
    Speed {
        /// Simulated seconds per second.
        value: f64,
    },
    /// Hold a body at a point and pull it.
    Drag {
        /// Index of the body.
        body: u32,
        /// Held point, body frame, m.
        point: [f64; 3],
        /// Where to, world, m.
        target: [f64; 3],
    },
    /// Let go.
    Release {},
}

impl Command {
    /// Reads and checks a command for a model with this many bodies, the world among them.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn parse(text: &str, bodies: usize) -> Result<Self, String> {
        let command: Self = serde_json::from_str(text).map_err(|error| format!("not a command: {error}"))?;
        match &command {
            Self::Step { count } if !(1..=MOST_STEPS).contains(count) => {
                return Err(format!("step: count = {count}, must be from 1 to {MOST_STEPS}"));
            }
            Self::Speed { value } if !SPEEDS.contains(value) => {
                return Err(format!("speed: value = {value}, must be from {} to {}", SPEEDS.start(), SPEEDS.end()));
            }
            Self::Drag { body, .. } if *body == 0 || *body as usize >= bodies => {
                return Err(format!("drag: body = {body}, must be from 1 to {}", bodies.saturating_sub(1)));
            }
            Self::Drag { point, target, .. } => {
                if let Some(x) = point.iter().chain(target).find(|x| x.abs() > FARTHEST) {
                    return Err(format!("drag: a coordinate is {x}, must be within {FARTHEST} m"));
                }
            }
            _ => {}
        }
        Ok(command)
    }

    /// The grip of a drag.
    pub fn grip(&self) -> Option<Grip> {
        let &Self::Drag { body, point, target } = self else { return None };
        Some(Grip { body: BodyId(body), point: DVec3::from_array(point), target: DVec3::from_array(target) })
    }
}

/// News for the page.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Notice<'a> {
    /// How the simulation stands.
    Status {
        /// Whether it runs.
        running: bool,
        /// Speed asked for.
        speed: f64,
        /// Speed reached lately; 0 while it does not run.
        rate: f64,
        /// Why it cannot go on.
        trouble: Option<&'a str>,
        /// What the user should know of the start.
        note: Option<&'a str>,
    },
    /// A command that was not understood.
    Error {
        /// What is wrong with it.
        message: &'a str,
    },
}

impl Notice<'_> {
    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("numbers and text become JSON")
    }
}
