//! What a verdict means for the bodies and contacts of a model.

use signorini_contact::ContactSolution;
use signorini_contact::statics::Verdict;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Input, Kinematics, Model, State, body_velocities_into, forward_kinematics_into};

use crate::model::ModelStability;

/// How a body takes part in a mechanism or a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyMotion {
    /// The body.
    pub body: BodyId,
    /// Velocity of its origin in world, m/s; of a mechanism in units of the fastest body's.
    pub linear: DVec3,
    /// Angular velocity in world, rad/s; of a mechanism in the same unit by metre.
    pub angular: DVec3,
}

/// The force of a contact in a balance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactForce {
    /// Index of the contact in the problem.
    pub contact: usize,
    /// Normal force, N; of a limit N or N·m. Negative where what [attracts](crate::Attraction) the bodies is needed to hold them.
    pub normal: f64,
    /// Force on body B in world, N; zero for limits.
    pub force: DVec3,
    /// The part of its friction that is used, in the polygon's gauge: 1 at the bound, 0 without friction.
    pub friction_use: f64,
}

impl ModelStability {
    /// Forces of the balance, where the verdict has one.
    pub fn forces(&self) -> Vec<ContactForce> {
        self.stability.proof.balance.as_ref().map_or(Vec::new(), |balance| self.contact_forces(balance))
    }

    /// How bodies move: in the collapse of `must_move`, whose fastest body has speed 1, or in the first step of the moving solution of
    /// `may_do_either`. Bodies that stay are left out.
    ///
    /// - `model`, `state`, `input`: those that were judged
    pub fn motion(&self, model: &Model, state: &State, input: &Input) -> Vec<BodyMotion> {
        let proof = &self.stability.proof;
        let (velocity, is_virtual) = match proof.verdict {
            Verdict::MustMove => (self.stability.collapse.as_deref(), true),
            _ => (proof.moving.as_ref().map(|moving| moving.velocity.as_slice()), false),
        };
        let Some(velocity) = velocity.filter(|v| v.len() == model.nv) else { return Vec::new() };
        let mut kinematics = Kinematics::new(model);
        kinematics.place_mocap(model, input);
        forward_kinematics_into(model, &state.q, velocity, &mut kinematics);
        let (mut angular, mut linear) = (Vec::new(), Vec::new());
        body_velocities_into(model, &kinematics, velocity, &mut angular, &mut linear);
        let speeds = linear.iter().zip(&angular).map(|(v, w)| v.length().max(w.length()));
        let fastest = speeds.fold(0.0, f64::max);
        let unit = if is_virtual && fastest > 0.0 { fastest } else { 1.0 };
        let all = linear.into_iter().zip(angular).enumerate();
        let moves = |body: &BodyMotion| body.linear.length().max(body.angular.length()) > STAYS * fastest / unit;
        all.map(|(i, (v, w))| BodyMotion { body: BodyId(i as u32), linear: v / unit, angular: w / unit })
            .filter(moves)
            .collect()
    }
}

/// Bodies slower than this part of the fastest one stay.
const STAYS: f64 = 1e-6;

impl ModelStability {
    fn contact_forces(&self, balance: &ContactSolution) -> Vec<ContactForce> {
        let (rest, problem) = (&self.rest, &self.rest.problem);
        let of = |i: usize| {
            let bound = problem.friction[i] * balance.lambda_n[i];
            let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
            let used: f64 = balance.alpha[range].iter().sum();
            let mut impulse = balance.impulse[i];
            impulse[0] -= self.attraction[i] * problem.timestep;
            let force = rest.frames.get(i).map_or(DVec3::ZERO, |frame| frame.to_world(impulse));
            ContactForce {
                contact: i,
                normal: balance.lambda_n[i] / problem.timestep - self.attraction[i],
                force: force / problem.timestep,
                friction_use: if bound > 0.0 { used / bound } else { 0.0 },
            }
        };
        (0..problem.contact_count()).map(of).collect()
    }
}
