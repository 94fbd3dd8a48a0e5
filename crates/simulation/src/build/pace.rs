//! How fast a step removes overlaps and violations: in full where the motion of the step before has left them, at a bounded speed
//! where they come from elsewhere.
//!
//! A step takes its constraints as linear and so leaves `½ Δt² |J̇v|` of violation, which the next one removes as the scheme of
//! Anitescu & Hart has it. What is more was there at the start or has come from outside; to remove that in one step would be a blow.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BodyId, ContactPoint, EqualityBlock, EqualityKind, Frame, JointKind, Kinematics, Model, Pose, ReferenceFrame,
    SpatialVector, State, TendonId, frame_bias_acceleration,
};

use crate::settings::Settings;

/// Overlaps below this part of a body's size are rounding.
const ROUNDING: f64 = 1e-9;

/// Distances of so many last digits of what they are differences of are zero. Where bodies rest they have one sign or the other, and modes changed with it from step to
/// step (stacked meshes took twice the factorisations; they took as many as with 1e-15 m with 1e-14 m).
pub(super) const LAST_DIGITS: f64 = 8.0 * f64::EPSILON;

/// Speeds of corrections, and the sizes that overlaps are compared with.
#[derive(Clone, Debug)]
pub(super) struct CorrectionPace {
    pub stabilization: f64,
    /// Gaps of at most this are none, m.
    resolution: f64,
    speed: f64,
    angular_speed: f64,
    /// Radius of the ball about each geom, m.
    radius: Vec<f64>,
}

impl CorrectionPace {
    pub fn new(model: &Model, settings: &Settings) -> Self {
        Self {
            stabilization: settings.stabilization,
            resolution: settings.gap_resolution,
            speed: settings.correction_speed,
            angular_speed: settings.correction_angular_speed,
            radius: model.geoms.iter().map(|geom| geom.geometry.bounding_radius()).collect(),
        }
    }

    /// Whether an overlap is more than rounding.
    pub fn is_overlap(&self, point: &ContactPoint) -> bool {
        -point.gap > self.resolution.max(ROUNDING * self.size(point))
    }

    /// The radius of the smaller of two geoms, m.
    fn size(&self, point: &ContactPoint) -> f64 {
        self.radius[point.geom_a.index()].min(self.radius[point.geom_b.index()])
    }

    /// Whether a gap is so small that the step's problem has it as zero.
    pub fn is_last_digits(&self, point: &ContactPoint) -> bool {
        rounded(point.gap, point.position.length() + self.size(point)) == 0.0
    }

    /// The gap of a contact point beyond the resolution.
    pub fn resolved(&self, point: &ContactPoint) -> f64 {
        if point.gap.abs() <= self.resolution {
            0.0
        } else if point.gap < 0.0 {
            point.gap + self.resolution
        } else {
            point.gap
        }
    }

    /// The gap of a contact point that counts: beyond the resolution, and last digits.
    pub fn counted(&self, point: &ContactPoint) -> f64 {
        if self.is_last_digits(point) { 0.0 } else { self.resolved(point) }
    }

    /// The gap of a contact point as the step's problem has it.
    pub fn point(&self, model: &Model, kinematics: &Kinematics, point: &ContactPoint, dt: f64) -> f64 {
        let gap = self.counted(point);
        if gap >= 0.0 {
            return gap;
        }
        let swing = || {
            let (a, b) = (point.body_a, point.body_b);
            let turning = [a, b].map(|body| kinematics.angular_velocity[body.index()].length());
            let slip = kinematics.point_velocity(b, point.position) - kinematics.point_velocity(a, point.position);
            // The normal turns with the body that it belongs to.
            let turned = 2.0 * (turning[0] + turning[1]) * slip.length();
            relative_swing(model, kinematics, [a, b], point.position).length() + turned
        };
        self.bounded(gap, dt, self.speed, swing)
    }

    /// The distance to a limit of a joint as the step's problem has it. Limits are linear in their coordinate, but for the cone of a
    /// ball joint.
    pub fn joint_limit(&self, model: &Model, state: &State, joint: usize, gap: f64, dt: f64) -> f64 {
        let joint = &model.joints[joint];
        let speed = if matches!(joint.kind, JointKind::Slide { .. }) { self.speed } else { self.angular_speed };
        let rates = &state.v[joint.v_index..joint.v_index + joint.kind.nv()];
        let curved = joint.kind == JointKind::Ball;
        self.bounded(rounded(gap, 1.0), dt, speed, || if curved { rates.iter().map(|w| w * w).sum() } else { 0.0 })
    }

    /// The distance to a limit of a tendon as the step's problem has it.
    ///
    /// - `swing`: a bound of the second derivative of the length when `v̇ = 0`
    pub fn tendon_limit(&self, gap: f64, dt: f64, swing: impl FnOnce() -> f64) -> f64 {
        self.bounded(rounded(gap, 1.0), dt, self.speed, swing)
    }

    /// The part of a block's violation that the step's problem has, in [0, 1].
    ///
    /// - `equality`: the constraint and which of its blocks it is
    pub fn block_part(
        &self,
        model: &Model,
        kinematics: &Kinematics,
        state: &State,
        equality: (&EqualityKind, usize),
        block: &EqualityBlock,
        dt: f64,
    ) -> f64 {
        let size = DVec3::from(block.violation).length();
        let angular = match *equality.0 {
            EqualityKind::Connect { .. } | EqualityKind::Tendon { .. } => false,
            EqualityKind::Weld { .. } => equality.1 == 1,
            EqualityKind::Joint { joint, .. } => !matches!(model.joints[joint.index()].kind, JointKind::Slide { .. }),
        };
        let speed = if angular { self.angular_speed } else { self.speed };
        let asked = self.stabilization * size;
        if asked <= dt * speed {
            return self.stabilization;
        }
        asked.min(dt * (speed + dt * block_swing(model, kinematics, state, equality))) / size
    }

    /// The part γ of a gap that is negative, at most what `speed` removes in a step, and what linearising has left: `swing` is the
    /// second derivative of the gap when `v̇ = 0`, or more.
    fn bounded(&self, gap: f64, dt: f64, speed: f64, swing: impl FnOnce() -> f64) -> f64 {
        if gap >= 0.0 {
            return gap;
        }
        let asked = self.stabilization * gap;
        if -asked <= dt * speed { asked } else { asked.max(-dt * (speed + dt * swing())) }
    }
}

/// Size of the second derivative of a block's violation when `v̇ = 0`.
fn block_swing(model: &Model, kinematics: &Kinematics, state: &State, (kind, block): (&EqualityKind, usize)) -> f64 {
    let of_points = |a, b| {
        let [a, b] = [a, b].map(|end| swing(model, kinematics, end).linear);
        (b - a).length()
    };
    match *kind {
        EqualityKind::Connect { body_a, point_a, body_b, point_b } => of_points((body_a, point_a), (body_b, point_b)),
        EqualityKind::Weld { body_a, frame_a, body_b, frame_b } if block == 0 => {
            of_points((body_a, frame_a.position), (body_b, frame_b.position))
        }
        EqualityKind::Weld { body_a, body_b, .. } => {
            let turning = [body_a, body_b].map(|body| kinematics.angular_velocity[body.index()].length());
            let [a, b] = [body_a, body_b].map(|body| swing(model, kinematics, (body, DVec3::ZERO)).angular);
            (b - a).length() + turning[0] * turning[1]
        }
        EqualityKind::Joint { driver, polynomial, .. } => {
            let joint = driver.map(|driver| &model.joints[driver.index()]);
            joint.map_or(0.0, |joint| {
                bend(polynomial, state.q[joint.q_index] - joint.reference).abs() * state.v[joint.v_index].powi(2)
            })
        }
        EqualityKind::Tendon { tendon, driver, polynomial } => {
            tendon_swing(model, kinematics, state, (tendon, driver), polynomial)
        }
    }
}

/// Acceleration of a body's point and angular acceleration when `v̇ = 0`, world axes; `point` in the body's frame.
fn swing(model: &Model, kinematics: &Kinematics, (body, point): (BodyId, DVec3)) -> SpatialVector {
    let frame = Frame { body, placement: Pose::from_position(point) };
    frame_bias_acceleration(model, kinematics, &frame, ReferenceFrame::LocalWorldAligned)
}

/// Acceleration of B's material point relative to A's at a point in world when `v̇ = 0`.
fn relative_swing(model: &Model, kinematics: &Kinematics, [a, b]: [BodyId; 2], point: DVec3) -> DVec3 {
    let at = |body: BodyId| {
        let pose = &kinematics.pose[body.index()];
        swing(model, kinematics, (body, pose.rotation.conjugate() * (point - pose.position))).linear
    };
    at(b) - at(a)
}

/// Second derivative of the difference between the length of a tendon and what another one makes of it, or more.
fn tendon_swing(
    model: &Model,
    kinematics: &Kinematics,
    state: &State,
    (tendon, driver): (TendonId, Option<TendonId>),
    polynomial: [f64; 5],
) -> f64 {
    let own = model.tendons[tendon.index()].swing(model, kinematics);
    let Some(driver) = driver.map(|driver| &model.tendons[driver.index()]) else { return own };
    let x = driver.length(model, kinematics, &state.q) - driver.reference_length;
    own + slope(polynomial, x).abs() * driver.swing(model, kinematics)
        + bend(polynomial, x).abs() * driver.rate(model, kinematics, &state.v).powi(2)
}

/// First derivative of `Σ a_k x^k`.
fn slope([_, a_1, a_2, a_3, a_4]: [f64; 5], x: f64) -> f64 {
    a_1 + x * (2.0 * a_2 + x * (3.0 * a_3 + x * 4.0 * a_4))
}

/// Its second derivative.
fn bend([_, _, a_2, a_3, a_4]: [f64; 5], x: f64) -> f64 {
    2.0 * a_2 + x * (6.0 * a_3 + x * 12.0 * a_4)
}

/// A distance, and zero where it is rounding of differences of numbers of this size.
pub(super) fn rounded(gap: f64, size: f64) -> f64 {
    if gap.abs() <= LAST_DIGITS * size { 0.0 } else { gap }
}
