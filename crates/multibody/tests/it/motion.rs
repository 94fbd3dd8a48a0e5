//! The motion of random mechanisms against finite differences along `q ⊕ Δt v`, balances and invariances.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BodyId, JacobianRows, Kinematics, Model, NewtonEuler, State, add_wrench, angular_jacobian_into, angular_momentum,
    angular_rows_into, center_of_mass, contact_rows_into, difference_into, integrate_into, inverse_dynamics_into,
    kinetic_energy, linear_momentum, point_jacobian_into, point_rows_into, potential_energy, rotation_log, total_mass,
};

use crate::identities::{
    FIXED, bias_force, forward_dynamics, inverse_dynamics, kinematics, magnitude, mass_matrix, relative_error,
};
use crate::random_model::{Recipe, for_random_models};

/// Step of the central differences; their error is of the order of `H²` = 1e-10 times a third derivative.
const H: f64 = 1e-5;

/// The state a time `h` later under a constant generalized acceleration, up to terms of third order.
fn moved(model: &Model, state: &State, acceleration: &[f64], h: f64) -> State {
    let mean: Vec<f64> = state.v.iter().zip(acceleration).map(|(v, a)| v + 0.5 * h * a).collect();
    let mut next = state.clone();
    integrate_into(model, &state.q, &mean, h, &mut next.q);
    next.v.iter_mut().zip(acceleration).for_each(|(v, a)| *v += h * a);
    next
}

/// Kinematics a time `H` before and after.
fn around(model: &Model, state: &State, acceleration: &[f64]) -> [Kinematics; 2] {
    [-H, H].map(|h| kinematics(model, &moved(model, state, acceleration, h)))
}

fn close(a: DVec3, b: DVec3, tolerance: f64, what: &str) {
    assert!((a - b).length() < tolerance * (1.0 + b.length()), "{what}: {a} and {b}");
}

#[test]
fn velocities_are_derivatives_of_poses() {
    for_random_models(11, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let [before, after] = around(model, state, &vec![0.0; model.nv]);
        for i in 0..model.bodies.len() {
            let body = BodyId(i as u32);
            let linear = (after.pose[i].position - before.pose[i].position) / (2.0 * H);
            close(at.linear_velocity[i], linear, 1e-8, "velocity");
            let turn = after.pose[i].rotation * before.pose[i].rotation.conjugate();
            close(at.angular_velocity[i], rotation_log(turn) / (2.0 * H), 1e-8, "angular velocity");
            let local = random.vector(1.0);
            let point = at.pose[i].transform_point(local);
            let speed = (after.pose[i].transform_point(local) - before.pose[i].transform_point(local)) / (2.0 * H);
            close(at.point_velocity(body, point), speed, 1e-8, "point velocity");
        }
    });
}

#[test]
fn jacobians_times_velocity_are_velocities() {
    for_random_models(12, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let mut rows = JacobianRows::new(model);
        let mut dense = vec![0.0; 3 * model.nv];
        for i in 0..model.bodies.len() {
            let body = BodyId(i as u32);
            let point = at.pose[i].transform_point(random.vector(1.0));
            let times = |dense: &[f64]| {
                let row = |r: usize| (0..model.nv).map(|k| dense[r * model.nv + k] * state.v[k]).sum::<f64>();
                DVec3::new(row(0), row(1), row(2))
            };
            point_jacobian_into(model, &at, body, point, &mut dense);
            close(times(&dense), at.point_velocity(body, point), 1e-13, "J v");
            point_rows_into(model, &at, body, point, &mut rows);
            close(DVec3::from(rows.multiply(&state.v)), at.point_velocity(body, point), 1e-13, "sparse J v");
            angular_jacobian_into(model, &at, body, &mut dense);
            close(times(&dense), at.angular_velocity[i], 1e-13, "angular J v");
            angular_rows_into(model, &at, body, &mut rows);
            close(DVec3::from(rows.multiply(&state.v)), at.angular_velocity[i], 1e-13, "sparse angular J v");
        }
    });
}

/// The power of a wrench is what its generalized force does with the velocities.
#[test]
fn wrenches_do_the_work_of_their_generalized_force() {
    for_random_models(29, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        for body in (0..model.bodies.len() as u32).map(BodyId) {
            let [point, force, moment] = [0; 3].map(|_: i32| random.vector(2.0));
            let mut tau = vec![0.0; model.nv];
            add_wrench(model, &at, body, point, force, moment, &mut tau);
            let work: f64 = tau.iter().zip(&state.v).map(|(t, v)| t * v).sum();
            let power = force.dot(at.point_velocity(body, point)) + moment.dot(at.angular_velocity[body.index()]);
            assert!((work - power).abs() < 1e-11 * (1.0 + power.abs()), "{body:?}: {work}, {power}");
        }
    });
}

#[test]
fn contact_rows_are_relative_velocities() {
    for_random_models(13, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let mut rows = JacobianRows::new(model);
        for _ in 0..20 {
            let [a, b] = [0; 2].map(|_: i32| BodyId(random.below(model.bodies.len()) as u32));
            let (point, directions) = (random.vector(2.0), [0; 3].map(|_: i32| random.direction()));
            contact_rows_into(model, &at, (a, b), point, &directions, &mut rows);
            assert!(rows.dofs.is_sorted_by(|x, y| x < y), "{:?}", rows.dofs);
            for k in &rows.dofs {
                assert!(model.dof_parent[*k].is_none_or(|p| rows.dofs.contains(&p)), "{:?}", rows.dofs);
            }
            let relative = at.point_velocity(b, point) - at.point_velocity(a, point);
            let expected = DVec3::from(directions.map(|d| d.dot(relative)));
            close(DVec3::from(rows.multiply(&state.v)), expected, 1e-12, "contact velocity");
        }
    });
}

/// `τ = Σ Jᵀ d(momentum)/dt − Jᵀ m g`, with the momenta of the bodies differentiated numerically along the motion.
#[test]
fn inverse_dynamics_is_the_projected_rate_of_momentum() {
    for_random_models(14, FIXED, |model, state, random| {
        let nv = model.nv;
        let acceleration = random.list(nv, 3.0);
        let at = kinematics(model, state);
        let [before, after] = around(model, state, &acceleration);
        let mut tau = vec![0.0; nv];
        for joint in &model.joints {
            (joint.v_index..joint.v_index + joint.kind.nv()).for_each(|k| tau[k] += joint.armature * acceleration[k]);
        }
        let (mut jp, mut jr) = (vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
        for i in 1..model.bodies.len() {
            let (body, inertia) = (BodyId(i as u32), &model.bodies[i].inertia);
            let momentum = |k: &Kinematics| k.point_velocity(body, k.center_of_mass[i]) * inertia.mass;
            let spin = |k: &Kinematics| {
                k.rotation[i] * (inertia.rotational * (k.rotation[i].transpose() * k.angular_velocity[i]))
            };
            let force = (momentum(&after) - momentum(&before)) / (2.0 * H) - model.gravity * inertia.mass;
            let moment = (spin(&after) - spin(&before)) / (2.0 * H);
            point_jacobian_into(model, &at, body, at.center_of_mass[i], &mut jp);
            angular_jacobian_into(model, &at, body, &mut jr);
            for k in 0..nv {
                let column = |j: &[f64]| DVec3::new(j[k], j[nv + k], j[2 * nv + k]);
                tau[k] += column(&jp).dot(force) + column(&jr).dot(moment);
            }
        }
        let error = relative_error(&inverse_dynamics(model, &at, &acceleration), &tau);
        assert!(error < 1e-8, "{error}");
    });
}

/// What inverse dynamics knows of every body's acceleration, gravity taken away from it.
#[test]
fn accelerations_are_derivatives_of_velocities() {
    for_random_models(18, FIXED, |model, state, random| {
        let acceleration = random.list(model.nv, 3.0);
        let mut work = NewtonEuler::new(model);
        let mut tau = vec![0.0; model.nv];
        inverse_dynamics_into(model, &kinematics(model, state), &acceleration, &mut work, &mut tau);
        let [before, after] = around(model, state, &acceleration);
        for i in 1..model.bodies.len() {
            let (angular, linear) = work.acceleration(BodyId(i as u32));
            close(angular, (after.angular_velocity[i] - before.angular_velocity[i]) / (2.0 * H), 1e-7, "angular");
            let speeding = (after.linear_velocity[i] - before.linear_velocity[i]) / (2.0 * H);
            close(linear, speeding - model.gravity, 1e-7, "linear");
        }
    });
}

#[test]
fn energy_changes_by_the_power_of_the_applied_forces() {
    for_random_models(15, FIXED, |model, state, random| {
        let mut model = model.clone();
        let mut tau = random.list(model.nv, 10.0);
        let power: f64 = tau.iter().zip(&state.v).map(|(t, v)| t * v).sum();
        for joint in model.joints.iter_mut().filter(|j| j.kind.nv() == 1) {
            (joint.stiffness, joint.spring_reference) = (random.uniform(0.0, 30.0), random.uniform(-1.0, 1.0));
            tau[joint.v_index] -= joint.stiffness * (state.q[joint.q_index] - joint.spring_reference);
        }
        let at = kinematics(&model, state);
        let acceleration = forward_dynamics(&model, &at, &tau);
        let energy = |h: f64| {
            let state = moved(&model, state, &acceleration, h);
            let at = kinematics(&model, &state);
            kinetic_energy(&model, &at, &state.v) + potential_energy(&model, &at, &state.q)
        };
        let rate = (energy(H) - energy(-H)) / (2.0 * H);
        let scale = 1.0 + power.abs() + energy(0.0).abs() + magnitude(&acceleration);
        assert!((rate - power).abs() < 1e-7 * scale, "{rate} {power}");
    });
}

#[test]
fn internal_forces_leave_momentum_alone() {
    let recipe = Recipe { bodies: 9, floating: true, armature: false };
    for_random_models(16, recipe, |model, state, random| {
        let mut tau = random.list(model.nv, 10.0);
        for joint in model.joints.iter().filter(|j| j.kind.nv() == 6) {
            tau[joint.v_index..joint.v_index + 6].fill(0.0);
        }
        let at = kinematics(model, state);
        let acceleration = forward_dynamics(model, &at, &tau);
        let [before, after] = around(model, state, &acceleration);
        let weight = model.gravity * total_mass(model);
        let force = (linear_momentum(model, &after) - linear_momentum(model, &before)) / (2.0 * H);
        let origin = |k: &Kinematics| angular_momentum(model, k, DVec3::ZERO);
        let moment = (origin(&after) - origin(&before)) / (2.0 * H);
        let scale = 1.0 + magnitude(&acceleration);
        close(force, weight, 1e-8 * scale, "force");
        close(moment, center_of_mass(model, &at).cross(weight), 1e-8 * scale, "moment");
    });
}

/// No world position and no common velocity enters the dynamics, so not a single bit may change.
#[test]
fn dynamics_do_not_depend_on_place_or_speed_of_the_whole() {
    let recipe = Recipe { bodies: 9, floating: true, armature: true };
    for_random_models(17, recipe, |model, state, random| {
        let (shift, boost) = (random.vector(1e4).to_array(), random.vector(1e4).to_array());
        let mut far = state.clone();
        for joint in model.joints.iter().filter(|j| j.kind.nv() == 6) {
            for a in 0..3 {
                far.q[joint.q_index + a] += shift[a];
                far.v[joint.v_index + a] += boost[a];
            }
        }
        let (near, far) = (kinematics(model, state), kinematics(model, &far));
        assert_eq!(mass_matrix(model, &near).matrix, mass_matrix(model, &far).matrix);
        assert_eq!(bias_force(model, &near), bias_force(model, &far));
        let tau = random.list(model.nv, 5.0);
        assert_eq!(forward_dynamics(model, &near, &tau), forward_dynamics(model, &far, &tau));
    });
}

#[test]
fn difference_inverts_integration() {
    for_random_models(18, FIXED, |model, state, random| {
        // The angle of a ball joint stays below π.
        let step = random.list(model.nv, 1.8);
        let (mut q, mut back) = (vec![0.0; model.nq], vec![0.0; model.nv]);
        integrate_into(model, &state.q, &step, 1.0, &mut q);
        difference_into(model, &q, &state.q, &mut back);
        assert!(relative_error(&back, &step) < 1e-13, "{}", relative_error(&back, &step));
        let mut again = vec![0.0; model.nq];
        integrate_into(model, &q, &step, -1.0, &mut again);
        assert!(relative_error(&again, &state.q) < 1e-14, "{}", relative_error(&again, &state.q));
    });
}
