//! The verdict on a contact problem at rest.

use signorini_contact::statics::{
    MechanismCertificate, StabilityProof, StaysProof, Verdict, certify_stability, check_at_rest,
};
use signorini_contact::{ContactProblem, ProblemError};

use crate::balance::polished;
use crate::enumeration::{Enumerated, enumerate};
use crate::mechanism::BalanceProgram;
use crate::search::{Search, SearchRun};
use crate::settings::StabilitySettings;

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
/// First what the structured solver finds from nothing; where that moves, the linear program between balance and mechanism. Of a balance,
/// whether there is one without the friction of contacts (then nothing can move); if not, the search for a moving solution, and the
/// enumeration of modes where the problem is small.
///
/// # Errors
/// [`ProblemError`] if the problem is malformed or not [at rest](check_at_rest); [`ProblemError::NotASolution`] if neither a balance nor a
/// mechanism was found to the accuracy asked for, which a problem within rounding of its limit can do.
pub fn judge(problem: &ContactProblem, settings: &StabilitySettings) -> Result<Stability, ProblemError> {
    problem.check()?;
    check_at_rest(problem)?;
    let mut search = Search::new();
    search.cold(problem, settings);
    if search.balance.is_none() {
        let answer = BalanceProgram::new(problem).solve();
        if let Some(answer) = answer {
            let (motion, certificate) = answer.mechanism;
            if certificate.residual <= settings.tolerance {
                return Ok(must_move(problem, motion, certificate, search));
            }
            search.balance = polished(problem, &answer.impulses, search.solver(), settings);
            if search.balance.is_none() {
                let residual = certificate.residual.min(answer.impulses.certificate.worst());
                return Err(ProblemError::NotASolution { residual });
            }
        }
    }
    if search.balance.is_none() {
        return Err(ProblemError::NotASolution { residual: f64::INFINITY });
    }
    Ok(with_balance(problem, search, settings))
}

fn must_move(
    problem: &ContactProblem,
    motion: Vec<f64>,
    certificate: MechanismCertificate,
    search: Search,
) -> Stability {
    let mut proof = StabilityProof::new(Verdict::MustMove);
    proof.mechanism = Some(motion);
    // What follows is a moving solution; it belongs to the report.
    proof.moving = search.moving.map(Box::new);
    finish(problem, proof, Some(certificate), search.runs, 0)
}

fn with_balance(problem: &ContactProblem, mut search: Search, settings: &StabilitySettings) -> Stability {
    let mut programs = 0;
    let mut stays = None;
    if search.moving.is_none() {
        let without = search.balance_without_friction(problem, settings);
        stays = without.map(|balance| StaysProof::WithoutFriction(Box::new(balance)));
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
    finish(problem, proof, None, search.runs, programs)
}

fn finish(
    problem: &ContactProblem,
    proof: StabilityProof,
    mechanism: Option<MechanismCertificate>,
    search: Vec<SearchRun>,
    enumeration_programs: usize,
) -> Stability {
    let residuals = certify_stability(problem, &proof);
    Stability { proof, residuals, mechanism, search, enumeration_programs }
}
