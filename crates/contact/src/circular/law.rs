//! Coulomb's law of one contact with the circular cone, and that of one friction group: projections, slopes and the natural map.
//!
//! Two maps have the solutions of Signorini's and Coulomb's laws as fixed points, for any weight `ρ > 0`:
//! - `λ = P(λ − ρ u)` with `P(y) = (max(y_N, 0), projection of y_T onto the disc of radius μ max(y_N, 0))` (Alart & Curnier 1991),
//!   the limit of the polygon solver's projection for many directions; Newton's method works on this one;
//! - `λ = P_K(λ − ρ (u + μ‖u_T‖ n))` with the Euclidean projection `P_K` onto the cone (De Saxcé & Feng 1998), the
//!   complementarity problem of formulation §9; the certificate is its residual.
//!
//! A friction group has the disc (in one direction the interval) of radius `r = r₀ + c λ_N` for its impulse and no normal part. Its triples
//! hold in the first place what decides `r`: of an impulse the radius itself, of a velocity that of its contact's normal. So the same
//! `P` projects it, with μ = 1.

use crate::{ContactProblem, FrictionBound};

/// Where friction acts in the tangent plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Tangent {
    /// Nowhere: a contact without directions, or with `μ = 0`.
    #[default]
    None,
    /// Along one line: a contact in the plane, with two opposite directions.
    Line([f64; 2]),
    /// In all directions.
    Plane,
}

/// `μ` and the tangential directions of a contact in which friction acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoulombLaw {
    friction: f64,
    tangent: Tangent,
    /// What bounds the impulse of a friction group; contacts have none.
    bound: Option<FrictionBound>,
}

/// Where friction with these directions acts.
fn tangent_of(directions: &[[f64; 2]]) -> Tangent {
    match directions {
        [] => Tangent::None,
        [d, _] => Tangent::Line(*d),
        _ => Tangent::Plane,
    }
}

impl CoulombLaw {
    /// The law of contact `i`: none of its directions matter, only whether they are none, one line, or more.
    pub fn of(problem: &ContactProblem, i: usize) -> Self {
        let (friction, tangent) = (problem.friction[i], tangent_of(problem.directions_of(i)));
        let acts = friction != 0.0 && tangent != Tangent::None;
        if acts { Self { friction, tangent, bound: None } } else { Self::default() }
    }

    /// The law of friction group `j`.
    pub fn of_group(problem: &ContactProblem, j: usize) -> Self {
        let groups = &problem.friction_groups;
        Self { friction: 1.0, tangent: tangent_of(groups.directions_of(j)), bound: Some(groups.bound[j]) }
    }

    /// What bounds the impulse of a friction group; nothing for a contact.
    pub fn bound(&self) -> Option<FrictionBound> {
        self.bound
    }

    /// The law of a contact of a problem in impulse space. `dimension`: 2 or 3.
    pub fn in_dimension(friction: f64, dimension: usize) -> Self {
        let tangent = if dimension == 2 { Tangent::Line([1.0, 0.0]) } else { Tangent::Plane };
        if friction == 0.0 { Self::default() } else { Self { friction, tangent, bound: None } }
    }

    /// The coefficient of friction, 0 where no friction acts.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Whether friction acts in all tangential directions.
    pub fn is_circular(&self) -> bool {
        self.tangent == Tangent::Plane
    }

    /// The line on which friction acts, if it is one.
    pub fn line(&self) -> Option<[f64; 2]> {
        if let Tangent::Line(d) = self.tangent { Some(d) } else { None }
    }

    /// The part of a tangential vector in which friction acts.
    pub fn tangential(&self, x: [f64; 3]) -> [f64; 2] {
        match self.tangent {
            Tangent::None => [0.0; 2],
            Tangent::Line(d) => {
                let s = d[0] * x[1] + d[1] * x[2];
                [s * d[0], s * d[1]]
            }
            Tangent::Plane => [x[1], x[2]],
        }
    }

    /// Alart and Curnier's projection `P(y)`.
    pub fn project(&self, y: [f64; 3]) -> [f64; 3] {
        if y[0] <= 0.0 {
            return [0.0; 3];
        }
        let t = self.tangential(y);
        let (size, radius) = (t[0].hypot(t[1]), self.friction * y[0]);
        if size <= radius {
            return [y[0], t[0], t[1]];
        }
        let factor = radius / size;
        [y[0], factor * t[0], factor * t[1]]
    }

    /// A generalized derivative of [`project`](Self::project) at `y`, rows (normal, tangent 1, tangent 2).
    pub fn slope(&self, y: [f64; 3]) -> [[f64; 3]; 3] {
        if y[0] <= 0.0 {
            return [[0.0; 3]; 3];
        }
        let t = self.tangential(y);
        let (size, radius) = (t[0].hypot(t[1]), self.friction * y[0]);
        let plane = self.tangential_identity();
        if size <= radius {
            return [[1.0, 0.0, 0.0], [0.0, plane[0][0], plane[0][1]], [0.0, plane[1][0], plane[1][1]]];
        }
        let (d, k) = ([t[0] / size, t[1] / size], radius / size);
        let across = |r: usize, c: usize| k * (plane[r][c] - d[r] * d[c]);
        [
            [1.0, 0.0, 0.0],
            [self.friction * d[0], across(0, 0), across(0, 1)],
            [self.friction * d[1], across(1, 0), across(1, 1)],
        ]
    }

    fn tangential_identity(&self) -> [[f64; 2]; 2] {
        match self.tangent {
            Tangent::None => [[0.0; 2]; 2],
            Tangent::Line(d) => [[d[0] * d[0], d[0] * d[1]], [d[1] * d[0], d[1] * d[1]]],
            Tangent::Plane => [[1.0, 0.0], [0.0, 1.0]],
        }
    }

    /// Euclidean projection `P_K` onto the cone `‖λ_T‖ ≤ μ λ_N`.
    pub fn project_onto_cone(&self, y: [f64; 3]) -> [f64; 3] {
        let (t, mu) = (self.tangential(y), self.friction);
        let size = t[0].hypot(t[1]);
        if y[0] <= 0.0 && mu * size <= -y[0] {
            return [0.0; 3];
        }
        if size <= mu * y[0] {
            return [y[0], t[0], t[1]];
        }
        let normal = (y[0] + mu * size) / (1.0 + mu * mu);
        let factor = mu * normal / size;
        [normal, factor * t[0], factor * t[1]]
    }

    /// `‖g λ − P_K(g λ − u − μ‖u_T‖ n)‖`, m/s: the residual of formulation §9 for the impulse `λ` (N·s) at the velocity `u`
    /// (m/s, `φ/Δt` included in its normal part). `g`: 1/kg.
    pub fn natural_map(&self, lambda: [f64; 3], u: [f64; 3], g: f64) -> f64 {
        let t = self.tangential(u);
        let slip = t[0].hypot(t[1]);
        let z = lambda.map(|p| g * p);
        let p = self.project_onto_cone([z[0] - u[0] - self.friction * slip, z[1] - t[0], z[2] - t[1]]);
        let difference: [f64; 3] = std::array::from_fn(|r| z[r] - p[r]);
        let square: f64 = difference.iter().map(|x| x * x).sum();
        square.sqrt()
    }

    /// `‖g λ − D(g λ − s)‖`, m/s, with `D` the projection onto the disc of radius `g r`: the same for a friction group with the
    /// impulse `λ` (N·s) in the last two places, the slip `s` (m/s) likewise, and the bound `r` (N·s).
    pub fn group_natural_map(&self, lambda: [f64; 3], slip: [f64; 3], r: f64, g: f64) -> f64 {
        let (z, s) = ([g * lambda[1], g * lambda[2]], self.tangential(slip));
        let p = self.project([g * r, z[0] - s[0], z[1] - s[1]]);
        (z[0] - p[1]).hypot(z[1] - p[2])
    }
}
