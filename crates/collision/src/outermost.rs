//! The outermost of many points of a plane, in evenly spread directions.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glamx::glam::DVec2;
use pulp::{Arch, Simd, WithSimd};

/// Directions: the polygon of so many corners encloses 99.4 % of a circle.
const COUNT: usize = 32;
/// Numbers of the widest vector.
const LANES: usize = 8;

static DIRECTIONS: LazyLock<[DVec2; COUNT]> =
    LazyLock::new(|| std::array::from_fn(|k| DVec2::from_angle(TAU * k as f64 / COUNT as f64)));

/// The points in columns; memory is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outermost {
    x: Vec<f64>,
    y: Vec<f64>,
    found: [usize; COUNT],
}

impl Outermost {
    /// Appends to `out` what is outermost in any of the directions, the first of equals, and the point `deepest`.
    /// - `points`: with whatever comes with each, at least one; `deepest`: a place among them
    pub fn take<T: Copy>(&mut self, points: &[(DVec2, T)], deepest: usize, out: &mut Vec<(DVec2, T)>) {
        let center = points.iter().map(|point| point.0).sum::<DVec2>() / points.len() as f64;
        let column = |of: fn(DVec2) -> f64, out: &mut Vec<f64>| {
            out.clear();
            out.extend(points.iter().map(|point| of(point.0 - center)));
            // The first point again is never the first of equals.
            out.resize(points.len().next_multiple_of(LANES), out[0]);
        };
        column(|p| p.x, &mut self.x);
        column(|p| p.y, &mut self.y);
        Arch::new().dispatch(Search { columns: self, directions: &DIRECTIONS });
        // What is outermost in several directions is so in neighbouring ones.
        for (k, &at) in self.found.iter().enumerate() {
            if self.found[..k].last() != Some(&at) && (k == 0 || self.found[0] != at) {
                out.push(points[at]);
            }
        }
        if !self.found.contains(&deepest) {
            out.push(points[deepest]);
        }
    }
}

struct Search<'a> {
    columns: &'a mut Outermost,
    directions: &'a [DVec2; COUNT],
}

impl WithSimd for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Outermost { x, y, found } = self.columns;
        for (found, direction) in found.iter_mut().zip(self.directions) {
            *found = outermost(x, y, *direction);
        }
    }
}

/// The place of the point outermost along a direction, the first of equals.
#[inline(always)]
fn outermost(x: &[f64], y: &[f64], direction: DVec2) -> usize {
    let (mut best, mut places) = ([f64::NEG_INFINITY; LANES], [0.0; LANES]);
    let mut place = 0.0;
    for (x, y) in x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            let along = direction.x * x[lane] + direction.y * y[lane];
            let is_better = along > best[lane];
            best[lane] = if is_better { along } else { best[lane] };
            places[lane] = if is_better { place } else { places[lane] };
        }
        place += 1.0;
    }
    let mut first = (f64::NEG_INFINITY, 0);
    for lane in 0..LANES {
        let at = LANES * places[lane] as usize + lane;
        if best[lane] > first.0 || best[lane] == first.0 && at < first.1 {
            first = (best[lane], at);
        }
    }
    first.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_is_outermost() {
        for count in 1..80 {
            let point = |k: usize| DVec2::new((k as f64 * 1.7).sin() + 5.0, (k as f64 * k as f64 * 0.9).sin());
            // Each comes twice: of equals the first counts.
            let points: Vec<(DVec2, usize)> = (0..2 * count).map(|k| (point(k % count), k)).collect();
            let mut out = Vec::new();
            Outermost::default().take(&points, count, &mut out);
            for direction in &*DIRECTIONS {
                let along = |k: usize| direction.dot(point(k) - DVec2::new(5.0, 0.0));
                let most = (0..count).map(along).fold(f64::NEG_INFINITY, f64::max);
                let is_there = out.iter().any(|&(_, k)| k < count && along(k) >= most - 1e-12);
                assert!(is_there, "{count} {direction}: {out:?}");
            }
            let mut places: Vec<usize> = out.iter().map(|point| point.1).collect();
            assert_eq!(places.pop(), Some(count));
            places.sort_unstable();
            places.dedup();
            assert!(places.len() == out.len() - 1 && places.iter().all(|k| *k < count), "{count}: {out:?}");
        }
    }
}
