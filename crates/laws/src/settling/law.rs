//! The laws of a contact on its way to rest: projections with symmetric slopes.

use crate::polyhedral::{ImpulseCones, Piece};
use signorini_contact::projection::{Cones, Mode};

/// What bounds a contact's friction.
#[derive(Clone, Copy, Debug)]
pub(super) enum Law {
    /// The polygon for a known normal impulse, whatever the normal impulse is; the bound of Tresca.
    Bounded {
        /// The normal impulse.
        normal: f64,
    },
    /// The cone of impulses as a whole, normal impulse and friction together: the associated law.
    Associated,
}

/// A linear piece of a law's projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LawPiece {
    /// Whether the contact is closed, and the piece of its friction.
    Bounded { closed: bool, friction: Mode },
    /// The face of the cone.
    Associated(Piece),
}

/// The cones of a problem in both forms.
pub(super) type BothCones<'a> = (&'a Cones, &'a ImpulseCones);

impl Law {
    /// The point nearest to `y` that contact `i`'s law admits, and the piece it is on.
    pub fn project(self, (cones, associated): BothCones, i: usize, y: [f64; 3]) -> ([f64; 3], LawPiece) {
        match self {
            Self::Bounded { normal } => {
                let y_friction = [normal, y[1], y[2]];
                let friction = cones.mode_at(i, y_friction);
                let [_, a, b] = cones.project(i, friction, y_friction);
                ([y[0].max(0.0), a, b], LawPiece::Bounded { closed: y[0] > 0.0, friction })
            }
            Self::Associated => {
                let mu = cones.friction(i);
                let (p, piece) = if cones.is_well_inside(i, y) {
                    (y, Piece::Interior)
                } else if y[0] <= 0.0 && y[0] * y[0] >= mu * mu * (y[1] * y[1] + y[2] * y[2]) {
                    ([0.0; 3], Piece::Apex)
                } else {
                    associated.project(i, y)
                };
                (p, LawPiece::Associated(piece))
            }
        }
    }
}

impl LawPiece {
    /// The slope of the projection of contact `i` on this piece; none where it is zero.
    pub fn slope(self, (cones, associated): BothCones, i: usize) -> Option<[[f64; 3]; 3]> {
        match self {
            Self::Bounded { closed: false, friction: Mode::Open | Mode::Closed } => None,
            Self::Bounded { closed, friction } => {
                let [_, a, b] = cones.slope(i, friction);
                Some([[f64::from(u8::from(closed)), 0.0, 0.0], [0.0, a[1], a[2]], [0.0, b[1], b[2]]])
            }
            Self::Associated(Piece::Apex) => None,
            Self::Associated(piece) => Some(associated.projector(i, piece)),
        }
    }
}

#[cfg(test)]
mod tests;
