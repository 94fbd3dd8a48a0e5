//! Steps whose numbers have blown up: told of as what they are, with the joint that moves farthest.

use signorini_multibody::{FreeMotionError, JointKind, Model, State};

use crate::SimulationError;

/// What moves farther than this in one step, rad or m, has blown up where nothing can be computed from it any more: a hundred turns and more.
const BLOWN_UP: f64 = 1e3;

/// The error of a step that cannot begin: that the motion has blown up, where the mass matrix of a finite state fails and something moves that far.
pub(crate) fn explain(error: SimulationError, model: &Model, state: &State, dt: f64) -> SimulationError {
    let is_mass = matches!(error, SimulationError::FreeMotion(FreeMotionError::Mass(_)));
    let blown_up = is_mass.then(|| diverged(model, &[&state.v], dt)).flatten();
    blown_up.filter(|(_, travel)| *travel > BLOWN_UP).map_or(error, |(error, _)| error)
}

/// Checks what a step has led to.
///
/// - `free_velocity`: without contact, `[nv]`; it tells of the joint where the velocities at the end are no numbers
///
/// # Errors
/// [`SimulationError::Diverged`] where that is not finite.
pub(crate) fn check_finite(
    model: &Model,
    state: &State,
    free_velocity: &[f64],
    next: &State,
    dt: f64,
) -> Result<(), SimulationError> {
    if next.is_finite() {
        return Ok(());
    }
    diverged(model, &[&next.v, free_velocity, &state.v], dt).map_or(Ok(()), |(error, _)| Err(error))
}

/// The error that names the joint that moves farthest at the first of these velocities that are numbers, and how far that is, rad or m; `None`
/// without joints.
fn diverged(model: &Model, velocities: &[&[f64]], dt: f64) -> Option<(SimulationError, f64)> {
    let finite = velocities.iter().find(|v| v.iter().all(|x| x.is_finite()));
    let v = finite.or(velocities.last())?;
    let dofs = model.joints.iter().flat_map(|joint| (0..joint.kind.nv()).map(move |k| (joint, k)));
    let size = |x: f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
    let (joint, k) = dofs.max_by(|(a, i), (b, k)| {
        let [a, b] = [(a, i), (b, k)].map(|(joint, k)| size(v[joint.v_index + k]));
        a.total_cmp(&b)
    })?;
    let speed = size(v[joint.v_index + k]);
    let slides = matches!(joint.kind, JointKind::Slide { .. }) || (joint.kind == JointKind::Free && k < 3);
    let unit = if slides { "m" } else { "rad" };
    let error = SimulationError::Diverged { joint: joint.name.clone(), speed, unit, timestep: dt };
    Some((error, speed * dt))
}
