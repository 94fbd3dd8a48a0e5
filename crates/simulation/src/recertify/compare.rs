//! What a frame says beside its solution, compared with what follows from model, state and solution.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Model, State};
use signorini_recording::{Frame, RecordedContact};

use super::fault::StepFault;
use crate::recorder::{energy, pose_array};
use crate::source::ContactSource;
use crate::workspace::Workspace;

/// Largest difference that is rounding: absolute below 1, relative above.
const ROUNDING: f64 = 1e-9;

/// Whether two numbers are the same to rounding; none is near NaN.
pub(super) fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * (1.0 + b.abs())
}

/// Whether a recorded contact is at this point, or where the height of its patch would bring it along its normal.
pub(super) fn is_same_point(recorded: &RecordedContact, point: &ContactPoint) -> bool {
    let apart = DVec3::from(recorded.point) - point.position;
    let across = point.position + apart - point.normal * point.normal.dot(apart);
    [recorded.geom_a, recorded.geom_b] == [point.geom_a.0, point.geom_b.0]
        && near(recorded.gap, point.gap)
        && across.to_array().iter().zip(point.position.to_array()).all(|(a, b)| near(*a, b))
}

/// The largest difference; infinite where something is no number.
fn largest_difference(found: &[f64], expected: &[f64]) -> f64 {
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |largest, d| if d.is_nan() { f64::INFINITY } else { d.max(largest) })
}

/// The largest difference of numbers of which one pair is not near each other; none where all are.
fn difference<const N: usize>(found: [f64; N], expected: [f64; N]) -> Option<f64> {
    let far = found.iter().zip(&expected).any(|(a, b)| !near(*a, *b));
    far.then(|| largest_difference(&found, &expected))
}

/// Compares everything; the first thing that differs.
pub(super) fn compare(model: &Model, ws: &Workspace, state: &State, frame: &Frame) -> Result<(), StepFault> {
    compare_contacts(ws, frame)?;
    compare_limits(ws, frame)?;
    compare_impulses(ws, frame)?;
    for (body, (recorded, pose)) in frame.body_poses.iter().zip(&ws.kinematics.pose).enumerate() {
        if let Some(difference) = difference(*recorded, pose_array(pose)) {
            return Err(StepFault::Pose { body, difference });
        }
    }
    let expected = energy(model, &ws.kinematics, state);
    let recorded = [frame.energy.kinetic, frame.energy.potential];
    match difference(recorded, [expected.kinetic, expected.potential]) {
        Some(difference) => Err(StepFault::Energy { difference }),
        None => Ok(()),
    }
}

fn compare_contacts(ws: &Workspace, frame: &Frame) -> Result<(), StepFault> {
    let found = ws.points.iter().zip(&ws.builder.frames);
    for (contact, (c, (point, axes))) in frame.contacts.iter().zip(found).enumerate() {
        let ids = [c.body_a, c.body_b].map(f64::from);
        let expected = [point.body_a.0, point.body_b.0].map(f64::from);
        let [_, slip_1, slip_2] = ws.builder.problem.contact_velocity(contact, ws.end_velocity());
        for (what, difference) in [
            ("its pair of bodies", difference(ids, expected)),
            ("its place", difference(c.point, point.position.to_array())),
            ("its normal", difference(c.normal, axes.normal.to_array())),
            ("its first tangent", difference(c.tangent_1, axes.tangent_1.to_array())),
            ("its second tangent", difference(c.tangent_2, axes.tangent_2.to_array())),
            ("its coefficient of friction", difference([c.friction], [point.friction])),
            ("its sliding velocity", difference(c.velocity_t, [slip_1, slip_2])),
        ] {
            if let Some(difference) = difference {
                return Err(StepFault::Contact { contact, what, difference });
            }
        }
    }
    Ok(())
}

fn compare_limits(ws: &Workspace, frame: &Frame) -> Result<(), StepFault> {
    let first = frame.contacts.len();
    for (i, limit) in frame.solution.limits.iter().enumerate() {
        let contact = first + i;
        let same = match ws.contact_source(contact) {
            Some(ContactSource::Limit { joint, upper }) => {
                !limit.tendon && (joint.0, upper) == (limit.index, limit.upper)
            }
            Some(ContactSource::TendonLimit { tendon, upper }) => {
                limit.tendon && (tendon.0, upper) == (limit.index, limit.upper)
            }
            _ => false,
        };
        if !same {
            return Err(StepFault::Contact { contact, what: "the order of limits", difference: 1.0 });
        }
        if let Some(difference) = difference([limit.gap], [ws.builder.problem.gap[contact]]) {
            return Err(StepFault::Contact { contact, what: "the distance to its limit", difference });
        }
        let axis = ws.limit_axis(contact).map_or([0.0; 3], |axis| axis.to_array());
        if let Some(difference) = difference(limit.axis.unwrap_or(axis), axis) {
            return Err(StepFault::Contact { contact, what: "the axis of its limit", difference });
        }
    }
    let (recorded, found) = (first + frame.solution.limits.len(), ws.builder.problem.contact_count());
    if recorded == found { Ok(()) } else { Err(StepFault::Contacts { recorded, found }) }
}

/// An impulse has the digits of the largest one, or of the momentum that the step's velocities are told from: what gives the problem's velocity scale
/// to what moves most easily.
fn compare_impulses(ws: &Workspace, frame: &Frame) -> Result<(), StepFault> {
    let problem = &ws.builder.problem;
    let contacts = frame.contacts.iter().map(|c| [c.lambda_n, c.lambda_t[0], c.lambda_t[1]]);
    let limits = frame.solution.limits.iter().map(|limit| [limit.impulse, 0.0, 0.0]);
    let expected: Vec<[f64; 3]> = (0..problem.contact_count()).map(|i| ws.contact_impulse(i)).collect();
    let inverse_mass = problem.delassus_scale();
    let momentum = if inverse_mass > 0.0 { problem.velocity_scale() / inverse_mass } else { 0.0 };
    let largest = expected.iter().flatten().fold(momentum, |largest: f64, x| largest.max(x.abs()));
    for (contact, (recorded, expected)) in contacts.chain(limits).zip(expected).enumerate() {
        let difference = largest_difference(&recorded, &expected);
        if difference > ROUNDING * largest {
            return Err(StepFault::Impulse { contact, difference });
        }
    }
    Ok(())
}
