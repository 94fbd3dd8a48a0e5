//! Rows along coordinates: limits of joints and tendons, dry friction, servos of speed.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{JointKind, Transmission, right_jacobian, rotation_log};
use signorini_simulation::{ContactSource, FrictionSource};

use super::parameters::add_violation;
use super::scratch::Scratch;
use super::system::{ModeRows, Modes, Step};
use super::tendons::add_turning;
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Below this angle a ball joint has no axis, rad.
const NO_AXIS: f64 = 1e-6;

pub(super) fn add_limits(
    step: &Step,
    modes: &Modes,
    margins: &mut Vec<Margin>,
    rows: &mut ModeRows,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let problem = step.workspace.problem();
    let solution = step.solution;
    let dt = problem.timestep;
    for i in step.workspace.contact_points().len()..problem.contact_count() {
        if modes.contacts[i].count == 0 {
            continue;
        }
        let found = problem.gap[i];
        let (true_gap, speed) = limit(step, i)?;
        let part = if true_gap >= 0.0 { 1.0 } else { step.settings.stabilization };
        if true_gap < 0.0 || part != 1.0 {
            let room = if speed.is_finite() { (speed + part * true_gap / dt).abs() } else { f64::INFINITY };
            let side = if step.settings.stabilization == 1.0 { f64::INFINITY } else { true_gap.abs() / dt };
            let value = step.scales.velocity(room.min(side));
            let source = InequalitySource::Contact(i);
            margins.push(Margin { source, kind: InequalityKind::Threshold, value });
        }
        if (found - part * true_gap).abs() > 1e-12 * (1.0 + true_gap.abs()) {
            return Err(format!("{}: it is restored at a bounded speed", limit_name(step, i)));
        }
        let lambda = solution.lambda_n[i];
        let (columns, entries) = problem.jacobian.group(i);
        let row = rows.push(InequalitySource::Contact(i));
        for (&column, entry) in columns.iter().zip(entries) {
            let k = column as usize;
            (row.held[k], row.impulse[k]) = (entry[0], entry[0]);
            row.by_configuration[k] = part * entry[0] / dt;
        }
        let by_configuration = row.by_configuration;
        if let Some(ContactSource::Limit { joint, .. }) = step.workspace.contact_source(i)
            && step.model.joints[joint.index()].kind == JointKind::Ball
        {
            let k = step.model.joints[joint.index()].v_index;
            let axis_slope = cone_axis_slope(step, joint.index())
                .ok_or_else(|| format!("{}: it has no axis", limit_name(step, i)))?;
            let rate = DVec3::from_slice(&solution.velocity[k..]);
            for a in 0..3 {
                by_configuration[k + a] -= axis_slope.col(a).dot(rate);
                (0..3).for_each(|r| turning[(k + r) * step.model.nv + k + a] -= lambda * axis_slope.col(a)[r]);
            }
        }
        if let Some(ContactSource::TendonLimit { tendon, upper }) = step.workspace.contact_source(i) {
            let pull = (tendon, if upper { -1.0 } else { 1.0 }, InequalitySource::Contact(i));
            add_turning(step, pull, lambda, margins, (by_configuration, turning), scratch)
                .map_err(|reason| format!("{}: {reason}", limit_name(step, i)))?;
        }
        for (&column, entry) in columns.iter().zip(entries) {
            rows.coordinate_impulse[column as usize] += lambda * entry[0];
        }
        add_violation(rows.len() - 1, found, dt, step.directions, rows);
    }
    Ok(())
}

/// Distance to a limit, and the speed at which it is restored.
fn limit(step: &Step, i: usize) -> Result<(f64, f64), String> {
    let (model, q) = (step.model, &step.state.q);
    let missing = || format!("{}: there is none", limit_name(step, i));
    match step.workspace.contact_source(i) {
        Some(ContactSource::Limit { joint, upper }) => {
            let joint = &model.joints[joint.index()];
            let [low, high] = joint.limits.ok_or_else(missing)?;
            let slides = matches!(joint.kind, JointKind::Slide { .. });
            let speed = if slides { step.settings.correction_speed } else { step.settings.correction_angular_speed };
            let gap = match joint.kind {
                JointKind::Ball => {
                    let turn = turn_of(step, joint.q_index);
                    let along = step.workspace.limit_axis(i).map_or(0.0, |axis| axis.dot(turn));
                    if turn.length() - along > 1e-9 * turn.length() {
                        return Err(format!("{}: its axis is that of where the step led", limit_name(step, i)));
                    }
                    high - turn.length()
                }
                _ if upper => high - q[joint.q_index],
                _ => q[joint.q_index] - low,
            };
            Ok((gap, speed))
        }
        Some(ContactSource::TendonLimit { tendon, upper }) => {
            let tendon = &model.tendons[tendon.index()];
            let [low, high] = tendon.limits.ok_or_else(missing)?;
            let length = tendon.length(model, step.workspace.kinematics(), q);
            Ok((if upper { high - length } else { length - low }, step.settings.correction_speed))
        }
        _ => Err(limit_name(step, i)),
    }
}

/// What a limit is called where something is wrong with it.
fn limit_name(step: &Step, i: usize) -> String {
    match step.workspace.contact_source(i) {
        Some(ContactSource::Limit { joint, .. }) => {
            format!("limit of joint '{}'", step.model.joints[joint.index()].name)
        }
        Some(ContactSource::TendonLimit { tendon, .. }) => {
            format!("limit of tendon '{}'", step.model.tendons[tendon.index()].name)
        }
        _ => format!("contact {i} is no limit"),
    }
}

fn turn_of(step: &Step, at: usize) -> DVec3 {
    let q = &step.state.q[at..];
    rotation_log(DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize())
}

/// How the axis of a ball joint's rotation changes with the rotation.
fn cone_axis_slope(step: &Step, joint: usize) -> Option<DMat3> {
    let turn = turn_of(step, step.model.joints[joint].q_index);
    let angle = turn.length();
    if angle <= 2.0 * NO_AXIS {
        return None;
    }
    let axis = turn / angle;
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    Some((DMat3::IDENTITY - along) * right_jacobian(turn).inverse() * (1.0 / angle))
}

/// Dry friction in joints and servos of speed; rows of servos along tendons with a path turn.
pub(super) fn add_groups(
    step: &Step,
    modes: &Modes,
    margins: &mut Vec<Margin>,
    rows: &mut ModeRows,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let problem = step.workspace.problem();
    let (groups, solution) = (&problem.friction_groups, step.solution);
    for j in 0..groups.len() {
        let servo = match step.workspace.friction_source(j) {
            Some(FrictionSource::Joint { .. }) => None,
            Some(FrictionSource::Servo { actuator }) => Some(actuator),
            _ => continue,
        };
        let drive = servo.map(|a| servo_drive(step, a)).transpose()?;
        let lambda = solution.group_impulse[j][0];
        // Also of a servo that has no row, as where its force is used up.
        let mut slopes = std::mem::take(&mut scratch.slopes);
        slopes.clear();
        slopes.resize(step.model.nv, 0.0);
        if let Some(actuator) = servo.map(|a| &step.model.actuators[a])
            && let Transmission::Tendon(tendon) = actuator.transmission
        {
            let pull = (tendon, actuator.gear, InequalitySource::FrictionGroup(j));
            add_turning(step, pull, lambda, margins, (&mut slopes, turning), scratch)
                .map_err(|reason| format!("actuator '{}': {reason}", actuator.name))?;
        }
        let (columns, entries) = groups.jacobian.group(j);
        for r in 0..modes.groups[j].count {
            let row = rows.push(InequalitySource::FrictionGroup(j));
            for (&column, entry) in columns.iter().zip(entries) {
                (row.held[column as usize], row.impulse[column as usize]) = (entry[0], entry[0]);
            }
            row.by_configuration.copy_from_slice(&slopes);
            debug_assert_eq!((r, modes.groups[j].held[r]), (0, [0.0, 1.0, 0.0]));
            if let (Some(a), Some(slope)) = (servo, drive) {
                row.by_control[a] = -slope;
            }
        }
        for (&column, entry) in columns.iter().zip(entries) {
            rows.coordinate_impulse[column as usize] += lambda * entry[0];
        }
        scratch.slopes = slopes;
    }
    Ok(())
}

/// How the speed of a servo changes with its control.
fn servo_drive(step: &Step, a: usize) -> Result<f64, String> {
    let actuator = &step.model.actuators[a];
    if matches!(actuator.transmission, Transmission::Site { .. }) {
        return Err(format!("actuator '{}': its row turns with a site", actuator.name));
    }
    if actuator.activation.is_some() {
        return Err(format!("actuator '{}': a servo of speed with an activation", actuator.name));
    }
    let given = *step.input.control.get(a).unwrap_or(&0.0);
    Ok(actuator.control_range.map_or(1.0, |[lower, upper]| f64::from(lower < given && given < upper)))
}
