//! Which bilateral rows are independent, what follows from the others, and what contradicts them.

use signorini_multibody::BlockCholesky;

use signorini_contact::SparseRows;
use signorini_contact::vector::inner;

/// What is tuned in the choice of rows.
struct Tuning {
    /// A row is dependent where the square of its part outside the span of the rows chosen is below this, relative to the row, in the
    /// metric of M⁻¹. Rounding of the factorisation leaves about 1e-15. Of a combination of rows, parts below its root are rounding.
    dependent: f64,
    /// Pivots of this part of the largest one are about as independent.
    as_good: f64,
}

/// Chosen by: `dependent` by the four loops of MuJoCo Menagerie's Cassie, which have rows of 3e-6 when they close, 28 November 2026; `as_good` by
/// reasoning: two rows of a basis at right angles are, and a pivot of half the largest costs no digits.
const TUNING: Tuning = Tuning { dependent: 1e-10, as_good: 0.5 };

/// A largest set of independent rows of `B`, by Cholesky factorisation of `B M⁻¹ Bᵀ` with complete pivoting; memory is reused.
///
/// # Source
/// N. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed. (2002), §10.3.
#[derive(Clone, Debug, Default)]
pub struct BilateralBasis {
    /// The rows in the order of the pivots; the first `rank` are the basis.
    order: Vec<usize>,
    rank: usize,
    /// Row by row: the scaled `B M⁻¹ Bᵀ` below, its factor in the first `rank` columns, `[nb, nb]` in pivot order.
    factor: Vec<f64>,
    /// `1 / √(B M⁻¹ Bᵀ)_kk`, or 0 for a row that moves nothing.
    scale: Vec<f64>,
    /// `Y` with `YᵀY = B M⁻¹ Bᵀ`, column by column, `[nb, n]` over the degrees of freedom of the blocks: half a solve of every row.
    half_rows: Vec<f64>,
    /// The blocks of M that have a part in the rows, ascending, and where each of them begins among their degrees of freedom, and the total `n`.
    blocks: Vec<usize>,
    starts: Vec<usize>,
    solution: Vec<f64>,
}

impl BilateralBasis {
    /// Factorises `B M⁻¹ Bᵀ`.
    ///
    /// - `rows`: `B`
    /// - `mass`: the factor of `M`
    ///
    /// # Cost
    /// `nb` half solves with M, O(nb² n) for the products and O(nb² rank) for the factor, of `nb` rows in blocks of M with `n` degrees of freedom. No
    /// allocation after warm-up.
    pub fn factor(&mut self, rows: &SparseRows<1>, mass: &BlockCholesky) {
        self.factor_scaled(rows, mass, false);
    }

    /// The same, but of rows that are about as independent the basis has the one that moves most: a row of a millionth of another one is rounding
    /// where it follows from that, and what is left out has to follow from rows with digits.
    pub fn factor_preferring_large(&mut self, rows: &SparseRows<1>, mass: &BlockCholesky) {
        self.factor_scaled(rows, mass, true);
    }

    fn factor_scaled(&mut self, rows: &SparseRows<1>, mass: &BlockCholesky, prefers_large: bool) {
        let nb = rows.len();
        self.find_blocks(rows, mass);
        let n = self.starts[self.blocks.len()];
        self.half_rows.clear();
        self.half_rows.resize(nb * n, 0.0);
        self.factor.clear();
        self.factor.resize(nb * nb, 0.0);
        for i in 0..nb {
            let (before, own) = self.half_rows.split_at_mut(i * n);
            let own = &mut own[..n];
            let (columns, entries) = rows.group(i);
            for (b, part) in mass.blocks_touched(columns) {
                let (place, first) = (self.blocks.partition_point(|&other| other < b), mass.blocks()[b].start);
                let range = self.starts[place]..self.starts[place + 1];
                for (column, [entry]) in columns[part.clone()].iter().zip(&entries[part]) {
                    own[range.start + *column as usize - first] = *entry;
                }
                mass.half_solve_block_in_place(b, &mut own[range.clone()]);
                for k in 0..i {
                    self.factor[i * nb + k] += inner(&own[range.clone()], &before[k * n..][range.clone()]);
                }
                self.factor[i * nb + i] += inner(&own[range.clone()], &own[range]);
            }
        }
        self.mirror(nb);
        self.scale.clear();
        let factor = &self.factor;
        self.scale.extend((0..nb).map(|k| factor[k * nb + k]).map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }));
        for i in 0..nb {
            for k in 0..nb {
                self.factor[i * nb + k] *= self.scale[i] * self.scale[k];
            }
        }
        self.order.clear();
        self.order.extend(0..nb);
        self.eliminate(nb, prefers_large);
    }

    fn find_blocks(&mut self, rows: &SparseRows<1>, mass: &BlockCholesky) {
        self.blocks.clear();
        for i in 0..rows.len() {
            self.blocks.extend(mass.blocks_touched(rows.group(i).0).map(|(b, _)| b));
        }
        self.blocks.sort_unstable();
        self.blocks.dedup();
        self.starts.clear();
        self.starts.push(0);
        for &b in &self.blocks {
            self.starts.push(self.starts[self.starts.len() - 1] + mass.blocks()[b].size);
        }
    }

    /// Cholesky with pivoting, in place; the rows and columns of `factor` follow `order`.
    fn eliminate(&mut self, nb: usize, prefers_large: bool) {
        self.rank = 0;
        for k in 0..nb {
            let diagonal = |i: usize| self.factor[i * nb + i];
            let largest = (k..nb).fold(0.0_f64, |most, i| most.max(diagonal(i)));
            if largest <= TUNING.dependent {
                return;
            }
            let scale = |i: usize| self.scale[self.order[i]];
            let smaller = |a: usize, b: usize| if prefers_large && scale(b) < scale(a) { b } else { a };
            let least = if prefers_large { TUNING.as_good * largest } else { largest };
            let pivot = (k..nb).filter(|&i| diagonal(i) >= least).reduce(smaller).unwrap_or(k);
            self.swap(k, pivot, nb);
            let root = self.factor[k * nb + k].sqrt();
            for i in k..nb {
                self.factor[i * nb + k] /= root;
            }
            // Row by row, the part above the diagonal with it: it is symmetric, and memory is read in its order.
            let Self { solution: column, factor, .. } = self;
            column.clear();
            column.extend((k + 1..nb).map(|i| factor[i * nb + k]));
            for (row, own) in factor.chunks_exact_mut(nb).skip(k + 1).zip(&*column) {
                row[k + 1..].iter_mut().zip(&*column).for_each(|(x, other)| *x -= own * other);
            }
            self.rank = k + 1;
        }
    }

    /// Makes the part above the diagonal that below it.
    fn mirror(&mut self, nb: usize) {
        for i in 0..nb {
            (0..i).for_each(|j| self.factor[j * nb + i] = self.factor[i * nb + j]);
        }
    }

    fn swap(&mut self, a: usize, b: usize, nb: usize) {
        if a == b {
            return;
        }
        self.order.swap(a, b);
        (0..nb).for_each(|j| self.factor.swap(a * nb + j, b * nb + j));
        (0..nb).for_each(|i| self.factor.swap(i * nb + a, i * nb + b));
    }

    /// Number of independent rows.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The independent rows that were chosen, in no particular order.
    pub fn independent(&self) -> &[usize] {
        &self.order[..self.rank]
    }

    /// The smallest change of velocity in the metric of M with `B change = −rate` on the independent rows.
    ///
    /// - `rate`: `[nb]`; entries of dependent rows are not read
    /// - `mass`: the factor of `M` that the rows were factorised with
    /// - `change`: out, `[nv]`; written where the blocks of the rows are, and nowhere else
    pub fn solve_into(&mut self, rate: &[f64], mass: &BlockCholesky, change: &mut [f64]) {
        let (nb, rank) = (self.order.len(), self.rank);
        self.solution.clear();
        self.solution.extend(self.order[..rank].iter().map(|&k| -rate[k] * self.scale[k]));
        forward(&self.factor, nb, &mut self.solution);
        backward(&self.factor, nb, &mut self.solution);
        let n = self.starts.last().copied().unwrap_or(0);
        for (&b, part) in self.blocks.iter().zip(self.starts.windows(2)) {
            let own = &mut change[mass.blocks()[b].range()];
            own.fill(0.0);
            for (p, &k) in self.order[..rank].iter().enumerate() {
                let impulse = self.solution[p] * self.scale[k];
                let row = &self.half_rows[k * n..][part[0]..part[1]];
                own.iter_mut().zip(row).for_each(|(c, r)| *c += impulse * r);
            }
            mass.other_half_solve_block_in_place(b, own);
        }
    }

    /// The rows of the first contradiction: a dependent row whose `rate` (`[nb]`: `B v^f + Θ/Δt`) is off by more than `tolerance`
    /// from what the independent rows leave, and the independent rows that it is a combination of. Empty where there is none.
    pub fn contradiction(&mut self, rate: &[f64], tolerance: f64) -> Vec<usize> {
        let (nb, rank) = (self.order.len(), self.rank);
        for p in rank..nb {
            let row = self.order[p];
            // With l the row's part of the factor, L Lᵀ c = L l: the row is the combination c = L⁻ᵀ l of the basis.
            self.solution.clear();
            self.solution.extend_from_slice(&self.factor[p * nb..p * nb + rank]);
            backward(&self.factor, nb, &mut self.solution);
            let weight = |k: usize| if self.scale[row] > 0.0 { self.scale[k] / self.scale[row] } else { 0.0 };
            let basis = || self.order[..rank].iter().zip(&self.solution);
            let wanted: f64 = basis().map(|(&k, c)| c * weight(k) * rate[k]).sum();
            if (rate[row] - wanted).abs() > tolerance {
                let largest = self.solution.iter().fold(0.0, |a: f64, c| a.max(c.abs()));
                let least = TUNING.dependent.sqrt() * largest;
                let mut rows: Vec<usize> = basis().filter(|(_, c)| c.abs() > least).map(|(&k, _)| k).collect();
                rows.push(row);
                rows.sort_unstable();
                return rows;
            }
        }
        Vec::new()
    }
}

/// `x ← L⁻¹ x` with the leading block of `factor`.
fn forward(factor: &[f64], stride: usize, x: &mut [f64]) {
    for i in 0..x.len() {
        let sum: f64 = (0..i).map(|j| factor[i * stride + j] * x[j]).sum();
        x[i] = (x[i] - sum) / factor[i * stride + i];
    }
}

/// `x ← L⁻ᵀ x` with the leading block of `factor`.
fn backward(factor: &[f64], stride: usize, x: &mut [f64]) {
    for i in (0..x.len()).rev() {
        let sum: f64 = (i + 1..x.len()).map(|j| factor[j * stride + i] * x[j]).sum();
        x[i] = (x[i] - sum) / factor[i * stride + i];
    }
}
