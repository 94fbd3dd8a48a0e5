//! The spring by which a body is dragged.

use signorini::multibody::glam::DVec3;
use signorini::multibody::{
    BodyId, Kinematics, MassMatrix, Model, State, forward_kinematics_into, mass_matrix_into, point_jacobian_into,
};

/// Natural frequency of the spring with the mass that it feels, rad/s.
const FREQUENCY: f64 = 15.0;

/// A body held at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// The body.
    pub body: BodyId,
    /// The point that is held, body frame, m.
    pub point: DVec3,
    /// Where it is pulled to, world, m.
    pub target: DVec3,
}

/// Computes the generalized force of grips; storage for one model.
pub struct Spring {
    kinematics: Kinematics,
    mass: MassMatrix,
    jacobian: Vec<f64>,
    column: Vec<f64>,
}

impl Spring {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            kinematics: Kinematics::new(model),
            mass: MassMatrix::new(model),
            jacobian: vec![0.0; 3 * model.nv],
            column: vec![0.0; model.nv],
        }
    }

    /// Adds `Jᵀf` to `force`, `[nv]`, N and N·m, where `J` is the Jacobian of the held point and
    /// `f = m (ω²(target − p − Δt ṗ) − 2ω ṗ) / (1 + 2ωΔt + ω²Δt²)`: a critically damped spring on the mass that the point
    /// has on average over all directions, `m = 3 / tr(J M⁻¹ Jᵀ)`. The denominator is that of the implicit Euler step, so that
    /// long steps do not make it swing.
    pub fn add_force(&mut self, model: &Model, state: &State, timestep: f64, grip: &Grip, force: &mut [f64]) {
        if model.nv == 0 {
            return;
        }
        let Self { kinematics, mass, jacobian, column } = self;
        forward_kinematics_into(model, &state.q, &state.v, kinematics);
        let pose = &kinematics.pose[grip.body.index()];
        let point = pose.position + pose.rotation * grip.point;
        let velocity = kinematics.point_velocity(grip.body, point);
        point_jacobian_into(model, kinematics, grip.body, point, jacobian);
        mass_matrix_into(model, kinematics, mass);
        // A singular mass matrix ends the step with an error of its own.
        let Ok(factor) = mass.matrix.factor() else { return };
        let mobility: f64 = jacobian
            .chunks_exact(model.nv)
            .map(|row| {
                column.copy_from_slice(row);
                factor.solve_in_place(column);
                row.iter().zip(column.iter()).map(|(a, b)| a * b).sum::<f64>()
            })
            .sum();
        if !(mobility > 0.0 && mobility.is_finite()) {
            return;
        }
        let (w, dt) = (FREQUENCY, timestep);
        let pull = (grip.target - point - dt * velocity) * (w * w) - velocity * (2.0 * w);
        let pull = pull * (3.0 / mobility / (1.0 + 2.0 * w * dt + w * w * dt * dt));
        for (row, f) in jacobian.chunks_exact(model.nv).zip(pull.to_array()) {
            force.iter_mut().zip(row).for_each(|(sum, j)| *sum += j * f);
        }
    }
}
