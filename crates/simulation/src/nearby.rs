//! What is asked of a configuration without a step: contact points, the polygon a mechanism stands on, the zero-moment point.

use signorini_collision::Reach;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Input, Kinematics, Model, StateError, forward_kinematics_into};

use crate::SimulationError;
use crate::simulation::Simulation;
use crate::workspace::Workspace;

impl Workspace {
    /// The contact points of a configuration whose gap is at most `within` (m), as a step would find them, in its order; the last step
    /// stays what it was.
    ///
    /// - `q`: `[nq]`; `input`: says where the bodies stand that are moved from outside
    /// - `within`: 0 for what touches or overlaps
    ///
    /// # Errors
    /// [`SimulationError::State`] if the length of `q` is not nq or a number is not finite.
    pub fn contacts_at(
        &mut self,
        model: &Model,
        q: &[f64],
        input: &Input,
        within: f64,
    ) -> Result<Vec<ContactPoint>, SimulationError> {
        if q.len() != model.nq {
            return Err(StateError::WrongLength { quantity: "q", expected: model.nq, found: q.len() }.into());
        }
        if let Some(index) = q.iter().position(|x| !x.is_finite()) {
            let part = "configuration".into();
            return Err(StateError::NotFinite { quantity: "q", index, part, found: q[index] }.into());
        }
        input.check(model)?;
        let mut kinematics = Kinematics::new(model);
        kinematics.place_mocap(model, input);
        forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
        // The search takes what is nearer than both bodies can move; rounding must not cost a point that touches.
        let reach = Reach { linear: within.max(0.0) + ROUNDING, angular: 0.0 };
        let mut points = Vec::new();
        self.collider.let_stand(|_| false);
        self.collider.find(model, &kinematics.pose, &vec![reach; model.bodies.len()], &mut points);
        self.collider.let_stand(|body| self.sleepers.is_asleep(body));
        points.retain(|point| point.gap <= within.max(0.0) + ROUNDING);
        Ok(points)
    }
}

impl Simulation {
    /// [`Workspace::contacts_at`] with the present input: the contact points of a configuration, without a step.
    ///
    /// # Errors
    /// As there.
    pub fn contacts_at(&mut self, q: &[f64], within: f64) -> Result<Vec<ContactPoint>, SimulationError> {
        self.workspace.contacts_at(&self.model, q, &self.input, within)
    }
}

/// Gaps of this size come from rounding, m.
const ROUNDING: f64 = 1e-9;

/// The convex hull of points as seen along a direction: the corners in their order, counter-clockwise seen against `up`. Points inside and
/// on its edges are left out; of one or two points, or of points on a line, the ends.
///
/// - `up`: unit, against gravity
///
/// # Source
/// Andrew (1979), Another efficient algorithm for convex hulls in two dimensions, Information Processing Letters 9.
pub fn support_polygon(points: &[DVec3], up: DVec3) -> Vec<DVec3> {
    let (x, y) = up.any_orthonormal_pair();
    let mut seen: Vec<(f64, f64, DVec3)> = points.iter().map(|p| (x.dot(*p), y.dot(*p), *p)).collect();
    seen.retain(|p| p.0.is_finite() && p.1.is_finite());
    seen.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)));
    seen.dedup_by(|p, q| (p.0, p.1) == (q.0, q.1));
    if seen.len() < 3 {
        return seen.into_iter().map(|p| p.2).collect();
    }
    let turn = |a: &(f64, f64, DVec3), b: &(f64, f64, DVec3), c: &(f64, f64, DVec3)| {
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    };
    let chain = |points: &mut dyn Iterator<Item = (f64, f64, DVec3)>| {
        let mut chain: Vec<(f64, f64, DVec3)> = Vec::new();
        for p in points {
            while let [.., a, b] = &chain[..] {
                if turn(a, b, &p) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let lower = chain(&mut seen.iter().copied());
    let upper = chain(&mut seen.iter().rev().copied());
    lower.into_iter().chain(upper).map(|p| p.2).collect()
}

/// The point of a plane about which a wrench has no moment along the plane: where the ground carries a mechanism (the zero-moment
/// point, and of the contact forces the centre of pressure). Nothing where no force presses on the plane.
///
/// - `force`, `moment`: N, and N·m about the world's origin, world axes
/// - `up`: unit normal of the plane; `height`: `up · p` of its points, m
///
/// # Source
/// Sardain, Bessonnet (2004), Forces acting on a biped robot: center of pressure – zero moment point, IEEE Transactions on Systems, Man,
/// and Cybernetics A 34: from `n × (m − p × f) = 0`, `p = (n × m + (n·p) f)/(n·f)`.
pub fn zero_moment_point(force: DVec3, moment: DVec3, up: DVec3, height: f64) -> Option<DVec3> {
    let pressing = up.dot(force);
    (pressing > 0.0).then(|| (up.cross(moment) + force * height) / pressing)
}
