//! Proofs that a problem has no solution, as files.

use std::path::Path;

use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::in_file;
use super::solutions::finite;
use crate::{ContactProblem, GapContradiction, ProblemError};

const KIND: &str = "infeasible";

/// Whether a file holds a proof that gaps and bilateral rows contradict each other.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file.
pub fn is_contradiction(path: impl AsRef<Path>) -> Result<bool, ProblemError> {
    let archive = Archive::read(path)?;
    Ok(archive.contains("normal") && archive.contains("kind") && archive.string("kind")? == KIND)
}

/// Writes a proof: `kind` = "infeasible", `normal` (nc) and `bilateral` (nb), the multipliers of [`GapContradiction`].
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_contradiction(path: impl AsRef<Path>, proof: &GapContradiction) -> Result<(), ProblemError> {
    let mut writer = ArchiveWriter::new();
    writer.string("kind", KIND)?;
    for (name, x) in [("normal", &proof.normal), ("bilateral", &proof.bilateral)] {
        writer.f64(name, &[x.len()], x)?;
    }
    writer.write(path)?;
    Ok(())
}

/// Reads a proof.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::InFile`] for an array that does not fit the problem
/// or holds a number that is not finite.
pub fn read_contradiction(path: impl AsRef<Path>, problem: &ContactProblem) -> Result<GapContradiction, ProblemError> {
    let archive = Archive::read(path)?;
    let read = |array: &'static str, expected: usize| -> Result<Vec<f64>, ProblemError> {
        let x = archive.f64(array)?;
        if x.len() != expected {
            return Err(ProblemError::Length { array, expected, found: x.len() });
        }
        finite(array, &x)?;
        Ok(x)
    };
    let (nc, nb) = (problem.contact_count(), problem.bilateral_violation.len());
    let proof =
        read("normal", nc).and_then(|normal| Ok(GapContradiction { normal, bilateral: read("bilateral", nb)? }));
    proof.map_err(|error| in_file(&archive, error))
}
