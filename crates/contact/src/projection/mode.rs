//! The pieces of the projection, and the facets between them.

/// A linear piece of the projection of one contact. Vertices and edges are numbered counterclockwise; edge `k` runs from
/// vertex `k` to vertex `k + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// No impulse.
    Open,
    /// Closed without friction: `λ_T = 0`.
    Closed,
    /// Inside the cone: `P(y) = y`.
    Stick,
    /// On edge `k` of the polygon.
    Edge(u16),
    /// At vertex `k` of the polygon.
    Vertex(u16),
}

impl Mode {
    /// A number for every mode, for storage.
    pub fn code(self) -> u32 {
        match self {
            Self::Open => 0,
            Self::Closed => 1,
            Self::Stick => 2,
            Self::Edge(k) => 3 + 2 * u32::from(k),
            Self::Vertex(k) => 4 + 2 * u32::from(k),
        }
    }

    /// The mode of a [`code`](Self::code).
    pub fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            0 => Self::Open,
            1 => Self::Closed,
            2 => Self::Stick,
            _ if code % 2 == 1 => Self::Edge(u16::try_from((code - 3) / 2).ok()?),
            _ => Self::Vertex(u16::try_from((code - 4) / 2).ok()?),
        })
    }
}

/// A direction in which a mode leaves the impulse free, and the one in which it holds the velocity for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// The direction of the impulse.
    pub impulse: [f64; 3],
    /// That of the velocity.
    pub velocity: [f64; 3],
}

/// A facet of a mode's cone: the mode holds where `normal · y ≥ 0`. On its far side the mode is `next`, and the slope of
/// the projection is larger by `jump normalᵀ`.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Inward normal `f` of the facet, of any length.
    pub normal: [f64; 3],
    /// What the slope changes by, `a`, beyond the facet.
    pub jump: [f64; 3],
    /// The mode on its far side.
    pub next: Mode,
}
