use crate::{LcpError, Matrix, Residual, Scaling};

/// The linear complementarity problem: find `z` with `0 ≤ z ⟂ w = A z + b ≥ 0`.
///
/// Source: Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §1.1.
#[derive(Clone, Debug, PartialEq)]
pub struct Lcp {
    A: Matrix,
    b: Vec<f64>,
    scaling: Scaling,
}

impl Lcp {
    /// A problem with the [default scaling](Scaling::from_diagonal).
    ///
    /// - `A`: `[n, n]`
    /// - `b`: `[n]`
    ///
    /// # Errors
    /// [`LcpError::NotSquare`], [`LcpError::Length`], [`LcpError::MatrixNotFinite`],
    /// [`LcpError::VectorNotFinite`].
    pub fn new(A: Matrix, b: Vec<f64>) -> Result<Self, LcpError> {
        check_data(&A, &b)?;
        let scaling = Scaling::from_diagonal(&A);
        Ok(Self { A, b, scaling })
    }

    /// A problem whose variables have units of their own.
    ///
    /// # Errors
    /// As [`Lcp::new`], and [`LcpError::Length`] when the scaling is for another size.
    pub fn with_scaling(A: Matrix, b: Vec<f64>, scaling: Scaling) -> Result<Self, LcpError> {
        check_data(&A, &b)?;
        if scaling.len() != b.len() {
            return Err(LcpError::Length { what: "scaling", expected: b.len(), found: scaling.len() });
        }
        Ok(Self { A, b, scaling })
    }

    /// The matrix `A`, `[n, n]`.
    pub fn A(&self) -> &Matrix {
        &self.A
    }

    /// The vector `b`, `[n]`.
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// The weights that put `z` and `w` in one unit.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// Number of complementary pairs.
    pub fn len(&self) -> usize {
        self.b.len()
    }

    /// Whether the problem has no variables.
    pub fn is_empty(&self) -> bool {
        self.b.is_empty()
    }

    /// `w = A z + b`.
    ///
    /// # Panics
    /// When `z` does not have [`len`](Lcp::len) entries.
    pub fn w(&self, z: &[f64]) -> Vec<f64> {
        affine(&self.A, &self.b, z)
    }

    /// How far `z` is from a solution: see [`Residual`].
    ///
    /// # Panics
    /// When `z` does not have [`len`](Lcp::len) entries.
    pub fn residual(&self, z: &[f64]) -> Residual {
        self.residual_at(z, &self.w(z))
    }

    /// The residual of `z` whose `w` is known.
    pub fn residual_at(&self, z: &[f64], w: &[f64]) -> Residual {
        Residual::of(z, w, &self.b, &self.scaling, |_| false)
    }
}

/// The mixed problem: `0 ≤ z_i ⟂ w_i ≥ 0` on ordinary rows, `w_i = 0` with `z_i` of any sign on free rows,
/// `w = A z + b`.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedLcp {
    A: Matrix,
    b: Vec<f64>,
    free: Vec<bool>,
    scaling: Scaling,
}

impl MixedLcp {
    /// A mixed problem with the [default scaling](Scaling::from_diagonal).
    ///
    /// - `A`: `[n, n]`
    /// - `b`: `[n]`
    /// - `free`: `[n]`, true where `z_i` is free and `w_i = 0`
    ///
    /// # Errors
    /// As [`Lcp::new`], and [`LcpError::Length`] for `free`.
    pub fn new(A: Matrix, b: Vec<f64>, free: Vec<bool>) -> Result<Self, LcpError> {
        check_data(&A, &b)?;
        let scaling = Scaling::from_diagonal(&A);
        Self::with_scaling(A, b, free, scaling)
    }

    /// A mixed problem whose variables have units of their own.
    ///
    /// # Errors
    /// As [`MixedLcp::new`], and [`LcpError::Length`] when the scaling is for another size.
    pub fn with_scaling(A: Matrix, b: Vec<f64>, free: Vec<bool>, scaling: Scaling) -> Result<Self, LcpError> {
        check_data(&A, &b)?;
        for (what, found) in [("free", free.len()), ("scaling", scaling.len())] {
            if found != b.len() {
                return Err(LcpError::Length { what, expected: b.len(), found });
            }
        }
        Ok(Self { A, b, free, scaling })
    }

    /// The matrix `A`, `[n, n]`.
    pub fn A(&self) -> &Matrix {
        &self.A
    }

    /// The vector `b`, `[n]`.
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// Which variables are free.
    pub fn free(&self) -> &[bool] {
        &self.free
    }

    /// The weights that put `z` and `w` in one unit.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// Number of variables, free ones included.
    pub fn len(&self) -> usize {
        self.b.len()
    }

    /// Whether the problem has no variables.
    pub fn is_empty(&self) -> bool {
        self.b.is_empty()
    }

    /// `w = A z + b`.
    ///
    /// # Panics
    /// When `z` does not have [`len`](MixedLcp::len) entries.
    pub fn w(&self, z: &[f64]) -> Vec<f64> {
        affine(&self.A, &self.b, z)
    }

    /// How far `z` is from a solution: see [`Residual`].
    ///
    /// # Panics
    /// When `z` does not have [`len`](MixedLcp::len) entries.
    pub fn residual(&self, z: &[f64]) -> Residual {
        Residual::of(z, &self.w(z), &self.b, &self.scaling, |i| self.free[i])
    }
}

impl From<Lcp> for MixedLcp {
    /// The same problem, none of whose variables is free.
    fn from(Lcp { A, b, scaling }: Lcp) -> Self {
        Self { free: vec![false; b.len()], A, b, scaling }
    }
}

fn affine(A: &Matrix, b: &[f64], z: &[f64]) -> Vec<f64> {
    assert_eq!(z.len(), b.len(), "z must have one entry per row of A");
    let mut w = vec![0.0; b.len()];
    A.multiply_into(z, &mut w);
    for (w, b) in w.iter_mut().zip(b) {
        *w += b;
    }
    w
}

fn check_data(A: &Matrix, b: &[f64]) -> Result<(), LcpError> {
    if A.rows() != A.cols() {
        return Err(LcpError::NotSquare { rows: A.rows(), cols: A.cols() });
    }
    if A.rows() != b.len() {
        return Err(LcpError::Length { what: "b", expected: A.rows(), found: b.len() });
    }
    if !are_finite(A.data())
        && let Some(k) = A.data().iter().position(|x| !x.is_finite())
    {
        return Err(LcpError::MatrixNotFinite { row: k / A.cols(), col: k % A.cols(), value: A.data()[k] });
    }
    if let Some(index) = b.iter().position(|x| !x.is_finite()) {
        return Err(LcpError::VectorNotFinite { what: "b", index, value: b[index] });
    }
    Ok(())
}

/// Whether all are finite, without a branch for each: the exponent of one that is not has all bits set, and one more carries into
/// the place of the sign.
fn are_finite(x: &[f64]) -> bool {
    const EXPONENT: u64 = 0x7ff << 52;
    x.iter().fold(0, |bits, x| bits | ((x.to_bits() & EXPONENT) + (1 << 52))) >> 63 == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_seen_wherever_they_are() {
        for n in [1, 8, 19] {
            let numbers: Vec<f64> = (0..n).map(|i| (i as f64 - 3.0) * 10_f64.powi(30 * i - 270)).collect();
            assert!(are_finite(&numbers) && are_finite(&[f64::MAX, f64::MIN, -0.0, 5e-324]));
            for k in 0..n as usize {
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut x = numbers.clone();
                    x[k] = bad;
                    assert!(!are_finite(&x), "{bad} at {k} of {n}");
                }
            }
        }
    }
}
