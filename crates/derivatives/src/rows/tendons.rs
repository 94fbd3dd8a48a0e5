//! Rows along tendons, which turn where these have a path.

use signorini_multibody::derivatives::LengthCurvature;
use signorini_multibody::{LengthRow, TendonId, tendon_length_into};

use super::scratch::Scratch;
use super::system::Step;
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Adds how a row along a tendon turns, and its impulse with it.
///
/// - `part`: how much of the tendon's own row it is
/// - `lambda`: its impulse, N·s
/// - `slopes`: of the row by the configuration, `[nv]`
///
/// # Errors
/// Why it has no derivative.
pub(super) fn add_turning(
    step: &Step,
    (tendon, part, source): (TendonId, f64, InequalitySource),
    lambda: f64,
    margins: &mut Vec<Margin>,
    (slopes, turning): (&mut [f64], &mut [f64]),
    scratch: &mut Scratch,
) -> Result<(), &'static str> {
    let (model, nv) = (step.model, step.model.nv);
    let Scratch { length, turns, .. } = scratch;
    measure(step, tendon, (length, turns));
    if turns.by_configuration.iter().any(|x| !x.is_finite()) {
        return Err("its way past a geom is not smooth here");
    }
    if !model.tendons[tendon.index()].path.is_empty() {
        margins.push(Margin { source, kind: InequalityKind::Feature, value: turns.clearance });
    }
    let n = length.dofs.len();
    for (j, &l) in length.dofs.iter().enumerate() {
        slopes[l] += part * turns.turned(length, j, &step.solution.velocity);
        for (i, &k) in length.dofs.iter().enumerate() {
            turning[k * nv + l] += lambda * part * turns.by_configuration[i * n + j];
        }
    }
    Ok(())
}

/// The length of a tendon with its row, and how that turns.
pub(super) fn measure(step: &Step, tendon: TendonId, (length, turns): (&mut LengthRow, &mut LengthCurvature)) {
    let (model, kinematics) = (step.model, step.workspace.kinematics());
    let tendon = &model.tendons[tendon.index()];
    tendon_length_into(model, kinematics, &step.state.q, tendon, length);
    turns.set(model, kinematics, step.end, tendon, length);
}
