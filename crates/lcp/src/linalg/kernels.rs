/// `y += factor · x`.
#[inline(always)]
pub(crate) fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// `y −= Σ_k factors[k] · rows[k]` for four rows in one sweep over `y`.
#[inline(always)]
pub(super) fn subtract_four(y: &mut [f64], factors: [f64; 4], rows: [&[f64]; 4]) {
    let n = y.len();
    let [r0, r1, r2, r3] = rows.map(|r| &r[..n]);
    for j in 0..n {
        y[j] -= (factors[0] * r0[j] + factors[1] * r1[j]) + (factors[2] * r2[j] + factors[3] * r3[j]);
    }
}

/// The power of two next below `|x|`, within 2^±500; 1 for zero and for numbers that are not finite.
pub(crate) fn power_of_two(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    let (least, largest) = (f64::from_bits((1023 - 500) << 52), f64::from_bits((1023 + 500) << 52));
    if x == 0.0 || !x.is_finite() {
        return 1.0;
    }
    // Without its mantissa a number is the power of two below it; a subnormal one becomes 0 and is clamped.
    f64::from_bits(x.to_bits() & EXPONENT).clamp(least, largest)
}

/// Sum of products accumulated in twice the working precision.
///
/// Source: Ogita, Rump, Oishi (2005), algorithm Dot2.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DoubleSum {
    high: f64,
    low: f64,
}

impl DoubleSum {
    pub(crate) fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    pub(crate) fn add_product(&mut self, a: f64, b: f64) {
        add_product(&mut self.high, &mut self.low, a, b);
    }

    pub(crate) fn value(self) -> f64 {
        self.high + self.low
    }
}

/// `high + low += a b` in doubled precision.
#[inline(always)]
pub(crate) fn add_product(high: &mut f64, low: &mut f64, a: f64, b: f64) {
    let (product, product_error) = two_product(a, b);
    let (sum, sum_error) = two_sum(*high, product);
    *high = sum;
    *low += sum_error + product_error;
}

#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

#[inline(always)]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    if cfg!(target_feature = "fma") {
        return (product, a.mul_add(b, -product));
    }
    // Without a hardware FMA `mul_add` is a slow library call; Veltkamp's splitting gives the same error term.
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let high = c - (c - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_sum_keeps_what_plain_summation_loses() {
        // 1e16·1 + 1·1 − 1e16·1 = 1, which plain f64 summation returns as 0.
        let mut sum = DoubleSum::new(0.0);
        sum.add_product(1e16, 1.0);
        sum.add_product(1.0, 1.0);
        sum.add_product(-1e16, 1.0);
        assert_eq!(sum.value(), 1.0);
        // (1 + 2⁻³⁰)² − 1 − 2⁻²⁹ = 2⁻⁶⁰: the error of one product.
        let x = 1.0 + 2f64.powi(-30);
        let mut square = DoubleSum::new(-1.0);
        square.add_product(-1.0, 2f64.powi(-29));
        square.add_product(x, x);
        assert_eq!(square.value(), 2f64.powi(-60));
    }

    #[test]
    fn power_of_two_brackets_its_argument() {
        assert_eq!(power_of_two(5.0), 4.0);
        assert_eq!(power_of_two(-0.3), 0.25);
        assert_eq!(power_of_two(0.0), 1.0);
        assert_eq!(power_of_two(f64::INFINITY), 1.0);
        assert_eq!(power_of_two(5e-324), 2f64.powi(-500));
        assert_eq!(power_of_two(-1e300), 2f64.powi(500));
        assert!((-400..400).all(|k| power_of_two(2f64.powi(k)) == 2f64.powi(k)));
    }
}
