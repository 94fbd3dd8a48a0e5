//! Where motion may begin, beside where forces cease to balance the loads.

use signorini_contact::ContactProblem;
use signorini_contact::statics::{StabilityProof, Verdict, friction_only_resists};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::family::Family;
use crate::question::SafetyQuestion;
use crate::safety::{Safety, farthest_limit, middle};
use crate::search::Search;
use crate::settings::StabilitySettings;
use crate::verdict::decide;

/// Halvings of the interval between a value without and one with a moving solution.
const HALVINGS: u32 = 80;
/// Two values this near, relative to the larger, are the limit.
const CLOSE: f64 = 1e-7;

/// Where the first step from rest may begin to move.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MotionLimit {
    /// The static limit: where forces cease to balance the loads.
    pub statics: Safety,
    /// The search for a moving solution found none here.
    pub still: f64,
    /// A moving solution exists from here on as far as was looked: it is certified at this value.
    pub moves: f64,
    /// The problem at [`moves`](Self::moves) with its balance and its moving solution; nothing where motion begins at the static limit.
    pub at_moves: Option<(ContactProblem, StabilityProof)>,
}

impl Configuration<'_> {
    /// Where the first step from rest begins to move: as friction is not associated, that may be before the static limit.
    ///
    /// Halves the interval up to the static limit by what the search for a moving solution ends with, to 1e-7. That something moves
    /// is proved; that nothing does is not ([`Verdict::Stands`]), and a value below `still` may have a moving solution, too.
    ///
    /// # Errors
    /// As [`safety`](Self::safety).
    pub fn motion_limit(
        &self,
        settings: &StabilitySettings,
        question: &SafetyQuestion,
    ) -> Result<MotionLimit, SimulationError> {
        let family = Family::new(self, settings, question)?;
        let [begin, end] = question.range();
        let statics = farthest_limit(&family, [begin, end], settings);
        let mut found = MotionLimit { still: statics.holds, moves: statics.falls, at_moves: None, statics };
        if found.statics.holds.is_nan() || !found.take(&family, found.statics.holds, settings) {
            return Ok(found);
        }
        if found.take(&family, begin, settings) {
            found.still = f64::NAN;
            return Ok(found);
        }
        found.still = begin;
        for _ in 0..HALVINGS {
            let (still, moves) = (found.still, found.moves);
            if (moves - still).abs() <= CLOSE * moves.abs().max(still.abs()) {
                break;
            }
            let between = middle(still, moves);
            if !found.take(&family, between, settings) {
                found.still = between;
            }
        }
        Ok(found)
    }
}

impl MotionLimit {
    /// Looks for a moving solution at a value; whether there is one.
    fn take(&mut self, family: &Family, value: f64, settings: &StabilitySettings) -> bool {
        let problem = family.at(value);
        let mut search = Search::new();
        if friction_only_resists(&problem) && search.balance_without_friction(&problem, settings).is_some() {
            return false;
        }
        if let Some(near) = self.at_moves.as_ref().and_then(|(_, proof)| proof.moving.as_deref()) {
            search.start_near(&problem, near, settings);
        }
        search.for_motion(&problem, settings);
        let Some(moving) = search.moving.take() else { return false };
        let mut proof = StabilityProof::new(Verdict::MayDoEither);
        if search.balance.is_none() {
            decide(&problem, &mut search, settings);
        }
        proof.balance = search.balance.map(Box::new);
        proof.moving = Some(Box::new(moving));
        (self.moves, self.at_moves) = (value, Some((problem, proof)));
        true
    }
}
