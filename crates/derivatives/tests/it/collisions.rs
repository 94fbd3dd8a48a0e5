//! Balls on a line that hit each other, pushed so that the last one arrives at a place with little effort: optima in closed form, found by
//! the derivatives of the steps.
//!
//! The problems are those of Y. D. Zhong, J. Han, G. O. Brikis, *Differentiable physics simulations with contacts: do they have correct
//! gradients w.r.t. position, velocity and control?* (2022): one collision and several, minimise `½ ε ∫ u² dt + ½ (x(T) − target)²`.

use crate::common::Bench;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{BodyId, Geom, Geometry, Inertia, Input, Joint, Model, ModelBuilder, Pose, State};
use signorini_simulation::Settings;

const RADIUS: f64 = 0.1;
const EFFORT: f64 = 0.02;
const TARGET: f64 = 3.0;
const DURATION: f64 = 1.0;

/// Balls of mass 1 at the places given, free to move along x, without gravity.
fn balls(places: &[f64], restitution: f64, timestep: f64) -> Model {
    let mut world = ModelBuilder::new("balls");
    world.gravity(DVec3::ZERO).timestep(timestep);
    for (i, x) in places.iter().enumerate() {
        let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY * 0.004 };
        let place = Pose::from_position(DVec3::new(*x, 0.0, 0.0));
        let body = world.add_body(format!("ball{i}"), BodyId::WORLD, place, inertia).expect("a body");
        world.add_joint(body, Joint::slide(format!("x{i}"), DVec3::X)).expect("a joint");
        let sphere = Geom::new(format!("sphere{i}"), Geometry::Sphere { radius: RADIUS });
        world.add_geom(body, sphere.with_friction(0.0).with_restitution(restitution)).expect("a geom");
    }
    world.build().expect("a model")
}

/// A force on the first ball.
fn pushing(nv: usize, force: f64) -> Input {
    let mut input = Input::default();
    input.generalized_force = vec![0.0; nv];
    input.generalized_force[0] = force;
    input
}

/// Where the last ball arrives, and how that changes with the force on the first ball in each step; all steps have to have a derivative.
fn arrival(bench: &mut Bench, places: &[f64], forces: &[f64]) -> (f64, Vec<f64>) {
    let nv = bench.model.nv;
    bench.workspace.clear_warm_start();
    let (mut state, mut steps) = (State::new(&bench.model), Vec::new());
    for force in forces {
        let input = pushing(nv, *force);
        let next = bench.differentiate(&state, &input).expect("a step");
        assert!(bench.is_exact(), "{:?}", bench.derivatives.validity());
        steps.push(bench.derivatives.clone());
        state = next;
    }
    let mut gradient = vec![0.0; 2 * nv];
    gradient[nv - 1] = 1.0;
    let mut slopes = vec![0.0; forces.len()];
    for (derivatives, slope) in steps.iter().zip(&mut slopes).rev() {
        let back = derivatives.transposed_product(&gradient).expect("a derivative");
        *slope = back[2 * nv];
        gradient.copy_from_slice(&back[..2 * nv]);
    }
    (places[nv - 1] + state.q[nv - 1], slopes)
}

/// Gauss and Newton's method: the least of `½ ε Δt Σ u² + ½ (x + s (u′ − u) − target)²`, again and again.
fn optimum(bench: &mut Bench, places: &[f64], mut forces: Vec<f64>) -> Vec<f64> {
    let weight = EFFORT * bench.model.timestep;
    for _ in 0..20 {
        let (x, slopes) = arrival(bench, places, &forces);
        let square: f64 = slopes.iter().map(|s| s * s).sum();
        let own: f64 = slopes.iter().zip(&forces).map(|(s, u)| s * u).sum();
        let miss = (x - own - TARGET) / (1.0 + square / weight);
        let next: Vec<f64> = slopes.iter().map(|s| -miss * s / weight).collect();
        let change = next.iter().zip(&forces).fold(0.0, |c: f64, (a, b)| c.max((a - b).abs()));
        forces = next;
        if change < 1e-10 {
            break;
        }
    }
    forces
}

/// The optimum where `x(T) = begin + Σ b_j u_j`.
fn linear_optimum(begin: f64, b: &[f64], timestep: f64) -> Vec<f64> {
    let weight = EFFORT * timestep;
    let miss = (begin - TARGET) / (1.0 + b.iter().map(|b| b * b).sum::<f64>() / weight);
    b.iter().map(|b| -miss * b / weight).collect()
}

fn assert_same(found: &[f64], expected: &[f64]) {
    let size = expected.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    let off = found.iter().zip(expected).fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
    assert!(off <= 1e-6 * size, "{:.1e} of the largest force", off / size);
}

/// Without rebound the two go on together: their common centre moves as if nothing had happened, `x₂(T) = X(T) + r` with
/// `X(T) = X(0) + ½ ∫ (T − t) u dt`, and the optimum is `u ∝ T − t`, also that of continuous time.
#[test]
fn one_collision_without_rebound() {
    let places = [0.0, 0.55];
    let n = 50;
    let dt = DURATION / n as f64;
    let mut bench = Bench::new(balls(&places, 0.0, dt), Settings::default());
    let found = optimum(&mut bench, &places, vec![4.0; n]);
    let b: Vec<f64> = (0..n).map(|j| 0.5 * dt * dt * (n - j) as f64).collect();
    let begin = 0.5 * (places[0] + places[1]) + RADIUS;
    assert_same(&found, &linear_optimum(begin, &b, dt));
    // u(0) = (target − begin) (T/2) / (ε + T³/12) for ever shorter steps.
    let continuous = (TARGET - begin) * 0.5 * DURATION / (EFFORT + DURATION.powi(3) / 12.0);
    assert!((found[0] - continuous).abs() < 1.5 * dt * continuous, "{} for {continuous}", found[0]);
}

/// The same with three: what is pushed in the end is the mass of all.
#[test]
fn several_collisions_without_rebound() {
    let places = [0.0, 0.45, 0.85];
    let n = 50;
    let dt = DURATION / n as f64;
    let mut bench = Bench::new(balls(&places, 0.0, dt), Settings::default());
    let found = optimum(&mut bench, &places, vec![8.0; n]);
    let b: Vec<f64> = (0..n).map(|j| dt * dt * (n - j) as f64 / 3.0).collect();
    let begin = places.iter().sum::<f64>() / 3.0 + 2.0 * RADIUS;
    assert_same(&found, &linear_optimum(begin, &b, dt));
}

/// The steps in which ball `i` is hit, one for each but the first, from the velocities of a rollout.
fn hits(bench: &mut Bench, forces: &[f64]) -> Vec<usize> {
    let nv = bench.model.nv;
    let (mut state, mut found) = (State::new(&bench.model), vec![usize::MAX; nv]);
    for (k, force) in forces.iter().enumerate() {
        let input = pushing(nv, *force);
        let next = bench.differentiate(&state, &input).expect("a step");
        for i in 1..nv {
            if state.v[i] == 0.0 && next.v[i] > 0.0 {
                found[i] = found[i].min(k);
            }
        }
        state = next;
    }
    found[1..].to_vec()
}

/// With full rebound a ball hands on its velocity in the step of the impact, of which what pushes in that step counts by half:
/// `x(T) = x(0) + Δt (N − K) Δt (Σ_{j<k} u_j + ½ u_k)` where the first impact is in step `k` and the last in step `K`. Forces after the first
/// impact do nothing and vanish. The optimum is that of impacts in these steps: a step puts an impact at its beginning, and does not know
/// when within it it happened. Where the ball arrives just as a step begins, the derivative is refused: the impact is in this step or the next.
fn with_rebound(places: &[f64], push: f64) {
    let n = 60;
    let dt = DURATION / n as f64;
    let mut bench = Bench::new(balls(places, 1.0, dt), Settings::default());
    let found = optimum(&mut bench, places, vec![push; n]);
    let steps = hits(&mut bench, &found);
    let (first, last) = (steps[0], steps[steps.len() - 1]);
    let share = |j: usize| {
        if j < first {
            1.0
        } else if j == first {
            0.5
        } else {
            0.0
        }
    };
    let b: Vec<f64> = (0..n).map(|j| dt * dt * (n - last) as f64 * share(j)).collect();
    assert_same(&found, &linear_optimum(places[places.len() - 1], &b, dt));
}

#[test]
fn one_collision_with_rebound() {
    with_rebound(&[0.0, 0.5], 12.0);
}

#[test]
fn several_collisions_with_rebound() {
    with_rebound(&[0.0, 0.5, 0.93], 12.0);
}
