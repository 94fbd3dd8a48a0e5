//! How far a configuration at rest is from collapse, with a proof on either side of the limit.

use signorini_contact::ContactProblem;
use signorini_contact::statics::{StabilityProof, Verdict, certify_mechanism};
use signorini_multibody::{Input, Model, State};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::family::{Family, Kind};
use crate::question::SafetyQuestion;
use crate::search::Search;
use crate::settings::StabilitySettings;
use crate::verdict::{Decided, decide};

/// Halvings of the interval at most: from its whole range to the last digits.
const HALVINGS: u32 = 80;
/// Values at most at which neither proof can be had, before the limit is left at what is proved: all of them are within rounding of it.
const UNKNOWN: usize = 6;
/// Steps of a half turn, and tenths of a range that is looked at where its end proves nothing.
const TURNS: u32 = 12;
/// Two values this near, relative to the larger, are the limit.
const CLOSE: f64 = 1e-9;
/// How far beside a limit proofs are looked for, relative to it.
const NUDGE: f64 = 2e-10;

/// The limit of a safety question, between two values with a proof each.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Safety {
    /// The loads are balanced here, to [`balance_tolerance`](StabilitySettings::balance_tolerance). Where they are not even at the beginning (friction: as it is), this is no number.
    pub holds: f64,
    /// No forces balance them here; infinite (friction: no number) where they are balanced over the whole range: 10⁶, or as many times the loads where these are larger than what is increased, half a turn,
    /// no friction. No number as well where
    /// neither could be proved.
    pub falls: f64,
    /// The problem at [`holds`](Self::holds) with its balance. The verdict says `stands`: nothing was asked about motion.
    pub at_holds: Option<(ContactProblem, StabilityProof)>,
    /// The problem at [`falls`](Self::falls) with its mechanism.
    pub at_falls: Option<(ContactProblem, StabilityProof)>,
}

/// Finds the limit of a safety question to 1e-9 of its size, or as near as both proofs can be had.
///
/// Newton's method from above: the mechanism at a value shows that the loads are not balanced wherever they have power along it, so that
/// the next value is where they have none. Where that leads nowhere the interval is halved.
///
/// A limit of statics: up to it forces exist that balance the loads, and beyond it none do. As friction is not associated, motion may begin
/// earlier. Loads that are balanced at two values of a load's multiplier are balanced between them, and with more friction if with less.
///
/// # Errors
/// [`SimulationError::Setting`] for a direction without length or a load of another size than nv; otherwise as
/// [`stability`](crate::stability()).
pub fn safety(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &StabilitySettings,
    question: &SafetyQuestion,
) -> Result<Safety, SimulationError> {
    Configuration::new(model, state, input).safety(settings, question)
}

impl Configuration<'_> {
    /// How far it is from collapse, as [`safety`](crate::safety()).
    ///
    /// # Errors
    /// As [`safety`](crate::safety()).
    pub fn safety(&self, settings: &StabilitySettings, question: &SafetyQuestion) -> Result<Safety, SimulationError> {
        Ok(farthest_limit(&Family::new(self, settings, question)?, question.range(), settings))
    }
}

/// The limit of a family between a value at which it is looked for first, and one at which it is looked for at most.
pub(crate) fn limit(family: &Family, [begin, end]: [f64; 2], settings: &StabilitySettings) -> Safety {
    let mut found = Safety { holds: f64::NAN, falls: f64::NAN, at_holds: None, at_falls: None };
    if !found.take(family, begin, settings) || found.at_holds.is_none() {
        return found;
    }
    found.look_beyond(family, [begin, end], settings);
    if found.at_falls.is_none() {
        // Without a proof at the end of the range nothing is known of what lies beyond.
        found.falls = if end > begin && found.holds == end { f64::INFINITY } else { f64::NAN };
        return found;
    }
    let mut unknown = 0;
    for _ in 0..HALVINGS {
        let (holds, falls) = (found.holds, found.falls);
        if (holds - falls).abs() <= CLOSE * holds.abs().max(falls.abs()) {
            break;
        }
        if found.newton(family, settings) && (found.holds, found.falls) != (holds, falls) {
            continue;
        }
        // Near the limit rounding leaves values at which neither proof can be had; others of the interval may do.
        let (holds, falls) = (found.holds, found.falls);
        let middle = middle(holds, falls);
        let rest = [0.25, 0.75, 0.125, 0.875].map(|part| holds + part * (falls - holds));
        let known = std::iter::once(middle).chain(rest).position(|value| found.take(family, value, settings));
        unknown += known.unwrap_or(rest.len());
        if known.is_none() || unknown > UNKNOWN {
            break;
        }
    }
    found
}

/// The same, and where it is beyond a range of loads, so many times farther as the loads are larger than what is increased: a million newtons
/// are little to a bridge.
pub(crate) fn farthest_limit(family: &Family, [begin, end]: [f64; 2], settings: &StabilitySettings) -> Safety {
    let found = limit(family, [begin, end], settings);
    let far = end * family.as_large_as_loads();
    if found.falls == f64::INFINITY && far > end { limit(family, [begin, far], settings) } else { found }
}

/// Between two values: large ranges are halved by their exponents first.
pub(crate) fn middle(holds: f64, falls: f64) -> f64 {
    if holds > 0.0 && falls > 4.0 * holds {
        (holds * falls).sqrt()
    } else if holds == 0.0 && falls > 1.0 {
        falls.sqrt().min(0.5 * falls)
    } else {
        0.5 * (holds + falls)
    }
}

impl Safety {
    /// Looks for a value at which nothing balances the loads.
    fn look_beyond(&mut self, family: &Family, [begin, end]: [f64; 2], settings: &StabilitySettings) {
        let turns = matches!(family.kind, Kind::Turned(..));
        let value = |k: u32| match turns {
            // What falls at a quarter turn may be held when it is upside down.
            true => begin + (end - begin) * f64::from(k + 1) / f64::from(TURNS),
            false => begin + (end - begin) * 0.1_f64.powi(k as i32),
        };
        for k in 0..TURNS {
            let is_known = self.take(family, value(k), settings);
            if self.at_falls.is_some() || is_known && !turns {
                return;
            }
        }
    }

    /// Looks beside the value at which the loads have no power along the last mechanism; whether that showed anything.
    fn newton(&mut self, family: &Family, settings: &StabilitySettings) -> bool {
        let Some(proof) = self.at_falls.as_ref() else { return false };
        let Some(motion) = proof.1.mechanism.as_ref() else { return false };
        let (holds, falls) = (self.holds, self.falls);
        let Some(root) = family.powerless(motion, holds, falls) else { return false };
        let nudge = (falls - holds).signum() * NUDGE * root.abs().max(holds.abs());
        // The same mechanism proves as much just beyond.
        let beyond = root + nudge;
        if (beyond - holds).abs() < (falls - holds).abs() {
            let problem = family.at(beyond);
            if certify_mechanism(&problem, motion).residual <= settings.tolerance {
                let mut proof = StabilityProof::new(Verdict::MustMove);
                proof.mechanism = Some(motion.clone());
                (self.falls, self.at_falls) = (beyond, Some((problem, proof)));
            }
        }
        let before = root - nudge;
        let inside = (before - holds).signum() == (falls - holds).signum();
        inside && self.take(family, before, settings)
    }

    /// Looks at a value; whether a proof was found there.
    fn take(&mut self, family: &Family, value: f64, settings: &StabilitySettings) -> bool {
        let problem = family.at(value);
        let mut search = Search::new();
        match decide(&problem, &mut search, settings) {
            Decided::Balance => {
                let mut proof = StabilityProof::new(Verdict::Stands);
                proof.balance = search.balance.map(Box::new);
                (self.holds, self.at_holds) = (value, Some((problem, proof)));
            }
            Decided::Mechanism(mechanism) => {
                let mut proof = StabilityProof::new(Verdict::MustMove);
                // The motion of most power cuts deepest, where it proves as much.
                let sharp = certify_mechanism(&problem, &mechanism.collapse).residual <= settings.tolerance;
                proof.mechanism = Some(if sharp { mechanism.collapse } else { mechanism.motion });
                (self.falls, self.at_falls) = (value, Some((problem, proof)));
            }
            Decided::Neither { .. } => return false,
        }
        true
    }
}
