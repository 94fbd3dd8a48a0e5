//! Solutions as files.

use std::path::Path;

use signorini_npz::{Archive, ArchiveWriter};

use super::arrays::in_file;
use crate::{ContactProblem, ContactSolution, ProblemError};

/// Writes a contact solution: `z` (λ_N, α, α_F, β, β_F), `v`, `lambda_n`, `alpha`, `beta`, `lambda_b` for bilateral rows, `alpha_f`
/// and `beta_f` for friction groups.
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_contact_solution(path: impl AsRef<Path>, solution: &ContactSolution) -> Result<(), ProblemError> {
    let mut writer = ArchiveWriter::new();
    write_arrays(&mut writer, "", solution)?;
    writer.write(path)?;
    Ok(())
}

/// The arrays of a solution, their names after a prefix.
pub(super) fn write_arrays(
    writer: &mut ArchiveWriter,
    prefix: &str,
    solution: &ContactSolution,
) -> Result<(), ProblemError> {
    let z = solution.z();
    writer.f64(&format!("{prefix}z"), &[z.len()], &z)?;
    for (name, x) in [
        ("v", &solution.velocity),
        ("lambda_n", &solution.lambda_n),
        ("alpha", &solution.alpha),
        ("beta", &solution.beta),
        ("lambda_b", &solution.bilateral),
        ("alpha_f", &solution.group_alpha),
        ("beta_f", &solution.group_beta),
    ] {
        writer.f64(&format!("{prefix}{name}"), &[x.len()], x)?;
    }
    Ok(())
}

/// Writes a plain solution: `z`.
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_plain_solution(path: impl AsRef<Path>, z: &[f64]) -> Result<(), ProblemError> {
    let mut writer = ArchiveWriter::new();
    writer.f64("z", &[z.len()], z)?;
    writer.write(path)?;
    Ok(())
}

/// Reads a plain solution: `z` with `expected` finite entries.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or one without `z`, [`ProblemError::Length`],
/// [`ProblemError::Number`].
pub fn read_plain_solution(path: impl AsRef<Path>, expected: usize) -> Result<Vec<f64>, ProblemError> {
    let z = Archive::read(path)?.f64("z")?;
    if z.len() != expected {
        return Err(ProblemError::Length { array: "z", expected, found: z.len() });
    }
    finite("z", &z)?;
    Ok(z)
}

pub(super) fn finite(array: &'static str, values: &[f64]) -> Result<(), ProblemError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(ProblemError::Number { array, index, value: values[index], expected: "finite" }),
        None => Ok(()),
    }
}

/// Reads the solution of a contact problem. `v` is computed from the impulses where the file has only `z`.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::InFile`] with a
/// [`ProblemError::Length`] for an array that does not fit the problem.
pub fn read_contact_solution(
    path: impl AsRef<Path>,
    problem: &ContactProblem,
) -> Result<ContactSolution, ProblemError> {
    let archive = Archive::read(path)?;
    read_arrays(&archive, "", problem).map_err(|error| in_file(&archive, error))
}

/// The arrays of a solution whose names have this prefix.
pub(super) fn read_arrays(
    archive: &Archive,
    prefix: &str,
    problem: &ContactProblem,
) -> Result<ContactSolution, ProblemError> {
    let mut solution = ContactSolution::default();
    solution.prepare(problem);
    read_unknowns(archive, prefix, problem, &mut solution)?;
    for i in 0..problem.contact_count() {
        let [t_1, t_2] = crate::certificate::tangential_impulse(problem, &solution, i);
        solution.impulse[i] = [solution.lambda_n[i], t_1, t_2];
    }
    for j in 0..problem.friction_groups.len() {
        solution.group_impulse[j] = problem.friction_groups.impulse(j, &solution.group_alpha);
    }
    let velocity = format!("{prefix}v");
    solution.velocity = if archive.contains(&velocity) {
        archive.f64(&velocity)?
    } else {
        crate::certificate::velocity_from_impulses(problem, &solution)
    };
    if solution.velocity.len() != problem.nv() {
        return Err(ProblemError::Length { array: "v", expected: problem.nv(), found: solution.velocity.len() });
    }
    finite("v", &solution.velocity)?;
    Ok(solution)
}

/// Reads the unknowns of the LCP, under their names or as one vector.
fn read_unknowns(
    archive: &Archive,
    prefix: &str,
    problem: &ContactProblem,
    solution: &mut ContactSolution,
) -> Result<(), ProblemError> {
    let named = |name: &str| format!("{prefix}{name}");
    let (nc, m) = (problem.contact_count(), problem.direction_count());
    let (nf, m_f) = (problem.friction_groups.len(), problem.friction_groups.direction_count());
    if archive.contains(&named("lambda_n")) {
        solution.lambda_n = archive.f64(&named("lambda_n"))?;
        solution.alpha = archive.f64(&named("alpha"))?;
        solution.beta = archive.f64(&named("beta"))?;
        if nf > 0 {
            solution.group_alpha = archive.f64(&named("alpha_f"))?;
            solution.group_beta = archive.f64(&named("beta_f"))?;
        }
    } else {
        let z = archive.f64(&named("z"))?;
        let expected = 2 * nc + m + nf + m_f;
        if z.len() != expected {
            return Err(ProblemError::Length { array: "z", expected, found: z.len() });
        }
        let mut rest = z.as_slice();
        for (part, size) in [
            (&mut solution.lambda_n, nc),
            (&mut solution.alpha, m),
            (&mut solution.group_alpha, m_f),
            (&mut solution.beta, nc),
            (&mut solution.group_beta, nf),
        ] {
            let (own, others) = rest.split_at(size);
            *part = own.to_vec();
            rest = others;
        }
    }
    if archive.contains(&named("lambda_b")) {
        solution.bilateral = archive.f64(&named("lambda_b"))?;
    }
    for (array, values, expected) in [
        ("lambda_n", &solution.lambda_n, nc),
        ("alpha", &solution.alpha, m),
        ("beta", &solution.beta, nc),
        ("lambda_b", &solution.bilateral, problem.bilateral_violation.len()),
        ("alpha_f", &solution.group_alpha, m_f),
        ("beta_f", &solution.group_beta, nf),
    ] {
        if values.len() != expected {
            return Err(ProblemError::Length { array, expected, found: values.len() });
        }
        finite(array, values)?;
    }
    Ok(())
}
