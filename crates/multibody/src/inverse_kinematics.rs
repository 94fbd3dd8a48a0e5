//! Configurations at which frames are where they are wanted: damped least squares with joint limits. A tool, not part of a step.
//!
//! Levenberg's and Marquardt's method on the errors of all targets, projected onto the limits: joints at a limit that the error pushes
//! against are held, the others take the step `Jᵀ (J Jᵀ + λ)⁻¹ e`, and what would leave a limit stops there. `λ` is in proportion to the
//! squared error, so that the end is as quick as Newton's method, and grows where a step does not help (Fan, Yuan 2005).

use derive_setters::Setters;
use glamx::glam::{DQuat, DVec3};

use crate::configuration::integrate_into;
use crate::frame::{Frame, ReferenceFrame, frame_jacobian_into};
use crate::kinematics::{Kinematics, forward_kinematics_into};
use crate::math::{Pose, read_quaternion, rotation_exp, rotation_log, write_quaternion};
use crate::model::{JointKind, Model};
use crate::small_dense::{factorise, solve};

/// Where a frame is wanted.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct FrameTarget {
    /// The frame.
    pub frame: Frame,
    /// Where its origin is wanted in world, m; anywhere without it.
    #[setters(into)]
    pub position: Option<DVec3>,
    /// How it is wanted turned in world; any way without it.
    #[setters(into)]
    pub rotation: Option<DQuat>,
}

impl FrameTarget {
    /// The origin of a frame at a point (world, m), however turned.
    pub fn at(frame: Frame, position: DVec3) -> Self {
        Self { frame, position: Some(position), rotation: None }
    }

    /// A frame at a pose in world.
    pub fn pose(frame: Frame, pose: Pose) -> Self {
        Self { frame, position: Some(pose.position), rotation: Some(pose.rotation) }
    }
}

/// How inverse kinematics is solved.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct InverseKinematicsSettings {
    /// Error of every target below which the answer counts, m and rad. Default: 1e-9.
    pub tolerance: f64,
    /// Evaluations of the errors, at most. Default: 200.
    pub max_iterations: usize,
    /// What an error of one radian is worth, m. Default: 1.
    pub radian: f64,
    /// Degrees of freedom that may move, `[nv]`; all where it is empty.
    pub movable: Vec<bool>,
}

impl Default for InverseKinematicsSettings {
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 200, radian: 1.0, movable: Vec::new() }
    }
}

/// How inverse kinematics ended.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InverseKinematicsReport {
    /// Whether every target is met within the tolerance. Where not, the configuration is the nearest one that was found: a target out of
    /// reach, or a local minimum, from which another start may lead.
    pub converged: bool,
    /// Largest distance of an origin from its target, m.
    pub position_error: f64,
    /// Largest angle of a frame from its target, rad.
    pub angle_error: f64,
    /// Evaluations of the errors.
    pub iterations: usize,
}

/// Damping where a start is far off, as a share of the squared error.
const FIRST_DAMPING: f64 = 1e-2;
/// Bounds of the damping's factor: below, rounding would be amplified; above, a step no longer moves anything.
const DAMPING: (f64, f64) = (1e-8, 1e12);
/// A step that does not help makes the damping grow by this factor, one that does makes it fall by it.
const PACE: f64 = 4.0;

/// Moves a configuration to where frames meet their targets, within the limits of hinges, slides and balls.
///
/// - `q`: `[nq]`, the start, and the configuration found; entries beyond a limit are brought to it first
/// - `kinematics`: storage; poses of bodies that are moved from outside are taken from it
///
/// # Panics
/// If a length does not fit the model, or a target's body is not of it.
///
/// # Source
/// Levenberg (1944), Marquardt (1963); damping by the error: Fan, Yuan (2005), On the quadratic convergence of the Levenberg–Marquardt
/// method without nonsingularity assumption, Computing 74; damped least squares in robotics: Nakamura, Hanafusa (1986).
pub fn inverse_kinematics_into(
    model: &Model,
    targets: &[FrameTarget],
    settings: &InverseKinematicsSettings,
    kinematics: &mut Kinematics,
    q: &mut [f64],
) -> InverseKinematicsReport {
    assert!(settings.movable.is_empty() || settings.movable.len() == model.nv, "movable must have nv entries or none");
    let movable = |k: usize| settings.movable.get(k).copied().unwrap_or(true);
    let still = vec![0.0; model.nv];
    keep_within_limits(model, &movable, q);
    let errors = |q: &[f64], kinematics: &mut Kinematics| {
        forward_kinematics_into(model, q, &still, kinematics);
        Errors::of(targets, kinematics, settings.radian)
    };
    let mut now = errors(q, kinematics);
    let (mut damping, mut iterations) = (FIRST_DAMPING, 1);
    let mut tried = q.to_vec();
    while !now.within(settings.tolerance) && iterations < settings.max_iterations && damping < DAMPING.1 {
        let jacobian = now.jacobian(model, targets, kinematics, settings.radian);
        while iterations < settings.max_iterations && damping < DAMPING.1 {
            let step = step(model, &movable, q, &jacobian, &now.rows, damping);
            integrate_into(model, q, &step, 1.0, &mut tried);
            keep_within_limits(model, &movable, &mut tried);
            let next = errors(&tried, kinematics);
            iterations += 1;
            if next.squared() < now.squared() {
                q.copy_from_slice(&tried);
                now = next;
                damping = (damping / PACE).max(DAMPING.0);
                break;
            }
            damping *= PACE;
        }
    }
    forward_kinematics_into(model, q, &still, kinematics);
    let (position_error, angle_error) = (now.position, now.angle);
    InverseKinematicsReport { converged: now.within(settings.tolerance), position_error, angle_error, iterations }
}

/// What is missing to the targets.
struct Errors {
    /// m, three rows for a position or a rotation.
    rows: Vec<f64>,
    position: f64,
    angle: f64,
}

impl Errors {
    fn of(targets: &[FrameTarget], kinematics: &Kinematics, radian: f64) -> Self {
        let mut errors = Self { rows: Vec::new(), position: 0.0, angle: 0.0 };
        for target in targets {
            let pose = target.frame.pose(kinematics);
            if let Some(wanted) = target.rotation {
                let error = rotation_log((wanted * pose.rotation.conjugate()).normalize());
                errors.angle = errors.angle.max(error.length());
                errors.rows.extend((error * radian).to_array());
            }
            if let Some(wanted) = target.position {
                let error = wanted - pose.position;
                errors.position = errors.position.max(error.length());
                errors.rows.extend(error.to_array());
            }
        }
        errors
    }

    fn within(&self, tolerance: f64) -> bool {
        self.position <= tolerance && self.angle <= tolerance
    }

    fn squared(&self) -> f64 {
        self.rows.iter().map(|x| x * x).sum()
    }

    /// `[rows, nv]`: how fast the frames move towards their targets.
    fn jacobian(&self, model: &Model, targets: &[FrameTarget], kinematics: &mut Kinematics, radian: f64) -> Vec<f64> {
        let (nv, mut rows) = (model.nv, Vec::with_capacity(self.rows.len() * model.nv));
        let mut whole = vec![0.0; 6 * nv];
        for target in targets {
            let (frame, world) = (&target.frame, ReferenceFrame::LocalWorldAligned);
            frame_jacobian_into(model, kinematics, frame, world, &mut whole);
            if target.rotation.is_some() {
                rows.extend(whole[..3 * nv].iter().map(|x| x * radian));
            }
            if target.position.is_some() {
                rows.extend_from_slice(&whole[3 * nv..]);
            }
        }
        rows
    }
}

/// `Jᵀ (J Jᵀ + λ)⁻¹ e` on the degrees of freedom that may move and that no limit holds.
fn step(
    model: &Model,
    movable: &impl Fn(usize) -> bool,
    q: &[f64],
    jacobian: &[f64],
    errors: &[f64],
    damping: f64,
) -> Vec<f64> {
    let (nv, rows) = (model.nv, errors.len());
    let mut step = vec![0.0; nv];
    let row = |i: usize| &jacobian[i * nv..(i + 1) * nv];
    let towards = |k: usize| (0..rows).map(|i| row(i)[k] * errors[i]).sum::<f64>();
    let mut free: Vec<usize> = (0..nv).filter(|&k| movable(k)).collect();
    free.retain(|&k| !is_held(model, q, k, towards(k)));
    let mut matrix = vec![0.0; rows * rows];
    for i in 0..rows {
        for j in 0..=i {
            matrix[i * rows + j] = free.iter().map(|&k| row(i)[k] * row(j)[k]).sum();
        }
    }
    let squared: f64 = errors.iter().map(|e| e * e).sum();
    // Rounding of the matrix must not make it indefinite.
    let trace: f64 = (0..rows).map(|i| matrix[i * rows + i]).sum();
    let shift = damping * squared + 1e-14 * trace + f64::MIN_POSITIVE;
    (0..rows).for_each(|i| matrix[i * rows + i] += shift);
    if factorise(&mut matrix, rows, 0.0).is_none() {
        return step;
    }
    let mut weights = errors.to_vec();
    solve(&matrix, &mut weights);
    for k in free {
        step[k] = (0..rows).map(|i| row(i)[k] * weights[i]).sum();
    }
    // The errors' derivative says nothing about turns of more than a radian.
    let largest = (0..nv).filter(|&k| turns(model, k)).fold(1.0_f64, |a, k| a.max(step[k].abs()));
    step.iter_mut().for_each(|x| *x /= largest);
    step
}

/// Whether a degree of freedom is a rotation.
fn turns(model: &Model, dof: usize) -> bool {
    let joint = &model.joints[model.dof_joint[dof].index()];
    match joint.kind {
        JointKind::Slide { .. } => false,
        JointKind::Free => dof >= joint.v_index + 3,
        JointKind::Hinge { .. } | JointKind::Ball => true,
    }
}

/// Whether a hinge or slide is at the limit that a push leads to.
fn is_held(model: &Model, q: &[f64], dof: usize, push: f64) -> bool {
    let joint = &model.joints[model.dof_joint[dof].index()];
    match (joint.kind, joint.limits) {
        (JointKind::Hinge { .. } | JointKind::Slide { .. }, Some([lower, upper])) => {
            let at = q[joint.q_index];
            (at <= lower && push < 0.0) || (at >= upper && push > 0.0)
        }
        _ => false,
    }
}

fn keep_within_limits(model: &Model, movable: &impl Fn(usize) -> bool, q: &mut [f64]) {
    for joint in &model.joints {
        let Some([lower, upper]) = joint.limits else { continue };
        let at = joint.q_index;
        match joint.kind {
            _ if !movable(joint.v_index) => {}
            JointKind::Hinge { .. } | JointKind::Slide { .. } => q[at] = q[at].clamp(lower, upper),
            JointKind::Ball => {
                let turn = rotation_log(read_quaternion(&q[at..at + 4]));
                if turn.length() > upper {
                    write_quaternion(rotation_exp(turn.normalize_or_zero() * upper), &mut q[at..at + 4]);
                }
            }
            JointKind::Free => {}
        }
    }
}
