//! The smallest contact problem.

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::BlockDiagonal;

/// A particle of mass 1 kg over a plane, one contact with directions +x, +y, −x, −y; degrees of freedom (normal, x, y).
pub fn particle(normal: f64, tangential: [f64; 2], timestep: f64, gap: f64, friction: f64) -> ContactProblem {
    let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).expect("symmetric");
    let velocity = vec![normal, tangential[0], tangential[1]];
    let mut problem = ContactProblem::new(mass, velocity, timestep).expect("valid data");
    let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
    problem.push_contact(columns, gap, friction, &FrictionPolygon::regular(4, 0.0).expect("even"));
    problem
}
