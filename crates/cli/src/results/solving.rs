//! Results of `solve` and `check`.

use std::collections::BTreeMap;

use serde::Serialize;
use signorini::contact::statics::Verdict;
use signorini::contact::{
    ConeStatus, ContactProblem, ForceDistributions, GapContradiction, ImpulseRange, LeastNormOutcome, LeastNormReport,
    RelaxationStatus, SolveStatus, gap_contradiction,
};
use signorini::lcp::{ExcludedCase, Exclusion, PairCase, Status};
use signorini_check::{Checked, Law};

use super::{FileName, Laws, StageHistory, StageLine};
use crate::solving::{ContactLaw, Denial};

/// A solved (or refused) problem.
#[derive(Clone, Debug, Serialize)]
pub struct SolveResult {
    /// File.
    pub problem: FileName,
    /// Kind of the file.
    pub kind: &'static str,
    /// Rows of the complementarity problem.
    pub n: usize,
    /// Contacts, where the problem has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<usize>,
    /// Method.
    pub method: String,
    /// The law of contact solved, where the problem has contacts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<ContactLaw>,
    /// `solved`, or why not.
    pub status: &'static str,
    /// The method's reason, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Tolerance of `solved`.
    pub tolerance: f64,
    /// Residuals of `law`.
    pub residual: Laws,
    /// Residuals of the circular cone's laws, beside those of a polygon.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circular_laws: Option<Laws>,
    /// Bound on these, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circular_tolerance: Option<f64>,
    /// Residuals of the true contact laws, beside those of a relaxation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_laws: Option<Laws>,
    /// Pivots, mode changes and proximal iterations; refinement: LCPs.
    pub iterations: u64,
    /// Wall time of the solve, s.
    pub seconds: f64,
    /// What the structured solver's stages did.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageLine>,
    /// What they did on each island, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<StageHistory>>,
    /// What became of the impulses of least norm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_norm: Option<LeastNormResult>,
    /// All force distributions with the same velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distributions: Option<Distributions>,
    /// Contacts (of a contact problem) or rows that wedge or contradict each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub involved: Vec<usize>,
    /// Of a problem without solution the proof.
    #[serde(skip_serializing_if = "Option::is_none", flatten)]
    pub denial: Option<DenialProof>,
    /// Solution, or proof that there is none, written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solution: Option<FileName>,
}

/// A proof that there is no solution.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DenialProof {
    /// Gaps and bilateral rows contradict each other.
    Contradiction(ContradictionProof),
    /// All cases of the complementarity problem were excluded.
    Exclusion(ExclusionProof),
}

/// Cases that together are all there are, each with the multipliers that exclude it.
#[derive(Clone, Debug, Serialize)]
pub struct ExclusionProof {
    /// The cases.
    pub cases: Vec<CaseProof>,
    /// What rounding leaves: 0 for an exact proof.
    pub residual: f64,
}

/// One of them.
#[derive(Clone, Debug, Serialize)]
pub struct CaseProof {
    /// Pairs decided to have `z = 0`.
    pub z_zero: Vec<usize>,
    /// Pairs decided to have `w = 0`.
    pub w_zero: Vec<usize>,
    /// A multiplier for each row.
    pub multipliers: Vec<f64>,
}

impl DenialProof {
    /// A proof in the form in which it is printed.
    pub fn of(proof: &Denial, residual: f64) -> Self {
        let decided =
            |case: &ExcludedCase, as_: PairCase| (0..case.pairs.len()).filter(|&i| case.pairs[i] == as_).collect();
        match proof {
            Denial::Gaps(GapContradiction { normal, bilateral }) => {
                let (normal, bilateral) = (normal.clone(), bilateral.clone());
                Self::Contradiction(ContradictionProof { normal, bilateral, residual })
            }
            Denial::Cases(exclusion) => {
                let case = |case: &ExcludedCase| CaseProof {
                    z_zero: decided(case, PairCase::NoZ),
                    w_zero: decided(case, PairCase::NoW),
                    multipliers: case.multipliers.clone(),
                };
                Self::Exclusion(ExclusionProof { cases: exclusion.cases.iter().map(case).collect(), residual })
            }
        }
    }
}

/// Multipliers of gap rows and bilateral rows that leave no velocity.
#[derive(Clone, Debug, Serialize)]
pub struct ContradictionProof {
    /// Of the gap rows, ≥ 0.
    pub normal: Vec<f64>,
    /// Of the bilateral rows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bilateral: Vec<f64>,
    /// What rounding leaves: 0 for an exact proof.
    pub residual: f64,
}

/// The choice of the impulses of least norm.
#[derive(Clone, Debug, Serialize)]
pub struct LeastNormResult {
    /// `chosen`, `kept` (they were not found to the tolerance) or `not_solved`.
    pub outcome: &'static str,
    /// Norm of the impulses before, N·s.
    pub norm_before: f64,
    /// Norm of the impulses of the solution, N·s.
    pub norm: f64,
}

impl LeastNormResult {
    /// Reads off a report.
    pub fn of(report: &LeastNormReport) -> Self {
        let outcome = match report.outcome {
            LeastNormOutcome::Chosen => "chosen",
            LeastNormOutcome::NotSolved => "not_solved",
            _ => "kept",
        };
        Self { outcome, norm_before: report.norm_before, norm: report.norm }
    }
}

/// The set of all impulses that solve the problem with the same velocity.
#[derive(Clone, Debug, Serialize)]
pub struct Distributions {
    /// Its dimension; 0 where the impulses are unique.
    pub dimension: usize,
    /// Smallest and largest impulses of each contact (normal, tangent 1, tangent 2), N·s; `null` where there is no bound.
    pub contacts: Vec<[[Option<f64>; 2]; 3]>,
    /// The same of each bilateral row, N·s or N·m·s.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bilateral: Vec<[Option<f64>; 2]>,
}

impl Distributions {
    /// Reads off the description of the set.
    pub fn of(set: &ForceDistributions) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let range = |r: &ImpulseRange| [finite(r.min), finite(r.max)];
        let contacts = set.normal.iter().zip(&set.tangential).map(|(n, [t_1, t_2])| [n, t_1, t_2].map(range));
        Self {
            dimension: set.dimension,
            contacts: contacts.collect(),
            bilateral: set.bilateral.iter().map(range).collect(),
        }
    }
}

/// A checked solution.
#[derive(Clone, Debug, Serialize)]
pub struct CheckResult {
    /// Problem file.
    pub problem: FileName,
    /// Solution file.
    pub solution: FileName,
    /// Kind of the problem.
    pub kind: &'static str,
    /// The law of contact checked, where the problem has contacts: the solution file says which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<ContactLaw>,
    /// Tolerance on every law.
    pub tolerance: f64,
    /// Residuals.
    #[serde(flatten)]
    pub laws: Option<Laws>,
    /// What the file proves in place of a solution: a verdict of statics, or `infeasible`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<&'static str>,
    /// Residuals of the proof.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub proof: BTreeMap<&'static str, f64>,
    /// Names of the laws whose residual exceeds the tolerance.
    pub violated: Vec<&'static str>,
    /// Whether every law holds.
    pub ok: bool,
}

impl CheckResult {
    /// Compares residuals with the tolerance.
    pub fn new([problem, solution]: [FileName; 2], tolerance: f64, checked: Checked) -> Self {
        let violated = checked.violated(tolerance);
        let law = checked.law.map(|law| if law == Law::Circular { ContactLaw::Circular } else { ContactLaw::Polygon });
        let denial = checked.denial.map(signorini_check::Denial::name);
        let (kind, ok, verdict) = (checked.kind, violated.is_empty(), checked.verdict.map(Verdict::name).or(denial));
        let laws = verdict.is_none().then(|| Laws::named(&checked.residuals));
        let proof = verdict.map_or(BTreeMap::new(), |_| checked.residuals.iter().copied().collect());
        Self { problem, solution, kind, law, tolerance, laws, verdict, proof, violated, ok }
    }
}

/// How a method ended, by name.
#[derive(Clone, Debug)]
pub struct Ending {
    /// `solved`, or another word.
    pub name: &'static str,
    /// Contacts or rows that it speaks of.
    pub involved: Vec<usize>,
    /// Why, where the method says.
    pub reason: Option<String>,
}

impl From<&'static str> for Ending {
    fn from(name: &'static str) -> Self {
        Self { name, involved: Vec::new(), reason: None }
    }
}

impl Ending {
    /// A refusal with its reason.
    pub fn refused(reason: String) -> Self {
        Self { reason: Some(reason), ..Self::from("refused") }
    }

    fn too_large(limit: usize) -> Self {
        let reason = format!("the complementarity problem has more than the {limit} pairs that the method accepts");
        Self { reason: Some(reason), ..Self::from("too_large") }
    }

    fn about(name: &'static str, involved: Vec<usize>) -> Self {
        Self { involved, ..Self::from(name) }
    }

    /// Of a solver of contact problems, with the proof that there is no solution where one was found.
    pub fn of_contacts(status: &SolveStatus, proof: Option<&Denial>) -> Self {
        match (proof, status) {
            (Some(Denial::Gaps(proof)), _) => Self::about("infeasible", proof.contacts()),
            (Some(Denial::Cases(proof)), SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts }) => {
                Self { reason: Some(excluded(proof)), ..Self::about("no_solution", contacts.clone()) }
            }
            _ => Self::without_proof(status),
        }
    }

    fn without_proof(status: &SolveStatus) -> Self {
        match status {
            SolveStatus::Solved => "solved".into(),
            SolveStatus::Ray { contacts } => {
                let reason =
                    "no solution was found, which does not prove that there is none: these contacts wedge each other";
                Self { reason: Some(reason.to_owned()), ..Self::about("unresolved", contacts.clone()) }
            }
            SolveStatus::Infeasible { contacts } => {
                let reason = "the gaps of these contacts seem to contradict each other; rounding leaves no proof";
                Self { reason: Some(reason.to_owned()), ..Self::about("unresolved", contacts.clone()) }
            }
            SolveStatus::IterationLimit => "iteration_limit".into(),
            SolveStatus::Refused(refusal) => Self::refused(refusal.to_string()),
            SolveStatus::TooLarge { limit } => Self::too_large(*limit),
            _ => "inaccurate".into(),
        }
    }

    /// Of the solver for the circular cone.
    pub fn of_cone(status: &ConeStatus, proof: Option<&Denial>) -> Self {
        match status {
            ConeStatus::Solved => "solved".into(),
            ConeStatus::Denied(status) => Self::of_contacts(status, proof),
            ConeStatus::Unsupported(unsupported) => Self::refused(unsupported.to_string()),
            _ => "inaccurate".into(),
        }
    }

    /// Of the convex relaxation.
    pub fn of_relaxation(status: &RelaxationStatus) -> Self {
        match status {
            RelaxationStatus::Solved => "solved".into(),
            RelaxationStatus::Inconsistent { proof } => {
                let presses = |i: &usize| proof.impulse[*i] != [0.0; 3];
                Self::about("infeasible", (0..proof.impulse.len()).filter(presses).collect())
            }
            RelaxationStatus::Unsupported(unsupported) => Self::refused(unsupported.to_string()),
            _ => "inaccurate".into(),
        }
    }

    /// Of a method for LCPs; it speaks of rows.
    pub fn of_lcp(status: &Status, proof: Option<&Denial>) -> Self {
        if let (Status::NoSolution, Some(Denial::Cases(proof))) = (status, proof) {
            return Self { reason: Some(excluded(proof)), ..Self::about("no_solution", proof.rows()) };
        }
        match status {
            Status::Solved => "solved".into(),
            Status::Ray(ray) => {
                let reason =
                    "the method's path ended on a ray of these rows, which does not prove that there is no solution"
                        .to_owned();
                Self { reason: Some(reason), ..Self::about("unresolved", ray.support.clone()) }
            }
            Status::Infeasible(farkas) => {
                Self::about("infeasible", (0..farkas.y.len()).filter(|&i| farkas.y[i] != 0.0).collect())
            }
            Status::NoSolution => {
                let reason = "no case was found to have a solution; rounding leaves no proof of that".to_owned();
                Self { reason: Some(reason), ..Self::from("unresolved") }
            }
            Status::IterationLimit => "iteration_limit".into(),
            Status::Inconsistent { row } => Self::about("inconsistent", vec![*row]),
            Status::Singular => "singular".into(),
            Status::TooLarge { limit } => Self::too_large(*limit),
            Status::Refused(refusal) => Self { involved: vec![refusal.row()], ..Self::refused(refusal.to_string()) },
            Status::Stationary { .. } => {
                let reason = "the descent stalled: the matrix is not P₀ there, or there is no solution".to_owned();
                Self { reason: Some(reason), ..Self::from("stationary") }
            }
            _ => "inaccurate".into(),
        }
    }
}

/// What was excluded, in words.
fn excluded(proof: &Exclusion) -> String {
    let most = |case: &ExcludedCase| case.pairs.iter().filter(|pair| **pair != PairCase::Open).count();
    let (count, pairs) = (proof.cases.len(), proof.cases.iter().map(most).max().unwrap_or(0));
    format!(
        "{count} cases, which decide at most {pairs} of the pairs and together are all, were excluded by multipliers"
    )
}

/// A contact solver's status by name; `infeasible` where that is proved.
pub fn solve_status(problem: &ContactProblem, status: &SolveStatus) -> &'static str {
    let proof = match status {
        SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts } => gap_contradiction(problem, contacts),
        _ => None,
    };
    Ending::of_contacts(status, proof.map(Denial::Gaps).as_ref()).name
}
