use crate::equilibrate::Scaled;
use crate::linalg::{Lu, add_product, add_product_doubled, add_scaled_wide, apply_updates};

/// A basis of `w − A z − d z0 = b`, factorised, with product-form updates; `d = 0` where a method has no `z0`.
///
/// Variables are numbered `w_i = i`, `z_j = n + j`, `z0 = 2n`. Columns of basic `w` are unit vectors, so only the
/// core needs factors: rows whose `w` is not basic, columns of the basic `z` and `z0`.
///
/// Source: Dantzig, Orchard-Hays (1954), product form of the inverse.
#[derive(Clone, Debug, Default)]
pub(crate) struct FactoredBasis {
    pub(crate) n: usize,
    /// The variable at each position.
    pub(crate) head: Vec<usize>,
    pub(crate) d: Vec<f64>,
    core_rows: Vec<usize>,
    core_cols: Vec<usize>,
    core: Lu,
    /// Transformed entering columns since the factorisation, `[updates, n]`, and their positions.
    etas: Vec<f64>,
    eta_positions: Vec<usize>,
    core_rhs: Vec<f64>,
    w_basic: Vec<bool>,
    /// What the sums of a residual lack.
    low: Vec<f64>,
}

impl FactoredBasis {
    /// Starts from a complementary basis.
    pub(crate) fn start(&mut self, n: usize, z_basic: &[bool]) {
        self.n = n;
        self.d.clear();
        self.d.resize(n, 0.0);
        self.head.clear();
        self.head.extend((0..n).map(|i| if z_basic[i] { n + i } else { i }));
    }

    pub(crate) fn updates(&self) -> usize {
        self.eta_positions.len()
    }

    /// Factorises the basis afresh and orders `head` anew; returns the smallest relative pivot, 0 if singular.
    pub(crate) fn factorize(&mut self, problem: &Scaled) -> f64 {
        let n = self.n;
        self.etas.clear();
        self.eta_positions.clear();
        self.core_cols.clear();
        self.core_cols.extend(self.head.iter().copied().filter(|&v| v >= n));
        self.core_cols.sort_unstable_by_key(|&v| if v == 2 * n { n } else { problem.rank(v - n) });
        self.core_rows.clear();
        self.w_basic.clear();
        self.w_basic.resize(n, false);
        for &v in self.head.iter().filter(|&&v| v < n) {
            self.w_basic[v] = true;
        }
        let w_basic = &self.w_basic;
        self.core_rows.extend((0..n).filter(|&i| !w_basic[i]));
        self.core_rows.sort_unstable_by_key(|&i| problem.rank(i));
        for i in 0..n {
            self.head[i] = i;
        }
        let k = self.core_cols.len();
        let data = self.core.start(k);
        for (c, &variable) in self.core_cols.iter().enumerate() {
            self.head[self.core_rows[c]] = variable;
            let column = if variable == 2 * n { &self.d[..] } else { problem.column(variable - n) };
            for (r, &i) in self.core_rows.iter().enumerate() {
                data[r * k + c] = -column[i];
            }
        }
        if k == 0 { 1.0 } else { self.core.factorize() }
    }

    /// `v ← B⁻¹ v`: by row on entry, by position on return.
    pub(crate) fn solve(&mut self, problem: &Scaled, v: &mut [f64]) {
        self.core_rhs.clear();
        self.core_rhs.extend(self.core_rows.iter().map(|&i| v[i]));
        if self.core_rhs.iter().any(|&x| x != 0.0) {
            self.core.solve(&mut self.core_rhs);
            for (&variable, &x) in self.core_cols.iter().zip(&self.core_rhs) {
                if x != 0.0 {
                    self.add_column(problem, variable, x, v);
                }
            }
        }
        for (&i, &x) in self.core_rows.iter().zip(&self.core_rhs) {
            v[i] = x;
        }
        apply_updates(v, &self.etas, &self.eta_positions);
    }

    /// `out += factor · A'_j` for the variable `z_j`, `factor · d` for `z0`.
    fn add_column(&self, problem: &Scaled, variable: usize, factor: f64, out: &mut [f64]) {
        if variable == 2 * self.n {
            add_scaled_wide(out, factor, &self.d);
        } else {
            problem.add_column(variable - self.n, factor, out);
        }
    }

    /// `out ←` the column of a variable, by row.
    pub(crate) fn column_into(&self, problem: &Scaled, variable: usize, out: &mut [f64]) {
        let n = self.n;
        if variable < n {
            out.fill(0.0);
            out[variable] = 1.0;
        } else {
            let column = if variable == 2 * n { &self.d[..] } else { problem.column(variable - n) };
            out.iter_mut().zip(column).for_each(|(out, x)| *out = -x);
        }
    }

    /// Puts `entering`, whose transformed column is `a`, in the place of the variable at `position`.
    pub(crate) fn replace(&mut self, position: usize, entering: usize, a: &[f64]) {
        self.etas.extend_from_slice(a);
        self.eta_positions.push(position);
        self.head[position] = entering;
    }

    /// `out ← B x`: `x` by position, `out` by row.
    pub(crate) fn multiply_into(&self, problem: &Scaled, x: &[f64], out: &mut [f64]) {
        let n = self.n;
        out.fill(0.0);
        for (&variable, &x) in self.head.iter().zip(x) {
            if variable < n {
                out[variable] += x;
            } else if x != 0.0 {
                self.add_column(problem, variable, -x, out);
            }
        }
    }

    /// `out ← rhs − B x`, accumulated in doubled precision.
    pub(crate) fn residual_into(&mut self, problem: &Scaled, rhs: &[f64], x: &[f64], out: &mut [f64]) {
        let n = self.n;
        out.copy_from_slice(rhs);
        self.low.clear();
        self.low.resize(n, 0.0);
        for (&variable, &x) in self.head.iter().zip(x) {
            if variable < n {
                add_product(&mut out[variable], &mut self.low[variable], -1.0, x);
            } else if variable == 2 * n {
                add_product_doubled(out, &mut self.low, &self.d, x);
            } else if x != 0.0 {
                problem.add_column_doubled(variable - n, x, out, &mut self.low);
            }
        }
        out.iter_mut().zip(&self.low).for_each(|(out, low)| *out += low);
    }
}
