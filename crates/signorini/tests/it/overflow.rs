//! Numbers beyond what can be computed: every law ends with a report or a typed error, and none with a panic.

use signorini::multibody::glam::DVec3;
use signorini::{FrictionLaw, InfeasiblePolicy, RestitutionLaw, Settings, SettleSettings, Simulation, SimulationError};

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

/// A motion that has blown up is an error that names what moves, and the simulation stays where it was.
#[test]
fn a_step_that_ends_in_no_numbers_is_refused() {
    let mut world = World::upright(0.005, 0.5);
    world.free_ball(0.1, 1.0, DVec3::Z);
    let mut simulation = world.simulation(Settings::default().with_timestep(Some(1e160)));
    let before = simulation.state().clone();
    let error = simulation.step().unwrap_err();
    let message = error.to_string();
    let SimulationError::Diverged { joint, speed, timestep, .. } = error else { panic!("{message}") };
    assert!(joint.starts_with("part") && speed * timestep > 1e3 && timestep == 1e160, "{message}");
    assert!(message.contains("shorter time step"), "{message}");
    assert_eq!(*simulation.state(), before);
    assert!(matches!(simulation.step(), Err(SimulationError::Diverged { .. })));
}

/// A double pendulum whose second hinge has blown up: the step names it, and from a state without the speed the simulation goes on.
#[test]
fn what_has_blown_up_is_named_and_can_be_left() {
    let text = r#"<mujoco><worldbody><body><joint name="first" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 1" size="0.05"/>
        <body pos="0 0 1"><joint name="second" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 1" size="0.05"/></body></body></worldbody></mujoco>"#;
    let mut simulation =
        Simulation::new(signorini_formats::load_mjcf_str(text, "").unwrap().model, Settings::default()).unwrap();
    let at_rest = simulation.state().clone();
    let mut state = at_rest.clone();
    state.v = vec![1e3, -1e170];
    simulation.set_state(&state).unwrap();
    let error = (0..20).find_map(|_| simulation.step().err()).expect("an error");
    assert!(matches!(&error, SimulationError::Diverged { joint, unit: "rad", .. } if joint == "second"), "{error}");
    simulation.set_state(&at_rest).unwrap();
    for _ in 0..5 {
        assert!(simulation.step().unwrap().certificate.holds(1e-9));
    }
}
