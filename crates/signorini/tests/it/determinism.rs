//! The same run again.

use signorini::lcp::{LemkeSettings, MethodKind};
use signorini::multibody::State;
use signorini::{ContactMethod, Settings, Simulation};

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
