//! The contact problem of a configuration at rest, for statics.

use signorini_contact::{ContactFrame, ContactProblem, FrictionPolygon, ProblemError};
use signorini_multibody::{ContactPoint, Input, Model, State};

use crate::SimulationError;
use crate::settings::Settings;
use crate::source::{ContactSource, FrictionSource};
use crate::workspace::Workspace;

/// The contact problem of a configuration at rest: every contact in it touches.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RestProblem {
    /// The problem: velocity before the step zero, all gaps and violations 0, `M v^f` the impulse of the loads during Δt.
    pub problem: ContactProblem,
    /// What each contact comes from.
    pub contacts: Vec<ContactSource>,
    /// Frames of the contact points, which come first among the contacts.
    pub frames: Vec<ContactFrame>,
    /// What each friction group comes from; contacts are named by their index here.
    pub groups: Vec<FrictionSource>,
    /// The deepest overlap of a contact that is taken as touching, m or rad (≥ 0).
    pub deepest_overlap: f64,
    /// The largest violation of an equality constraint, which is taken as 0, m or rad.
    pub constraint_error: f64,
}

/// Builds the contact problem of a configuration at rest under its loads: all points of shapes and all limits whose gap is at most
/// `tolerance` touch, whatever could close them, and all others are open.
///
/// - `state`: its velocity is taken as zero
/// - `tolerance`: m, for limits of hinges rad
///
/// # Errors
/// [`SimulationError::Setting`] for a tolerance that is negative or not finite; otherwise as [`step`](crate::step()).
pub fn rest_problem(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    tolerance: f64,
) -> Result<RestProblem, SimulationError> {
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        let expected = "finite and not negative";
        return Err(SimulationError::Setting { setting: "contact tolerance", expected, found: tolerance });
    }
    let (mut ws, state) = begin(model, state, input, settings)?;
    ws.collider.keep_outlines_whole();
    ws.reach.reach.iter_mut().for_each(|reach| (reach.linear, reach.angular) = (tolerance, 0.0));
    ws.reach.by_pairs = false;
    ws.find_points(model);
    let near: Vec<bool> = ws.candidates.all.iter().map(|point| point.gap <= tolerance).collect();
    let mut found = near.iter();
    ws.candidates.all.retain(|_| *found.next().unwrap_or(&false));
    Ok(finish(ws, model, &state, input, tolerance))
}

/// The same with contact points that are known from elsewhere, such as the faces of blocks, whatever the shapes of the model are; of limits those
/// that are reached. All points touch, whatever their gap is.
///
/// # Errors
/// As [`rest_problem`].
pub fn rest_problem_at(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    points: &[ContactPoint],
) -> Result<RestProblem, SimulationError> {
    let (mut ws, state) = begin(model, state, input, settings)?;
    ws.candidates.all.clear();
    ws.candidates.all.extend_from_slice(points);
    ws.candidates.all.iter_mut().for_each(|point| point.gap = 0.0);
    Ok(finish(ws, model, &state, input, 0.0))
}

/// A workspace at the state with velocity zero, and that state.
fn begin(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
) -> Result<(Workspace, State), SimulationError> {
    let mut state = state.clone();
    state.v.fill(0.0);
    state.check(model)?;
    let mut ws = Workspace::new(model, settings)?;
    let dt = settings.timestep.unwrap_or(model.timestep);
    ws.begin(model, &state, input, dt)?;
    Ok((ws, state))
}

/// The problem of all candidates, which touch, and of the limits within the tolerance.
fn finish(mut ws: Workspace, model: &Model, state: &State, input: &Input, tolerance: f64) -> RestProblem {
    ws.candidates.choose_all();
    ws.build_problem(model, state, input);
    ws.builder.add_limits(model, &ws.kinematics, state, &state.v, |_, gap| gap <= tolerance);
    touching(&ws, tolerance)
}

/// The problem of a workspace with the contacts that touch alone.
fn touching(ws: &Workspace, tolerance: f64) -> RestProblem {
    let whole = ws.problem();
    let touches: Vec<usize> = (0..whole.contact_count()).filter(|&i| whole.gap[i] <= tolerance).collect();
    let place = |contact: usize| touches.binary_search(&contact).ok();
    let mut problem = whole.clone();
    problem.clear_contacts();
    let polygon = |directions: &[[f64; 2]]| -> Result<FrictionPolygon, ProblemError> {
        FrictionPolygon::from_directions(directions.to_vec())
    };
    let mut deepest_overlap = 0.0_f64;
    for &i in &touches {
        let (columns, entries) = whole.jacobian.group(i);
        // The directions come from a polygon.
        let own = polygon(whole.directions_of(i)).unwrap_or_default();
        problem.push_contact(columns.iter().copied().zip(entries.iter().copied()), 0.0, whole.friction[i], &own);
        deepest_overlap = deepest_overlap.max(overlap(ws, i));
    }
    for k in 0..whole.bilateral_violation.len() {
        let (columns, entries) = whole.bilateral_jacobian.group(k);
        problem.push_bilateral(columns.iter().copied().zip(entries.iter().copied()), 0.0);
    }
    let groups = &whole.friction_groups;
    let mut sources = Vec::new();
    for j in 0..groups.len() {
        let bound = groups.bound[j].within(place);
        let Some(source) = ws.friction_source(j).and_then(|source| moved(source, place)) else { continue };
        let (columns, entries) = groups.jacobian.group(j);
        let own = polygon(groups.directions_of(j)).unwrap_or_default();
        problem.push_friction(columns.iter().copied().zip(entries.iter().copied()), groups.target[j], bound, &own);
        sources.push(source);
    }
    let contacts = touches.iter().filter_map(|&i| ws.contact_source(i)).collect();
    let frames = touches.iter().filter_map(|&i| ws.contact_frames().get(i).copied()).collect();
    RestProblem {
        problem,
        contacts,
        frames,
        groups: sources,
        deepest_overlap,
        constraint_error: ws.builder.constraint_error,
    }
}

/// How far contact `i` overlaps, m or rad: all of it, where the gap of a step's problem is what the step removes.
fn overlap(ws: &Workspace, i: usize) -> f64 {
    let of_point = || ws.contact_points().get(i).map_or(0.0, |point| ws.builder.counted_gap(point));
    (-ws.limit_distance(i).unwrap_or_else(of_point)).max(0.0)
}

/// A source whose contact has another index; nothing where the contact is gone.
fn moved(source: FrictionSource, place: impl Fn(usize) -> Option<usize>) -> Option<FrictionSource> {
    Some(match source {
        FrictionSource::Joint { .. } | FrictionSource::Servo { .. } => source,
        FrictionSource::Belt { contact } => FrictionSource::Belt { contact: place(contact)? },
        FrictionSource::Spinning { contact } => FrictionSource::Spinning { contact: place(contact)? },
        FrictionSource::Rolling { contact } => FrictionSource::Rolling { contact: place(contact)? },
    })
}
