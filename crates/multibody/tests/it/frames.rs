//! Frame Jacobians, their rates, centroidal quantities and the Delassus operator, against finite differences and other
//! algorithms.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    AxisRates, BodyId, Centroidal, Frame, HalfSolvedRows, JacobianRows, Kinematics, Model, ReferenceFrame, State,
    angular_momentum, axis_rates_into, center_of_mass, center_of_mass_jacobian_into, centroidal_momentum_matrix_into,
    contact_rows_into, delassus_into, frame_bias_acceleration, frame_jacobian_into, frame_jacobian_rate_into,
    frame_velocity, integrate_into, linear_momentum, point_jacobian_into, total_mass,
};

use crate::identities::{FIXED, bias_force, forward_dynamics, kinematics, mass_matrix, relative_error};
use crate::random_model::{Random, for_random_models};

const REFERENCES: [ReferenceFrame; 3] =
    [ReferenceFrame::World, ReferenceFrame::Local, ReferenceFrame::LocalWorldAligned];

/// Step of the central differences.
const H: f64 = 1e-5;

/// Kinematics a time `H` before and after with the same `v`.
fn around(model: &Model, state: &State) -> [Kinematics; 2] {
    [-H, H].map(|h| {
        let mut next = state.clone();
        integrate_into(model, &state.q, &state.v, h, &mut next.q);
        kinematics(model, &next)
    })
}

fn times(matrix: &[f64], v: &[f64]) -> Vec<f64> {
    matrix.chunks(v.len()).map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum()).collect()
}

fn for_frames(seed: u64, check: impl Fn(&Model, &State, &Kinematics, &Frame, ReferenceFrame)) {
    for_random_models(seed, FIXED, |model, state, random: &mut Random| {
        if model.nv == 0 {
            return;
        }
        let at = kinematics(model, state);
        for i in 0..model.bodies.len() {
            let frame = Frame { body: BodyId(i as u32), placement: random.pose() };
            REFERENCES.iter().for_each(|&reference| check(model, state, &at, &frame, reference));
        }
    });
}

fn jacobian(model: &Model, at: &Kinematics, frame: &Frame, reference: ReferenceFrame) -> Vec<f64> {
    let mut out = vec![f64::NAN; 6 * model.nv];
    frame_jacobian_into(model, at, frame, reference, &mut out);
    out
}

/// Velocities by differences of poses, moved between the conventions by their definitions.
#[test]
fn frame_velocities_are_derivatives_of_poses() {
    for_frames(61, |model, state, at, frame, reference| {
        let [before, after] = around(model, state).map(|at| frame.pose(&at));
        let now = frame.pose(at);
        let linear = (after.position - before.position) / (2.0 * H);
        let angular = signorini_multibody::rotation_log(after.rotation * before.rotation.conjugate()) / (2.0 * H);
        let expected = match reference {
            ReferenceFrame::LocalWorldAligned => [angular, linear],
            ReferenceFrame::Local => [now.inverse().rotation * angular, now.inverse().rotation * linear],
            ReferenceFrame::World => [angular, linear + now.position.cross(angular)],
        };
        let expected: Vec<f64> = expected.iter().flat_map(|x| x.to_array()).collect();
        let velocity = frame_velocity(at, frame, reference).to_array();
        assert!(relative_error(&velocity, &expected) < 1e-8);
        let product = times(&jacobian(model, at, frame, reference), &state.v);
        assert!(relative_error(&product, &velocity) < 1e-13);
    });
}

#[test]
fn rates_of_jacobians_are_their_derivatives() {
    for_frames(62, |model, state, at, frame, reference| {
        let [before, after] = around(model, state).map(|at| jacobian(model, &at, frame, reference));
        let expected: Vec<f64> = before.iter().zip(&after).map(|(a, b)| (b - a) / (2.0 * H)).collect();
        let mut rates = AxisRates::new(model);
        axis_rates_into(model, at, &state.v, &mut rates);
        let mut rate = vec![f64::NAN; 6 * model.nv];
        frame_jacobian_rate_into(model, at, &rates, frame, reference, &mut rate);
        assert!(relative_error(&rate, &expected) < 1e-8, "{reference:?}");
        let bias = frame_bias_acceleration(model, at, frame, reference).to_array();
        assert!(relative_error(&times(&rate, &state.v), &bias) < 1e-12, "{reference:?}");
    });
}

#[test]
fn centroidal_momentum_is_the_momentum_of_the_bodies() {
    for_random_models(63, FIXED, |model, state, _| {
        let at = kinematics(model, state);
        let mut centroidal = Centroidal::new(model);
        centroidal_momentum_matrix_into(model, &at, &mut centroidal);
        let momentum = centroidal.momentum(&state.v);
        let center = center_of_mass(model, &at);
        let (angular, linear) = (angular_momentum(model, &at, center), linear_momentum(model, &at));
        let scale = 1.0 + angular.length() + linear.length();
        assert!((momentum.angular - angular).length() < 1e-12 * scale);
        assert!((momentum.linear - linear).length() < 1e-12 * scale);
        // The centre of mass moves with the momentum over the mass of all bodies, welded ones included.
        let mut jacobian = vec![0.0; 3 * model.nv];
        center_of_mass_jacobian_into(&centroidal, &mut jacobian);
        if model.nv == 0 {
            return;
        }
        let [before, after] = around(model, state).map(|at| center_of_mass(model, &at));
        let speed = (after - before) / (2.0 * H);
        let expected = speed.to_array();
        assert!((centroidal.mass - total_mass(model)).abs() < 1e-12);
        assert!(relative_error(&times(&jacobian, &state.v), &expected) < 1e-8);
    });
}

/// `J M⁻¹ Jᵀ` column by column with the articulated-body algorithm, which has no mass matrix.
#[test]
fn delassus_operator_is_the_response_to_unit_forces() {
    for_random_models(64, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let count = 5;
        let mut groups = vec![JacobianRows::new(model); count];
        let mut dense = vec![0.0; 3 * count * model.nv];
        for (c, rows) in groups.iter_mut().enumerate() {
            let bodies = [0; 2].map(|_: i32| BodyId(random.below(model.bodies.len()) as u32));
            let (point, directions) = (random.vector(1.0), [0; 3].map(|_: i32| random.direction()));
            contact_rows_into(model, &at, bodies.into(), point, &directions, rows);
            // The same rows from two dense Jacobians.
            let mut sides = [vec![0.0; 3 * model.nv], vec![0.0; 3 * model.nv]];
            for (side, body) in sides.iter_mut().zip(bodies) {
                point_jacobian_into(model, &at, body, point, side);
            }
            for r in 0..3 {
                for k in 0..model.nv {
                    let column = |j: &[f64]| DVec3::new(j[k], j[model.nv + k], j[2 * model.nv + k]);
                    dense[(3 * c + r) * model.nv + k] = directions[r].dot(column(&sides[1]) - column(&sides[0]));
                }
            }
        }
        let factor = mass_matrix(model, &at).matrix.factor().unwrap();
        let mut out = vec![f64::NAN; 9 * count * count];
        delassus_into(&factor, &groups, &mut HalfSolvedRows::default(), &mut out);
        let h = bias_force(model, &at);
        let mut expected = vec![0.0; 9 * count * count];
        for a in 0..3 * count {
            let tau: Vec<f64> = (0..model.nv).map(|k| h[k] + dense[a * model.nv + k]).collect();
            let response = forward_dynamics(model, &at, &tau);
            if model.nv > 0 {
                expected[a * 3 * count..][..3 * count].copy_from_slice(&times(&dense, &response));
            }
        }
        let error = relative_error(&out, &expected);
        assert!(error < 1e-10, "{error:e}");
    });
}
