//! The polygons of the friction cones, each of them once.

use crate::lists::same_bits;

/// One edge of a polygon of radius 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its first vertex.
    pub vertex: [f64; 2],
    /// Unit vector along the edge.
    pub tangent: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Distance from the centre.
    pub height: f64,
    /// Index of its first vertex among the contact's directions.
    pub direction: u32,
}

/// Polygons with their edges. Most contacts share one, which stays from problem to problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    edges: Vec<Edge>,
    /// The directions of each polygon in the order in which the problem has them, as many as edges.
    directions: Vec<[f64; 2]>,
    known: Vec<Polygon>,
    order: Vec<u32>,
}

/// Where the edges of a polygon are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Polygon {
    first: u32,
    /// One after the last edge.
    end: u32,
    /// Radius of a circle well inside; zero without an inside.
    pub inner: f64,
}

/// Part of a polygon's inner circle in which rounding cannot take a point for one outside.
const WELL_INSIDE: f64 = 1.0 - 1e-9;

/// Polygons that are looked through for the one that a contact asks for, and that stay for the next problem.
const KEPT_POLYGONS: usize = 4;
/// Edges that stay for the next problem, at most.
const KEPT_EDGES: usize = 64;

impl Polygons {
    /// Makes room for the polygons of another problem, as if no two units shared one: what is kept never decides about memory.
    pub fn begin(&mut self, units: usize, directions: usize) {
        if self.known.len() > KEPT_POLYGONS || self.edges.len() > KEPT_EDGES {
            self.edges.clear();
            self.directions.clear();
            self.known.clear();
        }
        let edges = KEPT_EDGES + directions - self.edges.len();
        self.edges.reserve(edges);
        self.directions.reserve(edges);
        self.known.reserve(KEPT_POLYGONS + units - self.known.len());
    }

    /// The polygon with these directions, to the bit: the sign of a zero decides which edge is the first.
    pub fn with_directions(&mut self, directions: &[[f64; 2]]) -> Polygon {
        let same = |polygon: &&Polygon| {
            let own = &self.directions[polygon.first as usize..polygon.end as usize];
            same_bits(own.as_flattened(), directions.as_flattened())
        };
        let known = self.known.iter().take(KEPT_POLYGONS).find(same);
        known.copied().unwrap_or_else(|| self.push(directions))
    }

    /// The edges of a polygon in angular order.
    #[inline]
    pub fn edges(&self, polygon: Polygon) -> &[Edge] {
        &self.edges[polygon.first as usize..polygon.end as usize]
    }

    fn push(&mut self, directions: &[[f64; 2]]) -> Polygon {
        // Grows with the angle as the angle itself does, from −2 to 2.
        let angle = |k: &u32| {
            let [x, y] = directions[*k as usize];
            (1.0 - x / (x.abs() + y.abs())).copysign(y)
        };
        self.order.clear();
        self.order.extend(0..directions.len() as u32);
        self.order.sort_unstable_by(|a, b| angle(a).total_cmp(&angle(b)));
        let first = self.edges.len();
        for (k, &direction) in self.order.iter().enumerate() {
            let vertex = directions[direction as usize];
            let next = directions[self.order[(k + 1) % self.order.len()] as usize];
            let along = [next[0] - vertex[0], next[1] - vertex[1]];
            let length = along[0].hypot(along[1]);
            let tangent = [along[0] / length, along[1] / length];
            let normal = [tangent[1], -tangent[0]];
            self.edges.push(Edge { vertex, tangent, normal, height: dot(normal, vertex), direction });
        }
        self.directions.extend_from_slice(directions);
        let own = &self.edges[first..];
        let least = own.iter().fold(f64::MAX, |least, edge| least.min(edge.height));
        // Two directions make a line, which has no inside.
        let inner = if own.len() > 2 { WELL_INSIDE * least } else { 0.0 };
        let polygon = Polygon { first: first as u32, end: self.edges.len() as u32, inner };
        self.known.push(polygon);
        polygon
    }
}

#[inline]
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
