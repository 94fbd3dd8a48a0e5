//! The centre of mass of a body with all that hangs on it, its Jacobian and the Jacobian's rate.

use glamx::glam::DVec3;

use crate::frame::AxisRates;
use crate::jacobian::point_column;
use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model};

/// Mass (kg) and centre of mass (world, m) of a body with all that hangs on it; of the world: of everything. Without mass the centre is
/// the body's origin.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
///
/// # Panics
/// If the model has no such body.
pub fn subtree_center_of_mass(model: &Model, kinematics: &Kinematics, body: BodyId) -> (f64, DVec3) {
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for i in moving(model, body) {
        let own = model.bodies[i].inertia.mass;
        mass += own;
        moment += kinematics.center_of_mass[i] * own;
    }
    if mass > 0.0 { (mass, moment / mass) } else { (mass, kinematics.pose[body.index()].position) }
}

/// Jacobian of [`subtree_center_of_mass`]: `ċ = J v`, world axes (MuJoCo's `mj_jacSubtreeCom`).
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `out`: `[3, nv]` row by row; zero without mass
///
/// # Panics
/// If `out` does not have `3 nv` entries.
///
/// # Cost
/// O(bodies · depth), no allocation.
pub fn subtree_jacobian_into(model: &Model, kinematics: &Kinematics, body: BodyId, out: &mut [f64]) {
    sum(model, kinematics, body, out, |k, i| point_column(model, kinematics, k, kinematics.center_of_mass[i]));
}

/// Rate `J̇` of [`subtree_jacobian_into`] along the motion.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `(q, v)`
/// - `rates`: from [`axis_rates_into`](crate::axis_rates_into) at the same
/// - `out`: `[3, nv]` row by row, m/s or 1/s times m
///
/// # Panics
/// If `out` does not have `3 nv` entries.
///
/// # Cost
/// O(bodies · depth), no allocation.
pub fn subtree_jacobian_rate_into(
    model: &Model,
    kinematics: &Kinematics,
    rates: &AxisRates,
    body: BodyId,
    out: &mut [f64],
) {
    sum(model, kinematics, body, out, |k, i| {
        let carrier = model.dof_body(k).index();
        let lever = kinematics.center_of_mass[i] - kinematics.pose[carrier].position;
        let speed = kinematics.point_velocity(BodyId(i as u32), kinematics.center_of_mass[i]);
        let lever_rate = speed - kinematics.linear_velocity[carrier];
        rates.linear[k] + rates.angular[k].cross(lever) + kinematics.dof_angular[k].cross(lever_rate)
    });
}

/// Bodies with mass in a subtree, the world without.
fn moving(model: &Model, body: BodyId) -> impl Iterator<Item = usize> + '_ {
    model.subtree(body).map(|id| id.index()).filter(|&i| i > 0)
}

/// Columns `column(dof, body)` of the bodies of a subtree, weighted with their masses.
fn sum(model: &Model, kinematics: &Kinematics, body: BodyId, out: &mut [f64], column: impl Fn(usize, usize) -> DVec3) {
    let nv = model.nv;
    assert_eq!(out.len(), 3 * nv, "the Jacobian needs 3 nv entries");
    out.fill(0.0);
    let (mass, _) = subtree_center_of_mass(model, kinematics, body);
    if mass <= 0.0 {
        return;
    }
    for i in moving(model, body) {
        let share = model.bodies[i].inertia.mass / mass;
        for k in model.dofs_moving(BodyId(i as u32)) {
            let x = column(k, i) * share;
            (0..3).for_each(|r| out[r * nv + k] += x[r]);
        }
    }
}
