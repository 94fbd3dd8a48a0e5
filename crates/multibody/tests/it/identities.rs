//! Identities between independent algorithms on random mechanisms.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    ArticulatedBodies, BodyId, Kinematics, LengthRow, MassError, MassMatrix, Model, MovingBodies, NewtonEuler, State,
    angular_jacobian_into, bias_force_into, body_velocities_into, forward_dynamics_into, forward_kinematics_into,
    inverse_dynamics_into, kinetic_energy, mass_matrix_into, point_jacobian_into,
};

use crate::random_model::{Recipe, for_random_models};

pub const FIXED: Recipe = Recipe { bodies: 9, floating: false, armature: true };

pub fn kinematics(model: &Model, state: &State) -> Kinematics {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    kinematics
}

/// What a row has at a degree of freedom.
pub fn entry(row: &LengthRow, dof: usize) -> f64 {
    row.dofs.iter().position(|&d| d == dof).map_or(0.0, |at| row.gradient[at])
}

pub fn mass_matrix(model: &Model, kinematics: &Kinematics) -> MassMatrix {
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, kinematics, &mut mass);
    mass
}

pub fn inverse_dynamics(model: &Model, kinematics: &Kinematics, acceleration: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; model.nv];
    inverse_dynamics_into(model, kinematics, acceleration, &mut NewtonEuler::new(model), &mut tau);
    tau
}

pub fn bias_force(model: &Model, kinematics: &Kinematics) -> Vec<f64> {
    let mut h = vec![0.0; model.nv];
    bias_force_into(model, kinematics, &mut NewtonEuler::new(model), &mut h);
    h
}

pub fn forward_dynamics(model: &Model, kinematics: &Kinematics, tau: &[f64]) -> Vec<f64> {
    let mut acceleration = vec![0.0; model.nv];
    forward_dynamics_into(model, kinematics, tau, &mut ArticulatedBodies::new(model), &mut acceleration).unwrap();
    acceleration
}

/// Largest absolute entry, at least 1.
pub fn magnitude(a: &[f64]) -> f64 {
    a.iter().fold(1.0, |s, x| s.max(x.abs()))
}

/// Largest difference of two lists in terms of the largest entry of the second (or 1).
pub fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0_f64, |e, (x, y)| e.max((x - y).abs())) / magnitude(b)
}

#[test]
fn inverse_dynamics_undoes_forward_dynamics() {
    for_random_models(1, FIXED, |model, state, random| {
        let kinematics = kinematics(model, state);
        let tau = random.list(model.nv, 20.0);
        let acceleration = forward_dynamics(model, &kinematics, &tau);
        let back = inverse_dynamics(model, &kinematics, &acceleration);
        let error = relative_error(&back, &tau);
        assert!(error < 1e-12, "{error}");
    });
}

/// A joint whose inertia is taken away by its rotor, or that has none that is a number, cannot be accelerated.
#[test]
fn forward_dynamics_refuses_what_has_no_positive_inertia() {
    for armature in [-1e3, f64::NEG_INFINITY, f64::INFINITY, f64::NAN] {
        for_random_models(4, FIXED, |model, state, _| {
            let Some(k) = (0..model.joints.len()).find(|&k| model.joints[k].kind.nv() == 1) else { return };
            let mut model = model.clone();
            model.joints[k].armature = armature;
            let (at, mut out) = (kinematics(&model, state), vec![0.0; model.nv]);
            let mut work = ArticulatedBodies::new(&model);
            let done = forward_dynamics_into(&model, &at, &vec![0.0; model.nv], &mut work, &mut out);
            let dof = model.joints[k].v_index;
            assert!(matches!(done, Err(MassError::NotPositiveDefinite { dof: found, .. }) if found == dof), "{done:?}");
        });
    }
}

#[test]
fn mass_matrix_and_bias_give_inverse_dynamics() {
    for_random_models(2, FIXED, |model, state, random| {
        let kinematics = kinematics(model, state);
        let mass = mass_matrix(model, &kinematics);
        let acceleration = random.list(model.nv, 5.0);
        let mut force = vec![0.0; model.nv];
        mass.matrix.multiply_into(&acceleration, &mut force);
        force.iter_mut().zip(bias_force(model, &kinematics)).for_each(|(f, h)| *f += h);
        let error = relative_error(&force, &inverse_dynamics(model, &kinematics, &acceleration));
        assert!(error < 1e-13, "{error}");
    });
}

#[test]
fn mass_matrix_columns_are_inverse_dynamics_of_unit_accelerations() {
    for_random_models(3, FIXED, |model, state, _| {
        let kinematics = kinematics(model, state);
        let dense = mass_matrix(model, &kinematics).matrix.to_dense();
        let h = bias_force(model, &kinematics);
        for k in 0..model.nv {
            let mut unit = vec![0.0; model.nv];
            unit[k] = 1.0;
            let column: Vec<f64> =
                inverse_dynamics(model, &kinematics, &unit).iter().zip(&h).map(|(t, h)| t - h).collect();
            let error = relative_error(&dense[k * model.nv..][..model.nv], &column);
            assert!(error < 1e-12, "{error}");
        }
    });
}

#[test]
fn mass_matrix_is_the_sum_of_projected_inertias() {
    for_random_models(4, FIXED, |model, state, _| {
        let (kinematics, nv) = (kinematics(model, state), model.nv);
        let mut sum = vec![0.0; nv * nv];
        for joint in &model.joints {
            (joint.v_index..joint.v_index + joint.kind.nv()).for_each(|k| sum[k * nv + k] += joint.armature);
        }
        let (mut jp, mut jr) = (vec![0.0; 3 * nv], vec![0.0; 3 * nv]);
        for i in 1..model.bodies.len() {
            let body = BodyId(i as u32);
            point_jacobian_into(model, &kinematics, body, kinematics.center_of_mass[i], &mut jp);
            angular_jacobian_into(model, &kinematics, body, &mut jr);
            let inertia = &model.bodies[i].inertia;
            let r = kinematics.rotation[i];
            let rotational = r * inertia.rotational * r.transpose();
            let column = |j: &[f64], k: usize| DVec3::new(j[k], j[nv + k], j[2 * nv + k]);
            for a in 0..nv {
                for b in 0..nv {
                    sum[a * nv + b] += inertia.mass * column(&jp, a).dot(column(&jp, b))
                        + column(&jr, a).dot(rotational * column(&jr, b));
                }
            }
        }
        let error = relative_error(&mass_matrix(model, &kinematics).matrix.to_dense(), &sum);
        assert!(error < 1e-13, "{error}");
    });
}

#[test]
fn kinetic_energy_is_the_quadratic_form_of_the_mass_matrix() {
    for_random_models(5, FIXED, |model, state, _| {
        let kinematics = kinematics(model, state);
        let mut momentum = vec![0.0; model.nv];
        mass_matrix(model, &kinematics).matrix.multiply_into(&state.v, &mut momentum);
        let half: f64 = momentum.iter().zip(&state.v).map(|(p, v)| 0.5 * p * v).sum();
        let energy = kinetic_energy(model, &kinematics, &state.v);
        assert!((half - energy).abs() < 1e-13 * energy.max(1.0), "{half} {energy}");
    });
}

/// Bodies that are welded together have the energy of all of them, at any velocity.
#[test]
fn bodies_as_one_have_the_kinetic_energy_of_all() {
    for_random_models(21, FIXED, |model, state, random| {
        let mut at = kinematics(model, state);
        let velocity = random.list(model.nv, 3.0);
        let (mut angular, mut linear) = (Vec::new(), Vec::new());
        body_velocities_into(model, &at, &velocity, &mut angular, &mut linear);
        let as_one = MovingBodies::of(model).kinetic_energy(model, &at, &velocity, (&angular, &linear));
        forward_kinematics_into(model, &state.q, &velocity, &mut at);
        let apart = kinetic_energy(model, &at, &velocity);
        assert!((as_one - apart).abs() < 1e-13 * apart.max(1.0), "{as_one} {apart}");
    });
}

/// What cannot move stands in new storage where kinematics has it.
#[test]
fn fixed_bodies_stand_from_the_start() {
    let fixed = std::cell::Cell::new(0);
    for_random_models(22, FIXED, |model, state, _| {
        let (new, at) = (Kinematics::new(model), kinematics(model, state));
        for i in (1..model.bodies.len()).filter(|&i| model.is_fixed(BodyId(i as u32))) {
            assert_eq!((new.pose[i], new.rotation[i], new.offset[i]), (at.pose[i], at.rotation[i], at.offset[i]));
            assert_eq!(new.center_of_mass[i], at.center_of_mass[i]);
            fixed.set(fixed.get() + 1);
        }
    });
    assert!(fixed.get() > 10, "{fixed:?}");
}
