//! Mass ratios up to 1e9, long chains, needles and dust: what is not solved says so, nothing is denied, and no step goes on to continuation where
//! only the last digits of impulses are missing.

use signorini::contact::SolveStatus;
use signorini::multibody::glam::DVec3;
use signorini::{ImpulseChoice, Settings, Simulation};
use signorini_formats::load_mjcf_str;

use crate::support::{World, velocity};

const STEPS: u32 = 60;
const DT: f64 = 0.002;
const HALF: f64 = 0.1;

/// The mass of each box, from the lowest, kg.
type Masses = Box<dyn Fn(usize) -> f64>;

/// What ten boxes of these masses, from the lowest, come to.
struct Stack {
    /// Factorisations of all steps, each counted once more for the work that a step has anyway.
    work: u64,
    missed: u64,
    worst: f64,
    fastest: f64,
}

fn stack(mass: impl Fn(usize) -> f64) -> Stack {
    let mut world = World::upright(DT, 0.5);
    world.floor();
    for k in 0..10 {
        world.free_box(DVec3::splat(HALF), mass(k), DVec3::Z * HALF * (2 * k + 1) as f64);
    }
    let mut simulation = world.simulation(Settings::default());
    let mut work = 0;
    for _ in 0..STEPS {
        let report = simulation.step().expect("a step");
        let is_open = !matches!(report.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        assert!(report.advanced() && is_open, "denied: {:?}", report.status);
        assert_eq!(report.missed_tolerance, report.status != SolveStatus::Solved);
        work += 1 + u64::from(report.solver.factorizations) + u64::from(report.solver.lemke_pivots);
    }
    let summary = simulation.summary();
    let fastest = (0..10).map(|k| velocity(&simulation, k).length()).fold(0.0, f64::max);
    Stack { work, missed: summary.missed_steps, worst: summary.worst.worst(), fastest }
}

#[test]
fn stacks_of_ten_of_any_mass_ratio_stand_at_bounded_cost() {
    let even = stack(|_| 1.0);
    assert_eq!(even.missed, 0);
    for exponent in [3, 6, 9] {
        let r = 10_f64.powi(exponent);
        let kinds: [(&str, Masses); 5] = [
            ("heavy on top", Box::new(move |k| if k == 9 { r } else { 1.0 })),
            ("heavy below", Box::new(move |k| if k == 0 { r } else { 1.0 })),
            ("in turn", Box::new(move |k| if k % 2 == 1 { r } else { 1.0 })),
            ("growing", Box::new(move |k| r.powf(k as f64 / 9.0))),
            ("shrinking", Box::new(move |k| r.powf(1.0 - k as f64 / 9.0))),
        ];
        for (name, mass) in kinds {
            let found = stack(mass);
            println!(
                "1e{exponent} {name}: work {} of {}, {} missed, {:.1e}",
                found.work, even.work, found.missed, found.worst
            );
            // Below 1e9 everything is solved; there the last digits of the impulses are the residual.
            assert!(found.work <= 100 * even.work, "1e{exponent} {name}: {} times the work", found.work / even.work);
            assert!(exponent == 9 || found.missed == 0, "1e{exponent} {name}: {} missed", found.missed);
            assert!(found.worst < 1e-5, "1e{exponent} {name}: {:e}", found.worst);
            // It stands: gravity gives 0.02 m/s in a step.
            assert!(found.fastest < 1e-6, "1e{exponent} {name}: moves at {:e} m/s", found.fastest);
        }
    }
}

/// What a scene that is read from MJCF comes to in so many steps: the work as for stacks, and the fastest speed of all.
fn run(text: &str, steps: u32, name: &str) -> Stack {
    let mut simulation = Simulation::new(load_mjcf_str(text, "").unwrap().model, Settings::default()).unwrap();
    let (mut work, mut fastest) = (0, 0.0_f64);
    for step in 0..steps {
        let report = simulation.step().expect("a step");
        let is_open = !matches!(report.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        assert!(report.advanced() && is_open, "{name}, step {step} denied: {:?}", report.status);
        work += 1 + u64::from(report.solver.factorizations) + u64::from(report.solver.lemke_pivots);
        fastest = simulation.state().v.iter().fold(fastest, |most, v| most.max(v.abs()));
    }
    let summary = simulation.summary();
    Stack { work, missed: summary.missed_steps, worst: summary.worst.worst(), fastest }
}

/// A hundred free boxes in a row from the world on, each tied to the one before by two points of a hinge's axis; the last one weighs `end`, the
/// others a kilogram.
fn chain(end: f64) -> String {
    let (mut bodies, mut ties) = (String::new(), String::new());
    for k in 0..100 {
        let mass = if k == 99 { end } else { 1.0 };
        let x = 0.1 * (f64::from(k) + 0.5);
        bodies += &format!(
            "<body name='b{k}' pos='{x} 0 0'><freejoint/><geom type='box' size='.045 .02 .02' mass='{mass}'/></body>"
        );
        let before = if k == 0 { String::new() } else { format!("body2='b{}'", k - 1) };
        for y in [-0.02, 0.02] {
            ties += &format!("<connect body1='b{k}' {before} anchor='-.05 {y} 0'/>");
        }
    }
    format!(
        "<mujoco><option timestep='0.002'/><default><geom contype='0' conaffinity='0'/></default>\
         <worldbody>{bodies}</worldbody><equality>{ties}</equality></mujoco>"
    )
}

#[test]
fn chains_of_a_hundred_with_a_heavy_end_swing_at_bounded_cost() {
    let even = run(&chain(1.0), STEPS, "even");
    let found = run(&chain(1e6), STEPS, "heavy end");
    println!("work {} of {}, {:.1e}", found.work, even.work, found.worst);
    assert!(found.missed == 0 && found.worst < 1e-8 && found.work <= 100 * even.work, "{}", found.work);
}

/// Capsules of 0.4 m that fall on each other, `thinness` times as long as they are wide: their least moment of inertia falls with its square.
fn needles(thinness: f64) -> String {
    let needle = |k: i32| {
        let (x, z, turn, radius) = (0.02 * f64::from(k), 0.01 + 0.03 * f64::from(k), 10 * k, 0.2 / thinness);
        format!(
            "<body pos='{x} 0 {z}' euler='0 {turn} {}'><freejoint/><geom type='capsule' size='{radius} 0.2' mass='1'/></body>",
            2 * turn
        )
    };
    let bodies: String = (0..8).map(needle).collect();
    format!("<mujoco><option timestep='0.002'/><worldbody><geom type='plane'/>{bodies}</worldbody></mujoco>")
}

#[test]
fn needles_fall_on_each_other_at_bounded_cost() {
    let thick = run(&needles(10.0), 250, "thick");
    for thinness in [1e2, 1e3, 1e4] {
        let found = run(&needles(thinness), 250, "needles");
        println!("{thinness:e}: work {} of {}, {:.1e}", found.work, thick.work, found.worst);
        assert!(found.missed == 0 && found.worst < 1e-8, "{thinness:e}: {} missed, {}", found.missed, found.worst);
        assert!(found.work <= 100 * thick.work, "{thinness:e}: {} of {}", found.work, thick.work);
    }
}

/// Ten turned boxes on each other, of half the width `half`, with a step that falls with the root of it: to the eye the same motion at every size.
fn boxes(half: f64) -> String {
    let one = |k: i32| {
        let (x, z) = (0.3 * half * f64::from(k % 2), half * (1.05 + 2.1 * f64::from(k)));
        format!(
            "<body pos='{x} 0 {z}' euler='0 0 {}'><freejoint/><geom type='box' size='{half} {half} {half}'/></body>",
            7 * k
        )
    };
    let (bodies, dt) = ((0..10).map(one).collect::<String>(), 2e-3 * (half / 0.1).sqrt());
    format!("<mujoco><option timestep='{dt}'/><worldbody><geom type='plane'/>{bodies}</worldbody></mujoco>")
}

#[test]
fn boxes_of_ten_micrometres_come_to_rest_as_large_ones_do() {
    let large = run(&boxes(0.1), 250, "large");
    assert_eq!(large.missed, 0);
    for half in [1e-3, 1e-5] {
        let found = run(&boxes(half), 250, "small");
        println!("{half:e}: work {} of {}, {:.1e}", found.work, large.work, found.worst);
        assert!(found.missed == 0 && found.worst < 1e-8 && found.work <= 3 * large.work, "{half:e}: {}", found.work);
    }
}

/// Balls of 3 and 5 mm whose impulses at rest have a singular system: impulses of least norm are not found, and the step keeps its own.
#[test]
fn impulses_that_cannot_be_chosen_are_kept() {
    let text = r#"<mujoco><worldbody><body name="o1"><freejoint/><geom size="0.005"/></body><body><freejoint/><geom size="0.003"/></body></worldbody>
        <equality><connect body1="o1" anchor="0 0.003 -0.005"/></equality></mujoco>"#;
    let settings = Settings::default().with_impulses(ImpulseChoice::LeastNorm);
    let mut simulation = Simulation::new(load_mjcf_str(text, "").unwrap().model, settings).unwrap();
    for step in 0..50 {
        let report = simulation.step().expect("a step");
        assert!(report.advanced() && report.certificate.holds(1e-9), "step {step}: {report:?}");
    }
}
