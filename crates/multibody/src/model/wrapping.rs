//! The shortest way of a string past a round obstacle, as MuJoCo defines it.
//!
//! A string that is pulled from one point to another goes straight where the obstacle is not in its way, and else touches it along a
//! geodesic. Around a sphere the way lies in the plane of its centre and the two points, around a cylinder it is a helix; both are the
//! tangents of a circle, in that plane or seen along the axis. A side site says on which side the string lies; where the site is inside
//! the obstacle, the string runs inside and touches the circle from within, at one point.
//!
//! Source: MuJoCo's documentation, "Tendon path"; the geometry is elementary.

mod sliding;

use glamx::glam::{DVec2, DVec3};

use crate::math::Pose;

/// Below this a length is none, m; MuJoCo's `mjMINVAL`, by which both decide alike.
const NOTHING: f64 = 1e-15;

/// A sphere, or a cylinder about its z axis, that counts as infinitely long.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacle {
    /// Its frame in world.
    pub pose: Pose,
    /// Its radius, m.
    pub radius: f64,
    pub is_cylinder: bool,
}

/// Where a string touches the circle that an obstacle is.
#[derive(Clone, Copy, Debug)]
struct Arc {
    first: DVec2,
    last: DVec2,
    /// The way it turns, counter-clockwise or not; 0 where it is bent inwards at one point.
    turn: f64,
    /// Its length, m.
    length: f64,
}

/// Where a string touches an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touching {
    /// The first and the last point, world, m.
    pub points: [DVec3; 2],
    /// Length of the string between them, m.
    pub length: f64,
}

impl Obstacle {
    /// Where a string between two points touches; nothing where it goes straight.
    ///
    /// - `ends`: world, m
    /// - `side`: the side site, world, m
    pub fn wrap(&self, ends: [DVec3; 2], side: Option<DVec3>) -> Option<Touching> {
        let back = self.pose.inverse();
        let [a, b] = ends.map(|p| back.transform_point(p));
        if a.length() < NOTHING || b.length() < NOTHING || self.radius < NOTHING {
            return None;
        }
        let [x, y] = self.plane(a, b);
        let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
        let arc = self.arc([a, b].map(flat), side.map(|p| back.transform_point(p)), flat)?;
        let mut touched = [arc.first, arc.last].map(|p| x * p.x + y * p.y);
        let mut length = arc.length;
        if self.is_cylinder {
            // A helix and its tangents have one slope: heights grow with the way as seen along the axis.
            let straight = [(flat(a) - arc.first).length(), (flat(b) - arc.last).length()];
            let whole = straight[0] + length + straight[1];
            let height = |way: f64| a.z + (b.z - a.z) * way / whole;
            (touched[0].z, touched[1].z) = (height(straight[0]), height(straight[0] + length));
            length = length.hypot(touched[1].z - touched[0].z);
        }
        Some(Touching { points: touched.map(|p| self.pose.transform_point(p)), length })
    }

    /// What is seen of the string in the plane of the circle.
    ///
    /// - `side`: the side site in the obstacle's frame; `flat`: its place in the plane
    fn arc(&self, [a, b]: [DVec2; 2], side: Option<DVec3>, flat: impl Fn(DVec3) -> DVec2) -> Option<Arc> {
        match side {
            Some(site) if site.length() < self.radius => {
                let point = inside(a, b, self.radius)?;
                Some(Arc { first: point, last: point, turn: 0.0, length: 0.0 })
            }
            _ => outside(a, b, side.map(flat), self.radius),
        }
    }

    /// Axes of the plane in which the obstacle is a circle, in its frame.
    fn plane(&self, a: DVec3, b: DVec3) -> [DVec3; 2] {
        if self.is_cylinder {
            return [DVec3::X, DVec3::Y];
        }
        let x = a.normalize();
        let normal = a.cross(b);
        let normal = if normal.length() < NOTHING { x.any_orthonormal_vector() } else { normal.normalize() };
        [x, normal.cross(x).normalize()]
    }
}

/// The tangents of a circle about the origin from two points outside: the points where they touch, and the arc between them.
///
/// - `side`: a point on the side where the string lies. It goes the long way around where the point is behind the centre as seen from both
///   ends, between the directions opposite to them; else the short way, which may be straight.
fn outside(a: DVec2, b: DVec2, side: Option<DVec2>, radius: f64) -> Option<Arc> {
    if a.length() < radius || b.length() < radius {
        return None;
    }
    let way = b - a;
    if way.length_squared() < NOTHING {
        return None;
    }
    let nearest = a + way * (-a.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    let is_long = side.is_some_and(|side| {
        let turn = a.perp_dot(b);
        side.perp_dot(b) * turn < 0.0 && a.perp_dot(side) * turn < 0.0
    });
    if nearest.length() > radius && !is_long {
        return None;
    }
    let tangent = |p: DVec2, turn: f64| {
        let reach = (p.length_squared() - radius * radius).max(0.0).sqrt();
        (p * radius + p.perp() * (turn * reach)) * (radius / p.length_squared())
    };
    // The short way turns from the first end to the second by less than half a circle.
    let short = if a.perp_dot(b) < 0.0 { -1.0 } else { 1.0 };
    let turn = if is_long { -short } else { short };
    let (first, last) = (tangent(a, turn), tangent(b, -turn));
    let between = first.angle_to(last) * turn;
    let swept = if between < 0.0 { between + std::f64::consts::TAU } else { between };
    Some(Arc { first, last, turn, length: radius * swept })
}

/// The point of a circle about the origin at which a string from `a` to `b` is bent inwards: both its parts make the same angle with the
/// radius there, as a ray of light that is thrown back. Nothing where the straight way meets the circle.
fn inside(a: DVec2, b: DVec2, radius: f64) -> Option<DVec2> {
    if a.length() <= radius || b.length() <= radius {
        return None;
    }
    let way = b - a;
    if way.length_squared() > NOTHING {
        let at = -a.dot(way) / way.length_squared();
        if at > 0.0 && at < 1.0 && (a + way * at).length() <= radius {
            return None;
        }
    }
    // An end that touches has the angle of one beside it.
    let shares = [a, b].map(|end| (radius / end.length()).min(1.0 - f64::EPSILON));
    let angle = a.angle_to(b).abs();
    if angle.cos() < NOTHING - 1.0 {
        return None;
    }
    // With the angle φ against the radius, the law of sines has the angle at each end: 2 φ − Σ asin(share · sin φ) = angle.
    let excess = |sin: f64, phi: f64| 2.0 * phi - shares.iter().map(|s| (s * sin).asin()).sum::<f64>() - angle;
    let mut phi = std::f64::consts::FRAC_PI_2;
    if angle < NOTHING || excess(1.0, phi) < 0.0 {
        return Some((a + b).normalize_or(DVec2::X) * radius);
    }
    // It grows from −angle and is convex, as shares are less than 1: Newton's steps go down to the root, and end where rounding turns them.
    loop {
        let (sin, cos) = phi.sin_cos();
        let slope = 2.0 - shares.iter().map(|s| s * cos / ((1.0 - s * sin) * (1.0 + s * sin)).sqrt()).sum::<f64>();
        let next = phi - excess(sin, phi) / slope;
        if !(next < phi && next > 0.0) {
            break;
        }
        phi = next;
    }
    let ([from, _], share) = if a.perp_dot(b) > 0.0 { ([a, b], shares[0]) } else { ([b, a], shares[1]) };
    let turn = DVec2::from_angle(phi - (share * phi.sin()).asin());
    Some(turn.rotate(from.normalize()) * radius)
}
