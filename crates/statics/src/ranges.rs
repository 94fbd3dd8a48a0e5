//! What a balance leaves open: the range of every contact force over all balances.

use signorini_contact::ProblemError;
use signorini_laws::force_distributions;

use crate::model::ModelStability;

/// The forces of a contact over all balances.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ForceRange {
    /// Normal force, N (of a limit N or N·m), least and largest; infinite where contacts can press against each other without bound.
    /// Negative where what [attracts](crate::Attraction) the bodies is needed.
    pub normal: [f64; 2],
    /// Forces along the two tangents of the contact's frame, N, least and largest.
    pub tangential: [[f64; 2]; 2],
}

impl ModelStability {
    /// The range of every contact's force over all forces that balance the loads; none where the verdict has no balance.
    ///
    /// Statics alone does not say more: which of them act depends on how the contacts came about. By two linear programs for each
    /// component that the balance does not fix ([`force_distributions`]), in dense matrices: for problems of up to some hundred contacts.
    ///
    /// # Errors
    /// [`ProblemError::Unsupported`] with friction of joints, servos, spinning or rolling.
    pub fn force_ranges(&self) -> Result<Vec<ForceRange>, ProblemError> {
        let problem = &self.rest.problem;
        let Some(balance) = &self.stability.proof.balance else { return Ok(Vec::new()) };
        let all = force_distributions(problem, balance)?;
        let newton = 1.0 / problem.timestep;
        let range = |i: usize| ForceRange {
            normal: [all.normal[i].min, all.normal[i].max].map(|p| p * newton - self.attraction[i]),
            tangential: all.tangential[i].map(|t| [t.min, t.max].map(|p| p * newton)),
        };
        Ok((0..problem.contact_count()).map(range).collect())
    }
}
