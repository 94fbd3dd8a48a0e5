//! Names of problems, and the problems they stand for.
#![allow(non_snake_case)] // matrices keep the letters of the formulas

use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use signorini::contact::ContactProblem;
use signorini::contact::problem_file::{self, ProblemFile};
use signorini::lcp::linalg::Lu;
use signorini::lcp::{Lcp, Matrix, MixedLcp};
use signorini_testkit::suite::{Entry, entries};

use super::delassus;

/// Where a problem comes from.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    /// The problem of a seed: entry `seed mod 154` of the list.
    List(u32),
    /// A stack of this many boxes.
    Stack(usize),
    /// A cluster of this many bodies.
    Cluster(usize),
    /// A problem file.
    File(PathBuf),
}

/// The name of a problem, from which any process can make it. As text: `list:17:8` (seed, directions), `stack:20:4` (boxes,
/// directions), `cluster:80:4`, `file:4:PATH`; with `open:` in front the same with all negative gaps set to 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    source: Source,
    directions: usize,
    opened: bool,
}

/// What is to be solved.
#[derive(Clone, Debug)]
pub enum Problem {
    /// Contacts of bodies.
    Contact(Box<ContactProblem>),
    /// A problem without mechanics.
    Plain(Lcp),
}

impl Spec {
    /// The problem of a seed, with this many friction directions at every contact.
    pub fn list(seed: u32, directions: usize) -> Self {
        Self { source: Source::List(seed), directions, opened: false }
    }

    /// A stack for a series of growing size.
    pub fn stack(boxes: usize, directions: usize) -> Self {
        Self { source: Source::Stack(boxes), directions, opened: false }
    }

    /// A cluster for a series of growing size.
    pub fn cluster(bodies: usize, directions: usize) -> Self {
        Self { source: Source::Cluster(bodies), directions, opened: false }
    }

    /// A problem file. `directions`: of frictional problems, which have none of their own.
    pub fn file(path: PathBuf, directions: usize) -> Self {
        Self { source: Source::File(path), directions, opened: false }
    }

    /// The same with all negative gaps set to 0, so that it has a solution.
    pub fn opened(&self) -> Self {
        Self { opened: true, ..self.clone() }
    }

    /// A short name for tables and records: as the text, but of a file without its folder.
    pub fn label(&self) -> String {
        match &self.source {
            Source::File(path) => {
                let name = Path::new(path.file_name().unwrap_or_default());
                Self { source: Source::File(name.to_owned()), ..self.clone() }.to_string()
            }
            _ => self.to_string(),
        }
    }

    /// Whether it belongs to a series of growing size.
    pub fn is_growth(&self) -> bool {
        matches!(self.source, Source::Stack(_) | Source::Cluster(_))
    }

    /// Friction directions of each contact, where the problem leaves the choice.
    pub fn directions(&self) -> usize {
        self.directions
    }

    /// The family that results are gathered by.
    pub fn family(&self) -> String {
        match &self.source {
            Source::List(seed) => entry(*seed).group.to_owned(),
            Source::Stack(_) => "growing stack".to_owned(),
            Source::Cluster(_) => "growing cluster".to_owned(),
            Source::File(path) if path.parent().is_some_and(|p| p.ends_with("contact_problems")) => {
                "siconos".to_owned()
            }
            Source::File(_) => "files".to_owned(),
        }
    }

    /// Whether the problem is made so that it cannot have a solution.
    pub fn contradicts_itself(&self) -> bool {
        matches!(&self.source, Source::List(seed) if entry(*seed).group == "squeeze") && !self.opened
    }

    /// Makes the problem.
    ///
    /// # Errors
    /// For a file that cannot be read, or a frictional problem that no mechanics has.
    pub fn build(&self) -> Result<Problem, Box<dyn Error>> {
        let problem = match &self.source {
            Source::List(seed) => entry(*seed).problem(*seed),
            Source::Stack(boxes) => Entry::stack(*boxes).problem(*boxes as u32),
            Source::Cluster(bodies) => Entry::cluster(*bodies).problem(*bodies as u32),
            Source::File(path) => match problem_file::read(path)? {
                ProblemFile::Contact(problem) => *problem,
                ProblemFile::Frictional(problem) => match delassus::contact_problem(&problem, self.directions)? {
                    Some(problem) => problem,
                    None => return Ok(Problem::Plain(problem.polygonal_lcp(self.directions)?)),
                },
                ProblemFile::Lcp(lcp) => return Ok(Problem::Plain(lcp)),
                ProblemFile::MixedLcp(mixed) => return Ok(Problem::Plain(eliminate(&mixed)?)),
                _ => return Err("a kind of problem that is not known here".into()),
            },
        };
        // A problem of the list keeps the orientation of its own directions, one in the plane its two directions.
        let planar = problem.directions.len() == 2 * problem.contact_count();
        let mut problem = if planar { problem } else { problem.with_directions(self.directions)? };
        if self.opened {
            problem.gap.iter_mut().for_each(|gap| *gap = gap.max(0.0));
        }
        Ok(Problem::Contact(Box::new(problem)))
    }
}

/// The entry of the list that a seed stands for.
fn entry(seed: u32) -> Entry {
    let list = entries();
    list[seed as usize % list.len()]
}

impl fmt::Display for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let m = self.directions;
        if self.opened {
            f.write_str("open:")?;
        }
        match &self.source {
            Source::List(seed) => write!(f, "list:{seed}:{m}"),
            Source::Stack(boxes) => write!(f, "stack:{boxes}:{m}"),
            Source::Cluster(bodies) => write!(f, "cluster:{bodies}:{m}"),
            Source::File(path) => write!(f, "file:{m}:{}", path.display()),
        }
    }
}

impl FromStr for Spec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || format!("'{text}' is no problem; known are list:SEED:M, stack:K:M, cluster:N:M, file:M:PATH");
        if let Some(rest) = text.strip_prefix("open:") {
            return Ok(rest.parse::<Self>()?.opened());
        }
        let (kind, rest) = text.split_once(':').ok_or_else(unknown)?;
        let (first, second) = rest.split_once(':').ok_or_else(unknown)?;
        let first: usize = first.parse().map_err(|_| unknown())?;
        if kind == "file" {
            return Ok(Self::file(second.into(), first));
        }
        let directions = second.parse().map_err(|_| unknown())?;
        match kind {
            "list" => Ok(Self::list(first as u32, directions)),
            "stack" => Ok(Self::stack(first, directions)),
            "cluster" => Ok(Self::cluster(first, directions)),
            _ => Err(unknown()),
        }
    }
}

/// The LCP that is left when a regular block of free variables is eliminated.
fn eliminate(mixed: &MixedLcp) -> Result<Lcp, Box<dyn Error>> {
    let of = |free: bool| (0..mixed.len()).filter(|&i| mixed.free()[i] == free).collect::<Vec<usize>>();
    let (free, rest) = (of(true), of(false));
    let (f, A, b) = (free.len(), mixed.A(), mixed.b());
    let mut lu = Lu::default();
    let block = lu.start(f);
    for (i, &row) in free.iter().enumerate() {
        free.iter().enumerate().for_each(|(j, &column)| block[i * f + j] = A[(row, column)]);
    }
    if f > 0 && lu.factorize() < 1e-12 {
        return Err("the block of free variables is singular".into());
    }
    let mut reduced = Matrix::zeros(rest.len(), rest.len());
    let mut vector: Vec<f64> = rest.iter().map(|&i| b[i]).collect();
    let mut x = vec![0.0; f];
    let correction = |i: usize, x: &[f64]| free.iter().zip(x).map(|(&k, x)| A[(i, k)] * x).sum::<f64>();
    for (j, &column) in rest.iter().enumerate() {
        free.iter().zip(&mut x).for_each(|(&k, x)| *x = A[(k, column)]);
        lu.solve(&mut x);
        rest.iter().enumerate().for_each(|(i, &row)| reduced[(i, j)] = A[(row, column)] - correction(row, &x));
    }
    free.iter().zip(&mut x).for_each(|(&k, x)| *x = b[k]);
    lu.solve(&mut x);
    rest.iter().zip(&mut vector).for_each(|(&row, v)| *v -= correction(row, &x));
    Ok(Lcp::new(reduced, vector)?)
}
