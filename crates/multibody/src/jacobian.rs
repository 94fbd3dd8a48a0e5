//! Jacobians of points and bodies: dense, and sparse on the degrees of freedom that matter.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model};

/// Three rows of a Jacobian on the degrees of freedom that can be nonzero; storage that is reused.
///
/// `dofs` is sorted and holds with every degree of freedom all those before it on the way to the root, as
/// [`BlockCholesky::half_solve_sparse`](crate::BlockCholesky::half_solve_sparse) needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseRows {
    /// Degrees of freedom, ascending.
    pub dofs: Vec<usize>,
    /// For each of `dofs` its column: one value per row.
    pub columns: Vec<[f64; 3]>,
}

impl SparseRows {
    /// Storage that never grows for the model.
    pub fn new(model: &Model) -> Self {
        Self { dofs: Vec::with_capacity(model.nv), columns: Vec::with_capacity(model.nv) }
    }

    /// The three rows times `v`, `[nv]`.
    ///
    /// # Panics
    /// If `v` is shorter than the largest degree of freedom asks for.
    pub fn multiply(&self, v: &[f64]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (&k, column) in self.dofs.iter().zip(&self.columns) {
            for (s, c) in sum.iter_mut().zip(column) {
                *s += c * v[k];
            }
        }
        sum
    }

    pub(crate) fn clear(&mut self) {
        self.dofs.clear();
        self.columns.clear();
    }

    pub(crate) fn push(&mut self, dof: usize, column: [f64; 3]) {
        self.dofs.push(dof);
        self.columns.push(column);
    }

    /// Brings columns that were pushed from the last degree of freedom to the first into ascending order.
    fn finish(&mut self) {
        self.dofs.reverse();
        self.columns.reverse();
    }
}

/// Velocity of the material point of a moved body at `point` (world) per unit rate of degree of freedom `dof`, world axes.
/// The degree of freedom has to be one that moves the body.
pub fn point_column(model: &Model, kinematics: &Kinematics, dof: usize, point: DVec3) -> DVec3 {
    let origin = kinematics.pose[model.dof_body(dof).index()].position;
    kinematics.dof_linear[dof] + kinematics.dof_angular[dof].cross(point - origin)
}

/// Jacobian of the velocity of a body's material point: `ṗ = J v`.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `point`: where the point is, world, m
/// - `out`: `J`, `[3, nv]` row by row, world axes
///
/// # Panics
/// If `out` does not have `3 nv` entries.
pub fn point_jacobian_into(model: &Model, kinematics: &Kinematics, body: BodyId, point: DVec3, out: &mut [f64]) {
    dense_jacobian(model, body, out, |k| point_column(model, kinematics, k, point));
}

/// Jacobian of a body's angular velocity: `ω = J v`, world axes; `out`: `[3, nv]` row by row.
///
/// # Panics
/// If `out` does not have `3 nv` entries.
pub fn angular_jacobian_into(model: &Model, kinematics: &Kinematics, body: BodyId, out: &mut [f64]) {
    dense_jacobian(model, body, out, |k| kinematics.dof_angular[k]);
}

fn dense_jacobian(model: &Model, body: BodyId, out: &mut [f64], column: impl Fn(usize) -> DVec3) {
    assert_eq!(out.len(), 3 * model.nv, "the Jacobian needs 3 nv entries");
    out.fill(0.0);
    for k in model.dofs_moving(body) {
        for (row, x) in column(k).to_array().into_iter().enumerate() {
            out[row * model.nv + k] = x;
        }
    }
}

/// Sparse form of [`point_jacobian_into`]: the columns of the degrees of freedom that move the body.
pub fn point_rows_into(model: &Model, kinematics: &Kinematics, body: BodyId, point: DVec3, out: &mut SparseRows) {
    out.clear();
    for k in model.dofs_moving(body) {
        out.push(k, point_column(model, kinematics, k, point).to_array());
    }
    out.finish();
}

/// Sparse form of [`angular_jacobian_into`]: the columns of the degrees of freedom that move the body.
pub fn angular_rows_into(model: &Model, kinematics: &Kinematics, body: BodyId, out: &mut SparseRows) {
    out.clear();
    for k in model.dofs_moving(body) {
        out.push(k, kinematics.dof_angular[k].to_array());
    }
    out.finish();
}

/// Rows of a contact: the velocity of body B relative to body A at one point, along three directions
/// (`c = J v`, formulation §1).
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `bodies`: A and B
/// - `point`: world, m
/// - `directions`: unit vectors in world; row `r` of the result is along `directions[r]`
/// - `out`: columns on all degrees of freedom that move A or B; those that move both get exact zeros, since they move the
///   two material points alike
pub fn contact_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    bodies: (BodyId, BodyId),
    point: DVec3,
    directions: &[DVec3; 3],
    out: &mut SparseRows,
) {
    let along = |k: usize, sign: f64| {
        let velocity = point_column(model, kinematics, k, point) * sign;
        directions.map(|d| d.dot(velocity))
    };
    relative_rows(model, bodies, out, along, |_| [0.0; 3]);
}

/// Velocity of a material point of body B less that of one of body A, world axes: the Jacobian of the vector between them.
///
/// `a`, `b`: the bodies and their points in world, m. Degrees of freedom that move both bodies have columns, which are zero
/// only where the points coincide.
pub(crate) fn relative_point_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    a: (BodyId, DVec3),
    b: (BodyId, DVec3),
    out: &mut SparseRows,
) {
    let along = |k: usize, sign: f64| {
        let point = if sign > 0.0 { b.1 } else { a.1 };
        (point_column(model, kinematics, k, point) * sign).to_array()
    };
    let common = |k: usize| kinematics.dof_angular[k].cross(b.1 - a.1).to_array();
    relative_rows(model, (a.0, b.0), out, along, common);
}

/// Angular velocity of body B less that of body A, world axes.
pub(crate) fn relative_angular_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    body_a: BodyId,
    body_b: BodyId,
    out: &mut SparseRows,
) {
    let along = |k: usize, sign: f64| (kinematics.dof_angular[k] * sign).to_array();
    relative_rows(model, (body_a, body_b), out, along, |_| [0.0; 3]);
}

/// Rows of the angular velocity of body B relative to body A along three directions, as [`contact_rows_into`] has them for
/// velocities.
pub fn spin_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    bodies: (BodyId, BodyId),
    directions: &[DVec3; 3],
    out: &mut SparseRows,
) {
    let along = |k: usize, sign: f64| directions.map(|d| d.dot(kinematics.dof_angular[k] * sign));
    relative_rows(model, bodies, out, along, |_| [0.0; 3]);
}

/// Columns on all degrees of freedom that move A or B: `along(k, −1)` for those that move A alone, `along(k, 1)` for B alone,
/// `common(k)` for those that move both.
fn relative_rows(
    model: &Model,
    (body_a, body_b): (BodyId, BodyId),
    out: &mut SparseRows,
    along: impl Fn(usize, f64) -> [f64; 3],
    common: impl Fn(usize) -> [f64; 3],
) {
    out.clear();
    let (mut a, mut b) = (model.body_last_dof[body_a.index()], model.body_last_dof[body_b.index()]);
    while a != b {
        // The later of the two cannot move both bodies, because both paths to the root descend.
        if a > b {
            a = a.and_then(|k| {
                out.push(k, along(k, -1.0));
                model.dof_parent[k]
            });
        } else {
            b = b.and_then(|k| {
                out.push(k, along(k, 1.0));
                model.dof_parent[k]
            });
        }
    }
    while let Some(k) = a {
        out.push(k, common(k));
        a = model.dof_parent[k];
    }
    out.finish();
}
