//! The linear system of a step's mode and its derivatives.

mod contacts;
mod coordinates;
mod equalities;
mod frames;
mod gaps;
mod others;
mod pair;
mod parameters;
mod patch;
mod scratch;
mod system;
mod tendons;
mod turning;

use signorini_multibody::derivatives::BalanceDerivatives;

use crate::validity::Margin;

pub(crate) use equalities::LeftOut;
pub(crate) use scratch::Scratch;
pub(crate) use system::{ModeRows, Modes, Step, TieRows};

/// Builds the rows of the mode, and takes the turning of the impulses into the balance.
///
/// # Errors
/// Why something in the step has no derivative.
pub(crate) fn build(
    step: &mut Step,
    modes: &Modes,
    margins: &mut Vec<Margin>,
    (rows, ties, left_out): (&mut ModeRows, &mut TieRows, &mut LeftOut),
    turning: &mut Vec<f64>,
    scratch: &mut Scratch,
) -> Result<(), String> {
    let nv = step.model.nv;
    rows.clear(step.model, step.directions.len());
    ties.contacts.clear();
    ties.rows.clear(step.model, 0);
    turning.clear();
    turning.resize(nv * nv, 0.0);
    contacts::add_points(step, modes, margins, (rows, ties), turning, scratch)?;
    coordinates::add_limits(step, modes, margins, rows, turning, scratch)?;
    coordinates::add_groups(step, modes, margins, rows, turning, scratch)?;
    others::note_others(step, margins);
    equalities::add(step, margins, (rows, left_out), turning, scratch)?;
    parameters::add_coordinates(step, modes, step.directions, rows);
    Ok(())
}

/// Compares the balance with the impulses of the step: whether both are the same to rounding.
pub(crate) fn balances(balance: &BalanceDerivatives, rows: &ModeRows, scale: f64) -> bool {
    let off = balance.impulse.iter().zip(&rows.coordinate_impulse).map(|(x, y)| (x - y).abs());
    off.fold(0.0, f64::max) <= 1e-6 * scale
}
