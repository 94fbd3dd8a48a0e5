//! Mass ratios up to 1e9: what is not solved says so, nothing is denied, and no step goes on to continuation where only the last
//! digits of impulses are missing.

use signorini::Settings;
use signorini::contact::SolveStatus;
use signorini::multibody::glam::DVec3;

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
