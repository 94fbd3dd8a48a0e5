//! Problems and solutions as `.npz` files.
//!
//! The field `kind` says what a file holds: `lcp`, `mlcp`, `contact`, `frictional3d`, `frictional2d`. Matrices are dense arrays
//! `X` or CSR (`X_data`, `X_indices`, `X_indptr`, `X_shape`). See [`ProblemFile`] for the arrays of each kind.

mod arrays;
mod cone_solutions;
mod contradiction;
mod exclusion;
mod friction_groups;
mod solutions;
mod stability;

use std::path::Path;

use signorini_complementarity::{Lcp, Matrix, MixedLcp, Scaling};
use signorini_multibody::BlockDiagonal;
use signorini_npz::{Archive, ArchiveWriter};

use crate::{ContactProblem, FrictionPolygon, ProblemError};
use arrays::{SparseBuilder, dense, fault, in_file, merge_rows, sparse_rows};

pub use cone_solutions::{is_cone_solution, read_cone_solution, write_cone_solution};
pub use contradiction::{is_contradiction, read_contradiction, write_contradiction};
pub use exclusion::{is_exclusion, read_exclusion, write_exclusion};
pub use solutions::{read_contact_solution, read_plain_solution, write_contact_solution, write_plain_solution};
pub use stability::{is_stability, read_stability, write_stability};

/// A problem as a file holds it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ProblemFile {
    /// `A` (n × n), `b`.
    Lcp(Lcp),
    /// `A`, `b`, `is_comp` (1 where the row is complementary, 0 where it is free).
    MixedLcp(MixedLcp),
    /// `M`, `JN`, `JT`, `phi`, `dt`, `vf`, `mu`, `m`, `D`; with bilateral rows also `JB`, `theta`; with
    /// friction groups also `JF` (2·nf × nv), `uF` (nf × 2), the bounds
    /// `rF + muF λ_N[cF]` (`cF = −1`: no contact), `mF`, `DF`.
    Contact(Box<ContactProblem>),
    /// `W`, `q`, `mu`: `u = W r + q` with Coulomb's law, per contact (normal, tangents).
    Frictional(FrictionalProblem),
}

impl ProblemFile {
    /// The name of its kind, as in the field `kind` of its file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Lcp(_) => "lcp",
            Self::MixedLcp(_) => "mlcp",
            Self::Contact(_) => "contact",
            Self::Frictional(problem) if problem.dimension == 2 => "frictional2d",
            Self::Frictional(_) => "frictional3d",
        }
    }
}

/// A frictional contact problem in impulse space: `u = W r + q`, per contact a normal and one or two tangents.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionalProblem {
    /// Delassus operator `W`, `[dimension·nc, dimension·nc]`.
    pub delassus: Matrix,
    /// Velocity without impulses `q`, `[dimension·nc]`.
    pub free_velocity: Vec<f64>,
    /// Coefficients of friction, `[nc]`.
    pub friction: Vec<f64>,
    /// 2 (normal, tangent) or 3 (normal, two tangents).
    pub dimension: usize,
}

impl FrictionalProblem {
    /// Friction directions of each contact where none are asked for.
    pub const DEFAULT_DIRECTIONS: usize = 8;

    /// The standard LCP with `count` equally spaced directions for each contact (in the plane always the two directions
    /// ±1): `A`, `b` of the formulation, §4, with `W` in place of `J M⁻¹ Jᵀ`.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] for an odd count, [`ProblemError::Lcp`] for malformed data.
    #[allow(non_snake_case)]
    pub fn polygonal_lcp(&self, count: usize) -> Result<Lcp, ProblemError> {
        let nc = self.friction.len();
        let polygon = FrictionPolygon::regular(if self.dimension == 2 { 2 } else { count }, 0.0)?;
        let directions = polygon.directions();
        let m = directions.len();
        // Every impulse is a combination of one contact's rows: (contact, weights on normal and tangents).
        let normal = (0..nc).map(|i| (i, [1.0, 0.0, 0.0]));
        let tangential = (0..nc).flat_map(|i| directions.iter().map(move |d| (i, [0.0, d[0], d[1]])));
        let rows: Vec<(usize, [f64; 3])> = normal.chain(tangential).collect();
        let size = rows.len() + nc;
        let mut A = Matrix::zeros(size, size);
        let mut b = vec![0.0; size];
        let mut g = 0.0_f64;
        for (k, (i, a)) in rows.iter().enumerate() {
            for r in 0..self.dimension {
                b[k] += a[r] * self.free_velocity[self.dimension * i + r];
            }
            for (l, (j, c)) in rows.iter().enumerate() {
                let mut sum = 0.0;
                for r in 0..self.dimension {
                    for s in 0..self.dimension {
                        sum += a[r] * self.delassus[(self.dimension * i + r, self.dimension * j + s)] * c[s];
                    }
                }
                A[(k, l)] = sum;
            }
            g = g.max(A[(k, k)]);
        }
        for i in 0..nc {
            A[(rows.len() + i, i)] = self.friction[i];
            for k in 0..m {
                A[(nc + m * i + k, rows.len() + i)] = 1.0;
                A[(rows.len() + i, nc + m * i + k)] = -1.0;
            }
        }
        let g = if g > 0.0 { g } else { 1.0 };
        let unit = |impulse: f64, bound: f64| (0..size).map(|k| if k < rows.len() { impulse } else { bound }).collect();
        Ok(Lcp::with_scaling(A, b, Scaling::new(unit(g, 1.0), unit(1.0, g))?)?)
    }
}

/// Reads a problem of any kind.
///
/// # Errors
/// [`ProblemError::Archive`] for an unreadable file or a missing array, [`ProblemError::File`] for an unknown kind or parts that
/// do not fit, [`ProblemError::InFile`] with the error of the problem type. All name the file.
pub fn read(path: impl AsRef<Path>) -> Result<ProblemFile, ProblemError> {
    let archive = Archive::read(&path)?;
    read_kind(&archive).map_err(|error| in_file(&archive, error))
}

fn read_kind(archive: &Archive) -> Result<ProblemFile, ProblemError> {
    let kind = archive.string("kind")?;
    match kind.as_str() {
        "lcp" => Ok(ProblemFile::Lcp(Lcp::new(dense(archive, "A")?, archive.f64("b")?)?)),
        "mlcp" => {
            let free = archive.u8("is_comp")?.iter().map(|&c| c == 0).collect();
            Ok(ProblemFile::MixedLcp(MixedLcp::new(dense(archive, "A")?, archive.f64("b")?, free)?))
        }
        "contact" => Ok(ProblemFile::Contact(Box::new(read_contact(archive)?))),
        "frictional3d" => read_frictional(archive, 3),
        "frictional2d" => read_frictional(archive, 2),
        _ => Err(fault(
            archive,
            format!("unknown kind '{kind}'; known are lcp, mlcp, contact, frictional3d, frictional2d"),
        )),
    }
}

fn read_frictional(archive: &Archive, dimension: usize) -> Result<ProblemFile, ProblemError> {
    let (friction, free_velocity) = (archive.f64("mu")?, archive.f64("q")?);
    let delassus = dense(archive, "W")?;
    let expected = dimension * friction.len();
    for (array, found) in
        [("q", free_velocity.len()), ("rows of W", delassus.rows()), ("columns of W", delassus.cols())]
    {
        if found != expected {
            return Err(ProblemError::Length { array, expected, found });
        }
    }
    Ok(ProblemFile::Frictional(FrictionalProblem { delassus, free_velocity, friction, dimension }))
}

fn read_contact(archive: &Archive) -> Result<ContactProblem, ProblemError> {
    let free_velocity = archive.f64("vf")?;
    let nv = free_velocity.len();
    let mass = dense(archive, "M")?;
    if (mass.rows(), mass.cols()) != (nv, nv) {
        return Err(fault(archive, format!("M is {} x {}, expected {nv} x {nv} (as vf)", mass.rows(), mass.cols())));
    }
    let mass = BlockDiagonal::from_dense(nv, mass.data())?;
    let mut problem = ContactProblem::new(mass, free_velocity, archive.scalar_f64("dt")?)?;
    let (gap, friction) = (archive.f64("phi")?, archive.f64("mu")?);
    let nc = gap.len();
    let counts = archive.i32("m")?;
    for (array, found) in [("mu", friction.len()), ("m", counts.len())] {
        if found != nc {
            return Err(ProblemError::Length { array, expected: nc, found });
        }
    }
    let (normal, tangential) = (sparse_rows(archive, "JN", (nc, nv))?, sparse_rows(archive, "JT", (2 * nc, nv))?);
    if let Some(index) = counts.iter().position(|&m| m < 0) {
        let (value, expected) = (f64::from(counts[index]), "a number of directions, not negative");
        return Err(ProblemError::Number { array: "m", index, value, expected });
    }
    let total: usize = counts.iter().map(|&m| m as usize).sum();
    let directions = archive.array("D")?;
    if directions.shape != [total, 2] {
        return Err(fault(
            archive,
            format!("D has shape {:?}, expected [{total}, 2] (the sum of m)", directions.shape),
        ));
    }
    let directions = archive.f64("D")?;
    let mut start = 0;
    for i in 0..nc {
        let m = counts[i] as usize;
        let own = directions[2 * start..2 * (start + m)].chunks_exact(2).map(|d| [d[0], d[1]]).collect();
        let polygon = FrictionPolygon::from_directions(own).map_err(|e| match e {
            ProblemError::Directions { reason, .. } => ProblemError::Directions { contact: Some(i), reason },
            other => other,
        })?;
        let group = merge_rows([&normal[i], &tangential[2 * i], &tangential[2 * i + 1]]);
        problem.push_contact(group, gap[i], friction[i], &polygon);
        start += m;
    }
    if archive.contains("theta") || archive.contains_matrix("JB") {
        let violation = archive.f64("theta")?;
        for (row, theta) in sparse_rows(archive, "JB", (violation.len(), nv))?.iter().zip(violation) {
            problem.push_bilateral(merge_rows([row]), theta);
        }
    }
    friction_groups::read(archive, &mut problem)?;
    problem.check()?;
    Ok(problem)
}

/// Writes a contact problem with `kind = "contact"`.
///
/// # Errors
/// [`ProblemError::Archive`] if the file cannot be written.
pub fn write_contact(path: impl AsRef<Path>, problem: &ContactProblem) -> Result<(), ProblemError> {
    Ok(contact_archive(problem)?.write(path)?)
}

/// The bytes of the file that [`write_contact`] writes.
///
/// # Errors
/// [`ProblemError::Archive`] for a problem of more numbers than a file holds.
pub fn contact_to_bytes(problem: &ContactProblem) -> Result<Vec<u8>, ProblemError> {
    Ok(contact_archive(problem)?.to_bytes()?)
}

/// The contact problem of the bytes of a file.
///
/// # Errors
/// As [`read`], with "(bytes)" in the place of the file.
pub fn contact_from_bytes(bytes: Vec<u8>) -> Result<ContactProblem, ProblemError> {
    let archive = Archive::from_bytes("(bytes)", bytes)?;
    read_contact(&archive).map_err(|error| in_file(&archive, error))
}

fn contact_archive(problem: &ContactProblem) -> Result<ArchiveWriter, ProblemError> {
    let (nv, nc) = (problem.nv(), problem.contact_count());
    let mut mass = SparseBuilder::new(nv);
    for (index, block) in problem.mass.blocks().iter().enumerate() {
        for row in problem.mass.block_data(index).chunks_exact(block.size) {
            mass.push_row(row.iter().enumerate().map(|(j, &x)| (block.start + j, x)));
        }
    }
    let (mut normal, mut tangential, mut bilateral) =
        (SparseBuilder::new(nv), SparseBuilder::new(nv), SparseBuilder::new(nv));
    for i in 0..nc {
        let (columns, entries) = problem.jacobian.group(i);
        let row = |r: usize| columns.iter().zip(entries).map(move |(&c, e)| (c as usize, e[r]));
        normal.push_row(row(0));
        tangential.push_row(row(1));
        tangential.push_row(row(2));
    }
    for k in 0..problem.bilateral_violation.len() {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        bilateral.push_row(columns.iter().zip(entries).map(|(&c, e)| (c as usize, e[0])));
    }
    let counts: Vec<i32> = (0..nc).map(|i| problem.directions_of(i).len() as i32).collect();
    let directions: Vec<f64> = problem.directions.iter().flatten().copied().collect();
    let mut writer = ArchiveWriter::new();
    writer.string("kind", "contact")?.csr("M", &mass.finish())?.csr("JN", &normal.finish())?;
    writer.csr("JT", &tangential.finish())?.f64("phi", &[nc], &problem.gap)?;
    writer.scalar_f64("dt", problem.timestep)?.f64("vf", &[nv], &problem.free_velocity)?;
    writer.f64("mu", &[nc], &problem.friction)?.i32("m", &[nc], &counts)?;
    writer.f64("D", &[problem.directions.len(), 2], &directions)?;
    if !problem.bilateral_violation.is_empty() {
        let theta = &problem.bilateral_violation;
        writer.csr("JB", &bilateral.finish())?.f64("theta", &[theta.len()], theta)?;
    }
    friction_groups::write(&mut writer, problem)?;
    Ok(writer)
}
