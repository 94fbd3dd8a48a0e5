//! Two capsules in closed form.

use crate::convex::Placed;
use crate::feature::Feature;
use crate::manifold::Touch;

/// Axes that turn from each other by less than this sine also touch at the ends of their common part.
const ALONGSIDE: f64 = 0.05;

/// Appends the contacts of two capsules within `margin`: the closest points of the axes and, where the axes run along
/// each other, the ends of their common part, each with its own normal.
pub(crate) fn capsules(
    (a, radius_a, half_a): (&Placed, f64, f64),
    (b, radius_b, half_b): (&Placed, f64, f64),
    margin: f64,
    out: &mut Vec<Touch>,
) {
    let (u, v) = (a.rotation.z_axis, b.rotation.z_axis);
    let offset = b.position - a.position;
    let (cosine, cross) = (u.dot(v), u.cross(v));
    let sine = cross.length();
    let fallback = if sine > 1e-9 { cross / sine } else { u.any_orthonormal_vector() };
    let mut push = |s: f64, t: f64, feature: Feature| {
        let (on_a, on_b) = (a.position + u * s, b.position + v * t);
        let between = on_b - on_a;
        let distance = between.length();
        let normal = if distance > 1e-12 * (radius_a + radius_b) { between / distance } else { fallback };
        let gap = normal.dot(between) - radius_a - radius_b;
        if gap <= margin {
            let position = 0.5 * (on_a + normal * radius_a + on_b - normal * radius_b);
            out.push(Touch { position, normal, gap, feature });
        }
    };
    // Nearest place on one axis to a place on the other.
    let on_b = |s: f64| (u * s - offset).dot(v).clamp(-half_b, half_b);
    let on_a = |t: f64| (offset + v * t).dot(u).clamp(-half_a, half_a);
    if sine < ALONGSIDE {
        // Where both end at one place rounding does not decide that neither does.
        let rounding = 1e-12 * (radius_a + half_a + radius_b + half_b);
        for (k, end) in [-half_a, half_a].into_iter().enumerate() {
            let t = (u * end - offset).dot(v);
            if t.abs() <= half_b + rounding {
                push(end, t, Feature::VertexA(k as u32));
            }
        }
        for (k, end) in [-half_b, half_b].into_iter().enumerate() {
            let s = (offset + v * end).dot(u);
            if s.abs() < half_a - rounding {
                push(s, end, Feature::VertexB(k as u32));
            }
        }
    }
    let (s, t) = if sine > 1e-6 {
        let (along_a, along_b) = (offset.dot(u), offset.dot(v));
        let s = ((along_a - along_b * cosine) / (sine * sine)).clamp(-half_a, half_a);
        let t = on_b(s);
        let s = on_a(t);
        (s, on_b(s))
    } else {
        // What they have in common has its ends already.
        let s = on_a(0.0);
        (s, on_b(s))
    };
    push(s, t, Feature::Closest);
}

/// Where the closest points coincide with an end that is already there, or lie between two parallel ends, they add nothing.
pub(crate) fn drop_redundant(touches: &mut Vec<Touch>, from: usize, tolerance: f64) {
    let Some(closest) = touches.last().copied().filter(|_| touches.len() > from + 1) else { return };
    let ends = &touches[from..touches.len() - 1];
    let at_an_end = ends.iter().any(|e| (e.position - closest.position).length() <= tolerance);
    let between = ends.len() >= 2 && ends.iter().any(|e| e.gap <= closest.gap + tolerance);
    let same_normal = ends.iter().all(|e: &Touch| e.normal.dot(closest.normal) > 1.0 - 1e-9);
    if at_an_end || (between && same_normal) {
        touches.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convex::Convex;
    use glamx::glam::{DMat3, DVec3};

    #[test]
    fn parallel_capsules_touch_at_the_two_ends_of_their_common_part() {
        let shape = Convex::Capsule { radius: 0.1, half_length: 0.5 };
        let at = |p: DVec3| Placed { shape: &shape, rotation: DMat3::IDENTITY, position: p, center: p, size: 0.6 };
        let (a, b) = (at(DVec3::ZERO), at(DVec3::new(0.2, 0.0, 0.3)));
        let mut out = Vec::new();
        capsules((&a, 0.1, 0.5), (&b, 0.1, 0.5), 1e-3, &mut out);
        drop_redundant(&mut out, 0, 1e-9);
        let mut heights: Vec<f64> = out.iter().map(|t| t.position.z).collect();
        heights.sort_by(f64::total_cmp);
        // A spans z in [-0.5, 0.5], B spans [-0.2, 0.8]: the common part is [-0.2, 0.5].
        assert_eq!(heights.len(), 2, "{out:?}");
        assert!((heights[0] + 0.2).abs() < 1e-12 && (heights[1] - 0.5).abs() < 1e-12);
    }
}
