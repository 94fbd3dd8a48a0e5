//! Islands at rest: the impulses of the last step still hold them, so there is nothing to solve.
//!
//! Nothing is remembered from step to step, so that any change wakes an island: a new contact, an input, a body that moves.

use signorini_contact::StageOutcome;

use super::shared::{Outcome, Shared};
use crate::iterate::Iterate;
use crate::residual::{RESIDUALS, law_residual};
use crate::task::{Look, Task};

/// Memory of the sums of momenta.
#[derive(Clone, Debug, Default)]
pub(super) struct Loads {
    sum: Vec<f64>,
    /// Of the sizes of the momenta that meet in each degree of freedom.
    size: Vec<f64>,
}

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    task.settings.sleeping && task.look != Look::Second && !iterate.velocity.is_empty()
}

/// Takes velocity zero where the impulses of the start hold the island still: in every degree of freedom `(M v^f + Jᵀλ)_k = 0` up
/// to rounding of its terms, and the laws hold both at rest and at the velocity that the impulses give.
pub(super) fn run(sleep: &mut Loads, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let map = &mut shared.map;
    if !sleep.is_balanced(task, &map.free_velocity, iterate) {
        return StageOutcome::Lost.into();
    }
    map.set_weights(task.island, task.settings.proximal_weight);
    let residual = map.evaluate_centre(task, iterate).max(residual_at_rest(task, iterate));
    if residual > task.settings.accept() {
        return StageOutcome::Lost.into();
    }
    iterate.velocity.fill(0.0);
    iterate.residual = residual;
    StageOutcome::AtRest.into()
}

impl Loads {
    /// Whether `M v^f` and the impulses cancel.
    fn is_balanced(&mut self, task: &Task, free_velocity: &[f64], iterate: &Iterate) -> bool {
        let (island, Self { sum, size }) = (task.island, self);
        sum.clear();
        sum.resize(island.nv(), 0.0);
        island.multiply_mass(&task.problem.mass, free_velocity, sum);
        size.clear();
        size.extend(sum.iter().map(|p| p.abs()));
        for (c, &p) in iterate.impulse.iter().enumerate() {
            let p = island.pushing(c, p);
            // An impulse is one vector: friction that should be zero is rounding of the normal part.
            let largest = p[0].abs().max(p[1].abs()).max(p[2].abs());
            let (columns, entries) = island.jacobian.group(c);
            for (&k, e) in columns.iter().zip(entries) {
                sum[k as usize] += e[0] * p[0] + e[1] * p[1] + e[2] * p[2];
                size[k as usize] += largest * (e[0].abs() + e[1].abs() + e[2].abs());
            }
        }
        for (k, &p) in iterate.bilateral.iter().enumerate() {
            let (columns, entries) = island.bilateral_jacobian.group(k);
            for (&k, [e]) in columns.iter().zip(entries) {
                sum[k as usize] += e * p;
                size[k as usize] += (e * p).abs();
            }
        }
        sum.iter().zip(size).all(|(sum, size)| sum.abs() <= RESIDUALS.noise * *size)
    }
}

/// Residual of the contact laws at velocity zero, relative to the island's velocity scale.
fn residual_at_rest(task: &Task, iterate: &Iterate) -> f64 {
    let island = task.island;
    let law = |(c, &i): (usize, &u32)| {
        let u = island.pushing(c, island.offset[c]);
        law_residual(task.cones, i as usize, iterate.impulse[c], u, island.residual_scale)
    };
    let contacts = island.units.iter().enumerate().map(law);
    let worst = contacts.chain(island.bilateral_offset.iter().map(|u| u.abs())).fold(0.0, f64::max);
    let scale = island.velocity_scale.value();
    if scale > 0.0 { worst / scale } else { 0.0 }
}
