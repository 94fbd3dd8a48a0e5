//! How what a solution lacks is spread over the rows of its problem.

use crate::certificate::{Scales, Scratch, certify_rows};
use crate::residuals::ResidualSpread;
use crate::{Certificate, ContactProblem, ContactSolution};

/// How the residual of a claimed solution is spread, from the data alone; none where the problem has no rows, or what is claimed has not its
/// sizes or is no number.
pub fn residual_spread(problem: &ContactProblem, solution: &ContactSolution) -> Option<ResidualSpread> {
    let mut scratch = Scratch::default();
    let scales = scratch.scales(problem, problem.velocity_scale());
    certify_and_spread(problem, solution, &scales, &mut scratch).1
}

/// The [certificate](crate::certificate::certify_with) of a claimed solution and how its residual is spread.
pub fn certify_and_spread(
    problem: &ContactProblem,
    solution: &ContactSolution,
    scales: &Scales,
    scratch: &mut Scratch,
) -> (Certificate, Option<ResidualSpread>) {
    let (mut worst, mut worst_row, mut squares, mut rows) = (-1.0, None, 0.0, 0);
    let certificate = certify_rows(problem, solution, scales, scratch, |row, raw| {
        let residual = raw / scales.velocity;
        if residual > worst {
            (worst, worst_row) = (residual, Some(row));
        }
        squares += residual * residual;
        rows += 1;
    });
    if !certificate.natural_map.is_finite() || scales.velocity <= 0.0 {
        return (certificate, None);
    }
    let spread = worst_row.map(|worst_row| {
        let rms = (squares / f64::from(rows)).sqrt();
        ResidualSpread { worst_row, worst, rms }
    });
    (certificate, spread)
}
