//! Forces of actuators on a mass in one step, each against the equation of its law.

use signorini_multibody::{ActuatorKind, Input, State};

use crate::free_motion::{actuator, free_motion, slide, slider};

const MASS: f64 = 2.0;
const DT: f64 = 0.01;

/// The velocity at the end of a step from length `q` and rate `v`.
fn end(kind: ActuatorKind, range: Option<[f64; 2]>, control: f64, [q, v]: [f64; 2]) -> f64 {
    let model = slider(MASS, slide(), vec![actuator(0, kind).with_force_range(range)]);
    let input = Input::default().with_control(vec![control]);
    free_motion(&model, &State::at(vec![q], vec![v]), &input, DT).free_velocity[0]
}

/// `m (v⁺ − v)/Δt = c + a l + b l̇`: with length and rate of the end where they slow the mass, of the beginning where they drive it.
#[test]
fn affine_forces_are_implicit_where_they_slow() {
    let (gain, control, [q, v]) = ([0.5, -3.0, 7.0], 2.0, [0.3, -1.1]);
    for by_length in [40.0, -40.0] {
        for by_rate in [9.0, -9.0] {
            let bias = [0.7, by_length - gain[1] * control, by_rate - gain[2] * control];
            let found = end(ActuatorKind::Affine { gain, bias }, None, control, [q, v]);
            let length = if by_length < 0.0 { q + DT * found } else { q };
            let rate = if by_rate < 0.0 { found } else { v };
            let force = 0.7 + gain[0] * control + by_length * length + by_rate * rate;
            assert!((MASS * (found - v) / DT - force).abs() < 1e-11, "{by_length} {by_rate}: {found}");
        }
    }
}

/// A servo whose force stays inside its range does not feel the range.
#[test]
fn a_range_that_is_not_reached_changes_nothing() {
    let servo = ActuatorKind::Position { kp: 50.0, kv: 3.0 };
    for [q, v] in [[0.3, -1.1], [0.9, 0.4]] {
        let free = end(servo, None, 0.5, [q, v]);
        let force = 50.0 * (0.5 - q - DT * free) - 3.0 * free;
        assert!((MASS * (free - v) / DT - force).abs() < 1e-11 && force.abs() < 25.0);
        assert_eq!(end(servo, Some([-25.0, 30.0]), 0.5, [q, v]), free);
    }
}

/// What a speed actuator takes from a step before its row: the middle of its range, from which the row adds up to half of it either way.
#[test]
fn a_speed_actuator_pushes_with_the_middle_of_its_range() {
    for (range, middle) in [([-1.0, 4.0], 1.5), ([-3.0, 3.0], 0.0)] {
        let found = end(ActuatorKind::Speed, Some(range), 0.6, [0.2, 0.1]);
        assert!((MASS * (found - 0.1) / DT - middle).abs() < 1e-11, "{range:?}: {found}");
    }
}
