//! Why a simulation cannot be set up or cannot go on.

use signorini_collision::CollisionError;
use signorini_contact::ProblemError;
use signorini_multibody::{FreeMotionError, ModelError, StateError};

/// Wrong input to a simulation. How a contact problem ended is not an error: it is in the
/// [`StepReport`](crate::StepReport).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// A setting is out of its range.
    #[error("setting {setting} = {found}: must be {expected}")]
    Setting {
        /// The setting.
        setting: &'static str,
        /// What it has to be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// A motor that is asked to hold and whose force has no bounds.
    #[error("actuator '{name}' would hold anything: give it a force range (forcerange, for a motor ctrlrange)")]
    UnboundedMotor {
        /// The actuator.
        name: String,
    },
    /// Two settings that exclude each other.
    #[error("settings {} and {} exclude each other: {reason}", settings[0], settings[1])]
    Incompatible {
        /// The settings.
        settings: [&'static str; 2],
        /// Why.
        reason: &'static str,
    },
    /// A batch of more simulations than there is memory for.
    #[error("there is no memory for {simulations} simulations")]
    Memory {
        /// How many were asked for.
        simulations: usize,
    },
    /// The model's shapes cannot be prepared for collision.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// Numbers that the model cannot have.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The motion without contact cannot be computed.
    #[error(transparent)]
    FreeMotion(#[from] FreeMotionError),
    /// The state does not fit the model.
    #[error(transparent)]
    State(#[from] StateError),
    /// The simulation begins with a configuration that violates equality constraints.
    #[error(
        "the start violates equality constraints by more than {tolerance:e}: {}; call `assemble`, or allow it with \
         `Settings::assembly_tolerance`",
        violations.iter().map(|(name, size)| format!("'{name}' by {size:.3e}")).collect::<Vec<_>>().join(", ")
    )]
    NotAssembled {
        /// Violation that is allowed, m or rad.
        tolerance: f64,
        /// The constraints beyond it, with the largest |Θ| of their rows, m or rad.
        violations: Vec<(String, f64)>,
    },
    /// Equality constraints that no velocity satisfies together.
    #[error("the equality constraints {} contradict each other", names.iter().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(", "))]
    ContradictingEqualities {
        /// The constraints, in the model's order.
        names: Vec<String>,
    },
    /// Parts of one mechanism that lie inside each other, where the settings forbid it.
    #[error(
        "parts of one mechanism overlap in the reference configuration: {pairs}; draw them apart, exclude them in the model's file, \
         or let them not touch (`Settings::overlaps`)"
    )]
    OwnOverlaps {
        /// The pairs of geoms and how deep they overlap, for people.
        pairs: String,
    },
    /// The steps of a recording cannot be certified again.
    #[error("this recording cannot be checked: {reason}")]
    Recording {
        /// Why, and what to do.
        reason: &'static str,
    },
    /// A motion whose numbers have blown up: the state after the step is not finite, or the mass matrix of the state before it cannot be factorised while
    /// something moves by more than 1,000 rad or m in a step. The state before the step is as it was.
    #[error(
        "the motion has blown up: joint '{joint}' moves with {speed:.3e} {unit}/s, {:.3e} {unit} in a step of {timestep:e} s; take a shorter time \
         step, or give what moves damping or armature",
        speed * timestep
    )]
    Diverged {
        /// The joint with the largest speed.
        joint: String,
        /// That speed, rad/s or m/s.
        speed: f64,
        /// "rad" or "m".
        unit: &'static str,
        /// The time step, s.
        timestep: f64,
    },
    /// The contact problem is malformed.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Velocities that a motion prescribes and that the model cannot take.
    #[error("prescribed velocity {index} is of degree of freedom {dof} with {velocity}: {expected}")]
    Prescription {
        /// Where in the list.
        index: usize,
        /// Its degree of freedom.
        dof: usize,
        /// The velocity.
        velocity: f64,
        /// What it has to be.
        expected: &'static str,
    },
    /// Numbers that are not a warm start.
    #[error(
        "these {found} numbers are not a warm start: pass what Workspace::warm_start gave for this model, unchanged"
    )]
    WarmStart {
        /// How many numbers there are.
        found: usize,
    },
    /// Bytes that are no snapshot, or a snapshot of something else.
    #[error("this is no snapshot to go on from: {reason}")]
    Snapshot {
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A state that does not come to rest.
    #[error(
        "not at rest after {steps} steps: the kinetic energy is {kinetic_energy:.3e} J, and '{body}' moves fastest, with {speed:.3e}; \
         what settles slowly needs more steps (from the state reached one can go on), what slides or rolls for ever never does"
    )]
    NotSettled {
        /// Steps made.
        steps: u32,
        /// Kinetic energy of the state reached, J.
        kinetic_energy: f64,
        /// The body with the largest entry of the velocity.
        body: String,
        /// That entry, m/s or rad/s.
        speed: f64,
    },
    /// The threads of a batch cannot be started.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A name that the model does not have.
    #[error("there is no {sort} '{name}'; the model has {}", if known.is_empty() { "none" } else { known })]
    UnknownName {
        /// Sort of part.
        sort: &'static str,
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
}
