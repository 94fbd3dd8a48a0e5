//! What controls the steps along a central path: how far they go, when they are corrected, and when they have to be repeated.

use super::series::{Ahead, Rates};
use signorini_contact::vector::inner;

/// What is tuned in the steps along a path.
struct Tuning {
    /// The largest relative change of a number along the tangent in the first step, and where steps have become too small.
    first_reach: f64,
    least_reach: f64,
    /// The distance from the path at most at which a step along it is made, if the reach is more than twice that.
    most_distance: f64,
    /// Newton steps back to the path at most; none of them goes farther than the first reach.
    correctors: u32,
}

/// Chosen by: `contact_lcp --seeds 74..76 --directions 4,8,16 --no-growth --no-shared`, 23 November 2026; `most_distance` by the same and `random_steps`, 26 November 2026.
const TUNING: Tuning = Tuning { first_reach: 0.5, least_reach: 1e-5, most_distance: 0.1, correctors: 5 };

/// What controls the steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    reach: f64,
    /// Corrections since the last step along the path.
    correctors: u32,
    /// Whether the last step failed.
    careful: bool,
    /// Whether the parameter is where the path ends.
    pub is_landing: bool,
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

/// Where a point is, seen from the path.
struct View {
    /// Whether the path came there in a direction, and is not at its first point.
    started: bool,
    /// The tangent's length, and its part in the direction in which the path came.
    size: f64,
    onward: f64,
    /// How much of the tangent belongs to the step to the path.
    along: f64,
    /// The largest relative change of a number in that step.
    distance: f64,
    /// Whether a step has jumped to another part of the path, or to another path. Where that is passed through the other way round,
    /// the orientation shows it.
    jumped: bool,
}

/// What to do at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Move {
    /// To the last place, and more carefully on.
    Back,
    /// Part of Newton's step to the path, and so much along the tangent.
    Correct { part: f64, along: f64 },
    /// A step along the path.
    Advance(Ahead),
    /// Newton's step to the path, which ends there.
    Land,
}

impl Control {
    pub fn new() -> Self {
        Self { reach: TUNING.first_reach, correctors: 0, careful: false, is_landing: false }
    }

    /// What to do at a point; where that is a step along the path, `direction`, in which the path came there, becomes that of its
    /// tangent. `most`: Newton steps to the first point at most.
    pub fn decide(&mut self, point: &Point, direction: &mut Vec<f64>, most: u32) -> Move {
        let view = self.view(point, direction);
        let is_close = view.distance <= (0.5 * self.reach).clamp(TUNING.least_reach, TUNING.most_distance);
        let is_lost = self.correctors >= TUNING.correctors || (is_close && !self.is_landing && view.jumped);
        if view.started && is_lost || self.correctors >= most {
            return Move::Back;
        }
        if self.is_landing && view.distance <= TUNING.most_distance {
            return Move::Land;
        }
        if self.is_landing || !is_close {
            self.correctors += 1;
            let part = if view.started { (TUNING.first_reach / view.distance).min(1.0) } else { point.boundary };
            return Move::Correct { part, along: view.along };
        }
        self.advance(point, &view, direction)
    }

    fn view(&self, point: &Point, direction: &[f64]) -> View {
        let (correction, tangent) = (&point.correction.relative, &point.tangent.relative);
        let (size, started) = (inner(tangent, tangent).sqrt(), !direction.is_empty());
        let onward = if started { inner(tangent, direction) } else { point.ahead };
        // The correction is made across the path's direction, the first one without leaving the parameter.
        let along = if started && !self.is_landing { -inner(direction, correction) / onward } else { 0.0 };
        let distance = correction.iter().zip(tangent).fold(0.0, |m: f64, (c, t)| m.max((c + along * t).abs()));
        View { started, size, onward, along, distance, jumped: onward * point.orientation < 0.0 }
    }

    fn advance(&mut self, point: &Point, view: &View, direction: &mut Vec<f64>) -> Move {
        self.reach *= match self.correctors {
            0 if !self.careful => 2.0,
            0 | 1 => 1.0,
            _ => 0.5,
        };
        (self.correctors, self.careful) = (0, false);
        let tangent = &point.tangent.relative;
        let largest = tangent.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let along = view.onward.signum() / view.size;
        direction.clear();
        direction.extend(tangent.iter().map(|t| along * t));
        Move::Advance(Ahead { along, length: self.reach * view.size / largest, correction: view.along })
    }

    /// Notes which part of the length ahead a step has taken: the next one may go twice as far.
    pub fn note(&mut self, part: f64) {
        self.reach *= (2.0 * part).min(1.0);
    }

    /// Before a step is made again; `false` if steps have become too small.
    pub fn go_back(&mut self) -> bool {
        self.reach *= 0.5;
        (self.correctors, self.careful, self.is_landing) = (0, true, false);
        self.reach >= TUNING.least_reach
    }
}
