//! Every solver of the library by name.

use serde::Serialize;
use signorini::lcp::MethodKind;

use crate::args::MethodChoice;

/// The law of contact that a solver solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactLaw {
    /// Signorini and maximum dissipation over a polygon.
    Polygon,
    /// Signorini and Coulomb with the circular cone.
    Circular,
    /// Anitescu's convex relaxation, which is another model.
    Relaxation,
}

/// A solver by name.
#[derive(Clone, Debug, PartialEq)]
pub enum SolverChoice {
    /// The polygon's laws: the structured solver or a method for LCPs.
    Polygon(MethodChoice),
    /// The circular cone.
    Circular,
    /// The polygon, refined into the slip until the circular cone's laws hold.
    Refined,
    /// The convex relaxation.
    Relaxation,
}

impl SolverChoice {
    /// The solver of this name.
    pub fn parse(name: &str) -> Result<Self, String> {
        match name {
            "circular" => Ok(Self::Circular),
            "refined" => Ok(Self::Refined),
            "relaxation" => Ok(Self::Relaxation),
            _ => MethodChoice::parse(name)
                .map(Self::Polygon)
                .map_err(|known| format!("{known}, circular, refined, relaxation")),
        }
    }

    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Self::Polygon(method) => method.name(),
            Self::Circular => "circular".into(),
            Self::Refined => "refined".into(),
            Self::Relaxation => "relaxation".into(),
        }
    }

    /// Lemke's method with enumeration behind it, for problems without contacts.
    pub fn automatic() -> Self {
        Self::Polygon(MethodChoice::Lcp(MethodKind::Automatic(Default::default(), Default::default())))
    }

    /// The structured solver.
    pub fn structured() -> Self {
        Self::Polygon(MethodChoice::Structured)
    }

    /// The methods for LCPs.
    pub fn lcp_methods() -> impl Iterator<Item = Self> {
        MethodKind::all().into_iter().map(|kind| Self::Polygon(MethodChoice::Lcp(kind)))
    }

    /// The method, if it is one for LCPs.
    pub fn lcp(&self) -> Option<&MethodKind> {
        match self {
            Self::Polygon(MethodChoice::Lcp(kind)) => Some(kind),
            _ => None,
        }
    }
}
