//! One time step (formulation §6), on one screen.

use signorini_multibody::{Input, Model, State};

use crate::report::StepReport;
use crate::settings::Settings;
use crate::workspace::Workspace;
use crate::{SimulationError, divergence};

/// How often a step is found and solved again because a body moved farther than its reach.
const MAX_ENLARGEMENTS: u32 = 8;

/// A point left out may close by this part of the tolerance.
const LEFT_OPEN: f64 = 0.01;

/// The velocity that a degree of freedom shall have at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenVelocity {
    /// The degree of freedom, an index into `v`.
    pub dof: usize,
    /// Its velocity at the end of the step, m/s or rad/s.
    pub velocity: f64,
}

/// Advances a state by Δt: kinematics → contacts → free motion → contact problem → solution → next state.
///
/// - `state`: `(t, q, v)` and activations; `next`: out, same sizes
/// - `input`: what acts during the step
///
/// Overlaps and violated constraints are removed as far as the laws permit ([`StepReport::theta`]). With
/// [`InfeasiblePolicy::Stop`](crate::InfeasiblePolicy), and where prescribed velocities are impossible, a contact problem without solution
/// leaves `next` as the unchanged state, and the report says so.
///
/// # Errors
/// [`SimulationError::FreeMotion`] if the state or input does not fit the model, is not finite, or the mass matrix is
/// singular there; [`SimulationError::Diverged`] if the numbers of the motion have blown up; [`SimulationError::Problem`] if the contact problem is malformed; [`SimulationError::ContradictingEqualities`] if
/// equality constraints exclude each other.
pub fn step(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    workspace: &mut Workspace,
    next: &mut State,
) -> Result<StepReport, SimulationError> {
    let dt = settings.timestep.unwrap_or(model.timestep);
    let sleeping = settings.sleeps(model);
    if sleeping && let Some(report) = workspace.stay(state, input, settings, dt, next) {
        workspace.sleepers.was_repeated = true;
        return Ok(report);
    }
    workspace.sleepers.holds = sleeping;
    let made = step_driven(model, state, input, settings, &[], workspace, next);
    let mut report = made.inspect_err(|_| workspace.wake_all())?;
    workspace.report_sleepers(&mut report);
    if sleeping {
        workspace.fixed_point.observe(state, input, next, dt, &report);
        workspace.note_standing(state, input, next, dt, &report);
    }
    Ok(report)
}

/// [`step`] in which some degrees of freedom end with a given velocity, whatever torque that takes: each is a bilateral row
/// `v⁺_k = target`, after those of the model.
pub(crate) fn step_driven(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    driven: &[DrivenVelocity],
    workspace: &mut Workspace,
    next: &mut State,
) -> Result<StepReport, SimulationError> {
    let dt = settings.timestep.unwrap_or(model.timestep);
    let ws = workspace;
    if !driven.is_empty() {
        ws.sleepers.holds = false;
        ws.wake_all();
    }
    state.check(model)?;
    ws.begin(model, state, input, dt).map_err(|error| divergence::explain(error, model, state, dt))?;
    let mut report = StepReport { unresolved_rotations: ws.smooth.unresolved_rotations, ..StepReport::default() };
    ws.find_points(model);
    let mut problems = 0;
    loop {
        ws.choose_points(settings, dt);
        // Where a larger reach has no new points the solution at hand is that of the step, with the part of its corrections that is permitted.
        if problems == 0 || !ws.candidates.are_written() {
            problems += 1;
            solve_chosen(model, state, input, settings, driven, ws, &mut report)?;
        }
        if !report.advanced() {
            break;
        }
        ws.warm.keep(&ws.builder.keys, &ws.builder.group_keys, &ws.solution);
        ws.remember_withheld();
        // Where the sweeps were used up, what else would close is left to the next step, as what they left open is.
        if report.spread.is_some() {
            break;
        }
        ws.reach.end_with(model, &ws.kinematics, &ws.solution.velocity);
        if ws.brings_in(LEFT_OPEN * settings.tolerance) {
            continue;
        }
        if report.enlargements == MAX_ENLARGEMENTS || !ws.enlarge_reach() {
            break;
        }
        report.enlargements += 1;
        ws.find_points(model);
    }
    ws.decompress(settings, &mut report)?;
    next.time = state.time;
    next.q.clone_from(&state.q);
    next.v.clone_from(&state.v);
    next.activation.clone_from(&state.activation);
    if report.advanced() {
        ws.advance_into(model, state, input, settings, next);
        if let Err(error) = divergence::check_finite(model, state, &ws.builder.problem.free_velocity, next, dt) {
            // No later step begins from impulses that are no numbers.
            ws.warm.clear();
            next.clone_from(state);
            return Err(error);
        }
    }
    Ok(report)
}

/// Builds the problem with the points that are chosen, and solves it, again with every limit that its solution crosses.
fn solve_chosen(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    driven: &[DrivenVelocity],
    ws: &mut Workspace,
    report: &mut StepReport,
) -> Result<(), SimulationError> {
    ws.build_problem(model, state, input);
    let dt = ws.builder.problem.timestep;
    for drive in driven {
        ws.builder.problem.push_bilateral([(drive.dof as u32, [1.0])], -dt * drive.velocity);
    }
    ws.corrections.ask(&ws.builder.problem, ws.builder.bilateral_source.len());
    ws.solve(model, settings, &state.v, report)?;
    ws.name_contradiction(model, settings)?;
    while report.advanced() && ws.builder.add_crossed_limits(model, &ws.kinematics, state, &ws.solution.velocity) {
        ws.solve(model, settings, &state.v, report)?;
    }
    Ok(())
}
