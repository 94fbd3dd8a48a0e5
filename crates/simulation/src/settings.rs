//! Settings of a simulation.

use derive_setters::Setters;
use signorini_contact::{FrictionPolygon, MOST_DIRECTIONS};
use signorini_lcp::MethodKind;
use signorini_multibody::Model;
use signorini_solver::SolverSettings;

use crate::SimulationError;
use crate::overlaps::OverlapPolicy;

/// How contact problems are solved.
#[derive(Clone, Debug, PartialEq)]
pub enum ContactMethod {
    /// The structured solver of `signorini-contact`.
    Structured(SolverSettings),
    /// The standard LCP by a method of `signorini-lcp`, dense; for comparison.
    Lcp(MethodKind),
}

impl Default for ContactMethod {
    fn default() -> Self {
        Self::Structured(SolverSettings::default())
    }
}

/// What happens when a step's contact problem has no solution, which only penetrations (φ < 0) and violated constraints can cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum InfeasiblePolicy {
    /// The step removes the largest part θ of penetrations and violations that the laws permit: its problem has the gaps
    /// `max(φ, θφ)` and the violations `θΘ`, and its report says θ and what was kept
    /// ([`StepReport::theta`](crate::StepReport::theta)). With θ = 0 there is always a solution.
    #[default]
    GoOn,
    /// The simulation stops before the step, with the report.
    Stop,
    /// The step is solved again with negative gaps taken as zero, and its report says so.
    ClipGaps,
}

/// How much velocity an impact restores (formulation §7). Coefficients are those of the geoms; with e = 0 the laws are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum RestitutionLaw {
    /// Newton's (Moreau's) law: the normal velocity after is −e times that before. With friction it can gain energy: a rod
    /// that slides as it strikes, up to a quarter of what it has.
    #[default]
    Newton,
    /// Poisson's hypothesis: the normal impulse of the decompression is e times that of the compression, in two
    /// complementarity problems. Never gains energy. A step with an impact allocates memory.
    Poisson,
}

/// The law of dry friction at contacts (formulation §§2 and 9).
///
/// The circular laws hold where friction is the same in all directions, at contacts as in joints, at servos of speed, on moving
/// surfaces, against spinning and rolling. A step with anisotropic friction is an error that says so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum FrictionLaw {
    /// Maximum dissipation over a polygon of [`Settings::directions`]: an LCP, solved exactly.
    #[default]
    Polygon,
    /// Coulomb's law with the circular cone: a nonlinear complementarity problem, solved to [`Settings::tolerance`].
    Circular,
    /// The polygon, its directions turned into the slip until the circular cone's laws hold within a tolerance: LCPs, solved
    /// exactly.
    Refined {
        /// Bound on every residual of the circular cone's laws, in (0, 1).
        tolerance: f64,
    },
}

/// Which of the impulses that give the same velocity a step ends with, where there are many (a table with four legs). The
/// motion is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImpulseChoice {
    /// The solver's: nearest to those of the step before.
    #[default]
    Solver,
    /// Those of least norm, over the polygons of the step's problem: they depend neither on the order of contacts nor on the
    /// history. Where they are not found to the tolerance the solver's are kept, and the
    /// [report](crate::StepReport::least_norm) says so.
    LeastNorm,
}

/// Settings of a simulation.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Settings {
    /// Time step Δt, s; the model's own where it is not given.
    #[setters(into)]
    pub timestep: Option<f64>,
    /// Friction directions of every contact; even, at least 4 and at most 4096. Default 8.
    pub directions: usize,
    /// Angle of the first direction from the first tangent, rad. Default 0.
    pub direction_angle: f64,
    /// Points in which two convex shapes touch, at most; 0: all that are found. The deepest and the outermost points stay; one that was
    /// left out comes in where it would close within the step, and those that overlap are all there. Default 8.
    pub contact_points: usize,
    /// Constraint stabilization γ ∈ (0, 1]: factor on φ/Δt where φ < 0, and on Θ/Δt (formulation §5). Default 1.
    pub stabilization: f64,
    /// Gaps and overlaps of at most this count as closed, m; of a deeper overlap what is beyond it counts. What rests lies so far off at most. Default 0: all
    /// but last digits count. Bodies that come to rest on each other are left with gaps of 1e-10 to 1e-6 m by the steps that brought them there, and what closes those decides
    /// which contacts slide by as much and which stick; in piles of hundreds of bodies there is no end to that. A ten-thousandth of a body's size lets them
    /// rest, and is less than what other engines let bodies sink in. The certificate is that of the gaps as they count.
    pub gap_resolution: f64,
    /// Speed at which a step removes overlaps, and violations of constraints and of limits of slides and tendons, m/s; what the
    /// motion of the step before has left is removed in full. Infinite is the paper's scheme, which removes everything in one step. Default
    /// 0.25, what robots may do beside people (ISO 10218-1, reduced speed). Corrections put in no more kinetic energy in a
    /// step than all bodies have at twice this speed and a hundredth of what they have.
    pub correction_speed: f64,
    /// The same for limits of hinges and ball joints and for the rotation of welds, rad/s. Default 1.
    pub correction_angular_speed: f64,
    /// Newton steps, at most, that bring the configuration onto the equality constraints after each step. Default 0: the
    /// stabilization alone leaves a violation of the order Δt²‖v‖² (Anitescu & Hart 2004): at Δt = 1 ms over 10 s 3e-5 m in a
    /// four-bar of a metre that swings under its weight, 2e-6 m in a delta robot, 2e-7 m in a Stewart platform. With 3 it is
    /// rounding, 1e-13 m in all of them. Overconstrained mechanisms (more
    /// rows than the mobility allows, redundant only where the loops are closed) need it.
    pub position_iterations: u32,
    /// Violation of an equality constraint with which a simulation may begin, m or rad. Default 1e-6.
    pub assembly_tolerance: f64,
    /// Law of restitution. Default Newton's.
    pub restitution: RestitutionLaw,
    /// A step has missed its tolerance when the certificate's worst residual exceeds this; the solver has it, too
    /// ([`SolverSettings::for_tolerance`](signorini_solver::SolverSettings::for_tolerance)). Default 1e-9; in (0, 1).
    pub tolerance: f64,
    /// Contact sweeps a step may make, at least 1; none for steps as exact as can be. Where they are used up, the step is made with the best point
    /// found: [`Inaccurate`](signorini_contact::SolveStatus::Inaccurate), with its true certificate, and its momentum balance and friction bounds hold to
    /// rounding. What it leaves open the next steps close, and so do they with contacts that come within reach by the velocity found. Further solves of a
    /// step, as where a joint's limit is crossed, get what is left, and at least a quarter. For the polygon's law, the structured solver, Newton's restitution and the solver's impulses;
    /// see [`SolverSettings::budget`]. Default none.
    #[setters(into)]
    pub budget: Option<u32>,
    /// Law of friction. Default polygon.
    pub friction_law: FrictionLaw,
    /// Choice among indeterminate impulses. Default the solver's.
    pub impulses: ImpulseChoice,
    /// Solver; with another law of friction than the polygon's it is the structured one.
    pub method: ContactMethod,
    /// Whether what rests is left alone: islands that the impulses of the last step hold still end the step at velocity
    /// zero without being solved, those that stood for two steps take no part in the next ones at all until something disturbs them or comes
    /// near ([`Workspace::sleeps`](crate::Workspace::sleeps)), and a step that ended where it began is made again as it was until something changes. Every
    /// step has its certificate, and the motion is the same to rounding. Trees with actuators, tendons or equality constraints, and all trees of models
    /// with mocap bodies, adhesion or restitution, are solved for as long as anything moves. Trees that [begin
    /// asleep](signorini_multibody::Body::begins_asleep) stand for as long as nothing disturbs them, whatever pulls at them: their model says so, and no law.
    /// A step in which something falls asleep or wakes allocates. The model's own where it is not given.
    #[setters(into)]
    pub sleeping: Option<bool>,
    /// What to do where there is no solution.
    pub infeasible: InfeasiblePolicy,
    /// What becomes of parts of one mechanism that overlap in its reference configuration. Default: they do not touch each other.
    pub overlaps: OverlapPolicy,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            timestep: None,
            directions: 8,
            direction_angle: 0.0,
            contact_points: 8,
            stabilization: 1.0,
            gap_resolution: 0.0,
            correction_speed: 0.25,
            correction_angular_speed: 1.0,
            position_iterations: 0,
            assembly_tolerance: 1e-6,
            restitution: RestitutionLaw::Newton,
            tolerance: 1e-9,
            budget: None,
            friction_law: FrictionLaw::Polygon,
            impulses: ImpulseChoice::Solver,
            method: ContactMethod::default(),
            sleeping: None,
            infeasible: InfeasiblePolicy::GoOn,
            overlaps: OverlapPolicy::Exclude,
        }
    }
}

impl Settings {
    /// Whether what rests is left alone: as these settings say, or else the model.
    pub(crate) fn sleeps(&self, model: &Model) -> bool {
        self.sleeping.unwrap_or(model.sleeping)
    }

    /// Checks the ranges and makes the friction polygon.
    ///
    /// # Errors
    /// [`SimulationError::Setting`] naming the setting; [`SimulationError::Incompatible`] for two that exclude each other;
    /// [`SimulationError::Problem`] for an odd number of directions or a
    /// solver setting out of its range.
    pub fn validate(&self) -> Result<FrictionPolygon, SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        if let Some(dt) = self.timestep {
            check("timestep", dt, "positive and finite", dt > 0.0 && dt.is_finite())?;
        }
        let gamma = self.stabilization;
        check("stabilization", gamma, "in (0, 1]", gamma > 0.0 && gamma <= 1.0)?;
        let resolution = self.gap_resolution;
        let is_distance = resolution >= 0.0 && resolution.is_finite();
        check("gap_resolution", resolution, "finite and not negative", is_distance)?;
        for (setting, speed) in
            [("correction_speed", self.correction_speed), ("correction_angular_speed", self.correction_angular_speed)]
        {
            check(setting, speed, "positive", speed > 0.0)?;
        }
        let assembly = self.assembly_tolerance;
        check("assembly_tolerance", assembly, "not negative", assembly >= 0.0)?;
        check("tolerance", self.tolerance, "in (0, 1)", self.tolerance > 0.0 && self.tolerance < 1.0)?;
        check("budget", f64::from(self.budget.unwrap_or(1)), "at least 1", self.budget != Some(0))?;
        check("direction_angle", self.direction_angle, "finite", self.direction_angle.is_finite())?;
        let directions = self.directions;
        check(
            "directions",
            directions as f64,
            "even, at least 4 and at most 4096",
            (4..=MOST_DIRECTIONS).contains(&directions),
        )?;
        if let FrictionLaw::Refined { tolerance } = self.friction_law {
            check("friction_law.tolerance", tolerance, "in (0, 1)", tolerance > 0.0 && tolerance < 1.0)?;
        }
        if let ContactMethod::Structured(solver) = &self.method {
            solver.validate()?;
        }
        self.check_combination()?;
        Ok(FrictionPolygon::regular(self.directions, self.direction_angle)?)
    }

    fn check_combination(&self) -> Result<(), SimulationError> {
        let exclude = |settings, reason| Err(SimulationError::Incompatible { settings, reason });
        let polygon = self.friction_law == FrictionLaw::Polygon;
        if !polygon && matches!(self.method, ContactMethod::Lcp(_)) {
            return exclude(["friction_law", "method"], "a method for LCPs solves the polygon's law alone");
        }
        if self.budget.is_some() {
            let reason =
                "sweeps are those of the structured solver with the polygon's law, without a choice among impulses";
            if !polygon {
                return exclude(["budget", "friction_law"], reason);
            }
            if matches!(self.method, ContactMethod::Lcp(_)) {
                return exclude(["budget", "method"], reason);
            }
            if self.impulses == ImpulseChoice::LeastNorm {
                return exclude(["budget", "impulses"], reason);
            }
            if self.restitution == RestitutionLaw::Poisson {
                return exclude(["budget", "restitution"], "Poisson's decompression is solved without sweeps");
            }
        }
        if self.restitution == RestitutionLaw::Poisson && self.impulses == ImpulseChoice::LeastNorm {
            let reason =
                "Poisson's decompression bounds friction by shifted groups, among which no impulses are chosen";
            return exclude(["impulses", "restitution"], reason);
        }
        Ok(())
    }

    /// The solver in a few words, for people: the method, and the law where it is not the polygon's.
    pub fn solver_name(&self) -> String {
        match (self.friction_law, &self.method) {
            (FrictionLaw::Polygon, ContactMethod::Structured(_)) => "structured".into(),
            (FrictionLaw::Polygon, ContactMethod::Lcp(kind)) => kind.to_string(),
            (FrictionLaw::Circular, _) => "circular cone".into(),
            (FrictionLaw::Refined { .. }, _) => "direction refinement".into(),
        }
    }
}
