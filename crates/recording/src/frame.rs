//! One step of a run.

use crate::solution::StepSolution;

/// Position in m and unit quaternion, `[x, y, z, qw, qx, qy, qz]`.
pub type PoseArray = [f64; 7];

/// The state after a step, and how the step was solved.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Number of the step; 0 is the initial state.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Configuration, `[nq]`.
    pub q: Vec<f64>,
    /// Velocity, `[nv]`.
    pub v: Vec<f64>,
    /// Activations of actuators, `[na]`.
    pub activation: Vec<f64>,
    /// PoseArray of every body in the world, in the order of [`Header::bodies`](crate::Header::bodies);
    /// the world's own is the identity.
    pub body_poses: Vec<PoseArray>,
    /// The candidate contacts of the step.
    pub contacts: Vec<RecordedContact>,
    /// Directions that [`PolygonCode::Listed`] refers to, in contact coordinates.
    pub listed_directions: Vec<[f64; 2]>,
    /// The step's certificate.
    pub residuals: Residuals,
    /// Energy of the state.
    pub energy: Energy,
    /// Solver iterations or pivots.
    pub iterations: u32,
    /// What the solver's stages did, those that were asked.
    pub stages: Vec<StageFrame>,
    /// How the solver ended.
    pub status: StepStatus,
    /// Whether a residual exceeds the run's tolerance.
    pub missed_tolerance: bool,
    /// What acted and what was found, so that the certificate can be computed again.
    pub solution: StepSolution,
}

/// One candidate contact. Body B lies on the side that the normal points to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RecordedContact {
    /// Body A, index into [`Header::bodies`](crate::Header::bodies).
    pub body_a: u32,
    /// Body B.
    pub body_b: u32,
    /// Shape of A, index into [`Header::geoms`](crate::Header::geoms).
    pub geom_a: u32,
    /// Shape of B.
    pub geom_b: u32,
    /// Contact point in the world, m.
    pub point: [f64; 3],
    /// Unit normal from A to B, in the world.
    pub normal: [f64; 3],
    /// First unit tangent; (normal, tangent 1, tangent 2) is right-handed and orthonormal.
    pub tangent_1: [f64; 3],
    /// Second unit tangent.
    pub tangent_2: [f64; 3],
    /// Signed distance φ at the start of the step, m; negative when penetrating.
    pub gap: f64,
    /// Friction coefficient μ.
    pub friction: f64,
    /// Normal impulse λ_N of the step on B, N·s (on A the opposite).
    pub lambda_n: f64,
    /// Tangential impulse λ_T of the step on B along the two tangents, N·s.
    pub lambda_t: [f64; 2],
    /// Tangential velocity c_T of B relative to A at the end of the step, m/s.
    pub velocity_t: [f64; 2],
    /// What the contact did.
    pub mode: ContactModeCode,
    /// The directions of its friction polygon.
    pub polygon: PolygonCode,
}

/// What a contact did in a step. Directions are numbered as in its polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactModeCode {
    /// No normal impulse.
    #[default]
    Open,
    /// Touching without sliding.
    Sticking,
    /// Friction at its bound along one direction of the polygon.
    Sliding {
        /// The direction.
        direction: u32,
    },
    /// Friction at its bound between two neighbouring directions.
    SlidingBetween {
        /// The one.
        first: u32,
        /// The other.
        second: u32,
    },
}

/// The unit directions d_k of a contact's friction polygon μ λ_N conv{d_k}, in the coordinates of
/// the two tangents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PolygonCode {
    /// `directions` equally spaced directions, d_k at the angle `angle` + 2πk/`directions`.
    Regular {
        /// Number of directions; 0 for a contact without friction.
        directions: u32,
        /// Angle of the first direction from tangent 1, rad.
        angle: f64,
    },
    /// `count` entries of [`Frame::listed_directions`] from `start` on.
    Listed {
        /// The first entry.
        start: u32,
        /// How many.
        count: u32,
    },
}

impl Default for PolygonCode {
    /// No friction.
    fn default() -> Self {
        Self::Regular { directions: 0, angle: 0.0 }
    }
}

/// The certificate of the formulation, §8: zero for an exact solution, without unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residuals {
    /// Momentum balance.
    pub momentum: f64,
    /// Natural-map residual of the LCP.
    pub natural_map: f64,
    /// Signorini's condition.
    pub signorini: f64,
    /// Friction bound.
    pub friction: f64,
    /// Maximum dissipation.
    pub dissipation: f64,
}

impl Residuals {
    /// The largest of the five; NaN when one of them is.
    pub fn worst(&self) -> f64 {
        let all = [self.momentum, self.natural_map, self.signorini, self.friction, self.dissipation];
        all.into_iter().fold(0.0, |worst, x| if worst >= x || worst.is_nan() { worst } else { x })
    }
}

/// Energy of a state, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Kinetic energy ½ vᵀM v.
    pub kinetic: f64,
    /// Potential energy of gravity and springs.
    pub potential: f64,
}

/// What a stage of the solver did in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StageFrame {
    /// The stage, index into [`Header::stages`](crate::Header::stages).
    pub stage: u32,
    /// How often it was asked: once for each island that came to it.
    pub asked: u32,
    /// How often it ended an island.
    pub ended: u32,
    /// Its time, ns, where it was measured. Recordings do not hold it, so that the same run gives the same bytes.
    pub nanoseconds: u64,
}

/// How the solver of a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum StepStatus {
    /// Every residual within tolerance.
    #[default]
    Solved,
    /// A solution was found, but a residual exceeds the tolerance.
    Inaccurate,
    /// Ended on a ray: the constraints contradict each other, or the method cannot decide.
    Ray,
    /// Shown to have no solution.
    Infeasible,
    /// Stopped at the iteration limit.
    IterationLimit,
    /// Ended on numerical grounds, such as a singular matrix.
    NumericalFailure,
}
