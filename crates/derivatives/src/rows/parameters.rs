//! How the rows and the impulses of a mode change with numbers of the model.

use std::cmp::Ordering;

use signorini_contact::ContactFrame;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Geom, GeomId, JointId, Model, PathPart};
use signorini_simulation::FrictionSource;

use super::frames::{groups_of, turned_axes};
use super::gaps::GapLaw;
use super::patch::Patch;
use super::system::{ModeRows, Modes, Mover, Push, Step};
use crate::geometry::{PointMotion, size_motion};
use crate::matrix::add_scaled;
use crate::parameter::{Direction, ScalarParameter, share};

/// How the numbers of a contact change along a direction.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    gap: f64,
    place: DVec3,
    normal: DVec3,
    friction: f64,
    /// Against spinning and rolling.
    spin: [f64; 2],
    restitution: f64,
    timestep: f64,
}

/// A contact with what its derivatives by degrees of freedom were made from.
pub(super) struct At<'a> {
    pub i: usize,
    pub point: &'a ContactPoint,
    /// The same midway between its surfaces, and the patch whose height it has.
    pub midway: &'a ContactPoint,
    pub patch: &'a Patch,
    pub frame: &'a ContactFrame,
    pub motion: &'a PointMotion,
    pub push: &'a Push,
    /// Degrees of freedom, with the rotation and the displacement of the material point that each gives.
    pub movers: &'a [(Mover, DVec3, DVec3)],
    pub gap: GapLaw,
    pub first_row: usize,
}

/// Adds the columns of one contact.
pub(super) fn add_contact(step: &Step, modes: &Modes, at: &At, directions: &[Direction], rows: &mut ModeRows) {
    for (j, direction) in directions.iter().enumerate() {
        match change_of(step, at, direction) {
            Ok(change) => add_change(step, modes, at, j, &change, rows),
            Err(reason) => rows.without_slope[j] = Some(reason),
        }
    }
}

fn change_of(step: &Step, at: &At, direction: &Direction) -> Result<Change, String> {
    let (model, a, b) = (step.model, at.point.geom_a, at.point.geom_b);
    let mut change = Change { timestep: share(direction, |p| p == ScalarParameter::Timestep), ..Change::default() };
    let pair = model.pairs.iter().position(|p| (p.geom_a, p.geom_b) == (a, b) || (p.geom_a, p.geom_b) == (b, a));
    // Where nothing presses, friction has no bound to move.
    if step.solution.lambda_n[at.i] > 0.0 {
        [change.friction, change.spin[0], change.spin[1]] = friction_changes(model, [a, b], pair, direction)?;
    }
    if pair.is_none_or(|pair| model.pairs[pair].restitution.is_none()) {
        let own = [a, b].map(|id| share(direction, |p| p == ScalarParameter::Restitution(id)));
        let values = [a, b].map(|id| model.geoms[id.index()].restitution);
        change.restitution = off_zero("restitution", "impacts", larger("restitution", values, own)?)?;
    }
    let own = geometry_change(step, (at.midway, at.motion), direction)?;
    let middle = at.patch.middle_moved(|point, motion| {
        let other = geometry_change(step, (point, motion), direction)?;
        Ok::<_, String>((other.gap, other.place))
    })?;
    (change.gap, change.normal) = (own.gap, own.normal);
    change.place = at.patch.level(middle, at.midway, own.normal, own.place);
    Ok(change)
}

/// How the gap, the normal and the place of a point midway between its surfaces change.
fn geometry_change(
    step: &Step,
    (point, motion): (&ContactPoint, &PointMotion),
    direction: &Direction,
) -> Result<Change, String> {
    let (model, a, b) = (step.model, point.geom_a, point.geom_b);
    let mut change = Change::default();
    let pair = model.pairs.iter().find(|p| (p.geom_a, p.geom_b) == (a, b) || (p.geom_a, p.geom_b) == (b, a));
    if pair.is_none_or(|pair| pair.margin.is_none()) {
        change.gap -= share(direction, |p| matches!(p, ScalarParameter::Margin(id) if id == a || id == b));
    }
    for (side, id) in [a, b].into_iter().enumerate() {
        add_geometry(step, (point, motion), (side, id), direction, &mut change)?;
    }
    Ok(change)
}

/// A number of which a contact has one, and its change.
type Counted = [f64; 2];

/// The larger of two numbers and its change, which has none where they are equal and change apart.
fn larger(name: &str, values: [f64; 2], changes: [f64; 2]) -> Result<Counted, String> {
    if values[0] == values[1] && changes[0] != changes[1] {
        return Err(format!("two geoms have the same {name}, of which the larger counts: change both together"));
    }
    Ok(if values[0] > values[1] { [values[0], changes[0]] } else { [values[1], changes[1]] })
}

/// The change of a number that cannot be negative, and with which a law begins that is not there at 0.
fn off_zero(name: &str, laws_of: &str, [value, change]: Counted) -> Result<f64, String> {
    if value == 0.0 && change != 0.0 {
        return Err(format!("a {name} of 0 is the border of what {laws_of} do"));
    }
    Ok(change)
}

/// Changes of the coefficients of a contact: against sliding, spinning, and rolling.
fn friction_changes(
    model: &Model,
    geoms: [GeomId; 2],
    pair: Option<usize>,
    direction: &Direction,
) -> Result<[f64; 3], String> {
    let contacts = |name: &str, counted: Counted| off_zero(name, "contacts", counted);
    if let Some(pair) = pair {
        let change = share(direction, |p| p == ScalarParameter::PairFriction(pair));
        return Ok([contacts("friction", [model.pairs[pair].friction, change])?, 0.0, 0.0]);
    }
    let of = |name: &str, value: fn(&Geom) -> f64, parameter: fn(GeomId) -> ScalarParameter| {
        contacts(name, counted_friction(model, geoms, direction, name, value, parameter)?)
    };
    Ok([
        of("friction", |geom| geom.friction, ScalarParameter::Friction)?,
        of("friction against spinning", |geom| geom.spinning_friction, ScalarParameter::SpinningFriction)?,
        of("friction against rolling", |geom| geom.rolling_friction, ScalarParameter::RollingFriction)?,
    ])
}

fn counted_friction(
    model: &Model,
    geoms: [GeomId; 2],
    direction: &Direction,
    name: &str,
    value: fn(&Geom) -> f64,
    parameter: fn(GeomId) -> ScalarParameter,
) -> Result<Counted, String> {
    let changes = geoms.map(|id| share(direction, |p| p == parameter(id)));
    let geoms = geoms.map(|id| &model.geoms[id.index()]);
    let values = geoms.map(value);
    match geoms[0].priority.cmp(&geoms[1].priority) {
        Ordering::Greater => Ok([values[0], changes[0]]),
        Ordering::Less => Ok([values[1], changes[1]]),
        Ordering::Equal => larger(name, values, changes),
    }
}

/// What moving and growing a geom does.
fn add_geometry(
    step: &Step,
    (point, motion): (&ContactPoint, &PointMotion),
    (side, id): (usize, GeomId),
    direction: &Direction,
    change: &mut Change,
) -> Result<(), String> {
    let kinematics = step.workspace.kinematics();
    let turn = kinematics.rotation[step.model.geoms[id.index()].body.index()];
    let mut shift = DVec3::ZERO;
    for &(parameter, weight) in direction {
        match parameter {
            ScalarParameter::GeomPosition(geom, axis) if geom == id => {
                shift += turn * DVec3::AXES[axis.min(2)] * weight
            }
            ScalarParameter::GeomSize(geom, k) if geom == id => {
                let Some(size) = size_motion(step.model, kinematics, point, side, k) else {
                    return Err(format!(
                        "sizes of a {} have no closed form here",
                        step.model.geoms[id.index()].geometry.kind_name()
                    ));
                };
                shift += size.core * weight;
                let grown = size.outward * weight;
                change.gap -= grown;
                change.place += point.normal * (if side == 0 { 0.5 } else { -0.5 } * grown);
            }
            _ => {}
        }
    }
    if shift == DVec3::ZERO {
        return Ok(());
    }
    if motion.is_loose {
        return Err("faces lie on each other, and which of their points touch is about to change".into());
    }
    // The motion of B relative to A; that of A carries all with it.
    let relative = if side == 1 { shift } else { -shift };
    let sum = |columns: &[DVec3; 6]| (0..3).map(|a| columns[3 + a] * relative[a]).sum::<DVec3>();
    change.gap += (0..3).map(|a| motion.gap[3 + a] * relative[a]).sum::<f64>();
    change.normal += sum(&motion.normal);
    change.place += sum(&motion.position);
    if side == 0 {
        change.place += shift;
    }
    Ok(())
}

fn add_change(step: &Step, modes: &Modes, at: &At, j: usize, change: &Change, rows: &mut ModeRows) {
    let (i, frame, point) = (at.i, at.frame, at.point);
    let mode = &modes.contacts[i];
    let axes = turned_axes(frame, change.normal);
    let (lambda, impulse) = (step.solution.impulse[i][0], step.solution.impulse[i]);
    let tangential = |[x, y]: [f64; 2]| frame.tangent_1 * x + frame.tangent_2 * y;
    let mut force: DVec3 = (0..3).map(|r| axes[r] * impulse[r]).sum();
    force += tangential(mode.sliding) * (change.friction * lambda);
    let mut moment = change.place.cross(at.push.force);
    for (k, source) in groups_of(step, i) {
        let ([x, y], sliding) = (step.solution.group_impulse[k], modes.groups[k].sliding);
        match source {
            FrictionSource::Spinning { .. } => {
                moment += axes[0] * x + frame.normal * (sliding[0] * change.spin[0] * lambda);
            }
            _ => moment += axes[1] * x + axes[2] * y + tangential(sliding) * (change.spin[1] * lambda),
        }
    }
    let balance = rows.balance_by_parameter.row_mut(j);
    for (mover, turn, shift) in at.movers {
        let sign = f64::from(mover.of[1]) - f64::from(mover.of[0]);
        balance[mover.dof] -= sign * (turn.dot(moment) + shift.dot(force));
    }
    let p = point.position;
    let relative = |motion: &signorini_multibody::derivatives::MotionDerivatives| {
        motion.velocity(point.body_b, p) - motion.velocity(point.body_a, p)
    };
    let directions = [frame.normal, frame.tangent_1, frame.tangent_2];
    let along = |velocity: DVec3, change: DVec3| -> [f64; 3] {
        std::array::from_fn(|r| axes[r].dot(velocity) + directions[r].dot(change))
    };
    let (end, begin) = (relative(step.end), relative(step.begin));
    let slip = along(end.linear, end.angular.cross(change.place));
    let spin = along(end.angular, DVec3::ZERO);
    let problem = step.workspace.problem();
    let dt = problem.timestep;
    let gap = match at.gap {
        GapLaw::Part(part) => (part * change.gap - problem.gap[i] / dt * change.timestep) / dt,
        GapLaw::Rebound(e) => {
            let approach = begin.linear.dot(frame.normal);
            e * along(begin.linear, begin.angular.cross(change.place))[0] + change.restitution * approach
        }
    };
    let mut row = at.first_row;
    for r in 0..mode.count {
        let held = mode.held[r];
        rows.by_parameter.row_mut(row)[j] += (0..3).map(|a| held[a] * slip[a]).sum::<f64>() + held[0] * gap;
        row += 1;
    }
    for (k, source) in groups_of(step, i) {
        let first = if matches!(source, FrictionSource::Spinning { .. }) { 0 } else { 1 };
        for r in 0..modes.groups[k].count {
            let held = modes.groups[k].held[r];
            let second = if first == 0 { 0.0 } else { spin[2] };
            rows.by_parameter.row_mut(row)[j] += held[1] * spin[first] + held[2] * second;
            row += 1;
        }
    }
}

/// Adds the columns of what is no contact point: the gaps of limits and constraints move with Δt, and so do the bounds of dry friction.
pub(super) fn add_coordinates(step: &Step, modes: &Modes, directions: &[Direction], rows: &mut ModeRows) {
    let problem = step.workspace.problem();
    let groups = &problem.friction_groups;
    let dt = problem.timestep;
    for (j, direction) in directions.iter().enumerate() {
        if moves_a_path(step.model, direction) {
            rows.without_slope[j] = Some("a tendon runs around the geom".to_owned());
        }
        if let Err(reason) = dry_friction_begins(step.model, direction) {
            rows.without_slope[j] = Some(reason);
        }
        let timestep = share(direction, |p| p == ScalarParameter::Timestep);
        for k in 0..groups.len() {
            let source = step.workspace.friction_source(k);
            let grown = match source {
                Some(FrictionSource::Joint { joint, .. }) => {
                    let id = JointId(joint as u32);
                    let loss = share(direction, |p| p == ScalarParameter::FrictionLoss(id));
                    timestep / dt + loss / step.model.joints[joint].friction_loss
                }
                Some(FrictionSource::Servo { .. }) => timestep / dt,
                _ => continue,
            };
            if modes.groups[k].count > 0 || grown == 0.0 {
                continue;
            }
            let (columns, entries) = groups.jacobian.group(k);
            for (&column, entry) in columns.iter().zip(entries) {
                let impulse =
                    entry[0] * step.solution.group_impulse[k][0] + entry[1] * step.solution.group_impulse[k][1];
                rows.balance_by_parameter.row_mut(j)[column as usize] -= grown * impulse;
            }
        }
    }
}

/// A joint without dry friction has no friction group, so that no row of the step would feel how it begins.
fn dry_friction_begins(model: &Model, direction: &Direction) -> Result<(), String> {
    direction.iter().try_for_each(|&(parameter, share)| match parameter {
        ScalarParameter::FrictionLoss(id) => {
            let loss = model.joints.get(id.index()).map_or(0.0, |joint| joint.friction_loss);
            off_zero("dry friction", "joints", [loss, share]).map(|_| ())
        }
        _ => Ok(()),
    })
}

/// Whether a direction moves or grows a geom that a tendon runs around.
fn moves_a_path(model: &Model, direction: &Direction) -> bool {
    let runs_around = |own: GeomId| {
        let is_own = |part: &PathPart| matches!(part, PathPart::Wrap { geom, .. } if *geom == own);
        model.tendons.iter().any(|tendon| tendon.path.iter().any(is_own))
    };
    direction.iter().any(|(parameter, _)| match *parameter {
        ScalarParameter::GeomPosition(geom, _) | ScalarParameter::GeomSize(geom, _) => runs_around(geom),
        _ => false,
    })
}

/// Adds how the violation over Δt of rows `range` changes along each direction.
pub(super) fn add_violation(row: usize, violation: f64, dt: f64, directions: &[Direction], rows: &mut ModeRows) {
    for (j, direction) in directions.iter().enumerate() {
        let timestep = share(direction, |p| p == ScalarParameter::Timestep);
        add_scaled(&mut rows.by_parameter.row_mut(row)[j..=j], -violation / (dt * dt), &[timestep]);
    }
}
