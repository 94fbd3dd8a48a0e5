//! Proofs that no case of a complementarity problem has a solution, as files.

use std::path::Path;

use signorini_complementarity::{ExcludedCase, Exclusion, MixedLcp, PairCase};
use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::in_file;
use super::solutions::finite;
use crate::ProblemError;

/// The numbers of the cases of a pair in a file.
const PAIRS: [PairCase; 3] = [PairCase::Open, PairCase::NoZ, PairCase::NoW];

/// Whether a file holds a proof that cases of a complementarity problem have no solution.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file.
pub fn is_exclusion(path: impl AsRef<Path>) -> Result<bool, ProblemError> {
    let archive = Archive::read(path)?;
    Ok(archive.contains("kind") && archive.contains("cases") && archive.contains("multipliers"))
}

/// Writes a proof: `kind` = "infeasible" or "no_solution", `cases` (count, n; 0: the pair is open, 1: `z = 0`, 2: `w = 0`) and
/// `multipliers` (count, n) of each.
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_exclusion(path: impl AsRef<Path>, proof: &Exclusion) -> Result<(), ProblemError> {
    let (count, n) = (proof.cases.len(), proof.cases.first().map_or(0, |case| case.pairs.len()));
    let number = |pair: &PairCase| PAIRS.iter().position(|known| known == pair).unwrap_or(0) as u8;
    let cases: Vec<u8> = proof.cases.iter().flat_map(|case| case.pairs.iter().map(number)).collect();
    let multipliers: Vec<f64> = proof.cases.iter().flat_map(|case| case.multipliers.iter().copied()).collect();
    let mut writer = ArchiveWriter::new();
    writer.string("kind", if proof.is_infeasible() { "infeasible" } else { "no_solution" })?;
    writer.u8("cases", &[count, n], &cases)?;
    writer.f64("multipliers", &[count, n], &multipliers)?;
    writer.write(path)?;
    Ok(())
}

/// Reads a proof for a problem.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::InFile`] for an array that does not fit the problem,
/// an unknown case, or a number that is not finite.
pub fn read_exclusion(path: impl AsRef<Path>, problem: &MixedLcp) -> Result<Exclusion, ProblemError> {
    let archive = Archive::read(path)?;
    let n = problem.len().max(1);
    let read = || -> Result<Exclusion, ProblemError> {
        let (cases, multipliers) = (archive.u8("cases")?, archive.f64("multipliers")?);
        let rows = |array, found: usize| {
            let whole = found.is_multiple_of(n) && found > 0;
            if whole { Ok(found / n) } else { Err(ProblemError::Length { array, expected: n, found }) }
        };
        let (count, found) = (rows("cases", cases.len())?, rows("multipliers", multipliers.len())?);
        if count != found {
            return Err(ProblemError::Length { array: "multipliers", expected: count * n, found: found * n });
        }
        finite("multipliers", &multipliers)?;
        if let Some(index) = cases.iter().position(|&k| k as usize >= PAIRS.len()) {
            let value = f64::from(cases[index]);
            return Err(ProblemError::Number { array: "cases", index, value, expected: "0, 1 or 2" });
        }
        let case = |(pairs, y): (&[u8], &[f64])| ExcludedCase {
            pairs: pairs.iter().map(|&k| PAIRS[k as usize]).collect(),
            multipliers: y.to_vec(),
        };
        Ok(Exclusion { cases: cases.chunks(n).zip(multipliers.chunks(n)).map(case).collect() })
    };
    read().map_err(|error| in_file(&archive, error))
}
