//! Robots and random trees against the numbers of Pinocchio and MuJoCo (`testdata/peers/make_numbers.py`).

use std::path::Path;

use signorini_multibody::glam::DMat3;
use signorini_multibody::{
    AxisRates, BodyId, Centroidal, Frame, JointKind, Kinematics, Model, ReferenceFrame, State, axis_rates_into,
    center_of_mass, centroidal_momentum_matrix_into, frame_jacobian_into, frame_jacobian_rate_into, kinetic_energy,
    potential_energy,
};

use crate::identities::{bias_force, forward_dynamics, inverse_dynamics, kinematics, mass_matrix};
use crate::random_model::Random;
use crate::tree_file::{numbers, read_tree};

/// Largest difference of a weighted sum, in terms of the largest entry that is summed.
const TOLERANCE: f64 = 1e-11;

const QUANTITIES: [&str; 12] = [
    "position",
    "rotation",
    "jacobian",
    "jacobian rate",
    "mass matrix",
    "bias force",
    "inverse dynamics",
    "forward dynamics",
    "centre of mass",
    "centroidal momentum matrix",
    "kinetic energy",
    "potential energy",
];

/// A robot as `make_numbers.py` writes it.
struct Robot {
    model: Model,
    seed: u64,
    /// Weighted sums of every quantity at every state.
    states: Vec<Vec<f64>>,
}

fn read(name: &str, text: &str) -> Robot {
    let lines = || text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let seed = lines().find(|words| words[0] == "seed").expect("a seed")[1].parse().unwrap();
    let states = lines().filter(|words| words[0] == "state").map(|words| numbers(&words[1..])).collect();
    Robot { model: read_tree(name, text), seed, states }
}

/// The states of `make_numbers.py`, from the same random numbers.
fn random_state(random: &mut Random, model: &Model) -> State {
    let mut q = Vec::new();
    for joint in &model.joints {
        match joint.kind {
            JointKind::Free => {
                q.extend(random.list(3, 1.5));
                q.extend(quaternion(random));
            }
            JointKind::Ball => q.extend(quaternion(random)),
            _ => q.push(random.uniform(-1.5, 1.5)),
        }
    }
    State::at(q, random.list(model.nv, 2.0))
}

fn quaternion(random: &mut Random) -> [f64; 4] {
    let x = random.list(4, 1.0);
    let (w, x, y, z) = (x[0] + 2.0, x[1], x[2], x[3]);
    let norm = (w * w + x * x + y * y + z * z).sqrt();
    [w, x, y, z].map(|x| x / norm)
}

/// Every quantity in the order of the file, as all its numbers row by row.
fn evaluate(model: &Model, at: &Kinematics, state: &State, acceleration: &[f64], force: &[f64]) -> [Vec<f64>; 12] {
    let mut rates = AxisRates::new(model);
    axis_rates_into(model, at, &state.v, &mut rates);
    let (mut jacobians, mut changes) = (Vec::new(), Vec::new());
    let mut matrix = vec![0.0; 6 * model.nv];
    for i in 1..model.bodies.len() {
        let frame = Frame::of_body(BodyId(i as u32));
        frame_jacobian_into(model, at, &frame, ReferenceFrame::LocalWorldAligned, &mut matrix);
        jacobians.extend_from_slice(&matrix);
        frame_jacobian_rate_into(model, at, &rates, &frame, ReferenceFrame::LocalWorldAligned, &mut matrix);
        changes.extend_from_slice(&matrix);
    }
    let mut centroidal = Centroidal::new(model);
    centroidal_momentum_matrix_into(model, at, &mut centroidal);
    let rows = |m: DMat3| m.transpose().to_cols_array();
    [
        at.pose[1..].iter().flat_map(|x| x.position.to_array()).collect(),
        at.pose[1..].iter().flat_map(|x| rows(x.rotation_matrix())).collect(),
        jacobians,
        changes,
        mass_matrix(model, at).matrix.to_dense(),
        bias_force(model, at),
        inverse_dynamics(model, at, acceleration),
        forward_dynamics(model, at, force),
        center_of_mass(model, at).to_array().to_vec(),
        centroidal.matrix,
        vec![kinetic_energy(model, at, &state.v)],
        vec![potential_energy(model, at, &state.q)],
    ]
}

/// The largest error over all states, and the quantity that has it.
fn compare(robot: &Robot) -> (f64, &'static str) {
    let (model, mut random) = (&robot.model, Random(robot.seed));
    let mut worst = (0.0, "");
    for stored in &robot.states {
        let state = random_state(&mut random, model);
        let (acceleration, force) = (random.list(model.nv, 5.0), random.list(model.nv, 20.0));
        let values = evaluate(model, &kinematics(model, &state), &state, &acceleration, &force);
        for ((values, expected), quantity) in values.iter().zip(stored).zip(QUANTITIES) {
            let scale = values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let sum: f64 = values.iter().map(|x| random.uniform(-1.0, 1.0) * x).sum();
            let error = (sum - expected).abs() / if scale > 0.0 { scale } else { 1.0 };
            if error.is_nan() || error > worst.0 {
                worst = (error, quantity);
            }
        }
    }
    worst
}

#[test]
fn robots_are_as_in_pinocchio_and_mujoco() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/peers");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "txt"));
    files.sort();
    assert!(files.len() >= 40, "only {} robots", files.len());
    for path in files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let robot = read(name, &std::fs::read_to_string(&path).unwrap());
        assert_eq!(robot.states.len(), 100, "{name}");
        let (error, quantity) = compare(&robot);
        println!("{name:20} nv {:3}  largest error {error:.1e} ({quantity})", robot.model.nv);
        assert!(error < TOLERANCE, "{name}: {quantity} is {error:e} off");
    }
}
