//! Runs whose sweeps are counted: what a step leaves open the next ones close, nothing is claimed that does not hold, and the bits are the
//! same every time.

use signorini::contact::{SolveStatus, certify};
use signorini::multibody::glam::DVec3;
use signorini::{FrictionLaw, ImpulseChoice, Settings, Simulation, SimulationError};

use crate::support::World;

/// Cubes that fall onto each other, in layers that are turned against each other: one island of some hundred contacts.
fn heap(settings: Settings) -> Simulation {
    let mut world = World::upright(0.004, 0.6);
    world.floor();
    for layer in 0..4 {
        for k in 0..9 {
            let shift = 0.07 * f64::from(layer % 2) + 0.01 * f64::from(k % 2);
            let [x, y] = [k % 3, k / 3].map(|n| 0.21 * f64::from(n) + shift);
            world.free_box(DVec3::splat(0.1), 1.0, DVec3::new(x, y, 0.1 + 0.21 * f64::from(layer)));
        }
    }
    world.simulation(settings)
}

#[test]
fn what_is_left_open_closes_in_the_next_steps() {
    for budget in [20, 50] {
        let mut simulation = heap(Settings::default().with_budget(budget));
        let mut unfinished = 0;
        for _ in 0..400 {
            let report = simulation.step().expect("steps").clone();
            let workspace = simulation.workspace();
            let again = certify(workspace.problem(), workspace.solution());
            assert_eq!(again, report.certificate);
            assert!(again.momentum <= 1e-9 && again.friction <= 1e-9, "{again:?}");
            assert_eq!(report.missed_tolerance, again.worst() > 1e-9);
            if let Some(spread) = report.spread {
                assert_eq!(report.status, SolveStatus::Inaccurate);
                assert!(spread.rms <= spread.worst && again.friction <= 1e-13, "{again:?}");
                unfinished += 1;
            }
            assert_eq!(report.theta, 1.0, "a budget that is used up is no reason to keep overlaps");
        }
        let (summary, last) = (simulation.summary().clone(), simulation.workspace().solution().certificate.worst());
        println!(
            "budget {budget}: {unfinished} unfinished, rms {:.1e} at most, at the end {last:.1e}, deepest {:.1e} m",
            summary.largest_rms, summary.deepest_penetration
        );
        assert!(unfinished > 0 && summary.unfinished_steps == unfinished);
        let speed = simulation.state().v.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        assert!(speed < 1e-3, "the heap comes to rest: {speed:e}");
        assert!(last < 1e-2 * summary.worst.worst(), "{last:e} at the end, {:e} at most", summary.worst.worst());
        assert!(summary.deepest_penetration < 1e-3, "{:e} m", summary.deepest_penetration);
    }
}

#[test]
fn the_same_bits_every_time() {
    let run = || {
        let mut simulation = heap(Settings::default().with_budget(7));
        simulation.run(0.2, |_, _| true).expect("runs");
        simulation.state().clone()
    };
    assert_eq!(run(), run());
}

#[test]
fn settings_that_have_no_sweeps_are_refused() {
    let settings = Settings::default().with_budget(10);
    assert!(matches!(
        settings.clone().with_budget(0).validate(),
        Err(SimulationError::Setting { setting: "budget", .. })
    ));
    for other in [
        settings.clone().with_friction_law(FrictionLaw::Circular),
        settings.clone().with_impulses(ImpulseChoice::LeastNorm),
        settings.with_restitution(signorini::RestitutionLaw::Poisson),
    ] {
        assert!(matches!(other.validate(), Err(SimulationError::Incompatible { settings: ["budget", _], .. })));
    }
}
