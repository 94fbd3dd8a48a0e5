//! A drum that fifty bodies tumble in: what a run does whose contacts jam between walls, paddles and each other all the time.

use std::f64::consts::TAU;
use std::fmt::Write;

use signorini::multibody::glam::DQuat;
use signorini::{InfeasiblePolicy, RunEnd, Settings, Simulation};
use signorini_formats::load_mjcf_str;
use signorini_testkit::Random;

const RADIUS: f64 = 0.28;
const SIDES: u32 = 10;
const PADDLES: u32 = 3;

/// The walls and paddles of the drum, and fifty boxes, balls, capsules and cylinders on a grid within it.
fn drum(random: &mut Random) -> String {
    let mut text = String::from(
        "<mujoco><option timestep='0.002'/><default><geom friction='0.5 0 0' condim='3'/></default><worldbody>\
         <body pos='0 0 1'><joint name='turn' axis='0 1 0'/>",
    );
    let length = RADIUS * (0.5 * TAU / f64::from(SIDES)).tan() + 0.01;
    let parts = (0..SIDES).map(|k| (k, SIDES, RADIUS + 0.02, [0.02, 0.3, length]));
    for (k, of, distance, size) in parts.chain((0..PADDLES).map(|k| (k, PADDLES, RADIUS - 0.04, [0.05, 0.28, 0.008]))) {
        let turn = TAU * f64::from(k) / f64::from(of);
        let (x, z) = (distance * turn.cos(), distance * turn.sin());
        let [a, b, c] = size;
        let plate = format!("size='{a} {b} {c}' pos='{x} 0 {z}' euler='0 {} 0'", -turn.to_degrees());
        write!(text, "<geom type='box' {plate} density='3000'/>").unwrap();
    }
    for side in [-0.32, 0.32] {
        write!(text, "<geom type='box' size='0.33 0.02 0.33' pos='0 {side} 0' density='3000'/>").unwrap();
    }
    text.push_str("</body>");
    for k in 0..50_u32 {
        let place = [k % 4, k / 4 % 4, k / 16].map(|i| (f64::from(i) - 1.5) * 0.083);
        let DQuat { x, y, z, w } = DQuat::from_mat3(&random.rotation());
        let mut half = || random.between(0.018, 0.034);
        let shape = match k % 4 {
            0 => format!("type='box' size='{} {} {}'", half(), half(), half()),
            1 => format!("type='sphere' size='{}'", half()),
            2 => format!("type='capsule' size='{} {}'", 0.5 * half(), 0.6 * half()),
            _ => format!("type='cylinder' size='{} {}'", 0.7 * half(), 0.6 * half()),
        };
        let friction = random.between(0.2, 0.9);
        let [px, py, pz] = place;
        write!(text, "<body pos='{px} {py} {}' quat='{w} {x} {y} {z}'><freejoint/>", 1.0 + pz).unwrap();
        write!(text, "<geom {shape} density='1000' friction='{friction} 0 0'/></body>").unwrap();
    }
    text + "</worldbody><actuator><velocity joint='turn' kv='2000'/></actuator></mujoco>"
}

/// Runs; the work of each step in factorisations and pivots, each step counted once more for what it has anyway.
fn work_of_steps(policy: InfeasiblePolicy, seed: u64, duration: f64) -> Vec<u64> {
    let model = load_mjcf_str(&drum(&mut Random::new(seed)), "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default().with_infeasible(policy)).unwrap();
    simulation.input.control = vec![2.5];
    let mut work = Vec::new();
    let end = simulation.run(duration, |_, report| {
        work.push(1 + u64::from(report.solver.factorizations) + u64::from(report.solver.lemke_pivots));
        report.certificate.holds(1e-9)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "seed {seed}: {:?}", simulation.report());
    work
}

/// Neither policy stops or misses a step, and no step costs a thousand times what most do.
#[test]
fn a_drum_of_fifty_turns_to_the_end_at_bounded_cost() {
    for (policy, seed, duration) in [(InfeasiblePolicy::GoOn, 51, 4.0), (InfeasiblePolicy::ClipGaps, 52, 0.3)] {
        let mut work = work_of_steps(policy, seed, duration);
        work.sort_unstable();
        let (median, most) = (work[work.len() / 2], work[work.len() - 1]);
        println!("{policy:?}: median {median}, most {most}, all {}", work.iter().sum::<u64>());
        assert!(most <= 1000 * median, "{policy:?}: {most} in one step, {median} in most");
    }
}
