//! Jacobians of points and bodies: dense, and sparse on the degrees of freedom that matter.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model, PathStep};

/// Three rows of a Jacobian on the degrees of freedom that can be nonzero; storage that is reused.
///
/// `dofs` is sorted and holds with every degree of freedom all those before it on the way to the root, as
/// [`BlockCholesky::half_solve_sparse`](crate::BlockCholesky::half_solve_sparse) needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JacobianRows {
    /// Degrees of freedom, ascending.
    pub dofs: Vec<usize>,
    /// For each of `dofs` its column: one value per row.
    pub columns: Vec<[f64; 3]>,
}

impl JacobianRows {
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

/// Adds what a force and a moment on a body are to the degrees of freedom: `τ += J_vᵀ f + J_ωᵀ m`.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `point`: where the force acts, world, m
/// - `force`, `moment`: world axes, N and N·m
/// - `generalized_force`: `[nv]`, N, N·m; that of [`Input`](crate::Input) makes it act in a step
///
/// On the world nothing happens.
///
/// # Panics
/// If `generalized_force` is shorter than `nv`.
pub fn add_wrench(
    model: &Model,
    kinematics: &Kinematics,
    body: BodyId,
    point: DVec3,
    force: DVec3,
    moment: DVec3,
    generalized_force: &mut [f64],
) {
    for k in model.dofs_moving(body) {
        let along = point_column(model, kinematics, k, point);
        generalized_force[k] += force.dot(along) + moment.dot(kinematics.dof_angular[k]);
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
pub fn point_rows_into(model: &Model, kinematics: &Kinematics, body: BodyId, point: DVec3, out: &mut JacobianRows) {
    out.clear();
    for k in model.dofs_moving(body) {
        out.push(k, point_column(model, kinematics, k, point).to_array());
    }
    out.finish();
}

/// Sparse form of [`angular_jacobian_into`]: the columns of the degrees of freedom that move the body.
pub fn angular_rows_into(model: &Model, kinematics: &Kinematics, body: BodyId, out: &mut JacobianRows) {
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
    out: &mut JacobianRows,
) {
    let along = |i: usize, sign: f64, columns: &mut [[f64; 3]]| {
        let step = &model.path[i];
        // d · (v + ω × r) = d · v + (r × d) · ω
        let arm = point - kinematics.pose[i].position;
        let linear = directions.map(|d| d * sign);
        let angular = linear.map(|d| arm.cross(d));
        if step.free {
            // Its axes are the world's and the body's.
            let linear = linear.map(|d| d.to_array());
            let angular = angular.map(|d| kinematics.rotation[i].mul_transpose_vec3(d).to_array());
            let (first, last) = columns.split_at_mut(3);
            for a in 0..3 {
                first[a] = linear.map(|d| d[a]);
                last[a] = angular.map(|d| d[a]);
            }
            return;
        }
        for (k, column) in (step.first_dof..).zip(columns) {
            let (w, v) = (kinematics.dof_angular[k], kinematics.dof_linear[k]);
            *column = std::array::from_fn(|r| linear[r].dot(v) + angular[r].dot(w));
        }
    };
    relative_rows(model, bodies, out, along);
}

/// Velocity of a material point of body B relative to one of body A, in world axes, as seen from the last body that carries both: the Jacobian of the
/// vector between them in axes that turn with that body, and now are the world's.
///
/// `a`, `b`: the bodies and their points in world, m. Degrees of freedom that move both bodies have columns of zero: they turn the vector and leave it
/// as long as it is. What acts along such rows has no moment, however far the points are apart.
pub(crate) fn relative_point_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    a: (BodyId, DVec3),
    b: (BodyId, DVec3),
    out: &mut JacobianRows,
) {
    let along = |i: usize, sign: f64, columns: &mut [[f64; 3]]| {
        let point = if sign > 0.0 { b.1 } else { a.1 };
        for (k, column) in (model.path[i].first_dof..).zip(columns) {
            *column = (point_column(model, kinematics, k, point) * sign).to_array();
        }
    };
    relative_rows(model, (a.0, b.0), out, along);
}

/// Angular velocity of body B less that of body A, world axes.
pub(crate) fn relative_angular_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    body_a: BodyId,
    body_b: BodyId,
    out: &mut JacobianRows,
) {
    let along = |i: usize, sign: f64, columns: &mut [[f64; 3]]| {
        for (k, column) in (model.path[i].first_dof..).zip(columns) {
            *column = (kinematics.dof_angular[k] * sign).to_array();
        }
    };
    relative_rows(model, (body_a, body_b), out, along);
}

/// Rows of the angular velocity of body B relative to body A along three directions, as [`contact_rows_into`] has them for
/// velocities.
pub fn spin_rows_into(
    model: &Model,
    kinematics: &Kinematics,
    bodies: (BodyId, BodyId),
    directions: &[DVec3; 3],
    out: &mut JacobianRows,
) {
    let along = |i: usize, sign: f64, columns: &mut [[f64; 3]]| {
        for (k, column) in (model.path[i].first_dof..).zip(columns) {
            *column = directions.map(|d| d.dot(kinematics.dof_angular[k] * sign));
        }
    };
    relative_rows(model, bodies, out, along);
}

/// Columns on all degrees of freedom that move A or B: `along(body, −1, columns)` fills those of the own joints of a body that
/// moves A alone, `along(body, 1, columns)` for B alone; that of a degree of freedom that moves both is zero.
fn relative_rows(
    model: &Model,
    (body_a, body_b): (BodyId, BodyId),
    out: &mut JacobianRows,
    along: impl Fn(usize, f64, &mut [[f64; 3]]),
) {
    let mut count = 0;
    walk_to_root(model, (body_a, body_b), |step, _| count += step.end_dof - step.first_dof);
    out.dofs.resize(count, 0);
    out.columns.resize(count, [0.0; 3]);
    // The bodies come from the last one to the root, so the columns are filled from the last one to the first.
    let mut end = count;
    walk_to_root(model, (body_a, body_b), |step, side| {
        let first = end - (step.end_dof - step.first_dof);
        let columns = &mut out.columns[first..end];
        out.dofs[first..end].iter_mut().zip(step.first_dof..).for_each(|(dof, k)| *dof = k);
        match side {
            Some((body, sign)) => along(body, sign, columns),
            None => columns.fill([0.0; 3]),
        }
        end = first;
    });
}

/// Visits every body with joints of its own that moves A or B, the later ones first: with its number and −1 if it moves A
/// alone, 1 if it moves B alone, nothing if it moves both.
fn walk_to_root(
    model: &Model,
    (body_a, body_b): (BodyId, BodyId),
    mut visit: impl FnMut(&PathStep, Option<(usize, f64)>),
) {
    let (mut a, mut b) = (model.body_weld[body_a.index()].index(), model.body_weld[body_b.index()].index());
    while a != b {
        // The later of the two cannot move both bodies, because both paths to the root descend.
        let (later, sign) = if a > b { (&mut a, -1.0) } else { (&mut b, 1.0) };
        let step = &model.path[*later];
        visit(step, Some((*later, sign)));
        *later = step.above;
    }
    while a != 0 {
        visit(&model.path[a], None);
        a = model.path[a].above;
    }
}
