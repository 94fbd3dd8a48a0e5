//! Memory that building rows needs.

use signorini_multibody::derivatives::LengthCurvature;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, EqualityBlock, LengthRow};

use super::patch::Patch;
use super::system::{Moved, Mover};
use super::turning::TurnSum;
use crate::geometry::SearchMemory;

/// Memory that building rows needs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    pub list: Vec<Mover>,
    pub moved: Vec<Moved>,
    pub points: Vec<ContactPoint>,
    pub displaced: Vec<(Mover, DVec3, DVec3)>,
    pub turned: TurnSum,
    pub block: Option<EqualityBlock>,
    pub length: LengthRow,
    pub turns: LengthCurvature,
    /// Of a row by the configuration, `[nv]`.
    pub slopes: Vec<f64>,
    pub search: SearchMemory,
    pub patch: Patch,
}
