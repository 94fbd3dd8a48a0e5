//! The friction groups of a problem file.

use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::{SparseBuilder, fault, merge_rows, sparse_rows};
use crate::{ContactProblem, FrictionBound, FrictionPolygon, ProblemError};

/// Stands where a group has no contact.
const NO_CONTACT: i32 = -1;

/// Reads the groups of a file that has them: `JF` (2·nf × nv), `uF` (nf × 2), the bounds `rF + muF λ_N[cF]` with `cF = −1` where
/// there is no contact, `mF` (numbers of directions), `DF` (their sum × 2).
pub(super) fn read(archive: &Archive, problem: &mut ContactProblem) -> Result<(), ProblemError> {
    if !archive.contains("rF") {
        return Ok(());
    }
    let constants = archive.f64("rF")?;
    let nf = constants.len();
    let coefficients = archive.f64("muF")?;
    let (contacts, counts, target) = (archive.i32("cF")?, archive.i32("mF")?, archive.f64("uF")?);
    for (array, found, expected) in [
        ("muF", coefficients.len(), nf),
        ("cF", contacts.len(), nf),
        ("mF", counts.len(), nf),
        ("entries of uF", target.len(), 2 * nf),
    ] {
        if found != expected {
            return Err(ProblemError::Length { array, expected, found });
        }
    }
    let rows = sparse_rows(archive, "JF", (2 * nf, problem.nv()))?;
    let directions = archive.f64("DF")?;
    let total: usize = counts.iter().map(|&m| m.max(0) as usize).sum();
    if counts.iter().any(|m| *m < 0) || directions.len() != 2 * total {
        return Err(fault(archive, format!("DF has {} entries, mF asks for {}", directions.len(), 2 * total)));
    }
    let mut start = 0;
    for j in 0..nf {
        let end = start + 2 * counts[j] as usize;
        let own = directions[start..end].chunks_exact(2).map(|d| [d[0], d[1]]).collect();
        let polygon = FrictionPolygon::from_directions(own).map_err(|e| match e {
            ProblemError::Directions { reason, .. } => ProblemError::GroupDirections { group: j, reason },
            other => other,
        })?;
        let bound = match usize::try_from(contacts[j]) {
            Err(_) => FrictionBound::Impulse(constants[j]),
            Ok(contact) if constants[j] == 0.0 => FrictionBound::Normal { contact, coefficient: coefficients[j] },
            Ok(contact) => FrictionBound::Shifted { impulse: constants[j], contact, coefficient: coefficients[j] },
        };
        let columns = merge_rows([&rows[2 * j], &rows[2 * j + 1]]);
        problem.push_friction(columns, [target[2 * j], target[2 * j + 1]], bound, &polygon);
        start = end;
    }
    Ok(())
}

/// Writes the groups of a problem that has them.
pub(super) fn write(writer: &mut ArchiveWriter, problem: &ContactProblem) -> Result<(), ProblemError> {
    let groups = &problem.friction_groups;
    let nf = groups.len();
    if nf == 0 {
        return Ok(());
    }
    let mut rows = SparseBuilder::new(problem.nv());
    for j in 0..nf {
        let (columns, entries) = groups.jacobian.group(j);
        for r in 0..2 {
            rows.push_row(columns.iter().zip(entries).map(|(&c, e)| (c as usize, e[r])));
        }
    }
    let constants: Vec<f64> = groups.bound.iter().map(|bound| bound.constant()).collect();
    let normal = || groups.bound.iter().map(|bound| bound.normal());
    let coefficients: Vec<f64> = normal().map(|n| n.map_or(0.0, |(_, coefficient)| coefficient)).collect();
    let contacts: Vec<i32> = normal().map(|n| n.map_or(NO_CONTACT, |(contact, _)| contact as i32)).collect();
    let counts: Vec<i32> = (0..nf).map(|j| groups.directions_of(j).len() as i32).collect();
    writer.csr("JF", &rows.finish())?.f64("rF", &[nf], &constants)?.f64("muF", &[nf], &coefficients)?.i32(
        "cF",
        &[nf],
        &contacts,
    )?;
    writer.f64("uF", &[nf, 2], groups.target.as_flattened())?.i32("mF", &[nf], &counts)?;
    writer.f64("DF", &[groups.direction_count(), 2], groups.directions.as_flattened())?;
    Ok(())
}
