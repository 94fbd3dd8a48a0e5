//! What controls the steps along a central path: how far they go, when they are corrected, and when they have to be repeated.

use super::series::{Ahead, Rates};
use signorini_contact::vector::inner;

/// The largest relative change of a number along the tangent in the first step along a path, in any, and in one that is too small to
/// go on with.
const FIRST_REACH: f64 = 0.5;
const MOST_REACH: f64 = 10.0;
const LEAST_REACH: f64 = 1e-6;
/// Distances from the path, in parts of the reach, at which a step along it is made: usually, and where the path bends or steps failed.
const CLOSE: f64 = 0.4;
const CLOSER: f64 = 0.2;
/// ... and at which a place is worth keeping for when the last one does not help.
const CLOSEST: f64 = 0.1;
/// These distances are never more, and never less.
const MOST_DISTANCE: [f64; 2] = [0.2, 0.06];
const LEAST_DISTANCE: f64 = 1e-5;
/// The distance at which the end of a path is reached.
const LANDED: f64 = 0.02;
/// Newton steps back to the path at most, and to its first point; how far one of them goes, and the distance from where none is tried.
const CORRECTORS: u32 = 5;
const FIRST_CORRECTORS: u32 = 100;
const CORRECTION: f64 = 0.7;
const FAR: f64 = 3.0;
/// Cosine of the angle between the tangent and the direction in which the path came: where the path bends, where it bends much, and
/// where a step has jumped off it.
const BENT: f64 = 0.97;
const SHARP: f64 = 0.95;
const JUMPED: f64 = 0.7;
/// How the reach changes: after a step that needed no correction, in bends, after two and after more corrections, and on going back.
const LONGER: f64 = 1.5;
const IN_BENDS: f64 = 0.7;
const AFTER_TWO: f64 = 0.8;
const AFTER_MORE: f64 = 0.5;
const BACK: f64 = 0.3;
/// The reach is at most so many times what the last series allowed.
const BEYOND: f64 = 2.0;

/// What controls the steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    reach: f64,
    /// Corrections since the last step along the path.
    pub correctors: u32,
    /// Whether the path bends, or steps failed.
    careful: bool,
    /// Whether the parameter is where the path ends.
    pub is_landing: bool,
    /// How often steps from the last place failed, and the reach of the first of them.
    failures: u32,
    failed_reach: f64,
}

/// A point of a path, or near it.
pub(super) struct Point<'a> {
    /// Newton's step to the path at the present parameter, and the rates along the path for one unit of it.
    pub correction: &'a Rates,
    pub tangent: &'a Rates,
    /// The part of the correction that keeps all numbers positive.
    pub boundary: f64,
    /// The sign of the parameter's change with which the path begins.
    pub ahead: f64,
    /// The sign of that change here if the point is on the path, and was not passed through the other way round.
    pub orientation: f64,
}

/// What to do at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Move {
    /// To the last place, and more carefully on.
    Back,
    /// Part of Newton's step to the path, and so much along the tangent.
    Correct { part: f64, along: f64 },
    /// A step along the path; whether the place is very close to it.
    Advance { ahead: Ahead, closest: bool },
    /// Newton's step to the path, which ends there.
    Land,
}

impl Control {
    pub fn new() -> Self {
        Self { reach: FIRST_REACH, correctors: 0, careful: false, is_landing: false, failures: 0, failed_reach: 0.0 }
    }

    /// What to do at a point; where that is a step along the path, `direction`, in which the path came there, becomes that of its
    /// tangent.
    ///
    /// A step may have jumped to another part of the path, or to another path. Where that is passed through the other way round,
    /// the orientation shows it.
    pub fn decide(&mut self, point: &Point, direction: &mut Vec<f64>) -> Move {
        let (correction, tangent) = (&point.correction.relative, &point.tangent.relative);
        let size = inner(tangent, tangent).sqrt();
        let started = !direction.is_empty();
        let onward = if started { inner(tangent, direction) } else { point.ahead };
        let turn = if started { onward.abs() / size } else { 1.0 };
        // The correction is made across the path's direction, the first one without leaving the parameter.
        let along = if started && !self.is_landing { -inner(direction, correction) / onward } else { 0.0 };
        let distance = correction.iter().zip(tangent).fold(0.0, |m: f64, (c, t)| m.max((c + along * t).abs()));
        let wary = self.correctors > 0 || self.careful || turn < BENT;
        let (part, most) = if wary { (CLOSER, MOST_DISTANCE[1]) } else { (CLOSE, MOST_DISTANCE[0]) };
        let enough = if started { (part * self.reach).clamp(LEAST_DISTANCE, most) } else { LANDED };
        let is_close = distance <= enough;
        let jumped = turn < JUMPED || onward * point.orientation < 0.0;
        let lost = self.correctors >= CORRECTORS || distance > FAR || (is_close && !self.is_landing && jumped);
        if started && lost || self.correctors >= FIRST_CORRECTORS {
            return Move::Back;
        }
        if self.is_landing && distance <= LANDED {
            return Move::Land;
        }
        if self.is_landing || !is_close {
            self.correctors += 1;
            return Move::Correct {
                part: if started { (CORRECTION / distance).min(1.0) } else { point.boundary },
                along,
            };
        }
        self.reach *= match self.correctors {
            _ if turn < SHARP => IN_BENDS,
            0 if distance < CLOSEST && !self.careful => LONGER,
            0 | 1 => 1.0,
            2 => AFTER_TWO,
            _ => AFTER_MORE,
        };
        self.reach = self.reach.min(MOST_REACH);
        (self.correctors, self.careful) = (0, turn < BENT);
        if self.reach >= self.failed_reach {
            self.failures = 0;
        }
        let largest = tangent.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let ahead = Ahead { along: onward.signum() / size, length: self.reach * size / largest, correction: along };
        direction.clear();
        direction.extend(tangent.iter().map(|t| ahead.along * t));
        Move::Advance { ahead, closest: distance <= CLOSEST * self.reach }
    }

    /// Notes which part of the length ahead a step has taken.
    pub fn note(&mut self, part: f64) {
        self.reach *= (BEYOND * part).min(1.0);
    }

    /// Whether the place to go back to is the one that was closer to the path: every second time. Nothing if steps have become too
    /// small.
    pub fn go_back(&mut self) -> Option<bool> {
        self.failures += 1;
        if self.failures == 1 {
            self.failed_reach = self.reach;
        }
        self.reach *= BACK;
        (self.correctors, self.careful, self.is_landing) = (0, true, false);
        (self.reach >= LEAST_REACH).then_some(self.failures.is_multiple_of(2))
    }
}
