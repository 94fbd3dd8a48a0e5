//! Solutions with the circular cone as files.

use std::path::Path;

use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::{fault, in_file};
use super::solutions::finite;
use crate::{ConeSolution, ProblemError};

/// The field `law` of a solution with the circular cone; files with the polygon's laws have no such field.
const LAW: &str = "circular";

/// Writes a solution with the circular cone: `law = "circular"`, `v`, `impulse` (nc × 3: normal, tangent 1, tangent 2), `lambda_b`,
/// and, where there are friction groups, their impulses `impulse_F` (nf × 2).
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_cone_solution(path: impl AsRef<Path>, solution: &ConeSolution) -> Result<(), ProblemError> {
    let (velocity, bilateral) = (&solution.velocity, &solution.bilateral);
    let mut writer = ArchiveWriter::new();
    writer.string("law", LAW)?.f64("v", &[velocity.len()], velocity)?;
    writer.f64("impulse", &[solution.impulse.len(), 3], solution.impulse.as_flattened())?;
    writer.f64("lambda_b", &[bilateral.len()], bilateral)?;
    if !solution.group_impulse.is_empty() {
        writer.f64("impulse_F", &[solution.group_impulse.len(), 2], solution.group_impulse.as_flattened())?;
    }
    writer.write(path)?;
    Ok(())
}

/// Whether a solution file says that its law is the circular cone.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file, [`ProblemError::File`] for a law that is not known.
pub fn is_cone_solution(path: impl AsRef<Path>) -> Result<bool, ProblemError> {
    let archive = Archive::read(path)?;
    if !archive.contains("law") {
        return Ok(false);
    }
    match archive.string("law")?.as_str() {
        LAW => Ok(true),
        law => Err(fault(&archive, format!("unknown law '{law}'; known is {LAW}, and no field for the polygon's"))),
    }
}

/// Reads the velocity and impulses of a solution with the circular cone; its certificate is left for
/// [`certify_cone`](crate::certify_cone).
///
/// - `nv`, `nc`, `nb`: degrees of freedom, contacts and bilateral rows; a problem in impulse space has `nv = nb = 0`. The certificate
///   asks whether the number of friction groups fits
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::InFile`] with a
/// [`ProblemError::Length`] or [`ProblemError::Number`] for an array that does not fit.
pub fn read_cone_solution(
    path: impl AsRef<Path>,
    nv: usize,
    nc: usize,
    nb: usize,
) -> Result<ConeSolution, ProblemError> {
    let archive = Archive::read(path)?;
    let array = |name: &'static str, expected: usize| -> Result<Vec<f64>, ProblemError> {
        let values = archive.f64(name)?;
        if values.len() != expected {
            let length = ProblemError::Length { array: name, expected, found: values.len() };
            return Err(in_file(&archive, length));
        }
        finite(name, &values).map_err(|error| in_file(&archive, error))?;
        Ok(values)
    };
    let impulse = array("impulse", 3 * nc)?.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let groups = if archive.contains("impulse_F") { archive.f64("impulse_F")? } else { Vec::new() };
    finite("impulse_F", &groups).map_err(|error| in_file(&archive, error))?;
    Ok(ConeSolution {
        velocity: array("v", nv)?,
        impulse,
        group_impulse: groups.as_chunks().0.to_vec(),
        bilateral: array("lambda_b", nb)?,
        ..ConeSolution::default()
    })
}
