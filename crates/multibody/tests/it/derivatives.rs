//! Derivatives of inverse dynamics and of velocities, against central differences, for random trees.

use signorini_multibody::derivatives::{
    InverseDynamicsDerivatives, MotionDerivatives, inverse_dynamics_derivatives_into,
};
use signorini_multibody::{
    BodyId, Model, NewtonEuler, SpatialVector, State, add_wrench, integrate_into, inverse_dynamics_into,
    point_jacobian_into,
};

use crate::identities::{FIXED, kinematics, relative_error};
use crate::random_model::{Random, for_random_models};

/// Step of the central differences.
const H: f64 = 1e-5;

fn moved(model: &Model, state: &State, k: usize, h: f64) -> State {
    let (mut direction, mut next) = (vec![0.0; model.nv], state.clone());
    direction[k] = 1.0;
    integrate_into(model, &state.q, &direction, h, &mut next.q);
    next
}

fn force(model: &Model, state: &State, acceleration: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.nv];
    inverse_dynamics_into(model, &kinematics(model, state), acceleration, &mut NewtonEuler::new(model), &mut tau);
    tau
}

/// Checks a column of slopes against the difference of what is measured at both sides.
fn assert_column(ahead: &[f64], behind: &[f64], slope: impl Fn(usize) -> f64) {
    let size = ahead.iter().chain(behind).fold(1.0, |s: f64, x| s.max(x.abs()));
    for (row, (a, b)) in ahead.iter().zip(behind).enumerate() {
        let expected = (a - b) / (2.0 * H);
        let off = (slope(row) - expected).abs();
        assert!(off < 1e-6 * (size + expected.abs()), "row {row}: {} and {expected}", slope(row));
    }
}

#[test]
fn inverse_dynamics_has_the_slopes_of_its_differences() {
    for_random_models(901, FIXED, |model, state, random: &mut Random| {
        let nv = model.nv;
        let acceleration = random.list(nv, 1.0);
        let mut out = InverseDynamicsDerivatives::new(model);
        let at = kinematics(model, state);
        // Fixed to their bodies, so that they turn with them.
        let wrenches: Vec<SpatialVector> = (0..model.bodies.len())
            .map(|_| SpatialVector { angular: random.vector(2.0), linear: random.vector(2.0) })
            .collect();
        inverse_dynamics_derivatives_into(model, &at, &state.v, &acceleration, &wrenches, &mut out);
        let force = |model: &Model, state: &State, acceleration: &[f64]| {
            let (mut tau, now) = (force(model, state, acceleration), kinematics(model, state));
            for (i, wrench) in wrenches.iter().enumerate() {
                let turn = now.pose[i].rotation * at.pose[i].rotation.conjugate();
                let (point, taken) = (now.pose[i].position, [wrench.linear, wrench.angular].map(|x| turn * -x));
                add_wrench(model, &now, BodyId(i as u32), point, taken[0], taken[1], &mut tau);
            }
            tau
        };
        assert_column(&force(model, state, &acceleration), &out.force, |_| 0.0);
        for k in 0..nv {
            let [ahead, behind] = [H, -H].map(|h| force(model, &moved(model, state, k, h), &acceleration));
            assert_column(&ahead, &behind, |row| out.by_configuration[row * nv + k]);
            let [ahead, behind] = [H, -H].map(|h| {
                let mut other = state.clone();
                other.v[k] += h;
                force(model, &other, &acceleration)
            });
            assert_column(&ahead, &behind, |row| out.by_velocity[row * nv + k]);
        }
    });
}

#[test]
fn velocities_of_bodies_have_the_slopes_of_their_differences() {
    for_random_models(902, FIXED, |model, state, random: &mut Random| {
        let at = kinematics(model, state);
        let mut motion = MotionDerivatives::new(model);
        motion.set(model, &at, &state.v);
        for body in (1..model.bodies.len() as u32).map(BodyId) {
            let point = at.pose[body.index()].position;
            let elsewhere = random.vector(1.0);
            let carried = motion.velocity(body, elsewhere).to_array();
            let expected = [at.angular_velocity[body.index()], at.point_velocity(body, elsewhere)];
            assert!(relative_error(&carried, expected.map(|v| v.to_array()).as_flattened()) < 1e-13);
            let mut jacobian = vec![0.0; 3 * model.nv];
            point_jacobian_into(model, &at, body, elsewhere, &mut jacobian);
            for k in model.dofs_moving(body) {
                let column = [0, 1, 2].map(|row| jacobian[row * model.nv + k]);
                assert!(relative_error(&motion.displacement(k, elsewhere).to_array()[3..], &column) < 1e-13);
                let [ahead, behind] = [H, -H].map(|h| {
                    let near = kinematics(model, &moved(model, state, k, h));
                    let (v, w) = (near.point_velocity(body, point), near.angular_velocity[body.index()]);
                    [w.to_array(), v.to_array()].concat()
                });
                let slope = motion.velocity_slope(body, k, point).to_array();
                assert_column(&ahead, &behind, |row| slope[row]);
            }
        }
    });
}
