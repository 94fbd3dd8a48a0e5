//! How the points where a string touches an obstacle slide when its ends move.

use glamx::glam::{DVec2, DVec3};

use super::{Arc, Obstacle};

/// A point or a direction in the plane of the circle, and its change.
type Moving = (DVec2, DVec2);

impl Obstacle {
    /// How the touching points of [`wrap`](Self::wrap) move relative to the obstacle; nothing where the string goes straight, or where the
    /// way of the point at which it is bent inwards is not smooth.
    ///
    /// - `ends`, `side`: as there
    /// - `moves`: of the ends relative to the obstacle, world axes
    pub fn slide(&self, ends: [DVec3; 2], side: Option<DVec3>, moves: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let (back, turn) = (self.pose.inverse(), self.pose.rotation);
        let [a, b] = ends.map(|p| back.transform_point(p));
        let [da, db] = moves.map(|d| turn.conjugate() * d);
        let [x, y] = self.plane(a, b);
        let [dx, dy] = if self.is_cylinder { [DVec3::ZERO; 2] } else { plane_turns([a, b], [da, db], [x, y]) };
        let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
        let moving = |p: DVec3, d: DVec3| (flat(p), flat(d) + DVec2::new(p.dot(dx), p.dot(dy)));
        let seen = [moving(a, da), moving(b, db)];
        let arc = self.arc(seen.map(|(p, _)| p), side.map(|p| back.transform_point(p)), flat)?;
        let [first, last] = if arc.turn == 0.0 {
            [inwards(seen, arc.first, self.radius)?; 2]
        } else {
            [along_tangent(seen[0], self.radius, arc.turn), along_tangent(seen[1], self.radius, -arc.turn)]
        };
        let space = |p: DVec2, d: DVec2| x * d.x + y * d.y + dx * p.x + dy * p.y;
        let mut slid = [space(arc.first, first), space(arc.last, last)];
        if self.is_cylinder {
            let heights = heights([a.z, b.z], [da.z, db.z], seen, (&arc, [first, last]), self.radius);
            (slid[0].z, slid[1].z) = (heights[0], heights[1]);
        }
        Some(slid.map(|d| turn * d))
    }

    /// How far a string is from another kind of way past the obstacle, as parts of its radius or in rad.
    ///
    /// - `ends`, `side`: as of [`wrap`](Self::wrap)
    pub fn clearance(&self, ends: [DVec3; 2], side: Option<DVec3>) -> f64 {
        let back = self.pose.inverse();
        let [a, b] = ends.map(|p| back.transform_point(p));
        let [x, y] = self.plane(a, b);
        let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
        let side = side.map(|p| back.transform_point(p));
        let (p, q, r) = (flat(a), flat(b), self.radius);
        let outside = (p.length() / r - 1.0).abs().min((q.length() / r - 1.0).abs());
        let way = q - p;
        let nearest = p + way * (-p.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        let mut least = outside.min((nearest.length() / r - 1.0).abs());
        if let Some(site) = side {
            least = least.min((site.length() / r - 1.0).abs());
            let turn = p.perp_dot(q).signum();
            let site = flat(site).normalize_or_zero();
            let sides = [site.perp_dot(q) * turn / q.length(), p.perp_dot(site) * turn / p.length()];
            // It goes the long way where both are negative.
            let [low, high] = [sides[0].min(sides[1]), sides[0].max(sides[1])];
            least = least.min(if high < 0.0 { -high } else { high.max(low) });
        }
        if nearest.length() < r || side.is_some() {
            // Opposite ends: it may go around on either side.
            least = least.min(p.perp_dot(q).abs() / (p.length() * q.length()));
        }
        least
    }
}

/// How the axes of a sphere's plane turn.
fn plane_turns([a, b]: [DVec3; 2], [da, db]: [DVec3; 2], [x, y]: [DVec3; 2]) -> [DVec3; 2] {
    let across = |d: DVec3, unit: DVec3| d - unit * unit.dot(d);
    let dx = across(da, x) / a.length();
    let normal = x.cross(y);
    let turned = across(da.cross(b) + a.cross(db), normal) / a.cross(b).dot(normal);
    [dx, turned.cross(x) + normal.cross(dx)]
}

/// The change of a direction's angle.
fn turning((p, d): Moving) -> f64 {
    p.perp_dot(d) / p.length_squared()
}

/// The change of the point where the tangent from `p` touches: at the angle `acos(r/|p|)` from it.
fn along_tangent(p: Moving, radius: f64, turn: f64) -> DVec2 {
    let distance = p.0.length();
    let reach = (distance * distance - radius * radius).max(0.0).sqrt();
    let opening = radius * p.0.dot(p.1) / (distance * distance * reach);
    let point = (p.0 * radius + p.0.perp() * (turn * reach)) * (radius / p.0.length_squared());
    point.perp() * (turning(p) + turn * opening)
}

/// The change of the point at which a string is bent inwards: its angle against the radius follows from `2 φ − Σ asin(sᵢ sin φ) = angle`
/// with `sᵢ` the radius over the distances.
fn inwards([a, b]: [Moving; 2], point: DVec2, radius: f64) -> Option<DVec2> {
    // Counter-clockwise from the first to the second.
    let [from, to] = if a.0.perp_dot(b.0) > 0.0 { [a, b] } else { [b, a] };
    let phi = point.angle_to(from.0 - point).abs();
    let (sine, cosine) = phi.sin_cos();
    let share = |p: Moving| {
        let distance = p.0.length();
        let s = radius / distance;
        (s, -s * p.0.dot(p.1) / (distance * distance))
    };
    let root = |s: f64| (1.0 - (s * sine).powi(2)).sqrt();
    let mut slope = 2.0;
    let mut change = turning(to) - turning(from);
    for (s, ds) in [share(from), share(to)] {
        slope -= s * cosine / root(s);
        change += sine * ds / root(s);
    }
    let opened = change / slope;
    let (s, ds) = share(from);
    let turned = turning(from) + opened - (ds * sine + s * cosine * opened) / root(s);
    (turned.is_finite() && cosine > 0.0).then(|| point.perp() * turned)
}

/// Changes of the heights at which a helix begins and ends: they grow with the way as seen along the axis.
fn heights(
    [a, b]: [f64; 2],
    [da, db]: [f64; 2],
    seen: [Moving; 2],
    (arc, [first, last]): (&Arc, [DVec2; 2]),
    radius: f64,
) -> [f64; 2] {
    let straight = |(p, d): Moving, touched: DVec2, slid: DVec2| {
        let way = p - touched;
        (way.length(), way.dot(d - slid) / way.length())
    };
    let (begin, d_begin) = straight(seen[0], arc.first, first);
    let (end, d_end) = straight(seen[1], arc.last, last);
    let d_arc = radius * arc.turn * (turning((arc.last, last)) - turning((arc.first, first)));
    let (whole, d_whole) = (begin + arc.length + end, d_begin + d_arc + d_end);
    let height = |way: f64, d_way: f64| {
        let (part, d_part) = (way / whole, (d_way - way / whole * d_whole) / whole);
        da + (db - da) * part + (b - a) * d_part
    };
    [height(begin, d_begin), height(begin + arc.length, d_begin + d_arc)]
}
