//! How what the force law of an actuator takes as its control changes.

use crate::model::{Activation, ActivationKind, Actuator, activation_rate};
use crate::state::{Input, State};

/// Which inequality of the smooth part decides how a force goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarginSource {
    /// The control of an actuator, by index, against its range.
    Control(usize),
    /// The force of an actuator, by index, against its range.
    Force(usize),
    /// The activation of an actuator, by index, against its range.
    Activation(usize),
    /// The length of a tendon, by index, against the range in which it is slack.
    Slack(usize),
    /// The path of a tendon, by index, against another kind of way past a geom.
    Path(usize),
    /// The length and the speed of a muscle, by index of the actuator, against places where parts of its curves meet or its force begins to grow
    /// as it gives way.
    Curve(usize),
}

/// Slopes by the control of the input and by the activation; what is at a bound has no slope beyond it.
pub(super) fn drive_slopes(
    actuator: &Actuator,
    (state, input): (&State, &Input),
    a: usize,
    dt: f64,
    margins: &mut Vec<(MarginSource, f64)>,
) -> [f64; 2] {
    let given = *input.control.get(a).unwrap_or(&0.0);
    let mut slope = 1.0;
    if let Some(range) = actuator.control_range {
        margins.push((MarginSource::Control(a), distance_to(given, range)));
        slope = f64::from(range[0] < given && given < range[1]);
    }
    let Some(activation) = &actuator.activation else { return [slope, 0.0] };
    if !activation.early {
        return [0.0, 1.0];
    }
    let (value, control) = (state.activation[activation.index], actuator.control(input, a));
    if let ActivationKind::Muscle { smoothing, .. } = activation.kind {
        let rests = if smoothing > 0.0 { f64::INFINITY } else { (control.clamp(0.0, 1.0) - value).abs() };
        margins.push((MarginSource::Activation(a), distance_to(control, [0.0, 1.0]).min(rests)));
    }
    let moved = moved(activation, value, control, dt);
    let mut within = 1.0;
    if let Some(range) = activation.range {
        margins.push((MarginSource::Activation(a), distance_to(moved.value, range)));
        within = f64::from(range[0] < moved.value && moved.value < range[1]);
    }
    [slope * within * moved.by_control, within * moved.by_activation]
}

/// Slope by the time step.
pub(super) fn drive_by_timestep(actuator: &Actuator, (state, input): (&State, &Input), a: usize, dt: f64) -> f64 {
    let Some(activation) = actuator.activation.as_ref().filter(|activation| activation.early) else { return 0.0 };
    let moved = moved(activation, state.activation[activation.index], actuator.control(input, a), dt);
    let within = activation.range.is_none_or(|range| range[0] < moved.value && moved.value < range[1]);
    if within { moved.by_timestep } else { 0.0 }
}

/// An activation after Δt before it is cut to its range, and its slopes.
struct Moved {
    value: f64,
    by_control: f64,
    by_activation: f64,
    by_timestep: f64,
}

fn moved(activation: &Activation, a: f64, u: f64, dt: f64) -> Moved {
    // The share of the way to the control that is gone, and how it grows.
    let of_share = |share: f64, growth: f64| Moved {
        value: a + share * (u - a),
        by_control: share,
        by_activation: 1.0 - share,
        by_timestep: growth * (u - a),
    };
    match activation.kind {
        ActivationKind::Integrator => Moved { value: a + dt * u, by_control: dt, by_activation: 1.0, by_timestep: u },
        ActivationKind::Filter { time_constant } => of_share(dt / time_constant, 1.0 / time_constant),
        ActivationKind::ExactFilter { time_constant } => {
            of_share(-(-dt / time_constant).exp_m1(), (-dt / time_constant).exp() / time_constant)
        }
        ActivationKind::Muscle { times, smoothing } => {
            let [rate, by_activation, by_control] = activation_rate(a, u, times, smoothing);
            Moved {
                value: a + dt * rate,
                by_control: dt * by_control,
                by_activation: 1.0 + dt * by_activation,
                by_timestep: rate,
            }
        }
    }
}

/// Distance of a number to the nearer end of a range, relative to the range.
pub(super) fn distance_to(x: f64, [lower, upper]: [f64; 2]) -> f64 {
    (x - lower).abs().min((x - upper).abs()) / (upper - lower).max(f64::MIN_POSITIVE)
}
