//! Numbers beyond what can be computed: every law ends with a report or a typed error, and none with a panic.

use signorini::multibody::glam::DVec3;
use signorini::{FrictionLaw, InfeasiblePolicy, RestitutionLaw, Settings, SettleSettings, Simulation};

use crate::support::World;

/// Two boxes on each other and a ball beside them that touches both.
fn scene(settings: Settings) -> Simulation {
    let mut world = World::upright(0.005, 0.5);
    world.floor();
    world.free_box(DVec3::new(0.1, 0.1, 0.1), 1.0, DVec3::Z * 0.1);
    world.free_box(DVec3::new(0.1, 0.1, 0.1), 1.0, DVec3::Z * 0.3);
    world.free_ball(0.1, 1.0, DVec3::new(0.2, 0.0, 0.1));
    world.simulation(settings)
}

#[test]
fn no_law_panics_where_numbers_overflow() {
    let laws = [FrictionLaw::Polygon, FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-6 }];
    let policies = [InfeasiblePolicy::GoOn, InfeasiblePolicy::Stop, InfeasiblePolicy::ClipGaps];
    let mut steps = 0;
    for law in laws {
        for policy in policies {
            for restitution in [RestitutionLaw::Newton, RestitutionLaw::Poisson] {
                for exponent in [20, 80, 140, 154, 200, 290, 307] {
                    for dof in [0, 2, 3, 8, 14, 17] {
                        let settings = Settings::default()
                            .with_friction_law(law)
                            .with_infeasible(policy)
                            .with_restitution(restitution);
                        let mut simulation = scene(settings);
                        let mut state = simulation.state().clone();
                        state.v[dof] = -(10f64.powi(exponent));
                        simulation.set_state(&state).unwrap();
                        for _ in 0..3 {
                            let Ok(report) = simulation.step() else { break };
                            // What is no number is never called solved.
                            let (missed, advanced) = (report.missed_tolerance, report.advanced());
                            let finite = simulation.state().v.iter().all(|v| v.is_finite());
                            assert!(finite || missed || !advanced, "{law:?} 1e{exponent} {dof}");
                            steps += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(steps > 500, "{steps}");
}

#[test]
fn settling_does_not_panic_where_numbers_overflow() {
    for exponent in [3, 20, 80, 154, 200, 307] {
        for dof in [0, 2, 3, 8, 14, 17] {
            let mut simulation = scene(Settings::default());
            let mut state = simulation.state().clone();
            state.v[dof] = -(10f64.powi(exponent));
            simulation.set_state(&state).unwrap();
            let ended = simulation.settle(&SettleSettings::default().with_max_steps(50));
            assert!(
                ended.is_ok() || simulation.state().v.iter().all(|v| v.is_finite()),
                "1e{exponent} {dof}: {ended:?}"
            );
        }
    }
}
