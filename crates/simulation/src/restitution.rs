//! Poisson's hypothesis: an impact is a compression and a decompression (formulation §7).

use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon};

use crate::build::Impact;

/// The problem of the decompression that follows a solved compression.
///
/// The decompression begins with the velocity that the compression left, and its normal impulses are at least `e` times those of
/// the compression: `λ_N = e λ_c + x`. The given part goes into the free velocity; `x` is the unknown, and friction takes part
/// in both, `eᵀα ≤ μ (e λ_c + x)`, as groups with shifted bounds. Contacts that are no impacts have `e = 0`.
///
/// - `compression`: the problem, in which an impact's gap is at most 0
/// - `solution`: its solution
/// - `impacts`: the contacts that restore
/// - `out`: its memory is reused
///
/// # Source
/// Anitescu & Potra (1997).
pub(crate) fn decompression(
    compression: &ContactProblem,
    solution: &ContactSolution,
    impacts: &[Impact],
    out: &mut ContactProblem,
) {
    out.clone_from(compression);
    out.free_velocity.copy_from_slice(&solution.velocity);
    let mut push = vec![0.0; compression.nv()];
    out.clear_contacts();
    let restored = |contact: usize| -> f64 {
        let impact = impacts.iter().find(|impact| impact.contact == contact);
        impact.map_or(0.0, |impact| impact.restitution * solution.lambda_n[contact])
    };
    let none = FrictionPolygon::frictionless();
    for i in 0..compression.contact_count() {
        let (columns, entries) = compression.jacobian.group(i);
        let normal = columns.iter().zip(entries).map(|(&c, e)| (c, [e[0], 0.0, 0.0]));
        out.push_contact(normal, compression.gap[i], 0.0, &none);
        compression.jacobian.add_transposed(i, [restored(i), 0.0, 0.0], &mut push);
        if let Ok(polygon) = FrictionPolygon::from_directions(compression.directions_of(i).to_vec()) {
            let (impulse, coefficient) = (compression.friction[i] * restored(i), compression.friction[i]);
            let tangents = columns.iter().zip(entries).map(|(&c, e)| (c, [e[1], e[2]]));
            if !polygon.directions().is_empty() && coefficient > 0.0 {
                let bound = FrictionBound::Shifted { impulse, contact: i, coefficient };
                out.push_friction(tangents, [0.0; 2], bound, &polygon);
            }
        }
    }
    for k in 0..compression.bilateral_violation.len() {
        let (columns, entries) = compression.bilateral_jacobian.group(k);
        let row = columns.iter().copied().zip(entries.iter().copied());
        out.push_bilateral(row, compression.bilateral_violation[k]);
    }
    push_groups(compression, restored, out);
    compression.mass_factor.solve_in_place(&mut push);
    out.free_velocity.iter_mut().zip(push).for_each(|(v, p)| *v += p);
}

/// The groups that contacts bound; joints and servos gave their impulse of the step in the compression.
fn push_groups(compression: &ContactProblem, restored: impl Fn(usize) -> f64, out: &mut ContactProblem) {
    let groups = &compression.friction_groups;
    for j in 0..groups.len() {
        let Some((contact, coefficient)) = groups.bound[j].normal() else { continue };
        let bound = FrictionBound::Shifted { impulse: coefficient * restored(contact), contact, coefficient };
        let (columns, entries) = groups.jacobian.group(j);
        let columns = columns.iter().copied().zip(entries.iter().copied());
        if let Ok(polygon) = FrictionPolygon::from_directions(groups.directions_of(j).to_vec()) {
            out.push_friction(columns, groups.target[j], bound, &polygon);
        }
    }
}
