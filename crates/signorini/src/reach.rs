//! How far bodies can move within a step, so that no contact is missed.
//!
//! Candidates are found before the velocity at the end of the step is known. The reach starts from the velocities at the
//! beginning and without contact, with a factor to spare; after the solve it is compared with the true motion, and where a
//! body outran its reach (one that was struck, say) the step is found and solved again with more.

use signorini_collision::Reach;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Kinematics, Model};

/// Factor between a velocity and the reach it is given.
const MARGIN: f64 = 2.0;

/// Travel beyond the reach that is rounding of a body at rest, m or rad: no gap that it could close matters.
const NEGLIGIBLE: f64 = 1e-12;

/// The reach of every body, and the velocities it was made from.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyReach {
    pub reach: Vec<Reach>,
    angular: Vec<DVec3>,
    linear: Vec<DVec3>,
}

impl BodyReach {
    /// The reach for the generalized velocities `v` (at the beginning of the step) and `v_free`.
    pub fn start(&mut self, model: &Model, kinematics: &Kinematics, velocities: [&[f64]; 2], dt: f64) {
        self.reach.clear();
        self.reach.resize(model.bodies.len(), Reach { linear: 0.0, angular: 0.0 });
        for v in velocities {
            self.body_velocities(model, kinematics, v);
            for (i, reach) in self.reach.iter_mut().enumerate() {
                reach.linear = reach.linear.max(MARGIN * dt * self.linear[i].length());
                reach.angular = reach.angular.max(MARGIN * dt * self.angular[i].length());
            }
        }
    }

    /// Enlarges the reach of every body that `v` moves beyond it; whether there was one.
    pub fn enlarge(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], dt: f64) -> bool {
        self.body_velocities(model, kinematics, v);
        let mut exceeded = false;
        for (i, reach) in self.reach.iter_mut().enumerate() {
            for (travel, limit) in
                [(dt * self.linear[i].length(), &mut reach.linear), (dt * self.angular[i].length(), &mut reach.angular)]
            {
                if travel > *limit * (1.0 + 1e-9) + NEGLIGIBLE {
                    *limit = MARGIN * travel;
                    exceeded = true;
                }
            }
        }
        exceeded
    }

    /// Velocities of all bodies for a generalized velocity at the configuration of `kinematics`, world axes.
    fn body_velocities(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        self.angular.clear();
        self.linear.clear();
        for (i, body) in model.bodies.iter().enumerate() {
            if i == 0 {
                self.angular.push(DVec3::ZERO);
                self.linear.push(DVec3::ZERO);
                continue;
            }
            let parent = body.parent.index();
            let mut angular = self.angular[parent];
            let mut linear = self.linear[parent] + angular.cross(kinematics.offset[i]);
            for joint in model.joints_of(BodyId(i as u32)) {
                for k in joint.v_index..joint.v_index + joint.kind.nv() {
                    angular += kinematics.dof_angular[k] * v[k];
                    linear += kinematics.dof_linear[k] * v[k];
                }
            }
            self.angular.push(angular);
            self.linear.push(linear);
        }
    }
}
