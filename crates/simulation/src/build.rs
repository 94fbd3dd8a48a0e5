//! Contact points, limits, constraints and further friction become a contact problem.

mod builder;
mod dependent;
mod level;
mod limits;
mod mechanism;
mod pace;
pub(crate) mod rows;
mod surfaces;

use signorini_multibody::{ContactPoint, Input, Kinematics, Model, State};

use crate::settings::RestitutionLaw;
use crate::warm::group_key;

pub(crate) use builder::{Impact, ProblemBuilder, is_impact};
pub use level::Level;
use level::{level, take_back};

impl ProblemBuilder {
    /// Fills in the contacts (the points in their order, then the limits that can be reached), the constraints, and the
    /// friction of joints and servos. Points that no degree of freedom moves along their normal are taken out.
    pub fn build(
        &mut self,
        model: &Model,
        state: &State,
        input: &Input,
        kinematics: &Kinematics,
        points: &mut Vec<ContactPoint>,
    ) {
        self.left_out.clear();
        self.push_points(model, kinematics, points);
        if !self.left_out.is_empty() && self.levels.iter().any(|level| level.patch.len() > 1) {
            // The heights of patches are those of the points that are in them.
            take_back(points, &self.levels);
            self.push_points(model, kinematics, points);
        }
        self.impacts.clear();
        if self.features.restitution {
            self.find_impacts(model, state, points);
        }
        self.push_limits(model, kinematics, state);
        self.push_equalities(model, kinematics, state);
        self.push_joint_friction(model);
        self.push_servos(model, kinematics, state, input);
        self.group_keys.clear();
        self.group_keys.extend(self.friction_source.iter().map(|&source| group_key(source, &self.keys)));
    }

    /// Begins with the points; those that no degree of freedom moves are taken out.
    fn push_points(&mut self, model: &Model, kinematics: &Kinematics, points: &mut Vec<ContactPoint>) {
        self.problem.clear_contacts();
        self.frames.clear();
        self.keys.clear();
        self.limits.clear();
        self.friction_source.clear();
        let mut levels = std::mem::take(&mut self.levels);
        level(points, &mut levels);
        let (mut at, mut kept) = (0, 0);
        points.retain(|point| {
            let is_movable = self.push_point(model, kinematics, point);
            if is_movable {
                levels.swap(kept, at);
                if levels[kept].patch.len() == 1 {
                    levels[kept].patch = kept..kept + 1;
                }
                kept += 1;
            } else {
                self.left_out.push(levels[at].midway(point));
            }
            at += 1;
            is_movable
        });
        levels.truncate(kept);
        self.levels = levels;
    }

    /// Finds the contacts that restore velocity, and puts their law in place of the gap row (formulation §7).
    ///
    /// An impact is a contact that approaches faster than gravity moves anything in a step and closes within it; what is
    /// slower rests. With Newton's law its row is `c_N⁺ + e c_N⁻ ≥ 0`; with Poisson's the compression ends at `c_N⁺ ≥ 0`.
    /// A penetration is corrected by the same row if that asks for more.
    fn find_impacts(&mut self, model: &Model, state: &State, points: &[ContactPoint]) {
        let dt = self.problem.timestep;
        let at_rest = model.gravity.length() * dt;
        for (contact, point) in points.iter().enumerate() {
            let restitution = model.pair_restitution(point.geom_a, point.geom_b);
            let [approach, ..] = self.problem.contact_velocity(contact, &state.v);
            let [free, ..] = self.problem.contact_velocity(contact, &self.problem.free_velocity);
            if restitution > 0.0 && approach < -at_rest && point.gap + dt * approach.min(free) <= 0.0 {
                let (rebound, restitution) = match self.law {
                    RestitutionLaw::Newton => (dt * restitution * approach, restitution),
                    // What the forces of the step add to the compression is weight and not impact: it is not restored.
                    RestitutionLaw::Poisson if free < approach => (0.0, restitution * approach / free),
                    RestitutionLaw::Poisson => (0.0, restitution),
                };
                self.problem.gap[contact] = self.problem.gap[contact].min(rebound);
                self.impacts.push(Impact { contact, restitution });
            }
        }
    }
}
