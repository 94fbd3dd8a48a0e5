//! Contact points along one normal: the facing patches of two shapes, clipped against each other in the contact plane.

use glamx::glam::{DVec2, DVec3};

use crate::clipping::{Corner, Ring, Side};
use crate::feature::Feature;
use crate::patch::Patch;

/// A contact point of two shapes in the common frame, not yet a [`ContactPoint`](signorini_multibody::ContactPoint).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub position: DVec3,
    /// Unit, from A to B.
    pub normal: DVec3,
    pub gap: f64,
    pub feature: Feature,
}

/// Directions of the contact plane and its normal, right-handed.
#[derive(Clone, Copy, Debug)]
struct Plane {
    u: DVec3,
    v: DVec3,
    n: DVec3,
}

impl Plane {
    fn new(n: DVec3) -> Self {
        let u = n.any_orthonormal_vector();
        Self { u, v: n.cross(u), n }
    }

    fn flatten(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.u.dot(p), self.v.dot(p))
    }

    fn raise(&self, p: DVec2, height: f64) -> DVec3 {
        self.u * p.x + self.v * p.y + self.n * height
    }
}

/// Buffers of [`Manifold::clip`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Manifold {
    pub patch_a: Patch,
    pub patch_b: Patch,
    /// The patches in the contact plane.
    flat_a: Vec<DVec2>,
    flat_b: Vec<DVec2>,
    corners: Vec<Corner>,
    ring: Ring,
}

impl Manifold {
    /// Appends the corners of the overlap of `patch_a` and `patch_b` seen along the unit normal `n` (A to B), whatever
    /// their gap, and returns the smallest gap (infinite if the patches do not overlap). `tolerance` (m) is the lateral
    /// distance at which patches that just miss each other still count as overlapping.
    pub fn clip(&mut self, n: DVec3, tolerance: f64, out: &mut Vec<Touch>) -> f64 {
        let plane = Plane::new(n);
        drop_far_end(&mut self.patch_a, n);
        drop_far_end(&mut self.patch_b, -n);
        for (flat, patch) in [(&mut self.flat_a, &self.patch_a), (&mut self.flat_b, &self.patch_b)] {
            flat.clear();
            flat.extend(patch.points.iter().map(|p| plane.flatten(*p)));
        }
        let (count_a, count_b) = (self.flat_a.len(), self.flat_b.len());
        self.corners.clear();
        match (count_a, count_b) {
            (0, _) | (_, 0) => {}
            (1, _) => self.point(true, tolerance),
            (_, 1) => self.point(false, tolerance),
            (2, 2) => self.lines(tolerance),
            (2, _) => self.line_in_polygon(true, tolerance),
            (_, 2) => self.line_in_polygon(false, tolerance),
            _ => self.polygons(tolerance),
        }
        let height_a = Height::new(&plane, &self.patch_a);
        let height_b = Height::new(&plane, &self.patch_b);
        let mut smallest = f64::INFINITY;
        for corner in &self.corners {
            let (za, zb) = (height_a.at(corner.p), height_b.at(corner.p));
            smallest = smallest.min(zb - za);
            let position = plane.raise(corner.p, 0.5 * (za + zb));
            out.push(Touch { position, normal: n, gap: zb - za, feature: corner.feature });
        }
        smallest
    }

    /// The single point of A (or of B) if the other patch covers it.
    fn point(&mut self, of_a: bool, tolerance: f64) {
        let (own, id, other) = if of_a {
            (&self.flat_a, self.patch_a.ids[0], &self.flat_b)
        } else {
            (&self.flat_b, self.patch_b.ids[0], &self.flat_a)
        };
        let p = own[0];
        if covers(other, p, tolerance) {
            let feature = if of_a { Feature::VertexA(id) } else { Feature::VertexB(id) };
            let next = Side::OfA([0, 0]);
            self.corners.push(Corner { p, feature, next });
        }
    }

    /// Two lines: the ends of their common part when they run along each other, else where they cross.
    fn lines(&mut self, tolerance: f64) {
        let [a, b] = [&self.flat_a, &self.flat_b].map(|flat| [flat[0], flat[1]]);
        let (ids_a, ids_b) = ([self.patch_a.ids[0], self.patch_a.ids[1]], [self.patch_b.ids[0], self.patch_b.ids[1]]);
        let (u, v) = (a[1] - a[0], b[1] - b[0]);
        let (length_a, length_b) = (u.length(), v.length());
        if length_a <= tolerance || length_b <= tolerance {
            return;
        }
        let sine = u.perp_dot(v) / (length_a * length_b);
        let next = Side::OfA([0, 0]);
        if sine.abs() < PARALLEL {
            let along = u / length_a;
            let beside = |p: DVec2| (p - a[0]).perp_dot(along).abs() <= tolerance + PARALLEL * (length_a + length_b);
            let place = |p: DVec2| (p - a[0]).dot(along);
            let (low, high) = (place(b[0]).min(place(b[1])), place(b[0]).max(place(b[1])));
            for k in 0..2 {
                let inside = place(b[k]) >= -tolerance && place(b[k]) <= length_a + tolerance;
                if inside && beside(b[k]) {
                    self.corners.push(Corner { p: b[k], feature: Feature::VertexB(ids_b[k]), next });
                }
                let inside = place(a[k]) > low + tolerance && place(a[k]) < high - tolerance;
                if inside && beside(b[0]) && beside(b[1]) {
                    self.corners.push(Corner { p: a[k], feature: Feature::VertexA(ids_a[k]), next });
                }
            }
            return;
        }
        let s = (b[0] - a[0]).perp_dot(v) / u.perp_dot(v);
        let t = (b[0] - a[0]).perp_dot(u) / u.perp_dot(v);
        let within = |x: f64, length: f64| x * length >= -tolerance && (x - 1.0) * length <= tolerance;
        if within(s, length_a) && within(t, length_b) {
            let p = 0.5 * (a[0] + u * s.clamp(0.0, 1.0) + b[0] + v * t.clamp(0.0, 1.0));
            self.corners.push(Corner { p, feature: Feature::Edges(ids_a, ids_b), next });
        }
    }

    /// The part of the line of A (or of B) that the other polygon covers.
    fn line_in_polygon(&mut self, of_a: bool, tolerance: f64) {
        let (a, b) = ((&self.flat_a, &self.patch_a.ids), (&self.flat_b, &self.patch_b.ids));
        let ((line, line_ids), (polygon, polygon_ids)) = if of_a { (a, b) } else { (b, a) };
        let ends = [line[0], line[1]];
        let ids = [line_ids[0], line_ids[1]];
        let vertex = |id| if of_a { Feature::VertexA(id) } else { Feature::VertexB(id) };
        let crossing = |side| if of_a { Feature::Edges(ids, side) } else { Feature::Edges(side, ids) };
        let mut first = (0.0, vertex(ids[0]));
        let mut last = (1.0, vertex(ids[1]));
        let turn = orientation(polygon);
        for (k, l) in sides(polygon) {
            let (p, q) = (polygon[k], polygon[l]);
            let Some(inward) = (q - p).try_normalize().map(|e| e.perp() * turn) else { continue };
            let depth = ends.map(|e| inward.dot(e - p));
            if depth[0] < -tolerance && depth[1] < -tolerance {
                return;
            }
            let cut = depth[0] / (depth[0] - depth[1]);
            let side = crossing([polygon_ids[k], polygon_ids[l]]);
            if depth[0] < -tolerance && cut > first.0 {
                first = (cut, side);
            } else if depth[1] < -tolerance && cut < last.0 {
                last = (cut, side);
            }
        }
        let length = (ends[1] - ends[0]).length();
        if (first.0 - last.0) * length > tolerance {
            return;
        }
        let next = Side::OfA([0, 0]);
        for (place, feature) in [first, last] {
            self.corners.push(Corner { p: ends[0].lerp(ends[1], place), feature, next });
        }
    }

    /// The overlap of two convex polygons, A clipping B side by side (Sutherland & Hodgman 1974).
    fn polygons(&mut self, tolerance: f64) {
        let Self { patch_a, patch_b, flat_a, flat_b, corners, ring } = self;
        let corner = |p: &DVec2, feature, next| Corner { p: *p, feature, next };
        if lies_within(flat_a, flat_b, tolerance) {
            let own = flat_a.iter().zip(&patch_a.ids);
            corners.extend(own.map(|(p, &id)| corner(p, Feature::VertexA(id), Side::OfA([id, id]))));
            return;
        }
        let count = flat_b.len();
        let own = flat_b.iter().zip(&patch_b.ids).enumerate();
        ring.begin(
            own.map(|(k, (p, &id))| corner(p, Feature::VertexB(id), Side::OfB([id, patch_b.ids[(k + 1) % count]]))),
        );
        let turn = orientation(flat_a);
        for (k, l) in sides(flat_a) {
            let (p, q) = (flat_a[k], flat_a[l]);
            if let Some(inward) = (q - p).try_normalize().map(|e| e.perp() * turn) {
                ring.cut(p, inward, [patch_a.ids[k], patch_a.ids[l]], tolerance);
            }
        }
        corners.extend(ring.corners());
    }
}

/// Whether points lie inside a polygon by more than a distance.
fn lies_within(points: &[DVec2], polygon: &[DVec2], distance: f64) -> bool {
    let turn = orientation(polygon);
    sides(polygon).all(|(k, l)| {
        let side = polygon[l] - polygon[k];
        let (inward, least) = (side.perp() * turn, distance * side.length());
        points.iter().all(|p| inward.dot(*p - polygon[k]) > least)
    })
}

/// Both ends of every side of a polygon.
fn sides(polygon: &[DVec2]) -> impl Iterator<Item = (usize, usize)> {
    let count = polygon.len();
    (0..count).map(move |k| (k, if k + 1 == count { 0 } else { k + 1 }))
}

/// A line seen almost end-on bears at the end that is farther along `n`; its length across is not well determined.
fn drop_far_end(patch: &mut Patch, n: DVec3) {
    let [p, q] = patch.points[..] else { return };
    let (line, rise) = (q - p, n.dot(q - p));
    if line.length_squared() - rise * rise < END_ON * END_ON * line.length_squared() {
        let near = usize::from(rise > 0.0);
        patch.points.swap(0, near);
        patch.ids.swap(0, near);
        patch.points.truncate(1);
        patch.ids.truncate(1);
    }
}

/// Sine to the normal below which a line is seen end-on.
const END_ON: f64 = 0.02;

/// Lines that turn from each other by less than this sine run along each other.
const PARALLEL: f64 = 1e-3;

/// +1 if the polygon runs counter-clockwise, else −1.
fn orientation(polygon: &[DVec2]) -> f64 {
    let area: f64 = polygon[1..].windows(2).map(|e| (e[0] - polygon[0]).perp_dot(e[1] - polygon[0])).sum();
    if area >= 0.0 { 1.0 } else { -1.0 }
}

fn covers(patch: &[DVec2], p: DVec2, tolerance: f64) -> bool {
    match *patch {
        [a] => (a - p).length() <= tolerance,
        [a, b] => {
            let length2 = (b - a).length_squared();
            let place = if length2 < 1e-30 { 0.0 } else { ((p - a).dot(b - a) / length2).clamp(0.0, 1.0) };
            (a.lerp(b, place) - p).length() <= tolerance
        }
        _ => {
            let turn = orientation(patch);
            sides(patch).all(|(k, l)| {
                let inward = (patch[l] - patch[k]).normalize_or_zero().perp() * turn;
                inward.dot(p - patch[k]) >= -tolerance
            })
        }
    }
}

/// Height of a patch over the contact plane, extended linearly.
struct Height {
    origin: DVec2,
    base: f64,
    slope: DVec2,
}

impl Height {
    fn new(plane: &Plane, patch: &Patch) -> Self {
        let Some(&first) = patch.points.first() else {
            return Self { origin: DVec2::ZERO, base: 0.0, slope: DVec2::ZERO };
        };
        let (origin, base) = (plane.flatten(first), plane.n.dot(first));
        let slope = match patch.points.len() {
            1 => DVec2::ZERO,
            2 => {
                let along = plane.flatten(patch.points[1]) - origin;
                let length2 = along.length_squared();
                if length2 < 1e-30 { DVec2::ZERO } else { along * ((plane.n.dot(patch.points[1]) - base) / length2) }
            }
            _ => {
                let fan = patch.points[1..].windows(2);
                let normal: DVec3 = fan.map(|e| (e[0] - first).cross(e[1] - first)).sum();
                let rise = plane.n.dot(normal);
                if rise == 0.0 { DVec2::ZERO } else { plane.flatten(normal) * (-1.0 / rise) }
            }
        };
        Self { origin, base, slope }
    }

    fn at(&self, p: DVec2) -> f64 {
        self.base + self.slope.dot(p - self.origin)
    }
}
