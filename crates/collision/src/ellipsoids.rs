//! The direction along which two ellipsoids are farthest apart, or overlap least.
//!
//! The separation `s(n) = n·c − h_A(n) − h_B(n)` with the support functions `h = |A Rᵀ n|` of ellipsoids with centres `c` apart is smooth, and
//! Newton's method on the unit sphere finds its maximum in a few steps, where GJK converges linearly. Where they overlap by less than
//! the smallest radii of their curvatures together that maximum is the only one: no point closer than this to the boundary of their difference
//! has two nearest points on it (Blaschke's rolling theorem, 1916).

use glamx::glam::{DMat2, DMat3, DVec2, DVec3};

use crate::convex::{Convex, Placed};
use crate::separation::Separation;

/// Steps: of three hundred random pairs (the test below) most take four to seven, and none more than 15. What does not come closer is left to the
/// general search.
const ITERATIONS: usize = 30;
/// Halvings of a step that overlaps more than the one before it; a fifth of those pairs need any.
const HALVINGS: usize = 10;
/// Relative to the size: a remainder that moves the maximum by less than rounding.
const PRECISION: f64 = 1e-13;

/// One ellipsoid: `R A² Rᵀ`, and its smallest radius of curvature, m.
struct Ellipsoid {
    squares: DMat3,
    smallest_radius: f64,
}

/// A support function at a unit direction, m: its value, its gradient (the supporting point from the centre), its Hessian.
struct Support {
    value: f64,
    point: DVec3,
    hessian: DMat3,
}

impl Ellipsoid {
    fn new(placed: &Placed) -> Option<Self> {
        let Convex::Ellipsoid { axes } = placed.shape else { return None };
        let r = placed.rotation;
        let squares = r * DMat3::from_diagonal(*axes * *axes) * r.transpose();
        Some(Self { squares, smallest_radius: axes.min_element().powi(2) / axes.max_element() })
    }

    fn support(&self, n: DVec3) -> Support {
        let scaled = self.squares * n;
        let value = n.dot(scaled).sqrt();
        let point = scaled / value;
        let hessian =
            (self.squares - DMat3::from_cols(point * point.x, point * point.y, point * point.z)) * (1.0 / value);
        Support { value, point, hessian }
    }
}

/// The separation of two ellipsoids; `None` for other shapes, and where they overlap so much that it may not be the only maximum.
pub(crate) fn separation(a: &Placed, b: &Placed) -> Option<Separation> {
    let (of_a, of_b) = (Ellipsoid::new(a)?, Ellipsoid::new(b)?);
    let (size, between) = (a.size + b.size, b.center - a.center);
    let at = |n: DVec3| {
        let (p, q) = (of_a.support(n), of_b.support(n));
        (n.dot(between) - p.value - q.value, p, q)
    };
    // Of similar ellipsoids that touch this is the normal.
    let sum = of_a.squares + of_b.squares;
    let mut n = (sum.inverse() * between).try_normalize()?;
    let (mut gap, mut p, mut q) = at(n);
    for _ in 0..ITERATIONS {
        let rest = between - p.point - q.point - n * gap;
        if rest.length() <= PRECISION * size {
            break;
        }
        let step = newton_step(n, rest, p.hessian + q.hessian, gap)?;
        let mut part = 1.0;
        let better = (0..HALVINGS).find_map(|_| {
            let next = (n + step * part).normalize();
            part *= 0.5;
            let found = at(next);
            (found.0 >= gap).then_some((next, found))
        });
        // Rounding is all that is left.
        let Some((next, found)) = better else { break };
        n = next;
        (gap, p, q) = found;
    }
    let is_only = gap > -(of_a.smallest_radius + of_b.smallest_radius);
    let is_found = (between - p.point - q.point - n * gap).length() <= PRECISION.sqrt() * size;
    let midpoint = 0.5 * (a.center + p.point + b.center - q.point);
    (is_only && is_found).then_some(Separation { normal: n, gap, midpoint: Some(midpoint) })
}

/// The step across `n` by which the remainder of the gradient goes.
fn newton_step(n: DVec3, rest: DVec3, hessian: DMat3, gap: f64) -> Option<DVec3> {
    let (t, u) = n.any_orthonormal_pair();
    let (along_t, along_u) = (hessian * t, hessian * u);
    let of = |curvature: f64| {
        let off = u.dot(along_t);
        DMat2::from_cols(DVec2::new(t.dot(along_t) + curvature, off), DVec2::new(off, u.dot(along_u) + curvature))
    };
    // Without the gap's part it is positive definite, and the step goes up.
    let matrix = Some(of(gap)).filter(|m| m.determinant() > 0.0 && m.x_axis.x > 0.0).unwrap_or_else(|| of(0.0));
    let step = matrix.inverse() * DVec2::new(t.dot(rest), u.dot(rest));
    step.is_finite().then(|| t * step.x + u * step.y)
}

#[cfg(test)]
mod tests {
    use glamx::glam::DQuat;

    use super::*;
    use crate::convex::separation_along;

    fn placed(shape: &Convex, position: DVec3, turn: DVec3) -> Placed<'_> {
        let rotation = DMat3::from_quat(DQuat::from_scaled_axis(turn));
        Placed { shape, rotation, position, center: position, size: 1.0 }
    }

    /// Numbers in (−1, 1) that look random.
    fn noise(seed: usize) -> impl FnMut() -> f64 {
        let mut k = seed as f64;
        move || {
            k += 1.0;
            2.0 * (k * 0.754_877_666_246_693 + (k * 12.9898).sin() * 43_758.545_3).fract().abs() - 1.0
        }
    }

    /// No direction separates more, the points are on both surfaces, and what is between them is along the normal.
    #[test]
    fn no_direction_separates_more() {
        let (mut found, mut overlaps) = (0, 0);
        for seed in 0..300 {
            let mut x = noise(1000 * seed);
            let mut vector = |scale: f64| DVec3::new(x(), x(), x()) * scale;
            let [first, second] = [(); 2].map(|()| Convex::Ellipsoid { axes: (vector(1.0).abs() + 0.05) * 0.5 });
            let a = placed(&first, DVec3::ZERO, vector(3.0));
            let b = placed(&second, vector(0.7), vector(3.0));
            let Some(best) = separation(&a, &b) else { continue };
            found += 1;
            overlaps += usize::from(best.gap < 0.0);
            assert!((separation_along(&a, &b, best.normal) - best.gap).abs() < 1e-12, "{seed}");
            for _ in 0..400 {
                let other = vector(1.0).normalize();
                assert!(separation_along(&a, &b, other) <= best.gap + 1e-12, "{seed}: {best:?} {other}");
            }
            let middle = best.midpoint.unwrap();
            for (ellipsoid, axes, side) in [(&a, &first, 0.5), (&b, &second, -0.5)] {
                let Convex::Ellipsoid { axes } = axes else { unreachable!() };
                let local = ellipsoid.local(middle - best.normal * (side * best.gap) - ellipsoid.center);
                assert!(((local / *axes).length() - 1.0).abs() < 1e-8, "{seed}: {}", (local / *axes).length());
            }
        }
        assert!(found > 200 && overlaps > 20, "{found} {overlaps}");
    }
}
