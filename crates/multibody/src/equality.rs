//! Violation and Jacobian of the equality constraints of a model.

use glamx::glam::DVec3;

use crate::jacobian::{JacobianRows, relative_angular_rows_into, relative_point_rows_into};
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::rotation_log;
use crate::model::{EqualityKind, JointId, Model, TendonId};
use crate::tendon::tendon_length_into;

/// Up to three rows of an equality constraint; storage that is reused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EqualityBlock {
    /// Number of rows that are used, 1 or 3.
    pub count: usize,
    /// Violation Θ of each row, m or rad.
    pub violation: [f64; 3],
    /// `∇Θ` of each row.
    pub rows: JacobianRows,
    lengths: [LengthRow; 2],
}

impl EqualityBlock {
    /// Storage that never grows for the model.
    pub fn new(model: &Model) -> Self {
        let lengths = [LengthRow::new(model), LengthRow::new(model)];
        Self { count: 0, violation: [0.0; 3], rows: JacobianRows::new(model), lengths }
    }

    /// The largest |Θ| of its rows.
    pub fn size(&self) -> f64 {
        self.violation[..self.count].iter().fold(0.0, |a, x| a.max(x.abs()))
    }
}

/// Violation Θ and Jacobian ∇Θ of one block of an equality constraint (formulation §5).
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `q`
/// - `kind`: a constraint of the model
/// - `block`: 0, or 1 for the rotation of a weld
/// - `out`: for points, Θ is the vector from the point of A to that of B, in world axes, m, and ∇Θ its change as seen from the last body that carries
///   both, which turns it and leaves its length; for the rotation of a weld, the
///   rotation vector from A's frame to B's, in world axes, rad, whose row is the relative angular velocity: a step with
///   `∇Θ v = −Θ/Δt` removes it exactly, whatever its size; for joints `q − q₀ − Σ a_k (q′ − q′₀)^k`, and so for the
///   lengths of tendons
///
/// # Panics
/// If `kind` is not one of the model's.
pub fn equality_block_into(
    model: &Model,
    kinematics: &Kinematics,
    q: &[f64],
    kind: &EqualityKind,
    block: usize,
    out: &mut EqualityBlock,
) {
    out.count = 3;
    match *kind {
        EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
            let point_a = kinematics.pose[body_a.index()].transform_point(point_a);
            let point_b = kinematics.pose[body_b.index()].transform_point(point_b);
            out.violation = (point_b - point_a).to_array();
            relative_point_rows_into(model, kinematics, (body_a, point_a), (body_b, point_b), &mut out.rows);
        }
        EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
            let frame_a = kinematics.pose[body_a.index()] * frame_a;
            let frame_b = kinematics.pose[body_b.index()] * frame_b;
            if block == 0 {
                let (a, b) = (frame_a.position, frame_b.position);
                out.violation = (b - a).to_array();
                relative_point_rows_into(model, kinematics, (body_a, a), (body_b, b), &mut out.rows);
            } else {
                let turn: DVec3 = rotation_log(frame_a.rotation.conjugate() * frame_b.rotation);
                out.violation = (frame_a.rotation * turn).to_array();
                relative_angular_rows_into(model, kinematics, body_a, body_b, &mut out.rows);
            }
        }
        EqualityKind::Joint { joint, driver, polynomial } => {
            out.count = 1;
            couple_joints(model, q, (joint, driver), polynomial, out);
        }
        EqualityKind::Tendon { tendon, driver, polynomial } => {
            out.count = 1;
            couple_tendons(model, kinematics, q, (tendon, driver), polynomial, out);
        }
    }
}

/// The row of a tendon that follows another.
fn couple_tendons(
    model: &Model,
    kinematics: &Kinematics,
    q: &[f64],
    (tendon, driver): (TendonId, Option<TendonId>),
    polynomial: [f64; 5],
    out: &mut EqualityBlock,
) {
    let EqualityBlock { rows, lengths: [own, leading], violation, .. } = out;
    let measure = |id: TendonId, row: &mut LengthRow| {
        let tendon = &model.tendons[id.index()];
        tendon_length_into(model, kinematics, q, tendon, row);
        row.length - tendon.reference_length
    };
    let length = measure(tendon, own);
    leading.clear();
    let x = driver.map_or(0.0, |driver| measure(driver, leading));
    let (wanted, slope) = polynomial_at(polynomial, x);
    *violation = [length - wanted, 0.0, 0.0];
    for (&k, &g) in leading.dofs.iter().zip(&leading.gradient) {
        own.add(k, -slope * g);
    }
    rows.clear();
    own.dofs.iter().zip(&own.gradient).for_each(|(&k, &g)| rows.push(k, [g, 0.0, 0.0]));
}

/// What an equality asks of a joint or tendon whose driver is at `x`, and how that changes with it: `Σ a_k x^k` and its derivative, by Horner's
/// scheme.
pub fn polynomial_at(polynomial: [f64; 5], x: f64) -> (f64, f64) {
    polynomial.iter().rev().fold((0.0, 0.0), |(p, d), a| (p * x + a, d * x + p))
}

/// The row of a joint that follows another.
fn couple_joints(
    model: &Model,
    q: &[f64],
    (joint, driver): (JointId, Option<JointId>),
    polynomial: [f64; 5],
    out: &mut EqualityBlock,
) {
    let value = |id: JointId| {
        let joint = &model.joints[id.index()];
        (joint.v_index, q[joint.q_index] - joint.reference)
    };
    let (dof, position) = value(joint);
    let leading = driver.map(value);
    let x = leading.map_or(0.0, |(_, x)| x);
    let (wanted, slope) = polynomial_at(polynomial, x);
    out.violation = [position - wanted, 0.0, 0.0];
    out.rows.clear();
    let own = (dof, [1.0, 0.0, 0.0]);
    match leading {
        None => out.rows.push(own.0, own.1),
        Some((k, _)) => {
            let other = (k, [-slope, 0.0, 0.0]);
            let (first, second) = if k < dof { (other, own) } else { (own, other) };
            out.rows.push(first.0, first.1);
            out.rows.push(second.0, second.1);
        }
    }
}

/// The size of every equality constraint's violation at a configuration, `[equalities]`: the largest |Θ| of its rows, m or rad.
pub fn equality_violations(model: &Model, kinematics: &Kinematics, q: &[f64]) -> Vec<f64> {
    let mut block = EqualityBlock::new(model);
    let of = |equality: &crate::model::Equality| {
        (0..equality.kind.block_count()).fold(0.0, |worst: f64, k| {
            equality_block_into(model, kinematics, q, &equality.kind, k, &mut block);
            worst.max(block.size())
        })
    };
    model.equalities.iter().map(of).collect()
}
