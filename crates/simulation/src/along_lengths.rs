//! Forces along lengths in the last step: those of actuators and of tendons.

use signorini_multibody::{EqualityKind, Model, State, Transmission, polynomial_at};

use crate::source::{ContactSource, FrictionSource};
use crate::workspace::Workspace;

/// Force of an actuator with the velocity at the end of the step, and what a servo of speed adds to the middle of its range.
pub(crate) fn actuator_force(workspace: &Workspace, a: usize, dt: f64) -> f64 {
    let servo = FrictionSource::Servo { actuator: a };
    let is_servo = |source: &FrictionSource| *source == servo;
    // Asked first, as the rows of all are put together where some sleep.
    let is_there = workspace.builder.friction_source.iter().any(is_servo);
    let group = is_there.then(|| workspace.rows().friction_source.iter().position(is_servo)).flatten();
    let added = group.map_or(0.0, |j| workspace.group_impulse(j)[0] / dt);
    workspace.smooth.actuator_force_at(a, workspace.end_velocity(), dt) + added
}

/// Finds the force along the length of every tendon: of its spring and damper, its actuators, its limits and the constraints
/// that couple it, N (N·m where it combines angles).
pub(crate) fn tensions_into(model: &Model, state: &State, workspace: &mut Workspace, dt: f64) {
    let mut tension = std::mem::take(&mut workspace.sensors.tension);
    for (t, tension) in tension.iter_mut().enumerate() {
        *tension = workspace.smooth.tendon_force_at(model, t, [&state.v, workspace.end_velocity()], dt);
    }
    for (a, actuator) in model.actuators.iter().enumerate() {
        if let Transmission::Tendon(tendon) = actuator.transmission {
            tension[tendon.index()] += actuator.gear * actuator_force(workspace, a, dt);
        }
    }
    let first_limit = workspace.contact_points().len();
    for (i, source) in (first_limit..).map_while(|i| Some((i, workspace.contact_source(i)?))) {
        if let ContactSource::TendonLimit { tendon, upper } = source {
            let outward = if upper { -1.0 } else { 1.0 };
            tension[tendon.index()] += outward * workspace.contact_impulse(i)[0] / dt;
        }
    }
    for (k, row) in workspace.builder.bilateral_source.iter().enumerate() {
        if let EqualityKind::Tendon { tendon, driver, polynomial } = model.equalities[row.equality].kind {
            let force = workspace.bilateral_impulse(k) / dt;
            tension[tendon.index()] += force;
            if let Some(driver) = driver {
                let leading = &model.tendons[driver.index()];
                let x = leading.length(model, &workspace.kinematics, &state.q) - leading.reference_length;
                tension[driver.index()] -= polynomial_at(polynomial, x).1 * force;
            }
        }
    }
    workspace.sensors.tension = tension;
}
