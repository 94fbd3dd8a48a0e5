//! Contact points: tangents, moving surfaces, and friction against spinning and rolling.

use signorini_contact::{ContactFrame, FrictionBound};
use signorini_multibody::{ContactPoint, GeomId, Kinematics, Model, contact_rows_into, glam::DVec3, spin_rows_into};

use super::builder::ProblemBuilder;
use crate::source::FrictionSource;
use crate::warm::point_key;

/// A lever below this, relative to the coordinates of the point, is the rounding of their difference.
const ROUNDING: f64 = 1e-14;

/// A lever below this, relative to an overlap, would have to turn by a hundred radians in the step to open it.
const POWERLESS: f64 = 1e-2;

impl ProblemBuilder {
    /// Whether some degree of freedom moves a contact point along its normal.
    pub fn is_movable(&mut self, model: &Model, kinematics: &Kinematics, point: &ContactPoint) -> bool {
        self.measure_rows(model, kinematics, point, &ContactFrame::from_normal(point.normal));
        self.rows.columns.iter().any(|column| column[0] != 0.0)
    }

    fn measure_rows(&mut self, model: &Model, kinematics: &Kinematics, point: &ContactPoint, frame: &ContactFrame) {
        let directions = [frame.normal, frame.tangent_1, frame.tangent_2];
        let bodies = (point.body_a, point.body_b);
        contact_rows_into(model, kinematics, bodies, point.position, &directions, &mut self.rows);
        self.clear_powerless_rows(point);
    }

    /// Adds a contact point; not, and `false`, where no degree of freedom moves it along its normal: no impulse could open it.
    pub(super) fn push_point(&mut self, model: &Model, kinematics: &Kinematics, point: &ContactPoint) -> bool {
        // Most points share their normal with the one before.
        let frame = match self.frames.last() {
            Some(last) if last.normal == point.normal => *last,
            _ => ContactFrame::from_normal(point.normal),
        };
        self.measure_rows(model, kinematics, point, &frame);
        if self.rows.columns.iter().all(|column| column[0] == 0.0) {
            return false;
        }
        let belt = if self.features.belts { self.belt_velocity(model, kinematics, point) } else { DVec3::ZERO };
        let frictional = point.friction > 0.0 && belt == DVec3::ZERO;
        let grained = self.features.grain && frictional && self.stretch_polygon(model, kinematics, point, &frame);
        let polygon = match (frictional, grained) {
            (false, _) => &self.frictionless,
            (true, false) => &self.polygon,
            (true, true) => &self.stretched,
        };
        let columns = self.rows.dofs.iter().map(|&k| k as u32).zip(self.rows.columns.iter().copied());
        let gap = self.pace.point(model, kinematics, point, self.problem.timestep);
        self.problem.push_contact(columns, gap, point.friction, polygon);
        if point.friction > 0.0 && !frictional {
            self.push_belt(&frame, point.friction, belt);
        }
        if self.features.spin {
            self.push_spin(model, kinematics, point, &[frame.normal, frame.tangent_1, frame.tangent_2]);
        }
        self.frames.push(frame);
        self.keys.push(point_key(point));
        true
    }

    /// Makes rows zero that hold nothing but rounding, or levers too short to open an overlap by any motion: those of a point at the
    /// centre of the ball joint that it would move. An impulse over them would be without bound.
    fn clear_powerless_rows(&mut self, point: &ContactPoint) {
        let smallest = (ROUNDING * point.position.abs().max_element()).max(-POWERLESS * point.gap);
        for r in 0..3 {
            if self.rows.columns.iter().any(|column| column[r].abs() > smallest) {
                return;
            }
            self.rows.columns.iter_mut().for_each(|column| column[r] = 0.0);
        }
    }

    /// The polygon of a contact whose friction depends on the direction: that of the settings, stretched along the grain as the
    /// contact's tangents see it; whether there is a grain.
    fn stretch_polygon(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        point: &ContactPoint,
        frame: &ContactFrame,
    ) -> bool {
        let geoms = [point.geom_a, point.geom_b].map(|id| &model.geoms[id.index()]);
        let Some((geom, grain)) = geoms.into_iter().find_map(|geom| Some((geom, geom.grain?))) else { return false };
        let axis = kinematics.pose[geom.body.index()].rotation * (geom.placement.rotation * DVec3::X);
        let angle = axis.dot(frame.tangent_2).atan2(axis.dot(frame.tangent_1));
        self.stretched.stretch(&self.polygon, grain, angle);
        true
    }

    /// Velocity of the surface of A relative to that of B by their belts, world axes: the velocity of B relative to A at which
    /// nothing slides.
    fn belt_velocity(&self, model: &Model, kinematics: &Kinematics, point: &ContactPoint) -> DVec3 {
        let surface = |id: GeomId| {
            let geom = &model.geoms[id.index()];
            kinematics.pose[geom.body.index()].rotation * (geom.placement.rotation * geom.surface_velocity)
        };
        surface(point.geom_a) - surface(point.geom_b)
    }

    /// The tangents of the last contact as a friction group with a target, in place of its own.
    fn push_belt(&mut self, frame: &ContactFrame, friction: f64, velocity: DVec3) {
        let contact = self.problem.contact_count() - 1;
        let target = [frame.tangent_1.dot(velocity), frame.tangent_2.dot(velocity)];
        let columns = self.rows.dofs.iter().zip(&self.rows.columns).map(|(&k, c)| (k as u32, [c[1], c[2]]));
        let bound = FrictionBound::Normal { contact, coefficient: friction };
        self.problem.push_friction(columns, target, bound, &self.polygon);
        self.friction_source.push(FrictionSource::Belt { contact });
    }

    /// Friction of the last contact against spinning about the normal and against rolling, each with its own bound.
    fn push_spin(&mut self, model: &Model, kinematics: &Kinematics, point: &ContactPoint, directions: &[DVec3; 3]) {
        let [spinning, rolling] = model.pair_spin_friction(point.geom_a, point.geom_b);
        if spinning == 0.0 && rolling == 0.0 {
            return;
        }
        let contact = self.problem.contact_count() - 1;
        spin_rows_into(model, kinematics, (point.body_a, point.body_b), directions, &mut self.rows);
        let columns = || self.rows.dofs.iter().map(|&k| k as u32).zip(&self.rows.columns);
        if spinning > 0.0 {
            let bound = FrictionBound::Normal { contact, coefficient: spinning };
            self.problem.push_friction_row(columns().map(|(k, c)| (k, c[0])), 0.0, bound);
            self.friction_source.push(FrictionSource::Spinning { contact });
        }
        if rolling > 0.0 {
            let bound = FrictionBound::Normal { contact, coefficient: rolling };
            self.problem.push_friction(columns().map(|(k, c)| (k, [c[1], c[2]])), [0.0; 2], bound, &self.polygon);
            self.friction_source.push(FrictionSource::Rolling { contact });
        }
    }
}
