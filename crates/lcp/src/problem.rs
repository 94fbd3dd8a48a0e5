use crate::linalg::are_finite;
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
    pub(crate) fn residual_at(&self, z: &[f64], w: &[f64]) -> Residual {
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
