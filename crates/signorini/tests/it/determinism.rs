//! The same run again.

use std::sync::Arc;

use signorini::lcp::{LemkeSettings, MethodKind};
use signorini::multibody::{Kinematics, Parameter, ParameterChange, State, forward_kinematics_into};
use signorini::{ContactMethod, Settings, Simulation, Workspace, step};

use crate::invariants::balls_in_a_bin;
use crate::support::{bits, bundled, run_certified, run_observed};

fn difference(a: &State, b: &State) -> f64 {
    let values = |s: &State| s.q.iter().chain(&s.v).copied().collect::<Vec<_>>();
    values(a).iter().zip(values(b)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn same_input_same_bits() {
    let starts: [fn() -> Simulation; 3] =
        [|| balls_in_a_bin(30), || bundled("house_of_cards"), || bundled("quadruped")];
    for start in starts {
        let (mut first, mut second) = (start(), start());
        run_certified(&mut first, 0.4);
        run_certified(&mut second, 0.4);
        assert_eq!(bits(first.state()), bits(second.state()));
    }
}

/// Going on from a stored state, without the warm start, gives the same motion.
#[test]
fn a_restored_state_goes_on_alike() {
    let starts: [fn() -> Simulation; 3] = [|| bundled("incline"), || bundled("quadruped"), || bundled("gripper")];
    for start in starts {
        let (mut whole, mut resumed) = (start(), start());
        run_certified(&mut whole, 0.25);
        resumed.set_state(&whole.state().clone()).unwrap();
        run_certified(&mut whole, 0.25);
        run_certified(&mut resumed, 0.25);
        let apart = difference(whole.state(), resumed.state());
        assert!(apart < 1e-9, "{apart:e}");
    }
}

/// Lemke's method on the standard LCP finds the motion that the structured solver finds. (The gripper is not among the
/// scenes: while its fingers slide up the box as they close, how they press is not unique, nor is the velocity.)
#[test]
fn lemke_moves_it_alike() {
    for scene in ["incline", "quadruped", "spinning_top"] {
        let mut structured = bundled(scene);
        let method = ContactMethod::Lcp(MethodKind::Lemke(LemkeSettings::default()));
        let settings = Settings::default().with_method(method);
        let mut lemke = Simulation::new(structured.model().clone(), settings).unwrap();
        lemke.set_state(&structured.state().clone()).unwrap();
        lemke.input = structured.input.clone();
        run_observed(&mut structured, 0.2, |_, _| {});
        run_observed(&mut lemke, 0.2, |_, _| {});
        let apart = difference(structured.state(), lemke.state());
        assert!(apart < 1e-8, "{scene}: {apart:e}");
    }
}

/// Kinematics that a question between two steps has found are those that the step finds: of the state at hand, of another one, of other numbers
/// of the model, of bodies that are moved from outside.
#[test]
fn looking_ahead_changes_no_bit() {
    let pushed = "<mujoco><worldbody><geom type='plane' size='5 5 1'/><body mocap='true' pos='0 0 0.1'><geom type='box' size='.1 .1 .1'/></body>
        <body pos='0.19 0 0.1'><freejoint/><geom type='box' size='.1 .1 .1'/></body></worldbody></mujoco>";
    let pushed = Simulation::new(signorini_formats::load_mjcf_str(pushed, "").unwrap().model, Settings::default());
    for start in [bundled("quadruped"), bundled("gripper"), pushed.unwrap()] {
        let mut model = Arc::new(start.model().clone());
        let (mut state, mut input) = (start.state().clone(), start.input.clone());
        let settings = Settings::default();
        let [mut plain, mut asked] = [0, 1].map(|_| Workspace::new(&model, &settings).unwrap());
        let (mut next, mut same) = (state.clone(), state.clone());
        for k in 0..60 {
            input.mocap.iter_mut().for_each(|pose| pose.position.x += 1e-4);
            if k % 3 > 0 {
                asked.look_ahead(&model, &state, &input);
                let mut expected = Kinematics::new(&model);
                expected.place_mocap(&model, &input);
                forward_kinematics_into(&model, &state.q, &state.v, &mut expected);
                assert_eq!(format!("{:?}", asked.ahead()), format!("{expected:?}"));
            }
            if k % 7 == 6 {
                asked.look_ahead(&model, &next_to(&state), &input);
            }
            if k % 20 == 19 {
                asked.look_ahead(&model, &state, &input);
                let mut centers = model.parameter(Parameter::BodyCenter);
                centers[3 * (model.bodies.len() - 1)] += 1e-3;
                let changes: [ParameterChange; 1] = [(Parameter::BodyCenter, &centers)];
                plain.change(&mut model.clone(), &settings, &changes).unwrap();
                asked.change(&mut model, &settings, &changes).unwrap();
            }
            step(&model, &state, &input, &settings, &mut plain, &mut next).unwrap();
            step(&model, &state, &input, &settings, &mut asked, &mut same).unwrap();
            assert_eq!(format!("{:?}", plain.kinematics()), format!("{:?}", asked.kinematics()), "step {k}");
            assert_eq!(bits(&next), bits(&same), "step {k}");
            std::mem::swap(&mut state, &mut next);
        }
    }
}

/// A state that differs from another one in a last digit.
fn next_to(state: &State) -> State {
    let mut other = state.clone();
    other.q[0] = other.q[0].next_up();
    other
}
