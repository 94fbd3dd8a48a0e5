//! Friction polygons: the set `μ λ_N · conv{d_1 … d_m}` of admissible tangential impulses (formulation §2).

use crate::ProblemError;

/// How far a direction's length, or its opposite, may be off.
const UNIT_TOLERANCE: f64 = 1e-9;

/// The unit tangent directions of one contact, balanced: `−d` is among them whenever `d` is.
///
/// In 3-D there are at least four, in the plane two; a frictionless contact has none. The directions keep the order they
/// were given in, which is the order of the multipliers `α`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FrictionPolygon {
    directions: Vec<[f64; 2]>,
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
    /// [`ProblemError::Directions`] if `count` is odd or less than 2.
    pub fn regular(count: usize, angle: f64) -> Result<Self, ProblemError> {
        if count < 2 || count % 2 == 1 {
            let reason = format!("a polygon needs an even number of directions, at least 2; found {count}");
            return Err(ProblemError::Directions { contact: None, reason });
        }
        let step = std::f64::consts::TAU / count as f64;
        let half: Vec<[f64; 2]> = (0..count / 2).map(|k| unit_vector(angle + step * k as f64)).collect();
        let opposite = half.iter().map(|d| [-d[0], -d[1]]);
        Ok(Self { directions: half.iter().copied().chain(opposite).collect() })
    }

    /// The user's own directions.
    ///
    /// # Errors
    /// [`ProblemError::Directions`] if one is not a unit vector, appears twice, or lacks its opposite.
    pub fn from_directions(directions: Vec<[f64; 2]>) -> Result<Self, ProblemError> {
        check_directions(&directions).map_err(|reason| ProblemError::Directions { contact: None, reason })?;
        Ok(Self { directions })
    }

    /// The directions in their own order.
    pub fn directions(&self) -> &[[f64; 2]] {
        &self.directions
    }
}

/// Says what is wrong with a set of directions, if anything.
pub(crate) fn check_directions(directions: &[[f64; 2]]) -> Result<(), String> {
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= UNIT_TOLERANCE;
    for (k, d) in directions.iter().enumerate() {
        let length = d[0].hypot(d[1]);
        if !length.is_finite() || (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(format!("direction {k} = {d:?} has length {length}; every direction must be a unit vector"));
        }
        if let Some(j) = directions[..k].iter().position(|e| near(*e, *d)) {
            return Err(format!("directions {j} and {k} are the same; give each direction once"));
        }
        if !directions.iter().any(|e| near([-e[0], -e[1]], *d)) {
            return Err(format!("direction {k} = {d:?} has no opposite; the directions must be balanced"));
        }
    }
    Ok(())
}

fn unit_vector(angle: f64) -> [f64; 2] {
    let clean = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
    [clean(angle.cos()), clean(angle.sin())]
}
