//! Derivatives to one side at ties, against differences to that side.

use crate::common::{Bench, model_of, random_vector};
use signorini_derivatives::Validity;
use signorini_multibody::difference_into;
use signorini_multibody::{Input, State};
use signorini_simulation::Settings;
use signorini_testkit::Random;

/// Compares the derivative along random changes with `(f(x + h d) − f(x))/h`, extrapolated.
fn compare(bench: &mut Bench, state: &State, input: &Input, seed: u64) -> usize {
    let next = bench.differentiate(state, input).expect("a step");
    assert!(matches!(bench.derivatives.validity(), Validity::OneSided { .. }), "{:?}", bench.derivatives.validity());
    let mut random = Random::new(seed);
    let nv = bench.model.nv;
    let mut kinds = std::collections::HashSet::new();
    for _ in 0..40 {
        let mut change = random_vector(&mut random, nv, 0.01);
        change.extend(random_vector(&mut random, nv, 1.0));
        change.extend(random_vector(&mut random, bench.model.actuators.len(), 1.0));
        change.extend(random_vector(&mut random, nv, 1.0));
        bench.differentiate(state, input).expect("a step");
        let expected = bench.derivatives.directional(&change).expect("a derivative along the change");
        let mut slope = |h: f64| {
            let (near, with) = bench.moved(state, input, &change, h);
            let (q, v, signature) = bench.end(&near, &with);
            let mut place = vec![0.0; nv];
            difference_into(&bench.model, &q, &next.q, &mut place);
            place.extend(v.iter().zip(&next.v).map(|(a, b)| a - b));
            place.iter_mut().for_each(|x| *x /= h);
            (place, signature)
        };
        let ((coarse, _), (fine, signature)) = (slope(2e-6), slope(1e-6));
        kinds.insert(signature);
        let size = expected.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        let off = fine.iter().zip(&coarse).map(|(f, c)| 2.0 * f - c).zip(&expected);
        let off = off.fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
        assert!(off < 1e-6 * size, "{off:.1e} of {size:.1e}");
    }
    kinds.len()
}

const BALL: &str = "<mujoco><option timestep='0.01'/><worldbody><geom type='plane' friction='0.4'/>
  <body pos='0 0 0.1'><freejoint/><geom size='0.1' mass='2'/></body></worldbody></mujoco>";

#[test]
fn a_ball_that_touches_without_impulse_sticks_slides_or_leaves() {
    let mut bench = Bench::new(model_of(BALL), Settings::default());
    let (mut state, input) = bench.start();
    state.v[2] = 0.0981;
    assert!(compare(&mut bench, &state, &input, 1) >= 3);
}

#[test]
fn a_ball_that_slides_and_touches_without_impulse() {
    let mut bench = Bench::new(model_of(BALL), Settings::default());
    let (mut state, input) = bench.start();
    state.v.copy_from_slice(&[1.0, 0.3, 0.0981, 0.2, 0.1, 0.3]);
    assert!(compare(&mut bench, &state, &input, 2) >= 2);
}

const POINT: &str = "<mujoco><option timestep='0.01'/><worldbody><geom type='plane' friction='0.4'/>
  <body pos='0 0 0.1'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/><joint type='slide' axis='0 0 1'/>
  <geom size='0.1' mass='2' friction='0.4'/></body></worldbody></mujoco>";

#[test]
fn a_mass_that_is_pulled_as_hard_as_friction_holds() {
    let mut bench = Bench::new(model_of(POINT), Settings::default());
    let (state, mut input) = bench.start();
    // At a corner of the polygon, and in the middle of one of its edges.
    for angle in [0.0_f64, std::f64::consts::PI / 8.0] {
        let reach = if angle == 0.0 { 1.0 } else { angle.cos() };
        let force = 0.4 * 2.0 * 9.81 * reach;
        input.generalized_force = vec![force * angle.cos(), force * angle.sin(), 0.0];
        assert!(compare(&mut bench, &state, &input, 3) >= 2);
    }
}
