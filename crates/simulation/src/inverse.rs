//! Inverse dynamics with contact: which torques give a prescribed motion, and which contact impulses come with it.
//!
//! A hard contact that stays closed can carry any impulse, so velocities alone do not determine the torques (MuJoCo's
//! `mj_inverse` has an answer because its contacts are soft: their force is a function of the acceleration). What does
//! determine them is the contact law itself. Here some degrees of freedom are *driven*: their velocity at the end of the
//! step is prescribed and the torque on them is whatever that takes. All others follow from the laws of the step,
//!
//! ```text
//! M̂ (v⁺ − v^f) = J_Nᵀ λ_N + J_Tᵀ D α + S Δt τ,   Sᵀ v⁺ = target,   contact laws of v⁺ (formulation §§2–5),
//! ```
//!
//! with `S` the columns of the driven degrees of freedom. `Δt τ` are the multipliers of bilateral rows in the same LCP,
//! and the solution carries the same certificate as a step. A force acts on the Coriolis forces at the end of the motion without contact, too
//! ([`free_motion_into`](signorini_multibody::free_motion_into)), where a multiplier acts against `M̂` alone: where trees turn, what is found is
//! applied as a force, and what is still missing is found again, until nothing is. With the joints of a robot driven and its floating base not,
//! this is the question of a controller; with all degrees of freedom driven, `τ` is the generalized force that is missing
//! for the motion after what contacts can do; with none it is a step.

use signorini_multibody::{Input, Model, State};

use crate::SimulationError;
use crate::report::StepReport;
use crate::settings::Settings;
use crate::step::{DrivenVelocity, step_driven};
use crate::workspace::Workspace;

/// What a round leaves of the force is less by a factor of the angle that the trees turn by in the step: after so many a tree that turns by a fifth of
/// a radian leaves rounding alone.
const MAX_ROUNDS: u32 = 20;

/// The part of the force that counts as nothing: the rounding of a solve, some hundreds of last digits.
const NOTHING: f64 = 1e-13;

/// What [`inverse_step`] computes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseMotion {
    /// The state after the step, whose `v` holds the prescribed velocities.
    pub next: State,
    /// The generalized force `τ` on the driven degrees of freedom, `[nv]`, N or N·m; zero on all others.
    pub generalized_force: Vec<f64>,
}

impl InverseMotion {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self { next: State::new(model), generalized_force: vec![0.0; model.nv] }
    }
}

/// The generalized force with which a step ends with the prescribed velocities.
///
/// A step with it added to `input.generalized_force` ends in the same state wherever the contact problem has one
/// velocity, and as long as no servo reaches the end of its force range in one of the two.
///
/// - `state`: `(t, q, v)`; `input`: what else acts
/// - `driven`: the prescribed velocities, at most one for a degree of freedom
/// - `out`: see [`InverseMotion`]
///
/// Contacts and their impulses are in the workspace, as after a [`step`](crate::step()). Where the report says that there
/// is no solution (a limit or contact forbids the motion), the state is
/// unchanged and the force zero.
///
/// # Errors
/// [`SimulationError::Prescription`] for a degree of freedom that does not exist or is named twice, or a velocity that is not
/// finite; otherwise as for [`step`](crate::step()).
///
/// # Panics
/// If `out` belongs to another model.
pub fn inverse_step(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    driven: &[DrivenVelocity],
    workspace: &mut Workspace,
    out: &mut InverseMotion,
) -> Result<StepReport, SimulationError> {
    let tau = &mut out.generalized_force;
    assert_eq!(tau.len(), model.nv, "the storage belongs to another model");
    check(model, driven)?;
    // The impulses of the last step belong to another set of bilateral rows.
    workspace.clear_warm_start();
    tau.fill(0.0);
    let mut forced = input.clone();
    forced.generalized_force.resize(model.nv, 0.0);
    let mut rounds = 0;
    let report = loop {
        let report = step_driven(model, state, &forced, settings, driven, workspace, &mut out.next)?;
        if !report.advanced() {
            tau.fill(0.0);
            break report;
        }
        let (impulses, dt) = (&workspace.solution.bilateral, workspace.builder.problem.timestep);
        let (mut missing, mut size) = (0.0_f64, 0.0_f64);
        for (drive, impulse) in driven.iter().zip(&impulses[impulses.len() - driven.len()..]) {
            let force = impulse / dt;
            tau[drive.dof] += force;
            forced.generalized_force[drive.dof] += force;
            (missing, size) = (missing.max(force.abs()), size.max(tau[drive.dof].abs()));
        }
        rounds += 1;
        if !workspace.smooth.turns() || missing <= NOTHING * size || rounds == MAX_ROUNDS {
            break report;
        }
    };
    workspace.clear_warm_start();
    Ok(report)
}

fn check(model: &Model, driven: &[DrivenVelocity]) -> Result<(), SimulationError> {
    for (index, &DrivenVelocity { dof, velocity }) in driven.iter().enumerate() {
        let wrong = |expected| SimulationError::Prescription { index, dof, velocity, expected };
        if dof >= model.nv {
            return Err(wrong("the model has no such degree of freedom"));
        }
        if !velocity.is_finite() {
            return Err(wrong("it must be finite"));
        }
        if driven[..index].iter().any(|earlier| earlier.dof == dof) {
            return Err(wrong("it is prescribed twice"));
        }
    }
    Ok(())
}
