//! The spring by which a body is dragged.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BlockCholesky, BodyId, Kinematics, MassMatrix, Model, State, angular_jacobian_into, forward_kinematics_into,
    mass_matrix_into, point_jacobian_into,
};

/// Natural frequency ω of the spring with the mass that it feels, rad/s.
const FREQUENCY: f64 = 20.0;

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

    /// Adds the force of a grip to `force`, `[nv]`, N and N·m.
    ///
    /// At the held point `p` with Jacobian `J` it is `f = m (ω²(target − p − Δt ṗ) − 2ω ṗ) / (1 + 2ωΔt + ω²Δt²)`: a critically
    /// damped spring on the mass that the point has on average over all directions, `m = 3 / tr(J M⁻¹ Jᵀ)`. The denominator
    /// is that of the implicit Euler step, so that long steps do not make it swing. A torque `−ω I Ω / (1 + ωΔt)` against the
    /// body's angular velocity `Ω`, with the moment of inertia `I` in the same sense, keeps what hangs from swinging.
    pub fn add_force(&mut self, model: &Model, state: &State, timestep: f64, grip: &Grip, force: &mut [f64]) {
        if model.nv == 0 {
            return;
        }
        forward_kinematics_into(model, &state.q, &state.v, &mut self.kinematics);
        mass_matrix_into(model, &self.kinematics, &mut self.mass);
        // A singular mass matrix ends the step with an error of its own.
        let Ok(factor) = self.mass.matrix.factor() else { return };
        let pose = &self.kinematics.pose[grip.body.index()];
        let point = pose.position + pose.rotation * grip.point;
        let velocity = self.kinematics.point_velocity(grip.body, point);
        let (w, dt) = (FREQUENCY, timestep);
        let pull = (grip.target - point - dt * velocity) * (w * w) - velocity * (2.0 * w);
        point_jacobian_into(model, &self.kinematics, grip.body, point, &mut self.jacobian);
        self.accelerate(&factor, pull / (1.0 + 2.0 * w * dt + w * w * dt * dt), force);
        let turning = self.kinematics.angular_velocity[grip.body.index()];
        angular_jacobian_into(model, &self.kinematics, grip.body, &mut self.jacobian);
        self.accelerate(&factor, turning * (-w / (1.0 + w * dt)), force);
    }

    /// Adds `Jᵀ a m` with the present Jacobian and `m = 3 / tr(J M⁻¹ Jᵀ)`; nothing for what cannot move.
    fn accelerate(&mut self, factor: &BlockCholesky, acceleration: DVec3, force: &mut [f64]) {
        let Self { jacobian, column, .. } = self;
        let mobility: f64 = jacobian
            .chunks_exact(force.len())
            .map(|row| {
                column.copy_from_slice(row);
                factor.solve_in_place(column);
                row.iter().zip(column.iter()).map(|(a, b)| a * b).sum::<f64>()
            })
            .sum();
        if !(mobility > 0.0 && mobility.is_finite()) {
            return;
        }
        let size = acceleration * (3.0 / mobility);
        for (row, f) in jacobian.chunks_exact(force.len()).zip(size.to_array()) {
            force.iter_mut().zip(row).for_each(|(sum, j)| *sum += j * f);
        }
    }
}
