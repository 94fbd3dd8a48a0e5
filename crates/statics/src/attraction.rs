//! Forces that hold bodies together where they touch: studs, glue, magnets, clamps.

use signorini_multibody::{BodyId, Model};
use signorini_simulation::{ContactSource, RestProblem, SimulationError};

/// A constant force that pulls two bodies together along the normals of their contacts, as long as they touch.
///
/// A contact with an attraction `T` bears a tension of up to `T`: the force between the bodies is `λ_N − T` with `λ_N ≥ 0`, and friction is
/// bounded by `μ λ_N`. It is a load, so that verdicts and their proofs hold as they do without (B. Derjaguin, V. Muller, Y. Toporov,
/// J. Colloid Interface Sci. 53, 1975, for adhesion; a preload is the same).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attraction {
    /// Of every contact point, N each.
    Points(f64),
    /// Of two bodies, N, spread evenly over the points at which they touch.
    Pair([BodyId; 2], f64),
}

/// Adds attractions to the loads of a problem; what each contact has, N.
///
/// - `known`: of the first contacts, N each
///
/// # Errors
/// [`SimulationError::Setting`] for a force that is negative or not finite, or a pair that does not touch.
pub(crate) fn attract(
    model: &Model,
    rest: &mut RestProblem,
    known: &[f64],
    attractions: &[Attraction],
) -> Result<Vec<f64>, SimulationError> {
    let mut forces = vec![0.0; rest.contacts.len()];
    forces.iter_mut().zip(known).for_each(|(force, known)| *force += known);
    let bodies: Vec<Option<[BodyId; 2]>> = rest.contacts.iter().map(|source| bodies_of(model, source)).collect();
    for attraction in attractions {
        let (places, force): (Vec<usize>, f64) = match *attraction {
            Attraction::Points(force) => ((0..forces.len()).filter(|&i| bodies[i].is_some()).collect(), force),
            Attraction::Pair([a, b], force) => {
                let is_pair = |&i: &usize| bodies[i].is_some_and(|own| own == [a, b] || own == [b, a]);
                let places: Vec<usize> = (0..forces.len()).filter(is_pair).collect();
                if places.is_empty() {
                    let expected = "two bodies that touch; the first of these is number";
                    return Err(SimulationError::Setting { setting: "attraction", expected, found: f64::from(a.0) });
                }
                let count = places.len() as f64;
                (places, force / count)
            }
        };
        if !(force >= 0.0 && force.is_finite()) {
            let expected = "finite and not negative";
            return Err(SimulationError::Setting { setting: "attraction", expected, found: force });
        }
        places.into_iter().for_each(|i| forces[i] += force);
    }
    if forces.iter().any(|force| *force != 0.0) {
        load(rest, &forces);
    }
    Ok(forces)
}

fn bodies_of(model: &Model, source: &ContactSource) -> Option<[BodyId; 2]> {
    let ContactSource::Point(point) = source else { return None };
    Some([point.geom_a, point.geom_b].map(|geom| model.geoms[geom.index()].body))
}

/// `v^f −= M⁻¹ J_Nᵀ T Δt`.
fn load(rest: &mut RestProblem, forces: &[f64]) {
    let problem = &mut rest.problem;
    let mut impulse = vec![0.0; problem.nv()];
    for (i, force) in forces.iter().enumerate() {
        let (columns, entries) = problem.jacobian.group(i);
        let own = columns.iter().zip(entries);
        own.for_each(|(&column, e)| impulse[column as usize] -= e[0] * force * problem.timestep);
    }
    problem.mass_factor.solve_in_place(&mut impulse);
    problem.free_velocity.iter_mut().zip(&impulse).for_each(|(v, change)| *v += change);
}
