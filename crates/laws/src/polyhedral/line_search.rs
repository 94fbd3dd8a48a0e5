//! The length of a step that minimises a convex function.

/// The search ends where the slope has fallen to this part.
const SLOPE: f64 = 0.05;
/// Evaluations of the slope at most.
const MAX_EVALUATIONS: u32 = 40;

/// The part of a step after which the slope of a convex function along it, which grows monotonically, has nearly vanished: all of it if
/// it does there, or if the step goes uphill; else a root of the slope by the Illinois method, or what is known to lie before it.
pub(crate) fn step_length(slope: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let target = SLOPE * low.1.abs();
    if high.1 <= target || low.1 >= 0.0 {
        return 1.0;
    }
    let mut last = 0.0_f64;
    for _ in 0..MAX_EVALUATIONS {
        let t = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let s = slope(t);
        if s.abs() <= target {
            return t;
        }
        let (moved, kept) = if s < 0.0 { (&mut low, &mut high) } else { (&mut high, &mut low) };
        *moved = (t, s);
        if s * last > 0.0 {
            kept.1 *= 0.5;
        }
        last = s;
    }
    low.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a quadratic function, of one with a kink, of one that still falls at the end, and of one that rises from the beginning.
    #[test]
    fn slopes_nearly_vanish() {
        assert!((step_length(|t| 4.0 * t - 1.0) - 0.25).abs() < 0.25 * SLOPE);
        let kinked = |steep: f64| move |t: f64| if t < 0.1 { t - 0.2 } else { steep * (t - 0.1) - 0.1 };
        let slope = kinked(1e3);
        assert!(slope(step_length(slope)).abs() <= SLOPE * 0.2);
        // A kink that is too sharp for so many evaluations: the function has fallen, and does so still.
        let sharp = kinked(1e9);
        let length = step_length(sharp);
        assert!(length > 0.05 && sharp(length) <= SLOPE * 0.2, "{length}");
        assert_eq!(step_length(|t| 0.5 * t - 1.0), 1.0);
        assert_eq!(step_length(|t| t + 1.0), 1.0);
    }
}
