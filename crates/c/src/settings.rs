//! Settings of simulations.

use signorini::{FrictionLaw, ImpulseChoice, InfeasiblePolicy, OverlapPolicy, RestitutionLaw, Settings};

/// Settings of a simulation. Begin with signorini_settings_default().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct signorini_settings {
    /// Time step, s; 0 for the model's own.
    pub timestep: f64,
    /// Friction directions of every contact: even, at least 4.
    pub directions: u32,
    /// Points in which two convex shapes touch, at most; 0 for all that are found.
    pub contact_points: u32,
    /// Contact sweeps that a step may make; 0 for steps as exact as can be. A step that used them up ends with the best point found and its true
    /// certificate, and with SIGNORINI_MISSED_TOLERANCE.
    pub budget: u32,
    /// Newton steps, at most, that bring the configuration onto the equality constraints after each step.
    pub position_iterations: u32,
    /// Whether friction has the circular cone in place of a polygon.
    pub circular_cone: bool,
    /// Whether impacts follow Poisson's hypothesis; otherwise Newton's law.
    pub poisson: bool,
    /// Whether of the impulses that give the same velocity a step ends with those of least norm.
    pub least_norm_impulses: bool,
    /// Whether islands at rest are left alone even where the model does not ask for it.
    pub sleeping: bool,
    /// Whether all negative gaps count as zero where contacts contradict each other.
    pub clip_gaps: bool,
    /// Whether a step whose overlaps contradict each other ends with SIGNORINI_NO_SOLUTION; otherwise it keeps the part that the laws
    /// do not permit to remove.
    pub stop_at_contradiction: bool,
    /// Whether parts of one mechanism that overlap in its reference configuration are contacts like all others; otherwise they do not
    /// touch each other.
    pub keep_overlaps: bool,
    /// Whether such an overlap is an error that names the parts, when the simulation is made.
    pub stop_at_overlaps: bool,
    /// Factor on the velocity that corrects penetrations and violated constraints, in (0, 1].
    pub stabilization: f64,
    /// Speed at which overlaps and violations of constraints are removed, m/s.
    pub correction_speed: f64,
    /// The same for hinges, ball joints and the rotation of welds, rad/s.
    pub correction_angular_speed: f64,
    /// Gaps and overlaps of at most this count as closed, m.
    pub gap_resolution: f64,
    /// Largest residual of a step that counts as solved, in (0, 1).
    pub tolerance: f64,
}

/// The settings' defaults: the model's time step, polygons with 8 directions, Newton's law, a tolerance of 1e-9.
#[no_mangle]
pub extern "C" fn signorini_settings_default() -> signorini_settings {
    let usual = Settings::default();
    signorini_settings {
        timestep: usual.timestep.unwrap_or(0.0),
        directions: usual.directions as u32,
        contact_points: usual.contact_points as u32,
        budget: usual.budget.unwrap_or(0),
        position_iterations: usual.position_iterations,
        circular_cone: usual.friction_law == FrictionLaw::Circular,
        poisson: usual.restitution == RestitutionLaw::Poisson,
        least_norm_impulses: usual.impulses == ImpulseChoice::LeastNorm,
        sleeping: usual.sleeping.unwrap_or(false),
        clip_gaps: usual.infeasible == InfeasiblePolicy::ClipGaps,
        stop_at_contradiction: usual.infeasible == InfeasiblePolicy::Stop,
        keep_overlaps: usual.overlaps == OverlapPolicy::Keep,
        stop_at_overlaps: usual.overlaps == OverlapPolicy::Stop,
        stabilization: usual.stabilization,
        correction_speed: usual.correction_speed,
        correction_angular_speed: usual.correction_angular_speed,
        gap_resolution: usual.gap_resolution,
        tolerance: usual.tolerance,
    }
}

impl signorini_settings {
    /// The settings that these are.
    pub(crate) fn settings(&self) -> Settings {
        let mut settings = Settings::default()
            .with_timestep((self.timestep != 0.0).then_some(self.timestep))
            .with_directions(self.directions as usize)
            .with_contact_points(self.contact_points as usize)
            .with_budget((self.budget != 0).then_some(self.budget))
            .with_position_iterations(self.position_iterations)
            .with_sleeping(self.sleeping.then_some(true))
            .with_stabilization(self.stabilization)
            .with_correction_speed(self.correction_speed)
            .with_correction_angular_speed(self.correction_angular_speed)
            .with_gap_resolution(self.gap_resolution)
            .with_tolerance(self.tolerance);
        if self.circular_cone {
            settings.friction_law = FrictionLaw::Circular;
        }
        if self.poisson {
            settings.restitution = RestitutionLaw::Poisson;
        }
        if self.least_norm_impulses {
            settings.impulses = ImpulseChoice::LeastNorm;
        }
        if self.stop_at_contradiction {
            settings.infeasible = InfeasiblePolicy::Stop;
        }
        if self.clip_gaps {
            settings.infeasible = InfeasiblePolicy::ClipGaps;
        }
        if self.keep_overlaps {
            settings.overlaps = OverlapPolicy::Keep;
        }
        if self.stop_at_overlaps {
            settings.overlaps = OverlapPolicy::Stop;
        }
        settings
    }
}
