//! Derivatives of a step allocate nothing once their buffers have grown to the scene, where contact points have closed forms: the search
//! that others repeat with bodies displaced has memory of its own.

use signorini_derivatives::{StepDerivatives, Validity};
use signorini_formats::load_mjcf_str;
use signorini_lcp::Matrix;
use signorini_multibody::{Input, Model, State};
use signorini_simulation::{Settings, Workspace, step};
use signorini_testkit::{CountingAllocator, allocations};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Allocations of the derivatives of 60 steps after 60 for warming up, and how many of the derivatives exist.
fn allocations_of(model: Model) -> (usize, usize) {
    let settings = Settings::default();
    let (nv, nu) = (model.nv, model.actuators.len());
    let mut workspace = Workspace::new(&model, &settings).expect("a workspace");
    let mut derivatives = StepDerivatives::new(&model);
    let (mut by_state, mut by_control) = (Matrix::zeros(2 * nv, 2 * nv), Matrix::zeros(2 * nv, nu));
    let (mut state, mut input) = (State::new(&model), Input::of_control(vec![0.0; nu]));
    if let Some(key) = model.keyframes.first() {
        state.q.clone_from(&key.q);
        input.control[..key.control.len()].copy_from_slice(&key.control);
    }
    let mut next = state.clone();
    let (mut counted, mut given) = (0, 0);
    for n in 0..120 {
        let report = step(&model, &state, &input, &settings, &mut workspace, &mut next).expect("a step");
        let mut has_matrices = false;
        let own = allocations(|| {
            derivatives.compute(&model, (&state, &input), &settings, &report, &mut workspace);
            has_matrices = derivatives.matrices_into(&mut by_state, &mut by_control);
        });
        // What is refused says why, in a text.
        if n >= 60 && !matches!(derivatives.validity(), Validity::Refused { .. }) {
            (counted, given) = (counted + own, given + usize::from(has_matrices));
        }
        std::mem::swap(&mut state, &mut next);
    }
    (counted, given)
}

#[test]
fn derivatives_allocate_nothing_once_warm() {
    for name in ["quadruped", "incline", "spinning_top"] {
        let scene = signorini_scenes::named(name).expect("a scene");
        let (allocations, given) = allocations_of(load_mjcf_str(scene.text, ".").expect("a model").model);
        assert!(given > 30, "{name}: {given} derivatives");
        assert_eq!(allocations, 0, "{name}");
    }
    for text in [include_str!("../testdata/humanoid.xml"), include_str!("../testdata/four_bar.xml")] {
        let (allocations, given) = allocations_of(load_mjcf_str(text, ".").expect("a model").model);
        assert!(given > 20, "{given} derivatives");
        assert_eq!(allocations, 0);
    }
}

#[test]
fn the_counter_counts() {
    assert!(allocations(|| drop(std::hint::black_box(vec![1.0; 10]))) > 0);
}
