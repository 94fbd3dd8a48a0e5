//! Tendons: lengths with a spring, a damper and limits.

use derive_setters::Setters;

use super::{GeomId, JointId, SiteId};

/// A part of the path of a spatial tendon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathPart {
    /// A point that it passes.
    Site(SiteId),
    /// A sphere or a cylinder (as if infinitely long) that is in its way between the sites before and after.
    Wrap {
        /// The obstacle.
        geom: GeomId,
        /// A site on the side where the tendon lies; where it is inside the geom, the tendon runs inside. None: the shorter way.
        side: Option<SiteId>,
    },
    /// A new branch begins, whose lengths count by one part in `divisor`; the first branch counts whole.
    Pulley {
        /// > 0.
        divisor: f64,
    },
}

/// A tendon: a length that is a linear combination of joint coordinates, or that of a path along sites and around geoms, with a spring, a
/// damper and limits.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Tendon {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// Hinges and slides with their coefficients: they add `Σ c_j q_j` to the length.
    pub terms: Vec<(JointId, f64)>,
    /// Path of a spatial tendon, whose length is added; empty for a fixed one.
    pub path: Vec<PathPart>,
    /// Stiffness of the spring, N/m, ≥ 0.
    pub stiffness: f64,
    /// Viscous damping of the length, N·s/m, ≥ 0.
    pub damping: f64,
    /// The lengths between which the spring is slack, m.
    pub rest: [f64; 2],
    /// Lower and upper limit of the length, m.
    #[setters(into)]
    pub limits: Option<[f64; 2]>,
    /// Length at the reference configuration, m; set by the builder.
    #[setters(skip)]
    pub reference_length: f64,
}

impl Tendon {
    /// A fixed tendon with nothing acting in it.
    pub fn new(name: impl Into<String>, terms: Vec<(JointId, f64)>) -> Self {
        Self {
            name: name.into(),
            terms,
            path: Vec::new(),
            stiffness: 0.0,
            damping: 0.0,
            rest: [0.0; 2],
            limits: None,
            reference_length: 0.0,
        }
    }

    /// A spatial tendon with nothing acting in it.
    pub fn along(name: impl Into<String>, path: Vec<PathPart>) -> Self {
        Self { path, ..Self::new(name, Vec::new()) }
    }

    /// How far a length is beyond the end of the range in which the spring is slack, m.
    pub fn stretch(&self, length: f64) -> f64 {
        length - length.clamp(self.rest[0], self.rest[1])
    }
}
