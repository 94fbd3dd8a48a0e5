//! What a solve with the circular cone starts from and ends with.

use crate::residuals::Certificate;
use crate::{ContactProblem, ContactSolution, SolveStatus, StageCounts, UnsupportedFriction, WarmStart};

/// What a solve with the circular cone ended with.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum ConeStatus {
    /// Every law holds within the tolerance.
    #[default]
    Solved,
    /// The best point found; its residuals exceed the tolerance.
    Inaccurate,
    /// As above, and the problem with the polygon ended on a ray or is infeasible: [`SolveStatus::Ray`] or
    /// [`SolveStatus::Infeasible`] with the contacts.
    Denied(SolveStatus),
    /// The circular cone has no law for friction that the problem has; nothing was solved.
    Unsupported(UnsupportedFriction),
}

/// A way to a start for Newton's method, in the order in which they are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConeStart {
    /// The caller's impulses.
    Warm,
    /// No impulses (problems in impulse space).
    Zero,
    /// The exact solution with the problem's own polygons.
    Polygon,
    /// The same with directions turned into the slip.
    Refinement,
    /// Block Gauss–Seidel sweeps with an exact solve of each contact.
    Sweeps,
}

/// What was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ConeReport {
    /// The start that led to the solution, or the last one tried.
    pub start: Option<ConeStart>,
    /// Starts that were tried.
    pub starts: u32,
    /// Proximal iterations.
    pub proximal_iterations: u32,
    /// Newton steps.
    pub newton_iterations: u32,
    /// LU factorisations.
    pub factorizations: u32,
    /// Polygonal problems solved.
    pub polygon_solves: u32,
    /// What the structured solver's stages did for them.
    pub stages: StageCounts,
    /// Sweeps over all contacts.
    pub sweeps: u32,
}

/// Velocity and impulses of one step with the circular cone, with their certificate.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ConeSolution {
    /// Next velocity `v⁺`, `[nv]`, m/s or rad/s; empty for a problem in impulse space.
    pub velocity: Vec<f64>,
    /// Impulses (normal, tangent 1, tangent 2) of each contact, `[nc]`, N·s.
    pub impulse: Vec<[f64; 3]>,
    /// Impulses of the bilateral rows `λ_B`, `[nb]`, N·s or N·m·s.
    pub bilateral: Vec<f64>,
    /// Impulses of each friction group along its two generalized directions, N·s or N·m·s.
    pub group_impulse: Vec<[f64; 2]>,
    /// How the solve ended.
    pub status: ConeStatus,
    /// Residuals of the laws, computed from the data.
    pub certificate: Certificate,
    /// What was done.
    pub report: ConeReport,
}

impl ConeSolution {
    /// Whether the sizes are those of a problem.
    pub fn fits(&self, problem: &ContactProblem) -> bool {
        self.velocity.len() == problem.nv()
            && self.impulse.len() == problem.contact_count()
            && self.bilateral.len() == problem.bilateral_violation.len()
            && self.group_impulse.len() == problem.friction_groups.len()
    }

    /// Takes velocity and impulses of a polygon's solution.
    pub fn take_polygon(&mut self, solution: &ContactSolution) {
        self.velocity.clone_from(&solution.velocity);
        self.impulse.clone_from(&solution.impulse);
        self.bilateral.clone_from(&solution.bilateral);
        self.group_impulse.clone_from(&solution.group_impulse);
    }

    /// The velocity without impulses, for a problem with friction that the cone has no law for.
    pub fn refuse(&mut self, problem: &ContactProblem, unsupported: UnsupportedFriction) {
        self.velocity.clone_from(&problem.free_velocity);
        self.impulse.clear();
        self.impulse.resize(problem.contact_count(), [0.0; 3]);
        self.bilateral.clear();
        self.bilateral.resize(problem.bilateral_violation.len(), 0.0);
        self.group_impulse.clear();
        self.group_impulse.resize(problem.friction_groups.len(), [0.0; 2]);
        self.report = ConeReport::default();
        self.status = ConeStatus::Unsupported(unsupported);
        self.certificate = Certificate::everything_violated();
    }
}

/// Impulses of an earlier solve, one entry per contact and per friction group of the next problem.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ConeWarmStart {
    /// Impulse (normal, tangent 1, tangent 2) of each contact, N·s.
    pub impulse: Vec<[f64; 3]>,
    /// Impulse of each friction group, N·s or N·m·s.
    pub group_impulse: Vec<[f64; 2]>,
    /// Impulses of the bilateral rows, N·s or N·m·s.
    pub bilateral: Vec<f64>,
}

impl ConeWarmStart {
    /// Forgets everything and keeps the memory.
    pub fn clear(&mut self) {
        self.impulse.clear();
        self.group_impulse.clear();
        self.bilateral.clear();
    }

    /// Adds the entry for the next friction group: its impulse in an earlier solution; zero for a new one.
    pub fn push_group(&mut self, impulse: [f64; 2]) {
        self.group_impulse.push(impulse);
    }

    /// Adds the entry for the next contact: its impulse (normal, tangent 1, tangent 2) in an earlier solution, N·s; zero for
    /// a new contact.
    pub fn push(&mut self, impulse: [f64; 3]) {
        self.impulse.push(impulse);
    }

    /// Carries the bilateral impulses over.
    pub fn set_bilateral(&mut self, impulses: &[f64]) {
        self.bilateral.clear();
        self.bilateral.extend_from_slice(impulses);
    }

    /// Takes the impulses of a polygon's start over; zero for new contacts and groups.
    pub fn take(&mut self, start: &WarmStart) {
        self.clear();
        self.impulse.extend(start.contacts.iter().map(|entry| entry.map_or([0.0; 3], |(impulse, _)| impulse)));
        self.group_impulse.extend(start.groups.iter().map(|entry| entry.map_or([0.0; 2], |([_, a, b], _)| [a, b])));
        self.bilateral.extend_from_slice(&start.bilateral);
    }

    /// Whether the sizes are those of a problem.
    pub fn fits(&self, problem: &ContactProblem) -> bool {
        self.impulse.len() == problem.contact_count() && self.group_impulse.len() == problem.friction_groups.len()
    }
}
