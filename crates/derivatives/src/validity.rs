//! What a derivative is worth: whether it exists, and how far the nearest place is where it does not.

use signorini_multibody::derivatives::MarginSource;
use signorini_multibody::{GeomId, JointId, TendonId};

/// Whether a step has a derivative.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Validity {
    /// Every inequality of the step holds strictly: the step is differentiable.
    Exact,
    /// Some inequalities are about to turn: the step has another derivative on each side of them.
    OneSided {
        /// Those that decide.
        deciding: Vec<Margin>,
    },
    /// There is no derivative, or none that is known.
    Refused {
        /// Why.
        reason: String,
    },
}

/// How far an inequality of the step is from turning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Margin {
    /// What it belongs to.
    pub source: InequalitySource,
    /// Which of its inequalities.
    pub kind: InequalityKind,
    /// Its distance from turning, ≥ 0: velocities relative to the larger of the problem's velocity scale and the speeds at its contacts,
    /// impulses times the Delassus scale relative to the same, forces and controls relative to their range.
    pub value: f64,
}

/// What an inequality of a step belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InequalitySource {
    /// A contact of the step's problem, by index; limits are among them.
    Contact(usize),
    /// A friction group of the step's problem, by index.
    FrictionGroup(usize),
    /// Two geoms that could touch and are not in the step's problem.
    Candidate([GeomId; 2]),
    /// A limit of a joint that is not in the step's problem.
    JointLimit(JointId),
    /// A limit of a tendon that is not in the step's problem.
    TendonLimit(TendonId),
    /// A bilateral row of the step's problem, by index.
    Bilateral(usize),
    /// A range in the smooth part.
    Smooth(MarginSource),
}

/// Which inequality of a contact or a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InequalityKind {
    /// The contact is open, and its gap at the end of the step is positive.
    Gap,
    /// The contact is closed, and its normal impulse is positive.
    NormalImpulse,
    /// It sticks, and the friction bound has room.
    FrictionBound,
    /// It slides, and the sliding speed is positive.
    SlidingSpeed,
    /// It slides, and another direction of the polygon would dissipate less.
    Direction,
    /// It slides, and its friction is between two directions.
    Share,
    /// The parts of the shapes that touch stay the same.
    Feature,
    /// The speed of a correction, or of an impact, is on one side of its threshold.
    Threshold,
    /// Contacts that hold the same motion hold it on one side only.
    Redundancy,
    /// A control, force, or length against its range.
    Range,
}

impl InequalityKind {
    /// Whether it is one of a contact's laws, which are solved for along a change.
    pub(crate) fn is_law(self) -> bool {
        matches!(
            self,
            Self::Gap | Self::NormalImpulse | Self::FrictionBound | Self::SlidingSpeed | Self::Direction | Self::Share
        )
    }
}
