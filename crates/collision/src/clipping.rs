//! A convex polygon that is cut by one line after another.

use glamx::glam::DVec2;

use crate::feature::Feature;

/// A side of the clipped polygon: the vertices of the original side it lies on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Side {
    OfA([u32; 2]),
    OfB([u32; 2]),
}

/// A corner of the clipped polygon and the side that follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub p: DVec2,
    pub feature: Feature,
    pub next: Side,
}

/// The corners of a convex polygon, each with those before and after it.
///
/// Along a convex polygon the depth below a line falls to its lowest corner and rises from there, and the lowest corners of lines that turn follow each other. So a cut
/// begins at the last one, and visits what it removes: polygons of n and m sides take n + m visits in place of n · m.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ring {
    corners: Vec<Corner>,
    /// The corners before and after each.
    links: Vec<[usize; 2]>,
    /// The first one, if there is any.
    head: Option<usize>,
    /// Where the last line was lowest.
    lowest: usize,
}

/// Places in a link.
const BEFORE: usize = 0;
const AFTER: usize = 1;

impl Ring {
    /// Begins with the corners of a convex polygon in order, either way around.
    pub fn begin(&mut self, corners: impl Iterator<Item = Corner>) {
        self.corners.clear();
        self.corners.extend(corners);
        let count = self.corners.len();
        self.links.clear();
        self.links.extend((0..count).map(|k| [(k + count - 1) % count, (k + 1) % count]));
        self.head = (count > 0).then_some(0);
        self.lowest = 0;
    }

    /// Keeps the part on the inward side of a line, the line's border included.
    ///
    /// - `p`, `inward`: a point of the line, and the unit vector across it; `side`: the vertices of A that the line goes through; `tolerance`: how far outside a corner
    ///   counts as inside, m
    pub fn cut(&mut self, p: DVec2, inward: DVec2, side: [u32; 2], tolerance: f64) {
        let Some(head) = self.head else { return };
        let depth = |corner: &Corner| inward.dot(corner.p - p);
        self.lowest = self.find_lowest(depth, tolerance);
        let is_out = |ring: &Self, k: usize| depth(&ring.corners[k]) < -tolerance;
        if !is_out(self, self.lowest) {
            return;
        }
        let mut loses_head = self.lowest == head;
        let mut last_out = [self.lowest; 2];
        for way in [BEFORE, AFTER] {
            loop {
                let next = self.links[last_out[way]][way];
                if next == self.lowest {
                    self.head = None;
                    return;
                }
                if !is_out(self, next) {
                    break;
                }
                loses_head |= next == head;
                last_out[way] = next;
            }
        }
        let [first_out, last_out] = last_out;
        let (last_in, first_in) = (self.links[first_out][BEFORE], self.links[last_out][AFTER]);
        let leaving = Corner { next: Side::OfA(side), ..self.crossing([last_in, first_out], depth, side) };
        let entering = self.crossing([last_out, first_in], depth, side);
        let (exit, entry) = (self.corners.len(), self.corners.len() + 1);
        self.corners.extend([leaving, entering]);
        self.links.extend([[last_in, entry], [exit, first_in]]);
        self.links[last_in][AFTER] = exit;
        self.links[first_in][BEFORE] = entry;
        self.lowest = entry;
        if loses_head {
            self.head = Some(entry);
        }
    }

    /// The corners in order.
    pub fn corners(&self) -> impl Iterator<Item = Corner> + '_ {
        let after = |k: &usize| Some(self.links[*k][AFTER]).filter(|next| Some(*next) != self.head);
        std::iter::successors(self.head, after).map(|k| self.corners[k])
    }

    /// The lowest corner. Corners that nearly coincide may rise and fall by rounding: only what rises by more than the tolerance ends the search.
    fn find_lowest(&self, depth: impl Fn(&Corner) -> f64, tolerance: f64) -> usize {
        let from = self.lowest;
        let mut lowest = (depth(&self.corners[from]), from);
        for way in [BEFORE, AFTER] {
            let mut k = self.links[from][way];
            while k != from {
                let here = depth(&self.corners[k]);
                if here > lowest.0 + tolerance {
                    break;
                }
                if here < lowest.0 {
                    lowest = (here, k);
                }
                k = self.links[k][way];
            }
        }
        lowest.1
    }

    /// Where the side between two neighbours crosses a line, with the side that goes on from there.
    fn crossing(&self, between: [usize; 2], depth: impl Fn(&Corner) -> f64, side: [u32; 2]) -> Corner {
        let [corner, after] = between.map(|k| &self.corners[k]);
        let (here, there) = (depth(corner), depth(after));
        let feature = match corner.next {
            Side::OfB(edge) => Feature::Edges(side, edge),
            Side::OfA(edge) => Feature::VertexA(shared_vertex(edge, side)),
        };
        let p = corner.p.lerp(after.p, (here / (here - there)).clamp(0.0, 1.0));
        Corner { p, feature, next: corner.next }
    }
}

fn shared_vertex(e: [u32; 2], f: [u32; 2]) -> u32 {
    if f.contains(&e[0]) { e[0] } else { e[1] }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::testing::Noise;

    /// As narrow searches have it for shapes of a metre.
    const TOLERANCE: f64 = 1e-9;

    /// The corners of an ellipse, at angles that noise has moved.
    fn polygon(noise: &mut Noise, count: usize, center: DVec2, clockwise: bool) -> Vec<DVec2> {
        let (wide, high, start) = (noise.between(0.5, 1.5), noise.between(0.5, 1.5), noise.between(0.0, TAU));
        let at = |k: usize, shift: f64| start + TAU * (k as f64 + shift) / count as f64;
        let angles: Vec<f64> = (0..count).map(|k| at(k, noise.between(-0.4, 0.4))).collect();
        let way = if clockwise { -1.0 } else { 1.0 };
        angles.iter().map(|a| center + DVec2::new(wide * a.cos(), way * high * a.sin())).collect()
    }

    fn corners(polygon: &[DVec2]) -> Vec<Corner> {
        let count = polygon.len() as u32;
        let own = (0..count).zip(polygon);
        own.map(|(k, p)| Corner { p: *p, feature: Feature::VertexB(k), next: Side::OfB([k, (k + 1) % count]) })
            .collect()
    }

    /// All corners looked at for every line.
    fn cut_all(corners: &[Corner], p: DVec2, inward: DVec2, side: [u32; 2]) -> Vec<Corner> {
        let depth = |corner: &Corner| inward.dot(corner.p - p);
        let mut out = Vec::new();
        for (k, corner) in corners.iter().enumerate() {
            let after = &corners[(k + 1) % corners.len()];
            let (here, there) = (depth(corner), depth(after));
            let (keep, keep_after) = (here >= -TOLERANCE, there >= -TOLERANCE);
            if keep {
                out.push(*corner);
            }
            if keep != keep_after {
                let feature = match corner.next {
                    Side::OfB(edge) => Feature::Edges(side, edge),
                    Side::OfA(edge) => Feature::VertexA(shared_vertex(edge, side)),
                };
                let next = if keep { Side::OfA(side) } else { corner.next };
                out.push(Corner { p: corner.p.lerp(after.p, here / (here - there)), feature, next });
            }
        }
        out
    }

    #[test]
    fn a_ring_is_cut_as_a_list_of_all_corners_is() {
        let mut noise = Noise(7);
        let mut seen = [0; 3];
        for case in 0..3000 {
            let count = |noise: &mut Noise| noise.between(3.0, 60.0) as usize;
            let shift = DVec2::new(noise.between(-2.0, 2.0), noise.between(-2.0, 2.0));
            let (n, m) = (count(&mut noise), count(&mut noise));
            let a = polygon(&mut noise, n, DVec2::ZERO, case % 2 == 0);
            let b = polygon(&mut noise, m, if case % 3 == 0 { 0.01 * shift } else { shift }, case % 5 == 0);
            let mut list = corners(&b);
            let mut ring = Ring::default();
            ring.begin(list.iter().copied());
            for k in 0..n {
                let (p, q) = (a[k], a[(k + 1) % n]);
                let way = if case % 2 == 0 { -1.0 } else { 1.0 };
                let (inward, side) = ((q - p).normalize().perp() * way, [k as u32, (k as u32 + 1) % n as u32]);
                list = cut_all(&list, p, inward, side);
                ring.cut(p, inward, side, TOLERANCE);
            }
            let same = |(x, y): (&Corner, Corner)| x.p.distance(y.p) < 1e-12 && x.feature == y.feature;
            assert!(ring.corners().count() == list.len() && list.iter().zip(ring.corners()).all(same), "case {case}");
            let crossings = list.iter().filter(|corner| matches!(corner.feature, Feature::Edges(..))).count();
            seen[usize::from(!list.is_empty()) + usize::from(crossings > 4)] += 1;
        }
        assert!(seen.iter().all(|count| *count > 30), "apart, overlapping, with many crossings: {seen:?}");
    }
}
