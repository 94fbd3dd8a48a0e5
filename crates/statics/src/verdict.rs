//! The verdict on a contact problem at rest.

use signorini_contact::statics::{
    MechanismCertificate, StabilityProof, StaysProof, Verdict, certify_stability, check_at_rest, friction_only_resists,
};
use signorini_contact::{ContactProblem, ContactSolution, ProblemError};

use crate::balance::{polished, with_idle_friction};
use crate::enumeration::{Enumerated, enumerate};
use crate::interior::{Forces, has_contacts_alone};
use crate::mechanism::{BalanceProgram, Collapse, shows};
use crate::search::{Search, SearchRun};
use crate::settings::StabilitySettings;

/// Contacts at most for which the collapse is looked for once more.
const SHOWN: usize = 300;

/// A verdict with its proof and what was done for it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Stability {
    /// The verdict with what proves it.
    pub proof: StabilityProof,
    /// How far the proof is from one without rounding ([`certify_stability`]).
    pub residuals: Vec<(&'static str, f64)>,
    /// What the mechanism of `MustMove` shows.
    pub mechanism: Option<MechanismCertificate>,
    /// The collapse that `MustMove` leads to in the sense of limit analysis, `[nv]`, m/s or rad/s: the mechanism along which the loads have most
    /// power. The one in the proof may open contacts beside it.
    pub collapse: Option<Vec<f64>>,
    /// The search for a moving solution.
    pub search: Vec<SearchRun>,
    /// Linear programs of the enumeration of modes.
    pub enumeration_programs: usize,
}

impl Stability {
    /// The verdict.
    pub fn verdict(&self) -> Verdict {
        self.proof.verdict
    }

    /// The worst residual of the proof.
    pub fn worst(&self) -> f64 {
        self.residuals.iter().fold(0.0, |worst, (_, r)| if r.is_nan() { f64::INFINITY } else { r.max(worst) })
    }
}

/// Judges a problem at rest.
///
/// First whether there is a balance without the friction of contacts: then nothing can move. If not, forces or a mechanism by an
/// interior-point method in blocks of bodies; with joints and friction that no contact bounds what the structured solver finds from
/// nothing, then a linear program. Of a balance, the search for a moving solution, and the enumeration of modes where the problem is small.
///
/// # Errors
/// [`ProblemError`] if the problem is malformed or not [at rest](check_at_rest); [`ProblemError::NotASolution`] if neither a balance nor a
/// mechanism was found to the accuracy asked for, which a problem within rounding of its limit can do.
pub fn judge(problem: &ContactProblem, settings: &StabilitySettings) -> Result<Stability, ProblemError> {
    problem.check()?;
    check_at_rest(problem)?;
    let mut search = Search::new();
    let without =
        if friction_only_resists(problem) { search.balance_without_friction(problem, settings) } else { None };
    // Beside it no solution moves, and none needs to be looked for.
    search.balance = without.as_ref().and_then(|without| with_idle_friction(problem, without, settings));
    if search.balance.is_some() {
        return Ok(with_balance(problem, search, without, settings));
    }
    match decide(problem, &mut search, settings) {
        Decided::Balance => Ok(with_balance(problem, search, without, settings)),
        Decided::Mechanism(mechanism) => Ok(must_move(problem, shown(problem, *mechanism), search)),
        Decided::Neither { residual } => Err(ProblemError::NotASolution { residual }),
    }
}

/// Whether the loads of a problem can be balanced.
pub(crate) enum Decided {
    /// The search has a balance.
    Balance,
    /// A mechanism proves the contrary.
    Mechanism(Box<Collapse>),
    /// Neither was found to the accuracy asked for; what the better of the two lacks.
    Neither {
        /// Residual.
        residual: f64,
    },
}

/// Finds a balance or a mechanism.
pub(crate) fn decide(problem: &ContactProblem, search: &mut Search, settings: &StabilitySettings) -> Decided {
    match search.forces(problem, settings) {
        Forces::Balance(balance) => {
            search.balance = Some(*balance);
            return Decided::Balance;
        }
        Forces::Mechanism(collapse) => return Decided::Mechanism(collapse),
        // Of contacts alone nothing is known only within rounding of a limit, where the solver is slow.
        Forces::Unknown if has_contacts_alone(problem) => {}
        Forces::Unknown => search.cold(problem, settings),
    }
    if search.balance.is_some() {
        return Decided::Balance;
    }
    let Some(answer) = BalanceProgram::new(problem).solve() else {
        return Decided::Neither { residual: f64::INFINITY };
    };
    let (motion, certificate) = answer.mechanism;
    if certificate.residual <= settings.tolerance {
        return Decided::Mechanism(Box::new(Collapse { motion, certificate, collapse: answer.collapse }));
    }
    search.balance = polished(problem, &answer.impulses, search.solver(), settings);
    match search.balance {
        Some(_) => Decided::Balance,
        None => Decided::Neither { residual: certificate.residual.min(answer.impulses.certificate.worst()) },
    }
}

/// The mechanism with a collapse from the middle of those that have most power, where the problem is small: of many it is the one without
/// motion that nothing asks for, such as a turn of a box that slides.
fn shown(problem: &ContactProblem, mut mechanism: Collapse) -> Collapse {
    if problem.contact_count() <= SHOWN
        && let Some(answer) = BalanceProgram::new(problem).solve()
        && shows(problem, &answer.collapse)
    {
        mechanism.collapse = answer.collapse;
    } else if !shows(problem, &mechanism.collapse) {
        mechanism.collapse.clone_from(&mechanism.motion);
    }
    mechanism
}

fn must_move(problem: &ContactProblem, mechanism: Collapse, search: Search) -> Stability {
    let mut proof = StabilityProof::new(Verdict::MustMove);
    proof.mechanism = Some(mechanism.motion);
    // What follows is a moving solution; it belongs to the report.
    proof.moving = search.moving.map(Box::new);
    let mut found = finish(problem, proof, search.runs, 0);
    (found.mechanism, found.collapse) = (Some(mechanism.certificate), Some(mechanism.collapse));
    found
}

/// The verdict where forces balance the loads; `without`: those without the friction of contacts, if they do.
fn with_balance(
    problem: &ContactProblem,
    mut search: Search,
    without: Option<ContactSolution>,
    settings: &StabilitySettings,
) -> Stability {
    let mut programs = 0;
    let mut stays = without.map(|balance| StaysProof::WithoutFriction(Box::new(balance)));
    if search.moving.is_some() {
        stays = None;
    }
    if search.moving.is_none() && stays.is_none() {
        search.for_motion(problem, settings);
    }
    if search.moving.is_none() && stays.is_none() && settings.enumeration_programs > 0 {
        let (ended, count) = enumerate(problem, &mut search, settings);
        programs = count;
        if let Enumerated::None(tree) = ended {
            stays = Some(StaysProof::Modes(tree));
        }
    }
    let verdict = match (&search.moving, &stays) {
        (Some(_), _) => Verdict::MayDoEither,
        (None, Some(_)) => Verdict::Stays,
        (None, None) => Verdict::Stands,
    };
    let mut proof = StabilityProof::new(verdict);
    proof.balance = search.balance.map(Box::new);
    proof.moving = search.moving.map(Box::new);
    proof.stays = stays;
    finish(problem, proof, search.runs, programs)
}

fn finish(
    problem: &ContactProblem,
    proof: StabilityProof,
    search: Vec<SearchRun>,
    enumeration_programs: usize,
) -> Stability {
    let residuals = certify_stability(problem, &proof);
    Stability { proof, residuals, mechanism: None, collapse: None, search, enumeration_programs }
}
