//! The convex outline of points in a plane.

use glamx::glam::DVec2;

/// Indices of the corners of the convex hull of points in a plane, counter-clockwise from the leftmost one, the lowest of those. What lies on a side, or
/// where another corner is, is no corner; of points on a line the ends are left, of points at one place one of them.
///
/// # Cost
/// O(n log n).
///
/// # Source
/// A. M. Andrew, Another efficient algorithm for convex hulls in two dimensions, Information Processing Letters 9 (1979).
pub fn convex_outline(points: &[DVec2]) -> Vec<usize> {
    // One zero alone: in the order of numbers the negative one comes first, whatever y is.
    let place = |i: usize| points[i] + DVec2::ZERO;
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&i, &j| place(i).x.total_cmp(&place(j).x).then(place(i).y.total_cmp(&place(j).y)).then(i.cmp(&j)));
    order.dedup_by(|j, i| place(*i) == place(*j));
    if order.len() < 2 {
        return order;
    }
    let mut corners = chain(order.iter().copied(), place);
    corners.extend(chain(order.iter().rev().copied(), place));
    corners
}

/// The corners of the hull on the right of the way through points in order, without the last one.
fn chain(points: impl Iterator<Item = usize>, place: impl Fn(usize) -> DVec2) -> Vec<usize> {
    let mut corners: Vec<usize> = Vec::new();
    for i in points {
        while let [.., a, b] = corners[..]
            && (place(b) - place(a)).perp_dot(place(i) - place(a)) <= 0.0
        {
            corners.pop();
        }
        corners.push(i);
    }
    corners.pop();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a point is a corner of the hull, by its definition: it is on no line between two others and in no triangle of others.
    fn is_corner(points: &[DVec2], i: usize) -> bool {
        let p = points[i];
        let others: Vec<DVec2> = points.iter().copied().filter(|q| *q != p).collect();
        let between = |a: DVec2, b: DVec2| (a - p).perp_dot(b - p) == 0.0 && (a - p).dot(b - p) < 0.0;
        let inside = |a: DVec2, b: DVec2, c: DVec2| {
            let [x, y, z] = [(a, b), (b, c), (c, a)].map(|(a, b)| (a - p).perp_dot(b - p));
            (x > 0.0 && y > 0.0 && z > 0.0) || (x < 0.0 && y < 0.0 && z < 0.0)
        };
        let pairs = || others.iter().flat_map(|a| others.iter().map(move |b| (*a, *b)));
        !pairs().any(|(a, b)| between(a, b) || others.iter().any(|c| inside(a, b, *c)))
    }

    /// Points of a coarse grid, where many lie on lines and at one place and all products are exact.
    #[test]
    fn the_corners_are_those_of_the_definition() {
        let mut state = 7_u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % n
        };
        for case in 0..400 {
            let size = 1 + case % 7;
            let points: Vec<DVec2> =
                (0..below(15)).map(|_| DVec2::new(below(size) as f64 - 3.0, below(size) as f64 - 3.0)).collect();
            let corners = convex_outline(&points);
            let mut found: Vec<[f64; 2]> = corners.iter().map(|i| points[*i].to_array()).collect();
            let mut wanted: Vec<[f64; 2]> =
                (0..points.len()).filter(|i| is_corner(&points, *i)).map(|i| points[i].to_array()).collect();
            for places in [&mut found, &mut wanted] {
                places.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
            }
            wanted.dedup();
            assert_eq!(found, wanted, "{points:?}");
            for k in 0..if corners.len() < 3 { 0 } else { corners.len() } {
                let [a, b, c] = [0, 1, 2].map(|step| points[corners[(k + step) % corners.len()]]);
                assert!((b - a).perp_dot(c - b) > 0.0, "{points:?}: {corners:?}");
            }
        }
    }

    #[test]
    fn zeros_of_either_sign_are_one_number() {
        let points = [(-0.0, 4.0), (0.0, -6.0), (0.0, 0.0), (6.0, -6.0), (6.0, 4.0), (-0.0, 1.0)].map(DVec2::from);
        assert_eq!(convex_outline(&points), [1, 3, 4, 0]);
    }
}
