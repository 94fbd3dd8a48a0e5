//! Manifolds reduced to the points that matter: merged, and only the corners of their outline.

use glamx::glam::{DVec2, DVec3};

use crate::manifold::Touch;
use crate::outermost::Outermost;

/// A flat contact keeps at most this many points.
const MOST: usize = 8;

/// Buffers of the reduction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reducer {
    /// Largest angle the two shapes can turn against each other within the step, rad.
    pub turn: f64,
    /// Whether all corners of an outline are kept.
    pub is_whole: bool,
    flat: Vec<(DVec2, usize)>,
    /// Those of which the outline is made.
    outer: Vec<(DVec2, usize)>,
    outline: Vec<(DVec2, usize)>,
    outermost: Outermost,
    /// What the loss of each corner of the outline costs.
    bluntness: Vec<f64>,
    /// Place and gap of the outline's corners.
    corners: Vec<(DVec2, f64)>,
    kept: Vec<Touch>,
}

impl Reducer {
    fn most(&self) -> usize {
        if self.is_whole { usize::MAX } else { MOST }
    }

    /// Reduces `touches[from..]`, which share one normal, to those within `margin` (m) and of these to the corners of
    /// their outline in the contact plane (at most 8), the deepest, and those that lie below what these span and within the
    /// reach of the turn: the others cannot come to penetrate before one of the points kept does. Points closer than a billionth of `size` are one.
    pub fn outline(&mut self, touches: &mut Vec<Touch>, from: usize, margin: f64, size: f64) {
        keep_gaps(touches, from, |gap| gap <= margin);
        if touches.len() - from < 2 {
            return;
        }
        let tolerance = 1e-8 * size;
        let n = touches[from].normal;
        let u = n.any_orthonormal_vector();
        let v = n.cross(u);
        let origin = touches[from].position;
        let flatten = |p: DVec3| DVec2::new(u.dot(p - origin), v.dot(p - origin));
        self.flat.clear();
        self.flat.extend(touches[from..].iter().enumerate().map(|(i, t)| (flatten(t.position), i)));
        if is_corner_everywhere(&self.flat, tolerance) {
            return;
        }
        let own = &touches[from..];
        let deepest = (0..own.len()).min_by(|&i, &j| own[i].gap.total_cmp(&own[j].gap)).unwrap_or(0);
        let many = if self.is_whole { usize::MAX } else { MANY };
        self.outer.clear();
        if self.flat.len() <= many {
            self.outer.extend_from_slice(&self.flat);
        } else {
            self.outermost.take(&self.flat, deepest, &mut self.outer);
        }
        merge(&mut self.outer, own, tolerance);
        convex_outline(&mut self.outer, &mut self.outline, tolerance);
        if self.outline.len() == own.len() && own.len() <= self.most() {
            return; // Nothing to leave out; the order of the points means nothing.
        }
        let most = self.most();
        drop_bluntest(&mut self.outline, &mut self.bluntness, most, deepest);
        self.kept.clear();
        self.kept.extend(self.outline.iter().map(|&(_, i)| touches[from + i]));
        let lowest = touches[from + deepest];
        if self.kept.iter().all(|t| t.gap > lowest.gap + tolerance) {
            self.kept.push(lowest);
        }
        let center = (flatten(lowest.position), lowest.gap);
        self.corners.clear();
        self.corners.extend(self.outline.iter().map(|&(p, i)| (p, touches[from + i].gap)));
        let highest = self.corners.iter().fold(lowest.gap, |highest, corner| highest.max(corner.1)) - tolerance;
        for &(p, i) in &self.flat {
            let touch = touches[from + i];
            if touch.gap >= highest {
                continue; // Nothing that the corners span is higher than they are.
            }
            let kept = i == deepest || self.outline.iter().any(|corner| corner.1 == i);
            // While the deepest point does not penetrate, this one can come closer by the turn only.
            let out_of_reach = touch.gap - lowest.gap > self.turn * (p - center.0).length() + tolerance;
            if !kept && !out_of_reach && touch.gap < covered_gap(&self.corners, center, p) - tolerance {
                self.kept.push(touch);
            }
        }
        touches.truncate(from);
        touches.extend_from_slice(&self.kept);
    }

    /// Reduces more than 8 points with one normal to their outline.
    pub fn limit(&mut self, touches: &mut Vec<Touch>, size: f64) {
        if touches.len() > MOST {
            self.outline(touches, 0, f64::INFINITY, size);
        }
    }
}

/// Drops those of `touches[from..]` whose gap is not to be kept.
pub(crate) fn keep_gaps(touches: &mut Vec<Touch>, from: usize, is_kept: impl Fn(f64) -> bool) {
    let mut end = from;
    for i in from..touches.len() {
        if is_kept(touches[i].gap) {
            touches[end] = touches[i];
            end += 1;
        }
    }
    touches.truncate(end);
}

/// Whether three or four points, in the order given, are the corners of a convex polygon.
fn is_corner_everywhere(flat: &[(DVec2, usize)], tolerance: f64) -> bool {
    (3..=4).contains(&flat.len()) && is_ring(flat, tolerance)
}

/// Whether points, in the order given, are the corners of a convex polygon, each farther than `tolerance` from the line through its neighbours.
fn is_ring(flat: &[(DVec2, usize)], tolerance: f64) -> bool {
    let count = flat.len();
    let next = |k: usize| flat[if k < count { k } else { k - count }].0;
    let turns = |sign: f64| {
        (0..count).all(|k| {
            let (a, b, c) = (next(k), next(k + 1), next(k + 2));
            let chord = c - a;
            sign * (b - a).perp_dot(chord) > tolerance * chord.length()
        })
    };
    // What turns everywhere may go round more than once, as a star does: once round it goes up and down once.
    let rises = |k: usize| next(k + 1).y > next(k).y;
    let turnings = || (0..count).filter(|&k| rises(k) != rises(k + 1)).count();
    count >= 3 && (turns(1.0) || turns(-1.0)) && turnings() == 2
}

/// Whether the first three corners of a ring turn counter-clockwise.
fn is_counter_clockwise(ring: &[(DVec2, usize)]) -> bool {
    (ring[1].0 - ring[0].0).perp_dot(ring[2].0 - ring[1].0) > 0.0
}

/// The gap at `p` that the kept points guarantee: interpolated on the triangles between the deepest point and the sides of
/// the outline; on or beyond a side, interpolated along it. Gaps change affinely with small motions, so a point above
/// this stays above the lowest of the three.
fn covered_gap(corners: &[(DVec2, f64)], deepest: (DVec2, f64), p: DVec2) -> f64 {
    let mut beyond = (0.0, f64::INFINITY);
    for (k, &(a, gap_a)) in corners.iter().enumerate() {
        let (b, gap_b) = corners[(k + 1) % corners.len()];
        let area = (a - deepest.0).perp_dot(b - deepest.0);
        let weights = [(a - p).perp_dot(b - p), (b - p).perp_dot(deepest.0 - p), (deepest.0 - p).perp_dot(a - p)];
        if area > 0.0 && weights.iter().all(|w| *w >= -1e-9 * area) {
            return (weights[0] * deepest.1 + weights[1] * gap_a + weights[2] * gap_b) / area;
        }
        let side = b - a;
        let distance = -side.normalize_or_zero().perp_dot(p - a);
        if distance >= beyond.0 {
            let along = (side.dot(p - a) / side.length_squared()).clamp(0.0, 1.0);
            beyond = (distance, gap_a + along * (gap_b - gap_a));
        }
    }
    beyond.1
}

/// Of more points than this the outermost in evenly spread directions make the outline: so many points are on round faces, of which these
/// enclose 99 %. As many as there are directions: the outline of all of them is costlier (with twice as many a step of Hightorque's Hi on its mesh feet takes 1.3 of
/// the time, 28 November 2026).
const MANY: usize = 4 * MOST;

/// Of points within `tolerance` of each other only the deepest stays; of those that are as deep to rounding the one with the simplest feature: a vertex
/// over an edge is where that edge meets two others, too, and has one name whichever of them is a last digit lower.
fn merge(flat: &mut Vec<(DVec2, usize)>, touches: &[Touch], tolerance: f64) {
    let goes_before = |a: &Touch, b: &Touch| {
        let lower = b.gap - a.gap;
        lower > AS_DEEP * tolerance || lower >= -AS_DEEP * tolerance && a.feature.rank() < b.feature.rank()
    };
    let mut end = 0;
    for k in 0..flat.len() {
        let (p, i) = flat[k];
        match (0..end).position(|m| (flat[m].0 - p).length_squared() <= tolerance * tolerance) {
            Some(m) if goes_before(&touches[i], &touches[flat[m].1]) => flat[m].1 = i,
            Some(_) => {}
            None => {
                flat[end] = (p, i);
                end += 1;
            }
        }
    }
    flat.truncate(end);
}

/// Points as deep as each other to this share of the distance at which they are one, which is 1e-12 of the size: rounding of a gap, thousandfold.
/// Chosen by: random pairs of polyhedra moved by 1e-13 (29 November 2026).
const AS_DEEP: f64 = 1e-4;

/// Corners of the convex outline, counter-clockwise, without points within `tolerance` of its sides: the points as they are, where they go round
/// it; otherwise two points far from each other, then ever the point farthest beyond a side (quickhull; Eddy 1977).
/// - `flat`: comes back in another order
fn convex_outline(flat: &mut [(DVec2, usize)], out: &mut Vec<(DVec2, usize)>, tolerance: f64) {
    out.clear();
    if flat.len() < 3 || is_ring(flat, tolerance) {
        out.extend_from_slice(flat);
        if flat.len() >= 3 && !is_counter_clockwise(flat) {
            out.reverse();
        }
        return;
    }
    let farthest_from = |p: DVec2| {
        let mut best = flat[0];
        for q in &*flat {
            if (q.0 - p).length_squared() > (best.0 - p).length_squared() {
                best = *q;
            }
        }
        best
    };
    let first = farthest_from(flat[0].0);
    let second = farthest_from(first.0);
    for side in [[first, second], [second, first]] {
        out.push(side[0]);
        let beyond = take_beyond(flat, side[0].0, side[1].0, tolerance);
        push_corners(beyond, side[0].0, side[1].0, tolerance, out);
    }
}

/// Appends the corners between the ends of a side, of points that are all beyond it.
fn push_corners(
    points: &mut [(DVec2, usize)],
    start: DVec2,
    end: DVec2,
    tolerance: f64,
    out: &mut Vec<(DVec2, usize)>,
) {
    let Some(mut corner) = points.first().copied() else { return };
    let along = end - start;
    for point in &*points {
        if along.perp_dot(point.0 - corner.0) < 0.0 {
            corner = *point;
        }
    }
    let before = take_beyond(points, start, corner.0, tolerance);
    push_corners(before, start, corner.0, tolerance, out);
    out.push(corner);
    let after = take_beyond(points, corner.0, end, tolerance);
    push_corners(after, corner.0, end, tolerance, out);
}

/// The points on the right of a side, farther than `tolerance`.
fn take_beyond(points: &mut [(DVec2, usize)], start: DVec2, end: DVec2, tolerance: f64) -> &mut [(DVec2, usize)] {
    // Distances from the side times its length.
    let along = end - start;
    let least = tolerance * along.length();
    let mut count = 0;
    for k in 0..points.len() {
        if along.perp_dot(start - points[k].0) > least {
            points.swap(k, count);
            count += 1;
        }
    }
    &mut points[..count]
}

/// Removes the corner whose loss costs the least area, never `spared`, until there are `most`.
/// - `areas`: a buffer
fn drop_bluntest(outline: &mut Vec<(DVec2, usize)>, areas: &mut Vec<f64>, most: usize, spared: usize) {
    if outline.len() <= most {
        return;
    }
    let area = |outline: &[(DVec2, usize)], k: usize| {
        let count = outline.len();
        let (a, b, c) = (outline[(k + count - 1) % count].0, outline[k].0, outline[(k + 1) % count].0);
        if outline[k].1 == spared { f64::INFINITY } else { (b - a).perp_dot(c - b) }
    };
    areas.clear();
    areas.extend((0..outline.len()).map(|k| area(outline, k)));
    while outline.len() > most {
        let Some(k) = (0..areas.len()).min_by(|&i, &j| areas[i].total_cmp(&areas[j])) else { return };
        outline.remove(k);
        areas.remove(k);
        let count = outline.len();
        for neighbour in [(k + count - 1) % count, k % count] {
            areas[neighbour] = area(outline, neighbour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every point lies within the outline, and every corner turns to the left.
    #[test]
    fn outlines_are_convex_and_hold_all_points() {
        for count in 3..70 {
            let point = |k: usize| {
                let radius = if count % 3 == 0 { 1.0 } else { 0.5 + 0.5 * (k as f64 * 3.1).sin() };
                let angle = (k * k) as f64 * 0.7;
                DVec2::new(3.0 * radius * angle.cos(), radius * angle.sin())
            };
            let points: Vec<(DVec2, usize)> = (0..count).map(|k| (point(k), k)).collect();
            let mut outline = Vec::new();
            convex_outline(&mut points.clone(), &mut outline, 1e-9);
            let corner = |k: usize| outline[k % outline.len()].0;
            for k in 0..outline.len() {
                let side = corner(k + 1) - corner(k);
                assert!(side.perp_dot(corner(k + 2) - corner(k + 1)) > 0.0, "{count}: {outline:?}");
                let beyond = |p: DVec2| -side.perp_dot(p - corner(k)) > 2e-9 * side.length();
                assert!(points.iter().all(|point| !beyond(point.0)), "{count}: {outline:?}");
            }
            assert!(outline.iter().all(|corner| point(corner.1) == corner.0));
        }
    }

    /// The areas that corners cost, all of them anew after each that is left out.
    #[test]
    fn the_corners_that_cost_least_are_left_out() {
        for count in 9..40 {
            let radius = |k: usize| 1.0 + 1e-3 * (k as f64 * 2.3).sin();
            let turn = |k: usize| std::f64::consts::TAU * (k as f64 + 0.4 * (k as f64 * 5.1).sin()) / count as f64;
            let polygon: Vec<_> = (0..count).map(|k| (DVec2::from_angle(turn(k)) * radius(k), k)).collect();
            let spared = count / 3;
            let mut expected = polygon.clone();
            while expected.len() > MOST {
                let at = |k: usize| expected[k % expected.len()].0;
                let cost = |k: usize| {
                    let (before, own, after) = (at(k + expected.len() - 1), at(k), at(k + 1));
                    (own - before).perp_dot(after - before)
                };
                let can_go = (0..expected.len()).filter(|&k| expected[k].1 != spared);
                let cheapest = can_go.min_by(|&i, &j| cost(i).total_cmp(&cost(j))).unwrap();
                expected.remove(cheapest);
            }
            let mut found = polygon;
            drop_bluntest(&mut found, &mut Vec::new(), MOST, spared);
            assert_eq!(found, expected, "of {count} corners");
        }
    }
}
