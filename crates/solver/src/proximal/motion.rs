//! How contacts move along a path from one breakpoint to the next.

use pulp::{Arch, Simd, WithSimd};

use signorini_contact::SparseRows;
use signorini_sparse::{FREE, SUMS, load};

/// Where every contact is on a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    /// `dy_c/dt`.
    pub rate: Vec<[f64; 3]>,
    /// `‖dy_c/dt‖₁`.
    pub pace: Vec<f64>,
    /// How far each `y_c` may still move, in the 1-norm, before it can meet a facet of its mode's cone: a
    /// lower bound, kept by [`first_crossing`](super::breakpoint::first_crossing).
    pub clearance: Vec<f64>,
}

impl Motion {
    /// After the rates were set anew: nothing is known of the facets.
    pub fn begin(&mut self) {
        self.pace.clear();
        self.pace.extend(self.rate.iter().map(|rate| size(*rate)));
        self.clearance.clear();
        self.clearance.resize(self.rate.len(), 0.0);
    }

    /// Moves every `y_c` by `step` times its rate.
    pub fn advance(&mut self, y: &mut [[f64; 3]], step: f64) {
        Arch::new().dispatch(Advance { y: y.as_flattened_mut(), motion: self, step });
    }

    /// Subtracts `factor ρ_c J_c w` of a column `w` from the rates.
    pub fn correct(&mut self, jacobian: &SparseRows<3>, weight: &[f64], column: &[f64], factor: f64) {
        let Self { rate, pace, .. } = self;
        Arch::new().dispatch(Correction { jacobian, weight, column, factor, rate, pace });
    }
}

/// `‖x‖₁`.
#[inline]
pub(super) fn size(x: [f64; 3]) -> f64 {
    x[0].abs() + x[1].abs() + x[2].abs()
}

struct Advance<'a> {
    y: &'a mut [f64],
    motion: &'a mut Motion,
    step: f64,
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { y, motion, step } = self;
        for (y, rate) in y.iter_mut().zip(motion.rate.as_flattened()) {
            *y += step * rate;
        }
        for (clearance, pace) in motion.clearance.iter_mut().zip(&motion.pace) {
            *clearance -= step.abs() * pace;
        }
    }
}

struct Correction<'a> {
    jacobian: &'a SparseRows<3>,
    weight: &'a [f64],
    column: &'a [f64],
    factor: f64,
    rate: &'a mut [[f64; 3]],
    pace: &'a mut [f64],
}

impl WithSimd for Correction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { jacobian, weight, column, factor, rate, pace } = self;
        for (c, ((rate, pace), weight)) in rate.iter_mut().zip(pace).zip(weight).enumerate() {
            let u = multiply_bodies(simd, jacobian, c, column).unwrap_or_else(|| jacobian.multiply(c, column));
            for r in 0..3 {
                rate[r] -= weight * u[r] * factor;
            }
            *pace = size(*rate);
        }
    }
}

/// Entries that are read for a body of three rows, the last of them as a part of the widest vector.
const READ: usize = 3 * (FREE - 1) + SUMS;

/// `J_c x` for a contact whose columns are those of whole free bodies, three rows at a time and with the sums of
/// [`SparseRows::multiply`]; nothing for others, and where vectors would reach beyond the Jacobian's last entry.
#[inline(always)]
fn multiply_bodies<S: Simd>(simd: S, jacobian: &SparseRows<3>, c: usize, x: &[f64]) -> Option<[f64; 3]> {
    let (columns, mut entries) = jacobian.group_and_rest(c);
    let (bodies, rest) = columns.as_chunks::<FREE>();
    if !rest.is_empty() || S::F64_LANES < 3 {
        return None;
    }
    let mut sum = simd.splat_f64s(0.0);
    for body in bodies {
        let start = body[0] as usize;
        let own = entries.first_chunk::<READ>().filter(|_| body[FREE - 1] as usize == start + FREE - 1)?;
        let x = x[start..].first_chunk::<FREE>()?;
        for k in 0..FREE {
            let entry = load(simd, &own[3 * k..3 * k + S::F64_LANES]);
            sum = simd.add_f64s(sum, simd.mul_f64s(entry, simd.splat_f64s(x[k])));
        }
        entries = &entries[3 * FREE..];
    }
    let sum: &[f64] = pulp::bytemuck::cast_slice(std::slice::from_ref(&sum));
    sum.first_chunk().copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use signorini_sparse::Random;

    /// The rates after a correction with vectors of some width are, to the bit, those of the rows taken one by one.
    fn check(correct: impl Fn(Correction)) {
        let mut random = Random::new(1);
        let mut jacobian = SparseRows::<3>::default();
        let columns: [&[u32]; 6] = [
            &[0, 1, 2, 3, 4, 5],
            &[3, 4, 5, 6, 7, 8, 20, 21, 22, 23, 24, 25],
            &[0, 2, 3, 5, 6, 7],
            &[1, 4],
            &[0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12],
            &[12, 13, 14, 15, 16, 17, 24, 25, 26, 27, 28, 29],
        ];
        // The last contact has nothing behind it.
        for k in (0..24).map(|k| columns[k % 6]) {
            jacobian.push(k.iter().map(|&k| (k, [(); 3].map(|()| random.between(-1.0, 1.0)))));
        }
        let mut number = || random.between(-1.0, 1.0);
        let column: Vec<f64> = (0..30).map(|_| number()).collect();
        let weight: Vec<f64> = (0..24).map(|_| number()).collect();
        let before: Vec<[f64; 3]> = (0..24).map(|_| [(); 3].map(|()| number())).collect();
        let (mut rate, mut pace, factor) = (before.clone(), vec![0.0; 24], 0.37);
        correct(Correction {
            jacobian: &jacobian,
            weight: &weight,
            column: &column,
            factor,
            rate: &mut rate,
            pace: &mut pace,
        });
        for c in 0..24 {
            let (columns, entries) = jacobian.group(c);
            let mut u = [0.0; 3];
            for (&k, entry) in columns.iter().zip(entries) {
                (0..3).for_each(|r| u[r] += entry[r] * column[k as usize]);
            }
            let wanted: [f64; 3] = std::array::from_fn(|r| before[c][r] - weight[c] * u[r] * factor);
            assert_eq!(rate[c], wanted, "contact {c}");
            assert_eq!(pace[c], wanted[0].abs() + wanted[1].abs() + wanted[2].abs());
        }
    }

    #[test]
    fn corrections_are_the_same_with_all_vectors() {
        check(|correction| Arch::new().dispatch(correction));
        check(|correction| correction.with_simd(pulp::Scalar::new()));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            check(|correction| correction.with_simd(simd));
        }
    }
}
