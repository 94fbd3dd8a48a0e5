//! Claimed solutions, judged by the data of their problems.
//!
//! Whoever found a solution, with whatever method: [`check`] reads the problem file and the solution file and computes how far the laws
//! are from holding. Nothing below this crate solves anything, which CI checks.
//!
//! ```
//! use signorini_check::{Law, check};
//! use signorini_contact::problem_file::{write_contact, write_contact_solution};
//! use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon};
//! use signorini_multibody::BlockDiagonal;
//! # use std::error::Error;
//! # fn main() -> Result<(), Box<dyn Error>> {
//!
//! // A particle of 1 kg that falls with 2 m/s onto a floor; 2 N·s stop it.
//! let mut problem = ContactProblem::new(BlockDiagonal::from_dense(1, &[1.0])?, vec![-2.0], 0.01)?;
//! problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
//! let mut claimed = ContactSolution::default();
//! (claimed.velocity, claimed.lambda_n, claimed.beta) = (vec![0.0], vec![2.0], vec![0.0]);
//! # let folder = std::env::temp_dir().join(format!("signorini-check-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//! let files = [folder.join("problem.npz"), folder.join("solution.npz")];
//! write_contact(&files[0], &problem)?;
//! write_contact_solution(&files[1], &claimed)?;
//!
//! let checked = check(&files[0], &files[1], None)?;
//! assert_eq!((checked.kind, checked.law), ("contact", Some(Law::Polygon)));
//! assert!(checked.violated(1e-12).is_empty());
//!
//! claimed.lambda_n[0] = 1.0;
//! write_contact_solution(&files[1], &claimed)?;
//! assert_eq!(check(&files[0], &files[1], None)?.violated(1e-12), ["momentum", "natural_map"]);
//! # std::fs::remove_dir_all(folder)?;
//! # Ok(())
//! # }
//! ```

use std::path::{Path, PathBuf};

use signorini_contact::problem_file::{
    self, FrictionalProblem, ProblemFile, is_cone_solution, is_contradiction, is_exclusion, is_stability,
    read_cone_solution, read_contact_solution, read_contradiction, read_exclusion, read_plain_solution, read_stability,
};
use signorini_contact::statics::{Verdict, certify_stability, check_at_rest};
use signorini_contact::{Certificate, ContactProblem, ProblemError, certify, certify_cone};

/// The law of friction that a solution was checked against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Law {
    /// Maximum dissipation over the polygons of the problem.
    Polygon,
    /// Coulomb's law with the circular cone; the solution file says so.
    Circular,
}

/// What a check found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Checked {
    /// Kind of the problem, as in the field `kind` of its file.
    pub kind: &'static str,
    /// The law of friction, where the problem has contacts.
    pub law: Option<Law>,
    /// The residuals, by name; those that the kind of problem does not have are left out. Each is 0 for an exact solution, without unit
    /// (formulation §8).
    pub residuals: Vec<(&'static str, f64)>,
    /// The verdict of statics whose proof was checked.
    pub verdict: Option<Verdict>,
    /// What the file claims where it holds a proof that there is no solution, in place of one.
    pub denial: Option<Denial>,
}

/// Which proof there is that a problem has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Denial {
    /// The inequalities contradict each other.
    Infeasible,
    /// All complementary cases were excluded, one by one.
    NoSolution,
}

impl Denial {
    /// Its name, as in the field `kind` of the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Infeasible => "infeasible",
            Self::NoSolution => "no_solution",
        }
    }
}

impl Checked {
    /// Names of the laws whose residual exceeds a tolerance, or is no number.
    pub fn violated(&self, tolerance: f64) -> Vec<&'static str> {
        let exceeds = |r: f64| r.is_nan() || r > tolerance;
        self.residuals.iter().filter(|law| exceeds(law.1)).map(|law| law.0).collect()
    }
}

/// Why nothing can be said of a solution.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// A problem or solution file. The path is given where the error itself does not name it.
    #[error("{}{source}", prefix(path, source))]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<ProblemError>,
    },
    /// A solution with the circular cone, a verdict of statics or a contradiction of gaps, for a problem without contacts.
    #[error("{}: a solution with the circular cone, a verdict of statics or a contradiction of gaps, but the problem is of kind '{kind}', which has no contacts", path.display())]
    LawWithoutContacts {
        /// The solution file.
        path: PathBuf,
        /// Kind of the problem.
        kind: &'static str,
    },
    /// A kind of problem that this version does not know.
    #[error("{}: problems of this kind cannot be checked", path.display())]
    UnsupportedKind {
        /// The problem file.
        path: PathBuf,
    },
}

fn prefix(path: &Path, source: &ProblemError) -> String {
    match source {
        ProblemError::Archive(_) | ProblemError::File { .. } | ProblemError::InFile { .. } => String::new(),
        _ => format!("{}: ", path.display()),
    }
}

/// Attaches the file to an error of its contents.
fn in_file(path: &Path) -> impl FnOnce(ProblemError) -> CheckError + '_ {
    |source| CheckError::File { path: path.to_owned(), source: Box::new(source) }
}

/// Reads a problem and a claimed solution, and computes how far the laws are from holding.
///
/// - `directions`: friction directions of every contact, where the solution was made with others than the file's; of a frictional
///   problem, which has none, instead of [`FrictionalProblem::DEFAULT_DIRECTIONS`]
///
/// # Errors
/// [`CheckError`] if a file cannot be read, does not fit the other, or has friction that the law of the solution does not know.
pub fn check(problem: &Path, solution: &Path, directions: Option<usize>) -> Result<Checked, CheckError> {
    let data = problem_file::read(problem).map_err(in_file(problem))?;
    let kind = data.kind();
    if is_stability(solution).map_err(in_file(solution))? {
        return judge_stability(data, (problem, solution));
    }
    if is_contradiction(solution).map_err(in_file(solution))? {
        return judge_contradiction(data, solution);
    }
    if is_exclusion(solution).map_err(in_file(solution))? {
        return judge_exclusion(data, (problem, solution), directions);
    }
    let is_circular = is_cone_solution(solution).map_err(in_file(solution))?;
    let (law, residuals) = if is_circular {
        (Some(Law::Circular), circular(data, (problem, solution))?)
    } else {
        polygonal(data, (problem, solution), directions)?
    };
    Ok(Checked { kind, law, residuals, verdict: None, denial: None })
}

/// A proof that gaps and bilateral rows contradict each other, which no friction law mends.
fn judge_contradiction(data: ProblemFile, proof: &Path) -> Result<Checked, CheckError> {
    let kind = data.kind();
    let ProblemFile::Contact(data) = data else {
        return Err(CheckError::LawWithoutContacts { path: proof.to_owned(), kind });
    };
    let claimed = read_contradiction(proof, &data).map_err(in_file(proof))?;
    let residuals = vec![("contradiction", claimed.residual(&data))];
    Ok(Checked { kind, law: Some(Law::Polygon), residuals, verdict: None, denial: Some(Denial::Infeasible) })
}

/// A proof that no case of the complementarity problem has a solution: of the problem itself, or of the polygon's law.
fn judge_exclusion(
    data: ProblemFile,
    (problem, proof): (&Path, &Path),
    directions: Option<usize>,
) -> Result<Checked, CheckError> {
    let kind = data.kind();
    let (law, data) = match data {
        ProblemFile::Lcp(data) => (None, data.into()),
        ProblemFile::MixedLcp(data) => (None, data),
        ProblemFile::Frictional(data) => {
            let lcp = data.polygonal_lcp(directions.unwrap_or(FrictionalProblem::DEFAULT_DIRECTIONS));
            (Some(Law::Polygon), lcp.map_err(in_file(problem))?.into())
        }
        ProblemFile::Contact(data) => {
            let data = with_directions(data, directions).map_err(in_file(problem))?;
            (Some(Law::Polygon), data.mixed_lcp().map_err(in_file(problem))?)
        }
        _ => return Err(CheckError::UnsupportedKind { path: problem.to_owned() }),
    };
    let claimed = read_exclusion(proof, &data).map_err(in_file(proof))?;
    let residuals = vec![("exclusion", claimed.residual(&data))];
    let denial = if claimed.is_infeasible() { Denial::Infeasible } else { Denial::NoSolution };
    Ok(Checked { kind, law, residuals, verdict: None, denial: Some(denial) })
}

/// The contact problem with the directions asked for.
fn with_directions(data: Box<ContactProblem>, directions: Option<usize>) -> Result<Box<ContactProblem>, ProblemError> {
    Ok(match directions {
        Some(count) => Box::new(data.with_directions(count)?),
        None => data,
    })
}

/// A verdict of statics with its proof.
fn judge_stability(data: ProblemFile, (problem, proof): (&Path, &Path)) -> Result<Checked, CheckError> {
    let kind = data.kind();
    let ProblemFile::Contact(data) = data else {
        return Err(CheckError::LawWithoutContacts { path: proof.to_owned(), kind });
    };
    check_at_rest(&data).map_err(in_file(problem))?;
    let claimed = read_stability(proof, &data).map_err(in_file(proof))?;
    let residuals = certify_stability(&data, &claimed);
    Ok(Checked { kind, law: Some(Law::Polygon), residuals, verdict: Some(claimed.verdict), denial: None })
}

type Residuals = Vec<(&'static str, f64)>;

/// Those of a contact problem, which may have no bilateral rows, or no velocity of its own to balance.
fn of_contacts(certificate: &Certificate, has_momentum: bool, has_bilateral: bool) -> Residuals {
    let there = |name: &str| (name != "momentum" || has_momentum) && (name != "bilateral" || has_bilateral);
    certificate.list().into_iter().filter(|(name, _)| there(name)).collect()
}

fn circular(data: ProblemFile, (problem, solution): (&Path, &Path)) -> Result<Residuals, CheckError> {
    let read = |nv, nc, nb| read_cone_solution(solution, nv, nc, nb).map_err(in_file(solution));
    match data {
        ProblemFile::Contact(data) => {
            data.check_circular().map_err(|unsupported| in_file(problem)(unsupported.into()))?;
            let nb = data.bilateral_violation.len();
            let claimed = read(data.nv(), data.contact_count(), nb)?;
            Ok(of_contacts(&certify_cone(&data, &claimed), true, nb > 0))
        }
        ProblemFile::Frictional(data) => {
            let claimed = read(0, data.friction.len(), 0)?;
            Ok(of_contacts(&data.certify_cone(&claimed.impulse), false, false))
        }
        other => Err(CheckError::LawWithoutContacts { path: solution.to_owned(), kind: other.kind() }),
    }
}

fn polygonal(
    data: ProblemFile,
    (problem, solution): (&Path, &Path),
    directions: Option<usize>,
) -> Result<(Option<Law>, Residuals), CheckError> {
    let read = |size| read_plain_solution(solution, size).map_err(in_file(solution));
    let natural_map = |value: f64| (None, vec![("natural_map", value)]);
    match data {
        ProblemFile::Lcp(data) => Ok(natural_map(data.residual(&read(data.len())?).value)),
        ProblemFile::MixedLcp(data) => Ok(natural_map(data.residual(&read(data.len())?).value)),
        ProblemFile::Frictional(data) => {
            let lcp = data.polygonal_lcp(directions.unwrap_or(FrictionalProblem::DEFAULT_DIRECTIONS));
            let lcp = lcp.map_err(in_file(problem))?;
            let z = read(lcp.len())?;
            Ok((Some(Law::Polygon), of_contacts(&data.certify(&lcp, &z), false, false)))
        }
        ProblemFile::Contact(data) => {
            let data = with_directions(data, directions).map_err(in_file(problem))?;
            let claimed = read_contact_solution(solution, &data).map_err(in_file(solution))?;
            let has_bilateral = !data.bilateral_violation.is_empty();
            Ok((Some(Law::Polygon), of_contacts(&certify(&data, &claimed), true, has_bilateral)))
        }
        _ => Err(CheckError::UnsupportedKind { path: problem.to_owned() }),
    }
}
