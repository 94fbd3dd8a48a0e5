//! Friction polygons: the set `μ λ_N · conv{d_1 … d_m}` of admissible tangential impulses (formulation §2).

use crate::ProblemError;

/// How far a direction's opposite may be off.
const OPPOSITE_TOLERANCE: f64 = 1e-9;

/// The tangent directions of one contact, balanced (`−d` is among them whenever `d` is) and in convex position.
///
/// Directions of length 1 stand for a coefficient μ that is the same in every direction. A direction of another length has
/// the coefficient `μ |d|`: friction is anisotropic, and the sliding direction follows from maximum dissipation (the impulse
/// is where the polygon reaches farthest against the sliding velocity, so that the two need not be parallel).
///
/// In 3-D there are at least four, in the plane two; a frictionless contact has none. The directions keep the order they
/// were given in, which is the order of the multipliers `α`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FrictionPolygon {
    directions: Vec<[f64; 2]>,
}

/// Directions of a polygon at most: a circle to 1 part in 3 million.
pub const MOST_DIRECTIONS: usize = 4096;

fn too_many(count: usize) -> Result<(), ProblemError> {
    if count <= MOST_DIRECTIONS {
        return Ok(());
    }
    let reason = format!("a polygon has at most {MOST_DIRECTIONS} directions; found {count}");
    Err(ProblemError::Directions { contact: None, reason })
}

impl FrictionPolygon {
    /// No directions: a contact without friction.
    pub fn frictionless() -> Self {
        Self::default()
    }

    /// `count` equally spaced directions, the first at `angle` rad from the first tangent. Opposite directions are
    /// exact negatives of each other.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] if `count` is odd, less than 2 or more than [`MOST_DIRECTIONS`].
    pub fn regular(count: usize, angle: f64) -> Result<Self, ProblemError> {
        if count < 2 || count % 2 == 1 {
            let reason = format!("a polygon needs an even number of directions, at least 2; found {count}");
            return Err(ProblemError::Directions { contact: None, reason });
        }
        too_many(count)?;
        let step = std::f64::consts::TAU / count as f64;
        let half: Vec<[f64; 2]> = (0..count / 2).map(|k| unit_vector(angle + step * k as f64)).collect();
        let opposite = half.iter().map(|d| [-d[0], -d[1]]);
        Ok(Self { directions: half.iter().copied().chain(opposite).collect() })
    }

    /// `count` directions on an ellipse: friction `μ·semi_axes[0]` along the axis at `angle` rad from the first tangent,
    /// `μ·semi_axes[1]` across it. A skate has a small first and a large second semi-axis.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] if `count` is odd, less than 4 or more than [`MOST_DIRECTIONS`], or a semi-axis is not positive and finite.
    pub fn ellipse(count: usize, semi_axes: [f64; 2], angle: f64) -> Result<Self, ProblemError> {
        too_many(count)?;
        let refused = |reason| Err(ProblemError::Directions { contact: None, reason });
        if count < 4 {
            return refused(format!("an ellipse needs an even number of directions, at least 4; found {count}"));
        }
        if !semi_axes.iter().all(|a| *a > 0.0 && a.is_finite()) {
            return refused(format!("the semi-axes {semi_axes:?} must be positive and finite"));
        }
        let circle = Self::regular(count, 0.0)?;
        Self::from_directions(circle.directions.iter().map(|d| stretched(d, semi_axes, angle)).collect())
    }

    /// Directions on an ellipse, from those of a circle: each is stretched by `semi_axes` along and across the axis at `angle`, rad
    /// from the first tangent. Keeps its memory.
    ///
    /// `circle`: directions of length 1; `semi_axes`: positive and finite
    pub fn stretch(&mut self, circle: &Self, semi_axes: [f64; 2], angle: f64) {
        self.directions.clear();
        self.directions.extend(circle.directions.iter().map(|d| stretched(d, semi_axes, angle)));
    }

    /// The user's own directions, of any length.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] if one is zero or not finite, appears twice, lacks its opposite, or is no corner of their
    /// convex hull.
    pub fn from_directions(directions: Vec<[f64; 2]>) -> Result<Self, ProblemError> {
        check_directions(&directions).map_err(|reason| ProblemError::Directions { contact: None, reason })?;
        Ok(Self { directions })
    }

    /// The directions in their own order.
    pub fn directions(&self) -> &[[f64; 2]] {
        &self.directions
    }
}

/// A direction of a circle brought onto an ellipse whose first semi-axis is at `angle`.
fn stretched(d: &[f64; 2], [a, b]: [f64; 2], angle: f64) -> [f64; 2] {
    let [cos, sin] = unit_vector(angle);
    [cos * a * d[0] - sin * b * d[1], sin * a * d[0] + cos * b * d[1]]
}

/// Says what is wrong with a set of directions, if anything.
pub(crate) fn check_directions(directions: &[[f64; 2]]) -> Result<(), String> {
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= OPPOSITE_TOLERANCE;
    for (k, d) in directions.iter().enumerate() {
        let length = d[0].hypot(d[1]);
        if !(length.is_finite() && length > OPPOSITE_TOLERANCE) {
            return Err(format!("direction {k} = {d:?} has length {length}; it must be finite and not zero"));
        }
        if let Some(j) = directions[..k].iter().position(|e| near(*e, *d)) {
            return Err(format!("directions {j} and {k} are the same; give each direction once"));
        }
        if !directions.iter().any(|e| near([-e[0], -e[1]], *d)) {
            return Err(format!("direction {k} = {d:?} has no opposite; the directions must be balanced"));
        }
    }
    match no_corner(directions) {
        Some(k) => Err(format!("direction {k} = {:?} is no corner of the polygon; leave it out", directions[k])),
        None => Ok(()),
    }
}

/// The first direction that is no corner of the convex hull of all of them, which holds the origin.
fn no_corner(directions: &[[f64; 2]]) -> Option<usize> {
    if directions.len() <= 2 {
        return None;
    }
    let angle = |k: &usize| directions[*k][1].atan2(directions[*k][0]);
    let mut order: Vec<usize> = (0..directions.len()).collect();
    order.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let m = order.len();
    let turns_right = |i: &usize| {
        let [a, b, c] = [i + m - 1, *i, i + 1].map(|k| directions[order[k % m]]);
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) <= 0.0
    };
    (0..m).filter(turns_right).map(|i| order[i]).min()
}

fn unit_vector(angle: f64) -> [f64; 2] {
    let clean = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
    [clean(angle.cos()), clean(angle.sin())]
}
