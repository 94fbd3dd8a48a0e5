//! The piecewise linear projection onto the friction cone of one contact, and its pieces.
//!
//! For a trial impulse `y = (y_N, y_T)` the projection `P(y)` is 0 where `y_N ≤ 0`; otherwise its normal part is `y_N` and
//! its tangential part the Euclidean projection of `y_T` onto the polygon `μ y_N · conv{d_k}`. Each piece ([`Mode`]) is a
//! polyhedral cone with its apex at 0, on which `P` is linear; two pieces that share a facet `f·y = 0` have slopes that
//! differ by the rank-one matrix `a fᵀ`, because `P` is continuous. That is all that the path method needs.

use super::cone_data::ConeData;
use super::mode::{Facet, Held, Mode};
use super::polygons::{Edge, Polygon, Polygons, dot};
use crate::ContactProblem;

/// The friction cones of all contacts, then those of all friction groups, with directions in angular order.
#[derive(Clone, Debug, Default)]
pub struct Cones {
    polygons: Polygons,
    /// The polygon of each cone; one without edges where there is no friction.
    shape: Vec<Polygon>,
    friction: Vec<f64>,
    /// Radius of a circle well inside each cone's polygon for a normal impulse of 1.
    inner: Vec<f64>,
    source: ConeData,
}

impl Cones {
    /// Reads friction and directions of a problem; memory is reused.
    pub fn prepare(&mut self, problem: &ContactProblem) {
        if self.source.is_that_of(problem) {
            return;
        }
        self.source.read(problem);
        let groups = &problem.friction_groups;
        let units = problem.contact_count() + groups.len();
        self.polygons.begin(units, problem.direction_count() + groups.direction_count());
        self.shape.clear();
        self.friction.clear();
        self.inner.clear();
        for i in 0..problem.contact_count() {
            self.push_cone(problem.friction[i], problem.directions_of(i));
        }
        // A group with a constant bound has that bound in place of the normal impulse.
        for j in 0..groups.len() {
            let coefficient = groups.bound[j].normal().map_or(1.0, |(_, coefficient)| coefficient);
            self.push_cone(coefficient, groups.directions_of(j));
        }
    }

    fn push_cone(&mut self, friction: f64, directions: &[[f64; 2]]) {
        let frictional = friction > 0.0 && !directions.is_empty();
        self.friction.push(if frictional { friction } else { 0.0 });
        let shape = if frictional { self.polygons.with_directions(directions) } else { Polygon::default() };
        self.inner.push(friction * shape.inner);
        self.shape.push(shape);
    }

    /// Whether an impulse lies so far inside contact `i`'s cone that it sticks beyond doubt; the quick answer for most contacts.
    #[inline]
    pub fn is_well_inside(&self, i: usize, y: [f64; 3]) -> bool {
        let radius = self.inner[i] * y[0];
        radius > 0.0 && y[1] * y[1] + y[2] * y[2] < radius * radius
    }

    #[inline]
    fn edges(&self, i: usize) -> &[Edge] {
        self.polygons.edges(self.shape[i])
    }

    /// Number of directions of contact or friction group `i`.
    pub fn direction_count(&self, i: usize) -> usize {
        self.edges(i).len()
    }

    /// The effective coefficient of friction of contact `i`: 0 where it has no directions.
    pub fn friction(&self, i: usize) -> f64 {
        self.friction[i]
    }

    /// The part of a tangential impulse that contact `i`'s friction can have at all: with two directions that along them.
    pub fn admissible(&self, i: usize, t: [f64; 2]) -> [f64; 2] {
        match self.edges(i) {
            [] => [0.0; 2],
            [e, _] => e.tangent.map(|x| x * dot(e.tangent, t)),
            _ => t,
        }
    }

    /// Calls `visit` with the outward unit normal of every edge of the polygon and its distance from the centre for a normal
    /// impulse of 1; with two directions, with the ends of their interval.
    pub fn interior_edges(&self, i: usize, mut visit: impl FnMut([f64; 2], f64)) {
        let (edges, mu) = (self.edges(i), self.friction[i]);
        if let [first, last] = edges {
            let outward = first.tangent.map(|t| t * dot(first.tangent, first.vertex).signum());
            visit(outward, mu * dot(outward, first.vertex));
            let outward = outward.map(|n| -n);
            visit(outward, mu * dot(outward, last.vertex));
        } else {
            edges.iter().for_each(|edge| visit(edge.normal, mu * edge.height));
        }
    }

    /// The mode whose cone holds `y`.
    pub fn mode_at(&self, i: usize, y: [f64; 3]) -> Mode {
        if y[0] <= 0.0 {
            return Mode::Open;
        }
        if self.is_well_inside(i, y) {
            return Mode::Stick;
        }
        let edges = self.edges(i);
        if edges.is_empty() {
            return Mode::Closed;
        }
        let (radius, t) = (self.friction[i] * y[0], [y[1], y[2]]);
        if edges.len() == 2 {
            let (s, length) = (dot(edges[0].tangent, t), half_length(&edges[0]));
            return if s.abs() <= radius * length { Mode::Edge(0) } else { Mode::Vertex(u16::from(s > 0.0)) };
        }
        let beyond = |e: &Edge| dot(e.normal, t) - radius * e.height;
        let (k, worst) = edges.iter().map(beyond).enumerate().fold((0, f64::MIN), |a, b| if b.1 > a.1 { b } else { a });
        if worst <= 0.0 {
            return Mode::Stick;
        }
        self.nearest_on_boundary(i, k, radius, t)
    }

    /// Walks along the boundary from edge `k` to the edge or vertex nearest to a point `t` outside.
    fn nearest_on_boundary(&self, i: usize, mut k: usize, radius: f64, t: [f64; 2]) -> Mode {
        let edges = self.edges(i);
        let m = edges.len();
        let mut direction = 0_i32;
        for _ in 0..=m {
            let edge = &edges[k];
            let next = &edges[(k + 1) % m];
            let before = dot(edge.tangent, t) < radius * dot(edge.tangent, edge.vertex);
            let after = dot(edge.tangent, t) > radius * dot(edge.tangent, next.vertex);
            if !before && !after {
                return Mode::Edge(k as u16);
            }
            let step = if after { 1 } else { -1 };
            if step == -direction {
                return Mode::Vertex(if step > 0 { (k + 1) % m } else { k } as u16);
            }
            direction = step;
            k = if after { (k + 1) % m } else { (k + m - 1) % m };
        }
        Mode::Vertex(k as u16)
    }

    /// The mode itself if contact `i` has it, else its sticking mode (a polygon or friction may have changed).
    pub fn nearest_valid(&self, i: usize, mode: Mode) -> Mode {
        let m = self.edges(i).len();
        match mode {
            Mode::Open => Mode::Open,
            _ if m == 0 => Mode::Closed,
            Mode::Vertex(k) | Mode::Edge(k) if (k as usize) < m && (m > 2 || mode != Mode::Edge(1)) => mode,
            _ if m == 2 => Mode::Edge(0),
            _ => Mode::Stick,
        }
    }

    /// The projection `B y` of the mode's piece.
    pub fn project(&self, i: usize, mode: Mode, y: [f64; 3]) -> [f64; 3] {
        let radius = self.friction[i] * y[0];
        match mode {
            Mode::Open => [0.0; 3],
            Mode::Closed => [y[0], 0.0, 0.0],
            Mode::Stick => y,
            Mode::Edge(k) => {
                let e = &self.edges(i)[k as usize];
                let (n, s) = (radius * e.height, dot(e.tangent, [y[1], y[2]]));
                [y[0], n * e.normal[0] + s * e.tangent[0], n * e.normal[1] + s * e.tangent[1]]
            }
            Mode::Vertex(k) => {
                let d = self.edges(i)[k as usize].vertex;
                [y[0], radius * d[0], radius * d[1]]
            }
        }
    }

    /// The slope `B` of the mode's piece, rows (normal, tangent 1, tangent 2).
    pub fn slope(&self, i: usize, mode: Mode) -> [[f64; 3]; 3] {
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| self.project(i, mode, unit));
        std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]))
    }

    /// What is free with the mode fixed, and what it holds: impulses `λ = Σ z_k a_k` at velocities with `r_k·u = 0`, for the
    /// pairs `(a_k, r_k)`; those that are not of the mode are zero.
    pub fn held_directions(&self, i: usize, mode: Mode) -> (usize, [Held; 3]) {
        let normal = [1.0, 0.0, 0.0];
        let along = |impulse, velocity| Held { impulse, velocity };
        let only = |impulse| (1, [along(impulse, normal), Held::default(), Held::default()]);
        let mu = self.friction[i];
        match mode {
            Mode::Open => (0, [Held::default(); 3]),
            Mode::Closed => only(normal),
            Mode::Stick => (3, [normal, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| along(unit, unit))),
            Mode::Edge(k) => {
                let e = &self.edges(i)[k as usize];
                let (n, t) = (mu * e.height, [0.0, e.tangent[0], e.tangent[1]]);
                let pushed = [1.0, n * e.normal[0], n * e.normal[1]];
                (2, [along(pushed, normal), along(t, t), Held::default()])
            }
            Mode::Vertex(k) => {
                let d = self.edges(i)[k as usize].vertex;
                only([1.0, mu * d[0], mu * d[1]])
            }
        }
    }

    /// Calls `visit` with every facet of the mode's cone. That of an open contact leads into closed contact without friction;
    /// [`closing`](Self::closing) says where it lands.
    #[inline]
    pub fn facets(&self, i: usize, mode: Mode, mut visit: impl FnMut(Facet)) {
        let edges = self.edges(i);
        let (mu, m) = (self.friction[i], edges.len());
        let open = |jump| Facet { normal: [1.0, 0.0, 0.0], jump, next: Mode::Open };
        let tangential = |normal: [f64; 2], n: f64| [n, normal[0], normal[1]];
        match mode {
            Mode::Open => visit(Facet { normal: [-1.0, 0.0, 0.0], jump: [-1.0, 0.0, 0.0], next: Mode::Closed }),
            Mode::Closed => visit(open([-1.0, 0.0, 0.0])),
            Mode::Stick => {
                for (k, e) in edges.iter().enumerate() {
                    let normal = [mu * e.height, -e.normal[0], -e.normal[1]];
                    visit(Facet { normal, jump: tangential(e.normal, 0.0), next: Mode::Edge(k as u16) });
                }
            }
            Mode::Edge(k) => {
                let e = &edges[k as usize];
                let to = if k as usize + 1 == m { 0 } else { k as usize + 1 };
                if m > 2 {
                    let normal = tangential(e.normal, -mu * e.height);
                    visit(Facet { normal, jump: tangential(e.normal, 0.0), next: Mode::Stick });
                }
                let t = e.tangent;
                let (first, last) = (mu * dot(e.vertex, t), mu * dot(edges[to].vertex, t));
                visit(Facet { normal: [-first, t[0], t[1]], jump: [0.0, -t[0], -t[1]], next: Mode::Vertex(k) });
                visit(Facet { normal: [last, -t[0], -t[1]], jump: [0.0, t[0], t[1]], next: Mode::Vertex(to as u16) });
            }
            Mode::Vertex(k) => {
                let d = edges[k as usize].vertex;
                visit(open([-1.0, -mu * d[0], -mu * d[1]]));
                let before = if k == 0 { m - 1 } else { k as usize - 1 };
                if m > 2 || k == 0 {
                    let t = edges[k as usize].tangent;
                    let normal = [mu * dot(d, t), -t[0], -t[1]];
                    visit(Facet { normal, jump: [0.0, -t[0], -t[1]], next: Mode::Edge(k) });
                }
                if m > 2 || k == 1 {
                    let t = edges[before].tangent;
                    let normal = [-mu * dot(d, t), t[0], t[1]];
                    visit(Facet { normal, jump: [0.0, t[0], t[1]], next: Mode::Edge(before as u16) });
                }
            }
        }
    }

    /// The facet of an open contact that closes with the trial impulse `y`: with friction it begins to slide at a vertex.
    pub fn closing(&self, i: usize, y: [f64; 3]) -> Facet {
        let (edges, mu) = (self.edges(i), self.friction[i]);
        let along = |e: &Edge| dot(e.vertex, [y[1], y[2]]);
        let best = (0..edges.len()).max_by(|&a, &b| along(&edges[a]).total_cmp(&along(&edges[b])));
        let (next, d) = best.map_or((Mode::Closed, [0.0; 2]), |k| (Mode::Vertex(k as u16), edges[k].vertex));
        Facet { normal: [-1.0, 0.0, 0.0], jump: [-1.0, -mu * d[0], -mu * d[1]], next }
    }

    /// A trial impulse of normal size `size` well inside the mode's cone.
    pub fn interior_point(&self, i: usize, mode: Mode, size: f64) -> [f64; 3] {
        let mu = self.friction[i];
        match mode {
            Mode::Open => [-size, 0.0, 0.0],
            Mode::Closed | Mode::Stick => [size, 0.0, 0.0],
            Mode::Edge(k) => {
                let (edges, k) = (self.edges(i), k as usize);
                let (a, b) = (edges[k].vertex, edges[(k + 1) % edges.len()].vertex);
                let middle = [a[0] + b[0], a[1] + b[1]].map(|x| 0.5 * x);
                let outwards = if edges.len() == 2 { [0.0; 2] } else { edges[k].normal };
                [size, size * (mu * middle[0] + outwards[0]), size * (mu * middle[1] + outwards[1])]
            }
            Mode::Vertex(k) => {
                let (d, outwards) = (self.edges(i)[k as usize].vertex, self.outwards(i, k as usize));
                [size, size * (mu * d[0] + outwards[0]), size * (mu * d[1] + outwards[1])]
            }
        }
    }

    /// The unit vector halfway between the normals of the edges at vertex `k`; of an anisotropic polygon it is not along the vertex.
    fn outwards(&self, i: usize, k: usize) -> [f64; 2] {
        let edges = self.edges(i);
        let (a, b) = (edges[(k + edges.len() - 1) % edges.len()].normal, edges[k].normal);
        let sum = if edges.len() == 2 { edges[k].vertex } else { [a[0] + b[0], a[1] + b[1]] };
        let length = sum[0].hypot(sum[1]);
        sum.map(|x| x / length)
    }

    /// Splits a tangential impulse into its direction multipliers `α ≥ 0`, `D α = λ_T`, over the two neighbouring
    /// directions that enclose it, whose indices come back; nothing where there is no friction. `alpha`: the contact's entries,
    /// zero before.
    pub fn decompose(&self, i: usize, lambda: [f64; 3], alpha: &mut [f64]) -> Option<[usize; 2]> {
        let edges = self.edges(i);
        let (m, t) = (edges.len(), [lambda[1], lambda[2]]);
        if m == 0 || lambda[0] <= 0.0 {
            return None;
        }
        if m == 2 {
            let s = dot(edges[0].tangent, t);
            let pair = [usize::from(s > 0.0), usize::from(s <= 0.0)].map(|k| edges[k].direction as usize);
            alpha[pair[0]] = s.abs() / half_length(&edges[0]);
            return Some(pair);
        }
        let encloses = |k: &usize| {
            let (a, b) = (edges[*k].vertex, edges[if k + 1 == m { 0 } else { k + 1 }].vertex);
            a[0] * t[1] - a[1] * t[0] >= 0.0 && t[0] * b[1] - t[1] * b[0] >= 0.0
        };
        let k = (0..m).find(encloses).unwrap_or(0);
        Some(split(&edges[k], &edges[if k + 1 == m { 0 } else { k + 1 }], t, alpha))
    }
}

/// The length of the two directions of a line.
fn half_length(edge: &Edge) -> f64 {
    dot(edge.tangent, edge.vertex).abs()
}

/// `α_a d_a + α_b d_b = t`, rounding below zero cut off; the indices of both directions.
fn split(a: &Edge, b: &Edge, t: [f64; 2], alpha: &mut [f64]) -> [usize; 2] {
    let (u, v) = (a.vertex, b.vertex);
    let determinant = u[0] * v[1] - u[1] * v[0];
    let pair = [a.direction as usize, b.direction as usize];
    alpha[pair[0]] = ((t[0] * v[1] - t[1] * v[0]) / determinant).max(0.0);
    alpha[pair[1]] = ((u[0] * t[1] - u[1] * t[0]) / determinant).max(0.0);
    pair
}
