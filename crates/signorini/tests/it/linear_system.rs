//! The linear complementarity system of a step, and states stored with their warm start.

use signorini::lcp::{Lcp, Lemke, Method};
use signorini::multibody::{Input, State};
use signorini::{Settings, Workspace, linear_complementarity_system, step};

use crate::support::{bundled, run_certified};

#[test]
fn at_its_state_it_is_the_step() {
    for scene in ["incline", "quadruped", "spinning_top"] {
        let mut simulation = bundled(scene);
        run_certified(&mut simulation, 0.1);
        let (model, state, input) = (simulation.model().clone(), simulation.state().clone(), simulation.input.clone());
        let system = linear_complementarity_system(&model, &state, &input, &Settings::default()).unwrap();
        let plus = |constant: &[f64], matrix: &signorini::lcp::Matrix, x: &[f64]| -> Vec<f64> {
            let mut product = vec![0.0; constant.len()];
            matrix.multiply_into(x, &mut product);
            constant.iter().zip(product).map(|(c, p)| c + p).collect()
        };
        let right_hand_side = plus(&plus(&system.c, &system.E, &system.x), &system.H, &system.u);
        let scaling = system.problem.standard_lcp().unwrap().scaling().clone();
        let lcp = Lcp::with_scaling(system.F.clone(), right_hand_side, scaling).unwrap();
        let solution = Lemke::default().solve(&lcp, None);
        assert!(solution.status.is_solved(), "{scene}: {:?}", solution.status);
        let free = plus(&plus(&system.d, &system.A, &system.x), &system.B, &system.u);
        let next = plus(&free, &system.D, &solution.z);
        simulation.step().unwrap();
        for (k, v) in simulation.state().v.iter().enumerate() {
            assert!((next[model.nv + k] - v).abs() < 1e-8, "{scene}, velocity {k}: {} and {v}", next[model.nv + k]);
        }
    }
}

/// A state stored with its warm start goes on with the same bits.
#[test]
fn a_stored_warm_start_goes_on_with_the_same_bits() {
    let simulation = bundled("house_of_cards");
    let (model, settings, input) = (simulation.model().clone(), Settings::default(), Input::default());
    let mut workspace = Workspace::new(&model, &settings).unwrap();
    let (mut state, mut next) = (simulation.state().clone(), simulation.state().clone());
    state.v[6] = 0.3;
    let mut advance = |state: &mut State, workspace: &mut Workspace, steps: usize| {
        for _ in 0..steps {
            step(&model, state, &input, &settings, workspace, &mut next).unwrap();
            std::mem::swap(state, &mut next);
        }
    };
    advance(&mut state, &mut workspace, 20);
    let (stored, warm) = (state.clone(), workspace.warm_start());
    advance(&mut state, &mut workspace, 20);
    let mut other = Workspace::new(&model, &settings).unwrap();
    let mut resumed = stored.clone();
    other.set_warm_start(&warm).unwrap();
    advance(&mut resumed, &mut other, 20);
    assert_eq!(state, resumed);

    for (damage, value) in [(0, 1.5), (1, 0.5), (2, 0.5), (3 * warm[1] as usize + 2, 0.5), (warm.len() - 1, 0.5)] {
        let mut damaged = warm.clone();
        damaged[damage] = value;
        let kept = other.warm_start();
        if damage + 1 < warm.len() {
            assert!(other.set_warm_start(&damaged).is_err(), "entry {damage}");
            assert_eq!(other.warm_start(), kept);
        }
        assert!(other.set_warm_start(&warm[..damage]).is_err());
    }
}
