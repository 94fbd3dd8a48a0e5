//! Rows of contact points: sliding, sticking, spinning and rolling of two bodies at a place that moves with both.

use signorini_contact::ContactFrame;
use signorini_multibody::derivatives::MotionDerivatives;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, SpatialVector};
use signorini_simulation::FrictionSource;

use super::frames::{groups_of, turned_axes};
use super::gaps::{GapLaw, gap_law};
use super::parameters::{At, add_contact};
use super::patch::{Patch, moved_by};
use super::scratch::Scratch;
use super::system::{ModeRows, Modes, Moved, Mover, Push, Step, TieRows, movers};
use crate::geometry::{NoMotion, PointMotion};
use crate::mode::UnitMode;
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Entries of the step's rows and of those made here may differ by this, relative to the levers.
const AGREEMENT: f64 = 1e-9;

/// Faces on each other may slide by this part of the velocity scale while their points are about to change.
const UNFELT: f64 = 1e-9;

pub(super) fn add_points(
    step: &mut Step,
    modes: &Modes,
    margins: &mut Vec<Margin>,
    (rows, ties): (&mut ModeRows, &mut TieRows),
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let mut points = std::mem::take(&mut scratch.points);
    points.clear();
    points.extend_from_slice(step.workspace.contact_points());
    scratch.turned.forget();
    scratch.patch.forget();
    let result = add_all(step, &points, modes, margins, (rows, ties), turning, scratch);
    scratch.points = points;
    result
}

fn add_all(
    step: &mut Step,
    points: &[ContactPoint],
    modes: &Modes,
    margins: &mut Vec<Margin>,
    (rows, ties): (&mut ModeRows, &mut TieRows),
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    for (i, point) in points.iter().enumerate() {
        let gap = gap_law(step, i, point, margins);
        let (is_open, is_tie) = (modes.contacts[i].count == 0, modes.ties.contains(&i));
        if is_open && !is_tie {
            continue;
        }
        let gap = match gap {
            Ok(gap) => gap,
            // It does nothing yet; what it would do along a change is not known.
            Err(_) if is_open => continue,
            Err(reason) => return Err(about(step, point, reason)),
        };
        match add_point(step, modes, (i, points, gap), scratch, margins, rows, turning) {
            Err(_) if is_open => continue,
            other => other?,
        }
        if is_tie && groups_of(step, i).next().is_none() {
            ties.contacts.push(i);
            add_unit(step, &UnitMode::WHOLE, i, gap, &scratch.list, &scratch.moved, &mut ties.rows);
        }
    }
    scratch.turned.flush(step, turning);
    Ok(())
}

/// Adds the rows of a contact point and what its impulse does.
fn add_point(
    step: &mut Step,
    modes: &Modes,
    (i, points, gap): (usize, &[ContactPoint], GapLaw),
    scratch: &mut Scratch,
    margins: &mut Vec<Margin>,
    rows: &mut ModeRows,
    turning: &mut [f64],
) -> Result<(), String> {
    let point = &points[i];
    if [point.geom_a, point.geom_b].iter().any(|id| step.model.geoms[id.index()].grain.is_some()) {
        return Err(about(step, point, "its friction depends on the direction"));
    }
    let Scratch { list, moved, displaced, turned, search, patch, .. } = scratch;
    movers(step.model, [point.body_a, point.body_b], list);
    let (found, motion) = patch.find(step, (i, points), list, search).map_err(|why| match why {
        NoMotion::Changes => about(step, point, "its features change within the smallest differences"),
        NoMotion::Rough => about(step, point, "the search for it is not smooth to the digits of differences"),
    })?;
    if motion.is_tie {
        let source = InequalitySource::Contact(i);
        margins.push(Margin { source, kind: InequalityKind::Feature, value: 0.0 });
    }
    let frame = step.workspace.contact_frames()[i];
    measure(step, (point, &found, patch), &frame, (&motion, gap), list, moved);
    check_rows(step, i, &frame, list, moved).map_err(|reason| about(step, point, reason))?;
    let push = push_of(step, i, point, &frame)?;
    push.act(step, point.body_b, 1.0, &mut rows.wrenches);
    push.act(step, point.body_a, -1.0, &mut rows.wrenches);
    turned.add(step, (i, point), &push, (list, moved), turning);
    let first_row = rows.len();
    add_unit(step, &modes.contacts[i], i, gap, list, moved, rows);
    add_group_pulls(step, modes, i, first_row, rows);
    if motion.is_loose && modes.contacts[i].count > 0 {
        let lifts = |turn: DVec3| patch.level(DVec3::ZERO, &found, turn, DVec3::ZERO);
        note_loose(step, (i, gap), (point, &frame), (&push, &lifts), list, moved, rows)?;
    }
    add_spin_groups(step, modes, i, list, moved, rows);
    if !step.directions.is_empty() && modes.contacts[i].count > 0 {
        displaced.clear();
        displaced.extend(list.iter().zip(moved.iter()).map(|(mover, m)| (*mover, m.turn, m.shift)));
        let (frame, motion, push) = (&frame, &motion, &push);
        let at = At { i, point, midway: &found, patch, frame, motion, push, movers: displaced, gap, first_row };
        add_contact(step, modes, &at, step.directions, rows);
    }
    Ok(())
}

fn about(step: &Step, point: &ContactPoint, reason: &str) -> String {
    let name = |id: signorini_multibody::GeomId| {
        let geom = &step.model.geoms[id.index()];
        format!("{} '{}'", geom.geometry.kind_name(), geom.name)
    };
    format!("contact of {} and {}: {reason}", name(point.geom_a), name(point.geom_b))
}

/// Fills `moved` for every degree of freedom of the list.
///
/// - `found`: the point midway between its surfaces
fn measure(
    step: &Step,
    (point, found, patch): (&ContactPoint, &ContactPoint, &Patch),
    frame: &ContactFrame,
    (motion, gap): (&PointMotion, GapLaw),
    list: &[Mover],
    moved: &mut Vec<Moved>,
) {
    moved.clear();
    let p = point.position;
    let relative = |motion: &MotionDerivatives| motion.velocity(point.body_b, p) - motion.velocity(point.body_a, p);
    let at_end = relative(step.end);
    let at_begin = if let GapLaw::Rebound(_) = gap { Some(relative(step.begin)) } else { None };
    let directions = [frame.normal, frame.tangent_1, frame.tangent_2];
    for (k, mover) in list.iter().enumerate() {
        let own = step.end.displacement(mover.dof, p);
        let (gap, normal, place) = moved_by(step, found, motion, mover);
        let place = patch.level_by(k, found, normal, place);
        let axes = if normal == DVec3::ZERO { [DVec3::ZERO; 3] } else { turned_axes(frame, normal) };
        let slope = |motion: &MotionDerivatives| {
            let of = |body, moves| {
                if moves { motion.velocity_slope(body, mover.dof, p) } else { SpatialVector::ZERO }
            };
            of(point.body_b, mover.of[1]) - of(point.body_a, mover.of[0])
        };
        let along = |velocity: DVec3, change: DVec3| -> [f64; 3] {
            std::array::from_fn(|r| axes[r].dot(velocity) + directions[r].dot(change))
        };
        let end_slope = slope(step.end);
        let approach = at_begin.map_or(0.0, |at_begin| {
            let change = slope(step.begin).linear + at_begin.angular.cross(place);
            axes[0].dot(at_begin.linear) + frame.normal.dot(change)
        });
        moved.push(Moved {
            turn: own.angular,
            shift: own.linear,
            gap,
            place,
            axes,
            slip: along(at_end.linear, end_slope.linear + at_end.angular.cross(place)),
            spin: along(at_end.angular, end_slope.angular),
            approach,
        });
    }
}

/// Whether the rows of the step are those made here.
fn check_rows(
    step: &Step,
    i: usize,
    frame: &ContactFrame,
    list: &[Mover],
    moved: &[Moved],
) -> Result<(), &'static str> {
    let (columns, entries) = step.workspace.problem().jacobian.group(i);
    let size = moved.iter().fold(0.0, |s: f64, m| s.max(m.shift.length()));
    for (column, entry) in columns.iter().zip(entries) {
        let Some(at) = list.iter().position(|m| m.dof == *column as usize) else {
            return Err("its row has a column that does not move it");
        };
        let sign = f64::from(list[at].of[1]) - f64::from(list[at].of[0]);
        let expected = [frame.normal, frame.tangent_1, frame.tangent_2].map(|d| sign * d.dot(moved[at].shift));
        if (0..3).any(|r| entry[r] != 0.0 && (entry[r] - expected[r]).abs() > AGREEMENT * size) {
            return Err("its row is not that of its place");
        }
    }
    Ok(())
}

/// What the contact gives to body B.
fn push_of(step: &Step, i: usize, point: &ContactPoint, frame: &ContactFrame) -> Result<Push, String> {
    let solution = step.solution;
    let mut moment = DVec3::ZERO;
    for (j, source) in groups_of(step, i) {
        let [x, y] = solution.group_impulse[j];
        moment += match source {
            FrictionSource::Spinning { .. } => frame.normal * x,
            FrictionSource::Rolling { .. } => frame.tangent_1 * x + frame.tangent_2 * y,
            _ => return Err(about(step, point, "its surface moves")),
        };
    }
    Ok(Push { point: point.position, force: frame.to_world(solution.impulse[i]), moment })
}

/// Notes what a contact between faces that lie on each other would do to the momenta if its place slid or its normal turned: they may do so
/// where the velocity does not feel it.
///
/// - `lifts`: what a turn of the normal moves the place by, which stays at the height of its patch
fn note_loose(
    step: &Step,
    (i, gap): (usize, GapLaw),
    (point, frame): (&ContactPoint, &ContactFrame),
    (push, lifts): (&Push, &dyn Fn(DVec3) -> DVec3),
    list: &[Mover],
    moved: &[Moved],
    rows: &mut ModeRows,
) -> Result<(), String> {
    let p = point.position;
    let lever = moved.iter().map(|m| m.shift.length()).fold(0.0, f64::max);
    let felt = |motion: &MotionDerivatives, held: DVec3| {
        let relative = motion.velocity(point.body_b, p) - motion.velocity(point.body_a, p);
        (relative.linear - held * held.dot(relative.linear)).length().max(relative.angular.length() * lever)
    };
    let mut speed = felt(step.end, DVec3::ZERO);
    if let GapLaw::Rebound(_) = gap {
        // The approach at the place that slides; along the normal it stays the same to first order where that turns.
        speed = speed.max(felt(step.begin, point.normal));
    }
    if step.scales.velocity(speed) > UNFELT {
        return Err(about(step, point, "faces slide on each other, and the parts that touch are about to change"));
    }
    for t in [frame.tangent_1, frame.tangent_2] {
        let [n, t_1, t_2] = turned_axes(frame, t);
        let impulse = step.solution.impulse[i];
        let turned = n * impulse[0] + t_1 * impulse[1] + t_2 * impulse[2];
        for (moment, force) in [(t.cross(push.force), DVec3::ZERO), (lifts(t).cross(push.force), turned)] {
            let row = rows.unfelt.push();
            for (mover, m) in list.iter().zip(moved) {
                let sign = f64::from(mover.of[1]) - f64::from(mover.of[0]);
                row[mover.dof] = sign * (m.turn.dot(moment) + m.shift.dot(force));
            }
        }
    }
    Ok(())
}

/// The rows of the contact itself.
fn add_unit(step: &Step, mode: &UnitMode, i: usize, gap: GapLaw, list: &[Mover], moved: &[Moved], rows: &mut ModeRows) {
    let problem = step.workspace.problem();
    let (columns, entries) = problem.jacobian.group(i);
    for r in 0..mode.count {
        let (held, impulse) = (mode.held[r], mode.impulse[r]);
        let row = rows.push(InequalitySource::Contact(i));
        for (&column, entry) in columns.iter().zip(entries) {
            row.held[column as usize] = (0..3).map(|a| held[a] * entry[a]).sum();
            row.impulse[column as usize] = (0..3).map(|a| impulse[a] * entry[a]).sum();
        }
        for (mover, m) in list.iter().zip(moved) {
            row.by_configuration[mover.dof] = (0..3).map(|a| held[a] * m.slip[a]).sum::<f64>()
                + held[0]
                    * match gap {
                        GapLaw::Part(part) => part * m.gap / problem.timestep,
                        GapLaw::Rebound(e) => e * m.approach,
                    };
        }
        if let GapLaw::Rebound(e) = gap {
            for (&column, entry) in columns.iter().zip(entries) {
                row.by_velocity[column as usize] = held[0] * e * entry[0];
            }
        }
    }
}

/// Groups that slide pull with a part of the normal impulse, which belongs to the columns that have it.
fn add_group_pulls(step: &Step, modes: &Modes, i: usize, first_row: usize, rows: &mut ModeRows) {
    let groups = &step.workspace.problem().friction_groups;
    let mode = &modes.contacts[i];
    for r in (0..mode.count).filter(|&r| mode.impulse[r][0] != 0.0) {
        for (j, _) in groups_of(step, i) {
            let Some((_, coefficient)) = groups.bound[j].normal() else { continue };
            let (columns, entries) = groups.jacobian.group(j);
            let [x, y] = modes.groups[j].sliding;
            for (&column, entry) in columns.iter().zip(entries) {
                rows.impulse.row_mut(first_row + r)[column as usize] += coefficient * (x * entry[0] + y * entry[1]);
            }
        }
    }
}

/// The rows of spinning and rolling.
fn add_spin_groups(step: &Step, modes: &Modes, i: usize, list: &[Mover], moved: &[Moved], rows: &mut ModeRows) {
    let groups = &step.workspace.problem().friction_groups;
    for (j, source) in groups_of(step, i) {
        let mode = &modes.groups[j];
        let (columns, entries) = groups.jacobian.group(j);
        let first = if matches!(source, FrictionSource::Spinning { .. }) { 0 } else { 1 };
        for r in 0..mode.count {
            let (held, impulse) = (mode.held[r], mode.impulse[r]);
            let row = rows.push(InequalitySource::FrictionGroup(j));
            for (&column, entry) in columns.iter().zip(entries) {
                row.held[column as usize] = held[1] * entry[0] + held[2] * entry[1];
                row.impulse[column as usize] = impulse[1] * entry[0] + impulse[2] * entry[1];
            }
            for (mover, m) in list.iter().zip(moved) {
                let second = if first == 0 { 0.0 } else { m.spin[2] };
                row.by_configuration[mover.dof] = held[1] * m.spin[first] + held[2] * second;
            }
        }
    }
}
