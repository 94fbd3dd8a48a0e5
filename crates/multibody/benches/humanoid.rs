//! How fast are the algorithms on a robot of `testdata/peers`? Prints one line "name nanoseconds" for each; the other side
//! and the comparison are in `benchmarks/dynamics`.
//!
//!     humanoid FILE               times every algorithm
//!     humanoid FILE NAME CALLS    makes CALLS calls of one, for callgrind
//!
//! As in Pinocchio's functions, kinematics are part of every algorithm but `factor` and `solve`.

use std::hint::black_box;
use std::time::Instant;

#[path = "../tests/it/tree_file.rs"]
mod tree_file;

use signorini_multibody::{
    ArticulatedBodies, BodyId, Centroidal, Frame, Kinematics, MassMatrix, NewtonEuler, ReferenceFrame, State,
    centroidal_momentum_matrix_into, forward_dynamics_into, forward_kinematics_into, frame_jacobian_into,
    integrate_into, inverse_dynamics_into, mass_matrix_into,
};

const NAMES: [&str; 8] = ["kinematics", "rnea", "crba", "aba", "factor", "solve", "jacobian", "centroidal"];

/// A closure that makes one call of the algorithm.
fn algorithm(model: &signorini_multibody::Model, name: &str) -> Box<dyn FnMut()> {
    let model = model.clone();
    let nv = model.nv;
    let list = |f: &dyn Fn(f64) -> f64| (0..nv).map(|k| f(k as f64)).collect::<Vec<f64>>();
    let v = list(&|k| 0.7 * (k + 1.0).sin());
    let acceleration = list(&|k| 2.0 * (k + 1.0).cos());
    let tau = list(&|k| 5.0 * (2.0 * k).sin());
    let start = State::new(&model);
    let mut q = start.q.clone();
    integrate_into(&model, &start.q, &v, 1.0, &mut q);
    let mut at = Kinematics::new(&model);
    forward_kinematics_into(&model, &q, &v, &mut at);
    let mut mass = MassMatrix::new(&model);
    mass_matrix_into(&model, &at, &mut mass);
    let mut factor = mass.matrix.factor().unwrap();
    let mut out = vec![0.0; nv];
    match name {
        "kinematics" => Box::new(move || forward_kinematics_into(&model, black_box(&q), &v, &mut at)),
        "rnea" => {
            let mut work = NewtonEuler::new(&model);
            Box::new(move || {
                forward_kinematics_into(&model, black_box(&q), &v, &mut at);
                inverse_dynamics_into(&model, &at, &acceleration, &mut work, &mut out);
            })
        }
        "crba" => Box::new(move || {
            forward_kinematics_into(&model, black_box(&q), &v, &mut at);
            mass_matrix_into(&model, &at, &mut mass);
        }),
        "aba" => {
            let mut work = ArticulatedBodies::new(&model);
            Box::new(move || {
                forward_kinematics_into(&model, black_box(&q), &v, &mut at);
                forward_dynamics_into(&model, &at, &tau, &mut work, &mut out).unwrap();
            })
        }
        "factor" => Box::new(move || factor.refactor(black_box(&mass.matrix)).unwrap()),
        "solve" => Box::new(move || {
            out.copy_from_slice(black_box(&v));
            factor.solve_in_place(&mut out);
        }),
        "jacobian" => {
            let frame = Frame::of_body(BodyId(model.bodies.len() as u32 - 1));
            let mut matrix = vec![0.0; 6 * nv];
            Box::new(move || {
                forward_kinematics_into(&model, black_box(&q), &v, &mut at);
                frame_jacobian_into(&model, &at, &frame, ReferenceFrame::LocalWorldAligned, &mut matrix);
            })
        }
        "centroidal" => {
            let mut centroidal = Centroidal::new(&model);
            Box::new(move || {
                forward_kinematics_into(&model, black_box(&q), &v, &mut at);
                centroidal_momentum_matrix_into(&model, &at, &mut centroidal);
            })
        }
        other => panic!("no algorithm '{other}'; there are {NAMES:?}"),
    }
}

/// Best time of a call, ns. Rounds are short so that some are not interrupted on a busy machine.
fn time(mut call: impl FnMut()) -> f64 {
    const CALLS: u32 = 50;
    let round = |call: &mut dyn FnMut()| {
        let start = Instant::now();
        (0..CALLS).for_each(|_| call());
        start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    (0..600).map(|_| round(&mut call)).fold(f64::INFINITY, f64::min)
}

fn main() {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/peers/talos.txt");
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let path = arguments.first().map_or(default, String::as_str);
    let model = tree_file::read_tree("robot", &std::fs::read_to_string(path).expect("a file of testdata/peers"));
    if let [_, name, calls] = &arguments[..] {
        let mut call = algorithm(&model, name);
        (0..calls.parse::<u64>().expect("a number of calls")).for_each(|_| call());
        return;
    }
    for name in NAMES {
        println!("{name} {:.1}", time(algorithm(&model, name)));
    }
}
