//! The exact solution of a single contact: `u = W λ + q` under Signorini's law and maximum dissipation over its polygon.
//!
//! The mode of the last visit answers nearly always. Otherwise sticking is tried, and then the vertices and edges of the polygon, those
//! nearest to the direction against the velocity first.

use signorini_contact::ContactProblem;
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::vector::dot;

/// A vertex of a polygon for a normal impulse of 1 and the edge that begins there.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: [f64; 2],
    /// The far end of the edge.
    next: [f64; 2],
    /// Unit vector along the edge, and its outward normal.
    tangent: [f64; 2],
    normal: [f64; 2],
    /// The edge's distance from the centre.
    height: f64,
}

/// The polygons of an island's contacts, numbered as in [`Cones`].
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    corners: Vec<Corner>,
    /// First corner of each polygon, and the total.
    starts: Vec<u32>,
    /// The unit that the last one was made for.
    last: Option<usize>,
}

/// How a unit is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Exactly, over the polygon of this number.
    Frictional(u32),
    /// The normal impulse alone.
    Frictionless,
    /// By a projected step: friction in one direction, a Delassus block without an inverse, or a friction group.
    Projected,
}

/// The data of a unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Single {
    kind: Kind,
    /// `W`.
    delassus: [[f64; 3]; 3],
    inverse: [[f64; 3]; 3],
    /// Lengths of projected steps along the normal and the tangents.
    step: [f64; 2],
}

impl Polygons {
    /// Forgets all polygons.
    pub fn clear(&mut self) {
        self.corners.clear();
        self.starts.clear();
        self.starts.push(0);
        self.last = None;
    }

    /// The data of unit `i` of the problem with this Delassus block; neighbours mostly have the same polygon.
    pub fn single(&mut self, problem: &ContactProblem, cones: &Cones, i: usize, delassus: [[f64; 3]; 3]) -> Single {
        let (half, difference) = (0.5 * (delassus[1][1] + delassus[2][2]), 0.5 * (delassus[1][1] - delassus[2][2]));
        // The larger eigenvalue of the tangents' block.
        let step = [delassus[0][0], half + difference.hypot(delassus[1][2])].map(reciprocal);
        let mut single = Single { kind: Kind::Projected, delassus, inverse: [[0.0; 3]; 3], step };
        if i >= problem.contact_count() {
            return single;
        }
        if cones.friction(i) == 0.0 {
            single.kind = Kind::Frictionless;
        } else if cones.direction_count(i) > 2
            && let Some(inverse) = inverted(&delassus)
        {
            (single.kind, single.inverse) = (Kind::Frictional(self.polygon(problem, cones, i)), inverse);
        }
        single
    }

    fn polygon(&mut self, problem: &ContactProblem, cones: &Cones, i: usize) -> u32 {
        let is_like = |last: usize| {
            cones.friction(i) == cones.friction(last) && problem.directions_of(i) == problem.directions_of(last)
        };
        if !self.last.is_some_and(is_like) {
            self.last = Some(i);
            let m = cones.direction_count(i);
            let vertex = |k: usize| {
                let [_, x, y] = cones.held_directions(i, Mode::Vertex((k % m) as u16)).1[0].impulse;
                [x, y]
            };
            self.corners.extend((0..m).map(|k| Corner::between(vertex(k), vertex(k + 1))));
            self.starts.push(self.corners.len() as u32);
        }
        self.starts.len() as u32 - 2
    }

    fn corners(&self, polygon: u32) -> &[Corner] {
        &self.corners[self.starts[polygon as usize] as usize..self.starts[polygon as usize + 1] as usize]
    }

    /// The impulse of a unit and its mode.
    ///
    /// - `u`: its velocity with the impulse `p`; `bound`: what bounds a friction group; `guess`: the mode of the last visit
    #[inline]
    pub fn solve(
        &self,
        cones: &Cones,
        (i, single): (usize, &Single),
        (u, p): ([f64; 3], [f64; 3]),
        bound: Option<f64>,
        guess: Mode,
    ) -> ([f64; 3], Mode) {
        let w = &single.delassus;
        match single.kind {
            Kind::Frictional(polygon) => {
                let q = std::array::from_fn(|r| u[r] - dot(w[r], p));
                if q[0] >= 0.0 {
                    return ([0.0; 3], Mode::Open);
                }
                let found = Attempt { corners: self.corners(polygon), single, q }.search(guess);
                found.unwrap_or_else(|| projected(cones, i, single, (u, p), None))
            }
            Kind::Frictionless => {
                let normal = (p[0] - single.step[0] * u[0]).max(0.0);
                ([normal, 0.0, 0.0], if normal > 0.0 { Mode::Closed } else { Mode::Open })
            }
            Kind::Projected => projected(cones, i, single, (u, p), bound),
        }
    }
}

/// A step against the velocity, and the projection.
fn projected(
    cones: &Cones,
    i: usize,
    single: &Single,
    (u, p): ([f64; 3], [f64; 3]),
    bound: Option<f64>,
) -> ([f64; 3], Mode) {
    let [normal, tangential] = single.step;
    let y = [bound.unwrap_or(p[0] - normal * u[0]), p[1] - tangential * u[1], p[2] - tangential * u[2]];
    let mode = cones.mode_at(i, y);
    (cones.project(i, mode, y), mode)
}

/// A contact that closes at velocity `q` without its impulse.
struct Attempt<'a> {
    corners: &'a [Corner],
    single: &'a Single,
    q: [f64; 3],
}

impl Attempt<'_> {
    fn search(&self, guess: Mode) -> Option<([f64; 3], Mode)> {
        let tried = |mode| self.with_mode(mode).map(|p| (p, mode));
        tried(guess).or_else(|| tried(Mode::Stick)).or_else(|| {
            let m = self.corners.len();
            let against = |k: &usize| -planar(self.corners[*k].vertex, [self.q[1], self.q[2]]);
            let best = (0..m).max_by(|a, b| against(a).total_cmp(&against(b)))?;
            (0..=m).find_map(|away| {
                let aside = away.div_ceil(2);
                let k = if away % 2 == 0 { best + aside } else { best + m - aside.min(m) } % m;
                tried(Mode::Vertex(k as u16)).or_else(|| tried(Mode::Edge(k as u16)))
            })
        })
    }

    /// The impulse in a mode, if the contact has that mode.
    #[inline]
    fn with_mode(&self, mode: Mode) -> Option<[f64; 3]> {
        match mode {
            Mode::Stick => self.sticking(),
            Mode::Edge(k) => self.on_edge(self.corners.get(k as usize)?),
            Mode::Vertex(k) => self.at_vertex(k as usize),
            Mode::Open | Mode::Closed => None,
        }
    }

    /// `λ = −W⁻¹ q`, inside the cone.
    #[inline]
    fn sticking(&self) -> Option<[f64; 3]> {
        let p = self.single.inverse.map(|row| -dot(row, self.q));
        let inside = |c: &Corner| planar(c.normal, [p[1], p[2]]) <= p[0] * c.height;
        (p[0] > 0.0 && self.corners.iter().all(inside)).then_some(p)
    }

    /// `λ = z_0 (1, h n) + z_1 (0, t)` with `u_N = 0` and `t·u_T = 0`, between the ends of the edge, at `n·u_T ≤ 0`.
    #[inline]
    fn on_edge(&self, c: &Corner) -> Option<[f64; 3]> {
        let (w, q, [t_1, t_2]) = (&self.single.delassus, self.q, c.tangent);
        let pushed = [1.0, c.height * c.normal[0], c.height * c.normal[1]];
        let along = [0.0, t_1, t_2];
        let [of_pushed, of_along] = [pushed, along].map(|a| w.map(|row| dot(row, a)));
        let [a, b] = [of_pushed[0], of_along[0]];
        let [d, e] = [of_pushed, of_along].map(|x| t_1 * x[1] + t_2 * x[2]);
        let (r_0, r_1) = (-q[0], -(t_1 * q[1] + t_2 * q[2]));
        let determinant = a * e - b * d;
        if determinant <= 0.0 {
            return None;
        }
        let (z_0, z_1) = ((r_0 * e - b * r_1) / determinant, (a * r_1 - d * r_0) / determinant);
        let [from, to] = [c.vertex, c.next].map(|end| z_0 * planar(end, c.tangent));
        if z_0 <= 0.0 || z_1 < from || z_1 > to {
            return None;
        }
        let p = [z_0, z_0 * pushed[1] + z_1 * t_1, z_0 * pushed[2] + z_1 * t_2];
        let slip = [q[1] + dot(w[1], p), q[2] + dot(w[2], p)];
        (planar(c.normal, slip) <= 0.0).then_some(p)
    }

    /// `λ = z (1, d)` with `u_N = 0`, and `−u_T` in the normal cone of the vertex `d`.
    #[inline]
    fn at_vertex(&self, k: usize) -> Option<[f64; 3]> {
        let (w, q) = (&self.single.delassus, self.q);
        let corner = self.corners.get(k)?;
        let before = self.corners[if k == 0 { self.corners.len() } else { k } - 1].tangent;
        let [x, y] = corner.vertex;
        let pushed = [1.0, x, y];
        let opens = dot(w[0], pushed);
        if opens <= 0.0 {
            return None;
        }
        let z = -q[0] / opens;
        let p = pushed.map(|a| a * z);
        let slip = [q[1] + dot(w[1], p), q[2] + dot(w[2], p)];
        (planar(slip, corner.tangent) >= 0.0 && planar(slip, before) <= 0.0).then_some(p)
    }
}

impl Corner {
    fn between(vertex: [f64; 2], next: [f64; 2]) -> Self {
        let along = [next[0] - vertex[0], next[1] - vertex[1]];
        let length = along[0].hypot(along[1]);
        let tangent = along.map(|x| x / length);
        let normal = [tangent[1], -tangent[0]];
        Self { vertex, next, tangent, normal, height: planar(normal, vertex) }
    }
}

#[inline]
fn planar(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn reciprocal(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// The inverse of a symmetric block, if it is positive definite beyond doubt.
fn inverted(w: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactor = |r: usize, c: usize| {
        let ([r_1, r_2], [c_1, c_2]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        w[r_1][c_1] * w[r_2][c_2] - w[r_1][c_2] * w[r_2][c_1]
    };
    let determinant = (0..3).map(|c| w[0][c] * cofactor(0, c)).sum::<f64>();
    // Half of the digits are left then.
    let is_regular = determinant > f64::EPSILON.sqrt() * w[0][0] * w[1][1] * w[2][2];
    is_regular.then(|| std::array::from_fn(|r| std::array::from_fn(|c| cofactor(c, r) / determinant)))
}
