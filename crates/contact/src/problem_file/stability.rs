//! Verdicts of statics with their proofs as files.

use std::path::Path;

use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::{fault, in_file};
use super::solutions::{finite, read_arrays, write_arrays};
use crate::statics::{ModeTree, StabilityProof, StaysProof, Verdict, without_contact_friction};
use crate::{ContactProblem, ContactSolution, ProblemError};

const KIND: &str = "stability";

/// Whether a file holds a verdict of statics.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file.
pub fn is_stability(path: impl AsRef<Path>) -> Result<bool, ProblemError> {
    let archive = Archive::read(path)?;
    Ok(archive.contains("kind") && archive.string("kind")? == KIND)
}

/// Writes a verdict with its proof: `kind` = "stability", `verdict`, and what it needs of `motion` (a mechanism), `balance_…`, `moving_…`,
/// `without_friction_…` (solutions, with the names of [solution files](super::write_contact_solution)), `tree_branches` and
/// `tree_multipliers`.
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_stability(path: impl AsRef<Path>, proof: &StabilityProof) -> Result<(), ProblemError> {
    let mut writer = ArchiveWriter::new();
    writer.string("kind", KIND)?.string("verdict", proof.verdict.name())?;
    if let Some(motion) = &proof.mechanism {
        writer.f64("motion", &[motion.len()], motion)?;
    }
    for (prefix, solution) in [("balance_", &proof.balance), ("moving_", &proof.moving)] {
        if let Some(solution) = solution {
            write_arrays(&mut writer, prefix, solution)?;
        }
    }
    match &proof.stays {
        Some(StaysProof::WithoutFriction(solution)) => write_arrays(&mut writer, "without_friction_", solution)?,
        Some(StaysProof::Modes(tree)) => {
            writer.i32("tree_branches", &[tree.branches.len()], &tree.branches)?;
            writer.f64("tree_multipliers", &[tree.multipliers.len()], &tree.multipliers)?;
        }
        None => {}
    }
    writer.write(path)?;
    Ok(())
}

/// Reads a verdict with its proof.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::File`] for an unknown verdict,
/// [`ProblemError::InFile`] for an array that does not fit the problem.
pub fn read_stability(path: impl AsRef<Path>, problem: &ContactProblem) -> Result<StabilityProof, ProblemError> {
    let archive = Archive::read(path)?;
    read_proof(&archive, problem).map_err(|error| in_file(&archive, error))
}

fn read_proof(archive: &Archive, problem: &ContactProblem) -> Result<StabilityProof, ProblemError> {
    let name = archive.string("verdict")?;
    let verdict = Verdict::named(&name).ok_or_else(|| {
        let known = "must_move, stays, may_do_either, stands";
        fault(archive, format!("unknown verdict '{name}'; known are {known}"))
    })?;
    let solution = |prefix: &str, problem: &ContactProblem| -> Result<Option<Box<ContactSolution>>, ProblemError> {
        if !archive.contains(&format!("{prefix}lambda_n")) {
            return Ok(None);
        }
        Ok(Some(Box::new(read_arrays(archive, prefix, problem)?)))
    };
    let mut proof = StabilityProof::new(verdict);
    if archive.contains("motion") {
        let motion = archive.f64("motion")?;
        if motion.len() != problem.nv() {
            return Err(ProblemError::Length { array: "motion", expected: problem.nv(), found: motion.len() });
        }
        finite("motion", &motion)?;
        proof.mechanism = Some(motion);
    }
    proof.balance = solution("balance_", problem)?;
    proof.moving = solution("moving_", problem)?;
    if let Some(balance) = solution("without_friction_", &without_contact_friction(problem))? {
        proof.stays = Some(StaysProof::WithoutFriction(balance));
    } else if archive.contains("tree_branches") {
        let (branches, multipliers) = (archive.i32("tree_branches")?, archive.f64("tree_multipliers")?);
        finite("tree_multipliers", &multipliers)?;
        proof.stays = Some(StaysProof::Modes(ModeTree { branches, multipliers }));
    }
    Ok(proof)
}
