//! What a simulation says about wrong settings and names.

use signorini::{Settings, Simulation, SimulationError};

use crate::support::{World, bundled};

fn rejected(settings: Settings) -> String {
    let model = World::upright(0.005, 0.5).builder.build().unwrap();
    Simulation::new(model, settings).err().expect("rejected").to_string()
}

#[test]
fn settings_out_of_range_are_named() {
    let base = Settings::default;
    let cases = [
        (base().with_timestep(0.0), "timestep"),
        (base().with_timestep(f64::NAN), "timestep"),
        (base().with_stabilization(1.5), "stabilization"),
        (base().with_tolerance(0.0), "tolerance"),
        (base().with_directions(2), "directions"),
        (base().with_directions(7), "even"),
        (base().with_direction_angle(f64::INFINITY), "direction_angle"),
    ];
    for (settings, expected) in cases {
        let message = rejected(settings);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn an_unknown_keyframe_is_answered_with_the_known_ones() {
    let error = bundled("quadruped").reset_to("sit").unwrap_err();
    assert!(matches!(error, SimulationError::UnknownName { .. }));
    assert!(error.to_string().contains("'sit'") && error.to_string().contains("home"), "{error}");
}

#[test]
fn a_state_that_does_not_fit_is_refused() {
    let mut simulation = bundled("quadruped");
    let mut state = simulation.state().clone();
    state.q[0] = f64::NAN;
    assert!(matches!(simulation.set_state(&state), Err(SimulationError::State(_))));
    state.q.pop();
    assert!(matches!(simulation.set_state(&state), Err(SimulationError::State(_))));
}
