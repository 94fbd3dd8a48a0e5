//! Bodies that turn freely over long times.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{
    BodyId, FreeMotion, Inertia, Input, Joint, JointKind, Model, ModelBuilder, Pose, State, angular_momentum,
    center_of_mass, free_motion_into, integrate_into, kinetic_energy, potential_energy, rotation_exp,
};

use crate::identities::kinematics;
use crate::random_model::Random;

/// A body on one joint under gravity `g` along −z.
fn single(inertia: Inertia, joint: Joint, g: f64) -> Model {
    let mut builder = ModelBuilder::new("single");
    builder.gravity(DVec3::NEG_Z * g);
    let body = builder.add_body("body", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, joint).unwrap();
    builder.build().unwrap()
}

fn free(inertia: Inertia) -> Model {
    single(inertia, Joint::new("free", JointKind::Free), 0.0)
}

fn run(model: &Model, state: &mut State, dt: f64, duration: f64, mut look: impl FnMut(&State)) {
    let (mut motion, input) = (FreeMotion::new(model), Input::default());
    let mut q = state.q.clone();
    for _ in 0..(duration / dt).round() as u64 {
        free_motion_into(model, &kinematics(model, state), state, &input, dt, &mut motion).unwrap();
        assert_eq!(motion.unresolved_rotations, 0);
        integrate_into(model, &state.q, &motion.free_velocity, dt, &mut q);
        std::mem::swap(&mut q, &mut state.q);
        state.v.copy_from_slice(&motion.free_velocity);
        state.time += dt;
        look(state);
    }
}

/// A T-handle: a rod of 0.1 kg and 12 cm along y whose middle carries another of 0.05 kg and 6 cm along x.
fn t_handle() -> Inertia {
    let (bar, stem) = (0.1 * 0.12 * 0.12 / 12.0, 0.05 * 0.06 * 0.06 / 12.0);
    let (mass, arm) = (0.15, 0.03);
    let x = 0.05 * arm / mass;
    let across = stem + 0.1 * x * x + 0.05 * (arm - x) * (arm - x);
    // Thin rods have no moment about their axis; a cross-section of 8 mm gives the stem's axis the smallest one.
    let thin = 1e-6;
    Inertia {
        mass,
        center_of_mass: DVec3::X * x,
        rotational: DMat3::from_diagonal(DVec3::new(bar + thin, across + thin, bar + across)),
    }
}

/// What `v` says about the angular momentum at the end of the step that it was the mean velocity of: the discrete momentum
/// `R D(−Δt ω) I ω` of the integrator, written with the inverse of `dexp(x) = ∫ exp(s x) ds` instead of its closed form.
fn discrete_momentum(rotation: DQuat, inertia: DMat3, omega: DVec3, dt: f64) -> DVec3 {
    const POINTS: [(f64, f64); 5] = [
        (0.046_910_077_030_668, 0.118_463_442_528_094_5),
        (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
        (0.5, 0.284_444_444_444_444_4),
        (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
        (0.953_089_922_969_332, 0.118_463_442_528_094_5),
    ];
    let mean = |x: DVec3| {
        POINTS.iter().map(|&(s, weight)| DMat3::from_quat(rotation_exp(x * s)) * weight).fold(DMat3::ZERO, |a, b| a + b)
    };
    // dexp of −x is the transpose of dexp of x.
    rotation * (mean(omega * -dt).transpose().inverse() * (inertia * omega))
}

#[test]
fn a_t_handle_tumbles_for_100_seconds_and_keeps_energy_and_momentum() {
    let inertia = t_handle();
    let middle = inertia.rotational.to_cols_array();
    assert!(middle[4] < middle[0] && middle[0] < middle[8], "x is the middle axis");
    let model = free(inertia);
    let (dt, spin) = (1e-3, 10.0);
    let mut state = State::new(&model);
    state.v = vec![0.0, 0.0, 0.0, spin, 0.01, 0.02];
    let energy = |state: &State| kinetic_energy(&model, &kinematics(&model, state), &state.v);
    let momentum = |state: &State| {
        let at = kinematics(&model, state);
        angular_momentum(&model, &at, center_of_mass(&model, &at))
    };
    let discrete = |state: &State| {
        let omega = DVec3::from_slice(&state.v[3..]);
        discrete_momentum(kinematics(&model, state).pose[1].rotation, inertia.rotational, omega, dt)
    };
    let (start_energy, start, start_discrete) = (energy(&state), momentum(&state), discrete(&state));
    let (mut worst_energy, mut worst, mut worst_discrete) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut flips, mut upright) = (0, true);
    run(&model, &mut state, dt, 100.0, |state| {
        worst_energy = worst_energy.max((energy(state) / start_energy - 1.0).abs());
        worst = worst.max((momentum(state) - start).length() / start.length());
        worst_discrete = worst_discrete.max((discrete(state) - start_discrete).length() / start.length());
        if (state.v[3] > 0.0) != upright {
            (flips, upright) = (flips + 1, !upright);
        }
    });
    assert!(flips > 10, "{flips} flips");
    assert!(worst_energy < 1e-5, "energy {worst_energy:e}");
    assert!(worst < 5e-3, "momentum {worst:e}");
    assert!(worst_discrete < 1e-12, "discrete momentum {worst_discrete:e}");
}

/// Halving Δt divides the error of the energy by four and that of the momentum read from `(q, v)` by two.
#[test]
fn energy_is_of_second_order_and_momentum_of_first() {
    let mut random = Random(71);
    let model = free(random.inertia());
    let mut start = State::new(&model);
    start.v = random.list(6, 3.0);
    let errors = |dt: f64| {
        let (mut state, mut worst) = (start.clone(), [0.0_f64; 2]);
        let at = kinematics(&model, &start);
        let momentum = angular_momentum(&model, &at, center_of_mass(&model, &at));
        let spin = |state: &State| {
            let omega = DVec3::from_slice(&state.v[3..]);
            0.5 * omega.dot(model.bodies[1].inertia.rotational * omega)
        };
        run(&model, &mut state, dt, 4.0, |state| {
            let at = kinematics(&model, state);
            let now = angular_momentum(&model, &at, center_of_mass(&model, &at));
            worst[0] = worst[0].max((spin(state) - spin(&start)).abs());
            worst[1] = worst[1].max((now - momentum).length());
        });
        worst
    };
    let (coarse, fine) = (errors(4e-3), errors(2e-3));
    let ratios = [coarse[0] / fine[0], coarse[1] / fine[1]];
    assert!((3.7..4.3).contains(&ratios[0]) && (1.9..2.1).contains(&ratios[1]), "{ratios:?}");
}

/// A symmetric body's axis goes round its angular momentum on a cone; the velocity belongs to the middle of the step before.
#[test]
fn a_symmetric_top_converges_to_its_closed_form() {
    let (across, along) = (0.4, 0.7);
    let rotational = DMat3::from_diagonal(DVec3::new(across, across, along));
    let model = free(Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational });
    let (omega, duration) = (DVec3::new(0.8, -0.5, 2.0), 3.0);
    let momentum = rotational * omega;
    // R(t) = exp(L t / across) exp(−(along − across)/across ω_z t z).
    let exact = |t: f64| {
        rotation_exp(momentum * (t / across)) * rotation_exp(DVec3::Z * ((across - along) / across * omega.z * t))
    };
    let error = |dt: f64| {
        let mut state = State::new(&model);
        // ω at half a step before the start.
        let turn = rotation_exp(DVec3::Z * ((along - across) / across * omega.z * 0.5 * dt));
        state.v[3..].copy_from_slice(&(turn.conjugate() * omega).to_array());
        run(&model, &mut state, dt, duration, |_| {});
        let rotation = kinematics(&model, &state).pose[1].rotation;
        (rotation * DVec3::Z - exact(duration) * DVec3::Z).length()
            + (rotation * DVec3::X - exact(duration) * DVec3::X).length()
    };
    let errors = [4e-3, 2e-3, 1e-3].map(error);
    assert!(errors[2] < 1e-5, "{errors:?}");
    for pair in errors.windows(2) {
        assert!((3.9..4.1).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

/// The centre of mass goes on in a straight line, however the body tumbles about it.
#[test]
fn an_offset_centre_of_mass_moves_straight() {
    // Turns of less and of more than a tenth of a radian in a step.
    for turn in [0.08, 0.6] {
        let mut random = Random(72);
        let model = free(random.inertia());
        let mut state = State::new(&model);
        state.v = random.list(6, 8.0);
        let dt = turn / DVec3::from_slice(&state.v[3..]).length();
        let center = |state: &State| kinematics(&model, state).center_of_mass[1];
        let mut places = vec![center(&state)];
        run(&model, &mut state, dt, 100.0 * dt, |state| places.push(center(state)));
        let step = (places[1] - places[0]).length();
        for i in 0..places.len() {
            let straight = places[0] + (places[1] - places[0]) * i as f64;
            assert!(
                (places[i] - straight).length() < 1e-12 * step.max(1.0),
                "step {i}: {:e}",
                (places[i] - straight).length()
            );
        }
    }
}

/// A body on a ball joint swings and spins in gravity; its energy does not drift.
#[test]
fn a_body_on_a_ball_joint_keeps_its_energy() {
    let mut random = Random(73);
    let joint = Joint::new("ball", JointKind::Ball).with_anchor(DVec3::new(0.1, -0.2, 0.4));
    let model = single(random.inertia(), joint, 9.81);
    let drift = |dt: f64| {
        let mut state = State::new(&model);
        state.v = vec![2.0, 9.0, -1.0];
        let energy = |state: &State| {
            let at = kinematics(&model, state);
            kinetic_energy(&model, &at, &state.v) + potential_energy(&model, &at, &state.q)
        };
        let start = energy(&state);
        let mut last = [0.0; 2];
        run(&model, &mut state, dt, 20.0, |state| {
            let half = usize::from(state.time > 10.0);
            last[half] = f64::max(last[half], (energy(state) - start).abs());
        });
        last.map(|error| error / start.abs())
    };
    let [early, late] = drift(1e-3);
    assert!(late < 1.3 * early && late < 1e-2, "{early:e} {late:e}");
}

/// Half a turn in a step is too much for the integrator: the body keeps its angular velocity and the count says so. About a
/// principal axis there is no gyroscopic torque at any speed.
#[test]
fn a_body_too_fast_for_the_step_is_counted() {
    let inertia = t_handle();
    let model = free(inertia);
    let spun = |omega: [f64; 3]| {
        let mut state = State::new(&model);
        state.v[3..].copy_from_slice(&omega);
        let mut motion = FreeMotion::new(&model);
        free_motion_into(&model, &kinematics(&model, &state), &state, &Input::default(), 1e-2, &mut motion).unwrap();
        let change: Vec<f64> = motion.free_velocity[3..].iter().zip(omega).map(|(a, b)| a - b).collect();
        (motion.unresolved_rotations, change.iter().fold(0.0_f64, |m, x| m.max(x.abs())))
    };
    let (count, change) = spun([300.0, 200.0, 100.0]);
    assert!(count == 1 && change < 1e-9, "{count} {change:e}");
    let (count, change) = spun([0.0, 0.0, 1e4]);
    assert!(count == 0 && change < 1e-7, "{count} {change:e}");
    let (count, change) = spun([150.0, 100.0, 50.0]);
    assert!(count == 0 && change > 1.0, "{count} {change:e}");
}

#[test]
fn every_body_too_fast_for_the_step_is_counted() {
    let mut builder = ModelBuilder::new("three");
    for name in ["a", "b", "c"] {
        let body = builder.add_body(name, BodyId::WORLD, Pose::IDENTITY, t_handle()).unwrap();
        builder.add_joint(body, Joint::new(name, JointKind::Free)).unwrap();
    }
    let model = builder.build().unwrap();
    let mut state = State::new(&model);
    for (body, omega) in [[300.0, 200.0, 100.0], [3.0, 2.0, 1.0], [100.0, 300.0, 200.0]].iter().enumerate() {
        state.v[6 * body + 3..6 * body + 6].copy_from_slice(omega);
    }
    let mut motion = FreeMotion::new(&model);
    free_motion_into(&model, &kinematics(&model, &state), &state, &Input::default(), 1e-2, &mut motion).unwrap();
    assert_eq!(motion.unresolved_rotations, 2);
}
