//! Rows that follow from others: whether their derivatives do.

use signorini_multibody::derivatives::BalanceDerivatives;

use crate::columns::VelocityColumns;
use crate::matrix::{add_scaled, largest};
use crate::rows::LeftOut;
use crate::system::ModeSystem;
use crate::validity::{InequalityKind, Margin};

/// Redundant contacts hold the same motion where the derivatives of their rows agree to this part of their size. What they differ by is missing in the
/// derivative, up to a hundred times: to 1e-8 some of a pile's were off by 6e-7.
const CONSISTENT: f64 = 1e-9;

/// Rows of constraints that are left out follow from the others to this part of their size: what is more may be in the next step's problem.
/// The root of what `BilateralBasis` takes for no square.
const FOLLOWS: f64 = 1e-5;

/// Notes redundant rows whose derivatives do not follow from the others: their contacts part as soon as anything changes.
pub(crate) fn note_redundancy(
    (balance, system): (&BalanceDerivatives, &ModeSystem),
    columns: &mut VelocityColumns,
    margins: &mut Vec<Margin>,
    work: &mut Vec<f64>,
) {
    if system.dropped().is_empty() {
        return;
    }
    columns.keep_motion(balance, system);
    let fastest = largest(&columns.velocity.data);
    for &i in system.dropped() {
        let [off, size] = departure(system, columns, i, fastest, work);
        if off > CONSISTENT * size {
            let (source, kind) = (system.rows.source[i], InequalityKind::Redundancy);
            margins.push(Margin { source, kind, value: 0.0 });
        }
    }
}

/// By how much a row that is dropped changes, over all columns, less what follows from the others, and its size.
fn departure(system: &ModeSystem, columns: &VelocityColumns, i: usize, fastest: f64, work: &mut Vec<f64>) -> [f64; 2] {
    let slopes = columns.slopes.row(i);
    work.clear();
    work.extend_from_slice(slopes);
    system.add_held(i, &columns.velocity, work);
    let size = largest(slopes).max(fastest * largest(system.rows.held.row(i)));
    [largest(work), size]
}

/// Notes which of `count` parameters part redundant contacts.
pub(crate) fn note_parameters(nv: usize, count: usize, system: &mut ModeSystem) {
    if count == 0 || system.dropped().is_empty() {
        return;
    }
    let mut columns = VelocityColumns::default();
    columns.solve_parameters(nv, count, system);
    // Without contacts: what is less than the rounding of that is nothing.
    let mut free = Vec::new();
    let unheld: Vec<f64> = (0..count)
        .map(|j| {
            free.clear();
            free.extend_from_slice(system.rows.balance_by_parameter.row(j));
            system.accelerate(&mut free);
            largest(&free)
        })
        .collect();
    let (dropped, rows) = system.dropped_of();
    for &i in dropped {
        let held = rows.held.row(i);
        for (j, without) in rows.without_slope.iter_mut().enumerate() {
            let column = columns.velocity.data.iter().skip(j).step_by(columns.velocity.width);
            let (mut off, mut fastest) = (columns.slopes.row(i)[j], unheld[j]);
            for (held, velocity) in held.iter().zip(column) {
                off += held * velocity;
                fastest = fastest.max(velocity.abs());
            }
            let size = columns.slopes.row(i)[j].abs().max(fastest * largest(held));
            if off.abs() > CONSISTENT * size {
                *without = Some("redundant contacts part as soon as it changes".to_owned());
            }
        }
    }
}

/// The equality constraint that has a row that the step leaves out, as it follows from others or nothing moves it, and that no longer does so as soon
/// as the state changes: nothing moves the point of a parallelogram along the line on which all its links lie.
pub(crate) fn departing_constraint(
    left_out: &LeftOut,
    (balance, system): (&BalanceDerivatives, &ModeSystem),
    columns: &mut VelocityColumns,
    work: &mut Vec<f64>,
) -> Option<usize> {
    if left_out.of.is_empty() {
        return None;
    }
    columns.keep_motion(balance, system);
    let fastest = largest(&columns.velocity.data);
    let departs = |i: usize, motion: f64, off: &mut Vec<f64>| {
        let (slopes, held) = (left_out.rows.by_configuration.row(i), left_out.rows.held.row(i));
        off.clear();
        off.extend_from_slice(slopes);
        off.resize(columns.velocity.width, 0.0);
        held.iter().enumerate().for_each(|(k, entry)| add_scaled(off, *entry, columns.velocity.row(k)));
        largest(off) > FOLLOWS * fastest * motion
    };
    let rows = left_out.of.iter().enumerate();
    rows.into_iter().find(|(i, (_, motion))| departs(*i, *motion, work)).map(|(_, (equality, _))| *equality)
}
