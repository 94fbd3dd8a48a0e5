use crate::{LcpError, Matrix};

/// Positive weights that put all `z_i` and all `w_i` in one unit: `z̃_i = z[i]·z_i`, `w̃_i = w[i]·w_i`.
///
/// Complementarity compares `z_i` with `w_i`, which have different units; a residual means something only
/// after both are in the unit of `b`. A contact problem measures everything in velocity: impulses times the
/// Delassus scale `g`, sliding speeds as they are, the friction bound (an impulse) times `g`.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    z: Vec<f64>,
    w: Vec<f64>,
}

impl Scaling {
    /// Weights given by the caller, one per variable and one per row.
    ///
    /// # Errors
    /// [`LcpError::Length`] when the two differ in length, [`LcpError::Weight`] for a weight that is not
    /// positive and finite.
    pub fn new(z: Vec<f64>, w: Vec<f64>) -> Result<Self, LcpError> {
        if z.len() != w.len() {
            return Err(LcpError::Length { what: "scaling weights w", expected: z.len(), found: w.len() });
        }
        for (what, weights) in [("z", &z), ("w", &w)] {
            if let Some(index) = weights.iter().position(|&x| !(x > 0.0 && x.is_finite())) {
                return Err(LcpError::Weight { what, index, value: weights[index] });
            }
        }
        Ok(Self { z, w })
    }

    /// The default for a problem without units: `z̃ = g z`, `w̃ = w` with `g = max |diag A|`,
    /// or `max |A|` where that is 0, or 1 where `A = 0`.
    pub fn from_diagonal(A: &Matrix) -> Self {
        let n = A.rows().min(A.cols());
        let largest = |max: f64, x: f64| max.max(x.abs());
        let diagonal = (0..n).map(|i| A[(i, i)]).fold(0.0, largest);
        let all = A.data().iter().copied().fold(0.0, largest);
        let g = [diagonal, all].into_iter().find(|&g| g > 0.0).unwrap_or(1.0);
        Self { z: vec![g; n], w: vec![1.0; n] }
    }

    /// Weights of the variables.
    pub fn z(&self) -> &[f64] {
        &self.z
    }

    /// Weights of the rows.
    pub fn w(&self) -> &[f64] {
        &self.w
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.z.len()
    }

    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.z.is_empty()
    }
}

/// The natural-map residual of a point, in one unit and relative to the data.
///
/// `value = ‖r‖_∞ / max|b|` with `r_i = |min(z̃_i, w̃_i)|` on complementary rows and `|w̃_i|` on free rows,
/// `w = A z + b`. With `b = 0` the point `z = 0` is a solution and the denominator would be 0: `value` is then
/// 0 for a vanishing `r` and infinite otherwise. It is infinite too when the point is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// The relative residual.
    pub value: f64,
    /// The row where it is attained; `None` where it is 0.
    pub row: Option<usize>,
}

impl Residual {
    pub(crate) fn of(z: &[f64], w: &[f64], b: &[f64], scaling: &Scaling, free: impl Fn(usize) -> bool) -> Self {
        let mut worst = Self { value: 0.0, row: None };
        for i in 0..z.len() {
            let natural = if free(i) { scaling.w[i] * w[i] } else { (scaling.z[i] * z[i]).min(scaling.w[i] * w[i]) };
            // `min` drops a NaN, so the inputs are tested and not only the result.
            let size = if z[i].is_finite() && w[i].is_finite() { natural.abs() } else { f64::INFINITY };
            if size > worst.value {
                worst = Self { value: size, row: Some(i) };
            }
        }
        if worst.row.is_some() {
            worst.value /= b.iter().fold(0.0f64, |max, x| max.max(x.abs()));
        }
        worst
    }

    /// Whether the residual is at most `tolerance`.
    pub fn within(&self, tolerance: f64) -> bool {
        self.value <= tolerance
    }
}
